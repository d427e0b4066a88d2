// How a surface looks: the metallic-roughness model of glTF 2.0, which OBJ materials are mapped to.
#pragma once

#include <string>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// What a texture coordinate beyond [0, 1] means.
enum class texture_wrap { repeat, mirrored_repeat, clamp_to_edge };

/// An image as a material uses it. Texture coordinates start at the top left, as in glTF.
struct texture {
    image_id image = no_id;    ///< no_id: no texture, the factor stands alone
    std::uint32_t uv_set = 0;  ///< row of mesh::uv_sets
    texture_wrap wrap_u = texture_wrap::repeat;
    texture_wrap wrap_v = texture_wrap::repeat;
    bool is_nearest = false;  ///< magnification takes the nearest texel, not a bilinear mean
    /// uv' = (m[0] u + m[1] v + m[2]) of KHR_texture_transform, columns m.
    mat3 transform{1};

    [[nodiscard]] bool is_present() const noexcept { return image != no_id; }
};

enum class alpha_mode {
    opaque,  ///< alpha is ignored
    mask,    ///< a point is there when its alpha ≥ alpha_cutoff
    blend,   ///< alpha is the covered share
};

struct material {
    std::string name{};
    vec4 base_color{1};            ///< linear RGBA, multiplies texture and vertex colour
    texture base_color_texture{};  ///< sRGB, straight alpha
    float metallic = 1;            ///< multiplies the texture's blue
    float roughness = 1;           ///< multiplies the texture's green
    texture metallic_roughness_texture{};
    texture normal_texture{};  ///< tangent space, right-handed, y up
    float normal_scale = 1;
    texture occlusion_texture{};  ///< red: share of the surroundings that is visible
    float occlusion_strength = 1;
    vec3 emissive{0};            ///< linear RGB, multiplies the texture
    texture emissive_texture{};  ///< sRGB
    alpha_mode alpha = alpha_mode::opaque;
    float alpha_cutoff = 0.5f;  ///< of alpha_mode::mask
    bool is_double_sided = false;
};

}  // namespace billow::inline BILLOW_ABI
