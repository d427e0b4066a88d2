#include <billow/bake/place_tiles.hpp>

#include <set>
#include <utility>

#include <doctest/doctest.h>

namespace {

using namespace billow;

/// A tile whose texels tell their column and row; all are covered.
tile_picture numbered_tile(int width, int height) {
    tile_picture tile = empty_tile({width, height}, 1, true);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            for (image* channel : {&tile.channels.base_color, &tile.channels.normal,
                                   &tile.channels.occlusion_roughness_metallic,
                                   &tile.channels.emissive, &tile.channels.horizon}) {
                channel->pixel(x, y)[0] = static_cast<std::uint8_t>(x);
                channel->pixel(x, y)[1] = static_cast<std::uint8_t>(100 + y);
            }
        }
    }
    tile.covered.assign(tile.texel_count(), 1);
    return tile;
}

}  // namespace

TEST_SUITE("bake/place_tiles") {
    TEST_CASE("a turned tile holds every texel once, a quarter turn clockwise") {
        const tile turned{
            .atlas = 0, .x = 10, .y = 20, .width = 3, .height = 5, .is_rotated = true};
        std::set<std::pair<int, int>> seen;
        for (int y = 0; y < 3; ++y) {
            for (int x = 0; x < 5; ++x) {
                const ivec2 at = texel_position(turned, x, y);
                CHECK((at.x >= 10 && at.x < 13 && at.y >= 20 && at.y < 25));
                seen.insert({at.x, at.y});
            }
        }
        CHECK(seen.size() == 15);
        CHECK(texel_position(turned, 0, 0) == ivec2(12, 20));  // upper left goes to the upper right
        CHECK(texel_position(turned, 4, 0) == ivec2(12, 24));
    }
    TEST_CASE("an upright tile is only moved") {
        const tile upright{.atlas = 0, .x = 10, .y = 20, .width = 3, .height = 5};
        CHECK(texel_position(upright, 2, 4) == ivec2(12, 24));
    }
    TEST_CASE("the box of every tile is copied, channel by channel, and marked") {
        std::vector<tile_picture> tiles{numbered_tile(40, 9), numbered_tile(9, 40)};
        tiles[0].box = {5, 2, 30, 6};
        const placed_tiles placed = place_tiles(tiles, {.padding = 4}, normal_style::object);
        REQUIRE(placed.tiles.size() == 2);
        REQUIRE(placed.atlases.size() == 1);
        CHECK(placed.tiles[0].is_rotated != placed.tiles[1].is_rotated);
        const atlas& a = placed.atlases[0];
        int marked = 0;
        for (const char mark : placed.is_covered[0]) marked += mark;
        CHECK(marked == 30 * 6 + 9 * 40);
        for (std::size_t i = 0; i < 2; ++i) {
            const texel_box& box = tiles[i].box;
            for (const ivec2 in :
                 {ivec2(0, 0), ivec2(box.width - 1, 0), ivec2(3, box.height - 1)}) {
                const ivec2 at = texel_position(placed.tiles[i], in.x, in.y);
                for (const image* channel :
                     {&a.base_color, &a.normal, &a.occlusion_roughness_metallic, &a.emissive,
                      &a.horizon}) {
                    CHECK(channel->pixel(at.x, at.y)[0] == box.x + in.x);
                    CHECK(channel->pixel(at.x, at.y)[1] == 100 + box.y + in.y);
                }
            }
        }
        const double texels = a.width() * a.height();
        CHECK(placed.fill == doctest::Approx((30 * 6 + 9 * 40) / texels));
    }
    TEST_CASE("tangent space normals turn with their tile") {
        const std::vector<tile_picture> tiles{numbered_tile(40, 8), numbered_tile(8, 40)};
        const placed_tiles placed = place_tiles(tiles, {.padding = 4}, normal_style::folded);
        for (std::size_t i = 0; i < 2; ++i) {
            const ivec2 at = texel_position(placed.tiles[i], 3, 5);
            const std::uint8_t* n = placed.atlases[0].normal.pixel(at.x, at.y);
            CHECK(n[0] == (placed.tiles[i].is_rotated ? 105 : 3));
            CHECK(n[1] == (placed.tiles[i].is_rotated ? 255 - 3 : 105));
        }
    }
    TEST_CASE("no tiles make no atlas") {
        const placed_tiles placed = place_tiles({}, {}, normal_style::folded);
        CHECK(placed.atlases.empty());
        CHECK(placed.fill == 0);
    }
}
