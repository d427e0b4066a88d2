// What becomes of the faces that a search leaves when it stops before all of them have a plane.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 3.2.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>

namespace billow::inline BILLOW_ABI {

/// Which planes a skipped face may still join. The planes stay where they are.
struct skip_limits {
    double reach = 2;                ///< farthest corner of the face to the plane, epsilons, > 0
    double least_projection = 0.25;  ///< share of the face's area that the plane must show, [0, 1]:
                                     ///< less is a smear rather than a face
};

/// Distances of a face's three corners to a plane, in the unit of the table.
struct corner_distances {
    double largest = 0;
    double sum = 0;
};

[[nodiscard]] inline corner_distances distances_to(const plane& p, const face_table& faces,
                                                   std::size_t row) noexcept {
    corner_distances distances;
    for (const columns3& corner : faces.corner) {
        const double distance = std::abs(signed_distance(p, corner.get(row)));
        distances.largest = std::max(distances.largest, distance);
        distances.sum += distance;
    }
    return distances;
}

/// For each face the plane for which `cost(plane, row)` is least; among equals the first; no_id where
/// all costs are infinite. Cost O(faces · planes), parallel.
template <class Cost>
[[nodiscard]] std::vector<plane_id> cheapest_planes(const face_table& faces,
                                                    std::span<const plane> planes, const Cost& cost,
                                                    parallel threads = {}) {
    std::vector<plane_id> cheapest(faces.size, no_id);
    threads.for_chunks(faces.size, 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            double least = std::numeric_limits<double>::infinity();
            for (plane_id id = 0; id < planes.size(); ++id) {
                const double c = cost(planes[id], row);
                if (c < least) least = c, cheapest[row] = id;
            }
        }
    });
    return cheapest;
}

/// For each face the plane whose farthest corner of the face is nearest, however far that is.
[[nodiscard]] inline std::vector<plane_id> planes_of_least_error(const face_table& faces,
                                                                 std::span<const plane> planes,
                                                                 parallel threads = {}) {
    return cheapest_planes(
        faces, planes,
        [&](const plane& p, std::size_t row) { return distances_to(p, faces, row).largest; },
        threads);
}

/// For each face the nearest plane within the limits, by the sum of its corners' distances; no_id
/// where there is none.
///
/// Source  Luksch 2009, section 3.2: skipped faces go to the nearest plane, far ones are dropped.
///         Differs by limits where the thesis says "high distance", and by the face's projection.
[[nodiscard]] inline std::vector<plane_id> nearest_planes_within(const face_table& faces,
                                                                 std::span<const plane> planes,
                                                                 double epsilon,
                                                                 const skip_limits& limits,
                                                                 parallel threads = {}) {
    return cheapest_planes(
        faces, planes,
        [&](const plane& p, std::size_t row) {
            const corner_distances d = distances_to(p, faces, row);
            const bool is_near = d.largest <= limits.reach * epsilon;
            const bool is_shown =
                std::abs(glm::dot(p.normal, faces.normal.get(row))) >= limits.least_projection;
            return is_near && is_shown ? d.sum : std::numeric_limits<double>::infinity();
        },
        threads);
}

}  // namespace billow::inline BILLOW_ABI
