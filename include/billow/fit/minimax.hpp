// Minimax plane: the plane of least largest distance (Chebyshev).
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009, section
// 3.3, names the aim; the search is ours.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <billow/fit/fit.hpp>
#include <billow/geometry/frame.hpp>

namespace billow::inline BILLOW_ABI {

/// Minimises the largest distance of a corner, half the width of the corners along the normal. The
/// width has one minimum near a plane that the faces lie on, so a pattern search finds it: eight
/// normals around the best one, closer and closer together. Never worse than the start plane moved
/// to the middle of its corners, so a plane within epsilon of its faces stays so.
///
/// Cost  about 100 passes over the corners.
struct minimax_fit {
    static constexpr bool allows_less_contribution = true;

    double first_step = 6 * std::numbers::pi / 180;    ///< radians
    double last_step = 0.05 * std::numbers::pi / 180;  ///< radians; the normal is as exact as this

    [[nodiscard]] plane operator()(const face_table& faces, const plane& start) const {
        if (faces.size == 0) return start;
        extent best = extent_along(faces, start.normal);
        dvec3 normal = start.normal;
        for (double step = first_step; step >= last_step;) {
            const frame axes = frame_around(normal);
            dvec3 narrower = normal;
            for (int k = 0; k < 8; ++k) {
                const double angle = k * std::numbers::pi / 4;
                const dvec3 aside = axes.u * std::cos(angle) + axes.v * std::sin(angle);
                const dvec3 candidate = glm::normalize(normal + aside * std::tan(step));
                const extent along = extent_along(faces, candidate);
                if (along.width() < best.width()) best = along, narrower = candidate;
            }
            if (narrower == normal) {
                step /= 2;
            } else {
                normal = narrower;
            }
        }
        return {normal, (best.low + best.high) / 2};
    }

private:
    struct extent {
        double low = std::numeric_limits<double>::infinity();
        double high = -std::numeric_limits<double>::infinity();
        [[nodiscard]] double width() const noexcept { return high - low; }
    };
    [[nodiscard]] static extent extent_along(const face_table& faces, const dvec3& normal) {
        extent along;
        for_each_corner(faces, [&](const dvec3& corner) {
            const double offset = glm::dot(normal, corner);
            along.low = std::min(along.low, offset);
            along.high = std::max(along.high, offset);
        });
        return along;
    }
};
static_assert(plane_fitter<minimax_fit>);

}  // namespace billow::inline BILLOW_ABI
