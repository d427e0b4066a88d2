#include <billow/bake/pack.hpp>

#include <algorithm>
#include <ctime>
#include <vector>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

std::vector<ivec2> random_sizes(std::size_t count, std::uint64_t seed, double largest) {
    random_stream random(seed);
    std::vector<ivec2> sizes;
    for (std::size_t i = 0; i < count; ++i) {
        const double scale = random.unit();
        sizes.push_back({static_cast<int>(1 + random.unit() * scale * largest),
                         static_cast<int>(1 + random.unit() * scale * largest)});
    }
    return sizes;
}

double check_and_fill(const std::vector<ivec2>& sizes, const packing& p, const pack_options& o) {
    REQUIRE(p.rectangles.size() == sizes.size());
    double atlas_area = 0;
    double tile_area = 0;
    std::vector<std::vector<char>> used;
    for (const ivec2& s : p.atlas_sizes) {
        CHECK(s.x <= o.max_size);
        CHECK(s.y <= o.max_size);
        CHECK(s.x % o.alignment == 0);
        CHECK(s.y % o.alignment == 0);
        used.emplace_back(static_cast<std::size_t>(s.x * s.y));
        atlas_area += static_cast<double>(s.x) * s.y;
    }
    bool is_free = true;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        const packed_rectangle& r = p.rectangles[i];
        REQUIRE(r.atlas < p.atlas_sizes.size());
        const ivec2 size = r.is_rotated ? ivec2(sizes[i].y, sizes[i].x) : sizes[i];
        const ivec2 atlas = p.atlas_sizes[r.atlas];
        tile_area += static_cast<double>(size.x) * size.y;
        REQUIRE(r.x >= o.padding);
        REQUIRE(r.y >= o.padding);
        REQUIRE(r.x + size.x + o.padding <= atlas.x);
        REQUIRE(r.y + size.y + o.padding <= atlas.y);
        CHECK((r.x - o.padding) % o.alignment == 0);
        for (int y = r.y - o.padding; y < r.y + size.y + o.padding; ++y) {
            for (int x = r.x - o.padding; x < r.x + size.x + o.padding; ++x) {
                char& pixel = used[r.atlas][static_cast<std::size_t>(y * atlas.x + x)];
                is_free = is_free && pixel == 0;
                pixel = 1;
            }
        }
    }
    CHECK(is_free);
    return tile_area / atlas_area;
}

}  // namespace

