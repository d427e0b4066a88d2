// Some faces of a mesh as a mesh of their own.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Calls `visit(column of a, column of b)` for each column that has one row a vertex, positions first.
template <class A, class B, class Visit>
void for_each_vertex_column(A& a, B& b, const Visit& visit) {
    visit(a.positions, b.positions);
    visit(a.normals, b.normals);
    visit(a.tangents, b.tangents);
    for (std::size_t i = 0; i < uv_set_count; ++i) visit(a.uv_sets[i], b.uv_sets[i]);
    visit(a.colors, b.colors);
    visit(a.feature_ids, b.feature_ids);
}

/// The textures of a material, constant or not.
template <class Material>
[[nodiscard]] auto textures_of(Material& m) {
    return std::array{&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture,
                      &m.occlusion_texture, &m.emissive_texture};
}

/// Gives `value` its place in `order`, where it is new.
inline std::uint32_t place_of(std::uint32_t value, std::vector<std::uint32_t>& places,
                              std::vector<std::uint32_t>& order) {
    std::uint32_t& place = places[value];
    if (place == no_id) {
        place = static_cast<std::uint32_t>(order.size());
        order.push_back(value);
    }
    return place;
}

}  // namespace detail

/// The given faces, with the vertices, materials and images that they use and no others; what is
/// copied is copied bit by bit.
///
/// Shape   faces in the given order; vertices, materials and images in the order of first use.
/// Needs   face ids below m.face_count(); indices of `m` within bounds.
/// Cost    O(vertices of `m` + faces + pixels in use).
[[nodiscard]] inline mesh select_faces(const mesh& m, std::span<const face_id> faces) {
    mesh result;
    std::vector<std::uint32_t> vertices;
    std::vector<std::uint32_t> materials;
    std::vector<std::uint32_t> images;
    std::vector<std::uint32_t> new_vertex(m.vertex_count(), no_id);
    std::vector<std::uint32_t> new_material(m.materials.size(), no_id);
    std::vector<std::uint32_t> new_image(m.images.size(), no_id);
    result.triangles.reserve(faces.size());
    for (const face_id face : faces) {
        uvec3 triangle = m.triangles[face];
        for (int k = 0; k < 3; ++k) {
            triangle[k] = detail::place_of(triangle[k], new_vertex, vertices);
        }
        result.triangles.push_back(triangle);
        const material_id id = m.face_materials.empty() ? 0 : m.face_materials[face];
        result.face_materials.push_back(
            id < m.materials.size() ? detail::place_of(id, new_material, materials) : no_id);
    }
    detail::for_each_vertex_column(m, result, [&](const auto& from, auto& to) {
        if (from.empty()) return;
        to.reserve(vertices.size());
        for (const std::uint32_t v : vertices) to.push_back(from[v]);
    });
    for (const std::uint32_t id : materials) {
        result.materials.push_back(m.materials[id]);
        for (texture* t : detail::textures_of(result.materials.back())) {
            t->image =
                t->image < m.images.size() ? detail::place_of(t->image, new_image, images) : no_id;
        }
    }
    for (const std::uint32_t id : images) result.images.push_back(m.images[id]);
    return result;
}

}  // namespace billow::inline BILLOW_ABI
