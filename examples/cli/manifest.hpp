// What verbs share that write several files and a manifest of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include <billow/core/expected.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/mesh/mesh.hpp>

namespace cli {

/// A file that is to be written.
struct output_file {
    std::filesystem::path name;
    std::vector<std::uint8_t> bytes;
};

/// Writes all files or none: beside their places first, renamed when all are complete.
billow::expected<billow::done> write_together(const std::vector<output_file>& files);

[[nodiscard]] nlohmann::ordered_json sphere_json(const billow::bounding_sphere& sphere);

/// Of all images of a mesh, as a card without compression holds them, no mip levels counted.
[[nodiscard]] std::size_t texture_bytes(const billow::mesh& cloud);

}  // namespace cli
