// The cube plane space: normals through the lattice points on the surface of a cube.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
// section 4.4.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <billow/plane_space/plane_space.hpp>

namespace billow::inline BILLOW_ABI {

/// The 6N²+2 lattice points on the surface of a cube of N³ unit boxes, pulled to the sphere.
///
/// A point's cell is the dual one: its corners are the centres of the squares around the point, four
/// but at the cube's corners, where three squares meet. Ids count the points inside the six sides
/// first, then those inside the twelve edges, then the eight corners. N is even, so that the axes
/// are orientations. Copies share their tables.
///
/// Differs from the thesis by the warp t → tan(t π/4) of the lattice, which spreads the directions
/// more evenly (largest half diagonal 4.0° instead of 4.5° at N = 18).
class cube_map {
public:
    /// Needs an even resolution N in [2, 1024]. Cost O(N²).
    explicit cube_map(int resolution = 18) : resolution_(resolution) {
        BILLOW_ASSERT(resolution >= 2 && resolution <= 1024 && resolution % 2 == 0);
        auto tables = std::make_shared<lattice>();
        tables->id.resize(6 * static_cast<std::size_t>(side()) * static_cast<std::size_t>(side()));
        for (int rim_count = 1; rim_count <= 3; ++rim_count) {  // sides, edges, corners
            for (int chart = 0; chart < 6; ++chart) {
                for (int j = 0; j <= resolution_; ++j) {
                    for (int i = 0; i <= resolution_; ++i) {
                        const point p = point_of(chart, i, j);
                        if (rims(p) != rim_count) continue;
                        const int home = first_chart(p);
                        if (home == chart) {
                            tables->id[slot(chart, i, j)] =
                                static_cast<orientation_id>(tables->points.size());
                            tables->points.push_back(p);
                        } else {  // numbered with an earlier side
                            tables->id[slot(chart, i, j)] = tables->id[slot(home, p)];
                        }
                    }
                }
            }
        }
        lattice_ = std::move(tables);
    }

    [[nodiscard]] int resolution() const noexcept { return resolution_; }
    [[nodiscard]] std::size_t orientation_count() const noexcept { return lattice_->points.size(); }

    [[nodiscard]] dvec3 direction(orientation_id id) const noexcept {
        const point& p = lattice_->points[id];
        return glm::normalize(dvec3(warp(p[0]), warp(p[1]), warp(p[2])));
    }

    [[nodiscard]] orientation_id antipode(orientation_id id) const noexcept {
        const point& p = lattice_->points[id];
        return id_of({resolution_ - p[0], resolution_ - p[1], resolution_ - p[2]});
    }

    /// The lattice point nearest to `normal` in the coordinates of the side that it pierces.
    [[nodiscard]] orientation_id orientation_of(const dvec3& normal) const noexcept {
        const dvec3 size = glm::abs(normal);
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        point p{};
        for (int k = 0; k < 3; ++k) {
            const double t = std::atan(normal[k] / size[axis]) * 4 / std::numbers::pi;  // [-1, 1]
            p[static_cast<std::size_t>(k)] =
                static_cast<int>(std::lround((t + 1) / 2 * resolution_));
        }
        return id_of(p);
    }

    [[nodiscard]] orientation_cell cell(orientation_id id) const noexcept {
        std::array<dvec3, 4> corners{};
        std::size_t count = 0;
        for_each_square(id, [&](int chart, int i, int j) {
            corners[count++] =
                direction_at(chart, {unit(2 * i + 1 - resolution_), unit(2 * j + 1 - resolution_)});
        });
        return make_cell(direction(id), std::span(corners).first(count));
    }

    /// The points that share a square: 8, at the cube's corners 6.
    [[nodiscard]] orientation_list neighbours(orientation_id id) const noexcept {
        orientation_list list;
        for_each_square(id, [&](int chart, int i, int j) {
            for (int k = 0; k < 4; ++k) {
                const orientation_id near = lattice_->id[slot(chart, i + k % 2, j + k / 2)];
                if (near != id) list.add_once(near);
            }
        });
        return list;
    }

