#include <billow/bake/pack.hpp>

#include <chrono>

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

    TEST_CASE("a thousand rectangles fill most of one atlas in a moment") {
        const pack_options o{.padding = 0, .alignment = 1};
        const auto sizes = random_sizes(1000, 3, 200);
        const auto start = std::chrono::steady_clock::now();
        const auto p = pack_rectangles(sizes, o);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        MESSAGE("1,000 rectangles: " << seconds.count() * 1e3 << " ms");
        CHECK(p.atlas_sizes.size() == 1);
        CHECK(check_and_fill(sizes, p, o) > 0.9);
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

    TEST_CASE("nothing gives no atlas, and one rectangle an atlas of its size") {
        CHECK(pack_rectangles({}).atlas_sizes.empty());
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
