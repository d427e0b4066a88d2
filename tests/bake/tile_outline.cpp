#include <billow/bake/tile_outline.hpp>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

tile_picture disc(int side, double radius) {
    tile_picture tile = empty_tile({side, side}, 1, false);
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            const dvec2 off(x + 0.5 - side / 2.0, y + 0.5 - side / 2.0);
            tile.alpha(tile.index(x, y)) = glm::length(off) < radius ? 255 : 0;
        }
    }
    return tile;
}

bool is_inside(const std::vector<dvec2>& polygon, const dvec2& p) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const dvec2& a = polygon[i];
        const dvec2& b = polygon[(i + 1) % polygon.size()];
        if (detail::turn(a, b, p) < -1e-9) return false;
    }
    return true;
}

}  // namespace

TEST_SUITE("bake/tile_outline") {
    TEST_CASE("the box holds every opaque texel and not a column more") {
        random_stream random(1);
        for (int round = 0; round < 200; ++round) {
            tile_picture tile = empty_tile({17, 11}, 1, false);
            texel_box expected{};
            for (int i = 0; i < random.between(0, 5); ++i) {
                const ivec2 at(random.between(0, 16), random.between(0, 10));
                tile.alpha(tile.index(at.x, at.y)) = 255;
                expected = joined(expected, {at.x, at.y, 1, 1});
            }
            CHECK(drawn_box(tile) == expected);
        }
    }
    TEST_CASE("half-transparent texels count beside opaque ones alone") {
        tile_picture tile = empty_tile({9, 3}, 1, false);
        tile.alpha(tile.index(3, 1)) = 200;
        tile.alpha(tile.index(4, 1)) = 100;
        tile.alpha(tile.index(7, 1)) = 100;
        CHECK(drawn_box(tile) == texel_box{3, 1, 2, 1});
        CHECK(drawn_box(empty_tile({9, 3}, 1, false)) == texel_box{});
    }
    TEST_CASE("a box on the other side of a tile lies as far from the other edge") {
        CHECK(mirrored({1, 2, 3, 4}, 10) == texel_box{6, 2, 3, 4});
        CHECK(mirrored(mirrored({1, 2, 3, 4}, 10), 10) == texel_box{1, 2, 3, 4});
    }
    TEST_CASE("outlines hold all opaque texels, with few corners, more of them with less area") {
        const tile_picture tile = disc(64, 31);
        double before = 1;
        for (const int most : {4, 5, 6, 7, 8}) {
            std::vector<dvec2> corners;
            add_drawn_corners(tile, false, corners);
            const auto outline = outline_around(corners, {64, 64}, most);
            CHECK(outline.size() <= static_cast<std::size_t>(most));
            for (int y = 0; y < 64; ++y) {
                for (int x = 0; x < 64; ++x) {
                    if (tile.alpha(tile.index(x, y)) == 0) continue;
                    for (const ivec2 k : {ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(1, 1)}) {
                        REQUIRE(is_inside(outline, dvec2(x + k.x, 64 - y - k.y) / 64.0));
                    }
                }
            }
            const double area = 0.5 * doubled_area(outline);
            CHECK(area <= before + 1e-9);
            before = area;
        }
        CHECK(before < 0.84);  // an octagon around a disc: 0.83 of the square
    }
    TEST_CASE("the back's outline is the front's mirror image") {
        tile_picture tile = empty_tile({8, 4}, 1, false);
        for (int x = 0; x < 3; ++x) tile.alpha(tile.index(x, 1)) = 255;
        std::vector<dvec2> front;
        std::vector<dvec2> back;
        add_drawn_corners(tile, false, front);
        add_drawn_corners(tile, true, back);
        REQUIRE(front.size() == back.size());
        for (std::size_t i = 0; i < front.size(); ++i) {
            CHECK(front[i].x == 8 - back[i].x);
            CHECK(front[i].y == back[i].y);
        }
    }
}
