#include <billow/search/leftovers.hpp>

#include <doctest/doctest.h>

#include <billow/cloud/measure.hpp>
#include <billow/plants/species.hpp>
#include <billow/search/greedy.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/searches.hpp"

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
    TEST_CASE("skipping 2 % of the area saves planes; no face is dragged far") {
        const mesh pot = teapot(6);
        const mesh tree = *tree_of_about(3000);
        for (const mesh* m : {&pot, &tree}) {
            const auto all = support::coarse_search(*m, 0.08, {});
            const auto r = support::coarse_search(*m, 0.08, {.skip_area = 0.02});
            const greedy_statistics& s = r.statistics;
            const cloud_errors e = measure_errors(*m, r.cloud);
            CHECK(r.cloud.plane_count() + 3 <= all.cloud.plane_count());
            // The planes are the first of the full search.
            for (plane_id id = 0; id < r.cloud.plane_count(); ++id) {
                CHECK(r.cloud.planes[id] == all.cloud.planes[id]);
            }
            CHECK(s.leftover_faces > 0);
            CHECK(s.leftover_area_share < 0.02);
            CHECK(s.dropped_area_share <= s.leftover_area_share);
            CHECK(e.mapped_faces + s.dropped_faces + s.degenerate_faces == m->face_count());
            CHECK(e.max_error <= 2 * r.cloud.epsilon * (1 + 1e-5));
            CHECK(e.dropped_area_share == doctest::Approx(s.dropped_area_share).epsilon(1e-3));
            CHECK(e.area_beyond_epsilon_share ==
                  doctest::Approx(s.beyond_epsilon_area_share).epsilon(1e-3));
            CHECK(all.statistics.leftover_faces == 0);
            CHECK(all.statistics.dropped_area_share == 0);
        }
    }
    TEST_CASE("a far face is dropped rather than drawn on a plane it does not belong to") {
        mesh m;
        for (int i = 0; i < 30; ++i) {
            support::add_square(m, {float(i % 6), float(i / 6), 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
        }
        support::add_square(m, {2, 2, 2}, {0.1f, 0, 0}, {0, 0.1f, 0});
        greedy_options options{.epsilon = 0.1, .skip_area = 0.02};
        const auto r = greedy_search(support::table_of(m), m.face_count(), options);
        CHECK(r.cloud.plane_count() == 1);
        CHECK(r.statistics.leftover_faces == 2);
        CHECK(r.statistics.dropped_faces == 2);
        CHECK(r.cloud.plane_of_face[60] == no_id);
        CHECK(r.cloud.plane_of_face[61] == no_id);
        options.skipped.reach = 30;
        const auto near = greedy_search(support::table_of(m), m.face_count(), options);
        CHECK(near.statistics.dropped_faces == 0);
        CHECK(near.cloud.planes == r.cloud.planes);
    }
    TEST_CASE("planes that collect less than the minimum end the search, but never the first") {
        const mesh tree = *tree_of_about(2000);
        const auto all = support::coarse_search(tree, 0.1, {});
        const auto r = support::coarse_search(tree, 0.1, {.min_contribution = 0.005});
        CHECK(r.cloud.plane_count() < all.cloud.plane_count());
        CHECK(r.cloud.plane_count() > 1);
        CHECK(support::coarse_search(tree, 0.1, {.min_contribution = 0.99}).cloud.plane_count() ==
              1);
    }
}
