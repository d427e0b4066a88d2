#include <billow/metrics/displacement.hpp>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// A cloud with planes around `centre`.
billboard_cloud cloud_of(const dvec3& centre, std::vector<plane> planes,
                         std::vector<plane_id> plane_of_face) {
    billboard_cloud cloud;
    cloud.bounds.centre = centre;
    for (const plane& p : planes) {
        billboard b;
        b.axes = frame_around(p.normal);
        b.origin = centre + p.normal * p.rho;
        cloud.billboards.push_back(b);
    }
    cloud.planes = std::move(planes);
    cloud.plane_of_face = std::move(plane_of_face);
    return cloud;
}

const mesh one = support::triangles({{1, 0, 0}, {1.2f, 1, 0}, {0.9f, 0, 1}});

}  // namespace

TEST_SUITE("metrics/displacement") {
    TEST_CASE("what is not moved has no displacement") {
        const drawn_faces original = undisplaced(one);
        const auto cloud = cloud_of({0, 0, 0}, {{{1, 0, 0}, 1}}, {0});
        const drawn_faces drawn = drawn_by(cloud, original);
        const displacement still = displacement_between(one, drawn, drawn);
        CHECK(still.max == 0);
        CHECK(still.mean == 0);
        CHECK(still.faces == 1);
    }
    TEST_CASE("corners go to the nearest points of their plane, wherever the centre is") {
        for (const dvec3& centre : {dvec3(0), dvec3(3, -1, 2)}) {
            const plane p{{1, 0, 0}, 1 - centre.x};  // x = 1
            const auto drawn = drawn_by(cloud_of(centre, {p}, {0}), undisplaced(one));
            CHECK(glm::distance(drawn.corners[0][1], dvec3(1, 1, 0)) < 1e-6);
            const displacement moved = displacement_between(one, undisplaced(one), drawn);
            CHECK(moved.max == doctest::Approx(0.2).epsilon(1e-5));
            CHECK(moved.mean == doctest::Approx((0.0 + 0.2 + 0.1) / 3).epsilon(1e-5));
        }
    }
    TEST_CASE("corners that have moved before are drawn below where they went") {
        const dvec3 centre(3, -1, 2);
        const auto cloud = cloud_of(centre, {{{1, 0, 0}, 1 - centre.x}}, {0});
        const std::vector<moved_face> moved{
            {0, {dvec3(1, 0, 0) - centre, dvec3(1.3, 1, 0.5) - centre, dvec3(0.9, 0, 1) - centre}}};
        const drawn_faces drawn = drawn_by(cloud, undisplaced(one), moved);
        CHECK(glm::distance(drawn.corners[0][0], dvec3(1, 0, 0)) < 1e-6);
        CHECK(glm::distance(drawn.corners[0][1], dvec3(1, 1, 0.5)) < 1e-6);
        CHECK(glm::distance(drawn.corners[0][2], dvec3(1, 0, 1)) < 1e-6);
    }
    TEST_CASE("large faces weigh more in the mean") {
        const mesh two =
            support::triangles({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
        const auto drawn =
            drawn_by(cloud_of({0, 0, 0}, {{{0, 0, 1}, 0}}, {0, 0}), undisplaced(two));
        const displacement moved = displacement_between(two, undisplaced(two), drawn);
        CHECK(moved.max == doctest::Approx(1));
        CHECK(moved.mean == doctest::Approx(0.1));
    }
}
