#include <billow/metrics/render_scene.hpp>

#include <doctest/doctest.h>

#include <billow/shapes/box.hpp>

#include "support/meshes.hpp"

TEST_SUITE("metrics/render_scene") {
    using namespace billow;

    TEST_CASE("rows are faces, degenerate ones too, relative to the centre") {
        mesh m = support::random_triangles(13, 0.2, 5);
        for (vec3& p : m.positions) p += vec3(100, 0, 0);
        m.triangles[4] = {0, 0, 0};
        const render_scene scene(m);
        CHECK(scene.face_count() == 13);
        CHECK(scene.bounds.centre.x == doctest::Approx(100).epsilon(0.01));
        for (face_id face = 0; face < 13; ++face) {
            for (std::size_t k = 0; k < 3; ++k) {
                const dvec3 at = scene.corner[k].get(face) + scene.bounds.centre;
                CHECK(glm::length(at - dvec3(m.corners(face)[k])) < 1e-5);
            }
        }
        CHECK(scene.corner[0].x.size() % simd::lane_count == 0);
    }

    TEST_CASE("nothing is a scene") {
        const mesh nothing;
        CHECK(render_scene(nothing).face_count() == 0);
    }
}
