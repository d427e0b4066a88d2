// The planes of a cloud that is known by its mesh alone, and which of them each face may be on.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// The sphere around all corners of faces, as bounding_sphere_of points.
[[nodiscard]] inline bounding_sphere bounding_sphere_of(const mesh& of) {
    return bounding_sphere_of(3 * of.face_count(), [&](std::size_t i) {
        return of.positions[of.triangles[i / 3][static_cast<int>(i % 3)]];
    });
}

/// An original's faces on the planes of a cloud's mesh.
///
/// Shape  `planes.planes` ascends by feature id, without those of parts that are no plane;
///        `planes.plane_of_face` has a row a face of the original. Billboards are left out.
struct nearest_planes {
    billboard_cloud planes{};
    std::vector<std::uint32_t> feature_of_plane{};
    std::size_t kept = 0;  ///< faces that the cloud holds as they are; they are on no plane
};

namespace detail {

/// A triangle on a plane, counter-clockwise in (u, v).
using flat_triangle = std::array<dvec2, 3>;

/// Whether an edge of `a` has all of `b` beyond it, by more than `slack`.
[[nodiscard]] inline bool is_beyond_an_edge(const flat_triangle& a, const flat_triangle& b,
                                            double slack) noexcept {
    for (std::size_t k = 0; k < 3; ++k) {
        const dvec2 edge = a[(k + 1) % 3] - a[k];
        const double limit = -slack * glm::length(edge);
        const auto inside = [&](const dvec2& p) {
            return edge.x * (p.y - a[k].y) - edge.y * (p.x - a[k].x);
        };
        if (std::max({inside(b[0]), inside(b[1]), inside(b[2])}) < limit) return true;
    }
    return false;
}

[[nodiscard]] inline flat_triangle counter_clockwise(flat_triangle t) noexcept {
    const dvec2 p = t[1] - t[0];
    const dvec2 q = t[2] - t[0];
    if (p.x * q.y < p.y * q.x) std::swap(t[1], t[2]);
    return t;
}

/// A plane with the triangles that a cloud's mesh has on it.
struct drawn_plane {
    plane on{};  ///< relative to the original's centre
    frame axes{};
    std::vector<flat_triangle> triangles{};

    [[nodiscard]] flat_triangle flat(const std::array<dvec3, 3>& corners) const noexcept {
        flat_triangle result;
        for (std::size_t k = 0; k < 3; ++k) {
            result[k] = {glm::dot(axes.u, corners[k]), glm::dot(axes.v, corners[k])};
        }
        return counter_clockwise(result);
    }
    /// Whether some of a face lies over a triangle.
    [[nodiscard]] bool may_show(const std::array<dvec3, 3>& corners, double slack) const noexcept {
        const flat_triangle shape = flat(corners);
        return std::any_of(triangles.begin(), triangles.end(), [&](const flat_triangle& t) {
            return !is_beyond_an_edge(t, shape, slack) && !is_beyond_an_edge(shape, t, slack);
        });
    }
};

/// One call of find_nearest_planes; its methods are the steps in their order.
class plane_finder {
public:
    plane_finder(const mesh& original, const mesh& cloud)
        : original_(original),
          cloud_(cloud),
          bounds_(bounding_sphere_of(original)),
          slack_(1e-5 * bounds_.radius +
                 1e-6 * (std::abs(bounds_.centre.x) + std::abs(bounds_.centre.y) +
                         std::abs(bounds_.centre.z))) {}

    [[nodiscard]] nearest_planes run(parallel threads) {
        find_planes();
        result_.planes.bounds = bounds_;
        auto& plane_of_face = result_.planes.plane_of_face;
        plane_of_face.assign(original_.face_count(), no_id);
        std::vector<char> is_kept(original_.face_count(), 0);
        threads.for_chunks(plane_of_face.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t face = begin; face < end; ++face) {
                const auto corners = original_.corners(static_cast<face_id>(face));
                is_kept[face] = holds(corners) ? 1 : 0;
                if (is_kept[face] == 0) plane_of_face[face] = nearest(corners);
            }
        });
        result_.kept = static_cast<std::size_t>(std::count(is_kept.begin(), is_kept.end(), 1));
        return std::move(result_);
    }

