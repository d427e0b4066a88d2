// How far a cloud tears its mesh apart: the edges whose faces are drawn on different planes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/vertex_identity.hpp>

namespace billow::inline BILLOW_ABI {

/// What a cloud tears. An end of an edge is torn where its two faces draw it more than 1e-6 radii
/// apart.
struct cloud_cracks {
    double edge_length = 0;      ///< of the edges between faces on different planes, scene units
    double torn_length = 0;      ///< of those, torn at both ends; half of those torn at one
    double area = 0;             ///< length × mean width of the cracks, scene units squared
    double width = 0;            ///< of the widest crack, scene units
    std::size_t edges = 0;       ///< between faces on different planes
    std::size_t torn_edges = 0;  ///< of those, torn at an end at least
};

namespace detail {

/// A side of a face, and which vertices it joins.
struct face_side {
    std::uint32_t low = 0;  ///< vertex identities
    std::uint32_t high = 0;
    face_id face = no_id;
    std::uint8_t low_corner = 0;
    std::uint8_t high_corner = 0;
};

}  // namespace detail

/// Measures the cracks of `cloud` when `drawn` is drawn for its mesh `source`: equal faces, whose
/// corners may have moved.
///
/// Unit    tolerance as of position_ids, scene units.
/// Needs   `drawn` has the faces of `source`, in the same order.
/// Gives   sums over the edges of `source`. Where more than two faces meet at an edge, those on
///         neighbouring planes are compared.
/// Cost    O(faces log faces).
[[nodiscard]] inline cloud_cracks measure_cracks(const mesh& source, const billboard_cloud& cloud,
                                                 const mesh& drawn, double tolerance = 0) {
    BILLOW_ASSERT(drawn.face_count() == source.face_count());
    const vertex_identity vertices = position_ids(source, tolerance);
    std::vector<detail::face_side> sides;
    sides.reserve(3 * source.face_count());
    for (face_id face = 0; face < source.face_count(); ++face) {
        if (cloud.plane_of_face[face] == no_id) continue;
        for (std::uint8_t k = 0; k < 3; ++k) {
            const auto next = static_cast<std::uint8_t>((k + 1) % 3);
            const std::uint32_t a = vertices.id[source.triangles[face][k]];
            const std::uint32_t b = vertices.id[source.triangles[face][next]];
            if (a < b) sides.push_back({a, b, face, k, next});
            if (b < a) sides.push_back({b, a, face, next, k});
        }
    }
    const auto place = [&](const detail::face_side& s) {
        return std::tuple(s.low, s.high, cloud.plane_of_face[s.face], s.face);
    };
    std::sort(sides.begin(), sides.end(),
              [&](const auto& a, const auto& b) { return place(a) < place(b); });

    const auto drawn_at = [&](face_id face, std::uint8_t corner) {
        const plane& on = cloud.planes[cloud.plane_of_face[face]];
        const dvec3 p = dvec3(drawn.positions[drawn.triangles[face][corner]]) - cloud.bounds.centre;
        return p - on.normal * signed_distance(on, p);
    };
    const double least = 1e-6 * cloud.bounds.radius;
    cloud_cracks cracks;
    for (std::size_t i = 1; i < sides.size(); ++i) {
        const detail::face_side& a = sides[i - 1];
        const detail::face_side& b = sides[i];
        if (a.low != b.low || a.high != b.high) continue;
        if (cloud.plane_of_face[a.face] == cloud.plane_of_face[b.face]) continue;
        const std::array<vec3, 3> corners = source.corners(a.face);
        const double length =
            glm::distance(dvec3(corners[a.low_corner]), dvec3(corners[a.high_corner]));
        const std::array gaps{
            glm::distance(drawn_at(a.face, a.low_corner), drawn_at(b.face, b.low_corner)),
            glm::distance(drawn_at(a.face, a.high_corner), drawn_at(b.face, b.high_corner))};
        const int torn_ends = (gaps[0] > least ? 1 : 0) + (gaps[1] > least ? 1 : 0);
        ++cracks.edges;
        cracks.edge_length += length;
        cracks.torn_edges += torn_ends > 0 ? 1 : 0;
        cracks.torn_length += length * torn_ends / 2;
        cracks.area += length * (gaps[0] + gaps[1]) / 2;
        cracks.width = std::max({cracks.width, gaps[0], gaps[1]});
    }
    return cracks;
}

}  // namespace billow::inline BILLOW_ABI
