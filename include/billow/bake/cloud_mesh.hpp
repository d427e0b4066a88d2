// A baked cloud as a mesh: one or two polygons a billboard, one or two materials an atlas.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// The texture coordinate, from the top left of the atlas, of the point (s, t) of the side that a
/// tile shows: s to the right, t up.
[[nodiscard]] inline dvec2 atlas_uv(const tile& t, const atlas& in, const dvec2& st) noexcept {
    // Upright, t runs up. Turned clockwise, s runs down and t to the right.
    const dvec2 inside = t.is_rotated ? dvec2(st.y, st.x) : dvec2(st.x, 1 - st.y);
    return {(t.x + inside.x * t.width) / in.width(), (t.y + inside.y * t.height) / in.height()};
}

namespace detail {

/// One call of cloud_mesh; its methods are the steps in their order.
class cloud_mesher {
public:
    cloud_mesher(const billboard_cloud& cloud, const baked_cloud& baked)
        : cloud_(cloud), baked_(baked), materials_(baked.atlases.size(), {no_id, no_id}) {}

    [[nodiscard]] mesh run() {
        const bool is_scene_space =
            baked_.normals == normal_style::object || baked_.normals == normal_style::dome;
        for (std::size_t i = 0; i < cloud_.billboards.size(); ++i) {
            const std::uint32_t back = baked_.back_tile(i);
            const bool has_two_sides = is_scene_space || back != no_id;
            add_side(i, baked_.tiles[i], false, has_two_sides);
            if (has_two_sides) add_side(i, baked_.tiles[back == no_id ? i : back], true, true);
        }
        return std::move(result_);
    }

private:
    [[nodiscard]] texture add_texture(const image& picture) {
        if (picture.empty()) return {};
        result_.images.push_back(picture);
        return {.image = static_cast<image_id>(result_.images.size() - 1),
                .wrap_u = texture_wrap::clamp_to_edge,
                .wrap_v = texture_wrap::clamp_to_edge};
    }

    [[nodiscard]] material_id material_of(atlas_id id, bool is_single_sided) {
        material_id& known = materials_[id][is_single_sided ? 1 : 0];
        if (known != no_id) return known;
        const material_id other = materials_[id][is_single_sided ? 0 : 1];
        known = static_cast<material_id>(result_.materials.size());
        if (other != no_id) {
            result_.materials.push_back(result_.materials[other]);
        } else {
            const atlas& from = baked_.atlases[id];
            material m;
            m.base_color_texture = add_texture(from.base_color);
            m.normal_texture = add_texture(from.normal);
            m.metallic_roughness_texture = add_texture(from.occlusion_roughness_metallic);
            m.occlusion_texture = m.metallic_roughness_texture;
            m.metallic = m.metallic_roughness_texture.is_present() ? 1.0f : 0.0f;
            m.emissive_texture = add_texture(from.emissive);
            if (m.emissive_texture.is_present()) m.emissive = vec3(1);
            m.alpha = alpha_mode::mask;
            m.alpha_cutoff = 0.5f;
            result_.materials.push_back(std::move(m));
        }
        material& made = result_.materials[known];
        made.name = "atlas_" + std::to_string(id) + (is_single_sided ? "_sides" : "");
        made.is_double_sided = !is_single_sided;
        return known;
    }

    void add_side(std::size_t i, const tile& t, bool is_back, bool is_single_sided) {
        const billboard& b = cloud_.billboards[i];
        static const std::array<dvec2, 4> rectangle{dvec2(0, 0), dvec2(1, 0), dvec2(1, 1),
                                                    dvec2(0, 1)};
        const std::span<const dvec2> outline =
            baked_.outlines.empty() ? std::span<const dvec2>(rectangle) : baked_.outlines[i];
        const bool is_scene_space =
            baked_.normals == normal_style::object || baked_.normals == normal_style::dome;
        // The front's tile on the back is seen through, as on a double-sided polygon.
        const bool has_own_tile = is_back && baked_.back_tile(i) != no_id;
        const vec3 normal(is_back ? -b.axes.normal : b.axes.normal);
        const vec3 right(has_own_tile ? -b.axes.u : b.axes.u);
        const vec3 along = t.is_rotated ? vec3(b.axes.v) : right;
        const float side = is_back && !has_own_tile ? -1.0f : 1.0f;
        const auto first = static_cast<std::uint32_t>(result_.positions.size());
        for (const dvec2& st : outline) {
            result_.positions.push_back(
                vec3(b.origin + b.axes.u * (st.x * b.width) + b.axes.v * (st.y * b.height)));
            // In this frame tangent space is scene space.
            result_.normals.push_back(is_scene_space ? vec3(0, 0, 1) : normal);
            result_.tangents.push_back(is_scene_space ? vec4(1, 0, 0, 1) : vec4(along, side));
            const dvec2 seen = has_own_tile ? dvec2(1 - st.x, st.y) : st;
            result_.uv_sets[0].push_back(vec2(atlas_uv(t, baked_.atlases[t.atlas], seen)));
            result_.feature_ids.push_back(static_cast<std::uint32_t>(i));
        }
        const material_id look = material_of(t.atlas, is_single_sided);
        for (std::uint32_t k = 2; k < outline.size(); ++k) {
            const uvec3 triangle = is_back ? uvec3(first, first + k, first + k - 1)
                                           : uvec3(first, first + k - 1, first + k);
            result_.triangles.push_back(triangle);
            result_.face_materials.push_back(look);
        }
    }

    const billboard_cloud& cloud_;
    const baked_cloud& baked_;
    std::vector<std::array<material_id, 2>> materials_;  ///< of each atlas: double, single sided
    mesh result_{};
};

}  // namespace detail

/// The cloud as textured polygons where the original mesh is: each billboard is a fan of triangles,
/// its corners counter-clockwise from its front: (0,0), (1,0), (1,1), (0,1) of the rectangle, or its
/// outline. Behind it, where the billboard has two sides, the same turned round. Tangents run along
/// the atlas's u axis, and with scene space normals along x. Feature ids are plane ids.
///
/// Needs  tiles of `cloud`.
/// Gives  materials of alpha_mode::mask with their images, for each atlas one that is double sided
///        and one that is not, as far as they are used.
[[nodiscard]] inline mesh cloud_mesh(const billboard_cloud& cloud, const baked_cloud& baked) {
    BILLOW_ASSERT(baked.tiles.size() >= cloud.billboards.size());
    return detail::cloud_mesher(cloud, baked).run();
}

}  // namespace billow::inline BILLOW_ABI
