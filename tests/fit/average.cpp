#include <billow/fit/average.hpp>

#include <doctest/doctest.h>

#include "support/fitters.hpp"

using namespace billow;

TEST_SUITE("fit/average") {
    TEST_CASE("average_fit") { support::check_fitter(average_fit{}); }
    TEST_CASE("the two sides of leaves do not cancel out") {
        mesh m;
        support::add_square(m, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
        support::add_square(m, {0.5f, 0, 0}, {0, 1, 0}, {1, 0, 0});
        const plane p = average_fit{}(support::table_of(m), {{0, 0, 1}, 0.2});
        CHECK(p.normal == dvec3(0, 0, 1));
        CHECK(p.rho == 0);
    }
}
