#include <billow/image/raster.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

constexpr int size = 64;

void count_into(std::vector<int>& hits, const std::array<dvec2, 3>& corners) {
    raster_triangle(corners).for_each_row({0, 0, size, size}, [&](int y, int begin, int end) {
        REQUIRE(begin >= 0);
        REQUIRE(end <= size);
        for (int x = begin; x < end; ++x) ++hits[static_cast<std::size_t>(y * size + x)];
    });
}

}  // namespace

TEST_SUITE("image/raster") {
    TEST_CASE("a mesh without gaps takes every sample exactly once") {
        // A jittered grid: corners on sample centres, on 1/256 steps and anywhere.
        for (std::uint64_t seed = 0; seed < 60; ++seed) {
            random_stream random(seed);
            constexpr int cells = 9;
            std::vector<dvec2> points;
            for (int j = 0; j <= cells; ++j) {
                for (int i = 0; i <= cells; ++i) {
                    const bool inner = i > 0 && j > 0 && i < cells && j < cells;
                    dvec2 p{-4 + i * 8.0, -4 + j * 8.0};
                    if (inner) p += dvec2(random.between(-1.9, 1.9), random.between(-1.9, 1.9));
                    if (seed % 3 == 0) p = glm::floor(p) + 0.5;
                    points.push_back(p);
                }
            }
            std::vector<int> hits(size * size);
            for (int j = 0; j < cells; ++j) {
                for (int i = 0; i < cells; ++i) {
                    const auto at = [&](int x, int y) {
                        return points[static_cast<std::size_t>((j + y) * (cells + 1) + i + x)];
                    };
                    const bool turned = (i + j) % 2 == 0;  // windings are mixed
                    count_into(hits, {at(0, 0), at(turned ? 1 : 0, turned ? 0 : 1), at(1, 1)});
                    count_into(hits, {at(0, 0), at(1, 1), at(turned ? 0 : 1, turned ? 1 : 0)});
                }
            }
            CAPTURE(seed);
            CHECK(std::count(hits.begin(), hits.end(), 1) == size * size);
        }
    }

    TEST_CASE("a fan around a sample centre takes it once") {
        std::vector<int> hits(size * size);
        const dvec2 centre{32.5, 32.5};
        constexpr int spokes = 16;
        const auto rim = [&](int i) {
            const double a = 2 * 3.14159265358979 * (i % spokes) / spokes;
            return centre + dvec2(std::cos(a), std::sin(a)) * 20.0;
        };
        for (int i = 0; i < spokes; ++i) count_into(hits, {centre, rim(i), rim(i + 1)});
        CHECK(*std::max_element(hits.begin(), hits.end()) == 1);
        CHECK(hits[32 * size + 32] == 1);
    }

    TEST_CASE("the covered samples make up the area") {
        random_stream random(7);
        for (int round = 0; round < 200; ++round) {
            std::array<dvec2, 3> c;
            for (dvec2& p : c) p = {random.between(2, 62), random.between(2, 62)};
            std::vector<int> hits(size * size);
            count_into(hits, c);
            const raster_triangle t(c);
            const double perimeter =
                glm::distance(c[0], c[1]) + glm::distance(c[1], c[2]) + glm::distance(c[2], c[0]);
            const auto covered = static_cast<double>(std::count(hits.begin(), hits.end(), 1));
            CHECK(std::abs(covered - t.area()) <= 0.5 * perimeter + 2);
        }
    }

    TEST_CASE("a sliver never covers fewer samples than its area, and rarely more") {
        // Needles 0.4 samples wide at the base: a tenth of a texel of 4 × 4 samples.
        int most_missing = 0;
        for (int angle = 0; angle < 360; ++angle) {
            const double a = angle * std::numbers::pi / 180;
            const dvec2 along(std::cos(a), std::sin(a));
            const dvec2 across(-along.y, along.x);
            const dvec2 base = dvec2(32.37, 31.13) - along * 28.0;
            const std::array<dvec2, 3> needle{base - across * 0.2, base + across * 0.2,
                                              base + along * 56.0};
            std::vector<int> hits(size * size);
            count_into(hits, needle);
            const raster_triangle t(needle);
            REQUIRE(t.is_sliver());
            const auto by_rule = std::count(hits.begin(), hits.end(), 1);
            int missing = 0;
            t.for_each_missing({0, 0, size, size}, 0.5, [&](int y, int x, const dvec2& at) {
                ++missing;
                CHECK(std::max(std::abs(at.x - x), std::abs(at.y - y)) <= 0.5 + 1e-9);
                ++hits[static_cast<std::size_t>(y * size + x)];
            });
            CAPTURE(angle);
            CHECK(*std::max_element(hits.begin(), hits.end()) == 1);
            CHECK(by_rule + missing == std::max<std::int64_t>(by_rule, std::lround(t.area())));
            most_missing = std::max(most_missing, missing);
        }
        CHECK(most_missing == 11);  // where the rule misses it altogether
    }

    TEST_CASE("what a sliver owes does not depend on the window") {
        const std::array<dvec2, 3> needle{dvec2(3, 5.55), dvec2(3, 5.9), dvec2(61, 14.95)};
        const auto owed = [&](const sample_window& window) {
            std::vector<std::pair<int, int>> samples;
            raster_triangle(needle).for_each_missing(
                window, 0.9, [&](int y, int x, const dvec2&) { samples.emplace_back(x, y); });
            return samples;
        };
        std::vector<std::pair<int, int>> joined;
        for (int x = 0; x < size; x += 16) {
            for (const auto& sample : owed({x, 0, x + 16, 8})) joined.push_back(sample);
            for (const auto& sample : owed({x, 8, x + 16, size})) joined.push_back(sample);
        }
        auto whole = owed({0, 0, size, size});
        std::sort(joined.begin(), joined.end());
        std::sort(whole.begin(), whole.end());
        CHECK(joined == whole);
        CHECK_FALSE(raster_triangle({dvec2(3, 3), dvec2(9, 3), dvec2(3, 9)}).is_sliver());
    }

    TEST_CASE("interpolation is exact at the corners") {
        const std::array<dvec2, 3> c{dvec2(3, 50.5), dvec2(40.25, 8), dvec2(60, 61)};
        const affine_value value = raster_triangle(c).interpolate(5, -2, 9);
        const std::array<double, 3> expected{5, -2, 9};
        for (std::size_t i = 0; i < 3; ++i) {
            CHECK(value.at(c[i].x - 0.5, c[i].y - 0.5) == doctest::Approx(expected[i]));
        }
    }

    TEST_CASE("points, segments and far corners do no harm") {
        std::vector<int> hits(size * size);
        count_into(hits, {dvec2(5, 5), dvec2(5, 5), dvec2(5, 5)});
        count_into(hits, {dvec2(5, 5), dvec2(25, 25), dvec2(15, 15)});
        CHECK(*std::max_element(hits.begin(), hits.end()) == 0);
        count_into(hits, {dvec2(-1e12, -1e12), dvec2(1e12, -1e12), dvec2(0, 1e12)});
        CHECK(*std::min_element(hits.begin(), hits.end()) == 1);
    }
}
