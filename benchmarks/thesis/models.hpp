// The models of the published tables, or what is nearest to them here.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <billow/mesh/mesh.hpp>

namespace thesis {

/// Files where there are any, else generated meshes; each is read once.
class model_store {
public:
    /// `folder` holds solid/*.glb and trees/*.glb; empty: everything is generated.
    explicit model_store(std::filesystem::path folder) : folder_(std::move(folder)) {}

    struct model {
        std::string name{};  ///< for tables
        billow::mesh mesh{};
        bool is_tree = false;
    };

    /// The stand-in for a model of the papers, such as "teapot" or "aspen".
    [[nodiscard]] const model& of(const std::string& published);
    /// A tree of about so many faces.
    [[nodiscard]] const model& tree(std::size_t faces);
    /// Every file of the folder, or every generated model; by name, solids first.
    [[nodiscard]] std::vector<std::string> all() const;
    /// One of all(). It is not kept.
    [[nodiscard]] model load(const std::string& id) const;

private:
    std::filesystem::path folder_;
    std::map<std::string, model> known_{};
};

}  // namespace thesis
