// The door that a mesh of unknown origin passes before anything trusts it.
#pragma once

#include <atomic>
#include <cmath>
#include <string>

#include <billow/core/expected.hpp>
#include <billow/core/parallel.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// Checks that every corner of every face exists and is finite, and that columns have their rows.
///
/// Fails   out_of_range: a corner, or a column of the wrong length; not_finite: a position. The
///         message names the first such face. Degenerate faces are fine, so is a mesh of none.
/// Cost    O(faces), parallel.
[[nodiscard]] inline expected<done> validate(const mesh& m, const parallel& threads = {}) {
    const std::size_t vertex_count = m.vertex_count();
    const auto has_rows = [](const auto& column, std::size_t rows) {
        return column.empty() || column.size() == rows;
    };
    if (!has_rows(m.normals, vertex_count) || !has_rows(m.tangents, vertex_count) ||
        !has_rows(m.uv_sets[0], vertex_count) || !has_rows(m.uv_sets[1], vertex_count) ||
        !has_rows(m.colors, vertex_count) || !has_rows(m.feature_ids, vertex_count)) {
        return error{error_code::out_of_range, "a vertex attribute has not one value a vertex"};
    }
    if (!has_rows(m.face_materials, m.face_count())) {
        return error{error_code::out_of_range, "there is not one material id a face"};
    }
    if (m.face_count() >= no_id || vertex_count >= no_id) {
        return error{error_code::too_large, "more than 2^32 - 2 faces or vertices"};
    }

    const auto is_out_of_range = [&](std::size_t face) {
        const uvec3 t = m.triangles[face];
        return t.x >= vertex_count || t.y >= vertex_count || t.z >= vertex_count;
    };
    const auto is_bad = [&](std::size_t face) {
        if (is_out_of_range(face)) return true;
        for (const vec3& p : m.corners(static_cast<face_id>(face))) {
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return true;
        }
        return false;
    };

    std::atomic<std::size_t> first_bad{m.face_count()};
    threads.for_chunks(m.face_count(), 1 << 15, [&](std::size_t begin, std::size_t end) {
        for (std::size_t face = begin; face < end; ++face) {
            if (!is_bad(face)) continue;
            std::size_t known = first_bad.load();
            while (face < known && !first_bad.compare_exchange_weak(known, face)) {
            }
            return;
        }
    });

    const std::size_t face = first_bad.load();
    if (face == m.face_count()) return done{};
    if (is_out_of_range(face)) {
        return error{error_code::out_of_range, "face " + std::to_string(face) +
                                                   " has a corner beyond the last of " +
                                                   std::to_string(vertex_count) + " vertices"};
    }
    return error{error_code::not_finite,
                 "face " + std::to_string(face) + " has a position that is NaN or infinite"};
}

}  // namespace billow::inline BILLOW_ABI
