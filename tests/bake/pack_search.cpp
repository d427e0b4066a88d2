#include <billow/bake/pack_search.hpp>

#include <doctest/doctest.h>

namespace {

using namespace billow;

std::int64_t area_of(const std::vector<ivec2>& sizes,
                     const std::vector<detail::strip_place>& places) {
    ivec2 corner(0);
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        const detail::strip_place& p = places[i];
        if (p.x < 0) continue;
        corner = glm::max(
            corner, ivec2(p.x, p.y) + (p.is_turned ? ivec2(sizes[i].y, sizes[i].x) : sizes[i]));
    }
    return std::int64_t{corner.x} * corner.y;
}

}  // namespace

TEST_SUITE("bake/pack_search") {
    TEST_CASE("powers of two below and above a number") {
        CHECK(detail::floor_power_of_two(1) == 1);
        CHECK(detail::floor_power_of_two(63) == 32);
        CHECK(detail::ceil_power_of_two(1) == 1);
        CHECK(detail::ceil_power_of_two(33) == 64);
        CHECK(detail::ceil_power_of_two(64) == 64);
    }

    TEST_CASE("squares of side 1 to n fill all but a few of a rectangle") {
        const auto area_for = [](int most) {
            std::vector<ivec2> sizes;
            for (int i = 1; i <= most; ++i) sizes.emplace_back(i, i);
            detail::strip_search search(sizes, 1000, true, 2'000'000);
            return area_of(sizes, search.smallest());
        };
        CHECK(area_for(5) <= 63);   // of which 55 are squares
        CHECK(area_for(8) <= 210);  // 204
    }

    TEST_CASE("a full room holds as much as can be found, and names what it does not") {
        const std::vector<ivec2> sizes{{6, 6}, {6, 6}, {4, 10}, {6, 4}, {6, 6}};
        detail::strip_search search(sizes, 10, true, 1'000'000);
        const auto places = search.smallest();
        CHECK(area_of(sizes, places) == 100);
        CHECK(std::count_if(places.begin(), places.end(), [](auto& p) { return p.x < 0; }) == 2);
    }

    TEST_CASE("turns are left out where they are not allowed") {
        const std::vector<ivec2> sizes{{1, 9}, {9, 1}, {9, 1}};
        detail::strip_search upright(sizes, 100, false, 1'000);
        for (const detail::strip_place& p : upright.smallest()) CHECK_FALSE(p.is_turned);
        detail::strip_search turned(sizes, 100, true, 100'000);
        CHECK(area_of(sizes, turned.smallest()) == 27);
    }
}
