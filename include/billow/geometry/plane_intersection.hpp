// The point that several planes have in common, nearest to a given one.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <span>

#include <billow/core/types.hpp>
#include <billow/geometry/plane.hpp>

namespace billow::inline BILLOW_ABI {

/// The point nearest to `point` that lies on all of `planes`; nothing where their normals are
/// dependent, within a sine of 1e-3.
///
/// Needs   at most three planes with unit normals.
/// Source  Luksch 2009, section 3.3, asks for this point. Each step goes to the next plane along the
///         part of its normal that is orthogonal to the normals before, so that no plane is left.
[[nodiscard]] inline std::optional<dvec3> nearest_common_point(std::span<const plane> planes,
                                                               const dvec3& point) noexcept {
    BILLOW_ASSERT(planes.size() <= 3);
    constexpr double least_sine = 1e-3;
    std::array<dvec3, 3> steps;
    dvec3 at = point;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        dvec3 step = planes[i].normal;
        for (std::size_t k = 0; k < i; ++k) step -= steps[k] * glm::dot(steps[k], step);
        const double sine = glm::length(step);
        if (!(sine > least_sine)) return std::nullopt;
        steps[i] = step / sine;
        at -= steps[i] * (signed_distance(planes[i], at) / sine);
    }
    return at;
}

}  // namespace billow::inline BILLOW_ABI
