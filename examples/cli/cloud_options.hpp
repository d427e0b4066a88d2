// The options that say how a cloud is made, for every verb that makes one.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "recipe.hpp"
#include "screen_options.hpp"

namespace cli {

/// Options of a verb. A preset gives a recipe, and what the user gives changes it, in the order of
/// the help.
class cloud_options {
public:
    explicit cloud_options(CLI::App& verb);

    /// Adds --distance and what belongs to it, for verbs whose cloud is for one distance.
    void add_distance_options();

    /// Throws CLI::ValidationError where a value makes no sense. Needs no mesh.
    void check() const;
    /// The recipe for a mesh. Looks at it where the preset or --split is auto.
    [[nodiscard]] model_recipe recipe_for(const billow::mesh& source) const;
    /// The recipe for a model that is not split.
    [[nodiscard]] recipe recipe_for_whole(const billow::mesh& source) const;

private:
    using change = std::function<void(recipe&)>;

    /// Adds an option; `apply(recipe&, value)` is called when it is given. `shown` is the default in
    /// the help.
    template <class T, class Apply>
    CLI::Option* add(const std::string& name, const std::string& shown, const std::string& help,
                     Apply apply) {
        return add_change<T>(changes_, name, shown, help, apply);
    }
    /// The same for the trunk alone.
    template <class T, class Apply>
    CLI::Option* add_for_trunk(const std::string& name, const std::string& shown,
                               const std::string& help, Apply apply) {
        return trunk_options_.emplace_back(add_change<T>(trunk_changes_, name, shown, help, apply));
    }
    template <class T, class Apply>
    CLI::Option* add_change(std::vector<change>& to, const std::string& name,
                            const std::string& shown, const std::string& help, Apply apply) {
        auto value = std::make_shared<T>();
        CLI::Option* option = verb_.add_option(name, *value, help)->default_str(shown);
        option->group(group_);
        to.emplace_back([option, value, apply](recipe& how) {
            if (option->count() > 0) apply(how, *value);
        });
        return option;
    }
    template <class Apply>
    void add_flag(const std::string& name, const std::string& help, Apply apply) {
        auto value = std::make_shared<bool>(false);
        verb_.add_flag(name, *value, help)->group(group_);
        changes_.emplace_back([value, apply](recipe& how) {
            if (*value) apply(how);
        });
    }

    void add_preset_options();
    void add_plane_options();
    void add_density_options();
    void add_seam_options();
    void add_trunk_options();
    void add_texture_options();
    void add_texture_looks();

    [[nodiscard]] model_recipe recipe_of_model(const billow::mesh& source) const;
    void choose_for_distance(const billow::mesh& source, model_recipe& how) const;
    [[nodiscard]] recipe recipe_for_whole(const billow::model_description& model) const;
    [[nodiscard]] bool wants_split(const billow::model_description& model) const;
    [[nodiscard]] billow::model_description look_at(const billow::mesh& source) const;
    void change_all(recipe& how, bool is_trunk) const;

    CLI::App& verb_;
    std::string group_{};
    std::vector<change> changes_{};
    std::vector<change> trunk_changes_{};
    std::vector<CLI::Option*> trunk_options_{};
    std::string preset_ = "auto";
    std::string split_ = "auto";
    std::vector<std::string> foliage_materials_{};
    std::string trunk_ = "billboards";
    std::string distance_{};
    screen_options screen_{};
    double texel_error_ = 1;
};

}  // namespace cli
