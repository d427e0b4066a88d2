// Vertex welding after the search: vertices that planes tear apart move to where those planes meet.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
// section 3.3.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/cloud/cracks.hpp>
#include <billow/improve/drawn_mesh.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/vertex_identity.hpp>
#include <billow/search/motion.hpp>
#include <billow/search/weld_planes.hpp>

namespace billow::inline BILLOW_ABI {

/// What welding did.
struct weld_statistics {
    std::size_t torn_vertices = 0;    ///< on several planes of a part
    std::size_t moved_vertices = 0;   ///< of those
    std::size_t welded_vertices = 0;  ///< of those, on all of their planes now
    double largest_displacement = 0;  ///< scene units
};

/// The faces that welding moves, by face, around cloud.bounds.centre.
struct welded_faces {
    std::vector<moved_face> moved{};
    weld_statistics statistics{};
};

namespace detail {

/// One call of weld_faces.
class welder {
public:
    welder(const mesh& source, const billboard_cloud& cloud, std::span<const weld_options> of_parts)
        : source_(source), cloud_(cloud), of_parts_(of_parts) {}

    [[nodiscard]] welded_faces run() {
        double tolerance = 0;
        bool is_asked = false;
        for (const weld_options& options : of_parts_) {
            tolerance = std::max(tolerance, options.tolerance);
            is_asked |= options.kind != weld_kind::none;
        }
        if (!is_asked) return {};
        sort_corners(position_ids(source_, tolerance));
        for (std::size_t begin = 0, end = 0; begin < corners_.size(); begin = end) {
            while (end < corners_.size() && is_one(corners_[begin], corners_[end])) ++end;
            weld(std::span(corners_).subspan(begin, end - begin));
        }
        collect();
        return std::move(result_);
    }

private:
    /// A corner of a face: of one vertex, drawn on one plane.
    struct corner {
        std::uint32_t vertex = 0;
        part_id part = 0;
        plane_id plane = 0;
        std::size_t place = 0;  ///< 3 · face + k
    };
    struct welded_corner {
        std::size_t place = 0;
        dvec3 position{0};
    };

    [[nodiscard]] static bool is_one(const corner& a, const corner& b) noexcept {
        return a.vertex == b.vertex && a.part == b.part;
    }
    [[nodiscard]] const weld_options& options_of(part_id part) const noexcept {
        return of_parts_[of_parts_.size() == 1 ? 0 : part];
    }
    /// Around cloud.bounds.centre.
    [[nodiscard]] dvec3 position_of(std::size_t place) const noexcept {
        const uvec3 t = source_.triangles[place / 3];
        return dvec3(source_.positions[t[static_cast<glm::length_t>(place % 3)]]) -
               cloud_.bounds.centre;
    }

    /// By vertex, part and plane; planes are in the order of discovery.
    void sort_corners(const vertex_identity& vertices) {
        corners_.reserve(3 * source_.face_count());
        for (std::size_t place = 0; place < 3 * source_.face_count(); ++place) {
            const plane_id on = cloud_.plane_of_face[place / 3];
            if (on == no_id || options_of(cloud_.part_of(on)).kind == weld_kind::none) continue;
            const uvec3 t = source_.triangles[place / 3];
            corners_.push_back({vertices.id[t[static_cast<glm::length_t>(place % 3)]],
                                cloud_.part_of(on), on, place});
        }
        std::sort(corners_.begin(), corners_.end(), [](const corner& a, const corner& b) {
            return std::tie(a.vertex, a.part, a.plane, a.place) <
                   std::tie(b.vertex, b.part, b.plane, b.place);
        });
    }

