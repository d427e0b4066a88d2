#include <billow/improve/reassign.hpp>

#include <doctest/doctest.h>

#include <billow/fit/least_squares.hpp>
#include <billow/fit/svd.hpp>
#include <billow/search/greedy.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/covers.hpp"

using namespace billow;

namespace {

double projected_area_of(const plane_cover& cover) {
    const std::vector<plane_id> home = most_tangent_planes(cover);
    double sum = 0;
    for (std::uint32_t row = 0; row < home.size(); ++row) {
        if (home[row] == no_id) continue;
        sum += projected_area_of(cover.faces(), face_rows{row}, cover.planes()[home[row]].normal);
    }
    return sum;
}

}  // namespace

TEST_SUITE("improve/reassign") {
    TEST_CASE("a face goes to the most tangent plane, then the nearest, then the first") {
        mesh m;
        support::add_square(m, {0, 0, 0}, {0.05f, 0, 0}, {0, 0.05f, 0});
        support::add_square(m, {1, 0, 0}, {0.05f, 0, 0}, {0, 0.05f, 0});
        const face_table faces = support::table_of(m);
        const plane tilted{glm::normalize(dvec3(0, 1, 5)), 0};
        const plane level{{0, 0, 1}, 0.05};
        const plane nearer{{0, 0, -1}, -0.01};
        CHECK(most_tangent_planes({faces, {tilted, level}, 0.1, 0, {}})[0] == 1);
        CHECK(most_tangent_planes({faces, {tilted, level, nearer}, 0.1, 0, {}})[0] == 2);
        CHECK(most_tangent_planes({faces, {level, tilted, level}, 0.1, 0, {}})[0] == 0);
        CHECK(most_tangent_planes({faces, {{{0, 0, 1}, 0.5}}, 0.1, 0, {}})[0] == no_id);
        CHECK(most_tangent_planes({faces, {}, 0.1, 0, {}})[0] == no_id);
    }
    TEST_CASE("projected area never falls, and no face loses its plane") {
        const mesh soup = leaf_soup(1500, {.edge = 0.05f});
        const mesh pot = teapot(4);
        for (const mesh* m : {&soup, &pot}) {
            const face_table faces = support::table_of(*m);
            const auto check = [&](const auto& fit) {
                const billboard_cloud cloud = support::greedy_cloud(faces, 0.1);
                plane_cover cover(faces, cloud.planes, cloud.epsilon, 0, {});
                double last = projected_area_of(cover);
                const double first = last;
                for (int round = 0; round < 5; ++round) {
                    reassign_faces(cover, 1, fit);
                    const double now = projected_area_of(cover);
                    CHECK(now >= last * (1 - 1e-12));
                    last = now;
                    CHECK(std::ranges::count(cover.counts(), 0u) == 0);
                }
                CHECK(last > first);
            };
            check(average_fit{});
            check(svd_fit{});
            check(least_squares_fit{});
        }
    }
    TEST_CASE("ends by itself, where it starts the next time") {
        const face_table faces = support::table_of(teapot(3));
        const billboard_cloud cloud = support::greedy_cloud(faces, 0.15);
        plane_cover cover(faces, cloud.planes, cloud.epsilon, 0, {});
        const reassign_statistics told = reassign_faces(cover, 1000);
        CHECK(told.rounds < 500);
        CHECK(told.refits > 0);
        const std::vector<plane> planes = cover.planes();
        CHECK(reassign_faces(cover, 1000).refits == 0);
        CHECK(cover.planes() == planes);
    }
    TEST_CASE("a fit beyond epsilon is followed as far as epsilon allows") {
        mesh m;
        support::add_level_plate(m, {0, 0, 0}, 1);
        support::add_square(m, {0.9f, 0, 0.19f}, {0.01f, 0, 0}, {0, 0.01f, 0});
        const face_table faces = support::table_of(m);
        // The mean lies on the plate, 0.19 from the square.
        const plane start = support::level_plane(faces, 0.12);
        plane_cover cover(faces, {start}, 0.13, 0, {});
        CHECK(reassign_faces(cover, 3).refits == 1);
        CHECK(std::abs(cover.planes()[0].normal.z) == doctest::Approx(1));
        const plane reached = canonical(support::level_plane(faces, 0.06));
        CHECK(cover.planes()[0].rho == doctest::Approx(reached.rho).epsilon(1e-3));
        CHECK(cover.valid(0).size() == faces.size);
    }
    TEST_CASE("planes do not depend on threads") {
        const face_table faces = support::table_of(leaf_soup(1000, {.edge = 0.05f}));
        const billboard_cloud cloud = support::greedy_cloud(faces, 0.1);
        plane_cover one(faces, cloud.planes, cloud.epsilon, 0, {1});
        plane_cover three(faces, cloud.planes, cloud.epsilon, 0, {3});
        reassign_faces(one, 4, average_fit{}, {1});
        reassign_faces(three, 4, average_fit{}, {3});
        CHECK(one.planes() == three.planes());
    }
}
