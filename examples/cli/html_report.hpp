// A comparison as one HTML page that needs no other file and no network.
#pragma once

#include <string>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/metrics/compare.hpp>

#include "html_pictures.hpp"

namespace cli {

/// Shape   `files`: the original, then the clouds of `found`.
/// Gives   the same bytes for any number of threads; neither times nor folders.
[[nodiscard]] std::string html_report(const std::vector<compared_file>& files,
                                      const billow::comparison& found,
                                      const billow::compare_options& options,
                                      billow::parallel threads,
                                      const billow::progress_function& progress);

}  // namespace cli
