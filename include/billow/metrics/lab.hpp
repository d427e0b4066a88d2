// CIE L*a*b* of linear light, and the difference of two colours.
//
// CIE 15:2004, Colorimetry. The matrix of sRGB's primaries under D65 is that of B. Lindbloom,
// brucelindbloom.com, whom the thesis of Luksch (2009, section 3.4) converts by.
#pragma once

#include <billow/core/simd.hpp>
#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Three coordinates of a colour, each a float or a pack of them.
template <class V>
struct color_lanes {
    V x{};
    V y{};
    V z{};
};

/// CIE XYZ over that of white (D65), so that white is (1, 1, 1), of linear sRGB light.
template <class V>
[[nodiscard]] color_lanes<V> relative_xyz(const color_lanes<V>& linear) noexcept {
    constexpr float white_x = 0.9504700f;
    constexpr float white_z = 1.0888300f;
    const auto [r, g, b] = linear;
    return {r * (0.4124564f / white_x) + g * (0.3575761f / white_x) + b * (0.1804375f / white_x),
            r * 0.2126729f + g * 0.7151522f + b * 0.0721750f,
            r * (0.0193339f / white_z) + g * (0.1191920f / white_z) + b * (0.9503041f / white_z)};
}

/// Linear sRGB light of relative XYZ: the inverse of relative_xyz.
template <class V>
[[nodiscard]] color_lanes<V> linear_of_relative_xyz(const color_lanes<V>& relative) noexcept {
    const V x = relative.x * 0.9504700f;
    const V y = relative.y;
    const V z = relative.z * 1.0888300f;
    return {x * 3.2404542f - y * 1.5371385f - z * 0.4985314f,
            y * 1.8760108f - x * 0.9692660f + z * 0.0415560f,
            x * 0.0556434f - y * 0.2040259f + z * 1.0572252f};
}

/// L* (0 to 100), a* and b* of relative XYZ.
template <class V>
[[nodiscard]] color_lanes<V> lab_of_relative_xyz(const color_lanes<V>& relative) noexcept {
    const auto f = [](V t) {
        constexpr float delta = 6.0f / 29.0f;
        constexpr float knee = delta * delta * delta;
        const V root = simd::cube_root(simd::max(t, simd::lanes<V>::fill(knee)));
        return simd::select(t > knee, root, t * (1 / (3 * delta * delta)) + 4.0f / 29.0f);
    };
    const V x = f(relative.x);
    const V y = f(relative.y);
    const V z = f(relative.z);
    return {y * 116.0f - 16.0f, (x - y) * 500.0f, (y - z) * 200.0f};
}

/// L* (0 to 100), a* and b* of linear sRGB light, white D65.
[[nodiscard]] inline vec3 lab_from_linear(const vec3& linear) noexcept {
    const auto lab =
        lab_of_relative_xyz(relative_xyz(color_lanes<float>{linear.x, linear.y, linear.z}));
    return {lab.x, lab.y, lab.z};
}

/// ΔE*76: the distance of two colours in L*a*b*. About 2.3 is just noticed; black and white are 100
/// apart.
[[nodiscard]] inline double delta_e76(const vec3& lab, const vec3& other) noexcept {
    return glm::distance(dvec3(lab), dvec3(other));
}

}  // namespace billow::inline BILLOW_ABI
