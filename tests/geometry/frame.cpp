#include <billow/geometry/frame.hpp>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("geometry/frame") {
    TEST_CASE("a frame is orthonormal and right-handed around any normal") {
        random_stream random(3);
        for (int i = 0; i < 200; ++i) {
            const dvec3 n = i == 0   ? dvec3(0, 0, -1)
                            : i == 1 ? dvec3(0, 0, 1)
                            : i == 2 ? dvec3(1, 0, 0)
                                     : support::random_direction(random);
            const frame f = frame_around(n);
            CHECK(glm::length(f.u) == doctest::Approx(1).epsilon(1e-12));
            CHECK(glm::length(f.v) == doctest::Approx(1).epsilon(1e-12));
            CHECK(glm::dot(f.u, f.v) == doctest::Approx(0).epsilon(1e-12));
            CHECK(glm::distance(glm::cross(f.u, f.v), n) < 1e-12);
        }
    }
    TEST_CASE("to_scene undoes to_local") {
        const frame f = frame_around(glm::normalize(dvec3(1, 2, -3)));
        const dvec3 p{0.3, -7, 2};
        CHECK(glm::distance(f.to_scene(f.to_local(p)), p) < 1e-12);
    }
}
