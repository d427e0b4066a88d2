// The bounding sphere that every tolerance refers to.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Centre and radius of a sphere, in scene units.
struct bounding_sphere {
    dvec3 centre{0};
    double radius = 0;
};

/// The sphere around the centre of the axis-aligned box that holds every point of the range, not
/// always the smallest one. No points give centre and radius 0.
///
/// Source: Luksch 2009, section 4.1.
template <std::ranges::forward_range Points>
[[nodiscard]] bounding_sphere bounding_sphere_of(const Points& points) {
    if (std::ranges::empty(points)) return {};
    dvec3 low{std::numeric_limits<double>::infinity()};
    dvec3 high = -low;
    for (const auto& point : points) {
        low = glm::min(low, dvec3(point));
        high = glm::max(high, dvec3(point));
    }
    const dvec3 centre = low + (high - low) * 0.5;
    double radius_sq = 0;
    for (const auto& point : points) {
        const dvec3 offset = dvec3(point) - centre;
        radius_sq = std::max(radius_sq, glm::dot(offset, offset));
    }
    return {centre, std::sqrt(radius_sq)};
}

}  // namespace billow::inline BILLOW_ABI
