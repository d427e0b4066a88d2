// A picture of a mesh to look at.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/image/image.hpp>
#include <billow/image/srgb.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/metrics/camera.hpp>
#include <billow/metrics/render.hpp>
#include <billow/metrics/render_scene.hpp>
#include <billow/metrics/view_picture.hpp>

namespace billow::inline BILLOW_ABI {

struct picture_options {
    vec3 background{0.85f, 0.87f, 0.9f};  ///< linear light
    render_options render{};
};

/// A view before a background, in linear light, as an sRGB image of three channels.
[[nodiscard]] inline image image_of(const view_picture& picture, const vec3& background) {
    image result = image::filled(picture.width, picture.height, 3, 0);
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const vec4& seen = picture.at(x, y);
            const vec3 light = vec3(seen) + background * (1 - seen.w);
            std::uint8_t* pixel = result.pixel(x, y);
            for (int c = 0; c < 3; ++c) pixel[c] = srgb_byte_from_linear(light[c]);
        }
    }
    return result;
}

/// Draws `source` as render_view does.
///
/// Needs  indices within bounds, finite positions.
/// Gives  RGB, sRGB, options.background where nothing is.
[[nodiscard]] inline image draw_picture(const mesh& source, const camera& from,
                                        const picture_options& options = {},
                                        parallel threads = {}) {
    return image_of(render_view(render_scene(source), from, options.render, threads),
                    options.background);
}

/// Two pictures of the same height and channels in one, the first on the left.
[[nodiscard]] inline image side_by_side(const image& left, const image& right) {
    BILLOW_ASSERT(left.height == right.height && left.channels == right.channels);
    image joined = image::filled(left.width + right.width, left.height, left.channels, 0);
    for (int y = 0; y < left.height; ++y) {
        const auto bytes_of = [](const image& i) {
            return static_cast<std::ptrdiff_t>(i.width) * i.channels;
        };
        const auto row_of = [&](const image& i) { return i.bytes.begin() + y * bytes_of(i); };
        const auto end =
            std::copy_n(row_of(left), bytes_of(left), joined.bytes.begin() + y * bytes_of(joined));
        std::copy_n(row_of(right), bytes_of(right), end);
    }
    return joined;
}

}  // namespace billow::inline BILLOW_ABI
