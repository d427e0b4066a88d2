#include <billow/density/grid.hpp>

#include <vector>

#include <doctest/doctest.h>

using namespace billow;

namespace {

std::vector<std::int64_t> contributions(const density_grid& grid, std::size_t row) {
    std::vector<std::int64_t> values;
    grid.for_each_bin(row, [&](int, std::int64_t c, std::int64_t) { values.push_back(c); });
    return values;
}

}  // namespace

TEST_SUITE("density/grid") {
    TEST_CASE("two ramps bound what lies between them") {
        density_grid grid(2, {0, 1, 5}, 1);
        // Height 8 from 1.25 to 3.5.
        grid.contribution(1)[1] = {8, 2};
        grid.contribution(1)[3] = {-8, -4};
        CHECK(contributions(grid, 1) == std::vector<std::int64_t>{0, 6, 8, 4, 0});
        CHECK(contributions(grid, 0) == std::vector<std::int64_t>(5, 0));
    }
    TEST_CASE("an interval within one bin counts its share of it") {
        density_grid grid(1, {0, 1, 3}, 1);
        grid.contribution(0)[1] = {0, 2 - 6};  // height 8 from 1.25 to 1.75
        CHECK(contributions(grid, 0) == std::vector<std::int64_t>{0, 4, 0});
    }
    TEST_CASE("an interval that ends with the last bin fills it") {
        density_grid grid(1, {0, 1, 3}, 1);
        grid.contribution(0)[0] = {8, 0};
        grid.contribution(0)[3] = {-8, 0};
        CHECK(contributions(grid, 0) == std::vector<std::int64_t>{8, 8, 8});
    }
    TEST_CASE("the densest bin is the first of the best") {
        density_grid grid(2, {-1, 1, 2}, 2);
        grid.contribution(0)[1] = {10, 0};
        grid.contribution(1)[0] = {10, 0};
        const dense_bin best = densest_bin(grid, [](std::size_t, double c, double) { return c; });
        CHECK(best.row == 0);
        CHECK(best.bin == 1);
        CHECK(best.density == 5);
        CHECK(best.contribution == 5);
    }
    TEST_CASE("the first of the best is the same for any number of threads") {
        density_grid grid(400, {0, 1, 1000}, 1);
        for (const std::size_t row : {350u, 150u, 250u}) grid.contribution(row)[7] = {10, 0};
        for (const unsigned threads : {1u, 2u, 3u, 8u}) {
            const dense_bin best =
                densest_bin(grid, [](std::size_t, double c, double) { return c; }, {threads});
            CHECK(best.row == 150);
            CHECK(best.bin == 7);
        }
    }
    TEST_CASE("bins know their centre") {
        CHECK(offset_axis{-2, 0.5, 8}.centre_of(0) == -1.75);
        CHECK(offset_axis{-2, 0.5, 8}.centre_of(7) == 1.75);
    }
}
