// Vertex welding during the search: the vertices of the faces that a plane takes move onto it, and
// the faces around them are searched as they are then.
//
// A. Fuhrmann, E. Umlauf, S. Mantler: Extreme model simplification for forest rendering. Eurographics
// Workshop on Natural Phenomena 2005, section 3.3.4.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <billow/geometry/frame.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/vertex_identity.hpp>
#include <billow/search/face_sets.hpp>
#include <billow/search/motion.hpp>
#include <billow/search/weld_planes.hpp>

namespace billow::inline BILLOW_ABI {

/// Moves vertices onto the planes that take their faces, by at most epsilon from where they were.
///
/// Needs   a table whose faces ascend, as make_face_table gives it.
/// Gives   `options.kind` first: onto the first plane, as published. intersection: later planes move
///         the vertex within the ones that it lies on, if they meet within epsilon. The corners that
///         faces have in the mesh stay within epsilon of their planes, too.
/// Cost    O(corners of the faces that a plane takes and of their neighbours) a plane; 100 bytes a
///         face. A face enters the density once more each time a corner moves.
/// Source  Fuhrmann et al. 2005, section 3.3.4. Differs: intersection, after Luksch 2009, section
///         3.3; the area that a face grows to counts only up to that of the largest one.
class weld_online {
public:
    static constexpr bool is_still = false;

    explicit weld_online(const weld_options& options = {.kind = weld_kind::intersection})
        : options_(options) {
        BILLOW_ASSERT(options.kind != weld_kind::none);
    }

    void start(const face_table& faces, double epsilon) {
        // What floats round is left of epsilon.
        epsilon_ = epsilon;
        planes_.clear();
        max_displacement_ = 0.999 * epsilon;
        source_ = faces.source;
        row_of_face_.assign(source_.empty() ? 0 : std::size_t{source_.back()} + 1, no_id);
        for (std::uint32_t row = 0; row < source_.size(); ++row) row_of_face_[source_[row]] = row;
        largest_area_ = 0;
        for (const float area : faces.area) largest_area_ = std::max(largest_area_, double{area});
        least_area_ = degenerate_area_share * faces.bounds.radius * faces.bounds.radius;
        least_shift_ = 1e-7 * faces.bounds.radius;

        const vertex_identity vertices = position_ids(faces, options_.tolerance);
        vertices_.assign(vertices.count, {});
        corners_.resize(3 * source_.size());
        original_.resize(3 * source_.size());
        begin_.assign(vertices.count + 1, 0);
        for (std::size_t row = 0; row < source_.size(); ++row) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t id = vertices.id[k * source_.size() + row];
                corners_[3 * row + k] = id;
                original_[3 * row + k] = faces.corner[k].get(row);
                ++begin_[id + 1];
            }
        }
        for (std::size_t i = 0; i < vertices.count; ++i) begin_[i + 1] += begin_[i];
        rows_.resize(corners_.size());
        std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
        for (std::size_t i = corners_.size(); i-- > 0;) {
            vertices_[corners_[i]].original = original_[i];
        }
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            vertex& v = vertices_[corners_[i]];
            v.spread = std::max(v.spread, glm::distance(v.original, original_[i]));
            rows_[next[corners_[i]]++] = static_cast<std::uint32_t>(i / 3);
        }
        for (vertex& v : vertices_) v.position = v.original;
    }

    void keep_allowed(const face_table& faces, const plane& p, face_rows& rows) const noexcept {
        std::erase_if(rows, [&](std::uint32_t row) {
            const std::size_t first = 3 * std::size_t{row_of_face_[faces.source[row]]};
            for (std::size_t i = first; i < first + 3; ++i) {
                if (is_moved(i) && std::abs(signed_distance(p, original_[i])) > epsilon_) {
                    return true;
                }
            }
            return false;
        });
    }

    [[nodiscard]] face_rows plane_found(const face_table& faces, const plane& p,
                                        const face_table& remaining) {
        const auto id = static_cast<plane_id>(planes_.size());
        planes_.push_back(p);
        face_rows moving;
        for (std::size_t row = 0; row < faces.size; ++row) {
            const std::size_t first = 3 * std::size_t{row_of_face_[faces.source[row]]};
            for (std::size_t i = first; i < first + 3; ++i) {
                vertex& v = vertices_[corners_[i]];
                if (v.last_plane == id) continue;
                v.is_torn |= v.last_plane != no_id;
                v.last_plane = id;
                if (!v.planes.add(planes_, id, options_)) continue;
                const dvec3 before = v.position;
                v.position = v.planes.nearest(planes_, v.original, max_displacement_ - v.spread);
                if (glm::distance(before, v.position) <= least_shift_) continue;
                add_rows_around(corners_[i], remaining, moving);
            }
        }
        std::sort(moving.begin(), moving.end());
        moving.erase(std::unique(moving.begin(), moving.end()), moving.end());
        return moving;
    }

    void move(face_table& remaining, const face_rows& rows) const noexcept {
        for (const std::uint32_t row : rows) {
            const std::array<dvec3, 3> corners = moved_corners(row_of_face_[remaining.source[row]]);
            const dvec3 cross = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
            const double area = glm::length(cross) / 2;
            if (area > least_area_) {
                remaining.set(row, corners, cross / (2 * area), std::min(area, largest_area_));
            } else {
                remaining.set(row, corners,
                              normal_of_line(corners, glm::normalize(remaining.normal.get(row))),
                              0);
            }
        }
    }

    /// Faces with a corner that lies on several planes.
    [[nodiscard]] std::vector<moved_face> moved_faces() const {
        std::vector<moved_face> moved;
        for (std::uint32_t row = 0; row < source_.size(); ++row) {
            bool is_torn = false;
            std::array<dvec3, 3> corners;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t i = 3 * std::size_t{row} + k;
                const bool moves = vertices_[corners_[i]].is_torn && is_moved(i);
                corners[k] = moves ? vertices_[corners_[i]].position : original_[i];
                is_torn |= moves;
            }
            if (is_torn) moved.push_back({source_[row], corners});
        }
        return moved;
    }

