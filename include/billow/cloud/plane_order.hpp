// Planes in the order of what they hold, and how much the first of them hold together.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/config.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// The area of the faces on each plane.
[[nodiscard]] inline std::vector<double> areas_of_planes(const face_table& faces,
                                                         const billboard_cloud& cloud) {
    std::vector<double> areas(cloud.plane_count(), 0.0);
    for (std::size_t row = 0; row < faces.size; ++row) {
        const plane_id id = cloud.plane_of_face[faces.source[row]];
        if (id != no_id) areas[id] += static_cast<double>(faces.area[row]);
    }
    return areas;
}

}  // namespace detail

/// What the planes up to each hold together, one row a plane.
struct plane_curve {
    std::vector<double>
        covered_area{};                ///< share of the faces' area; ends below 1 where faces have
                                       ///< no plane
    std::vector<double> mean_error{};  ///< mean distance of the corners of these faces to their
                                       ///< planes, weighted by area, scene units
};

/// Needs  `faces` of the mesh that `cloud` was searched in.
/// Cost   O(faces + planes).
[[nodiscard]] inline plane_curve curve_of(const face_table& faces, const billboard_cloud& cloud) {
    const std::vector<double> areas = detail::areas_of_planes(faces, cloud);
    std::vector<double> errors(areas.size(), 0.0);
    double all = 0;
    for (std::size_t row = 0; row < faces.size; ++row) {
        const auto area = static_cast<double>(faces.area[row]);
        all += area;
        const plane_id id = cloud.plane_of_face[faces.source[row]];
        if (id == no_id) continue;
        const plane& of = cloud.planes[id];
        const double rho = of.rho + glm::dot(of.normal, cloud.bounds.centre - faces.bounds.centre);
        for (const columns3& corner : faces.corner) {
            errors[id] += area / 3 * std::abs(glm::dot(of.normal, corner.get(row)) - rho);
        }
    }
    plane_curve curve;
    double area = 0;
    double error = 0;
    for (std::size_t i = 0; i < areas.size(); ++i) {
        area += areas[i];
        error += errors[i];
        curve.covered_area.push_back(all > 0 ? area / all : 0);
        curve.mean_error.push_back(area > 0 ? error / area : 0);
    }
    return curve;
}

/// Puts planes that hold more area first, among equals those that were first before. A search gives
/// them nearly so; what changes planes afterwards may not.
///
/// Needs  no billboards, faces drawn too, or parts yet.
/// Cost   O(faces + planes log planes).
inline void order_planes_by_area(const face_table& faces, billboard_cloud& cloud) {
    BILLOW_ASSERT(cloud.billboards.empty() && cloud.also_drawn.empty());
    BILLOW_ASSERT(cloud.part_of_plane.empty());
    const std::vector<double> areas = detail::areas_of_planes(faces, cloud);
    std::vector<plane_id> order(cloud.plane_count());
    std::iota(order.begin(), order.end(), plane_id{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](plane_id a, plane_id b) { return areas[a] > areas[b]; });
    std::vector<plane> planes;
    std::vector<plane_id> place(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        planes.push_back(cloud.planes[order[i]]);
        place[order[i]] = static_cast<plane_id>(i);
    }
    cloud.planes = std::move(planes);
    for (plane_id& id : cloud.plane_of_face) {
        if (id != no_id) id = place[id];
    }
}

}  // namespace billow::inline BILLOW_ABI
