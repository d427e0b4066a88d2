// Convex hulls and rectangles of least area in the plane.
//
// Hull: Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979 (monotone
// chain). Rectangle: Toussaint, "Solving geometric problems with the rotating calipers", 1983.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// A rectangle that may be turned. `axis` runs along the width, the axis turned by 90°
/// counter-clockwise along the height.
struct oriented_rectangle {
    dvec2 axis{1, 0};    ///< unit length
    dvec2 low{0};        ///< least coordinates of the rectangle along the two axes
    dvec2 extent{0, 0};  ///< width and height, ≥ 0

    [[nodiscard]] dvec2 height_axis() const noexcept { return {-axis.y, axis.x}; }
    [[nodiscard]] double area() const noexcept { return extent.x * extent.y; }
};

namespace detail {

[[nodiscard]] inline double turn(const dvec2& a, const dvec2& b, const dvec2& c) noexcept {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

}  // namespace detail

/// The corners of the convex hull, counter-clockwise, without repeated or collinear ones.
///
/// Shape  `hull` has room for one more than `points`; `points` is reordered.
/// Needs  finite points.
/// Gives  number of corners at the front of `hull`: 0, 1 or 2 for none, one point, a segment.
/// Cost   O(n log n), no allocation.
inline std::size_t convex_hull(std::span<dvec2> points, std::span<dvec2> hull) {
    BILLOW_ASSERT(hull.size() > points.size());
    const auto before = [](const dvec2& a, const dvec2& b) {
        return a.x < b.x || (a.x == b.x && a.y < b.y);
    };
    std::sort(points.begin(), points.end(), before);
    const auto end = std::unique(points.begin(), points.end());
    points = points.first(static_cast<std::size_t>(end - points.begin()));
    if (points.size() < 3) {
        std::copy(points.begin(), points.end(), hull.begin());
        return points.size();
    }
    std::size_t size = 0;
    const auto push = [&](const dvec2& point, std::size_t floor) {
        while (size >= floor + 2 && detail::turn(hull[size - 2], hull[size - 1], point) <= 0) {
            --size;
        }
        hull[size++] = point;
    };
    for (const dvec2& point : points) push(point, 0);  // lower chain, left to right
    const std::size_t floor = size - 1;
    for (std::size_t i = points.size() - 1; i-- > 0;) push(points[i], floor);
    return size - 1;  // the first corner came again
}

/// The rectangle of least area around a convex polygon; one of its sides lies on a polygon's side.
/// A point gives zero extents, a segment zero height.
///
/// Needs  corners as convex_hull gives them.
/// Cost   O(n).
[[nodiscard]] inline oriented_rectangle minimum_rectangle(std::span<const dvec2> hull) {
    if (hull.empty()) return {};
    if (hull.size() == 1) return {.low = hull[0]};
    const std::size_t n = hull.size();
    const auto next = [n](std::size_t i) { return i + 1 == n ? 0 : i + 1; };
    // The corners farthest along the side, away from it and against it, carried around.
    std::size_t right = 0;
    std::size_t top = 0;
    std::size_t left = 0;
    oriented_rectangle best;
    double best_area = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i) {
        const dvec2 side = hull[next(i)] - hull[i];
        const double length = std::hypot(side.x, side.y);
        if (!(length > 0)) continue;
        const dvec2 x = side / length;
        const dvec2 y{-x.y, x.x};
        const auto advance = [&](std::size_t from, const dvec2& direction) {
            for (std::size_t steps = 0; steps < n; ++steps) {
                if (glm::dot(hull[next(from)] - hull[from], direction) <= 0) break;
                from = next(from);
            }
            return from;
        };
        right = advance(i == 0 ? next(0) : right, x);
        top = advance(i == 0 ? right : top, y);
        left = advance(i == 0 ? top : left, -x);
        const dvec2 low{glm::dot(hull[left], x), glm::dot(hull[i], y)};
        const dvec2 high{glm::dot(hull[right], x), glm::dot(hull[top], y)};
        const dvec2 extent = glm::max(high - low, dvec2(0));
        if (const double area = extent.x * extent.y; area < best_area) {
            best_area = area;
            best = {x, low, extent};
        }
    }
    return best;
}

/// The rectangle of least area around points in any order.
///
/// Cost  O(n log n).
[[nodiscard]] inline oriented_rectangle minimum_rectangle_of(std::vector<dvec2> points) {
    std::vector<dvec2> hull(points.size() + 1);
    const std::size_t corners = convex_hull(points, hull);
    return minimum_rectangle(std::span<const dvec2>(hull).first(corners));
}

}  // namespace billow::inline BILLOW_ABI
