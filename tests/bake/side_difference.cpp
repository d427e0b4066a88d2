#include <billow/bake/side_difference.hpp>

#include <doctest/doctest.h>

namespace {

using namespace billow;

tile_picture plain_tile(int width, int height, const vec3& color) {
    tile_picture tile = empty_tile({width, height}, 1, false);
    for (std::size_t i = 0; i < tile.texel_count(); ++i) {
        for (int c = 0; c < 3; ++c) {
            tile.channels.base_color.bytes[4 * i + static_cast<std::size_t>(c)] =
                static_cast<std::uint8_t>(color[c]);
        }
    }
    tile.covered.assign(tile.texel_count(), 1);
    return tile;
}

}  // namespace

TEST_SUITE("bake/side_difference") {
    TEST_CASE("equal sides do not differ, black and white do wholly") {
        const auto black = plain_tile(20, 13, {0, 0, 0});
        CHECK(side_difference(black, black) == 0);
        CHECK(side_difference(black, plain_tile(20, 13, {255, 255, 255})) == doctest::Approx(1));
        CHECK(side_difference(black, plain_tile(20, 13, {255, 0, 0})) ==
              doctest::Approx(1 / std::sqrt(3.0)));
    }
    TEST_CASE("the back is seen mirrored") {
        auto front = plain_tile(16, 8, {0, 0, 0});
        auto back = front;
        for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 8; ++x) {
                front.channels.base_color.pixel(x, y)[0] = 255;
                back.channels.base_color.pixel(8 + x, y)[0] = 255;
            }
        }
        CHECK(side_difference(front, back) == doctest::Approx(0));
        CHECK(side_difference(front, front) > 0.5);
    }
    TEST_CASE("leaves of one colour in other places are no difference") {
        auto front = plain_tile(8, 8, {60, 120, 30});
        auto back = front;
        for (std::size_t i = 0; i < 64; ++i) (i % 3 == 0 ? front : back).covered[i] = 0;
        CHECK(side_difference(front, back) == doctest::Approx(0));
    }
    TEST_CASE("what only one side covers differs") {
        const auto front = plain_tile(16, 8, {60, 120, 30});
        auto back = front;
        for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 8; ++x) back.covered[back.index(x, y)] = 0;
        }
        CHECK(side_difference(front, back) == doctest::Approx(0.5));
        CHECK(side_difference(empty_tile({4, 4}, 1, false), empty_tile({4, 4}, 1, false)) == 0);
    }
}
