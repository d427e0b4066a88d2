// Convex polygons of few corners around a shape, within a rectangle.
//
// Persson, "Particle trimming", 2009, has the use: a billboard that is cut along its outline wastes
// fewer transparent fragments. He searches all corner sets; here corners are cut off one by one, and
// each cut is chosen again while that helps.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/geometry/rectangle.hpp>

namespace billow::inline BILLOW_ABI {

/// Twice the area of a polygon, positive when its corners are counter-clockwise.
[[nodiscard]] inline double doubled_area(std::span<const dvec2> polygon) noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const dvec2& a = polygon[i];
        const dvec2& b = polygon[i + 1 == polygon.size() ? 0 : i + 1];
        sum += a.x * b.y - a.y * b.x;
    }
    return sum;
}

namespace detail {

/// All points p with normal·p ≤ limit.
struct half_plane {
    dvec2 normal{0};
    double limit = 0;
};

using outline_corners = std::vector<dvec2>;

/// The part of a convex polygon within a half plane, corners closer than `slack` merged.
inline void cut_polygon(const outline_corners& from, const half_plane& keep, double slack,
                        outline_corners& to) {
    to.clear();
    const auto add = [&](const dvec2& p) {
        if (to.empty() || glm::distance(to.back(), p) > slack) to.push_back(p);
    };
    for (std::size_t i = 0; i < from.size(); ++i) {
        const dvec2& a = from[i];
        const dvec2& b = from[i + 1 == from.size() ? 0 : i + 1];
        const double above_a = glm::dot(keep.normal, a) - keep.limit;
        const double above_b = glm::dot(keep.normal, b) - keep.limit;
        if (above_a <= 0) add(a);
        if ((above_a < 0 && above_b > 0) || (above_a > 0 && above_b < 0)) {
            add(a + (b - a) * (above_a / (above_a - above_b)));
        }
    }
    while (to.size() > 1 && glm::distance(to.front(), to.back()) <= slack) to.pop_back();
}

/// The lines that touch the hull: along its sides, and at evenly spread directions.
[[nodiscard]] inline std::vector<half_plane> touching_lines(std::span<const dvec2> hull) {
    constexpr int direction_count = 64;
    std::vector<half_plane> lines;
    const auto touch = [&](const dvec2& normal) {
        double limit = -std::numeric_limits<double>::infinity();
        for (const dvec2& p : hull) limit = std::max(limit, glm::dot(normal, p));
        lines.push_back({normal, limit});
    };
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const dvec2 side = hull[i + 1 == hull.size() ? 0 : i + 1] - hull[i];
        if (const double length = glm::length(side); length > 0) {
            touch(dvec2(side.y, -side.x) / length);
        }
    }
    for (int i = 0; i < direction_count; ++i) {
        const double angle = 2 * std::numbers::pi * i / direction_count;
        touch({std::cos(angle), std::sin(angle)});
    }
    return lines;
}

}  // namespace detail

/// A convex polygon of at most `most_corners` corners that holds `hull` and lies within the rectangle
/// from `low` to `high`: the rectangle, cut along lines that touch the hull, each cut the one that
/// takes most area away.
///
/// Needs  hull: a convex polygon within the rectangle, corners counter-clockwise; most_corners ≥ 4.
/// Gives  corners counter-clockwise, never more area than the rectangle. The rectangle itself, where
///        the hull has no corner.
/// Cost   O(most_corners² · (n + 64)) clips of a small polygon.
/// Source Persson 2009, see above: greedy instead of exhaustive; the corners stay in the rectangle,
///        where a texture atlas holds other tiles beyond it.
[[nodiscard]] inline std::vector<dvec2> outline_polygon(std::span<const dvec2> hull,
                                                        const dvec2& low, const dvec2& high,
                                                        int most_corners) {
    BILLOW_ASSERT(most_corners >= 4);
    detail::outline_corners rectangle{low, {high.x, low.y}, high, {low.x, high.y}};
    if (hull.empty()) return rectangle;
    const double slack = 1e-9 * glm::distance(low, high);
    const std::vector<detail::half_plane> lines = detail::touching_lines(hull);
    const auto most = static_cast<std::size_t>(most_corners);

    detail::outline_corners cut;
    /// The line that leaves the least of `from`, within `room` corners.
    const auto best_cut = [&](const detail::outline_corners& from) {
        std::size_t best = lines.size();
        double least = doubled_area(from) * (1 - 1e-9);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            detail::cut_polygon(from, lines[i], slack, cut);
            if (cut.size() < 3 || cut.size() > most) continue;
            if (const double area = doubled_area(cut); area < least) least = area, best = i;
        }
        return best;
    };
    const auto polygon_of = [&](const std::vector<std::size_t>& cuts) {
        detail::outline_corners result = rectangle;
        for (const std::size_t i : cuts) {
            detail::cut_polygon(result, lines[i], slack, cut);
            std::swap(result, cut);
        }
        return result;
    };

    std::vector<std::size_t> cuts;
    detail::outline_corners result = rectangle;
    const auto extend = [&] {
        for (std::size_t i; cuts.size() < 2 * most && (i = best_cut(result)) < lines.size();) {
            cuts.push_back(i);
            result = polygon_of(cuts);
        }
    };
    extend();
    for (int round = 0; round < 4; ++round) {
        const double before = doubled_area(result);
        for (std::size_t drop = 0; drop < cuts.size(); ++drop) {
            const std::vector<std::size_t> kept_cuts = cuts;
            const detail::outline_corners kept = result;
            cuts.erase(cuts.begin() + static_cast<std::ptrdiff_t>(drop));
            result = polygon_of(cuts);
            if (result.size() <= most) extend();
            if (result.size() > most || doubled_area(result) >= doubled_area(kept)) {
                cuts = kept_cuts;
                result = kept;
            }
        }
        if (doubled_area(result) > before * (1 - 1e-6)) break;
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI
