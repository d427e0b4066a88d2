#include <billow/geometry/outline.hpp>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

std::vector<dvec2> hull_of(std::vector<dvec2> points) {
    std::vector<dvec2> hull(points.size() + 1);
    hull.resize(convex_hull(points, hull));
    return hull;
}

std::vector<dvec2> random_hull(std::uint64_t seed, int count) {
    random_stream random(seed);
    std::vector<dvec2> points;
    for (int i = 0; i < count; ++i) points.push_back({random.unit() * 3, random.unit()});
    return hull_of(points);
}

void check_promises(std::span<const dvec2> hull, const dvec2& low, const dvec2& high, int most) {
    const auto outline = outline_polygon(hull, low, high, most);
    CHECK(outline.size() >= 3);
    CHECK(outline.size() <= static_cast<std::size_t>(most));
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const dvec2& a = outline[i];
        const dvec2& b = outline[(i + 1) % outline.size()];
        const dvec2& c = outline[(i + 2) % outline.size()];
        CHECK(detail::turn(a, b, c) > 0);
        CHECK(a.x >= low.x - 1e-9);
        CHECK(a.y >= low.y - 1e-9);
        CHECK(a.x <= high.x + 1e-9);
        CHECK(a.y <= high.y + 1e-9);
        for (const dvec2& p : hull) CHECK(detail::turn(a, b, p) >= -1e-7);
    }
}

}  // namespace

TEST_SUITE("geometry/outline") {
    TEST_CASE("it is convex, within the rectangle, holds the hull and has few corners") {
        for (std::uint64_t seed = 0; seed < 40; ++seed) {
            const auto hull = random_hull(seed, 3 + static_cast<int>(seed % 30));
            for (int most = 4; most <= 8; ++most) {
                check_promises(hull, {0, 0}, {3, 1}, most);
                check_promises(hull, {-1, -2}, {4, 5}, most);
            }
        }
    }
    TEST_CASE("more corners never leave more area") {
        for (std::uint64_t seed = 0; seed < 40; ++seed) {
            const auto hull = random_hull(seed, 40);
            double last = 6;
            for (int most = 4; most <= 8; ++most) {
                const double area = doubled_area(outline_polygon(hull, {0, 0}, {3, 1}, most));
                CHECK(area <= last * (1 + 1e-3));
                last = area;
            }
            CHECK(last >= doubled_area(hull) * (1 - 1e-9));
        }
    }
    TEST_CASE("a shape of few corners is its own outline") {
        const std::vector<dvec2> diamond{{1, 0}, {2, 1}, {1, 2}, {0, 1}};
        CHECK(doubled_area(outline_polygon(diamond, {0, 0}, {2, 2}, 8)) == doctest::Approx(4));
        CHECK(doubled_area(outline_polygon(diamond, {0, 0}, {2, 2}, 4)) <= 8);
        const std::vector<dvec2> triangle{{0, 0}, {2, 0}, {0, 2}};
        const auto outline = outline_polygon(triangle, {0, 0}, {2, 2}, 4);
        CHECK(doubled_area(outline) == doctest::Approx(4));
        CHECK(outline.size() == 3);
    }
    TEST_CASE("eight corners around a disc leave a twentieth of its area") {
        std::vector<dvec2> points;
        for (int i = 0; i < 200; ++i) {
            points.push_back({1 + std::cos(i * 0.0314159265), 1 + std::sin(i * 0.0314159265)});
        }
        const auto disc = hull_of(points);
        const double area = doubled_area(outline_polygon(disc, {0, 0}, {2, 2}, 8)) / 2;
        CHECK(area < 1.06 * std::numbers::pi);
        // A square with two corners cut off; a regular hexagon would leave the rectangle.
        CHECK(doubled_area(outline_polygon(disc, {0, 0}, {2, 2}, 6)) / 2 ==
              doctest::Approx(4 - 2 * (3 - 2 * std::numbers::sqrt2)).epsilon(1e-3));
    }
    TEST_CASE("a point, a segment and nothing keep what fits the corners") {
        CHECK(outline_polygon({}, {0, 0}, {2, 1}, 6).size() == 4);
        const std::vector<dvec2> point{{1, 0.5}};
        const std::vector<dvec2> segment{{0, 0}, {2, 1}};
        for (const auto& hull : {point, segment}) {
            const auto outline = outline_polygon(hull, {0, 0}, {2, 1}, 6);
            CHECK(outline.size() >= 3);
            CHECK(doubled_area(outline) <= 4);
        }
    }
}
