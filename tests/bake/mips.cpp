#include <billow/bake/mips.hpp>

#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

#include "support/opaque_marks.hpp"

using namespace billow;

namespace {

constexpr int padding = 16;

/// Needles one texel wide, in every direction: what loses most when it is averaged.
void draw_needles(atlas& in, const tile& t, int count, std::uint32_t seed) {
    random_stream random(seed);
    for (int needle = 0; needle < count; ++needle) {
        const double angle = random.unit() * 2 * std::numbers::pi;
        dvec2 at(t.x + random.unit() * t.width, t.y + random.unit() * t.height);
        for (int step = 0; step < 20; ++step, at += dvec2(std::cos(angle), std::sin(angle))) {
            const int x = static_cast<int>(at.x);
            const int y = static_cast<int>(at.y);
            if (x < t.x || y < t.y || x >= t.x + t.width || y >= t.y + t.height) break;
            std::uint8_t* p = in.base_color.pixel(x, y);
            p[0] = static_cast<std::uint8_t>(20 + needle % 60);
            p[1] = static_cast<std::uint8_t>(90 + needle % 120);
            p[2] = 30;
            p[3] = 255;
            const double tilt = needle * 0.1;
            std::uint8_t* n = in.normal.pixel(x, y);
            n[0] = byte_from_unit(static_cast<float>(0.5 + 0.4 * std::cos(tilt)));
            n[1] = byte_from_unit(static_cast<float>(0.5 + 0.4 * std::sin(tilt)));
            n[2] = byte_from_unit(0.8f);
        }
    }
}

/// Thin foliage, dense foliage and a solid tile, at places that no level's texels begin at.
baked_cloud foliage() {
    baked_cloud baked;
    baked.tiles = {{.atlas = 0, .x = 17, .y = 19, .width = 190, .height = 301},
                   {.atlas = 0, .x = 243, .y = 16, .width = 120, .height = 200},
                   {.atlas = 0, .x = 397, .y = 22, .width = 96, .height = 96}};
    atlas& a = baked.atlases.emplace_back();
    a.base_color = image::filled(512, 384, 4, 0);
    a.normal = image::filled(512, 384, 3, 128);
    draw_needles(a, baked.tiles[0], 500, 1);
    draw_needles(a, baked.tiles[1], 900, 2);
    const tile& solid = baked.tiles[2];
    for (int y = solid.y; y < solid.y + solid.height; ++y) {
        for (int x = solid.x; x < solid.x + solid.width; ++x) {
            a.base_color.pixel(x, y)[0] = 180;
            a.base_color.pixel(x, y)[3] = 255;
        }
    }
    fill_borders(baked, support::opaque_marks(baked), padding);
    return baked;
}

/// The share of a tile that passes alpha 0.5 under a bilinear filter, by points.
double drawn_share(const tile& t, const image& base, const image& level) {
    constexpr int points = 400000;
    const auto alpha = [&](int x, int y) {
        return static_cast<double>(level.pixel(std::clamp(x, 0, level.width - 1),
                                               std::clamp(y, 0, level.height - 1))[3]) /
               255;
    };
    int drawn = 0;
    for (int k = 0; k < points; ++k) {
        // A lattice in general position: at level 0 the contours lie along the texels' edges.
        const dvec2 texel =
            dvec2(t.x, t.y) +
            dvec2(t.width, t.height) * glm::fract(dvec2(0.7548776662, 0.5698402910) * (k + 0.5));
        const dvec2 p =
            texel * dvec2(level.width, level.height) / dvec2(base.width, base.height) - dvec2(0.5);
        const int x = static_cast<int>(std::floor(p.x));
        const int y = static_cast<int>(std::floor(p.y));
        const dvec2 f = p - dvec2(x, y);
        const double value = glm::mix(glm::mix(alpha(x, y), alpha(x + 1, y), f.x),
                                      glm::mix(alpha(x, y + 1), alpha(x + 1, y + 1), f.x), f.y);
        drawn += value >= 0.5 ? 1 : 0;
    }
    return static_cast<double>(drawn) / points;
}

/// Mean colour of what is drawn around a tile, linear light, weighted by alpha.
dvec3 mean_colour(const tile& t, const image& base, const image& level) {
    dvec3 sum(0);
    double weight = 0;
    const dvec2 scale = dvec2(level.width, level.height) / dvec2(base.width, base.height);
    for (int y = 0; y < level.height; ++y) {
        for (int x = 0; x < level.width; ++x) {
            const dvec2 at = (dvec2(x, y) + 0.5) / scale - dvec2(t.x, t.y);
            if (at.x < -padding || at.y < -padding || at.x >= t.width + padding ||
                at.y >= t.height + padding) {
                continue;
            }
            const std::uint8_t* p = level.pixel(x, y);
            const auto& light = linear_of_srgb_byte();
            sum += dvec3(light[p[0]], light[p[1]], light[p[2]]) * static_cast<double>(p[3]);
            weight += p[3];
        }
    }
    return sum / weight;
}

}  // namespace

