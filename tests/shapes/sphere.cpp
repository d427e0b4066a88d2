#include <billow/shapes/sphere.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("shapes/sphere") {
    TEST_CASE("an icosphere has 20 · 4^n faces and its vertices on the unit sphere") {
        for (unsigned n = 0, faces = 20; n < 4; ++n, faces *= 4) {
            const mesh ball = icosphere(n);
            CHECK(ball.face_count() == faces);
            CHECK(ball.vertex_count() == faces / 2 + 2);  // Euler: closed
            for (const vec3& p : ball.positions) CHECK(glm::length(p) == doctest::Approx(1));
        }
    }

    TEST_CASE("faces look outwards and the volume nears 4/3 pi from below") {
        double before = 0;
        for (unsigned n = 0; n < 5; ++n) {
            const mesh ball = icosphere(n);
            double volume = 0;
            for (face_id f = 0; f < ball.face_count(); ++f) {
                const auto [a, b, c] = ball.corners(f);
                const double part = double(glm::dot(a, glm::cross(b, c))) / 6;
                REQUIRE(part > 0);
                volume += part;
            }
            CHECK(volume > before);
            before = volume;
        }
        CHECK(before == doctest::Approx(4.18879).epsilon(0.005));
        CHECK(before < 4.18879);
    }
}
