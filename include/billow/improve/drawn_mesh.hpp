// The mesh that is drawn on a cloud's planes when corners have moved there.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/select_faces.hpp>
#include <billow/search/motion.hpp>

namespace billow::inline BILLOW_ABI {

/// `source` with the corners of `moved` where they have moved to along the planes of their faces.
///
/// Across its plane a corner keeps the distance that it has in `source`. A picture on the plane is
/// the same for it, but what lay in front of something else still does, and heights above the plane
/// stay those of the source.
///
/// Shape   the faces, materials and images of `source`; a moved face has vertices of its own.
/// Needs   `moved` around cloud.bounds.centre, each with a plane; one row of plane_of_face a face.
/// Gives   normals, tangents, uvs and colours as in the source. Where that has no normals and
///         something has moved, every corner has the normal of its face in the source. Faces may
///         have lost their area.
/// Cost    O(vertices + faces), and a copy of the images.
[[nodiscard]] inline mesh drawn_mesh(const mesh& source, const billboard_cloud& cloud,
                                     std::span<const moved_face> moved) {
    if (moved.empty()) return source;
    const bool is_flat = source.normals.empty();
    mesh drawn;
    drawn.triangles = source.triangles;
    drawn.face_materials = source.face_materials;
    drawn.materials = source.materials;
    drawn.images = source.images;

    std::vector<std::uint32_t> origin;  // the vertex of the source that each vertex is made of
    const auto split = [&](face_id face) {
        for (int k = 0; k < 3; ++k) {
            origin.push_back(source.triangles[face][k]);
            drawn.triangles[face][k] = static_cast<std::uint32_t>(origin.size() - 1);
        }
    };
    if (is_flat) {
        for (face_id face = 0; face < source.face_count(); ++face) split(face);
    } else {
        origin.resize(source.vertex_count());
        std::iota(origin.begin(), origin.end(), 0u);
        for (const moved_face& m : moved) split(m.face);
    }
    detail::for_each_vertex_column(source, drawn, [&](const auto& from, auto& to) {
        if (from.empty()) return;
        to.reserve(origin.size());
        for (const std::uint32_t vertex : origin) to.push_back(from[vertex]);
    });
    if (is_flat) {
        drawn.normals.reserve(origin.size());
        for (face_id face = 0; face < source.face_count(); ++face) {
            const auto [a, b, c] = source.corners(face);
            const dvec3 cross = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
            const double length = glm::length(cross);
            const dvec3 normal = length > 0 ? cross / length : dvec3(0, 0, 1);
            drawn.normals.insert(drawn.normals.end(), 3, vec3(normal));
        }
    }
    for (const moved_face& m : moved) {
        const plane& on = cloud.planes[cloud.plane_of_face[m.face]];
        const std::array<vec3, 3> corners = source.corners(m.face);
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec3 was = dvec3(corners[k]) - cloud.bounds.centre;
            const dvec3 is = m.corners[k];
            const dvec3 at = is + on.normal * glm::dot(on.normal, was - is);
            drawn.positions[drawn.triangles[m.face][static_cast<glm::length_t>(k)]] =
                vec3(at + cloud.bounds.centre);
        }
    }
    return drawn;
}

}  // namespace billow::inline BILLOW_ABI
