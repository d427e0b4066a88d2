// The sky that a point sees, compressed to a cone: which directions light comes from.
//
// Fuhrmann et al. 2005, section 3.3.9, bake a "compressed horizon" that they do not define. Here it is
// a bent normal and a cone, as in Klehm et al.: Bent normals and cones in screen-space. VMV 2011.
#pragma once

#include <array>
#include <cstdint>

#include <billow/core/types.hpp>
#include <billow/image/srgb.hpp>

namespace billow::inline BILLOW_ABI {

/// The directions l with dot(l, axis) > cosine.
struct horizon_cone {
    vec3 axis{0};       ///< unit length; 0 where no direction is better than another
    float cosine = -1;  ///< of the angle between axis and edge: -1 the whole sky, 1 none

    /// Whether light from the direction `l`, unit length, arrives.
    [[nodiscard]] bool is_lit(const vec3& l) const noexcept { return glm::dot(l, axis) > cosine; }
};

/// The cone around the mean visible direction that is as large as what is visible, so that over all
/// directions as much light arrives. `visible` is sky_view::visible, or a mean of several.
///
/// Source  Klehm et al. 2011. Differs: they take the angle from the length of the mean direction,
///         which would open the cone for light that comes in from two opposite sides.
[[nodiscard]] inline horizon_cone cone_of(const vec4& visible) noexcept {
    const vec3 sum(visible);
    const float length = glm::length(sum);
    // A cone of angle θ is (1 - cos θ) / 2 of the sphere.
    return {length > 1e-4f ? sum / length : vec3(0), 1 - 2 * visible.w};
}

/// Four bytes: axis · 0.5 + 0.5 and cosine · 0.5 + 0.5.
[[nodiscard]] inline std::array<std::uint8_t, 4> encode_horizon(const horizon_cone& cone) noexcept {
    return {byte_from_unit(cone.axis.x * 0.5f + 0.5f), byte_from_unit(cone.axis.y * 0.5f + 0.5f),
            byte_from_unit(cone.axis.z * 0.5f + 0.5f), byte_from_unit(cone.cosine * 0.5f + 0.5f)};
}
/// The cone of a texel, as a shader reads it: axis to within 1°, cosine to within 0.004.
[[nodiscard]] inline horizon_cone decode_horizon(const std::uint8_t* texel) noexcept {
    const vec4 value = vec4(texel[0], texel[1], texel[2], texel[3]) * (2.0f / 255.0f) - 1.0f;
    const float length = glm::length(vec3(value));
    return {length > 0.5f ? vec3(value) / length : vec3(0), value.w};
}

}  // namespace billow::inline BILLOW_ABI