private:
    /// Sorts the features of the cloud into planes and parts that are none.
    void find_planes() {
        std::map<std::uint32_t, std::vector<face_id>> faces_of;
        for (face_id face = 0; face < cloud_.face_count(); ++face) {
            faces_of[cloud_.feature_ids[cloud_.triangles[face].x]].push_back(face);
        }
        for (const auto& [feature, faces] : faces_of) {
            if (!add_plane(feature, faces)) {
                for (const face_id face : faces) {
                    for (const vec3& p : cloud_.corners(face)) kept_points_.push_back(key(p));
                }
            }
        }
        std::sort(kept_points_.begin(), kept_points_.end());
    }

    [[nodiscard]] std::array<dvec3, 3> centred(const std::array<vec3, 3>& corners) const noexcept {
        return {dvec3(corners[0]) - bounds_.centre, dvec3(corners[1]) - bounds_.centre,
                dvec3(corners[2]) - bounds_.centre};
    }

    /// The plane of a feature's largest triangle, if all of the feature is on it.
    bool add_plane(std::uint32_t feature, const std::vector<face_id>& faces) {
        dvec3 largest{0};
        dvec3 point{0};
        for (const face_id face : faces) {
            const auto corners = centred(cloud_.corners(face));
            const dvec3 cross = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
            if (glm::dot(cross, cross) <= glm::dot(largest, largest)) continue;
            largest = cross;
            point = corners[0];
        }
        const double length = glm::length(largest);
        if (!(length > 0)) return true;  // shows nothing
        drawn_plane added;
        added.axes = frame_around(largest / length);
        added.on = {added.axes.normal, glm::dot(added.axes.normal, point)};
        for (const face_id face : faces) {
            const auto corners = centred(cloud_.corners(face));
            for (const dvec3& p : corners) {
                if (std::abs(signed_distance(added.on, p)) > 10 * slack_) return false;
            }
            added.triangles.push_back(added.flat(corners));
        }
        result_.planes.planes.push_back(added.on);
        result_.feature_of_plane.push_back(feature);
        drawn_.push_back(std::move(added));
        return true;
    }

    using point_key = std::array<float, 3>;
    [[nodiscard]] static point_key key(const vec3& p) noexcept { return {p.x, p.y, p.z}; }

    /// Whether all corners are vertices of parts that are no plane.
    [[nodiscard]] bool holds(const std::array<vec3, 3>& corners) const noexcept {
        return std::all_of(corners.begin(), corners.end(), [&](const vec3& p) {
            return std::binary_search(kept_points_.begin(), kept_points_.end(), key(p));
        });
    }

    [[nodiscard]] plane_id nearest(const std::array<vec3, 3>& at) const noexcept {
        const auto corners = centred(at);
        plane_id best = no_id;
        double least = std::numeric_limits<double>::infinity();
        for (plane_id id = 0; id < drawn_.size(); ++id) {
            double distance = 0;
            for (const dvec3& p : corners) {
                distance = std::max(distance, std::abs(signed_distance(drawn_[id].on, p)));
            }
            if (!(distance < least) || !drawn_[id].may_show(corners, slack_)) continue;
            least = distance;
            best = id;
        }
        return best;
    }

    const mesh& original_;
    const mesh& cloud_;
    bounding_sphere bounds_;
    double slack_;  ///< files hold floats
    std::vector<drawn_plane> drawn_{};
    std::vector<point_key> kept_points_{};
    nearest_planes result_{};
};

}  // namespace detail

/// For each face of the original the plane that is nearest to its farthest corner, of those on which
/// some polygon of the cloud lies over or under the face. A file does not say which plane a face was
/// mapped to; that plane is among these, so the distances are lower bounds of those of the cloud.
///
/// Needs   cloud.feature_ids, one plane each. A feature that is not flat is a part that stayed a
///         mesh: it holds the faces whose three corners are vertices of it.
/// Gives   no_id for faces over no polygon. Of planes that are equally near the lower feature id.
/// Cost    O(faces of the original × planes), parallel over faces.
[[nodiscard]] inline nearest_planes find_nearest_planes(const mesh& original, const mesh& cloud,
                                                        parallel threads = {}) {
    BILLOW_ASSERT(cloud.feature_ids.size() == cloud.vertex_count());
    return detail::plane_finder(original, cloud).run(threads);
}

}  // namespace billow::inline BILLOW_ABI
