#include <billow/fit/least_squares.hpp>

#include <cmath>

#include <doctest/doctest.h>

#include "support/fitters.hpp"

using namespace billow;

TEST_SUITE("fit/least_squares") {
    TEST_CASE("least_squares_fit") { support::check_fitter(least_squares_fit{}); }
    TEST_CASE("heights over the start plane have the smallest squares") {
        const plane start{glm::normalize(dvec3(1, 2, 3)), 0.1};
        const face_table faces = support::table_of(support::near_plane(start, 0.1));
        const plane from = support::centred(start, faces);
        const auto height_squares = [&](const plane& p) {
            return support::squared_distances(faces, p) /
                   std::pow(glm::dot(p.normal, from.normal), 2);
        };
        const plane best = least_squares_fit{}(faces, from);
        random_stream random(6);
        for (int i = 0; i < 200; ++i) {
            const dvec3 n = glm::normalize(best.normal + 0.05 * support::random_direction(random));
            CHECK(height_squares({n, best.rho + random.between(-0.02, 0.02)}) >=
                  height_squares(best) * (1 - 1e-9));
        }
    }
}
