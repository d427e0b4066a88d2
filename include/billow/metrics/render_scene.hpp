// A mesh made ready for many views.
#pragma once

#include <array>
#include <cstddef>

#include <billow/bake/surface.hpp>
#include <billow/core/simd.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// The corners of a mesh in columns, and its textures with their mip chains.
///
/// Shape  `corner`: a row a face of the mesh, padded to the widest lane with zeros.
/// Unit   scene units, relative to bounds.centre.
/// Needs  indices within bounds, finite positions; the mesh outlives it.
struct render_scene {
    explicit render_scene(const mesh& source, bool culls_backs = false)
        : is_culled(culls_backs),
          bounds(bounding_sphere_of(
              source.face_count() * 3,
              [&](std::size_t i) {
                  return source.positions[source.triangles[i / 3][static_cast<int>(i % 3)]];
              })),
          look(source) {
        for (columns3& column : corner) column.resize(simd::padded(source.face_count()));
        for (face_id face = 0; face < source.face_count(); ++face) {
            const std::array<vec3, 3> at = source.corners(face);
            for (std::size_t k = 0; k < 3; ++k) {
                corner[k].set(face, dvec3(at[k]) - bounds.centre);
            }
        }
    }

    [[nodiscard]] std::size_t face_count() const noexcept { return look.source().face_count(); }

    bool is_culled;  ///< backs of faces whose material is not double-sided are not drawn
    bounding_sphere bounds;
    std::array<columns3, 3> corner{};
    surface look;
};

}  // namespace billow::inline BILLOW_ABI
