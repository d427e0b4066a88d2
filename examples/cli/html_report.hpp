// A comparison as one HTML page that needs no other file and no network.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/metrics/compare.hpp>

namespace cli {

/// A mesh and the name that it goes by.
struct compared_file {
    std::string name{};
    const billow::mesh* drawn = nullptr;
};

/// Bytes that a page should not exceed. Pictures get smaller until they fit.
inline constexpr std::size_t largest_page = 6'000'000;

/// `text` for the inside of elements and of quoted attributes, control characters as spaces.
[[nodiscard]] std::string html_escaped(std::string_view text);

/// Shape   `files`: the original, then the clouds of `found`.
/// Gives   the same bytes for any number of threads; neither times nor folders.
[[nodiscard]] std::string html_report(const std::vector<compared_file>& files,
                                      const billow::comparison& found,
                                      const billow::compare_options& options,
                                      billow::parallel threads,
                                      const billow::progress_function& progress);

}  // namespace cli
