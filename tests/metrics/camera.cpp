#include <billow/metrics/camera.hpp>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

#include "support/meshes.hpp"

namespace {

using namespace billow;

void check_frame(const frame& axes) {
    CHECK(glm::length(glm::cross(axes.u, axes.v) - axes.normal) < 1e-12);
    CHECK(glm::length(axes.u) == doctest::Approx(1));
    CHECK(axes.v.y >= -1e-12);
}

}  // namespace

TEST_SUITE("metrics/camera") {
    TEST_CASE("frames are right-handed and upright, from above and below too") {
        random_stream random(1);
        for (int i = 0; i < 50; ++i) {
            const dvec3 from = support::random_direction(random);
            check_frame(orbit_camera({dvec3(1, 2, 3), 2}, from).axes);
            check_frame(view_of({dvec3(1, 2, 3), 2}, from * 3.0).axes);
        }
        for (const double y : {-1.0, 1.0}) check_frame(view_of({dvec3(0), 1}, {0, y, 0}).axes);
    }

    TEST_CASE("an orbit camera sees the outline of its sphere 2 % within the picture") {
        for (const double distance : {1.5, 4.0, 30.0}) {
            const bounding_sphere sphere{dvec3(1, -2, 0.5), 3};
            const camera c = orbit_camera(sphere, {0.3, 0.2, -1}, distance);
            CHECK(glm::length(c.eye - sphere.centre) == doctest::Approx(3 * distance));
            // The ray at the upper edge touches a sphere that is a little larger.
            const double slope = 0.5 * c.height;
            const double closest = 3 * distance * slope / std::sqrt(1 + slope * slope);
            CHECK(closest > 3);
            CHECK(closest < 3 * 1.021);
            CHECK(c.near_distance > 0);
            CHECK(c.near_distance < 3 * (distance - 1));
        }
    }

    TEST_CASE("the angle of view is that from the lower to the upper edge") {
        const camera c = perspective_camera({0, 0, 5}, {0, 0, 0}, 1.5707963267948966, 200, 100);
        CHECK(c.height == doctest::Approx(2));
        CHECK(glm::length(c.axes.normal - dvec3(0, 0, 1)) < 1e-12);
    }

    TEST_CASE("the shorter side of an orthographic view holds the sphere") {
        CHECK(view_of({dvec3(0), 1}, {0, 0, 1}, 200, 100).height == doctest::Approx(2.04));
        CHECK(view_of({dvec3(0), 1}, {0, 0, 1}, 100, 200).height == doctest::Approx(4.08));
        CHECK(view_of({dvec3(0), 0}, {0, 0, 1}).height > 0);
    }
}
