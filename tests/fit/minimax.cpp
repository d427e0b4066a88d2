#include <billow/fit/minimax.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <billow/fit/least_squares.hpp>
#include <billow/fit/svd.hpp>

#include "support/fitters.hpp"

using namespace billow;

namespace {

double largest_distance(const face_table& faces, const plane& p) {
    double largest = 0;
    for (const columns3& corner : faces.corner) {
        for (std::size_t row = 0; row < faces.size; ++row) {
            largest = std::max(largest, std::abs(signed_distance(p, corner.get(row))));
        }
    }
    return largest;
}

}  // namespace

TEST_SUITE("fit/minimax") {
    TEST_CASE("a plane of least largest distance is found, whichever way faces look") {
        const plane truth{glm::normalize(dvec3(0.2, -0.9, 0.4)), 0.3};
        const plane start{glm::normalize(truth.normal + dvec3(0.06, 0.03, -0.02)), 0.25};
        const face_table faces = support::table_of(support::near_plane(truth, 0, true));
        const plane found = minimax_fit{}(faces, support::centred(start, faces));
        CHECK(glm::dot(found.normal, truth.normal) > std::cos(0.1 * std::numbers::pi / 180));
        CHECK(largest_distance(faces, found) < 2e-3);
        CHECK(minimax_fit{}(face_table{}, start) == start);
    }
    TEST_CASE("no plane nearby has a smaller largest distance, nor do the least squares") {
        const plane start{glm::normalize(dvec3(1, 2, 3)), 0.1};
        const face_table faces = support::table_of(support::near_plane(start, 0.1));
        const plane from = support::centred(start, faces);
        const plane best = minimax_fit{}(faces, from);
        const double least = largest_distance(faces, best);
        CHECK(least <= largest_distance(faces, least_squares_fit{}(faces, from)) + 1e-4);
        CHECK(least <= largest_distance(faces, svd_fit{}(faces, from)) + 1e-4);
        random_stream random(6);
        for (int i = 0; i < 300; ++i) {
            const double tilt = random.between(0, 0.1);
            const dvec3 n = glm::normalize(best.normal + tilt * support::random_direction(random));
            CHECK(largest_distance(faces, {n, best.rho + random.between(-0.02, 0.02)}) >=
                  least - 1e-4);
        }
    }
    TEST_CASE("what lies within epsilon of the start plane stays so") {
        random_stream random(9);
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            const face_table faces = support::table_of(support::random_triangles(30, 0.3, seed));
            const plane start{support::random_direction(random), random.between(-0.2, 0.2)};
            CHECK(largest_distance(faces, minimax_fit{}(faces, start)) <=
                  largest_distance(faces, start) + 1e-12);
        }
    }
}
