// A baked cloud as a mesh: two triangles a billboard, one material an atlas.
#pragma once

#include <array>
#include <string>

#include <billow/bake/baked_cloud.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

[[nodiscard]] inline texture atlas_texture(mesh& owner, const image& picture) {
    if (picture.empty()) return {};
    owner.images.push_back(picture);
    return {.image = static_cast<image_id>(owner.images.size() - 1),
            .wrap_u = texture_wrap::clamp_to_edge,
            .wrap_v = texture_wrap::clamp_to_edge};
}

inline void add_atlas_material(mesh& to, const atlas& from) {
    material m;
    m.name = "atlas_" + std::to_string(to.materials.size());
    m.base_color_texture = atlas_texture(to, from.base_color);
    m.normal_texture = atlas_texture(to, from.normal);
    m.metallic_roughness_texture = atlas_texture(to, from.occlusion_roughness_metallic);
    m.occlusion_texture = m.metallic_roughness_texture;
    m.metallic = m.metallic_roughness_texture.is_present() ? 1.0f : 0.0f;
    m.emissive_texture = atlas_texture(to, from.emissive);
    if (m.emissive_texture.is_present()) m.emissive = vec3(1);
    m.alpha = alpha_mode::mask;
    m.alpha_cutoff = 0.5f;
    m.is_double_sided = true;
    to.materials.push_back(std::move(m));
}

}  // namespace detail

/// The texture coordinate, from the top left of the atlas, of the point (s, t) of a billboard.
[[nodiscard]] inline dvec2 atlas_uv(const tile& t, const atlas& in, const dvec2& st) noexcept {
    // Upright, t runs up. Turned clockwise, s runs down and t to the right.
    const dvec2 inside = t.is_rotated ? dvec2(st.y, st.x) : dvec2(st.x, 1 - st.y);
    return {(t.x + inside.x * t.width) / in.width(), (t.y + inside.y * t.height) / in.height()};
}

/// The cloud as textured quads where the original mesh is: vertices 4i to 4i + 3 are the corners
/// (0,0), (1,0), (1,1), (0,1) of billboard i, counter-clockwise from its front; faces 2i and 2i + 1
/// its triangles. Tangents run along the atlas's u axis, w = 1: seen from the front no tile is
/// mirrored. Feature ids are plane ids.
///
/// Needs  tiles of `cloud`.
/// Gives  materials of alpha_mode::mask, double sided, one an atlas, with their images.
[[nodiscard]] inline mesh cloud_mesh(const billboard_cloud& cloud, const baked_cloud& baked) {
    BILLOW_ASSERT(baked.tiles.size() == cloud.billboards.size());
    mesh result;
    for (const atlas& a : baked.atlases) detail::add_atlas_material(result, a);
    for (std::size_t i = 0; i < cloud.billboards.size(); ++i) {
        const billboard& b = cloud.billboards[i];
        const tile& t = baked.tiles[i];
        const auto first = static_cast<std::uint32_t>(result.positions.size());
        for (const dvec2& st : {dvec2(0, 0), dvec2(1, 0), dvec2(1, 1), dvec2(0, 1)}) {
            result.positions.push_back(
                vec3(b.origin + b.axes.u * (st.x * b.width) + b.axes.v * (st.y * b.height)));
            result.normals.push_back(vec3(b.axes.normal));
            result.tangents.push_back(vec4(vec3(t.is_rotated ? b.axes.v : b.axes.u), 1));
            result.uv_sets[0].push_back(vec2(atlas_uv(t, baked.atlases[t.atlas], st)));
            result.feature_ids.push_back(static_cast<std::uint32_t>(i));
        }
        result.triangles.push_back({first, first + 1, first + 2});
        result.triangles.push_back({first, first + 2, first + 3});
        result.face_materials.insert(result.face_materials.end(), 2, t.atlas);
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI
