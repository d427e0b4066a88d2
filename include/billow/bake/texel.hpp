// From the samples of a texel to its bytes in the atlas.
//
// Luksch 2009, section 4.5: only samples that show a face are averaged, so no halo of background.
// Fuhrmann et al. 2005, section 3.3.7: binary alpha from the covered share.
#pragma once

#include <algorithm>
#include <array>

#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/horizon.hpp>
#include <billow/bake/visibility.hpp>
#include <billow/core/types.hpp>
#include <billow/image/srgb.hpp>

namespace billow::inline BILLOW_ABI {

/// The mean look of what a texel shows.
struct texel {
    surface_sample look{};  ///< normal in scene space, turned to the front
    int samples = 0;        ///< that show a face
    bool is_opaque = false;
};

/// Shares of a texel that must be covered for it to be opaque.
struct coverage_thresholds {
    double foliage = 0.3;  ///< materials of alpha_mode::mask and blend
    double solid = 0.5;
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

}  // namespace detail

/// The texel in column x and row y of a view's grid.
[[nodiscard]] inline texel resolve_texel(const visibility_buffer& buffer, view_shader& shader,
                                         const surface& look, int x, int y, int supersample,
                                         const coverage_thresholds& thresholds,
                                         const vec3& front) noexcept {
    std::array<texel_part, max_supersample * max_supersample> parts;
    const std::size_t count = parts_of_texel(buffer, x, y, supersample, parts);
    texel result;
    if (count == 0) return result;
    detail::look_mean mean;
    double threshold = 0;  // summed over the covered samples
    for (std::size_t i = 0; i < count; ++i) {
        const bool is_solid = look.material_of(parts[i].face).alpha == alpha_mode::opaque;
        // Solids at the centre of the texel, or the nearest point of the face: sharp where a texel
        // lies across an edge. Of leaves the centre may be a hole.
        const dvec2 point =
            is_solid ? dvec2(x + 0.5, y + 0.5) * static_cast<double>(supersample) : parts[i].centre;
        mean.add(shader.at(parts[i].face, point), static_cast<float>(parts[i].samples));
        threshold += parts[i].samples * (is_solid ? thresholds.solid : thresholds.foliage);
        result.samples += parts[i].samples;
    }
    result.look = mean.mean(front);
    const double share = static_cast<double>(result.samples) / (supersample * supersample);
    result.is_opaque = share >= threshold / result.samples - 1e-9;
    return result;
}

/// Where the texel in column x and row y of an upright tile lies in the atlas.
[[nodiscard]] inline ivec2 texel_position(const tile& t, int x, int y) noexcept {
    // A quarter turn clockwise takes the row from the top to the column from the right.
    return t.is_rotated ? ivec2(t.x + t.width - 1 - y, t.y + x) : ivec2(t.x + x, t.y + y);
}

/// Writes `value` to the channels that `to` has. Alpha tells whether the texel is opaque.
inline void write_texel(atlas& to, const tile& t, const frame& axes, int x, int y,
                        const texel& value) noexcept {
    const ivec2 at = texel_position(t, x, y);
    const surface_sample& look = value.look;
    std::uint8_t* color = to.base_color.pixel(at.x, at.y);
    for (int c = 0; c < 3; ++c) color[c] = srgb_byte_from_linear(look.base_color[c]);
    color[3] = value.is_opaque ? 255 : 0;

    const dvec3 local = axes.to_local(dvec3(look.normal));
    // A normal map holds nothing that points behind the surface: blue stays at 128 or above.
    vec3 normal(t.is_rotated ? dvec3(local.y, -local.x, local.z) : local);
    normal.z = std::max(normal.z, 0.004f);
    normal = glm::normalize(normal);
    std::uint8_t* n = to.normal.pixel(at.x, at.y);
    for (int c = 0; c < 3; ++c) n[c] = byte_from_unit(normal[c] * 0.5f + 0.5f);

    std::uint8_t* orm = to.occlusion_roughness_metallic.pixel(at.x, at.y);
    orm[0] = byte_from_unit(look.occlusion);
    orm[1] = byte_from_unit(look.roughness);
    orm[2] = byte_from_unit(look.metallic);
    std::uint8_t* emissive = to.emissive.pixel(at.x, at.y);
    for (int c = 0; c < 3; ++c) emissive[c] = srgb_byte_from_linear(look.emissive[c]);
    if (!to.horizon.empty()) {
        const auto cone = encode_horizon(cone_of(look.visible_sky));
        std::copy(cone.begin(), cone.end(), to.horizon.pixel(at.x, at.y));
    }
}

}  // namespace billow::inline BILLOW_ABI
