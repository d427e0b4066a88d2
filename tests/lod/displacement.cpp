#include <billow/lod/displacement.hpp>

#include <cmath>

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

TEST_SUITE("lod/displacement") {
    TEST_CASE("a level made of billboards moves what the level above has moved") {
        // x = 1, then the plane through the y axis that is turned by 45 degrees.
        const double half = std::sqrt(0.5);
        const auto above = cloud_of({0, 0, 0}, {{{1, 0, 0}, 1}}, {0});
        const auto cloud = cloud_of({0, 0, 0}, {{{half, 0, half}, half}}, {0, 0});
        const std::vector<plane_id> billboard_of_face{0, 0};
        const drawn_faces first = drawn_by(above, undisplaced(one));
        const drawn_faces second = drawn_through(cloud, billboard_of_face, 1, first);
        // (0.9, 0, 1) goes to (1, 0, 1), then to (0.5, 0, 0.5).
        CHECK(glm::distance(second.corners[0][2], dvec3(0.5, 0, 0.5)) < 1e-6);
        CHECK(displacement_between(one, first, second).max == doctest::Approx(half));
        CHECK(displacement_between(one, undisplaced(one), second).max ==
              doctest::Approx(std::hypot(0.4, 0.5)));
    }
    TEST_CASE("of a parted billboard the farther plane counts, a dropped part does not") {
        const auto above = cloud_of({0, 0, 0}, {{{1, 0, 0}, 1}}, {0});
        const drawn_faces first = drawn_by(above, undisplaced(one));
        const std::vector<plane_id> halves{0, 0};
        const std::vector<plane> planes{{{1, 0, 0}, 1.1}, {{1, 0, 0}, 1.5}};
        const auto moved = [&](std::vector<plane_id> plane_of_half) {
            const auto cloud = cloud_of({0, 0, 0}, planes, std::move(plane_of_half));
            return displacement_between(one, first, drawn_through(cloud, halves, 1, first));
        };
        CHECK(moved({0, 1}).max == doctest::Approx(0.5));
        CHECK(moved({1, 0}).max == doctest::Approx(0.5));
        CHECK(moved({no_id, 0}).max == doctest::Approx(0.1));
        CHECK(moved({no_id, no_id}).faces == 0);
    }
    TEST_CASE("a plane is kept when a billboard lies near it, on either side of it") {
        const auto fine = cloud_of({0, 0, 0}, {{{1, 0, 0}, 1}, {{0, 1, 0}, 2}}, {});
        const auto share = [&](const plane& p) {
            return share_of_kept_planes(cloud_of({0, 0, 0}, {p}, {}), fine, 0.1, 0.05);
        };
        CHECK(share({{1, 0, 0}, 1.04}) == 1);
        CHECK(share({{-1, 0, 0}, -1.04}) == 1);
        CHECK(share({{1, 0, 0}, 1.06}) == 0);
        CHECK(share({{0, 0, 1}, 1}) == 0);
        CHECK(share({{std::cos(0.09), std::sin(0.09), 0}, std::cos(0.09)}) == 1);
        CHECK(share({{std::cos(0.11), std::sin(0.11), 0}, std::cos(0.11)}) == 0);
        CHECK(share_of_kept_planes(cloud_of({0, 0, 0}, {}, {}), fine, 0.1, 0.1) == 0);
    }
}
