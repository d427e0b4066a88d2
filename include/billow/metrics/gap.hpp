// Cracks and holes of a cloud: how much longer its borders are than its original's, and how much of
// the original they let through.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 3.4, Gap Intensity.
#pragma once

#include <cstddef>

#include <billow/metrics/channel.hpp>
#include <billow/metrics/coverage_error.hpp>
#include <billow/metrics/view_picture.hpp>

namespace billow::inline BILLOW_ABI {

struct gap_options {
    /// How far from the original's silhouette a hole begins, pixels, ≥ 0. What is missing nearer to
    /// it may be the silhouette itself, displaced; the cloud's epsilon in pixels leaves all of that
    /// out, and the ends of cracks with it.
    int depth_px = 2;
};

struct gap_errors {
    double intensity = 0;   ///< see gap_intensity
    double hole_share = 0;  ///< see hole_share
};

/// The number of border pixels: those covered by half or more with a pixel above, below, to the left
/// or to the right that is covered by less. Cost O(pixels).
[[nodiscard]] inline std::size_t border_pixels(const view_picture& picture) noexcept {
    const auto is_covered = [&](int x, int y) { return picture.at(x, y).a >= 0.5f; };
    std::size_t count = 0;
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            if (!is_covered(x, y)) continue;
            const bool is_border = (x > 0 && !is_covered(x - 1, y)) ||
                                   (x + 1 < picture.width && !is_covered(x + 1, y)) ||
                                   (y > 0 && !is_covered(x, y - 1)) ||
                                   (y + 1 < picture.height && !is_covered(x, y + 1));
            count += is_border ? 1u : 0u;
        }
    }
    return count;
}

/// (E_cloud - E_original) / E_original, E the number of border pixels. 0 for a cloud with borders as
/// long as the original's, 1 where cracks make them twice as long; below 0 where thin structures are
/// lost.
///
/// Needs   pictures of the same size.
/// Gives   1 where the cloud alone has borders.
/// Source  Luksch 2009, section 3.4, which names neither the filter nor what the difference is
///         related to: here the four neighbours, and the original's border.
[[nodiscard]] inline double gap_intensity(const view_picture& original,
                                          const view_picture& cloud) noexcept {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    const auto of_original = static_cast<double>(border_pixels(original));
    return share_of(static_cast<double>(border_pixels(cloud)) - of_original, of_original);
}

/// Σmax(e - b, 0) / Σa, a and b the coverage in the original and in the cloud's picture, e the least
/// a within depth_px along rows and columns: the share of the original that is missing inside of it.
/// Tells how large the holes are, which the gap intensity does not. Crowns that let light through
/// have little inside, and read low.
///
/// Needs  pictures of the same size.          Cost  O(pixels · depth_px).
[[nodiscard]] inline double hole_share(const view_picture& original, const view_picture& cloud,
                                       const gap_options& options = {}) {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    if (original.pixels.empty()) return 0;
    channel coverage(original.width, original.height);
    double all = 0;
    for (int y = 0; y < original.height; ++y) {
        for (int x = 0; x < original.width; ++x) {
            coverage.row(y)[x] = original.at(x, y).a;
            all += original.at(x, y).a;
        }
    }
    const channel inside = eroded(coverage, options.depth_px);
    double holes = 0;
    for (int y = 0; y < original.height; ++y) {
        for (int x = 0; x < original.width; ++x) {
            holes += std::max(0.0f, inside.at(x, y) - cloud.at(x, y).a);
        }
    }
    return share_of(holes, all);
}

[[nodiscard]] inline gap_errors gap_error(const view_picture& original, const view_picture& cloud,
                                          const gap_options& options = {}) {
    return {gap_intensity(original, cloud), hole_share(original, cloud, options)};
}

}  // namespace billow::inline BILLOW_ABI
