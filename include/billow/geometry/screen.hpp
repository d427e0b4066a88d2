// How many pixels a length covers on a screen.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include <billow/core/config.hpp>

namespace billow::inline BILLOW_ABI {

/// A perspective camera, as far as levels of detail care.
struct lod_screen {
    double fov_y = std::numbers::pi / 3;  ///< vertical field of view, radians, in (0, pi)
    int width_px = 1920;
    int height_px = 1080;
    double near = 0.01;  ///< least distance to an object's surface that counts, scene units, > 0

    /// Pixels that a length of 1 covers at a distance of 1: cot(fov_y / 2) / 2 · height.
    [[nodiscard]] double pixels_at_one() const noexcept {
        return height_px / (2 * std::tan(fov_y / 2));
    }
};

/// Largest size on the screen of a displacement by `error` somewhere in a sphere of `radius` whose
/// centre is at `distance`: error / max(distance - radius, near) · cot(fov_y / 2) / 2 · height.
///
/// Unit   lengths in scene units; gives pixels.
[[nodiscard]] inline double pixels_of_error(double error, double radius, double distance,
                                            const lod_screen& screen) noexcept {
    return error / std::max(distance - radius, screen.near) * screen.pixels_at_one();
}

/// The largest displacement that covers at most `pixels` at a distance: the inverse of
/// pixels_of_error.
[[nodiscard]] inline double error_for_pixels(double pixels, double radius, double distance,
                                             const lod_screen& screen) noexcept {
    return pixels * std::max(distance - radius, screen.near) / screen.pixels_at_one();
}

/// The least distance to the centre from which `error` covers at most `pixels`: the inverse of
/// pixels_of_error. 0 where it never covers more.
///
/// Needs  pixels > 0.
[[nodiscard]] inline double distance_for_pixels(double error, double radius, double pixels,
                                                const lod_screen& screen) noexcept {
    const double to_surface = error * screen.pixels_at_one() / pixels;
    return to_surface > screen.near ? radius + to_surface : 0;
}

}  // namespace billow::inline BILLOW_ABI
