#include <billow/search/greedy.hpp>

#include <algorithm>
#include <limits>

#include <doctest/doctest.h>

#include <billow/cloud/measure.hpp>
#include <billow/fit/minimax.hpp>
#include <billow/fit/svd.hpp>
#include <billow/plane_space/spherical.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/sphere.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/fitters.hpp"
#include "support/meshes.hpp"

using namespace billow;

namespace {

/// Searches with epsilon as a share of the radius.
template <plane_space Space = cube_map, class Policies = density_policies<>,
          plane_fitter Fitter = least_squares_fit>
greedy_result search(const mesh& m, double share, greedy_options options = {},
                     const Space& space = Space{}, const Policies& policies = {},
                     const Fitter& fitter = {}, unsigned threads = 0) {
    face_table faces = support::table_of(m);
    options.epsilon = faces.bounds.radius > 0 ? share * faces.bounds.radius : share;
    return greedy_search(std::move(faces), m.face_count(), options,
                         pipeline{space, policies, fitter}, {threads});
}

/// Checks what every result promises: each face on one plane, within epsilon.
void check_promises(const mesh& m, const greedy_result& r) {
    const cloud_errors e = measure_errors(m, r.cloud);
    CHECK(e.max_error <= r.cloud.epsilon * (1 + 1e-9));
    CHECK(e.faces_beyond_epsilon == 0);
    CHECK(e.mapped_faces + r.statistics.degenerate_faces == m.face_count());
    CHECK(r.cloud.plane_of_face.size() == m.face_count());
    for (const plane_id id : r.cloud.plane_of_face)
        CHECK((id == no_id || id < r.cloud.plane_count()));
    for (plane_id id = 0; id < r.cloud.plane_count(); ++id) {
        CHECK(glm::length(r.cloud.planes[id].normal) == doctest::Approx(1).epsilon(1e-9));
        CHECK(r.cloud.planes[id].rho >= 0);
        CHECK(std::count(r.cloud.plane_of_face.begin(), r.cloud.plane_of_face.end(), id) > 0);
    }
}

bool is_same(const billboard_cloud& a, const billboard_cloud& b) {
    return a.planes == b.planes && a.plane_of_face == b.plane_of_face;
}

/// Two parallel squares, `distance` apart, and specks that fix the radius at about 1.
mesh walls(double distance) {
    mesh m;
    const auto z = static_cast<float>(distance / 2);
    support::add_square(m, {0, 0, z}, {0.5f, 0, 0}, {0, 0.5f, 0});
    support::add_square(m, {0, 0, -z}, {0.5f, 0, 0}, {0, 0.5f, 0});
    return m;
}

}  // namespace

