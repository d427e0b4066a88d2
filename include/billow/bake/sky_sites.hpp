// Where light is measured: a leaf as a whole, everything else vertex by vertex.
//
// Fuhrmann et al.: Extreme model simplification for forest rendering. Eurographics Workshop on
// Natural Phenomena 2005, section 3.3.9: one value a leaf.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/mesh/components.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/vertex_identity.hpp>

namespace billow::inline BILLOW_ABI {

using site_id = std::uint32_t;

/// Rows of a face table that are measured together.
struct sky_patch {
    std::uint32_t first = 0;  ///< of sky_sites::rows
    std::uint32_t count = 0;
    bool is_leaf = false;  ///< all corners are one site; else a single face, a site a corner
    int rays = 0;
};

/// Shape  `of_face`: the sites of each face's corners. `rows`: those of the table, patch by patch.
struct sky_sites {
    std::vector<uvec3> of_face{};
    std::vector<std::uint32_t> rows{};
    std::vector<sky_patch> patches{};
    std::size_t count = 0;  ///< site 0 is that of faces without area
};

/// Whether a material is that of leaves, which light passes to both sides.
[[nodiscard]] inline bool is_foliage(const material& look) noexcept {
    return look.alpha != alpha_mode::opaque;
}

namespace detail {

/// The corners at one place whose normals are alike share a site.
class corner_sites {
public:
    corner_sites(std::size_t places, site_id first) : newest_(places, no_id), next_(first) {}

    [[nodiscard]] site_id of(std::uint32_t place, const vec3& normal) {
        constexpr float alike = 0.9f;  // 26°: an edge to be seen stays one
        for (std::uint32_t i = newest_[place]; i != no_id; i = entries_[i].before) {
            if (glm::dot(entries_[i].normal, normal) >= alike) return entries_[i].site;
        }
        const auto id = static_cast<std::uint32_t>(entries_.size());
        entries_.push_back({normal, next_, std::exchange(newest_[place], id)});
        return next_++;
    }
    [[nodiscard]] site_id end() const noexcept { return next_; }

private:
    struct entry {
        vec3 normal;
        site_id site;
        std::uint32_t before;
    };
    std::vector<entry> entries_{};
    std::vector<std::uint32_t> newest_;
    site_id next_;
};

}  // namespace detail

/// Finds the sites of a mesh. A connected component of foliage or of a double-sided material is a
/// leaf where its diameter is at most `leaf_extent`; otherwise the corners of faces are measured,
/// those at one place with normals alike together.
///
/// Unit   leaf_extent in scene units.      Needs  `faces` is the table of `m`; rays ≥ 1.
/// Gives  patches of about `rays` rays a site, so that a mesh costs by its leaves and vertices.
/// Cost   O(faces).
[[nodiscard]] inline sky_sites find_sky_sites(const mesh& m, const face_table& faces,
                                              double leaf_extent, int rays) {
    const mesh_components pieces = find_components(m);
    const vertex_identity places = position_ids(m);
    const std::size_t component_count = pieces.components.size();
    std::vector<char> is_leaf(component_count, 1);
    for (std::size_t i = 0; i < component_count; ++i) {
        is_leaf[i] = pieces.components[i].diameter <= leaf_extent ? 1 : 0;
    }
    for (face_id face = 0; face < m.face_count(); ++face) {
        const material& look = m.material_of(face);
        if (!is_foliage(look) && !look.is_double_sided) is_leaf[pieces.of_face[face]] = 0;
    }

    sky_sites sites;
    sites.of_face.assign(m.face_count(), uvec3(0));
    std::vector<std::uint32_t> rows_of_leaf(component_count, 0);
    for (const face_id face : faces.source) ++rows_of_leaf[pieces.of_face[face]];
    std::vector<site_id> site_of_leaf(component_count, 0);
    std::vector<std::uint32_t> next_row(component_count, 0);
    site_id next_site = 1;
    std::uint32_t filled = 0;
    for (std::size_t i = 0; i < component_count; ++i) {
        if (is_leaf[i] == 0 || rows_of_leaf[i] == 0) continue;
        site_of_leaf[i] = next_site++;
        sites.patches.push_back({filled, rows_of_leaf[i], true, rays});
        next_row[i] = std::exchange(filled, filled + rows_of_leaf[i]);
    }
    sites.rows.resize(faces.size);
    detail::corner_sites corners(places.count, next_site);
    for (std::uint32_t row = 0; row < faces.size; ++row) {
        const face_id face = faces.source[row];
        const std::uint32_t component = pieces.of_face[face];
        if (is_leaf[component] != 0) {
            sites.of_face[face] = uvec3(site_of_leaf[component]);
            sites.rows[next_row[component]++] = row;
            continue;
        }
        const vec3 flat(faces.normal.get(row));
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t vertex = m.triangles[face][k];
            const vec3& normal = m.normals.empty() ? flat : m.normals[vertex];
            sites.of_face[face][k] = corners.of(places.id[vertex], normal);
        }
        sites.patches.push_back({filled, 1, false, rays});
        sites.rows[filled++] = row;
    }
    sites.count = corners.end();

    // A corner gets a third of the rays of each face around it.
    std::vector<int> faces_at(sites.count, 0);
    for (const uvec3& face : sites.of_face) {
        for (int k = 0; k < 3; ++k) ++faces_at[face[k]];
    }
    for (sky_patch& patch : sites.patches) {
        if (patch.is_leaf) continue;
        const uvec3 at = sites.of_face[faces.source[sites.rows[patch.first]]];
        const int fewest = std::min({faces_at[at.x], faces_at[at.y], faces_at[at.z]});
        patch.rays = std::clamp((3 * rays + fewest - 1) / fewest, 1, rays);
    }
    return sites;
}

}  // namespace billow::inline BILLOW_ABI
