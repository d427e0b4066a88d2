// Meshes and face tables that many tests need.
#pragma once

#include <initializer_list>
#include <vector>

#include <billow/core/random.hpp>
#include <billow/mesh/face_table.hpp>

namespace support {

/// A mesh of loose triangles, three positions each.
inline billow::mesh triangles(const std::vector<billow::vec3>& corners) {
    billow::mesh m;
    m.positions = corners;
    for (std::uint32_t i = 0; i + 2 < corners.size(); i += 3)
        m.triangles.push_back({i, i + 1, i + 2});
    return m;
}

/// `count` triangles with corners within `extent` of centres in the unit ball.
inline billow::mesh random_triangles(std::size_t count, double extent, std::uint64_t seed) {
    billow::random_stream random(seed);
    const auto in_ball = [&](double radius) {
        billow::dvec3 p;
        do {
            p = {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
        } while (glm::dot(p, p) > 1);
        return p * radius;
    };
    std::vector<billow::vec3> corners;
    for (std::size_t i = 0; i < count; ++i) {
        const billow::dvec3 centre = in_ball(1 - extent);
        for (int k = 0; k < 3; ++k) corners.emplace_back(centre + in_ball(extent));
    }
    return triangles(corners);
}

/// Appends a square of two triangles, centre ± u ± v.
inline void add_square(billow::mesh& m, const billow::vec3& centre, const billow::vec3& u,
                       const billow::vec3& v) {
    const auto first = static_cast<std::uint32_t>(m.vertex_count());
    for (const billow::vec3& p : {centre - u - v, centre + u - v, centre + u + v, centre - u + v}) {
        m.positions.push_back(p);
    }
    m.triangles.push_back({first, first + 1, first + 2});
    m.triangles.push_back({first, first + 2, first + 3});
}

/// The table of a mesh that is known to be good.
inline billow::face_table table_of(const billow::mesh& m) { return *billow::make_face_table(m); }

/// A uniform random direction.
inline billow::dvec3 random_direction(billow::random_stream& random) {
    billow::dvec3 p;
    do {
        p = {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    } while (glm::dot(p, p) > 1 || glm::dot(p, p) < 0.01);
    return glm::normalize(p);
}

}  // namespace support
