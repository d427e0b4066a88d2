// Which samples of a grid a triangle covers.
//
// Edge functions after Pineda, "A parallel algorithm for polygon rasterization", SIGGRAPH 1988, in
// integers, so that two triangles along a shared edge never both take a sample nor both leave it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Columns [x_begin, x_end) and rows [y_begin, y_end) of a grid of samples. The sample (x, y) lies
/// at (x + 0.5, y + 0.5); y runs down.
struct sample_window {
    int x_begin = 0;
    int y_begin = 0;
    int x_end = 0;
    int y_end = 0;
};

/// A value that changes linearly over the grid: `base` at the sample (0, 0), `dx` more each column
/// and `dy` more each row.
struct affine_value {
    double base = 0;
    double dx = 0;
    double dy = 0;

    [[nodiscard]] double at(double x, double y) const noexcept { return base + dy * y + dx * x; }
};

namespace detail {

[[nodiscard]] constexpr std::int64_t floor_div(std::int64_t a, std::int64_t b) noexcept {
    return a / b - ((a % b != 0 && (a < 0) != (b < 0)) ? 1 : 0);
}
[[nodiscard]] constexpr std::int64_t ceil_div(std::int64_t a, std::int64_t b) noexcept {
    return -floor_div(-a, b);
}

}  // namespace detail

/// A triangle snapped to 1/256 of a sample. Its winding does not matter. A sample on an edge belongs
/// to the triangle for which the edge is a left or top one.
class raster_triangle {
public:
    /// Needs  finite corners in samples. Beyond ±2²¹ samples they are moved to that limit.
    explicit raster_triangle(const std::array<dvec2, 3>& corners) noexcept {
        for (std::size_t i = 0; i < 3; ++i) {
            x_[i] = snapped(corners[i].x);
            y_[i] = snapped(corners[i].y);
        }
        doubled_area_ = (x_[1] - x_[0]) * (y_[2] - y_[0]) - (x_[2] - x_[0]) * (y_[1] - y_[0]);
    }

    /// Whether the triangle covers nothing.
    [[nodiscard]] bool is_empty() const noexcept { return doubled_area_ == 0; }
    /// In samples.
    [[nodiscard]] double area() const noexcept {
        return std::abs(static_cast<double>(doubled_area_)) / (2.0 * unit * unit);
    }

    /// Calls `visit(y, x_begin, x_end)` for every row of samples that is covered within `window`.
    template <class Visit>
    void for_each_row(const sample_window& window, const Visit& visit) const {
        if (is_empty()) return;
        std::array<edge, 3> edges;
        for (std::size_t i = 0; i < 3; ++i) edges[i] = edge_from(i);
        const auto [y_low, y_high] = std::minmax({y_[0], y_[1], y_[2]});
        const auto [x_low, x_high] = std::minmax({x_[0], x_[1], x_[2]});
        const std::int64_t first = std::max<std::int64_t>(window.y_begin, first_centre(y_low));
        const std::int64_t last = std::min<std::int64_t>(window.y_end, last_centre(y_high) + 1);
        const std::int64_t left = std::max<std::int64_t>(window.x_begin, first_centre(x_low));
        const std::int64_t right = std::min<std::int64_t>(window.x_end, last_centre(x_high) + 1);
        for (std::int64_t y = first; y < last; ++y) {
            std::int64_t begin = left;
            std::int64_t end = right;
            for (const edge& e : edges) {
                const std::int64_t start = e.start + e.down * y;  // at x = 0; covered where ≥ 0
                if (e.across > 0) {
                    begin = std::max(begin, detail::ceil_div(-start, e.across));
                } else if (e.across < 0) {
                    end = std::min(end, detail::floor_div(start, -e.across) + 1);
                } else if (start < 0) {
                    end = begin;
                }
            }
            if (begin < end) {
                visit(static_cast<int>(y), static_cast<int>(begin), static_cast<int>(end));
            }
        }
    }