    /// Moves the vertex that all of `corners` are.
    void weld(std::span<const corner> corners) {
        if (corners.front().plane == corners.back().plane) return;
        ++result_.statistics.torn_vertices;
        const weld_options& options = options_of(corners.front().part);
        const dvec3 vertex = position_of(corners.front().place);
        double spread = 0;  // of what the tolerance makes one
        weld_planes planes;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            spread = std::max(spread, glm::distance(vertex, position_of(corners[i].place)));
            if (i == 0 || corners[i].plane != corners[i - 1].plane) {
                planes.add(cloud_.planes, corners[i].plane, options);
            }
        }
        const double epsilon = cloud_.epsilon_of(corners.front().plane);
        const dvec3 at = planes.nearest(cloud_.planes, vertex, epsilon - spread);
        if (at == vertex && spread == 0) return;
        ++result_.statistics.moved_vertices;
        double off = 0;
        for (const corner& c : corners) {
            off = std::max(off, std::abs(signed_distance(cloud_.planes[c.plane], at)));
            welded_.push_back({c.place, at});
            result_.statistics.largest_displacement = std::max(
                result_.statistics.largest_displacement, glm::distance(at, position_of(c.place)));
        }
        if (off <= 1e-9 * cloud_.bounds.radius) ++result_.statistics.welded_vertices;
    }

    /// Makes faces of the welded corners.
    void collect() {
        std::sort(welded_.begin(), welded_.end(),
                  [](const auto& a, const auto& b) { return a.place < b.place; });
        for (const welded_corner& w : welded_) {
            const auto face = static_cast<face_id>(w.place / 3);
            if (result_.moved.empty() || result_.moved.back().face != face) {
                const std::size_t first = w.place - w.place % 3;
                result_.moved.push_back(
                    {face, {position_of(first), position_of(first + 1), position_of(first + 2)}});
            }
            result_.moved.back().corners[w.place % 3] = w.position;
        }
    }

    const mesh& source_;
    const billboard_cloud& cloud_;
    std::span<const weld_options> of_parts_;
    std::vector<corner> corners_{};
    std::vector<welded_corner> welded_{};
    welded_faces result_{};
};

}  // namespace detail

/// Moves every vertex whose faces lie on several planes onto those planes, as far as that is possible
/// within epsilon. The faces keep their planes.
///
/// Shape   `of_parts`: one row a part of the cloud, or one for all. Parts are welded apart.
/// Unit    positions around cloud.bounds.centre.
/// Needs   one row of plane_of_face a face of `source`.
/// Gives   faces with a moved corner. No corner moves by more than the epsilon of its part; corners
///         of faces without a plane stay.
/// Cost    O(faces log faces).
/// Source  Luksch 2009, section 3.3; weld_kind::first is its variant of Fuhrmann et al. 2005.
///         Differs: planes that do not meet within epsilon are tried in pairs, and see
///         weld_planes::nearest for pairs that do not.
[[nodiscard]] inline welded_faces weld_faces(const mesh& source, const billboard_cloud& cloud,
                                             std::span<const weld_options> of_parts) {
    BILLOW_ASSERT(cloud.plane_of_face.size() == source.face_count());
    BILLOW_ASSERT(of_parts.size() == 1 || of_parts.size() == cloud.parts.size());
    return detail::welder(source, cloud, of_parts).run();
}

/// A mesh to draw instead of the source, and what was done to it.
struct welded_mesh {
    mesh drawn{};
    weld_statistics statistics{};
    cloud_cracks before{};
    cloud_cracks after{};
};

/// Welds, and measures what that helps. The result is drawn instead of `source`:
/// `fit_billboards(drawn, cloud); bake_cloud(drawn, *make_face_table(drawn), cloud)`.
///
/// Shape, Needs, Cost  as weld_faces, drawn_mesh and measure_cracks.
[[nodiscard]] inline welded_mesh weld_vertices(const mesh& source, const billboard_cloud& cloud,
                                               const weld_options& options) {
    const welded_faces welded = weld_faces(source, cloud, std::span(&options, 1));
    welded_mesh result{drawn_mesh(source, cloud, welded.moved), welded.statistics, {}, {}};
    result.before = measure_cracks(source, cloud, source, options.tolerance);
    result.after = measure_cracks(source, cloud, result.drawn, options.tolerance);
    return result;
}

}  // namespace billow::inline BILLOW_ABI
