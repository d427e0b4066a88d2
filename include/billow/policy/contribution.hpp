// What drawing a face on a plane is worth: contribution.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <utility>

#include <billow/core/simd.hpp>
#include <billow/mesh/face_table.hpp>

namespace billow::inline BILLOW_ABI {

/// Worth of drawing a face on a plane with the given normal, in scene units squared. Pure, at most
/// the area of the face, and the same for n and -n: faces are seen from both sides, and the density
/// grid keeps one row for both. A policy may have a member `least_cosine`, see least_cosine_of.
template <class P, class V = float>
concept contribution = std::copyable<P> &&
    requires(const P& worth, const face_lanes<V>& face, const vec3_lanes<V>& normal) {
    { worth(face, normal) }
    noexcept->std::same_as<V>;
};

/// The least |cosine| between the normals of a face and of a plane that may take it; 0, which allows
/// all, for a policy that does not say.
template <class Contribution>
[[nodiscard]] constexpr float least_cosine_of(const Contribution& worth) noexcept {
    if constexpr (requires { worth.least_cosine; }) {
        return worth.least_cosine;
    } else {
        return 0;
    }
}

/// Area of the face seen along the plane's normal. Source: Luksch 2009, eq 3.4. Differs by the
/// absolute value, without which faces that look the other way would count as negative.
struct projected_area {
    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        return face.area * simd::min(simd::abs(dot(face.normal, normal)), simd::lanes<V>::fill(1));
    }
};

/// Area of the face, falling in proportion to the angle between face and plane: 100, 88.9, 66.7 at
/// 0, 10 and 30 degrees, where the projected area is 100, 98.5, 86.6 and hardly tells them apart.
///
/// Source  Fuhrmann et al. 2005, section 3.3.1. The angle is that of the chord between the normals:
///         it keeps its digits near 0, where the arc cosine of a float is off by 0.02°. Within 2e-6
///         of the area, by a polynomial of our own instead of a library's, so that all lanes give
///         the same bits.
struct angular_area {
    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        const auto squared_length = [](V x, V y, V z) { return x * x + y * y + z * z; };
        const vec3_lanes<V>& f = face.normal;
        const V ahead = squared_length(f.x - normal.x, f.y - normal.y, f.z - normal.z);
        const V behind = squared_length(f.x + normal.x, f.y + normal.y, f.z + normal.z);
        const V q = simd::min(ahead, behind);
        // angle / 90° = 4 / pi · asin(sqrt(q) / 2) = sqrt(q) · sum, equal to it in six Chebyshev
        // nodes of q in [0, 2].
        const auto fill = [](float value) { return simd::lanes<V>::fill(value); };
        const V low = (fill(2.9080769e-3f) * q + fill(2.653927e-2f)) * q + fill(0.63661939f);
        const V high = (fill(5.8815534e-5f) * q - fill(5.4860026e-5f)) * q + fill(5.9644331e-4f);
        const V sum = low + high * (q * q * q);
        return face.area * simd::max(fill(1) - simd::sqrt(q) * sum, fill(0));
    }
};

/// Another contribution, but none to planes whose normal deviates more from the face's than an angle.
/// A search takes no face on such a plane.
///
/// Source  Luksch 2009, section 4.3, "normal threshold". A density measures a face at the centres of
///         the orientation cells, so the angle should exceed their half diagonal, 4° at raster 18.
template <class Contribution = projected_area>
struct within_angle {
    Contribution base;
    float least_cosine;  ///< of the angle; 0: all planes

    /// `max_angle_deg` in [0, 90], where 90 allows all planes; below 0.1 floats end, it works as 0.1.
    within_angle(Contribution contribution, double max_angle_deg) noexcept
        : base(std::move(contribution)), least_cosine(least_cosine_of(base)) {
        constexpr double radian = 0.017453292519943295;
        if (max_angle_deg >= 90) return;
        const double cosine = std::cos(std::max(max_angle_deg, 0.1) * radian);
        least_cosine = std::max(least_cosine, static_cast<float>(cosine));
    }

    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        const V cosine = simd::abs(dot(face.normal, normal));
        return simd::select(cosine >= simd::lanes<V>::fill(least_cosine), base(face, normal),
                            simd::lanes<V>::fill(0));
    }
};

static_assert(contribution<projected_area> && contribution<projected_area, simd::wide>);
static_assert(contribution<angular_area> && contribution<angular_area, simd::wide>);
static_assert(contribution<within_angle<>> && contribution<within_angle<>, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
