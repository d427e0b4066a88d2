#include <billow/search/refine.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <doctest/doctest.h>

#include <billow/geometry/frame.hpp>

#include <billow/cloud/measure.hpp>
#include <billow/plane_space/cube_map.hpp>
#include <billow/plane_space/spherical.hpp>
#include <billow/search/greedy.hpp>
#include <billow/shapes/sphere.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

struct plane_as_found {
    static constexpr bool allows_less_contribution = false;
    plane operator()(const face_table&, const plane& found) const { return found; }
};

/// A patch of small triangles on the plane p, and the bin of `space` that the plane is in.
mesh tiles_on(const plane& p) {
    random_stream random(4);
    const frame axes = frame_around(p.normal);
    mesh m;
    for (int i = 0; i < 100; ++i) {
        support::add_square(
            m, vec3(axes.to_scene({random.between(-0.6, 0.6), random.between(-0.6, 0.6), p.rho})),
            vec3(axes.u * 0.02), vec3(axes.v * 0.02));
    }
    // Far corners fix the centre at 0 and the radius near 1.
    for (const float s : {-1.0f, 1.0f})
        support::add_square(m, vec3(s * 0.7f), vec3(0.01f, 0, 0), vec3(0, 0.01f, 0));
    return m;
}

template <plane_space Space>
void check_finds(const Space& space, const plane& target, int children) {
    const double epsilon = 0.02;
    const face_table all = support::table_of(tiles_on(target));
    std::vector<std::uint32_t> rows(200);
    for (std::uint32_t i = 0; i < 200; ++i) rows[i] = i;
    const face_table faces = select_rows(all, rows);
    const double rho = target.rho - glm::dot(target.normal, faces.bounds.centre);
    const orientation_patch patch = space.patch(space.orientation_of(target.normal));
    const double spacing = epsilon / 1.5;
    const double low = std::floor(rho / spacing) * spacing;
    const auto refined = refine(space, plane_bin{patch, low, low + spacing}, faces,
                                density_policies<>{}, epsilon, {.children_per_axis = children});
    REQUIRE(refined);
    CHECK(faces_valid_for(faces, refined->plane, epsilon).size() == faces.size);
    CHECK(refined->level <= 12);
}

}  // namespace

