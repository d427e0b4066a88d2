// Right-handed orthonormal frames on a plane.
#pragma once

#include <cmath>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Three orthonormal axes with u × v = normal: seen from the tip of the normal, v is u turned by
/// 90° counter-clockwise.
struct frame {
    dvec3 u{1, 0, 0};
    dvec3 v{0, 1, 0};
    dvec3 normal{0, 0, 1};

    /// (u, v, height along the normal) of a scene vector.
    [[nodiscard]] dvec3 to_local(const dvec3& vector) const noexcept {
        return {glm::dot(u, vector), glm::dot(v, vector), glm::dot(normal, vector)};
    }
    /// The scene vector of (u, v, height along the normal).
    [[nodiscard]] dvec3 to_scene(const dvec3& local) const noexcept {
        return u * local.x + v * local.y + normal * local.z;
    }
};

/// Some frame around the unit vector `normal`; a continuous choice but for normal.z = 0.
///
/// Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
[[nodiscard]] inline frame frame_around(const dvec3& normal) noexcept {
    const double sign = std::copysign(1.0, normal.z);
    const double a = -1 / (sign + normal.z);
    const double b = normal.x * normal.y * a;
    return {.u = {1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x},
            .v = {b, sign + normal.y * normal.y * a, -normal.y},
            .normal = normal};
}

}  // namespace billow::inline BILLOW_ABI
