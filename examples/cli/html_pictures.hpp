// The pictures of a page, as data that its HTML holds.
#pragma once

#include <cstddef>
#include <string>
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

/// ΔE*76 that is hottest in pictures of colour differences.
inline constexpr double hottest_color = 20;

/// Addresses of a view's pictures.
struct cloud_pictures {
    std::string seen{};
    std::string coverage{};
    std::string color{};
};
struct view_pictures {
    std::size_t view = 0;
    std::string original{};
    std::vector<cloud_pictures> clouds{};

    [[nodiscard]] std::size_t size() const {
        std::size_t sum = original.size();
        for (const auto& c : clouds) sum += c.seen.size() + c.coverage.size() + c.color.size();
        return sum;
    }
};

/// An original and a cloud by the colours of planes.
struct plane_pictures {
    std::size_t cloud = 0;
    std::string original{};
    std::string seen{};
};

/// An atlas picture and what is drawn over it.
struct atlas_picture {
    std::size_t cloud = 0;
    int width = 0;
    int height = 0;
    std::string uri{};
    std::string planes{};
};

struct page_pictures {
    std::vector<view_pictures> views{};
    std::vector<plane_pictures> planes{};  ///< of the clouds that know their planes
    std::vector<atlas_picture> atlases{};
};

/// Shape   `files`: the original, then the clouds of `found`.
/// Gives   the same bytes for any number of threads.
[[nodiscard]] page_pictures draw_pictures(const std::vector<compared_file>& files,
                                          const billow::comparison& found,
                                          const billow::compare_options& options,
                                          billow::parallel threads,
                                          const billow::progress_function& progress);

}  // namespace cli
