// From planes to rectangles: how large each billboard is and which way it is turned.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 4.5: the
// rectangle of least area around the projected faces.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/rectangle.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// The frame of a billboard: of the four ways to lay v along a rectangle's axes the one that points
/// most to +Y, so that textures stand upright. On a near-horizontal plane, where no axis points up,
/// it is the one most to -Z: north on a map seen from above.
[[nodiscard]] inline frame upright_frame(const dvec3& along, const dvec3& across,
                                         const dvec3& normal) noexcept {
    const std::array axes{across, along, -across, -along};
    const double rise = std::max(std::abs(along.y), std::abs(across.y));
    const dvec3 goal = rise > 1e-3 ? dvec3(0, 1, 0) : dvec3(0, 0, -1);
    dvec3 v = axes[0];
    for (const dvec3& axis : axes) {
        if (glm::dot(axis, goal) > glm::dot(v, goal) + 1e-9) v = axis;
    }
    return {.u = glm::cross(v, normal), .v = v, .normal = normal};
}

/// Buffers for the largest plane, one set a thread.
struct rectangle_scratch {
    std::vector<dvec2> points{};
    std::vector<dvec2> hull{};
};

[[nodiscard]] inline billboard fit_billboard(const mesh& mesh, const billboard_cloud& cloud,
                                             plane_id id, std::span<const face_id> mapped,
                                             rectangle_scratch& scratch) {
    const plane base = canonical(cloud.planes[id]);
    const frame local = frame_around(base.normal);
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    double facing = 0;  // twice the area seen from the front minus that seen from behind
    double total = 0;
    std::size_t count = 0;
    const auto add = [&](face_id face) {
        std::array<dvec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = local.to_local(dvec3(mesh.corners(face)[k]) - cloud.bounds.centre);
            scratch.points[count++] = dvec2(p[k]);
            low = std::min(low, p[k].z - base.rho);
            high = std::max(high, p[k].z - base.rho);
        }
        const dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
        facing += normal.z;
        total += glm::length(normal);
    };
    for (const face_id face : mapped) add(face);
    for (const drawn_too& d : cloud.also_drawn_on(id)) add(d.face);
    if (count == 0) low = high = 0;
    const std::size_t corners = convex_hull(std::span(scratch.points).first(count), scratch.hull);
    const oriented_rectangle rectangle =
        minimum_rectangle(std::span<const dvec2>(scratch.hull).first(corners));

    const bool is_flipped = facing < -1e-6 * total;  // even halves keep the outward normal
    const auto in_scene = [&](const dvec2& v) { return local.u * v.x + local.v * v.y; };
    const dvec3 along = in_scene(rectangle.axis);
    const dvec3 across = in_scene(rectangle.height_axis());
    billboard result;
    result.axes = upright_frame(along, across, is_flipped ? -base.normal : base.normal);
    result.width =
        std::abs(glm::dot(result.axes.u, along)) > 0.5 ? rectangle.extent.x : rectangle.extent.y;
    result.height =
        std::abs(glm::dot(result.axes.v, along)) > 0.5 ? rectangle.extent.x : rectangle.extent.y;
    const dvec2 middle = rectangle.low + rectangle.extent * 0.5;
    result.origin = cloud.bounds.centre + base.normal * base.rho + along * middle.x +
                    across * middle.y - result.axes.u * (result.width * 0.5) -
                    result.axes.v * (result.height * 0.5);
    result.depth_low = is_flipped ? -high : low;
    result.depth_high = is_flipped ? -low : high;
    return result;
}

}  // namespace detail

/// Lays a rectangle on every plane: the smallest one around the projected vertices of the faces
/// that are mapped to it or in cloud.also_drawn for it. Its front is the side that most of their area faces; where both sides
/// weigh the same (difference below 1e-6 of the area), the side away from the centre of the scene.
/// Corners (0,0), (1,0), (1,1), (0,1) of a billboard are counter-clockwise seen from its front.
///
/// Needs  planes, plane_of_face and also_drawn of `cloud`; one row of plane_of_face a face.
/// Gives  `cloud.billboards`, one a plane; a plane without faces has zero extents.
/// Cost   O(faces log faces), parallel over planes.
inline void fit_billboards(const mesh& mesh, billboard_cloud& cloud, parallel threads = {}) {
    BILLOW_ASSERT(cloud.plane_of_face.size() == mesh.face_count());
    const faces_of_planes faces(cloud.plane_of_face, cloud.plane_count());
    const auto plane_count = static_cast<plane_id>(cloud.plane_count());
    std::size_t most = 0;
    for (plane_id i = 0; i < plane_count; ++i) {
        most = std::max(most, faces[i].size() + cloud.also_drawn_on(i).size());
    }
    cloud.billboards.assign(plane_count, {});

    std::vector<detail::rectangle_scratch> scratches(threads.count());
    for (auto& scratch : scratches) {
        scratch.points.resize(3 * most);
        scratch.hull.resize(3 * most + 1);
    }
    for_jobs(threads, plane_count, scratches, [&](std::size_t job, auto& scratch) {
        const auto id = static_cast<plane_id>(job);
        cloud.billboards[id] = detail::fit_billboard(mesh, cloud, id, faces[id], scratch);
    });
}

}  // namespace billow::inline BILLOW_ABI
