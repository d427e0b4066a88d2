// From the samples of a texel to its bytes in a tile.
//
// Luksch 2009, section 4.5: only samples that show a face are averaged, so no halo of background.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <billow/bake/horizon.hpp>
#include <billow/bake/tile_picture.hpp>
#include <billow/bake/visibility.hpp>
#include <billow/core/types.hpp>
#include <billow/image/srgb.hpp>

namespace billow::inline BILLOW_ABI {

/// The mean look of what a texel shows.
struct texel {
    surface_sample look{};   ///< normal in scene space, turned to the front
    int samples = 0;         ///< that show a face
    int cut_out = 0;         ///< those of them on materials of alpha_mode::mask and blend
    float surface_area = 0;  ///< of what they show, in samples, see tile_picture
};

namespace detail {

/// Sums of looks, weighted by samples.
class look_mean {
public:
    void add(const surface_sample& sample, float weight) noexcept {
        sum_.base_color += sample.base_color * weight;
        sum_.normal += sample.normal * weight;
        sum_.occlusion += sample.occlusion * weight;
        sum_.roughness += sample.roughness * weight;
        sum_.metallic += sample.metallic * weight;
        sum_.emissive += sample.emissive * weight;
        sum_.visible_sky += sample.visible_sky * weight;
        weight_ += weight;
    }
    /// Needs a sample. Normals that cancel out give `front`.
    [[nodiscard]] surface_sample mean(const vec3& front) const noexcept {
        const float scale = 1 / weight_;
        const float length = glm::length(sum_.normal);
        return {.base_color = sum_.base_color * scale,
                .normal = length > 1e-6f * weight_ ? sum_.normal / length : front,
                .occlusion = sum_.occlusion * scale,
                .roughness = sum_.roughness * scale,
                .metallic = sum_.metallic * scale,
                .emissive = sum_.emissive * scale,
                .visible_sky = sum_.visible_sky * scale};
    }

private:
    surface_sample sum_{.base_color = vec3(0),
                        .normal = vec3(0),
                        .occlusion = 0,
                        .roughness = 0,
                        .metallic = 0,
                        .emissive = vec3(0),
                        .visible_sky = vec4(0)};
    float weight_ = 0;
};

/// How much larger a face is than it looks along `front`, at most four times.
[[nodiscard]] inline float tilt_of(const mesh& source, face_id face, const vec3& front) noexcept {
    const auto [a, b, c] = source.corners(face);
    const dvec3 cross = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
    const double seen = std::abs(glm::dot(cross, dvec3(front)));
    const double area = glm::length(cross);
    return area < 4 * seen ? static_cast<float>(area / seen) : 4.0f;
}

}  // namespace detail

/// The texel in column x and row y of a view's grid; `front` is the view's normal. `surface_area` is
/// left at 0 unless `measures_surface`.
[[nodiscard]] inline texel resolve_texel(const visibility_buffer& buffer, view_shader& shader,
                                         const surface& look, int x, int y, int supersample,
                                         const vec3& front,
                                         bool measures_surface = false) noexcept {
    std::array<texel_part, max_supersample * max_supersample> parts;
    const std::size_t count = parts_of_texel(buffer, x, y, supersample, parts);
    texel result;
    if (count == 0) return result;
    detail::look_mean mean;
    for (std::size_t i = 0; i < count; ++i) {
        const bool is_solid = look.material_of(parts[i].face).alpha == alpha_mode::opaque;
        // Solids at the centre of the texel, or the nearest point of the face: sharp where a texel
        // lies across an edge. Of leaves the centre may be a hole.
        const dvec2 point =
            is_solid ? dvec2(x + 0.5, y + 0.5) * static_cast<double>(supersample) : parts[i].centre;
        mean.add(shader.at(parts[i].face, point), static_cast<float>(parts[i].samples));
        if (measures_surface) {
            result.surface_area += static_cast<float>(parts[i].samples) *
                                   detail::tilt_of(look.source(), parts[i].face, front);
        }
        result.samples += parts[i].samples;
        if (!is_solid) result.cut_out += parts[i].samples;
    }
    result.look = mean.mean(front);
    return result;
}

/// How a normal becomes a colour.
struct normal_encoding {
    frame axes{};                 ///< of the billboard, or of its back
    bool is_scene_space = false;  ///< as it is; else in the billboard's axes, and never behind it
};

[[nodiscard]] inline vec3 encoded_normal(const vec3& normal, const normal_encoding& how) noexcept {
    if (how.is_scene_space) return normal;
    vec3 local(how.axes.to_local(dvec3(normal)));
    // A tangent space normal map holds nothing behind the surface: blue stays at 128 or above.
    local.z = std::max(local.z, 0.004f);
    return glm::normalize(local);
}

/// Writes `value` to all channels that `to` has, but alpha.
inline void write_texel(tile_picture& to, const normal_encoding& normals, int x, int y,
                        const texel& value) noexcept {
    const std::size_t at = to.index(x, y);
    to.covered[at] = static_cast<std::uint8_t>(value.samples);
    to.cut_out[at] = static_cast<std::uint8_t>(value.cut_out);

    atlas& channels = to.channels;
    const surface_sample& look = value.look;
    std::uint8_t* color = channels.base_color.pixel(x, y);
    for (int c = 0; c < 3; ++c) color[c] = srgb_byte_from_linear(look.base_color[c]);
    const vec3 normal = encoded_normal(look.normal, normals);
    std::uint8_t* n = channels.normal.pixel(x, y);
    for (int c = 0; c < 3; ++c) n[c] = byte_from_unit(normal[c] * 0.5f + 0.5f);
    std::uint8_t* orm = channels.occlusion_roughness_metallic.pixel(x, y);
    orm[0] = byte_from_unit(look.occlusion);
    orm[1] = byte_from_unit(look.roughness);
    orm[2] = byte_from_unit(look.metallic);
    std::uint8_t* emissive = channels.emissive.pixel(x, y);
    for (int c = 0; c < 3; ++c) emissive[c] = srgb_byte_from_linear(look.emissive[c]);
    if (!channels.horizon.empty()) {
        const auto cone = encode_horizon(cone_of(look.visible_sky));
        std::copy(cone.begin(), cone.end(), channels.horizon.pixel(x, y));
    }
}

}  // namespace billow::inline BILLOW_ABI
