#include <billow/geometry/rectangle.hpp>

#include <numbers>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

double area_at(const std::vector<dvec2>& points, double angle) {
    const dvec2 x{std::cos(angle), std::sin(angle)};
    const dvec2 y{-x.y, x.x};
    dvec2 low{1e300};
    dvec2 high{-1e300};
    for (const dvec2& p : points) {
        low = glm::min(low, dvec2(glm::dot(p, x), glm::dot(p, y)));
        high = glm::max(high, dvec2(glm::dot(p, x), glm::dot(p, y)));
    }
    return (high.x - low.x) * (high.y - low.y);
}

bool holds(const oriented_rectangle& r, const dvec2& p, double slack) {
    const dvec2 local = dvec2(glm::dot(p, r.axis), glm::dot(p, r.height_axis())) - r.low;
    return local.x >= -slack && local.y >= -slack && local.x <= r.extent.x + slack &&
           local.y <= r.extent.y + slack;
}

std::vector<dvec2> cloud_of(std::uint64_t seed) {
    random_stream random(seed);
    const auto count = static_cast<std::size_t>(random.between(3, 60));
    const double grid = seed % 3 == 0 ? 4.0 : 1e6;  // a coarse grid: duplicates, collinear points
    const double offset = seed % 5 == 0 ? 1e5 : 0;
    std::vector<dvec2> points;
    for (std::size_t i = 0; i < count; ++i) {
        points.push_back({offset + std::floor(random.unit() * grid) / grid,
                          0.3 * std::floor(random.unit() * grid) / grid});
    }
    return points;
}

}  // namespace

TEST_SUITE("geometry/rectangle") {
    TEST_CASE("no angle gives a smaller rectangle, and all points are inside") {
        for (std::uint64_t seed = 0; seed < 300; ++seed) {
            const auto points = cloud_of(seed);
            const auto rectangle = minimum_rectangle_of(points);
            double brute = 1e300;
            for (int i = 0; i < 900; ++i) {
                brute = std::min(brute, area_at(points, i * std::numbers::pi / 1800));
            }
            CAPTURE(seed);
            CHECK(rectangle.area() <= brute * (1 + 1e-9) + 1e-9);
            CHECK(glm::dot(rectangle.axis, rectangle.axis) == doctest::Approx(1));
            for (const dvec2& p : points) CHECK(holds(rectangle, p, 1e-9));
        }
    }

    TEST_CASE("the hull is convex and holds every point") {
        for (std::uint64_t seed = 0; seed < 300; ++seed) {
            auto points = cloud_of(seed);
            std::vector<dvec2> hull(points.size() + 1);
            hull.resize(convex_hull(points, hull));
            for (std::size_t i = 0; hull.size() > 2 && i < hull.size(); ++i) {
                const dvec2& a = hull[i];
                const dvec2& b = hull[(i + 1) % hull.size()];
                CHECK(detail::turn(a, b, hull[(i + 2) % hull.size()]) > 0);
                for (const dvec2& p : points) CHECK(detail::turn(a, b, p) >= -1e-9);
            }
        }
    }

    TEST_CASE("a turned rectangle is found again") {
        for (int degree = 0; degree < 180; degree += 7) {
            const double angle = degree * std::numbers::pi / 180;
            const dvec2 x{std::cos(angle), std::sin(angle)};
            const dvec2 y{-x.y, x.x};
            std::vector<dvec2> points{{0, 0}, x * 3.0, x * 3.0 + y * 2.0, y * 2.0, x + y, x * 1.5};
            const auto r = minimum_rectangle_of(points);
            CHECK(r.area() == doctest::Approx(6));
            CHECK(std::max(r.extent.x, r.extent.y) == doctest::Approx(3));
        }
    }

    TEST_CASE("points and segments have zero extents") {
        CHECK(minimum_rectangle_of({}).extent == dvec2(0));
        const auto point = minimum_rectangle_of({{2, 3}, {2, 3}, {2, 3}});
        CHECK(point.extent == dvec2(0));
        CHECK(point.low == dvec2(2, 3));
        const auto segment = minimum_rectangle_of({{0, 0}, {3, 4}, {1.5, 2}, {0, 0}});
        CHECK(segment.extent.x == doctest::Approx(5));
        CHECK(std::abs(segment.extent.y) < 1e-12);
        CHECK(segment.extent.y >= 0);
    }
}
