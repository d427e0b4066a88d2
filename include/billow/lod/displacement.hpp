// Where a level of detail draws each corner of the original mesh, composed through the levels that it
// was made of, and how far that is from elsewhere.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/types.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/search/motion.hpp>

namespace billow::inline BILLOW_ABI {

/// The faces of the original mesh as a level draws them.
///
/// Shape  one row a face of the original mesh.
/// Unit   scene units.
struct drawn_faces {
    std::vector<plane_id> plane_of_face{};  ///< of the level's cloud; no_id: not drawn
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

/// Of the planes of a billboard's triangles the one that is farthest from a face. A search with
/// leftovers may part the triangles, and then any of those planes may show the face.
[[nodiscard]] inline plane_id farthest_plane(const billboard_cloud& cloud,
                                             std::span<const face_id> triangles,
                                             const std::array<dvec3, 3>& corners) noexcept {
    plane_id farthest = no_id;
    double most = -1;
    for (const face_id triangle : triangles) {
        const plane_id plane = cloud.plane_of_face[triangle];
        if (plane == no_id || plane == farthest) continue;
        double distance = 0;
        for (const dvec3& corner : corners) {
            distance = std::max(distance, glm::distance(corner, foot_on(cloud, plane, corner)));
        }
        if (distance > most) most = distance, farthest = plane;
    }
    return farthest;
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

/// Where a cloud of the billboards of the level `above` draws the faces. Needs the billboard of each
/// face that the cloud was made of.
[[nodiscard]] inline drawn_faces drawn_through(const billboard_cloud& cloud,
                                               std::span<const plane_id> billboard_of_face,
                                               std::size_t billboard_count,
                                               const drawn_faces& above) {
    const faces_of_planes triangles(billboard_of_face, billboard_count);
    return detail::drawn_on(cloud, above, [&](face_id face) {
        const plane_id billboard = above.plane_of_face[face];
        if (billboard == no_id) return no_id;
        return detail::farthest_plane(cloud, triangles[billboard], above.corners[face]);
    });
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

/// Share of the planes of `coarse` that are nearly planes of `fine`: angle between the normals at most
/// `max_angle_rad`, and of `fine` the centre of a billboard no farther from the plane than
/// `max_distance`. 0 without planes.
[[nodiscard]] inline double share_of_kept_planes(const billboard_cloud& coarse,
                                                 const billboard_cloud& fine, double max_angle_rad,
                                                 double max_distance) {
    const double least_cosine = std::cos(max_angle_rad);
    std::size_t kept = 0;
    for (const plane& p : coarse.planes) {
        for (plane_id id = 0; id < fine.plane_count(); ++id) {
            const billboard& b = fine.billboards[id];
            const dvec3 centre = b.origin + b.axes.u * (b.width / 2) + b.axes.v * (b.height / 2);
            if (std::abs(glm::dot(p.normal, fine.planes[id].normal)) >= least_cosine &&
                std::abs(signed_distance(p, centre - coarse.bounds.centre)) <= max_distance) {
                ++kept;
                break;
            }
        }
    }
    return coarse.planes.empty()
               ? 0
               : static_cast<double>(kept) / static_cast<double>(coarse.plane_count());
}

}  // namespace billow::inline BILLOW_ABI
