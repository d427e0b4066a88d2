#include <billow/bake/border.hpp>

#include <doctest/doctest.h>

#include "support/opaque_marks.hpp"

using namespace billow;

namespace {

/// Two tiles of 4 × 4 with a padding of 2, a red texel in the first and a blue one in the second.
baked_cloud two_tiles() {
    baked_cloud baked;
    baked.tiles = {{.atlas = 0, .x = 2, .y = 2, .width = 4, .height = 4},
                   {.atlas = 0, .x = 10, .y = 2, .width = 4, .height = 4}};
    atlas& a = baked.atlases.emplace_back();
    a.base_color = image::filled(24, 8, 4, 0);
    a.normal = image::filled(24, 8, 3, 0);
    const auto put = [&](int x, int y, int channel) {
        a.base_color.pixel(x, y)[channel] = 200;
        a.base_color.pixel(x, y)[3] = 255;
        a.normal.pixel(x, y)[channel] = 100;
    };
    put(5, 3, 0);
    put(13, 5, 2);
    return baked;
}

}  // namespace

TEST_SUITE("bake/border") {
    TEST_CASE("a tile with its padding takes its own opaque texels, whatever lies beside it") {
        baked_cloud baked = two_tiles();
        fill_borders(baked, support::opaque_marks(baked), 2);
        const atlas& a = baked.atlases[0];
        for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 16; ++x) {
                const int channel = x < 8 ? 0 : 2;
                CHECK(a.base_color.pixel(x, y)[channel] == 200);
                CHECK(a.base_color.pixel(x, y)[2 - channel] == 0);
                CHECK(a.normal.pixel(x, y)[channel] == 100);
            }
        }
    }
    TEST_CASE("what no tile holds takes the nearest tile's colour, and alpha stays") {
        baked_cloud baked = two_tiles();
        fill_borders(baked, support::opaque_marks(baked), 2);
        const atlas& a = baked.atlases[0];
        CHECK(a.base_color.pixel(23, 7)[2] == 200);
        int opaque = 0;
        for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 24; ++x) opaque += a.base_color.pixel(x, y)[3] != 0 ? 1 : 0;
        }
        CHECK(opaque == 2);
    }
    TEST_CASE("a covered texel keeps its colour, opaque or not") {
        baked_cloud baked = two_tiles();
        const auto covered = support::opaque_marks(baked);
        baked.atlases[0].base_color.pixel(5, 3)[3] = 0;
        fill_borders(baked, covered, 2);
        CHECK(baked.atlases[0].base_color.pixel(5, 3)[0] == 200);
        CHECK(baked.atlases[0].base_color.pixel(2, 2)[0] == 200);
        CHECK(baked.atlases[0].base_color.pixel(5, 3)[3] == 0);
    }
    TEST_CASE("any number of threads fills alike") {
        baked_cloud one = two_tiles();
        fill_borders(one, support::opaque_marks(one), 2, {1});
        for (const unsigned threads : {2u, 3u}) {
            baked_cloud many = two_tiles();
            fill_borders(many, support::opaque_marks(many), 2, {threads});
            CHECK(many.atlases[0].base_color == one.atlases[0].base_color);
        }
    }
}
