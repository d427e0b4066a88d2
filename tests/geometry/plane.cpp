#include <billow/geometry/plane.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("geometry/plane") {
    TEST_CASE("the distance is positive on the normal's side") {
        const plane p{{0, 0, 1}, 2};
        CHECK(signed_distance(p, {5, 6, 3}) == 1);
        CHECK(signed_distance(p, {5, 6, 0}) == -2);
    }
    TEST_CASE("the canonical plane has an outward normal and the same points") {
        const plane p{{0, 0.6, -0.8}, -3};
        const plane c = canonical(p);
        CHECK(c.rho == 3);
        CHECK(signed_distance(c, {1, 2, 3}) == -signed_distance(p, {1, 2, 3}));
        CHECK(canonical(c) == c);
    }
}
