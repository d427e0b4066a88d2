// Two meshes as one.
#pragma once

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/select_faces.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Where normals lack, gives every face corners of its own and its flat normal.
inline void make_normals(mesh& m) {
    if (!m.normals.empty()) return;
    const mesh shared = m;
    detail::for_each_vertex_column(shared, m, [&](const auto& from, auto& to) {
        if (from.empty()) return;
        to.clear();
        to.reserve(3 * shared.face_count());
        for (const uvec3& t : shared.triangles) {
            for (int k = 0; k < 3; ++k) to.push_back(from[t[k]]);
        }
    });
    for (face_id face = 0; face < m.face_count(); ++face) {
        m.triangles[face] = uvec3(0, 1, 2) + 3u * face;
        const auto [a, b, c] = m.corners(face);
        const dvec3 cross = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
        const double length = glm::length(cross);
        m.normals.insert(m.normals.end(), 3, vec3(length > 0 ? cross / length : dvec3(0, 0, 1)));
    }
}

/// Whether shading needs tangents that are not there.
[[nodiscard]] inline bool lacks_tangents(const mesh& m) noexcept {
    return m.tangents.empty() && std::ranges::any_of(m.materials, [](const material& look) {
               return look.normal_texture.is_present();
           });
}

/// Appends rows, with `plain` for those that one side lacks. None where both do.
template <class T>
void append_rows(std::vector<T>& to, std::size_t to_count, const std::vector<T>& from,
                 std::size_t from_count, const T& plain) {
    if (to.empty() && from.empty()) return;
    if (to.empty()) to.assign(to_count, plain);
    to.insert(to.end(), from.begin(), from.end());
    to.resize(to_count + from_count, plain);
}

}  // namespace detail

/// Adds the faces of `from` behind those of `to`, with their own vertices, materials and images.
///
/// Gives   attributes that one of them lacks are filled: flat normals, which unshares vertices; uvs
///         of 0; white. Tangents stay only where nobody misses them, a viewer derives them from the
///         uvs. Where one has feature ids, the other one's vertices get those of
///         `plain_feature`.
/// Cost    O(vertices + faces + pixels) of `from`.
inline void append_mesh(mesh& to, mesh from, std::uint32_t plain_feature = 0) {
    if (to.vertex_count() > 0 && from.vertex_count() > 0) {
        if (!to.normals.empty()) detail::make_normals(from);
        if (!from.normals.empty()) detail::make_normals(to);
        if (detail::lacks_tangents(to) || detail::lacks_tangents(from)) {
            to.tangents.clear();
            from.tangents.clear();
        }
    }
    const std::size_t before = to.vertex_count();
    const std::size_t more = from.vertex_count();
    const auto append = [&](auto& rows, const auto& new_rows, const auto& plain) {
        detail::append_rows(rows, before, new_rows, more, plain);
    };
    append(to.normals, from.normals, vec3(0, 0, 1));
    append(to.tangents, from.tangents, vec4(1, 0, 0, 1));
    for (std::size_t i = 0; i < uv_set_count; ++i) append(to.uv_sets[i], from.uv_sets[i], vec2(0));
    append(to.colors, from.colors, vec4(1));
    append(to.feature_ids, from.feature_ids, plain_feature);
    append(to.positions, from.positions, vec3(0));

    // A face beyond the last material is plain; it stays so whatever comes behind.
    const auto material_ids = [](const mesh& m, std::size_t offset) {
        std::vector<material_id> ids(m.face_count(), 0);
        if (!m.face_materials.empty()) ids = m.face_materials;
        for (material_id& id : ids) {
            id = id < m.materials.size() ? id + static_cast<material_id>(offset) : no_id;
        }
        return ids;
    };
    std::vector<material_id> materials = material_ids(to, 0);
    const std::vector<material_id> new_materials = material_ids(from, to.materials.size());
    materials.insert(materials.end(), new_materials.begin(), new_materials.end());
    to.face_materials = std::move(materials);
    for (const uvec3& t : from.triangles) {
        to.triangles.push_back(t + static_cast<std::uint32_t>(before));
    }
    for (material& look : from.materials) {
        for (texture* t : detail::textures_of(look)) {
            if (t->is_present()) t->image += static_cast<image_id>(to.images.size());
        }
        to.materials.push_back(std::move(look));
    }
    std::ranges::move(from.images, std::back_inserter(to.images));
}

}  // namespace billow::inline BILLOW_ABI
