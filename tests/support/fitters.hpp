// What every plane fitter promises.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <billow/fit/fit.hpp>
#include <billow/geometry/frame.hpp>

#include "support/meshes.hpp"

namespace support {

using namespace billow;

/// Triangles near the plane normal·x = rho, `noise` off it at most.
inline mesh near_plane(const plane& p, double noise, bool alternates = false) {
    random_stream random(5);
    const frame axes = frame_around(p.normal);
    std::vector<vec3> corners;
    for (int i = 0; i < 60; ++i) {
        const dvec3 at = axes.to_scene({random.between(-1, 1), random.between(-1, 1), p.rho});
        std::array<vec3, 3> t;
        for (auto& c : t) {
            c = vec3(at + axes.to_scene({random.between(-0.1, 0.1), random.between(-0.1, 0.1),
                                         random.between(-noise, noise)}));
        }
        if (alternates && i % 2 == 1) std::swap(t[1], t[2]);
        corners.insert(corners.end(), t.begin(), t.end());
    }
    return triangles(corners);
}

/// The plane around the table's own centre.
inline plane centred(const plane& p, const face_table& faces) {
    return {p.normal, p.rho - glm::dot(p.normal, faces.bounds.centre)};
}

template <plane_fitter Fitter>
void check_fitter(const Fitter& fit) {
    const plane truth{glm::normalize(dvec3(0.2, -0.9, 0.4)), 0.3};
    const plane start{glm::normalize(truth.normal + dvec3(0.06, 0.03, -0.02)), 0.25};
    SUBCASE("coplanar faces give their plane, whichever way they look") {
        const face_table faces = table_of(near_plane(truth, 0, true));
        const plane p = fit(faces, centred(start, faces));
        const plane expected = centred(truth, faces);
        CHECK(glm::distance(p.normal, expected.normal) < 1e-5);
        CHECK(p.rho == doctest::Approx(expected.rho).epsilon(1e-5));
    }
    SUBCASE("the plane keeps the side of the start plane") {
        const face_table faces = table_of(near_plane(truth, 0.01));
        CHECK(glm::dot(fit(faces, centred(start, faces)).normal, start.normal) > 0.9);
        const plane behind{-start.normal, -start.rho};
        CHECK(glm::dot(fit(faces, centred(behind, faces)).normal, start.normal) < -0.9);
    }
    SUBCASE("faces that determine no plane keep the normal") {
        face_table none;
        CHECK(fit(none, start) == start);
    }
}

inline double squared_distances(const face_table& faces, const plane& p) {
    double sum = 0;
    for (const columns3& corner : faces.corner) {
        for (std::size_t row = 0; row < faces.size; ++row) {
            const double d = signed_distance(p, corner.get(row));
            sum += d * d;
        }
    }
    return sum;
}

}  // namespace support