TEST_SUITE("bake/pack") {
    TEST_CASE("rectangles keep their padding and stay inside") {
        for (std::uint64_t seed = 0; seed < 12; ++seed) {
            pack_options o{.max_size = 512};
            o.padding = static_cast<int>(seed % 3) * 4;
            o.alignment = seed % 2 == 0 ? 4 : 1;
            o.power_of_two = seed % 4 == 0;
            o.allows_rotation = seed % 5 != 0;
            const auto sizes = random_sizes(80, seed, 200);
            const auto p = pack_rectangles(sizes, o);
            check_and_fill(sizes, p, o);
            for (const ivec2& s : p.atlas_sizes) {
                if (o.power_of_two) CHECK(((s.x & (s.x - 1)) == 0 && (s.y & (s.y - 1)) == 0));
            }
        }
    }

    TEST_CASE("padded rectangles start and end at multiples of the alignment") {
        for (const int padding : {0, 2, 4, 6, 8}) {
            const pack_options o{.padding = padding};
            const auto sizes = random_sizes(60, 4, 90);
            const auto p = pack_rectangles(sizes, o);
            // Which block of 4 x 4 pixels belongs to whom, padding included.
            const ivec2 blocks = p.atlas_sizes[0] / 4;
            std::vector<std::size_t> owner(static_cast<std::size_t>(blocks.x * blocks.y), no_id);
            bool is_shared = false;
            for (std::size_t i = 0; i < sizes.size(); ++i) {
                const packed_rectangle& r = p.rectangles[i];
                const ivec2 size = r.is_rotated ? ivec2(sizes[i].y, sizes[i].x) : sizes[i];
                for (int y = r.y - padding; y < r.y + size.y + padding; ++y) {
                    for (int x = r.x - padding; x < r.x + size.x + padding; ++x) {
                        auto& block = owner[static_cast<std::size_t>(y / 4 * blocks.x + x / 4)];
                        is_shared = is_shared || (block != no_id && block != i);
                        block = i;
                    }
                }
            }
            CHECK_FALSE(is_shared);
        }
    }

    TEST_CASE("from eight rectangles on, 93 % of the atlas is rectangles and padding") {
        for (const std::size_t count : {8u, 16u, 32u, 64u, 200u}) {
            CAPTURE(count);
            const auto sizes = random_sizes(count, count, 600);
            const auto p = pack_rectangles(sizes);
            REQUIRE(p.atlas_sizes.size() == 1);
            CHECK(p.fill == doctest::Approx(check_and_fill(sizes, p, {})).epsilon(1e-9));
            CHECK(p.padded_fill > 0.93);
            CHECK(p.padded_fill <= 1);
            CHECK(p.fill < p.padded_fill);
            const double ratio = static_cast<double>(p.atlas_sizes[0].x) / p.atlas_sizes[0].y;
            CHECK(std::max(ratio, 1 / ratio) < 2.2);
        }
    }

    TEST_CASE("rectangles cut from a square go back into it") {
        const std::vector<ivec2> sizes{{60, 40}, {40, 70}, {70, 30}, {30, 60}};
        // Around a hole of 10 x 20: 96 % of 100 x 100; nothing smaller than 98 x 100 holds them.
        const pack_options o{.padding = 0, .alignment = 1};
        CHECK(check_and_fill(sizes, pack_rectangles(sizes, o), o) > 0.95);
        const std::vector<ivec2> equal(49, ivec2(12, 12));
        const pack_options tiles{.padding = 2, .alignment = 4};
        const auto p = pack_rectangles(equal, tiles);
        CHECK(p.padded_fill == doctest::Approx(1));
        CHECK(p.atlas_sizes[0] == ivec2(112, 112));
    }

    TEST_CASE("the time is bounded from one rectangle to ten thousand") {
        for (const std::size_t count : {1u, 200u, 3'000u, 10'000u}) {
            CAPTURE(count);
            const auto sizes = random_sizes(count, 3, 24);
            const std::clock_t start = std::clock();
            const auto p = pack_rectangles(sizes);
            const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
            MESSAGE(count << " rectangles: " << seconds * 1e3 << " ms, fill with padding "
                          << p.padded_fill);
            CHECK(seconds < 30);  // a build without optimisation, with sanitizers
            check_and_fill(sizes, p, {});
            CHECK(p.atlas_sizes.size() == 1);
            CHECK(p.padded_fill > 0.97);
        }
    }

    TEST_CASE("turning tall rectangles saves area") {
        std::vector<ivec2> sizes;
        for (int i = 0; i < 40; ++i) sizes.push_back(i % 2 == 0 ? ivec2(16, 256) : ivec2(256, 16));
        const pack_options turned{.padding = 0};
        const pack_options fixed{.padding = 0, .allows_rotation = false};
        const auto a = pack_rectangles(sizes, turned);
        const auto b = pack_rectangles(sizes, fixed);
        CHECK(check_and_fill(sizes, a, turned) >= check_and_fill(sizes, b, fixed));
        CHECK(check_and_fill(sizes, a, turned) > 0.98);
    }

    TEST_CASE("what one atlas does not hold goes to the next") {
        const std::vector<ivec2> sizes(9, ivec2(100, 100));
        const pack_options o{.max_size = 256, .padding = 8};
        const auto p = pack_rectangles(sizes, o);
        CHECK(p.atlas_sizes.size() == 3);
        check_and_fill(sizes, p, o);
    }

    TEST_CASE("a second atlas only where one does not hold all, and the last is the smallest") {
        pack_options o{.max_size = 512, .padding = 0};
        std::vector<ivec2> sizes(16, ivec2(128, 128));
        CHECK(pack_rectangles(sizes, o).atlas_sizes.size() == 1);
        sizes.emplace_back(20, 8);
        auto p = pack_rectangles(sizes, o);
        REQUIRE(p.atlas_sizes.size() == 2);
        CHECK(p.atlas_sizes[0] == ivec2(512, 512));
        CHECK(p.atlas_sizes[1] == ivec2(20, 8));
        for (const bool power_of_two : {false, true}) {
            o = {.max_size = 512, .padding = 4, .power_of_two = power_of_two};
            sizes = random_sizes(120, 5, 200);
            p = pack_rectangles(sizes, o);
            check_and_fill(sizes, p, o);
            double area = 0;
            for (const ivec2& s : sizes) area += static_cast<double>((s.x + 8) * (s.y + 8));
            CHECK(static_cast<double>(p.atlas_sizes.size() - 1) < area / (0.95 * 512 * 512));
            for (std::size_t i = 0; i + 1 < p.atlas_sizes.size(); ++i) {
                CHECK(p.atlas_sizes[i].x * p.atlas_sizes[i].y > 0.97 * 512 * 512);
            }
        }
    }

    TEST_CASE("a power of two is the smallest that holds all") {
        const std::vector<ivec2> sizes(7, ivec2(56, 56));
        const auto p = pack_rectangles(sizes, {.padding = 4, .power_of_two = true});
        CHECK(p.atlas_sizes[0].x * p.atlas_sizes[0].y == 256 * 128);
        const std::vector<ivec2> slim{{1000, 8}};
        CHECK(pack_rectangles(slim, {.padding = 4, .power_of_two = true}).atlas_sizes[0] ==
              ivec2(1024, 16));
    }

    TEST_CASE("rectangles of the largest size have an atlas each") {
        for (const bool power_of_two : {false, true}) {
            const pack_options o{.max_size = 256, .power_of_two = power_of_two};
            const std::vector<ivec2> sizes(3, ivec2(largest_side(o)));
            const auto p = pack_rectangles(sizes, o);
            CHECK(p.atlas_sizes == std::vector<ivec2>(3, ivec2(256)));
            check_and_fill(sizes, p, o);
        }
        const pack_options odd{.max_size = 203, .padding = 3};
        CHECK(largest_side(odd) == 194);
        const std::vector<ivec2> one{{194, 194}};
        CHECK(pack_rectangles(one, odd).atlas_sizes[0] == ivec2(200, 200));
    }

    TEST_CASE("nothing gives no atlas, and one rectangle an atlas of its size") {
        CHECK(pack_rectangles({}).atlas_sizes.empty());
        CHECK(pack_rectangles({}).fill == 0);
        const std::vector<ivec2> one{{30, 3}};
        CHECK(pack_rectangles(one, {.padding = 0, .alignment = 1}).atlas_sizes[0] == ivec2(30, 3));
        const std::vector<ivec2> full{{4080, 4080}};
        CHECK(pack_rectangles(full).atlas_sizes[0] == ivec2(4096, 4096));
    }

    TEST_CASE("the answer is the same every time") {
        const auto sizes = random_sizes(200, 9, 100);
        const auto a = pack_rectangles(sizes);
        const auto b = pack_rectangles(sizes);
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            CHECK(a.rectangles[i].x == b.rectangles[i].x);
            CHECK(a.rectangles[i].y == b.rectangles[i].y);
        }
    }
}
