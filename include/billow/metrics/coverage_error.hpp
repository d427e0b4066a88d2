// How much of its original a cloud covers, and what else.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 3.4, Coverage Error.
#pragma once

#include <algorithm>
#include <cmath>

#include <billow/metrics/view_picture.hpp>

namespace billow::inline BILLOW_ABI {

/// Shares, 0 where the pictures cover the same.
///
/// With a and b the coverage of a pixel in the original and in the cloud's picture:
struct coverage_errors {
    double error = 0;           ///< Σ|a - b| / Σa: the thesis's coverage error
    double missing = 0;         ///< Σmax(a - b, 0) / Σa
    double extra = 0;           ///< Σmax(b - a, 0) / Σa; error = missing + extra
    double extra_of_cloud = 0;  ///< Σmax(b - a, 0) / Σb, as the thesis relates it
};

/// `part` of `whole`. Of nothing there is either nothing (0) or too much, which counts as 1.
[[nodiscard]] inline double share_of(double part, double whole) noexcept {
    if (whole > 0) return part / whole;
    return part > 0 ? 1 : 0;
}

/// Compares the coverage of two pictures.
///
/// Needs   pictures of the same size.
/// Gives   an original that covers nothing makes 1 of what the cloud adds.
/// Cost    O(pixels).
/// Source  Luksch 2009, section 3.4. Differs: coverage is not a mask but antialiased, so that what is
///         thinner than a pixel counts by its area. Two halves of one pixel are then the same, which
///         a mask of as many samples would tell apart.
[[nodiscard]] inline coverage_errors coverage_error(const view_picture& original,
                                                    const view_picture& cloud) noexcept {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    double of_original = 0;
    double of_cloud = 0;
    double missing = 0;
    double extra = 0;
    for (std::size_t i = 0; i < original.pixels.size(); ++i) {
        const double a = original.pixels[i].a;
        const double b = cloud.pixels[i].a;
        of_original += a;
        of_cloud += b;
        missing += std::max(a - b, 0.0);
        extra += std::max(b - a, 0.0);
    }
    return {share_of(missing + extra, of_original), share_of(missing, of_original),
            share_of(extra, of_original), share_of(extra, of_cloud)};
}

}  // namespace billow::inline BILLOW_ABI
