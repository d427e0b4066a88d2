// What drawing a face on a plane is worth: contribution.
#pragma once

#include <concepts>

#include <billow/core/simd.hpp>
#include <billow/mesh/face_table.hpp>

namespace billow::inline BILLOW_ABI {

/// Worth of drawing a face on a plane with the given normal, in scene units squared. Pure, at most
/// the area of the face, and the same for n and -n: faces are seen from both sides, and the density
/// grid keeps one row for both.
template <class P, class V = float>
concept contribution = std::copyable<P> &&
    requires(const P& worth, const face_lanes<V>& face, const vec3_lanes<V>& normal) {
    { worth(face, normal) }
    noexcept->std::same_as<V>;
};

/// Area of the face seen along the plane's normal. Source: Luksch 2009, eq 3.4. Differs by the
/// absolute value, without which faces that look the other way would count as negative.
struct projected_area {
    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        return face.area * simd::min(simd::abs(dot(face.normal, normal)), simd::lanes<V>::fill(1));
    }
};
static_assert(contribution<projected_area> && contribution<projected_area, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
