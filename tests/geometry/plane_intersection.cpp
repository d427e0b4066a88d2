#include <billow/geometry/plane_intersection.hpp>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("geometry/plane_intersection") {
    TEST_CASE("the point lies on all planes, and the way to it in the span of their normals") {
        random_stream random(3);
        for (int i = 0; i < 300; ++i) {
            std::array<plane, 3> planes;
            for (plane& p : planes) {
                p = {support::random_direction(random), random.between(-1, 1)};
            }
            const dvec3 point = support::random_direction(random);
            for (std::size_t count = 0; count <= 3; ++count) {
                const auto at = nearest_common_point(std::span(planes).first(count), point);
                if (!at) continue;
                for (std::size_t k = 0; k < count; ++k) {
                    CHECK(std::abs(signed_distance(planes[k], *at)) < 1e-9);
                }
                if (count == 2) {  // along the line of both planes nothing moves
                    const dvec3 line = glm::cross(planes[0].normal, planes[1].normal);
                    CHECK(std::abs(glm::dot(line, *at - point)) < 1e-9);
                }
            }
        }
    }
    TEST_CASE("without planes the point stays, and on one it is the projection") {
        const plane floor{{0, 1, 0}, 2};
        CHECK(nearest_common_point({}, dvec3(1, 5, 3)) == dvec3(1, 5, 3));
        CHECK(nearest_common_point(std::span(&floor, 1), dvec3(1, 5, 3)) == dvec3(1, 2, 3));
    }
    TEST_CASE("planes whose normals depend on each other have no point") {
        const std::array parallel{plane{{0, 1, 0}, 2}, plane{{0, -1, 0}, 2}};
        CHECK_FALSE(nearest_common_point(parallel, dvec3(0)));
        const std::array tent{plane{{1, 0, 0}, 1}, plane{{0, 1, 0}, 1},
                              plane{glm::normalize(dvec3(1, 1, 0)), 3}};
        CHECK_FALSE(nearest_common_point(tent, dvec3(0)));
        CHECK(nearest_common_point(std::span(tent).first(2), dvec3(0)) == dvec3(1, 1, 0));
    }
}
