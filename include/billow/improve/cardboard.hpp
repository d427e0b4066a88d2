// A second billboard across thin ones: without it a stem is flat seen from the side.
//
// Fuhrmann, Umlauf, Mantler, "Extreme Model Simplification for Forest Rendering", 2005, section 3.3.6.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/parallel.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/geometry/rectangle.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

struct cardboard_options {
    double min_coverage = 0.8;  ///< least area on the cardboard plane, as a share of that on the
                                ///< primary one; 0: no cardboard planes
    double min_elongation = 2;  ///< least length of the primary rectangle over its width; 1: any
    part_id only_part = no_id;  ///< planes of this part only; no_id: of all parts
};

namespace detail {

/// Looks for the cardboard plane of one primary plane.
class cardboard_finder {
public:
    cardboard_finder(const mesh& drawn, const billboard_cloud& cloud,
                     const cardboard_options& options)
        : mesh_(drawn), cloud_(cloud), options_(options) {}

    struct found {
        plane across{};
        std::vector<face_id> faces{};  ///< none: no cardboard plane
    };

    [[nodiscard]] found operator()(plane_id primary, std::span<const face_id> mapped) const {
        const plane& of = cloud_.planes[primary];
        const frame local = frame_around(of.normal);
        std::vector<dvec2> points;
        points.reserve(3 * mapped.size());
        dvec2 moment{0};
        double area = 0;
        for (const face_id face : mapped) {
            dvec2 sum{0};
            for (const dvec3& corner : corners_of(face)) {
                points.emplace_back(local.to_local(corner));
                sum += points.back();
            }
            const double weight = projected_area(face, of.normal);
            moment += sum * (weight / 3);
            area += weight;
        }
        if (!(area > 0)) return {};
        const oriented_rectangle rectangle = minimum_rectangle_of(std::move(points));
        const auto [shorter, longer] = std::minmax(rectangle.extent.x, rectangle.extent.y);
        if (longer < options_.min_elongation * shorter) return {};

        found best;
        double most = options_.min_coverage * area;
        for (const dvec2& side : {rectangle.axis, rectangle.height_axis()}) {
            const dvec3 normal = local.u * side.x + local.v * side.y;
            const plane across = canonical({normal, glm::dot(side, moment / area)});
            std::vector<face_id> faces = valid_faces(across, mapped, cloud_.epsilon_of(primary));
            double covered = 0;
            for (const face_id face : faces) covered += projected_area(face, normal);
            if (covered >= most && (best.faces.empty() || covered > most) && covered > 0) {
                most = covered;
                best = {across, std::move(faces)};
            }
        }
        return best;
    }

private:
    [[nodiscard]] std::array<dvec3, 3> corners_of(face_id face) const noexcept {
        const auto [a, b, c] = mesh_.corners(face);
        const dvec3& centre = cloud_.bounds.centre;
        return {dvec3(a) - centre, dvec3(b) - centre, dvec3(c) - centre};
    }
    [[nodiscard]] double projected_area(face_id face, const dvec3& normal) const noexcept {
        const auto [a, b, c] = corners_of(face);
        return 0.5 * std::abs(glm::dot(normal, glm::cross(b - a, c - a)));
    }
    [[nodiscard]] std::vector<face_id> valid_faces(const plane& across,
                                                   std::span<const face_id> mapped,
                                                   double epsilon) const {
        const double radius = cloud_.bounds.radius;
        std::vector<face_id> valid;
        for (const face_id face : mapped) {
            const auto [a, b, c] = corners_of(face);
            if (!(glm::length(glm::cross(b - a, c - a)) >
                  2 * degenerate_area_share * radius * radius)) {
                continue;  // nothing to draw
            }
            if (std::max({std::abs(signed_distance(across, a)),
                          std::abs(signed_distance(across, b)),
                          std::abs(signed_distance(across, c))}) <= epsilon * (1 + 1e-9)) {
                valid.push_back(face);
            }
        }
        return valid;
    }

    const mesh& mesh_;
    const billboard_cloud& cloud_;
    const cardboard_options& options_;
};

}  // namespace detail

/// Adds a cardboard plane to every plane that holds something long and thin. It is perpendicular to
/// its primary plane, goes through the centroid of the projected faces along an edge of their
/// rectangle of least area, and shows those of the primary plane's faces that are valid for it, too.
/// Of the two edges the one is taken whose plane has the larger coverage: the sum of the faces'
/// projected areas there, over the sum for all faces on the primary plane.
///
/// Needs  `drawn` as the cloud was searched in, or with moved vertices; called before
///        fit_billboards, which gives the new planes their rectangles.
/// Gives  the number of planes added. They are appended to `cloud.planes`, of the same part as their
///        primary one; their faces are in `cloud.also_drawn`. No face is mapped to them, and they
///        reach at most epsilon out of the primary plane on either side.
/// Cost   O(faces log faces), parallel over planes.
/// Source Fuhrmann et al. 2005, section 3.3.6. Differs: asks for a least elongation, as coverage
///        alone also admits lumps within 2 epsilon each way, that look alike from all sides.
inline std::size_t add_cardboard_planes(const mesh& drawn, billboard_cloud& cloud,
                                        const cardboard_options& options = {},
                                        parallel threads = {}) {
    BILLOW_ASSERT(cloud.plane_of_face.size() == drawn.face_count());
    if (!(options.min_coverage > 0)) return 0;
    const std::size_t primaries = cloud.plane_count();
    const faces_of_planes mapped(cloud.plane_of_face, primaries);
    const detail::cardboard_finder find(drawn, cloud, options);
    std::vector<detail::cardboard_finder::found> found(primaries);
    threads.for_chunks(primaries, 1, [&](std::size_t i, std::size_t) {
        const auto id = static_cast<plane_id>(i);
        if (options.only_part == no_id || options.only_part == cloud.part_of(id)) {
            found[i] = find(id, mapped[id]);
        }
    });
    for (plane_id primary = 0; primary < primaries; ++primary) {
        if (found[primary].faces.empty()) continue;
        const auto added = static_cast<plane_id>(cloud.plane_count());
        cloud.planes.push_back(found[primary].across);
        if (!cloud.part_of_plane.empty()) cloud.part_of_plane.push_back(cloud.part_of(primary));
        for (const face_id face : found[primary].faces) cloud.also_drawn.push_back({added, face});
    }
    return cloud.plane_count() - primaries;
}

}  // namespace billow::inline BILLOW_ABI
