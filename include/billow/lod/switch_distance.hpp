// From which distance a level of detail may be drawn, and how engines spell that distance.
//
// Differs from a table of fixed distances: an error in scene units becomes one in pixels, so one
// cloud serves every screen. The formula is that of meshoptimizer's clustered levels of detail.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include <billow/geometry/screen.hpp>

namespace billow::inline BILLOW_ABI {

/// The distance from which each level may be drawn, finest first. Never less than that of the level
/// above, so that levels follow each other.
[[nodiscard]] inline std::vector<double> switch_distances(std::span<const double> errors,
                                                          double radius, double pixels,
                                                          const lod_screen& screen) {
    std::vector<double> distances;
    double least = 0;
    for (const double error : errors) {
        least = std::max(least, distance_for_pixels(error, radius, pixels, screen));
        distances.push_back(least);
    }
    return distances;
}

/// Height of an object of `size` over that of the screen: 1 fills it. Unity's
/// screenRelativeTransitionHeight, where size is the longest side of the object's box, and Houdini's
/// lod_screensizes. Infinite at distance 0.
[[nodiscard]] inline double relative_screen_height(double size, double distance,
                                                   const lod_screen& screen) noexcept {
    if (!(distance > 0)) return std::numeric_limits<double>::infinity();
    return size / (2 * distance * std::tan(screen.fov_y / 2));
}

/// The distance at which an object of `size` has that share of the screen's height: the inverse of
/// relative_screen_height. Needs relative_height > 0.
[[nodiscard]] inline double distance_for_screen_height(double size, double relative_height,
                                                       const lod_screen& screen) noexcept {
    return size / (2 * relative_height * std::tan(screen.fov_y / 2));
}

/// Share of the screen's area that the disc of a sphere covers, at most 1: for MSFT_screencoverage,
/// whose text leaves open what is covered. Entry i there is the end of level i, so the coverage at
/// the switch distance of level i + 1.
[[nodiscard]] inline double screen_coverage(double radius, double distance,
                                            const lod_screen& screen) noexcept {
    const double height = relative_screen_height(2 * radius, distance, screen);
    const double aspect = static_cast<double>(screen.width_px) / screen.height_px;
    return std::min(1.0, std::numbers::pi / 4 * height * height / aspect);
}

}  // namespace billow::inline BILLOW_ABI
