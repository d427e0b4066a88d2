// What the tool tells of a cloud that it has made: JSON for programs, lines for people.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include <billow/io/loaded_mesh.hpp>

#include "recipe.hpp"

namespace cli {

/// Wall times of the tool, seconds.
struct tool_times {
    double load = 0;
    double write = 0;
    double total = 0;
};

/// A build from end to end.
struct finished_build {
    const std::filesystem::path& input;
    const std::filesystem::path& output;
    const model_recipe& how;
    const billow::loaded_mesh& loaded;
    const billow::build_result& result;
    std::size_t triangles = 0;  ///< of what was written
    tool_times seconds{};
};

[[nodiscard]] std::string report_json(const finished_build& of);
void print_summary(const finished_build& of);

}  // namespace cli
