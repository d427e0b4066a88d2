// Ever smaller versions of an image, so that a texture seen from afar does not alias.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <billow/image/image.hpp>
#include <billow/image/srgb.hpp>

namespace billow::inline BILLOW_ABI {

/// What the bytes of an image mean when they are averaged.
enum class texel_kind {
    linear,      ///< every channel by itself
    srgb,        ///< colour in linear light
    srgb_alpha,  ///< colour in linear light, weighted by alpha: what is not there has no colour
};

namespace detail {

/// The source pixels under one smaller pixel along one axis, at most 3 as sizes are halved.
struct box_taps {
    int first = 0;
    int count = 0;
    std::array<float, 3> weight{};
};

[[nodiscard]] inline std::vector<box_taps> box_taps_of(int from, int to) {
    std::vector<box_taps> taps(static_cast<std::size_t>(to));
    const double scale = static_cast<double>(from) / to;
    for (int i = 0; i < to; ++i) {
        box_taps& t = taps[static_cast<std::size_t>(i)];
        const double low = i * scale;
        const double high = std::min<double>(from, (i + 1) * scale);
        t.first = std::min(static_cast<int>(low + 1e-9), from - 1);
        for (int k = 0; k < 3 && t.first + k < from; ++k) {
            const double share =
                std::min<double>(high, t.first + k + 1) - std::max<double>(low, t.first + k);
            if (share <= 1e-9) break;
            t.weight[static_cast<std::size_t>(k)] = static_cast<float>(share / (high - low));
            t.count = k + 1;
        }
    }
    return taps;
}

/// RGBA pixels in floats: linear light, straight alpha.
struct float_image {
    int width = 0;
    int height = 0;
    std::vector<std::array<float, 4>> pixels{};
};

[[nodiscard]] inline float_image halved(const float_image& from, bool is_alpha_weighted) {
    float_image to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
    const auto columns = box_taps_of(from.width, to.width);
    const auto rows = box_taps_of(from.height, to.height);
    to.pixels.reserve(columns.size() * rows.size());
    for (const box_taps& row : rows) {
        for (const box_taps& column : columns) {
            std::array<float, 4> plain{};
            std::array<float, 3> weighted{};
            for (int j = 0; j < row.count; ++j) {
                for (int i = 0; i < column.count; ++i) {
                    const auto& p = from.pixels[static_cast<std::size_t>(row.first + j) *
                                                    static_cast<std::size_t>(from.width) +
                                                static_cast<std::size_t>(column.first + i)];
                    const float w = row.weight[static_cast<std::size_t>(j)] *
                                    column.weight[static_cast<std::size_t>(i)];
                    for (std::size_t c = 0; c < 4; ++c) plain[c] += w * p[c];
                    for (std::size_t c = 0; c < 3; ++c) weighted[c] += w * p[3] * p[c];
                }
            }
            if (is_alpha_weighted && plain[3] > 0) {
                for (std::size_t c = 0; c < 3; ++c) plain[c] = weighted[c] / plain[3];
            }
            to.pixels.push_back(plain);
        }
    }
    return to;
}

[[nodiscard]] inline float_image float_image_of(const image& from, bool is_srgb) {
    float_image to{from.width, from.height, {}};
    const auto& light = linear_of_srgb_byte();
    const auto channels = static_cast<std::size_t>(from.channels);
    to.pixels.reserve(from.bytes.size() / channels);
    for (std::size_t at = 0; at + channels <= from.bytes.size(); at += channels) {
        const std::uint8_t* p = from.bytes.data() + at;
        const bool is_grey = channels < 3;
        const auto colour = [&](std::size_t c) {
            const std::uint8_t byte = p[is_grey ? 0 : c];
            return is_srgb ? light[byte] : static_cast<float>(byte) / 255.0f;
        };
        const bool has_alpha = channels == 2 || channels == 4;
        const float alpha = has_alpha ? static_cast<float>(p[channels - 1]) / 255.0f : 1.0f;
        to.pixels.push_back({colour(0), colour(1), colour(2), alpha});
    }
    return to;
}

[[nodiscard]] inline image bytes_of(const float_image& from, bool is_srgb) {
    image to = image::filled(from.width, from.height, 4, 0);
    std::uint8_t* byte = to.bytes.data();
    for (const auto& p : from.pixels) {
        for (std::size_t c = 0; c < 3; ++c) {
            *byte++ = is_srgb ? srgb_byte_from_linear(p[c]) : byte_from_unit(p[c]);
        }
        *byte++ = byte_from_unit(p[3]);
    }
    return to;
}

}  // namespace detail

/// RGBA images, the first one as large as `source`, each further one half as large as the one
/// before (rounded down), the last one 1 × 1. Grey is spread to three channels, missing alpha is 1.
///
/// Needs  a source of at least one pixel.
/// Cost   O(pixels); 16 bytes a pixel while it works.
[[nodiscard]] inline std::vector<image> make_mip_chain(const image& source, texel_kind kind) {
    BILLOW_ASSERT(!source.empty() && source.width > 0 && source.height > 0);
    const bool is_srgb = kind != texel_kind::linear;
    detail::float_image level = detail::float_image_of(source, is_srgb);
    std::vector<image> chain{source.channels == 4 ? source : detail::bytes_of(level, is_srgb)};
    while (level.width > 1 || level.height > 1) {
        level = detail::halved(level, kind == texel_kind::srgb_alpha);
        chain.push_back(detail::bytes_of(level, is_srgb));
    }
    return chain;
}

}  // namespace billow::inline BILLOW_ABI
