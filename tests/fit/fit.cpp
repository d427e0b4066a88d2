#include <billow/fit/fit.hpp>

#include <doctest/doctest.h>

#include "support/fitters.hpp"

using namespace billow;

TEST_SUITE("fit/fit") {
    TEST_CASE("no_fit keeps the plane") {
        const plane p{{0, 1, 0}, 3};
        CHECK(no_fit{}(support::table_of(support::random_triangles(3, 0.2, 1)), p) == p);
    }
}
