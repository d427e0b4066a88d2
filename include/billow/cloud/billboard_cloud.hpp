// What a plane search finds: planes, the faces on each, and the rectangles that show them.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/geometry/plane.hpp>

namespace billow::inline BILLOW_ABI {

/// A textured rectangle on a plane.
///
/// Scene point of texture coordinate (s, t) in [0, 1]²:
/// origin + s·width·axes.u + t·height·axes.v. The front, which the texture is drawn from, is the
/// side that axes.normal points to.
struct billboard {
    dvec3 origin{0};        ///< corner of the rectangle with the least u and v, scene units
    frame axes{};           ///< u along the width, v along the height
    double width = 0;       ///< scene units, ≥ 0
    double height = 0;      ///< scene units, ≥ 0
    double depth_low = 0;   ///< least signed distance of a mapped vertex to the plane, along normal
    double depth_high = 0;  ///< greatest such distance
};

/// A face that is drawn on a plane although it is mapped to another one.
struct drawn_too {
    plane_id plane = no_id;
    face_id face = no_id;

    // NOLINTNEXTLINE(modernize-use-nullptr): the 0 is of the comparison that the compiler writes
    friend auto operator<=>(const drawn_too&, const drawn_too&) = default;
};

/// What planes share that were searched together: those of a trunk, or of its foliage. Faces of one
/// part are not drawn on the planes of another.
struct cloud_part {
    double epsilon = 0;  ///< the bound on the distance of a mapped vertex to its plane, scene units
};

/// A billboard cloud without its textures.
///
/// Shape  P planes; `billboards` and `part_of_plane` have one row a plane; `plane_of_face` one row a
///        face of the mesh.
/// Unit   planes are relative to bounds.centre: a scene point p lies on plane i when
///        planes[i].normal·(p - bounds.centre) = planes[i].rho. Billboards are in scene units.
struct billboard_cloud {
    bounding_sphere bounds{};
    double epsilon = 0;                     ///< the largest of the parts'
    std::vector<plane> planes{};            ///< in the order of discovery
    std::vector<plane_id> plane_of_face{};  ///< no_id: degenerate or skipped
    std::vector<billboard> billboards{};
    std::vector<drawn_too> also_drawn{};   ///< ascending; counts for a billboard's size
    std::vector<part_id> part_of_plane{};  ///< none: all planes are of one part
    std::vector<cloud_part> parts{};       ///< none: one part with `epsilon`

    [[nodiscard]] std::size_t plane_count() const noexcept { return planes.size(); }
    [[nodiscard]] part_id part_of(plane_id plane) const noexcept {
        return part_of_plane.empty() ? 0 : part_of_plane[plane];
    }
    /// The rows of also_drawn for a plane.
    [[nodiscard]] std::span<const drawn_too> also_drawn_on(plane_id plane) const noexcept {
        const auto is_before = [plane](const drawn_too& d) { return d.plane < plane; };
        const auto is_up_to = [plane](const drawn_too& d) { return d.plane <= plane; };
        const auto all = std::span(also_drawn);
        const auto begin = std::partition_point(all.begin(), all.end(), is_before);
        const auto end = std::partition_point(begin, all.end(), is_up_to);
        return all.subspan(static_cast<std::size_t>(begin - all.begin()),
                           static_cast<std::size_t>(end - begin));
    }
    /// The bound for the faces of a plane, scene units.
    [[nodiscard]] double epsilon_of(plane_id plane) const noexcept {
        return parts.empty() ? epsilon : parts[part_of(plane)].epsilon;
    }
};

/// The faces of each plane, in ascending order.
class faces_of_planes {
public:
    /// Needs plane_of_face values below plane_count, or no_id. Cost O(faces + planes).
    faces_of_planes(std::span<const plane_id> plane_of_face, std::size_t plane_count)
        : begin_(plane_count + 1, 0) {
        for (const plane_id plane : plane_of_face) {
            if (plane != no_id) ++begin_[plane + 1];
        }
        for (std::size_t i = 0; i < plane_count; ++i) begin_[i + 1] += begin_[i];
        faces_.resize(begin_.back());
        std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
        for (std::size_t face = 0; face < plane_of_face.size(); ++face) {
            if (const plane_id plane = plane_of_face[face]; plane != no_id) {
                faces_[next[plane]++] = static_cast<face_id>(face);
            }
        }
    }

    [[nodiscard]] std::span<const face_id> operator[](plane_id plane) const noexcept {
        return std::span(faces_).subspan(begin_[plane], begin_[plane + 1] - begin_[plane]);
    }

private:
    std::vector<std::size_t> begin_;
    std::vector<face_id> faces_;
};

}  // namespace billow::inline BILLOW_ABI
