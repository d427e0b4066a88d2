// Keeps the triangles of a billboard together when a cloud's mesh is what the next planes are
// searched for.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <billow/mesh/mesh.hpp>
#include <billow/search/motion.hpp>

namespace billow::inline BILLOW_ABI {

/// The billboard of each face of a cloud's mesh, which are its feature ids.
[[nodiscard]] inline std::vector<plane_id> billboards_of_faces(const mesh& cloud) {
    std::vector<plane_id> billboards;
    billboards.reserve(cloud.face_count());
    for (const uvec3& triangle : cloud.triangles) {
        billboards.push_back(cloud.feature_ids[triangle.x]);
    }
    return billboards;
}

/// Vertices stay; a plane takes all triangles of a billboard or none. Those that are left of one
/// after its others have gone, or had no area, count as the whole of it.
class whole_billboards : public fixed_vertices {
public:
    whole_billboards() = default;
    /// Needs  triangles of a billboard one after the other, as cloud_mesh lays them.
    explicit whole_billboards(std::vector<plane_id> billboard_of_face)
        : billboard_of_face_(std::move(billboard_of_face)) {}

    /// Needs  rows of `faces` in the order of the mesh, as the search keeps them.
    void keep_allowed(const face_table& faces, const plane&, face_rows& rows) const {
        const auto billboard_of = [&](std::size_t row) {
            return billboard_of_face_[faces.source[row]];
        };
        std::size_t kept = 0;
        for (std::size_t begin = 0; begin < rows.size();) {
            const plane_id billboard = billboard_of(rows[begin]);
            std::size_t end = begin + 1;
            while (end < rows.size() && billboard_of(rows[end]) == billboard) ++end;
            const std::uint32_t first = rows[begin];
            const std::uint32_t last = rows[end - 1];
            const bool is_whole = last - first == end - 1 - begin &&
                                  (first == 0 || billboard_of(first - 1) != billboard) &&
                                  (last + 1 == faces.size || billboard_of(last + 1) != billboard);
            for (; begin < end; ++begin) {
                if (is_whole) rows[kept++] = rows[begin];
            }
        }
        rows.resize(kept);
    }

private:
    std::vector<plane_id> billboard_of_face_{};
};
static_assert(vertex_motion<whole_billboards>);

}  // namespace billow::inline BILLOW_ABI
