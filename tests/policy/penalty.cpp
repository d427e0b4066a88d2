#include <billow/policy/penalty.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("policy/penalty") {
    TEST_CASE("planes up to epsilon further in are charged, none further out") {
        const auto charged = inner_side_penalty{}(offset_interval<float>{0.5f, 0.7f}, 0.125f);
        CHECK(charged.low == 0.375f);
        CHECK(charged.high == 0.5f);
        CHECK(inner_side_penalty{}.weight == 3);
    }
    TEST_CASE("no penalty charges an empty range") {
        const auto charged = no_penalty{}(offset_interval<float>{0.5f, 0.7f}, 0.125f);
        CHECK(charged.low == charged.high);
        CHECK(no_penalty::weight == 0);
    }
}
