// The bounding sphere that every tolerance refers to.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Centre and radius of a sphere, in scene units.
struct bounding_sphere {
    dvec3 centre{0};
    double radius = 0;
};

/// The sphere around the centre of the axis-aligned box that holds the points point_at(0) …
/// point_at(count - 1); not always the smallest sphere. No points give centre and radius 0.
///
/// Source  Luksch 2009, section 4.1.
template <std::invocable<std::size_t> PointAt>
[[nodiscard]] bounding_sphere bounding_sphere_of(std::size_t count, const PointAt& point_at) {
    if (count == 0) return {};
    dvec3 low{std::numeric_limits<double>::infinity()};
    dvec3 high = -low;
    for (std::size_t i = 0; i < count; ++i) {
        const dvec3 point(point_at(i));
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
    const dvec3 centre = low + (high - low) * 0.5;
    double radius_sq = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const dvec3 offset = dvec3(point_at(i)) - centre;
        radius_sq = std::max(radius_sq, glm::dot(offset, offset));
    }
    return {centre, std::sqrt(radius_sq)};
}

}  // namespace billow::inline BILLOW_ABI
