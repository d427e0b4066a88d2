#include <billow/bake/tile_alpha.hpp>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

/// Covers texels as `share(x, y)` says, by leaves or by solids.
template <class Share>
tile_picture covered_tile(int width, int height, bool is_foliage, const Share& share) {
    tile_picture tile = empty_tile({width, height}, 4, false);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto samples = static_cast<std::uint8_t>(std::lround(16 * share(x, y)));
            tile.covered[tile.index(x, y)] = samples;
            tile.cut_out[tile.index(x, y)] = is_foliage ? samples : std::uint8_t{0};
        }
    }
    return tile;
}

/// Discs of less than two texels, strewn.
tile_picture foliage_tile(int side, double share_of_texels = 0.3) {
    random_stream random(5);
    std::vector<double> share(static_cast<std::size_t>(side * side), 0.0);
    for (int i = 0; i < side * side * share_of_texels; ++i) {
        const dvec2 at(random.unit() * side, random.unit() * side);
        const double radius = 0.3 + random.unit() * 0.6;
        for (int y = 0; y < side * 4; ++y) {
            if (std::abs((y + 0.5) / 4 - at.y) > radius) continue;
            for (int x = 0; x < side * 4; ++x) {
                if (glm::distance(dvec2(x + 0.5, y + 0.5) / 4.0, at) > radius) continue;
                share[static_cast<std::size_t>(y / 4 * side + x / 4)] += 1.0 / 16;
            }
        }
    }
    return covered_tile(side, side, true, [&](int x, int y) {
        return std::min(1.0, share[static_cast<std::size_t>(y * side + x)]);
    });
}

double opaque_count(const tile_picture& tile) {
    double count = 0;
    for (std::size_t i = 0; i < tile.texel_count(); ++i) count += tile.alpha(i) >= 128;
    return count;
}

/// As bilinear filtering and an alpha test draw it.
double filtered_area(const tile_picture& tile) {
    std::vector<float> alpha(tile.texel_count());
    for (std::size_t i = 0; i < alpha.size(); ++i) {
        alpha[i] = static_cast<float>(tile.alpha(i)) / 255.0f;
    }
    const alpha_block block{alpha, tile.width, 0, 0, tile.width, tile.height};
    return drawn_area(block, dvec2(0), dvec2(tile.width, tile.height), 1, 0.5f);
}

}  // namespace

TEST_SUITE("bake/tile_alpha") {
    TEST_CASE("the opaque area of foliage is its covered area, where thresholds are off by far") {
        tile_picture tile = foliage_tile(64);
        const double covered = tile.covered_area();
        choose_alpha(tile, {.area = opaque_area::thresholds});
        CHECK(opaque_count(tile) > 1.15 * covered);  // Fuhrmann's 0.3 makes leaves fatter
        choose_alpha(tile, {.area = opaque_area::thresholds, .thresholds = {.foliage = 0.7}});
        CHECK(opaque_count(tile) < 0.85 * covered);
        for (const double threshold : {0.3, 0.7}) {
            choose_alpha(tile, {.thresholds = {.foliage = threshold}});
            CHECK(std::abs(opaque_count(tile) - covered) <= 1);
        }
    }
    TEST_CASE("coverage and distances draw the covered area under bilinear filtering") {
        tile_picture tile = foliage_tile(64);
        for (const alpha_kind kind : {alpha_kind::coverage, alpha_kind::distance}) {
            choose_alpha(tile, {.kind = kind});
            CHECK(filtered_area(tile) == doctest::Approx(tile.covered_area()).epsilon(0.02));
        }
    }
    TEST_CASE("coverage is the share, scaled for the whole tile") {
        tile_picture tile = covered_tile(32, 8, false, [](int x, int) { return x / 32.0; });
        choose_alpha(tile, {.kind = alpha_kind::coverage});
        for (int x = 1; x < 32; ++x) {
            CHECK(tile.alpha(tile.index(x, 3)) >= tile.alpha(tile.index(x - 1, 3)));
        }
        CHECK(std::abs(tile.alpha(tile.index(16, 3)) - 128) <= 2);
    }
    TEST_CASE("distances rise by the same step from texel to texel across an edge") {
        tile_picture tile =
            covered_tile(32, 8, false, [](int x, int) { return x < 16 ? 1.0 : 0.0; });
        choose_alpha(tile, {.kind = alpha_kind::distance, .spread = 4});
        for (int x = 13; x < 18; ++x) {
            const int step = tile.alpha(tile.index(x, 4)) - tile.alpha(tile.index(x + 1, 4));
            CHECK(std::abs(step - 32) <= 1);
        }
        CHECK(tile.alpha(tile.index(15, 4)) >= 128);
        CHECK(tile.alpha(tile.index(16, 4)) < 128);
    }
    TEST_CASE("the outline of a wide solid is decided by its threshold, not frayed") {
        tile_picture tile = covered_tile(20, 20, false, [](int x, int) {
            return x < 10 ? 1 : x == 10 ? 0.4 : 0;
        });
        choose_alpha(tile, {});
        CHECK(opaque_count(tile) == 200);
        tile = covered_tile(20, 20, false, [](int x, int) {
            return x < 10 ? 1 : x == 10 ? .6 : 0;
        });
        choose_alpha(tile, {});
        CHECK(opaque_count(tile) == 220);
    }
    TEST_CASE("a rod thinner than a texel keeps its area, spread along it") {
        tile_picture tile =
            covered_tile(400, 5, false, [](int, int y) { return y == 2 ? .25 : 0; });
        choose_alpha(tile, {.area = opaque_area::thresholds});
        CHECK(opaque_count(tile) == 1);  // all but the one that every tile keeps
        choose_alpha(tile, {});
        CHECK(opaque_count(tile) == 100);
        int longest_gap = 0;
        int gap = 0;
        for (int x = 0; x < 400; ++x) {
            gap = tile.alpha(tile.index(x, 2)) != 0 ? 0 : gap + 1;
            longest_gap = std::max(longest_gap, gap);
        }
        CHECK(longest_gap <= 12);
    }
    TEST_CASE("tilted leaves grow to their own area, by two texels at most") {
        tile_picture tile = foliage_tile(64, 0.05);
        choose_alpha(tile, {});
        const double covered = opaque_count(tile);
        tile.surface_area = 1.7 * covered;
        choose_alpha(tile, {.area = opaque_area::surface});
        CHECK(std::abs(opaque_count(tile) - 1.7 * covered) <= 1);
        tile_picture lone =
            covered_tile(32, 32, true, [](int x, int y) { return x == 16 && y == 16 ? 1.0 : 0.0; });
        lone.surface_area = 500;
        choose_alpha(lone, {.area = opaque_area::surface});
        CHECK(opaque_count(lone) == 13);  // a disc of radius 2
    }
    TEST_CASE("a tile that shows anything has an opaque texel; an empty one has none") {
        for (const alpha_kind kind :
             {alpha_kind::binary, alpha_kind::coverage, alpha_kind::distance}) {
            for (const bool is_foliage : {true, false}) {
                tile_picture faint = covered_tile(9, 9, is_foliage, [](int x, int y) {
                    return x == 4 && y == 5 ? 1.0 / 16 : 0.0;
                });
                choose_alpha(faint, {.kind = kind});
                CHECK(faint.alpha(faint.index(4, 5)) >= 128);
                tile_picture empty = empty_tile({9, 9}, 4, false);
                choose_alpha(empty, {.kind = kind});
                CHECK(opaque_count(empty) == 0);
            }
        }
    }
}
