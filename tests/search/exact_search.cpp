#include <billow/search/exact_search.hpp>

#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include <billow/cloud/measure.hpp>
#include <billow/fit/minimax.hpp>
#include <billow/fit/svd.hpp>
#include <billow/plane_space/spherical.hpp>
#include <billow/search/compact.hpp>
#include <billow/search/greedy.hpp>
#include <billow/search/weld_online.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/sphere.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

using free_policies = density_policies<hull_of_samples, projected_area, no_penalty>;

template <class... Parts>
greedy_result search_exactly(const mesh& m, double share, exact_search_options options,
                             const pipeline<Parts...>& parts, unsigned threads = 0) {
    face_table faces = support::table_of(m);
    options.epsilon = faces.bounds.radius > 0 ? share * faces.bounds.radius : share;
    return exact_search(std::move(faces), m.face_count(), options, parts, {threads});
}
greedy_result search_exactly(const mesh& m, double share,
                             const exact_search_options& options = {}) {
    return search_exactly(m, share, options, pipeline{cube_map(8), free_policies{}});
}

/// Each face on one plane, within epsilon; the curve of areas rises to all of it.
void check_exact_promises(const mesh& m, const greedy_result& r) {
    const cloud_errors e = measure_errors(m, r.cloud);
    CHECK(e.max_error <= r.cloud.epsilon * (1 + 1e-9));
    CHECK(e.faces_beyond_epsilon == 0);
    CHECK(e.mapped_faces + r.statistics.degenerate_faces == m.face_count());
    CHECK(r.cloud.plane_of_face.size() == m.face_count());
    for (plane_id id = 0; id < r.cloud.plane_count(); ++id) {
        CHECK(glm::length(r.cloud.planes[id].normal) == doctest::Approx(1).epsilon(1e-9));
        CHECK(r.cloud.planes[id].rho >= 0);
        CHECK(std::count(r.cloud.plane_of_face.begin(), r.cloud.plane_of_face.end(), id) > 0);
    }
    CHECK(r.covered_area.size() == r.cloud.plane_count());
    CHECK(std::ranges::is_sorted(r.covered_area));
    if (!r.covered_area.empty()) CHECK(r.covered_area.back() == doctest::Approx(1));
}

std::size_t density_planes(const mesh& m, double share, double& projected) {
    face_table faces = support::table_of(m);
    const double epsilon = share * faces.bounds.radius;
    const greedy_result r = greedy_search(std::move(faces), m.face_count(), {.epsilon = epsilon},
                                          pipeline{cube_map(8), free_policies{}});
    projected = measure_errors(m, r.cloud).projected_area_share;
    return r.cloud.plane_count();
}

bool is_same(const greedy_result& a, const greedy_result& b) {
    return a.cloud.planes == b.cloud.planes && a.cloud.plane_of_face == b.cloud.plane_of_face &&
           a.covered_area == b.covered_area;
}

}  // namespace