    /// Charts are the six sides, with coordinates in [-1, 1]².
    [[nodiscard]] orientation_patch patch(orientation_id id) const noexcept {
        const point& p = lattice_->points[id];
        const int chart = first_chart(p);
        const auto [i, j] = chart_position(chart, p);
        return {.chart = chart,
                .centre = {unit(2 * i - resolution_), unit(2 * j - resolution_)},
                .half_size = {unit(1), unit(1)}};
    }
    /// Needs |u|, |v| < 2.
    [[nodiscard]] dvec3 direction_at(int chart, const dvec2& uv) const noexcept {
        dvec3 at{};
        at[chart % 3] = chart < 3 ? 1 : -1;
        at[(chart + 1) % 3] = std::tan(uv.x * std::numbers::pi / 4);
        at[(chart + 2) % 3] = std::tan(uv.y * std::numbers::pi / 4);
        return glm::normalize(at);
    }

private:
    using point = std::array<int, 3>;  ///< coordinates in [0, N], at least one of them 0 or N
    struct lattice {
        std::vector<point> points;       ///< by id
        std::vector<orientation_id> id;  ///< by slot
    };

    [[nodiscard]] int side() const noexcept { return resolution_ + 1; }
    [[nodiscard]] double unit(int doubled) const noexcept {
        return static_cast<double>(doubled) / resolution_;
    }
    [[nodiscard]] double warp(int coordinate) const noexcept {
        return std::tan(unit(2 * coordinate - resolution_) * std::numbers::pi / 4);
    }
    /// How many sides the point lies on.
    [[nodiscard]] int rims(const point& p) const noexcept {
        int count = 0;
        for (const int c : p) count += (c == 0 || c == resolution_) ? 1 : 0;
        return count;
    }
    /// Chart k < 3 is the side where coordinate k is N, chart k + 3 that where it is 0.
    [[nodiscard]] bool is_on(int chart, const point& p) const noexcept {
        return p[static_cast<std::size_t>(chart % 3)] == (chart < 3 ? resolution_ : 0);
    }
    [[nodiscard]] int first_chart(const point& p) const noexcept {
        int chart = 0;
        while (!is_on(chart, p)) ++chart;
        return chart;
    }
    [[nodiscard]] point point_of(int chart, int i, int j) const noexcept {
        point p{};
        p[static_cast<std::size_t>(chart % 3)] = chart < 3 ? resolution_ : 0;
        p[static_cast<std::size_t>((chart + 1) % 3)] = i;
        p[static_cast<std::size_t>((chart + 2) % 3)] = j;
        return p;
    }
    [[nodiscard]] std::array<int, 2> chart_position(int chart, const point& p) const noexcept {
        return {p[static_cast<std::size_t>((chart + 1) % 3)],
                p[static_cast<std::size_t>((chart + 2) % 3)]};
    }
    [[nodiscard]] std::size_t slot(int chart, int i, int j) const noexcept {
        return static_cast<std::size_t>((chart * side() + j) * side() + i);
    }
    [[nodiscard]] std::size_t slot(int chart, const point& p) const noexcept {
        const auto [i, j] = chart_position(chart, p);
        return slot(chart, i, j);
    }
    [[nodiscard]] orientation_id id_of(const point& p) const noexcept {
        return lattice_->id[slot(first_chart(p), p)];
    }
    /// Calls `visit(chart, i, j)` for the squares [i, i + 1] × [j, j + 1] that touch the point.
    template <class Visit>
    void for_each_square(orientation_id id, const Visit& visit) const {
        const point& p = lattice_->points[id];
        for (int chart = 0; chart < 6; ++chart) {
            if (!is_on(chart, p)) continue;
            const auto [i, j] = chart_position(chart, p);
            for (int k = 0; k < 4; ++k) {
                const int si = i - k % 2;
                const int sj = j - k / 2;
                if (si >= 0 && sj >= 0 && si < resolution_ && sj < resolution_)
                    visit(chart, si, sj);
            }
        }
    }

    int resolution_;
    std::shared_ptr<const lattice> lattice_;
};
static_assert(plane_space<cube_map>);

}  // namespace billow::inline BILLOW_ABI
