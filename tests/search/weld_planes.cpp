#include <billow/search/weld_planes.hpp>

#include <vector>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

namespace {

const weld_options to_intersection{.kind = weld_kind::intersection};

weld_planes all_of(const std::vector<plane>& planes, const weld_options& options) {
    weld_planes chosen;
    for (plane_id id = 0; id < planes.size(); ++id) chosen.add(planes, id, options);
    return chosen;
}

/// How far apart two planes draw a point.
double gap(const plane& a, const plane& b, const dvec3& point) {
    return glm::distance(point - a.normal * signed_distance(a, point),
                         point - b.normal * signed_distance(b, point));
}

}  // namespace

TEST_SUITE("search/weld_planes") {
    TEST_CASE("a vertex goes to the corner of three planes") {
        const std::vector<plane> planes{{{1, 0, 0}, 1}, {{0, 1, 0}, 1}, {{0, 0, 1}, 1}};
        const weld_planes chosen = all_of(planes, to_intersection);
        CHECK(chosen.nearest(planes, dvec3(1.1, 0.9, 1), 0.2) == dvec3(1));
    }
    TEST_CASE("where three planes are out of reach, two that are not will do") {
        const std::vector<plane> planes{{{1, 0, 0}, 1}, {{0, 1, 0}, 1}, {{0, 0, 1}, 1}};
        const weld_planes chosen = all_of(planes, to_intersection);
        CHECK(chosen.nearest(planes, dvec3(1, 0.9, 0.5), 0.2) == dvec3(1, 1, 0.5));
        CHECK(chosen.nearest(planes, dvec3(0.5, 0.9, 1), 0.2) == dvec3(0.5, 1, 1));
    }
    TEST_CASE("the kind first stays with the first plane") {
        const std::vector<plane> planes{{{1, 0, 0}, 1}, {{0, 1, 0}, 1}};
        const weld_planes chosen = all_of(planes, {.kind = weld_kind::first});
        CHECK(chosen.first() == 0);
        CHECK(chosen.nearest(planes, dvec3(1.1, 0.9, 0), 0.2) == dvec3(1, 0.9, 0));
        CHECK(chosen.nearest(planes, dvec3(1.5, 0.9, 0), 0.2) == dvec3(1.5, 0.9, 0));
    }
    TEST_CASE("planes that are nearly parallel to an earlier one are left out") {
        const double turn = 10 * std::numbers::pi / 180;
        const std::vector<plane> planes{{{1, 0, 0}, 1}, {{std::cos(turn), std::sin(turn), 0}, 1}};
        weld_planes chosen = all_of(planes, to_intersection);
        CHECK(chosen.nearest(planes, dvec3(1.1, 0.1, 0), 0.2) == dvec3(1, 0.1, 0));
        weld_options options = to_intersection;
        options.min_angle = turn / 2;
        chosen = all_of(planes, options);
        const dvec3 at = chosen.nearest(planes, dvec3(1.1, 0.1, 0), 0.2);
        CHECK(gap(planes[0], planes[1], at) < 1e-12);
    }
    TEST_CASE("no vertex goes beyond its limit, and no crack widens") {
        random_stream random(8);
        std::size_t closed = 0;
        for (int i = 0; i < 1000; ++i) {
            const double limit = 0.1;
            const dvec3 vertex = support::random_direction(random);
            std::vector<plane> planes;
            for (int k = 0; k < 2; ++k) {
                const dvec3 normal = support::random_direction(random);
                planes.push_back(
                    {normal, glm::dot(normal, vertex) + random.between(-limit, limit)});
            }
            for (const weld_kind kind : {weld_kind::first, weld_kind::intersection}) {
                const dvec3 at = all_of(planes, {.kind = kind}).nearest(planes, vertex, limit);
                CHECK(glm::distance(at, vertex) <= limit);
                const double after = gap(planes[0], planes[1], at);
                CHECK(after <= gap(planes[0], planes[1], vertex) + 1e-12);
                if (after < 1e-9) ++closed;
            }
        }
        CHECK(closed > 300);
    }
    TEST_CASE("without planes a vertex stays") {
        CHECK(weld_planes{}.empty());
        CHECK(weld_planes{}.nearest({}, dvec3(1, 2, 3), 1) == dvec3(1, 2, 3));
    }
}