TEST_SUITE("search/exact_search") {
    TEST_CASE("every face ends on exactly one plane, within epsilon") {
        for (const double share : {0.2, 0.07}) {
            check_exact_promises(leaf_soup(500), search_exactly(leaf_soup(500), share));
            check_exact_promises(teapot(2), search_exactly(teapot(2), share));
        }
        const mesh big = support::random_triangles(60, 0.7, 9);
        check_exact_promises(big, search_exactly(big, 0.03));
    }
    TEST_CASE("the promise holds for every composition") {
        const mesh m = leaf_soup(150, {.edge = 0.1f});
        const cube_map coarse(6);
        const auto check = [&](const auto& parts, const exact_search_options& options = {}) {
            check_exact_promises(m, search_exactly(m, 0.1, options, parts));
        };
        check(pipeline{coarse});
        check(pipeline{spherical(4), density_policies<>{}, no_fit{}});
        check(pipeline{coarse, density_policies{hull_of_samples{}, angular_area{}}, svd_fit{}});
        check(pipeline{coarse, density_policies{hull_of_samples{}, within_angle<>({}, 50)},
                       minimax_fit{}});
        check(pipeline{coarse, density_policies{hull_of_samples{}, projected_area{}, no_penalty{},
                                                distance_falloff{}, horizontal_penalty{}}},
              {.distribution = {.strength = 0.3}});
        check(pipeline{coarse, free_policies{}, least_squares_fit{}, heaviest_group<>{}});
        check(pipeline{coarse, free_policies{}},
              {.method = {.tangency = 2, .tail = 0, .starts = 0}});
        check(pipeline{coarse, free_policies{}}, {.method = {.tail = 1, .starts = 9}});
    }
    TEST_CASE("vertices may move during the search") {
        const mesh m = teapot(2);
        const auto r = search_exactly(m, 0.1, {},
                                      pipeline{cube_map(6), free_policies{}, least_squares_fit{},
                                               whole_set{}, weld_online{}});
        const cloud_errors e = measure_errors(m, r.cloud);
        CHECK(e.max_error <= r.cloud.epsilon * (1 + 1e-9));
        CHECK(e.mapped_faces + r.statistics.degenerate_faces == m.face_count());
        CHECK(!r.moved.empty());
    }
    TEST_CASE("no more planes than the density grid, and as frontal") {
        for (const mesh& m : {teapot(3), leaf_soup(1000), icosphere(2)}) {
            double share = 0;
            const std::size_t planes = density_planes(m, 0.1, share);
            const greedy_result r = search_exactly(m, 0.1);
            CHECK(r.cloud.plane_count() <= planes);
            CHECK(measure_errors(m, r.cloud).projected_area_share > share - 0.02);
        }
    }
    TEST_CASE("the teapot of a thousand faces needs ten planes at a tenth of its radius") {
        CHECK(search_exactly(teapot(4), 0.1, {}, pipeline{cube_map{}, free_policies{}})
                  .cloud.plane_count() <= 10);
    }
    TEST_CASE("a box needs six planes, which lie in its sides") {
        const mesh m = box({2, 3, 4}, 2);
        const greedy_result r = search_exactly(m, 0.03);
        CHECK(r.cloud.plane_count() == 6);
        CHECK(measure_errors(m, r.cloud).max_error < 1e-5);
    }
    TEST_CASE("the first plane collects the most of all planes tried") {
        const mesh m = leaf_soup(200);
        const face_table faces = support::table_of(m);
        const double epsilon = 0.1 * faces.bounds.radius;
        const projected_area worth;
        const auto collects = [&](const plane& p) {
            return contribution_of(faces, faces_valid_for(faces, p, epsilon), p.normal, worth);
        };
        const auto r = search_exactly(m, 0.1, {.max_planes = 1},
                                      pipeline{cube_map(6), free_policies{}, no_fit{}});
        const double most = collects(r.cloud.planes[0]);
        const cube_map space(6);
        for (orientation_id id = 0; id < space.orientation_count(); ++id) {
            for (double rho = 0; rho < 1; rho += 0.07) {
                CHECK(collects({space.direction(id), rho}) <= most * (1 + 1e-4));
            }
        }
    }
    TEST_CASE("any number of threads gives the same planes and faces") {
        const mesh m = leaf_soup(2600);
        for (const auto& options : {exact_search_options{}, {.coverage = 0.9}}) {
            const auto with = [&](unsigned threads) {
                return search_exactly(m, 0.1, options, pipeline{cube_map(8)}, threads);
            };
            const greedy_result one = with(1);
            for (const unsigned threads : {2u, 3u}) CHECK(is_same(one, with(threads)));
        }
    }
    TEST_CASE("coverage ends the search, and faces that are left stay within its limits") {
        const mesh m = leaf_soup(600);
        const greedy_result all = search_exactly(m, 0.1);
        const greedy_result most = search_exactly(m, 0.1, {.coverage = 0.9});
        CHECK(most.cloud.plane_count() < all.cloud.plane_count());
        CHECK(most.covered_area.back() >= 0.9);
        CHECK(most.covered_area[most.cloud.plane_count() - 2] < 0.9);
        CHECK(most.statistics.leftover_faces > 0);
        CHECK(most.statistics.leftover_area_share ==
              doctest::Approx(1 - most.covered_area.back()).epsilon(1e-6));
        const cloud_errors e = measure_errors(m, most.cloud);
        CHECK(e.max_error <= 2 * most.cloud.epsilon * (1 + 1e-6));
        CHECK(e.dropped_area_share == doctest::Approx(most.statistics.dropped_area_share));

        const greedy_result dropped = search_exactly(
            m, 0.1, {.coverage = 0.9, .skipped = {.reach = 1e-9, .least_projection = 1}});
        CHECK(dropped.statistics.dropped_faces == dropped.statistics.leftover_faces);
        const greedy_result nearest = search_exactly(
            m, 0.1, {.coverage = 0.9, .skipped = {.reach = 1e9, .least_projection = 0}});
        CHECK(nearest.statistics.dropped_faces == 0);
    }
    TEST_CASE("tangency shows faces more frontally") {
        const mesh m = leaf_soup(600);
        const auto share = [&](double tangency) {
            const greedy_result r = search_exactly(m, 0.1, {.method = {.tangency = tangency}});
            check_exact_promises(m, r);
            return measure_errors(m, r.cloud).projected_area_share;
        };
        CHECK(share(3) > share(0) + 0.01);
    }
    TEST_CASE("an unlit start: empty, one face, no area, faces wider than two epsilons") {
        const auto none = search_exactly(mesh{}, 0.1);
        CHECK(none.cloud.plane_count() == 0);
        CHECK(none.covered_area.empty());

        const mesh one = support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0.3f}});
        const auto of_one = search_exactly(one, 0.001);
        CHECK(of_one.cloud.plane_count() == 1);
        check_exact_promises(one, of_one);

        mesh flat = support::triangles(
            {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.3f}, {0, 0, 0}, {1, 1, 1}, {2, 2, 2}});
        check_exact_promises(flat, search_exactly(flat, 0.1));
        const mesh line = support::triangles({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}});
        CHECK(search_exactly(line, 0.1).cloud.plane_count() == 0);

        const mesh wide = support::random_triangles(20, 0.8, 11);
        const auto of_wide = search_exactly(wide, 1e-4);
        check_exact_promises(wide, of_wide);
        CHECK(of_wide.cloud.plane_count() == 20);
        CHECK(of_wide.statistics.fail_safes > 0);
    }
    TEST_CASE("a number of planes ends the search") {
        const mesh m = leaf_soup(300);
        const auto r = search_exactly(m, 0.1, {.max_planes = 3});
        CHECK(r.cloud.plane_count() == 3);
        CHECK(r.statistics.leftover_faces > 0);
        CHECK(measure_errors(m, r.cloud).mapped_faces == 300);
    }
}
