// Where a cloud draws each corner of its mesh, and how far that is from elsewhere.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/types.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/search/motion.hpp>

namespace billow::inline BILLOW_ABI {

/// The faces of a mesh as a cloud draws them.
///
/// Shape  one row a face of the mesh.
/// Unit   scene units.
struct drawn_faces {
    std::vector<plane_id> plane_of_face{};  ///< of the cloud; no_id: not drawn
    std::vector<std::array<dvec3, 3>> corners{};
};

/// The mesh as it is, on no plane.
[[nodiscard]] inline drawn_faces undisplaced(const mesh& original) {
    drawn_faces result;
    result.plane_of_face.assign(original.face_count(), no_id);
    result.corners.reserve(original.face_count());
    for (face_id face = 0; face < original.face_count(); ++face) {
        const auto [a, b, c] = original.corners(face);
        result.corners.push_back({dvec3(a), dvec3(b), dvec3(c)});
    }
    return result;
}

namespace detail {

/// The foot of the perpendicular from `point` on a plane of the cloud.
[[nodiscard]] inline dvec3 foot_on(const billboard_cloud& cloud, plane_id plane,
                                   const dvec3& point) noexcept {
    const auto& p = cloud.planes[plane];
    return point - p.normal * signed_distance(p, point - cloud.bounds.centre);
}

template <class PlaneOf>
[[nodiscard]] drawn_faces drawn_on(const billboard_cloud& cloud, const drawn_faces& before,
                                   const PlaneOf& plane_of) {
    drawn_faces faces = before;
    for (face_id face = 0; face < faces.corners.size(); ++face) {
        const plane_id plane = plane_of(face);
        faces.plane_of_face[face] = plane;
        if (plane == no_id) continue;
        for (dvec3& corner : faces.corners[face]) corner = foot_on(cloud, plane, corner);
    }
    return faces;
}

}  // namespace detail

/// Where a cloud of the mesh itself draws the faces, of which some corners have `moved` around the
/// cloud's centre before. Needs the original's `undisplaced` faces.
[[nodiscard]] inline drawn_faces drawn_by(const billboard_cloud& cloud, const drawn_faces& original,
                                          std::span<const moved_face> moved = {}) {
    drawn_faces drawn =
        detail::drawn_on(cloud, original, [&](face_id face) { return cloud.plane_of_face[face]; });
    for (const moved_face& m : moved) {
        const plane_id plane = cloud.plane_of_face[m.face];
        if (plane == no_id) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            drawn.corners[m.face][k] =
                detail::foot_on(cloud, plane, m.corners[k] + cloud.bounds.centre);
        }
    }
    return drawn;
}

/// Distances between two drawings of the same faces, scene units.
struct displacement {
    double max = 0;   ///< of any corner; the faces' inner points stay below, being drawn affinely
    double mean = 0;  ///< over a face's corners, area-weighted over the faces
    std::size_t faces = 0;  ///< that the second drawing shows
};

/// How far the faces of `original` move from one drawing to the other, over those that `to` shows.
/// Cost O(faces).
[[nodiscard]] inline displacement displacement_between(const mesh& original,
                                                       const drawn_faces& from,
                                                       const drawn_faces& to) {
    displacement result;
    double area_sum = 0;
    for (face_id face = 0; face < original.face_count(); ++face) {
        if (to.plane_of_face[face] == no_id) continue;
        ++result.faces;
        const auto [a, b, c] = original.corners(face);
        const double area = glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a))) / 2;
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double moved = glm::distance(from.corners[face][k], to.corners[face][k]);
            result.max = std::max(result.max, moved);
            sum += moved;
        }
        result.mean += area * sum / 3;
        area_sum += area;
    }
    if (area_sum > 0) result.mean /= area_sum;
    return result;
}

}  // namespace billow::inline BILLOW_ABI