    /// Whether the triangle covers half a sample or more but is narrower than one, so that it may slip
    /// between them.
    [[nodiscard]] bool is_sliver() const noexcept {
        if (std::abs(doubled_area_) < unit * unit) return false;
        double longest_sq = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t k = i == 2 ? 0 : i + 1;
            const auto dx = static_cast<double>(x_[k] - x_[i]);
            const auto dy = static_cast<double>(y_[k] - y_[i]);
            longest_sq = std::max(longest_sq, dx * dx + dy * dy);
        }
        const auto width_by_longest = static_cast<double>(doubled_area_) / unit;
        return longest_sq > width_by_longest * width_by_longest;
    }

    /// Calls `visit(y, x, at)` for samples that a sliver owes: as many as its area, rounded up where
    /// its fraction exceeds 1 - `rounding`, is more than for_each_row takes. They lie along its
    /// longer axis, spread over the columns (or rows) where it takes none, and it passes through
    /// their squares at `at` (the sample (x, y) is at (x, y) there).
    ///
    /// Cost   O(samples along it), whatever the window.
    /// Source the promise is that of Fuhrmann et al. 2005, section 3.3.7. Differs: they enlarge the
    ///        buffer until every face covers a pixel.
    template <class Visit>
    void for_each_missing(const sample_window& window, double rounding, const Visit& visit) const {
        constexpr int limit = 1 << 22;
        std::int64_t owed = static_cast<std::int64_t>(area() + rounding);
        for_each_row({-limit, -limit, limit, limit},
                     [&](int, int begin, int end) { owed -= end - begin; });
        if (owed <= 0) return;
        const sliver_axis axis(*this);
        double free_area = 0;
        const auto is_free = [&](std::int64_t i) {
            const std::int64_t j = axis.middle_sample(i);
            return !axis.takes(i, j - 1) && !axis.takes(i, j) && !axis.takes(i, j + 1);
        };
        for (std::int64_t i = axis.first(); i <= axis.last(); ++i) {
            if (is_free(i)) free_area += axis.area_in(i);
        }
        if (!(free_area > 0)) return;
        const double rate = static_cast<double>(owed) / free_area;
        double due = 0.5;
        for (std::int64_t i = axis.first(); i <= axis.last(); ++i) {
            if (!is_free(i)) continue;
            due += rate * axis.area_in(i);
            if (due < 1) continue;
            due -= 1;
            const auto at = axis.is_tall ? std::pair(axis.middle_sample(i), i)
                                         : std::pair(i, axis.middle_sample(i));
            if (at.first >= window.x_begin && at.first < window.x_end &&
                at.second >= window.y_begin && at.second < window.y_end) {
                visit(static_cast<int>(at.second), static_cast<int>(at.first), axis.middle(i));
            }
        }
    }

    /// The value that is a, b, c at the corners. Needs !is_empty().
    [[nodiscard]] affine_value interpolate(double a, double b, double c) const noexcept {
        const double ux = static_cast<double>(x_[1] - x_[0]);
        const double uy = static_cast<double>(y_[1] - y_[0]);
        const double vx = static_cast<double>(x_[2] - x_[0]);
        const double vy = static_cast<double>(y_[2] - y_[0]);
        const double scale = unit / static_cast<double>(doubled_area_);
        affine_value value;
        value.dx = ((b - a) * vy - (c - a) * uy) * scale;
        value.dy = ((c - a) * ux - (b - a) * vx) * scale;
        const double x = 0.5 - static_cast<double>(x_[0]) / unit;
        const double y = 0.5 - static_cast<double>(y_[0]) / unit;
        value.base = a + value.dx * x + value.dy * y;
        return value;
    }

