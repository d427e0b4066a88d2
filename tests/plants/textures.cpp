#include <billow/plants/textures.hpp>

#include <doctest/doctest.h>

#include <cstdlib>

using namespace billow;

namespace {

/// Mean difference of neighbouring texels across a vertical line, in bytes.
double step_across(const image& picture, int left, int right) {
    double sum = 0;
    for (int y = 0; y < picture.height; ++y) {
        sum += std::abs(picture.pixel(left, y)[1] - picture.pixel(right, y)[1]);
    }
    return sum / picture.height;
}

}  // namespace

TEST_SUITE("plants/textures") {
    TEST_CASE("bark tiles: the border is as smooth as the inside") {
        const image bark = bark_image({.size = 128});
        double inside = 0;
        for (int x = 0; x + 1 < 128; ++x) inside += step_across(bark, x, x + 1) / 127;
        CHECK(step_across(bark, 127, 0) < 2 * inside);
        for (std::size_t i = 3; i < bark.bytes.size(); i += 4) REQUIRE(bark.bytes[i] == 255);
    }

    TEST_CASE("bark has light ridges and dark furrows") {
        const image bark = bark_image({.size = 128});
        int dark = 0, light = 0;
        for (std::size_t i = 0; i < bark.bytes.size(); i += 4) {
            dark += bark.bytes[i] < 70;
            light += bark.bytes[i] > 95;
        }
        CHECK(dark > 128 * 128 / 20);
        CHECK(light > 128 * 128 / 20);
    }

    TEST_CASE("leaves cover a fair part of the picture and leave its rims free") {
        for (const unsigned count : {1u, 5u, 9u}) {
            const image leaves = leaf_image({.size = 128, .variants = 2, .leaves = count});
            int covered = 0, partial = 0;
            for (int y = 0; y < 128; ++y) {
                for (int x = 0; x < 128; ++x) {
                    const int alpha = leaves.pixel(x, y)[3];
                    covered += alpha > 127;
                    partial += alpha > 0 && alpha < 255;
                    // Nothing reaches over the left, right and upper rim of its picture.
                    if (x % 64 == 0 || x % 64 == 63 || y % 64 == 0) REQUIRE(alpha == 0);
                }
            }
            CHECK(covered > 128 * 128 / 8);
            CHECK(covered < 128 * 128 * 3 / 4);
            CHECK(partial > 100);  // antialiased outlines
        }
    }

    TEST_CASE("every picture stands on the middle of its lower edge") {
        const image leaves = leaf_image({.size = 256, .variants = 2, .leaves = 7});
        for (const int x : {64, 192}) {
            for (const int y : {126, 254}) CHECK(leaves.pixel(x, y)[3] > 127);
        }
    }

    TEST_CASE("texels without a leaf are as green as the leaves") {
        const image leaves = leaf_image({.size = 64});
        for (std::size_t i = 0; i < leaves.bytes.size(); i += 4) {
            if (leaves.bytes[i + 3] != 0) continue;
            REQUIRE(leaves.bytes[i + 1] > leaves.bytes[i]);
            REQUIRE(leaves.bytes[i + 1] > leaves.bytes[i + 2] + 20);
        }
    }

    TEST_CASE("the seed alone decides, and the pictures differ") {
        CHECK(leaf_image({.size = 64}) == leaf_image({.size = 64}));
        CHECK(leaf_image({.size = 64}) != leaf_image({.size = 64, .seed = 2}));
        CHECK(bark_image({.size = 32}) == bark_image({.size = 32}));
        CHECK(bark_image({.size = 32}) != bark_image({.size = 32, .seed = 2}));
        const image leaves = leaf_image({.size = 64, .variants = 2});
        int differing = 0;
        for (int y = 0; y < 32; ++y) {
            for (int x = 0; x < 32; ++x) {
                differing += leaves.pixel(x, y)[1] != leaves.pixel(x + 32, y)[1];
            }
        }
        CHECK(differing > 50);
    }
}
