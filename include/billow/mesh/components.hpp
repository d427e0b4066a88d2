// The pieces that a mesh falls into: faces that hang together by shared vertices.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include <billow/core/disjoint_sets.hpp>
#include <billow/core/types.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/vertex_identity.hpp>

namespace billow::inline BILLOW_ABI {

/// What makes two faces one piece.
enum class connection {
    position,  ///< corners at the same place: seams of normals and uvs do not cut
    index,     ///< the same vertex of the mesh
};

/// Faces that can be reached from each other over shared vertices.
struct mesh_component {
    std::size_t face_count = 0;
    double area = 0;      ///< scene units squared
    double diameter = 0;  ///< of the sphere around the centre of its box, scene units
};

/// Shape  `of_face`: a row of `components` for each face. Components are in the order of their first
///        faces.
struct mesh_components {
    std::vector<std::uint32_t> of_face{};
    std::vector<mesh_component> components{};
};

/// Finds the connected components of a mesh.
///
/// Needs   indices within bounds, as validate() checks.
/// Cost    O(vertices + faces).
[[nodiscard]] inline mesh_components find_components(const mesh& m,
                                                     connection by = connection::position) {
    const bool is_by_position = by == connection::position;
    const vertex_identity identity = is_by_position ? position_ids(m) : vertex_identity{};
    const auto id_of = [&](std::uint32_t v) { return is_by_position ? identity.id[v] : v; };
    disjoint_sets sets(is_by_position ? identity.count : m.vertex_count());
    for (const uvec3& t : m.triangles) {
        sets.join(id_of(t.x), id_of(t.y));
        sets.join(id_of(t.x), id_of(t.z));
    }

    struct box {
        dvec3 low{std::numeric_limits<double>::infinity()};
        dvec3 high{-std::numeric_limits<double>::infinity()};
    };
    mesh_components result;
    result.of_face.reserve(m.face_count());
    std::vector<std::uint32_t> number(is_by_position ? identity.count : m.vertex_count(), no_id);
    std::vector<box> boxes;
    for (face_id face = 0; face < m.face_count(); ++face) {
        std::uint32_t& component = number[sets.leader(id_of(m.triangles[face].x))];
        if (component == no_id) {
            component = static_cast<std::uint32_t>(boxes.size());
            result.components.emplace_back();
            boxes.emplace_back();
        }
        result.of_face.push_back(component);
        ++result.components[component].face_count;
        const auto [a, b, c] = m.corners(face);
        result.components[component].area +=
            glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a))) / 2;
        for (const vec3& corner : {a, b, c}) {
            boxes[component].low = glm::min(boxes[component].low, dvec3(corner));
            boxes[component].high = glm::max(boxes[component].high, dvec3(corner));
        }
    }
    for (face_id face = 0; face < m.face_count(); ++face) {
        const box& around = boxes[result.of_face[face]];
        double& diameter = result.components[result.of_face[face]].diameter;
        for (const vec3& corner : m.corners(face)) {
            const dvec3 centre = around.low + (around.high - around.low) * 0.5;
            diameter = std::max(diameter, 2 * glm::distance(dvec3(corner), centre));
        }
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI
