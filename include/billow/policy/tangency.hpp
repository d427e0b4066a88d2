// How much faces that lie askew to a plane lose besides the projection: tangency.
#pragma once

#include <utility>

#include <billow/policy/contribution.hpp>

namespace billow::inline BILLOW_ABI {

/// Another contribution, times |cos|^tangency of the angle between face and plane.
///
/// Few planes alone are a poor aim: parallel slabs of one direction hold a crown within epsilon, and
/// show most of its leaves edge-on. With a tangency above 0 a plane is found for the faces that it
/// shows frontally; it still takes all that are valid for it. 0 is the base alone; 1 to 3 are useful.
/// Between two whole numbers it is the mix of their powers.
template <class Contribution = projected_area>
struct tangent_share {
    Contribution base{};
    float least_cosine = least_cosine_of(base);
    float tangency = 0;  ///< ≥ 0, at most 16

    explicit tangent_share(Contribution contribution = {}, double exponent = 0) noexcept
        : base(std::move(contribution)), tangency(static_cast<float>(exponent)) {}

    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        const V one = simd::lanes<V>::fill(1);
        const V cosine = simd::min(simd::abs(dot(face.normal, normal)), one);
        V worth = base(face, normal);
        float left = simd::min(tangency, 16.0f);
        for (; left >= 1; left -= 1) worth = worth * cosine;
        if (left > 0) worth = worth * (one - simd::lanes<V>::fill(left) * (one - cosine));
        return worth;
    }
};
static_assert(contribution<tangent_share<>> && contribution<tangent_share<>, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
