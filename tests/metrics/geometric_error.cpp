#include <billow/metrics/geometric_error.hpp>

#include <numbers>

#include <doctest/doctest.h>

#include <billow/cloud/measure.hpp>
#include <billow/pipeline.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// Two squares above the plane z = 0, on which both are drawn: area 4 at height 0.1, 1 at 0.6.
struct two_squares {
    mesh source{};
    billboard_cloud cloud{};

    two_squares() {
        support::add_square(source, {0, 0, 0.1f}, {1, 0, 0}, {0, 1, 0});
        support::add_square(source, {0, 0, 0.6f}, {0.5f, 0, 0}, {0, 0.5f, 0});
        cloud.bounds = {{5, 5, 1}, 2};
        cloud.planes = {{{0, 0, 1}, -1}};
        cloud.plane_of_face = {0, 0, 0, 0};
    }
};

}  // namespace

TEST_SUITE("metrics/geometric_error") {
    TEST_CASE("faces in their planes are not displaced") {
        two_squares s;
        s.cloud.planes = {{{0, 0, 1}, 0.1f - 1.0}, {{0, 0, 1}, 0.6f - 1.0}};
        s.cloud.plane_of_face = {0, 0, 1, 1};
        const geometric_errors e = geometric_error(s.source, s.cloud);
        CHECK(e.mean < 1e-12);
        CHECK(e.max < 1e-12);
        CHECK(e.max_px < 1e-9);
        CHECK(e.undrawn == 0);
    }
    TEST_CASE("the mean weighs by area; shares and pixels follow from it") {
        const two_squares s;
        const lod_screen screen{.fov_y = std::numbers::pi / 2, .height_px = 1000};  // 500 at 1
        const auto e = geometric_error(s.source, s.cloud, {}, {.distance = 10, .screen = screen});
        CHECK(e.mean == doctest::Approx((4 * 0.1 + 1 * 0.6) / 5));
        CHECK(e.max == doctest::Approx(0.6));
        CHECK(e.mean_of_radius == doctest::Approx(0.1));
        CHECK(e.max_of_radius == doctest::Approx(0.3));
        CHECK(e.mean_of_diameter == doctest::Approx(0.05));
        CHECK(e.max_of_diameter == doctest::Approx(0.15));
        CHECK(e.mean_px == doctest::Approx(0.2 / 10 * 500));
        CHECK(e.max_px == doctest::Approx(0.6 / 8 * 500));
        const auto standard = geometric_error(s.source, s.cloud, {}, {.screen = screen});
        CHECK(standard.mean_px == doctest::Approx(0.2 / 8 * 500));
        CHECK(standard.max_px == doctest::Approx(0.6 / 6 * 500));
    }
    TEST_CASE("what is not drawn is counted apart") {
        two_squares s;
        s.cloud.plane_of_face = {0, 0, no_id, no_id};
        const auto e = geometric_error(s.source, s.cloud);
        CHECK(e.undrawn == 2);
        CHECK(e.max == doctest::Approx(0.1));
    }
    TEST_CASE("welded corners are displaced along their plane, too") {
        const two_squares s;
        const std::vector<moved_face> moved{{2,
                                             {dvec3(-0.5, -0.5, 0.6) - s.cloud.bounds.centre,
                                              dvec3(0.5 + 0.8, -0.5, 0) - s.cloud.bounds.centre,
                                              dvec3(0.5, 0.5, 0.6) - s.cloud.bounds.centre}}};
        CHECK(geometric_error(s.source, s.cloud, moved).max == doctest::Approx(1));  // 0.6, 0.8
    }
    TEST_CASE("of a cloud that is not welded it is what the cloud measures, within epsilon") {
        const mesh pot = teapot(3);
        const auto built = build_cloud(pot, {.epsilon = tolerance::of_radius(0.05)});
        REQUIRE(built);
        const geometric_errors e = geometric_error(pot, built->cloud, built->moved);
        const cloud_errors plain = measure_errors(pot, built->cloud);
        CHECK(e.max == doctest::Approx(plain.max_error));
        CHECK(e.mean == doctest::Approx(plain.mean_error));
        CHECK(e.max_of_radius <= 0.05 * (1 + 1e-6));
        CHECK(e.mean > 0);
    }
    TEST_CASE("an empty mesh has no error") { CHECK(geometric_error(mesh{}, {}).max_px == 0); }
}
