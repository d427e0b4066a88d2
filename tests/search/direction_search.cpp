#include <billow/search/direction_search.hpp>

#include <doctest/doctest.h>

#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

double weigh_none(const dvec3&) { return 1; }

}  // namespace

TEST_SUITE("search/direction_search") {
    TEST_CASE("a wall that is askew to the start is found to a tenth of a degree") {
        mesh m;
        const dvec3 wall = glm::normalize(dvec3(0.05, 0.04, 1));
        const frame axes = frame_around(wall);
        support::add_square(m, vec3(wall * 0.4), vec3(axes.u * 0.5), vec3(axes.v * 0.5));
        support::add_square(m, {0, 0, -0.8f}, {0.01f, 0, 0}, {0, 0.01f, 0});
        const face_table faces = support::table_of(m);
        const double epsilon = 0.06;
        const projected_area worth;
        const no_penalty none;
        const offset_sweep sweep(worth, none, epsilon, faces.bounds.radius, density_scale(faces));
        direction_scratch scratch;
        const dvec3 start(0, 0, 1);
        const swept_offset at =
            sweep.best(faces, vec3(start), {}, -1e300, scratch.buckets, scratch.sweep);
        REQUIRE(at.is_found);
        const directed_plane found =
            search_directions(sweep, faces, {start, at}, epsilon, worth, weigh_none, 0,
                              {.last_step = 0.02 * std::numbers::pi / 180}, scratch);
        CHECK(glm::distance(found.normal, wall) < 0.1 * std::numbers::pi / 180);
        CHECK(found.at.density > at.density);
    }
    TEST_CASE("what is found is no worse than the start, and no better than it says") {
        const face_table faces = support::table_of(leaf_soup(1000));
        const double epsilon = 0.1 * faces.bounds.radius;
        const projected_area worth;
        const inner_side_penalty penalty{2};
        const offset_sweep sweep(worth, penalty, epsilon, faces.bounds.radius,
                                 density_scale(faces));
        direction_scratch scratch;
        random_stream random(6);
        for (const double charge : {0.0, 2.0}) {
            double gained = 0;
            for (int i = 0; i < 4; ++i) {
                const dvec3 start = support::random_direction(random);
                const swept_offset at = sweep.best(faces, vec3(start), {1, charge}, -1e300,
                                                   scratch.buckets, scratch.sweep);
                const directed_plane found = search_directions(
                    sweep, faces, {start, at}, epsilon, worth, weigh_none, charge, {}, scratch);
                CHECK(found.at.density >= at.density);
                CHECK(glm::length(found.normal) == doctest::Approx(1).epsilon(1e-9));
                gained += found.at.density / at.density - 1;
                const swept_offset there = sweep.best(faces, vec3(found.normal), {1, charge},
                                                      -1e300, scratch.buckets, scratch.sweep);
                CHECK(there.density >= found.at.density);
            }
            CHECK(gained > 0);
        }
    }
    TEST_CASE("weights of normals are kept to") {
        const face_table faces = support::table_of(leaf_soup(1000));
        const projected_area worth;
        const no_penalty none;
        const offset_sweep sweep(worth, none, 0.1, faces.bounds.radius, density_scale(faces));
        direction_scratch scratch;
        const dvec3 start(0, 1, 0);
        const swept_offset at =
            sweep.best(faces, vec3(start), {}, -1e300, scratch.buckets, scratch.sweep);
        const auto only_start = [&](const dvec3& n) { return n == start ? 1.0 : 1e-3; };
        const directed_plane found =
            search_directions(sweep, faces, {start, at}, 0.1, worth, only_start, 0, {}, scratch);
        CHECK(found.normal == start);
    }
}
