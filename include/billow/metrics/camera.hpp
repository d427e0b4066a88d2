// Where a picture is taken from.
#pragma once

#include <algorithm>
#include <cmath>

#include <billow/core/types.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/geometry/frame.hpp>

namespace billow::inline BILLOW_ABI {

/// A camera with square pixels.
struct camera {
    frame axes{};          ///< u to the right, v up in the picture, the normal to the viewer
    dvec3 eye{0, 0, 4};    ///< of an orthographic camera: any point seen in the picture's middle
    double height = 0.55;  ///< of the picture in scene units; of a perspective one at distance 1
    double near_distance = 1e-3;  ///< perspective: what is nearer along -axes.normal is not seen
    bool is_orthographic = false;
    int width_px = 512;
    int height_px = 512;
};

namespace detail {

/// Axes of a view from the direction `from` (any length), +Y up, or ∓Z where that is the view.
[[nodiscard]] inline frame upright_frame(const dvec3& from) noexcept {
    const dvec3 normal = glm::normalize(from);
    const bool is_vertical = std::abs(normal.y) > 0.999;
    const dvec3 up = is_vertical ? dvec3(0, 0, normal.y > 0 ? -1 : 1) : dvec3(0, 1, 0);
    const dvec3 u = glm::normalize(glm::cross(up, normal));
    return {u, glm::cross(normal, u), normal};
}

/// So much larger than a sphere is the view that frames it.
inline constexpr double framing_margin = 1.02;

}  // namespace detail

/// A perspective camera at `eye` that looks at another point.
///
/// Unit   `fov_rad`: the angle from the lower to the upper edge.
/// Needs  eye ≠ look_at, 0 < fov_rad < π, near_distance > 0.
[[nodiscard]] inline camera perspective_camera(const dvec3& eye, const dvec3& look_at,
                                               double fov_rad, int width_px = 512,
                                               int height_px = 512, double near_distance = 1e-3) {
    BILLOW_ASSERT(near_distance > 0 && fov_rad > 0 && fov_rad < 3.1415);
    const double height = 2 * std::tan(0.5 * fov_rad);
    return {detail::upright_frame(eye - look_at),
            eye,
            height,
            near_distance,
            false,
            width_px,
            height_px};
}

/// A perspective camera that sees a whole sphere from outside: at `distance` radii R from the centre
/// its outline has the half angle asin(1 / distance), and the square picture is 2 % larger:
/// height = 2 · 1.02 / √(distance² - 1).
///
/// Needs  distance > 1.
[[nodiscard]] inline camera orbit_camera(const bounding_sphere& sphere, const dvec3& direction,
                                         double distance = 4, int size_px = 512) {
    BILLOW_ASSERT(distance > 1);
    const double radius = sphere.radius > 0 ? sphere.radius : 1.0;
    const frame axes = detail::upright_frame(direction);
    const double height = 2 * detail::framing_margin / std::sqrt(distance * distance - 1);
    return {axes,   sphere.centre + axes.normal * (distance * radius),
            height, 0.01 * (distance - 1) * radius,
            false,  size_px,
            size_px};
}

/// An orthographic camera that sees a whole sphere from the direction `from` (any length).
[[nodiscard]] inline camera view_of(const bounding_sphere& sphere, const dvec3& from,
                                    int width_px = 512, int height_px = 512) {
    const double radius = sphere.radius > 0 ? sphere.radius : 1.0;
    const double shorter = std::min(1.0, static_cast<double>(width_px) / height_px);
    const double height = 2 * detail::framing_margin * radius / shorter;
    return {detail::upright_frame(from), sphere.centre, height, 0, true, width_px, height_px};
}

}  // namespace billow::inline BILLOW_ABI
