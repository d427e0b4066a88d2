#include <billow/image/raster.hpp>

#include <algorithm>
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