private:
    static constexpr std::int64_t unit = 256;

    /// covered(x, y) = start + across * x + down * y ≥ 0 for sample columns and rows.
    struct edge {
        std::int64_t start = 0;
        std::int64_t across = 0;
        std::int64_t down = 0;
    };

    /// A triangle along its longer axis, in samples: i counts them along it, j across.
    struct sliver_axis {
        const raster_triangle& of;
        bool is_tall;
        std::array<edge, 3> edges{};
        std::array<dvec2, 3> corner{};  ///< (along, across), ascending along

        explicit sliver_axis(const raster_triangle& triangle) noexcept : of(triangle) {
            const auto [x_low, x_high] = std::minmax({of.x_[0], of.x_[1], of.x_[2]});
            const auto [y_low, y_high] = std::minmax({of.y_[0], of.y_[1], of.y_[2]});
            is_tall = y_high - y_low > x_high - x_low;
            for (std::size_t k = 0; k < 3; ++k) {
                edges[k] = of.edge_from(k);
                const dvec2 p = dvec2(of.x_[k], of.y_[k]) / static_cast<double>(unit);
                corner[k] = is_tall ? dvec2(p.y, p.x) : p;
            }
            std::sort(corner.begin(), corner.end(),
                      [](const dvec2& a, const dvec2& b) { return a.x < b.x; });
        }

        [[nodiscard]] std::int64_t first() const noexcept {
            return static_cast<std::int64_t>(std::floor(corner[0].x));
        }
        [[nodiscard]] std::int64_t last() const noexcept {
            return static_cast<std::int64_t>(std::ceil(corner[2].x)) - 1;
        }
        [[nodiscard]] bool takes(std::int64_t i, std::int64_t j) const noexcept {
            const std::int64_t x = is_tall ? j : i;
            const std::int64_t y = is_tall ? i : j;
            const auto is_inside = [&](const edge& e) {
                return e.start + e.across * x + e.down * y >= 0;
            };
            return std::all_of(edges.begin(), edges.end(), is_inside);
        }

        /// Halfway across, above the middle of column i or the end next to it.
        [[nodiscard]] dvec2 middle_of(std::int64_t i) const noexcept {
            const double at = std::clamp(static_cast<double>(i) + 0.5, corner[0].x, corner[2].x);
            const auto between = [at](const dvec2& a, const dvec2& b) {
                return b.x > a.x ? a.y + (b.y - a.y) * ((at - a.x) / (b.x - a.x)) : b.y;
            };
            const double near =
                at < corner[1].x ? between(corner[0], corner[1]) : between(corner[1], corner[2]);
            return {at, 0.5 * (between(corner[0], corner[2]) + near)};
        }
        [[nodiscard]] std::int64_t middle_sample(std::int64_t i) const noexcept {
            return static_cast<std::int64_t>(std::floor(middle_of(i).y));
        }
        [[nodiscard]] dvec2 middle(std::int64_t i) const noexcept {
            const dvec2 p = middle_of(i) - 0.5;
            return is_tall ? dvec2(p.y, p.x) : p;
        }

        [[nodiscard]] double area_in(std::int64_t i) const noexcept {
            return area_before(static_cast<double>(i) + 1) - area_before(static_cast<double>(i));
        }
        [[nodiscard]] double area_before(double at) const noexcept {
            const double low = corner[0].x;
            const double high = corner[2].x;
            const double peak = corner[1].x;
            const double area = of.area();
            if (at <= low) return 0;
            if (at >= high) return area;
            const double scale = area / (high - low);
            return at < peak ? scale * (at - low) * (at - low) / (peak - low)
                             : area - scale * (high - at) * (high - at) / (high - peak);
        }
    };

    [[nodiscard]] static std::int64_t snapped(double value) noexcept {
        constexpr double limit = 2097152.0;  // 2²¹: edge products stay below 2⁶²
        return static_cast<std::int64_t>(std::floor(std::clamp(value, -limit, limit) * unit + 0.5));
    }
    [[nodiscard]] static std::int64_t first_centre(std::int64_t at) noexcept {
        return detail::ceil_div(at - unit / 2, unit);
    }
    [[nodiscard]] static std::int64_t last_centre(std::int64_t at) noexcept {
        return detail::floor_div(at - unit / 2, unit);
    }

    [[nodiscard]] edge edge_from(std::size_t i) const noexcept {
        std::size_t from = i;
        std::size_t to = i == 2 ? 0 : i + 1;
        if (doubled_area_ < 0) std::swap(from, to);
        const std::int64_t dx = x_[to] - x_[from];
        const std::int64_t dy = y_[to] - y_[from];
        const bool is_top_left = dy < 0 || (dy == 0 && dx > 0);
        // dx (y - y0) - dy (x - x0) at the sample centres, one less where the edge is excluded.
        const std::int64_t start = dx * (unit / 2 - y_[from]) - dy * (unit / 2 - x_[from]);
        return {start - (is_top_left ? 0 : 1), -dy * unit, dx * unit};
    }

    std::array<std::int64_t, 3> x_{};
    std::array<std::int64_t, 3> y_{};
    std::int64_t doubled_area_ = 0;
};

}  // namespace billow::inline BILLOW_ABI
