// How far a cloud is from its mesh, measured on the mesh's own vertices.
#pragma once

#include <algorithm>
#include <cmath>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// Errors of a cloud. Distances are in scene units.
struct cloud_errors {
    double max_error = 0;             ///< largest distance of a mapped vertex to its plane
    double mean_error = 0;            ///< mean over a face's corners, area-weighted over the faces
    double projected_area_share = 0;  ///< area-weighted mean |cos| between a face and its plane: 1
        ///< when every texture is seen frontally, 0.5 for random planes
    std::size_t mapped_faces = 0;
    std::size_t faces_beyond_epsilon = 0;  ///< mapped faces with a vertex farther than epsilon
    double area_beyond_epsilon_share = 0;  ///< their area, of that of all faces
    double dropped_area_share = 0;         ///< area of the faces without a plane, of that of all
    /// Area that the mapped faces have on their planes, of the billboards' area: how much of the
    /// textures shows something. Above 1 where faces lie over each other; 0 without billboards.
    double rectangle_use = 0;
};

/// Measures `cloud` against the mesh that it was made of, in double. Cost O(faces).
[[nodiscard]] inline cloud_errors measure_errors(const mesh& m, const billboard_cloud& cloud) {
    cloud_errors errors;
    double area_sum = 0;
    double dropped_area = 0;
    for (face_id face = 0; face < m.face_count(); ++face) {
        const plane_id id = cloud.plane_of_face[face];
        const auto [a, b, c] = m.corners(face);
        const dvec3 normal = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)) / 2.0;
        const double area = glm::length(normal);
        if (id == no_id) {
            dropped_area += area;
            continue;
        }
        ++errors.mapped_faces;
        const plane& p = cloud.planes[id];
        double largest = 0;
        double sum = 0;
        for (const vec3& corner : {a, b, c}) {
            const double distance =
                std::abs(signed_distance(p, dvec3(corner) - cloud.bounds.centre));
            largest = std::max(largest, distance);
            sum += distance;
        }
        errors.max_error = std::max(errors.max_error, largest);
        errors.mean_error += area * sum / 3;
        errors.projected_area_share += std::abs(glm::dot(p.normal, normal));
        if (largest > cloud.epsilon_of(id) * (1 + 1e-9)) {
            ++errors.faces_beyond_epsilon;
            errors.area_beyond_epsilon_share += area;
        }
        area_sum += area;
    }
    if (const double all = area_sum + dropped_area; all > 0) {
        errors.area_beyond_epsilon_share /= all;
        errors.dropped_area_share = dropped_area / all;
    }
    double rectangles = 0;
    for (const billboard& b : cloud.billboards) rectangles += b.width * b.height;
    if (rectangles > 0) errors.rectangle_use = errors.projected_area_share / rectangles;
    if (area_sum > 0) {
        errors.mean_error /= area_sum;
        errors.projected_area_share /= area_sum;
    }
    return errors;
}

}  // namespace billow::inline BILLOW_ABI
