#include <billow/geometry/bounds.hpp>

#include <array>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("geometry/bounds") {
    TEST_CASE("the sphere is around the box's centre and holds every point") {
        const std::array<vec3, 3> points{vec3(1, 2, 3), vec3(3, 2, 3), vec3(2, 4, 3)};
        const auto sphere =
            bounding_sphere_of(points.size(), [&](std::size_t i) { return points[i]; });
        CHECK(sphere.centre == dvec3(2, 3, 3));
        CHECK(sphere.radius == doctest::Approx(std::sqrt(2.0)));
    }
    TEST_CASE("no points give a point") {
        const auto sphere = bounding_sphere_of(0, [](std::size_t) { return vec3(1); });
        CHECK(sphere.radius == 0);
        CHECK(sphere.centre == dvec3(0));
    }
}
