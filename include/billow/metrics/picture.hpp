// A picture of a mesh, drawn by the rasteriser and the shading that the baker uses: to look at, and to
// measure how close a cloud comes to its original.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <billow/bake/draw_set.hpp>
#include <billow/bake/surface.hpp>
#include <billow/bake/visibility.hpp>
#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/image/image.hpp>
#include <billow/image/srgb.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// An orthographic camera.
struct picture_view {
    frame axes{};       ///< u to the right, v up in the picture, the normal to the viewer
    dvec3 centre{0};    ///< the scene point in the middle of the picture
    double height = 2;  ///< scene units from the lower to the upper edge
    int width_px = 512;
    int height_px = 512;
};

/// A view of a whole sphere from the direction `from` (any length), +Y up.
[[nodiscard]] inline picture_view view_of(const bounding_sphere& sphere, const dvec3& from,
                                          int width_px = 512, int height_px = 512) {
    const dvec3 normal = glm::normalize(from);
    const bool is_vertical = std::abs(normal.y) > 0.999;
    const dvec3 up = is_vertical ? dvec3(0, 0, normal.y > 0 ? -1 : 1) : dvec3(0, 1, 0);
    const dvec3 u = glm::normalize(glm::cross(up, normal));
    const double shorter = std::min(1.0, static_cast<double>(width_px) / height_px);
    const double height = 2.04 * (sphere.radius > 0 ? sphere.radius : 1.0) / shorter;
    return {{u, glm::cross(normal, u), normal}, sphere.centre, height, width_px, height_px};
}

struct picture_options {
    int supersample = 4;                  ///< samples a pixel side, 1 to 8
    vec3 background{0.85f, 0.87f, 0.9f};  ///< linear light
    float headlight = 0.7f;               ///< light from the viewer's place
    float sky = 0.35f;                    ///< light from above, and half of it from below
};

namespace detail {

[[nodiscard]] inline vec3 lit(const surface_sample& sample, const vec3& toward_viewer,
                              const picture_options& options) noexcept {
    const float facing = std::max(0.0f, glm::dot(sample.normal, toward_viewer));
    const float sky = options.sky * sample.occlusion * (0.75f + 0.25f * sample.normal.y);
    return sample.base_color * (options.headlight * facing + sky) + sample.emissive;
}

struct picture_scratch {
    visibility_buffer buffer;
    view_shader shader;
};

}  // namespace detail

/// Draws `source` with a light at the viewer and one from the sky. Alpha is tested, all faces are
/// seen from both sides.
///
/// Needs  indices within bounds, finite positions.
/// Gives  RGB, sRGB, options.background where nothing is.
/// Cost   O(faces + samples × faces that overlap), parallel over bands of rows.
[[nodiscard]] inline image draw_picture(const mesh& source, const picture_view& from,
                                        const picture_options& options = {},
                                        parallel threads = {}) {
    constexpr int band_height = 16;
    const int s = options.supersample;
    const double sample_size = from.height / (from.height_px * s);
    const dvec3 corner = from.centre - from.axes.u * (0.5 * from.width_px * s * sample_size) +
                         from.axes.v * (0.5 * from.height);
    const draw_target target{
        {from.axes, corner, sample_size}, from.width_px * s, from.height_px * s, band_height * s};
    std::vector<drawn_face> faces;
    for (face_id face = 0; face < source.face_count(); ++face) {
        const auto [a, b, c] = source.corners(face);
        if (const auto drawn = clipped_to(target, face, {dvec3(a), dvec3(b), dvec3(c)})) {
            faces.push_back(*drawn);
        }
    }
    std::sort(faces.begin(), faces.end());

    const surface look(source);
    const vec3 toward_viewer(from.axes.normal);
    image picture = image::filled(from.width_px, from.height_px, 3, 0);
    const auto bands = static_cast<std::size_t>((from.height_px + band_height - 1) / band_height);
    std::vector<detail::picture_scratch> scratches(threads.count(),
                                                   {visibility_buffer(s), view_shader(look, s)});
    for (auto& scratch : scratches) {
        scratch.buffer.reserve(static_cast<std::size_t>(target.columns) *
                               static_cast<std::size_t>(target.band_rows));
        scratch.shader.start(target.view);
    }
    for_jobs(threads, bands, scratches, [&](std::size_t band, auto& scratch) {
        const int first = static_cast<int>(band) * band_height;
        const int last = std::min(first + band_height, from.height_px);
        scratch.buffer.start({0, first * s, target.columns, last * s});
        for (const drawn_face& f : faces) {
            if (f.first_band <= band && band <= f.last_band) {
                scratch.buffer.draw(look, target.view, f.face, {});
            }
        }
        std::array<texel_part, max_supersample * max_supersample> parts;
        for (int y = first; y < last; ++y) {
            for (int x = 0; x < from.width_px; ++x) {
                const std::size_t count = parts_of_texel(scratch.buffer, x, y, s, parts);
                vec3 sum{0};
                int covered = 0;
                for (std::size_t i = 0; i < count; ++i) {
                    const surface_sample sample = scratch.shader.at(parts[i].face, parts[i].centre);
                    sum += glm::min(detail::lit(sample, toward_viewer, options), vec3(1)) *
                           static_cast<float>(parts[i].samples);
                    covered += parts[i].samples;
                }
                sum += options.background * static_cast<float>(s * s - covered);
                std::uint8_t* pixel = picture.pixel(x, y);
                for (int c = 0; c < 3; ++c) {
                    pixel[c] = srgb_byte_from_linear(sum[c] / static_cast<float>(s * s));
                }
            }
        }
    });
    return picture;
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
