// Reading textures as glTF means it: wrap modes, bilinear filter, linear light.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/image/image.hpp>
#include <billow/image/mip_chain.hpp>
#include <billow/mesh/material.hpp>

namespace billow::inline BILLOW_ABI {

/// `uv` after KHR_texture_transform.
[[nodiscard]] inline vec2 transformed(const texture& t, const vec2& uv) noexcept {
    return vec2(t.transform[0]) * uv.x + vec2(t.transform[1]) * uv.y + vec2(t.transform[2]);
}

namespace detail {

/// A coordinate within [0, 1]: where the wrap mode folds it to. NaN becomes 0.
[[nodiscard]] inline float wrapped(float u, texture_wrap wrap) noexcept {
    if (u >= 0 && u <= 1) return u;
    if (wrap == texture_wrap::repeat) {
        u -= std::floor(u);
    } else if (wrap == texture_wrap::mirrored_repeat) {
        u -= 2 * std::floor(u * 0.5f);
        u = u > 1 ? 2 - u : u;
    }
    return u > 0 ? (u < 1 ? u : 1.0f) : 0.0f;
}

/// The two texels that a coordinate lies between.
struct texel_pair {
    int a = 0;
    int b = 0;
    float share_of_b = 0;
};

[[nodiscard]] inline texel_pair texels_at(float u, int size, texture_wrap wrap,
                                          bool is_nearest) noexcept {
    const float x = wrapped(u, wrap) * static_cast<float>(size);
    if (is_nearest) {
        const int texel = std::min(static_cast<int>(x), size - 1);
        return {texel, texel, 0};
    }
    const int above = static_cast<int>(x + 0.5f);  // the texel after the one before x - 0.5
    const float share = x + 0.5f - static_cast<float>(above);
    const bool repeats = wrap == texture_wrap::repeat;
    return {above > 0 ? above - 1 : (repeats ? size - 1 : 0),
            above < size ? above : (repeats ? 0 : size - 1), share};
}

/// The four texels around a point and their shares.
struct texel_quad {
    std::array<const std::uint8_t*, 4> texel;
    std::array<float, 4> share;
};

[[nodiscard]] inline texel_quad texels_around(const image& level, const texture& t, const vec2& uv,
                                              bool is_nearest) noexcept {
    const texel_pair x = texels_at(uv.x, level.width, t.wrap_u, is_nearest);
    const texel_pair y = texels_at(uv.y, level.height, t.wrap_v, is_nearest);
    const float fx = x.share_of_b;
    const float fy = y.share_of_b;
    return {{level.pixel(x.a, y.a), level.pixel(x.b, y.a), level.pixel(x.a, y.b),
             level.pixel(x.b, y.b)},
            {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}

}  // namespace detail

/// The level of a chain whose texels are closest in size to a footprint of `texels` texels of
/// level 0, counted by area.
[[nodiscard]] inline std::size_t level_of_footprint(double texels, std::size_t levels) noexcept {
    if (!(texels > 2)) return 0;  // a level has a fourth of the texels; half way is √4
    int exponent = 0;
    std::frexp(texels * 0.5, &exponent);  // texels in [2 · 4^(k-1), 2 · 4^k) is level k
    return std::min(static_cast<std::size_t>((exponent + 1) / 2), levels - 1);
}

/// Linear RGBA of one texel chain at `uv`, which the texture's transform has been applied to.
///
/// Needs  the chain that make_mip_chain gives for `kind`.
[[nodiscard]] inline vec4 sample_texture(const std::vector<image>& chain, texel_kind kind,
                                         const texture& t, const vec2& uv,
                                         std::size_t level) noexcept {
    const auto& light = linear_of_srgb_byte();
    const detail::texel_quad quad =
        detail::texels_around(chain[level], t, uv, t.is_nearest && level == 0);
    vec4 sum{0};
    vec3 weighted{0};
    for (std::size_t i = 0; i < 4; ++i) {
        const std::uint8_t* p = quad.texel[i];
        const float alpha = static_cast<float>(p[3]) * (1.0f / 255.0f);
        const vec3 colour = kind == texel_kind::linear
                                ? vec3(p[0], p[1], p[2]) * (1.0f / 255.0f)
                                : vec3(light[p[0]], light[p[1]], light[p[2]]);
        sum += vec4(colour, alpha) * quad.share[i];
        weighted += colour * (alpha * quad.share[i]);
    }
    if (kind == texel_kind::srgb_alpha && sum.w > 0) return vec4(weighted / sum.w, sum.w);
    return sum;
}

/// Alpha alone, in [0, 1], of an image with one channel.
[[nodiscard]] inline float sample_alpha(const image& level, const texture& t, const vec2& uv,
                                        bool is_nearest) noexcept {
    if (is_nearest) {
        const int x = detail::texels_at(uv.x, level.width, t.wrap_u, true).a;
        const int y = detail::texels_at(uv.y, level.height, t.wrap_v, true).a;
        return static_cast<float>(*level.pixel(x, y)) * (1.0f / 255.0f);
    }
    const detail::texel_quad quad = detail::texels_around(level, t, uv, false);
    float sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += static_cast<float>(*quad.texel[i]) * quad.share[i];
    return sum * (1.0f / 255.0f);
}

}  // namespace billow::inline BILLOW_ABI
