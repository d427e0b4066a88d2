#include <billow/image/nearest.hpp>

#include <algorithm>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

std::vector<std::int32_t> nearest_of(int w, int h, const std::vector<char>& seeds,
                                     parallel threads = {1}) {
    std::vector<std::int32_t> nearest(seeds.size());
    nearest_scratch scratch;
    nearest_pixels(
        w, h, [&](int x, int y) { return seeds[static_cast<std::size_t>(y * w + x)] != 0; },
        nearest, scratch, threads);
    return nearest;
}

}  // namespace

TEST_SUITE("image/nearest") {
    TEST_CASE("the distance is that of brute force") {
        random_stream random(5);
        for (int round = 0; round < 60; ++round) {
            const int w = static_cast<int>(random.between(1, 40));
            const int h = static_cast<int>(random.between(1, 40));
            const double density = round % 3 == 0 ? 0.005 : random.unit() * 0.2;
            std::vector<char> seeds(static_cast<std::size_t>(w * h));
            for (char& s : seeds) s = random.unit() < density;
            const auto nearest = nearest_of(w, h, seeds);
            for (int i = 0; i < w * h; ++i) {
                int best = 1 << 30;
                for (int k = 0; k < w * h; ++k) {
                    if (!seeds[static_cast<std::size_t>(k)]) continue;
                    const int dx = k % w - i % w;
                    const int dy = k / w - i / w;
                    best = std::min(best, dx * dx + dy * dy);
                }
                const std::int32_t found = nearest[static_cast<std::size_t>(i)];
                if (best == 1 << 30) {
                    CHECK(found == no_pixel);
                    continue;
                }
                REQUIRE(found >= 0);
                REQUIRE(seeds[static_cast<std::size_t>(found)] != 0);
                const int dx = found % w - i % w;
                const int dy = found / w - i / w;
                CHECK(dx * dx + dy * dy == best);
            }
        }
    }

    TEST_CASE("threads do not change the choice") {
        std::vector<char> seeds(300 * 200);
        for (std::size_t i = 0; i < seeds.size(); i += 137) seeds[i] = 1;
        CHECK(nearest_of(300, 200, seeds, {1}) == nearest_of(300, 200, seeds, {3}));
    }
}
