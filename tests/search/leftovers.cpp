#include <billow/search/leftovers.hpp>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// A square at height z, made of two faces, and specks that fix the centre at the origin.
mesh squares(const std::vector<float>& heights) {
    mesh m;
    for (const float z : heights) support::add_square(m, {0, 0, z}, {1, 0, 0}, {0, 1, 0});
    return m;
}

const std::vector<plane> floors{{{0, 0, 1}, 0}, {{0, 0, 1}, 1}};

}  // namespace

TEST_SUITE("search/leftovers") {
    TEST_CASE("a face goes to the nearest plane, among equals the first") {
        const face_table faces = support::table_of(squares({-1, -0.4f, 0.4f, 0.5f, 0.7f, 1}));
        const std::vector<plane_id> nearest{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1};
        CHECK(planes_of_least_error(faces, floors) == nearest);
        CHECK(nearest_planes_within(faces, floors, 1, {}) == nearest);
    }
    TEST_CASE("faces beyond the reach are dropped, unless a budget keeps all") {
        const face_table faces = support::table_of(squares({-1, 0.3f, 1}));
        CHECK(nearest_planes_within(faces, floors, 0.1, {.reach = 2}) ==
              std::vector<plane_id>{no_id, no_id, no_id, no_id, 1, 1});
        CHECK(nearest_planes_within(faces, floors, 0.1, {.reach = 4}) ==
              std::vector<plane_id>{no_id, no_id, 0, 0, 1, 1});
        CHECK(planes_of_least_error(faces, floors) == std::vector<plane_id>{0, 0, 0, 0, 1, 1});
    }
    TEST_CASE("a face that a plane sees edge-on goes to a farther one that shows it") {
        mesh m;
        support::add_square(m, {0, 0, 0.1f}, {0.1f, 0, 0}, {0, 0, 0.1f});  // upright
        const face_table faces = support::table_of(m);
        const double y = -faces.bounds.centre.y;
        const std::vector<plane> planes{{{0, 0, 1}, 0}, {{0, 1, 0}, y + 0.15}};
        CHECK(nearest_planes_within(faces, planes, 0.1, {}) == std::vector<plane_id>{1, 1});
        CHECK(nearest_planes_within(faces, planes, 0.1, {.least_projection = 0}) ==
              std::vector<plane_id>{0, 0});
        CHECK(nearest_planes_within(faces, std::span(planes).first(1), 0.1, {}) ==
              std::vector<plane_id>{no_id, no_id});
    }
    TEST_CASE("the sum of distances and the largest one may disagree") {
        const face_table faces =
            support::table_of(support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0.9f}}));
        const double low = -faces.bounds.centre.z;
        const std::vector<plane> planes{{{0, 0, 1}, low}, {{0, 0, 1}, low + 0.45}};
        CHECK(nearest_planes_within(faces, planes, 1, {}) == std::vector<plane_id>{0});
        CHECK(planes_of_least_error(faces, planes) == std::vector<plane_id>{1});
    }
    TEST_CASE("no faces, no planes") {
        CHECK(planes_of_least_error(face_table{}, floors).empty());
        const face_table faces = support::table_of(squares({1}));
        CHECK(planes_of_least_error(faces, {}) == std::vector<plane_id>{no_id, no_id});
    }
    TEST_CASE("any number of threads gives the same planes") {
        const face_table faces = support::table_of(support::random_triangles(5000, 0.1, 4));
        CHECK(nearest_planes_within(faces, floors, 0.1, {}, {1}) ==
              nearest_planes_within(faces, floors, 0.1, {}, {3}));
    }
}
