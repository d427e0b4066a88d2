#include <billow/cloud/measure.hpp>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("cloud/measure") {
    TEST_CASE("distances, their area-weighted mean and the share of projected area") {
        mesh m;
        support::add_square(m, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});  // in the plane, area 4
        support::add_square(m, {0, 0, 0.5f}, {0.5f, 0, 0},
                            {0, 0, 0.5f});  // upright, area 1, z 0 … 1
        billboard_cloud cloud;
        cloud.bounds.centre = {10, 20, 1};
        cloud.epsilon = 0.9;
        cloud.planes = {{{0, 0, 1}, -1}};
        cloud.plane_of_face = {0, 0, 0, 0};
        cloud_errors e = measure_errors(m, cloud);
        CHECK(e.max_error == 1);
        CHECK(e.mean_error == doctest::Approx((0.5 * (1.0 / 3) + 0.5 * (2.0 / 3)) / 5));
        CHECK(e.projected_area_share == doctest::Approx(4.0 / 5));
        CHECK(e.mapped_faces == 4);
        CHECK(e.faces_beyond_epsilon == 2);
        CHECK(e.area_beyond_epsilon_share == doctest::Approx(1.0 / 5));
        CHECK(e.dropped_area_share == 0);
        CHECK(e.rectangle_use == 0);
        cloud.plane_of_face = {0, 0, no_id, no_id};
        e = measure_errors(m, cloud);
        CHECK(e.mapped_faces == 2);
        CHECK(e.max_error == 0);
        CHECK(e.projected_area_share == 1);
        CHECK(e.area_beyond_epsilon_share == 0);
        CHECK(e.dropped_area_share == doctest::Approx(1.0 / 5));
        cloud.billboards = {{.width = 2, .height = 4}};
        CHECK(measure_errors(m, cloud).rectangle_use == doctest::Approx(4.0 / 8));
    }
    TEST_CASE("nothing mapped gives zeros") {
        billboard_cloud cloud;
        CHECK(measure_errors(mesh{}, cloud).mean_error == 0);
    }
}