TEST_SUITE("bake/mips") {
    TEST_CASE("as much of each tile is drawn on every safe level, where plain mips lose foliage") {
        const baked_cloud baked = foliage();
        const image& base = baked.atlases[0].base_color;
        const auto mips = make_mips(baked, {.padding = padding});
        const auto plain = make_mip_chain(base, texel_kind::srgb_alpha);
        REQUIRE(mips.at(0).safe_levels == 5);
        REQUIRE(mips[0].base_color.size() == plain.size());
        double worst_plain = 0;
        for (const tile& t : baked.tiles) {
            const double wanted = drawn_share(t, base, base);
            for (std::size_t level = 1; level < 5; ++level) {
                CAPTURE(level);
                CAPTURE(t.x);
                worst_plain =
                    std::max(worst_plain, 1 - drawn_share(t, base, plain[level]) / wanted);
                const double share = drawn_share(t, base, mips[0].base_color[level]);
                CHECK(std::abs(share / wanted - 1) < 0.02);
            }
        }
        CHECK(worst_plain > 0.2);
    }

    TEST_CASE("the mean colour of a tile is kept") {
        const baked_cloud baked = foliage();
        const image& base = baked.atlases[0].base_color;
        const auto mips = make_mips(baked, {.padding = padding});
        for (const tile& t : baked.tiles) {
            const dvec3 wanted = mean_colour(t, base, base);
            for (std::size_t level = 1; level < 5; ++level) {
                const dvec3 mean = mean_colour(t, base, mips[0].base_color[level]);
                for (int c = 0; c < 3; ++c) CHECK(std::abs(mean[c] - wanted[c]) < 0.004);
            }
        }
    }

    TEST_CASE("no safe level mixes tiles, wherever they lie") {
        for (int shift = 0; shift < 8; ++shift) {
            CAPTURE(shift);
            baked_cloud baked;
            baked.tiles = {{.atlas = 0, .x = 8, .y = 8, .width = 9 + shift, .height = 21},
                           {.atlas = 0, .x = 33 + shift, .y = 8, .width = 11, .height = 23}};
            atlas& a = baked.atlases.emplace_back();
            a.base_color = image::filled(64, 48, 4, 0);
            a.emissive = image::filled(64, 48, 3, 0);
            for (std::size_t t = 0; t < 2; ++t) {
                const tile& in = baked.tiles[t];
                for (int y = in.y; y < in.y + in.height; ++y) {
                    for (int x = in.x; x < in.x + in.width; ++x) {
                        a.base_color.pixel(x, y)[t] = 255;
                        a.base_color.pixel(x, y)[3] = 255;
                        a.emissive.pixel(x, y)[t] = 255;
                    }
                }
            }
            fill_borders(baked, support::opaque_marks(baked), 8);
            const auto mips = make_mips(baked, {.padding = 8});
            REQUIRE(mips[0].safe_levels == 4);
            for (int level = 0; level < 4; ++level) {
                const image& colour = mips[0].base_color[static_cast<std::size_t>(level)];
                const image& glow = mips[0].emissive[static_cast<std::size_t>(level)];
                for (std::size_t t = 0; t < 2; ++t) {
                    const tile& in = baked.tiles[t];
                    // Every texel that a bilinear filter reads at points of the tile.
                    for (int y = in.y * 4 + 1; y < (in.y + in.height) * 4; ++y) {
                        for (int x = in.x * 4 + 1; x < (in.x + in.width) * 4; ++x) {
                            const int i =
                                static_cast<int>(std::floor(x / (4.0 * (1 << level)) - 0.5));
                            const int j =
                                static_cast<int>(std::floor(y / (4.0 * (1 << level)) - 0.5));
                            for (int k = 0; k < 4; ++k) {
                                const int column = std::clamp(i + k % 2, 0, colour.width - 1);
                                const int row = std::clamp(j + k / 2, 0, colour.height - 1);
                                const std::uint8_t* p = colour.pixel(column, row);
                                REQUIRE(p[t] == 255);
                                REQUIRE(p[1 - t] == 0);
                                REQUIRE(glow.pixel(column, row)[t] == 255);
                                REQUIRE(glow.pixel(column, row)[1 - t] == 0);
                            }
                        }
                    }
                }
            }
        }
    }

    TEST_CASE("normals have unit length, and data is averaged as what it means") {
        baked_cloud baked = foliage();
        atlas& a = baked.atlases[0];
        a.occlusion_roughness_metallic = image::filled(512, 384, 3, 0);
        a.horizon = image::filled(512, 384, 4, 0);
        for (int y = 0; y < 384; ++y) {
            for (int x = 0; x < 512; ++x) {
                a.occlusion_roughness_metallic.pixel(x, y)[1] = x % 2 == 0 ? 100 : 200;
                const horizon_cone cone{x % 2 == 0 ? vec3(0, 1, 0) : vec3(1, 0, 0), 0.2f};
                const auto bytes = encode_horizon(cone);
                std::copy(bytes.begin(), bytes.end(), a.horizon.pixel(x, y));
            }
        }
        const auto mips = make_mips(baked, {.padding = padding})[0];
        for (std::size_t level = 1; level < mips.normal.size(); ++level) {
            const image& normals = mips.normal[level];
            for (std::size_t i = 0; i < normals.bytes.size(); i += 3) {
                const vec3 n = vec3(normals.bytes[i], normals.bytes[i + 1], normals.bytes[i + 2]) *
                                   (2.0f / 255.0f) -
                               1.0f;
                REQUIRE(glm::length(n) == doctest::Approx(1).epsilon(0.01));
            }
        }
        // Within the solid tile, far from its edge.
        CHECK(mips.occlusion_roughness_metallic[1].pixel(220, 30)[1] == 150);
        CHECK(mips.occlusion_roughness_metallic[1].pixel(220, 30)[0] == 0);
        const horizon_cone cone = decode_horizon(mips.horizon[2].pixel(110, 15));
        CHECK(cone.cosine == doctest::Approx(0.2).epsilon(0.03));
        CHECK(glm::dot(cone.axis, glm::normalize(vec3(1, 1, 0))) > 0.999f);
        CHECK(mips.emissive.empty());
    }

    TEST_CASE("the colour of leaves does not fade into what is transparent") {
        baked_cloud baked = foliage();
        for (std::size_t i = 0; i < baked.atlases[0].base_color.bytes.size(); i += 4) {
            std::uint8_t* p = &baked.atlases[0].base_color.bytes[i];
            if (p[3] == 0) p[2] = 255;  // as if nobody had filled the borders
        }
        const auto mips = make_mips(baked, {.padding = padding})[0];
        for (std::size_t level = 1; level < 5; ++level) {
            const image& colour = mips.base_color[level];
            for (std::size_t i = 0; i < colour.bytes.size(); i += 4) {
                if (colour.bytes[i + 3] != 0) REQUIRE(colour.bytes[i + 2] <= 31);
            }
        }
    }

    TEST_CASE("levels are safe as long as the padding is a texel of theirs wide") {
        CHECK(safe_mip_levels(0, 512, 512) == 1);
        CHECK(safe_mip_levels(1, 512, 512) == 1);
        CHECK(safe_mip_levels(2, 512, 512) == 2);
        CHECK(safe_mip_levels(8, 512, 256) == 4);
        CHECK(safe_mip_levels(15, 512, 256) == 4);
        CHECK(safe_mip_levels(16, 512, 256) == 5);
        CHECK(safe_mip_levels(2, 513, 512) == 1);  // a texel of level 1 is 513 / 256 wide
        CHECK(safe_mip_levels(8, 1, 1) == 1);
        CHECK(safe_mip_levels(8, 4, 4) == 3);
    }

    TEST_CASE("chains end at 1 x 1 or where told, for any atlas") {
        baked_cloud baked = foliage();
        auto& tiny = baked.atlases.emplace_back();
        tiny.base_color = image::filled(3, 1, 4, 255);
        baked.tiles.push_back({.atlas = 1, .x = 1, .y = 0, .width = 1, .height = 1});
        const auto mips = make_mips(baked, {.padding = 1});
        REQUIRE(mips.size() == 2);
        CHECK(mips[0].base_color.size() == 10);
        CHECK(mips[0].base_color.back().bytes.size() == 4);
        CHECK(mips[0].base_color[0] == baked.atlases[0].base_color);
        REQUIRE(mips[1].base_color.size() == 2);
        CHECK(mips[1].base_color[1].bytes == std::vector<std::uint8_t>(4, 255));
        CHECK(mips[1].normal.empty());
        CHECK(make_mips(baked, {.levels = 3})[0].normal.size() == 3);
        CHECK(make_mips({}).empty());
    }

    TEST_CASE("any number of threads makes the same levels") {
        const baked_cloud baked = foliage();
        const auto one = make_mips(baked, {.padding = padding}, {1})[0];
        for (const unsigned threads : {2u, 3u, 8u}) {
            const auto many = make_mips(baked, {.padding = padding}, {threads})[0];
            CHECK(many.base_color == one.base_color);
            CHECK(many.normal == one.normal);
        }
    }
}