private:
    /// Vertices that are one.
    struct vertex {
        dvec3 original{0};
        dvec3 position{0};
        double spread = 0;  ///< of what the tolerance makes one
        weld_planes planes{};
        plane_id last_plane = no_id;
        bool is_torn = false;  ///< lies on several planes
    };

    [[nodiscard]] bool is_moved(std::size_t corner) const noexcept {
        const vertex& v = vertices_[corners_[corner]];
        return !v.planes.empty() && v.position != original_[corner];
    }
    [[nodiscard]] std::array<dvec3, 3> moved_corners(std::uint32_t row) const noexcept {
        std::array<dvec3, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = 3 * std::size_t{row} + k;
            corners[k] = is_moved(i) ? vertices_[corners_[i]].position : original_[i];
        }
        return corners;
    }

    void add_rows_around(std::uint32_t id, const face_table& remaining, face_rows& to) const {
        const auto begin = remaining.source.begin();
        const auto end = remaining.source.end();
        for (std::size_t i = begin_[id]; i < begin_[id + 1]; ++i) {
            const face_id face = source_[rows_[i]];
            const auto found = std::lower_bound(begin, end, face);
            if (found != end && *found == face) {
                to.push_back(static_cast<std::uint32_t>(found - begin));
            }
        }
    }

    /// A unit vector across the line that the corners lie on, as near to `wanted` as possible: a face
    /// without area lies in its supporting plane all the same.
    [[nodiscard]] static dvec3 normal_of_line(const std::array<dvec3, 3>& corners,
                                              const dvec3& wanted) noexcept {
        dvec3 line{0};
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec3 side = corners[(k + 1) % 3] - corners[k];
            if (glm::dot(side, side) > glm::dot(line, line)) line = side;
        }
        if (line == dvec3(0)) return wanted;
        line = glm::normalize(line);
        const dvec3 across = wanted - line * glm::dot(line, wanted);
        const double length = glm::length(across);
        return length > 1e-6 ? across / length : frame_around(line).u;
    }

    weld_options options_;
    double epsilon_ = 0;
    double max_displacement_ = 0;
    double largest_area_ = 0;
    double least_area_ = 0;
    double least_shift_ = 0;
    std::vector<plane> planes_{};
    std::vector<face_id> source_{};
    std::vector<std::uint32_t> row_of_face_{};
    std::vector<vertex> vertices_{};
    std::vector<std::uint32_t> corners_{};  ///< the vertex of corner k of row r at 3 r + k
    std::vector<dvec3> original_{};         ///< in the same order
    std::vector<std::size_t> begin_{};      ///< of a vertex, in rows_
    std::vector<std::uint32_t> rows_{};     ///< that a vertex is a corner of
};
static_assert(vertex_motion<weld_online>);

}  // namespace billow::inline BILLOW_ABI
