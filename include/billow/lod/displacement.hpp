// Where a level of detail draws each corner of the original mesh, composed through the levels that it
// was made of, and how many planes two levels share.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <billow/metrics/displacement.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

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

}  // namespace detail

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
