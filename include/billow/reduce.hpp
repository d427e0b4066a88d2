// Fewer triangles for what stays a mesh, by meshoptimizer. Apart from billow.hpp, since it links that
// library: CMake's billow::reduce.
//
// M. Garland, P. S. Heckbert: Surface simplification using quadric error metrics. SIGGRAPH 1997,
// which meshoptimizer's simplifier builds upon.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include <meshoptimizer.h>

#include <billow/core/config.hpp>
#include <billow/core/types.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/select_faces.hpp>

namespace billow::inline BILLOW_ABI {

struct reduced_mesh {
    billow::mesh mesh{};
    double error = 0;  ///< distance to the original as the quadrics estimate it, scene units
};

namespace detail {

/// Numbers vertices that agree in every attribute and in the material of their face.
struct unique_corners {
    std::vector<unsigned int> corner{};     ///< its vertex, three rows a face
    std::vector<unsigned int> vertex_of{};  ///< of the mesh, for each unique vertex
    std::vector<material_id> material{};    ///< of each unique vertex; empty: the mesh has none
    std::vector<vec3> positions{};
};

[[nodiscard]] inline unique_corners find_unique_corners(const mesh& m) {
    std::vector<unsigned int> old_vertex;
    std::vector<material_id> material;
    for (face_id face = 0; face < m.face_count(); ++face) {
        for (int k = 0; k < 3; ++k) old_vertex.push_back(m.triangles[face][k]);
        if (!m.face_materials.empty()) material.insert(material.end(), 3, m.face_materials[face]);
    }
    mesh unfolded;  // a row a corner, since meshoptimizer compares rows of equal length
    for_each_vertex_column(m, unfolded, [&](const auto& from, auto& to) {
        if (from.empty()) return;
        for (const unsigned int v : old_vertex) to.push_back(from[v]);
    });
    std::vector<meshopt_Stream> streams;
    const auto add_stream = [&](const auto& column) {
        if (column.empty()) return;
        streams.push_back({column.data(), sizeof column[0], sizeof column[0]});
    };
    for_each_vertex_column(unfolded, unfolded,
                           [&](const auto& column, const auto&) { add_stream(column); });
    add_stream(material);

    unique_corners result;
    result.corner.resize(old_vertex.size());
    const std::size_t count =
        meshopt_generateVertexRemapMulti(result.corner.data(), nullptr, old_vertex.size(),
                                         old_vertex.size(), streams.data(), streams.size());
    result.vertex_of.resize(count);
    result.positions.resize(count);
    if (!material.empty()) result.material.resize(count);
    for (std::size_t i = 0; i < old_vertex.size(); ++i) {
        const unsigned int vertex = result.corner[i];
        result.vertex_of[vertex] = old_vertex[i];
        result.positions[vertex] = m.positions[old_vertex[i]];
        if (!material.empty()) result.material[vertex] = material[i];
    }
    return result;
}

/// The faces that meshoptimizer kept, with the attributes of their vertices.
[[nodiscard]] inline mesh mesh_of_kept(const mesh& m, const unique_corners& corners,
                                       const std::vector<unsigned int>& kept) {
    mesh reduced;
    reduced.materials = m.materials;
    reduced.images = m.images;
    for_each_vertex_column(m, reduced, [&](const auto& from, auto& to) {
        if (from.empty()) return;
        for (const unsigned int v : corners.vertex_of) to.push_back(from[v]);
    });
    for (std::size_t i = 0; i < kept.size(); i += 3) {
        reduced.triangles.emplace_back(kept[i], kept[i + 1], kept[i + 2]);
        if (!corners.material.empty()) {
            reduced.face_materials.push_back(corners.material[kept[i]]);
        }
    }
    std::vector<face_id> all(reduced.face_count());
    for (face_id face = 0; face < all.size(); ++face) all[face] = face;
    return select_faces(reduced, all);
}

[[nodiscard]] inline std::size_t share_of_faces(const mesh& m, double share) noexcept {
    return static_cast<std::size_t>(share * static_cast<double>(m.face_count()) + 0.5);
}

/// meshopt_simplifySloppy, which takes locks of vertices, too, in later releases.
template <class Index>
[[nodiscard]] std::size_t simplify_sloppily(Index* to, const Index* corners, std::size_t count,
                                            const float* positions, std::size_t vertex_count,
                                            std::size_t target, float& error) {
    constexpr bool is_without_locks = requires {
        meshopt_simplifySloppy(to, corners, count, positions, vertex_count, sizeof(vec3), target,
                               1.0f, &error);
    };
    if constexpr (is_without_locks) {
        return meshopt_simplifySloppy(to, corners, count, positions, vertex_count, sizeof(vec3),
                                      target, 1.0f, &error);
    } else {
        return meshopt_simplifySloppy(to, corners, count, positions, vertex_count, sizeof(vec3),
                                      nullptr, target, 1.0f, &error);
    }
}

}  // namespace detail

/// Collapses edges until about a share of the triangles is left. Vertices are chosen among those of
/// `m`, never moved, so their attributes stay true; seams of normals, uvs and materials stay closed.
///
/// Unit    share of the triangles, (0, 1]; max_error in scene units.
/// Needs   indices within bounds.
/// Gives   more triangles than asked for where seams and borders hold it back: a surface whose every
///         triangle has a normal of its own cannot be reduced, and below what the shape needs only
///         max_error keeps branches from being cut off.
/// Cost    O(faces log faces).
[[nodiscard]] inline reduced_mesh reduce_mesh(
    const mesh& m, double share, double max_error = std::numeric_limits<double>::infinity()) {
    BILLOW_ASSERT(share > 0 && share <= 1 && max_error > 0);
    if (m.face_count() == 0 || share == 1) return {m, 0};
    const detail::unique_corners corners = detail::find_unique_corners(m);
    const float* positions = &corners.positions[0].x;
    const std::size_t vertex_count = corners.positions.size();
    const std::size_t target = detail::share_of_faces(m, share);
    std::vector<unsigned int> kept(corners.corner.size());
    const auto scale =
        static_cast<double>(meshopt_simplifyScale(positions, vertex_count, sizeof(vec3)));
    float error = 0;
    kept.resize(meshopt_simplify(kept.data(), corners.corner.data(), corners.corner.size(),
                                 positions, vertex_count, sizeof(vec3), 3 * target,
                                 static_cast<float>(std::min(1.0, max_error / scale)), 0, &error));
    return {detail::mesh_of_kept(m, corners, kept), static_cast<double>(error) * scale};
}

/// Merges vertices within cells of a grid, whatever that tears or joins, until at most about a share
/// of the triangles is left. It goes where reduce_mesh cannot: leaves and other loose parts merge,
/// too. A face keeps the material that its first corner had.
///
/// Unit    share of the triangles, (0, 1].
/// Needs   indices within bounds.
/// Gives   often fewer triangles than asked for, down to none: faces within a cell vanish.
/// Cost    O(faces).
/// Source  J. Rossignac, P. Borrel: Multi-resolution 3D approximations for rendering complex scenes.
///         Modeling in Computer Graphics 1993, which meshoptimizer's simplifySloppy builds upon.
[[nodiscard]] inline reduced_mesh reduce_mesh_sloppily(const mesh& m, double share) {
    BILLOW_ASSERT(share > 0 && share <= 1);
    if (m.face_count() == 0 || share == 1) return {m, 0};
    const detail::unique_corners corners = detail::find_unique_corners(m);
    const float* positions = &corners.positions[0].x;
    const std::size_t vertex_count = corners.positions.size();
    std::vector<unsigned int> kept(corners.corner.size());
    float error = 0;
    kept.resize(detail::simplify_sloppily(kept.data(), corners.corner.data(), corners.corner.size(),
                                          positions, vertex_count,
                                          3 * detail::share_of_faces(m, share), error));
    const auto scale =
        static_cast<double>(meshopt_simplifyScale(positions, vertex_count, sizeof(vec3)));
    return {detail::mesh_of_kept(m, corners, kept), static_cast<double>(error) * scale};
}

}  // namespace billow::inline BILLOW_ABI