TEST_SUITE("search/refine") {
    TEST_CASE("a plane that serves all faces is found within its bin, in either plane space") {
        for (const int children : {4, 6}) {
            check_finds(cube_map(18), {glm::normalize(dvec3(0.31, 0.2, 0.93)), 0.3}, children);
            check_finds(spherical(18), {glm::normalize(dvec3(0.31, 0.2, 0.93)), 0.3}, children);
        }
    }
    TEST_CASE("at poles, cube corners, cube edges and across rho = 0 as well") {
        for (const dvec3& direction : {dvec3(0.02, 0.01, 1), dvec3(0, 0, -1), dvec3(1, 1, 1),
                                       dvec3(1, 0.97, 1), dvec3(-1, 1, 0.3), dvec3(0.4, -1, 1)}) {
            for (const double rho : {0.001, -0.003, 0.25}) {
                const plane target{glm::normalize(direction), rho};
                check_finds(cube_map(18), target, 4);
                check_finds(spherical(18), target, 4);
            }
        }
    }
    TEST_CASE("the centre plane is in the middle of its bin") {
        const cube_map space(8);
        const plane p = centre_plane(space, {space.patch(3), 0.25, 0.5});
        CHECK(p.rho == 0.375);
        CHECK(glm::distance(p.normal, space.direction(3)) < 1e-12);
    }
    TEST_CASE("a bin that no face has a plane in gives nothing") {
        const cube_map space(8);
        const face_table faces = support::table_of(support::random_triangles(20, 0.05, 1));
        CHECK_FALSE(refine(space, plane_bin{space.patch(3), 5, 5.1}, faces, density_policies<>{},
                           0.01, {}));
    }
    TEST_CASE("with penalty, even where all sub-bins are negative, refinement ends") {
        const face_table faces = support::table_of(support::random_triangles(300, 0.05, 1));
        const cube_map space(8);
        for (const double weight : {3.0, 1000.0}) {
            const density_policies policies{hull_of_samples{}, projected_area{},
                                            inner_side_penalty{weight}};
            for (const int children : {4, 6}) {
                const auto refined =
                    refine(space, plane_bin{space.patch(3), 0.2, 0.3}, faces, policies, 0.1,
                           {.children_per_axis = children, .penalty_counts = true});
                REQUIRE(refined);
                CHECK(faces_valid_for(faces, refined->plane, 0.1).size() > 0);
            }
        }
        for (const refinement kind :
             {refinement::original, refinement::fail_safe, refinement::none}) {
            const greedy_result r = greedy_search(
                faces, 300, {.epsilon = 0.1, .refine = kind, .penalty_in_refinement = true},
                pipeline{cube_map(8),
                         density_policies{hull_of_samples{}, angular_area{},
                                          inner_side_penalty{1000}, distance_falloff{}}});
            CHECK(std::ranges::count(r.cloud.plane_of_face, no_id) == 0);
        }
    }
    TEST_CASE("of areas 8, 1, 1 the falloff prefers the plane of the large face") {
        // Luksch 2009, eq 3.8: at twice epsilon from the large face, 8 against 5 in between.
        mesh m;
        support::add_square(m, {0, 0, -0.15f}, {0.4f, 0, 0}, {0, 0.4f, 0});
        for (const float x : {-0.2f, 0.2f}) {
            support::add_square(m, {x, 0, 0.04f}, {0.1414f, 0, 0}, {0, 0.1414f, 0});
        }
        const auto plane_of_large = [&](falloff_use use) {
            const greedy_result r = greedy_search(
                support::table_of(m), m.face_count(), {.epsilon = 0.1, .falloff = use},
                pipeline{cube_map{}, density_policies{hull_of_samples{}, projected_area{},
                                                      no_penalty{}, distance_falloff{}}});
            return std::pair(
                r.cloud.plane_count(),
                std::abs(signed_distance(r.cloud.planes[r.cloud.plane_of_face[0]],
                                         dvec3(m.positions[0]) - r.cloud.bounds.centre)));
        };
        CHECK(plane_of_large(falloff_use::nowhere).first == 1);
        CHECK(plane_of_large(falloff_use::nowhere).second > 0.02);
        CHECK(plane_of_large(falloff_use::everywhere).first == 2);
        CHECK(plane_of_large(falloff_use::everywhere).second < 1e-6);

        const face_table faces = support::table_of(m);
        const double large = -0.15 - faces.bounds.centre.z;
        const auto worth = [&](double rho) {
            const plane p{{0, 0, 1}, rho};
            return contribution_of(faces, faces_valid_for(faces, p, 0.1), p, projected_area{},
                                   distance_falloff{}, 0.1, 0);
        };
        CHECK(worth(large) / worth(large + 0.095) == doctest::Approx(8.0 / 5).epsilon(0.05));
    }
    TEST_CASE("without fitting the falloff lowers the mean error at about as many planes") {
        for (const mesh& m : {teapot(4), icosphere(4)}) {
            const auto run = [&](falloff_use use) {
                const greedy_result r = greedy_search(
                    support::table_of(m), m.face_count(), {.epsilon = 0.08, .falloff = use},
                    pipeline{cube_map{},
                             density_policies{hull_of_samples{}, projected_area{},
                                              inner_side_penalty{}, distance_falloff{}},
                             plane_as_found{}});
                return std::pair(measure_errors(m, r.cloud).mean_error, r.cloud.plane_count());
            };
            const auto [plain, plain_count] = run(falloff_use::nowhere);
            const auto [falling, falling_count] = run(falloff_use::everywhere);
            CHECK(falling < plain);
            CHECK(double(falling_count) <= 1.2 * double(plain_count));
        }
    }
    TEST_CASE("a search with falloff nowhere is one without it") {
        const mesh m = teapot(3);
        const auto faces_on = [&](const auto& policies) {
            return greedy_search(support::table_of(m), m.face_count(),
                                 {.epsilon = 0.08, .falloff = falloff_use::nowhere},
                                 pipeline{cube_map{}, policies})
                .cloud.plane_of_face;
        };
        CHECK(faces_on(density_policies{hull_of_samples{}, projected_area{}, inner_side_penalty{},
                                        distance_falloff{}}) == faces_on(density_policies{}));
    }
    TEST_CASE("a search with a normal threshold gives every face a plane within it") {
        const mesh m = teapot(3);
        const within_angle worth{angular_area{}, 15};
        const face_table faces = support::table_of(m);
        const greedy_result r =
            greedy_search(faces, m.face_count(), {.epsilon = 0.1},
                          pipeline{cube_map{}, density_policies{hull_of_samples{}, worth}});
        for (std::size_t row = 0; row < faces.size; ++row) {
            const plane& p = r.cloud.planes[r.cloud.plane_of_face[faces.source[row]]];
            CHECK(std::abs(glm::dot(faces.normal.get(row), p.normal)) >=
                  double(worth.least_cosine) - 1e-6);
        }
    }
}
