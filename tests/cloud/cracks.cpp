#include <billow/cloud/cracks.hpp>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("cloud/cracks") {
    TEST_CASE("a crack has the length of its edge and the width between its planes") {
        mesh m =
            support::triangles({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 0, 0}, {0, 0, 0}, {0, -1, 0}});
        billboard_cloud cloud;
        cloud.bounds = {dvec3(0), 2};
        cloud.planes = {{{0, 0, 1}, 0}, {{0, 0, 1}, 0.25}};
        cloud.plane_of_face = {0, 1};
        const cloud_cracks cracks = measure_cracks(m, cloud, m);
        CHECK(cracks.edges == 1);
        CHECK(cracks.torn_edges == 1);
        CHECK(cracks.edge_length == 2);
        CHECK(cracks.torn_length == 2);
        CHECK(cracks.width == 0.25);
        CHECK(cracks.area == 0.5);
        // Tilted so that one end is closed.
        const dvec3 normal = glm::normalize(dvec3(-1, 0, 4));
        cloud.planes[1] = {normal, 0};
        const cloud_cracks half = measure_cracks(m, cloud, m);
        CHECK(half.torn_edges == 1);
        CHECK(half.torn_length == 1);
        CHECK(half.area == doctest::Approx(half.width));
    }
    TEST_CASE("faces on one plane or on none tear nothing") {
        const mesh m =
            support::triangles({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {2, 0, 0}, {0, 0, 0}, {0, -1, 0}});
        billboard_cloud cloud;
        cloud.bounds = {dvec3(0), 2};
        cloud.planes = {{{0, 0, 1}, 0}, {{0, 0, 1}, 0.25}};
        cloud.plane_of_face = {1, 1};
        CHECK(measure_cracks(m, cloud, m).edges == 0);
        cloud.plane_of_face = {1, no_id};
        CHECK(measure_cracks(m, cloud, m).edges == 0);
        CHECK(measure_cracks({}, {}, {}).edges == 0);
    }
}