TEST_SUITE("search/greedy") {
    TEST_CASE("every face ends on exactly one plane, within epsilon") {
        const mesh soup = leaf_soup(3000);
        const mesh pot = teapot(4);
        for (const double share : {0.2, 0.1, 0.05}) {
            check_promises(soup, search(soup, share));
            check_promises(pot, search(pot, share));
        }
        const mesh big = support::random_triangles(300, 0.7, 9);
        check_promises(big, search(big, 0.03));
    }
    TEST_CASE("the promise holds for every composition") {
        const mesh m = leaf_soup(1500, {.edge = 0.1f});
        check_promises(m, search(m, 0.08, {}, spherical(12)));
        check_promises(m, search(m, 0.08, {.refine = refinement::original}));
        check_promises(m, search(m, 0.08, {.refine = refinement::none}));
        check_promises(m, search(m, 0.08, {.rho_rate = 0.75}));
        check_promises(m, search(m, 0.08, {}, cube_map{8}, density_policies<>{}, no_fit{}));
        check_promises(m, search(m, 0.08, {}, cube_map{8}, density_policies<>{}, svd_fit{}));
        check_promises(m, search(m, 0.08, {}, cube_map{8}, density_policies<>{}, average_fit{}));
        check_promises(m, search(m, 0.08, {}, cube_map{8}, density_policies<>{}, minimax_fit{}));
        check_promises(m, search(m, 0.08, {}, cube_map{8},
                                 density_policies{intersection_of_vertices{}, projected_area{},
                                                  no_penalty{}}));
    }
    TEST_CASE("a box needs six planes") {
        for (const double share : {0.02, 0.05}) {
            const greedy_result r = search(box({2, 3, 4}, 3), share);
            CHECK(r.cloud.plane_count() == 6);
        }
    }
    TEST_CASE("walls 1.9 epsilon apart share a plane, 2.1 apart do not") {
        // The radius depends a little on the distance: epsilon is taken from it.
        for (const double apart : {1.9, 2.1}) {
            const double epsilon = 0.05;
            const mesh m = walls(apart * epsilon);
            greedy_options options{.epsilon = epsilon};
            const auto r = greedy_search(support::table_of(m), m.face_count(), options);
            CHECK(r.cloud.plane_count() == (apart < 2 ? 1 : 2));
            check_promises(m, r);
        }
    }
    TEST_CASE("any number of threads gives the same planes and faces") {
        const mesh m = leaf_soup(12000);
        const auto one =
            search(m, 0.1, {}, cube_map{}, density_policies<>{}, least_squares_fit{}, 1);
        for (const unsigned threads : {2u, 3u, 8u}) {
            const auto many =
                search(m, 0.1, {}, cube_map{}, density_policies<>{}, least_squares_fit{}, threads);
            CHECK(is_same(one.cloud, many.cloud));
        }
    }
    TEST_CASE("scaling and moving by powers of two change nothing but the units") {
        const mesh m = leaf_soup(1000);
        const auto base = search(m, 0.1);
        mesh scaled = m;
        for (vec3& p : scaled.positions) p *= 0x1p-20f;  // about 1e-6
        const auto small = search(scaled, 0.1);
        CHECK(small.cloud.plane_of_face == base.cloud.plane_of_face);
        CHECK(small.cloud.planes[0].normal == base.cloud.planes[0].normal);
        CHECK(small.cloud.planes[0].rho == base.cloud.planes[0].rho * 0x1p-20);

        mesh coarse = m;  // positions that survive the move exactly
        for (vec3& p : coarse.positions) p = glm::round(p * 1024.0f) / 1024.0f;
        mesh moved = coarse;
        for (vec3& p : moved.positions) p += vec3(4096, -2048, 1024);
        const auto here = search(coarse, 0.1);
        const auto there = search(moved, 0.1);
        CHECK(is_same(here.cloud, there.cloud));
        check_promises(moved, there);
    }
    TEST_CASE("turning the model by a symmetry of the cube keeps the number of planes") {
        mesh m = teapot(3);
        const std::size_t planes = search(m, 0.1).cloud.plane_count();
        for (vec3& p : m.positions) p = {p.y, p.z, p.x};
        const auto turned = search(m, 0.1);
        check_promises(m, turned);
        CHECK(turned.cloud.plane_count() <= planes + 2);
        CHECK(turned.cloud.plane_count() + 2 >= planes);
    }
    TEST_CASE("turning faces over changes nothing: they are seen from both sides") {
        mesh m = leaf_soup(800, {.edge = 0.1f});
        const auto base = search(m, 0.1, {}, cube_map{}, density_policies<>{}, no_fit{});
        for (std::size_t f = 0; f < m.face_count(); f += 2)
            std::swap(m.triangles[f].y, m.triangles[f].z);
        const auto flipped = search(m, 0.1, {}, cube_map{}, density_policies<>{}, no_fit{});
        CHECK(base.cloud.plane_of_face == flipped.cloud.plane_of_face);
    }
    TEST_CASE("a sphere needs no more planes with the penalty than without") {
        const mesh ball = icosphere(3);
        const auto with = search(ball, 0.1);
        const auto without =
            search(ball, 0.1, {}, cube_map{},
                   density_policies{hull_of_samples{}, projected_area{}, no_penalty{}});
        CHECK(with.cloud.plane_count() <= without.cloud.plane_count());
        check_promises(ball, with);
    }
    TEST_CASE("a fitted plane stays within epsilon and lowers the mean error") {
        const mesh m = support::near_plane({glm::normalize(dvec3(1, 2, 0.3)), 0.2}, 0.02);
        const auto unfitted = search(m, 0.1, {}, cube_map{}, density_policies<>{}, no_fit{});
        CHECK(unfitted.statistics.tweaks == 0);
        const auto check_better = [&](const greedy_result& fitted) {
            check_promises(m, fitted);
            CHECK(fitted.statistics.tweaks > 0);
            CHECK(measure_errors(m, fitted.cloud).mean_error <
                  0.7 * measure_errors(m, unfitted.cloud).mean_error);
        };
        check_better(search(m, 0.1));
        check_better(search(m, 0.1, {}, cube_map{}, density_policies<>{}, svd_fit{}));
        check_better(search(m, 0.1, {}, cube_map{}, density_policies<>{}, average_fit{}));
    }
    TEST_CASE("a budget of planes is kept, and every face still has the plane of least error") {
        const mesh m = leaf_soup(1000);
        const auto r = search(m, 0.05, {.max_planes = 4});
        CHECK(r.cloud.plane_count() == 4);
        const cloud_errors e = measure_errors(m, r.cloud);
        CHECK(e.mapped_faces == m.face_count());
        CHECK(r.statistics.leftover_faces >= e.faces_beyond_epsilon);
        CHECK(r.statistics.dropped_faces == 0);
        CHECK(r.statistics.beyond_epsilon_area_share ==
              doctest::Approx(e.area_beyond_epsilon_share).epsilon(1e-3));
        CHECK(e.faces_beyond_epsilon > 0);
        for (face_id face = 0; face < m.face_count(); face += 37) {
            const auto error_on = [&](const plane& p) {
                double error = 0;
                for (const vec3& c : m.corners(face)) {
                    error = std::max(
                        error, std::abs(signed_distance(p, dvec3(c) - r.cloud.bounds.centre)));
                }
                return error;
            };
            const double own = error_on(r.cloud.planes[r.cloud.plane_of_face[face]]);
            if (own <= r.cloud.epsilon) continue;
            for (const plane& p : r.cloud.planes) CHECK(own <= error_on(p) + 1e-6);
        }
    }
    TEST_CASE("statistics count every plane once") {
        const auto r = search(teapot(4), 0.06, {}, cube_map{10});
        CHECK(r.statistics.refined_planes + r.statistics.fail_safes == r.cloud.plane_count());
        CHECK(r.statistics.mean_refinement_level() > 0);
        CHECK(r.statistics.mean_refinement_level() <= 12);
        CHECK(greedy_statistics{}.mean_refinement_level() == 0);
    }
    TEST_CASE("a large penalty that makes every bin negative still finds planes") {
        const mesh m = leaf_soup(600, {.edge = 0.2f});
        check_promises(m, search(m, 0.1, {}, cube_map{},
                                 density_policies{hull_of_samples{}, projected_area{},
                                                  inner_side_penalty{1000}}));
    }
    TEST_CASE("no face, one face, only degenerate, coplanar and duplicate faces work") {
        CHECK(search(mesh{}, 0.1).cloud.plane_count() == 0);
        const mesh points = support::triangles({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
        greedy_options one_unit{.epsilon = 1};
        const auto none = greedy_search(support::table_of(points), 1, one_unit);
        CHECK(none.cloud.plane_count() == 0);
        CHECK(none.statistics.degenerate_faces == 1);
        CHECK(none.cloud.plane_of_face == std::vector<plane_id>{no_id});

        const mesh single = support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0.3f}});
        check_promises(single, search(single, 0.1));
        CHECK(search(single, 0.1).cloud.plane_count() == 1);

        mesh flat;
        for (int i = 0; i < 20; ++i)
            support::add_square(flat, {float(i), float(i % 3), 2}, {0.5f, 0, 0}, {0, 0.4f, 0});
        check_promises(flat, search(flat, 0.01));
        CHECK(search(flat, 0.01).cloud.plane_count() == 1);

        mesh doubled = leaf_soup(100);
        doubled.triangles.insert(doubled.triangles.end(), doubled.triangles.begin(),
                                 doubled.triangles.end());
        check_promises(doubled, search(doubled, 0.1));
    }
    TEST_CASE("an epsilon near zero ends, with a plane a face at most") {
        const mesh m = support::random_triangles(40, 0.3, 8);
        const auto tiny = search(m, 1e-5);
        check_promises(m, tiny);
        CHECK(tiny.cloud.plane_count() == 40);
        const auto vanishing = search(m, 1e-12);  // below what floats resolve: it must only end
        CHECK(vanishing.cloud.plane_count() <= 40);
        CHECK(measure_errors(m, vanishing.cloud).max_error < 1e-6);
    }
    TEST_CASE("the assignment of a small model is the known one") {
        // Recorded from this implementation on the reference build (g++ -ffp-contract=off) after
        // the result had been looked at: a change must be explained.
        const greedy_result r = search(teapot(2), 0.12);
        std::uint64_t hash = 0;
        for (const plane_id id : r.cloud.plane_of_face) hash = mix_bits(hash ^ id);
        CHECK(r.cloud.plane_count() == 9);
        CHECK(hash == 318447043119646189u);
    }
    TEST_CASE("progress rises to 1") {
        const mesh m = leaf_soup(500);
        double last = 0;
        greedy_options options{.epsilon = 0.1};
        (void)greedy_search(support::table_of(m), m.face_count(), options, pipeline{cube_map{8}},
                            {}, [&](std::string_view stage, double share) {
                                CHECK(stage == "search");
                                CHECK(share >= last);
                                last = share;
                            });
        CHECK(last == doctest::Approx(1));
    }
}
