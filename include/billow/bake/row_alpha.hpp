// Along a row of samples, where the alpha of a face lets it be seen: several samples at once.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <billow/bake/surface.hpp>
#include <billow/bake/texture_sampler.hpp>
#include <billow/core/simd.hpp>
#include <billow/core/types.hpp>
#include <billow/image/raster.hpp>

namespace billow::inline BILLOW_ABI::detail {

/// A value along a row, in floats from its first sample on.
template <class V>
struct row_value {
    V first;
    V across;

    row_value(const affine_value& of, const dvec2& at) noexcept
        : first(simd::lanes<V>::fill(static_cast<float>(of.at(at.x, at.y)))),
          across(simd::lanes<V>::fill(static_cast<float>(of.dx))) {}
    [[nodiscard]] V at(V step) const noexcept { return first + across * step; }
};

/// wrapped() of several coordinates; where not `wanted`, any number within [0, 1].
template <class V>
[[nodiscard]] V wrapped_lanes(V u, texture_wrap wrap, simd::mask_lanes<V> wanted) noexcept {
    using lanes = simd::lanes<V>;
    const V zero = lanes::fill(0);
    const V one = lanes::fill(1);
    const simd::mask_lanes<V> is_inside = (u >= zero) & (u <= one);
    if (simd::any(simd::mask_lanes<V>(wanted & (is_inside == simd::mask_lanes<V>{})))) {
        std::array<float, lanes::count> values;
        lanes::store(values.data(), u);
        for (float& value : values) value = wrapped(value, wrap);
        return lanes::load(values.data());
    }
    return simd::min(simd::max(u, zero), one);
}

/// texels_at() of several coordinates that are wrapped already.
template <class V>
struct texel_pair_lanes {
    std::array<std::int32_t, simd::lanes<V>::count> a;
    std::array<std::int32_t, simd::lanes<V>::count> b;
    V share_of_b;

    texel_pair_lanes(V u, int size, texture_wrap wrap, bool is_nearest) noexcept
        : share_of_b(simd::lanes<V>::fill(0)) {
        using lanes = simd::lanes<V>;
        const V texels = lanes::fill(static_cast<float>(size));
        const V last = lanes::fill(static_cast<float>(size - 1));
        const V x = u * texels;
        if (is_nearest) {
            lanes::store(a.data(), simd::truncate(simd::min(x, last)));
            return;
        }
        const V zero = lanes::fill(0);
        const V one = lanes::fill(1);
        const V shifted = x + lanes::fill(0.5f);
        const V above = simd::to_float(simd::truncate(shifted));
        share_of_b = shifted - above;
        const bool repeats = wrap == texture_wrap::repeat;
        const V before = simd::select(above > zero, above - one, repeats ? last : zero);
        const V after = simd::select(above < texels, above, repeats ? zero : last);
        lanes::store(a.data(), simd::truncate(before));
        lanes::store(b.data(), simd::truncate(after));
    }
};

/// sample_alpha() at several places; without meaning where not `wanted`.
template <bool IsNearest, class V>
[[nodiscard]] V sample_alpha_lanes(const image& level, const texture& t, V u, V v,
                                   simd::mask_lanes<V> wanted) noexcept {
    using lanes = simd::lanes<V>;
    const texel_pair_lanes<V> x(wrapped_lanes<V>(u, t.wrap_u, wanted), level.width, t.wrap_u,
                                IsNearest);
    const texel_pair_lanes<V> y(wrapped_lanes<V>(v, t.wrap_v, wanted), level.height, t.wrap_v,
                                IsNearest);
    const std::uint8_t* texels = level.bytes.data();
    const auto width = static_cast<std::size_t>(level.width);
    const auto values = [&](const auto& column, const auto& row) {
        return simd::to_float(simd::int_lanes_of<V>([&](std::size_t i) {
            return static_cast<std::int32_t>(texels[static_cast<std::size_t>(row[i]) * width +
                                                    static_cast<std::size_t>(column[i])]);
        }));
    };
    const V scale = lanes::fill(1.0f / 255.0f);
    if constexpr (IsNearest) return values(x.a, y.a) * scale;
    const V one = lanes::fill(1);
    const V fx = x.share_of_b;
    const V fy = y.share_of_b;
    V sum = values(x.a, y.a) * ((one - fx) * (one - fy));
    sum += values(x.b, y.a) * (fx * (one - fy));
    sum += values(x.a, y.b) * ((one - fx) * fy);
    sum += values(x.b, y.b) * (fx * fy);
    return sum * scale;
}

/// What decides over the samples of a face whose alpha counts.
class face_alpha {
public:
    /// Needs  `cover` outlives this.
    face_alpha(const face_cover& cover, const raster_triangle& triangle) noexcept : cover_(cover) {
        const auto interpolated = [&](auto&& value) {
            return triangle.interpolate(value(0), value(1), value(2));
        };
        if (cover.alpha != nullptr) {
            u_ = interpolated([&](std::size_t i) { return cover.uvs[i].x; });
            v_ = interpolated([&](std::size_t i) { return cover.uvs[i].y; });
        }
        if (cover.has_vertex_alpha) {
            vertex_ = interpolated([&](std::size_t i) { return cover.vertex_alpha[i]; });
        }
    }

    template <class V, bool IsNearest>
    struct row {
        const face_cover* cover;
        row_value<V> u;
        row_value<V> v;
        row_value<V> vertex;

        /// Alpha of the samples `step` after the first of the row.
        [[nodiscard]] V at(V step, simd::mask_lanes<V> wanted) const noexcept {
            V alpha = simd::lanes<V>::fill(cover->factor);
            if (cover->has_vertex_alpha) alpha *= vertex.at(step);
            if (cover->alpha != nullptr) {
                alpha *= sample_alpha_lanes<IsNearest>(*cover->alpha, *cover->map, u.at(step),
                                                       v.at(step), wanted);
            }
            return alpha;
        }
    };
    template <class V, bool IsNearest>
    [[nodiscard]] row<V, IsNearest> from(const dvec2& at) const noexcept {
        return {&cover_, {u_, at}, {v_, at}, {vertex_, at}};
    }

private:
    const face_cover& cover_;
    affine_value u_{};
    affine_value v_{};
    affine_value vertex_{};
};

}  // namespace billow::inline BILLOW_ABI::detail
