// Planes in Hesse normal form.
#pragma once

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// The points x with normal·x = rho. `normal` has length 1.
///
/// (n, rho) and (-n, -rho) are the same plane; the canonical one has rho ≥ 0, so that its normal
/// points away from the origin. Differs from Luksch 2009, eq 3.1, whose sign of rho would turn the
/// penalty to the outer side.
struct plane {
    dvec3 normal{0, 0, 1};
    double rho = 0;  ///< signed distance of the plane to the origin, along the normal

    friend bool operator==(const plane&, const plane&) = default;
};

/// Distance of `point` to `p`, positive on the side the normal points to.
[[nodiscard]] inline double signed_distance(const plane& p, const dvec3& point) noexcept {
    return glm::dot(p.normal, point) - p.rho;
}

/// The same plane with rho ≥ 0.
[[nodiscard]] inline plane canonical(const plane& p) noexcept {
    return p.rho < 0 ? plane{-p.normal, -p.rho} : p;
}

}  // namespace billow::inline BILLOW_ABI
