#include <billow/fit/svd.hpp>

#include <doctest/doctest.h>

#include "support/fitters.hpp"

using namespace billow;

TEST_SUITE("fit/svd") {
    TEST_CASE("svd_fit") { support::check_fitter(svd_fit{}); }
    TEST_CASE("no plane has smaller squared distances") {
        const face_table faces =
            support::table_of(support::near_plane({glm::normalize(dvec3(1, 2, 3)), 0.1}, 0.1));
        const plane best = svd_fit{}(faces, {glm::normalize(dvec3(1, 2, 3)), 0.1});
        const double least = support::squared_distances(faces, best);
        random_stream random(6);
        for (int i = 0; i < 200; ++i) {
            const dvec3 n = glm::normalize(best.normal + 0.05 * support::random_direction(random));
            CHECK(support::squared_distances(faces, {n, best.rho + random.between(-0.02, 0.02)}) >=
                  least);
        }
    }
    TEST_CASE("corners on a line keep the normal") {
        const face_table faces =
            support::table_of(support::triangles({{-1, 0, 0}, {1, 0, 0}, {0, 1e-5f, 0}}));
        const dvec3 n = glm::normalize(dvec3(0, 1, 1));
        CHECK(svd_fit{}(faces, {n, 0}).normal == n);
    }
}
