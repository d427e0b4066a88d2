// The mesh that readers deliver, planes are searched in, textures are baked from and writers store.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/image/image.hpp>
#include <billow/mesh/material.hpp>

namespace billow::inline BILLOW_ABI {

inline constexpr std::size_t uv_set_count = 2;

/// An indexed triangle list in columns. Counter-clockwise triangles are seen from their front.
///
/// Shape  V vertices, F faces. Vertex columns hold V rows, or none where the mesh lacks the
///        attribute; face columns hold F rows.
/// Unit   positions in scene units, right-handed; colours linear.
struct mesh {
    std::vector<vec3> positions{};
    std::vector<vec3> normals{};   ///< unit length; none: every face is flat
    std::vector<vec4> tangents{};  ///< xyz unit length, w = ±1 the side of the bitangent
    std::array<std::vector<vec2>, uv_set_count> uv_sets{};
    std::vector<vec4> colors{};                ///< linear RGBA, multiplies the base colour
    std::vector<std::uint32_t> feature_ids{};  ///< of a cloud's vertices: the plane they lie on

    std::vector<uvec3> triangles{};
    std::vector<material_id> face_materials{};  ///< none: all faces use material 0

    std::vector<material> materials{};  ///< none: everything is white, rough and opaque
    std::vector<image> images{};

    [[nodiscard]] std::size_t vertex_count() const noexcept { return positions.size(); }
    [[nodiscard]] std::size_t face_count() const noexcept { return triangles.size(); }

    /// The three corners of a face.
    [[nodiscard]] std::array<vec3, 3> corners(face_id face) const noexcept {
        const uvec3 t = triangles[face];
        return {positions[t.x], positions[t.y], positions[t.z]};
    }

    /// The material of a face; a plain white one where the mesh has none.
    [[nodiscard]] const material& material_of(face_id face) const noexcept {
        static const material plain{.metallic = 0};
        const material_id id = face_materials.empty() ? 0 : face_materials[face];
        return id < materials.size() ? materials[id] : plain;
    }
};

}  // namespace billow::inline BILLOW_ABI
