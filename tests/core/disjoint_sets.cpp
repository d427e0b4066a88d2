#include <billow/core/disjoint_sets.hpp>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

using namespace billow;

TEST_SUITE("core/disjoint_sets") {
    TEST_CASE("everything is its own set at first") {
        disjoint_sets sets(3);
        std::size_t count = 0;
        CHECK(sets.numbers(count) == std::vector<std::uint32_t>{0, 1, 2});
        CHECK(count == 3);
    }
    TEST_CASE("the least member leads, in whatever order sets are joined") {
        disjoint_sets sets(6);
        sets.join(5, 3);
        sets.join(3, 1);
        sets.join(4, 0);
        CHECK(sets.leader(5) == 1);
        CHECK(sets.leader(3) == 1);
        CHECK(sets.leader(4) == 0);
        CHECK(sets.leader(2) == 2);
        std::size_t count = 0;
        CHECK(sets.numbers(count) == std::vector<std::uint32_t>{0, 1, 2, 1, 0, 1});
        CHECK(count == 3);
    }
    TEST_CASE("sets agree with painting over") {
        constexpr std::uint32_t size = 200;
        disjoint_sets sets(size);
        std::vector<std::uint32_t> paint(size);
        for (std::uint32_t i = 0; i < size; ++i) paint[i] = i;
        random_stream random(1);
        for (int k = 0; k < 150; ++k) {
            const auto a = static_cast<std::uint32_t>(random.between(0, size));
            const auto b = static_cast<std::uint32_t>(random.between(0, size));
            sets.join(a, b);
            const std::uint32_t from = std::max(paint[a], paint[b]);
            const std::uint32_t to = std::min(paint[a], paint[b]);
            for (std::uint32_t& colour : paint) {
                if (colour == from) colour = to;
            }
        }
        for (std::uint32_t i = 0; i < size; ++i) CHECK(sets.leader(i) == paint[i]);
    }
    TEST_CASE("a set of nothing has no sets") {
        std::size_t count = 7;
        CHECK(disjoint_sets(0).numbers(count).empty());
        CHECK(count == 0);
    }
}
