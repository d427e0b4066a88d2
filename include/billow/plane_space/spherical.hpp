// The spherical plane space: a grid of longitude and latitude.
//
// X. Décoret, F. Durand, F. X. Sillion, J. Dorsey: Billboard clouds for extreme model
// simplification. SIGGRAPH 2003; as described by C. Luksch: Implementation of an improved billboard
// cloud algorithm. Thesis, TU Wien 2009, sections 2.1 and 3.2.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <billow/plane_space/plane_space.hpp>

namespace billow::inline BILLOW_ABI {

/// 4N longitudes times 2N latitudes: 8N² orientations, as far apart at the equator as those of
/// cube_map(N), crowded at the poles.
///
/// Cell (i, j) spans theta in [i, i + 1] · 2π / 4N and phi in [j, j + 1] · π / 2N; its id is
/// 4N · j + i. The direction is (sin phi cos theta, sin phi sin theta, cos phi): the roles of theta
/// and phi in eq 3.2 and 3.3 of the thesis disagree, here they follow eq 3.3's ranges.
class spherical {
public:
    /// Needs resolution ≥ 1.
    explicit spherical(int resolution = 18) : resolution_(resolution) {
        BILLOW_ASSERT(resolution >= 1);
    }

    [[nodiscard]] int resolution() const noexcept { return resolution_; }
    [[nodiscard]] std::size_t orientation_count() const noexcept {
        return static_cast<std::size_t>(columns()) * static_cast<std::size_t>(rows());
    }

    [[nodiscard]] dvec3 direction(orientation_id id) const noexcept {
        // The lower half mirrors the upper one exactly, so antipodes are exact negatives.
        if (row(id) >= resolution_) return -direction(antipode(id));
        return direction_at(0, patch(id).centre);
    }

    [[nodiscard]] orientation_id antipode(orientation_id id) const noexcept {
        return id_of(column(id) + columns() / 2, rows() - 1 - row(id));
    }

    /// The cell that holds `normal`, which has length 1.
    [[nodiscard]] orientation_id orientation_of(const dvec3& normal) const noexcept {
        const double theta = std::atan2(normal.y, normal.x) + 2 * std::numbers::pi;
        const double phi = std::acos(std::clamp(normal.z, -1.0, 1.0));
        return id_of(static_cast<int>(theta / step()),
                     std::min(static_cast<int>(phi / step()), rows() - 1));
    }

    [[nodiscard]] orientation_cell cell(orientation_id id) const noexcept {
        const orientation_patch p = patch(id);
        const auto at = [&](double u, double v) {
            return direction_at(0, p.centre + p.half_size * dvec2(u, v));
        };
        return make_cell(direction(id), std::array{at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)});
    }

    /// The cells that share a side or a corner: 8. Across a pole they lie half a turn away.
    [[nodiscard]] orientation_list neighbours(orientation_id id) const noexcept {
        orientation_list list;
        for (int dj = -1; dj <= 1; ++dj) {
            for (int di = -1; di <= 1; ++di) {
                int i = column(id) + di;
                int j = row(id) + dj;
                if (j < 0 || j >= rows()) {
                    i += columns() / 2;
                    j = j < 0 ? 0 : rows() - 1;
                }
                if (const orientation_id near = id_of(i, j); near != id) list.add_once(near);
            }
        }
        return list;
    }

    /// Chart 0, coordinates (theta, phi) in radians.
    [[nodiscard]] orientation_patch patch(orientation_id id) const noexcept {
        return {.chart = 0,
                .centre = {(column(id) + 0.5) * step(), (row(id) + 0.5) * step()},
                .half_size = {step() / 2, step() / 2}};
    }
    [[nodiscard]] dvec3 direction_at(int, const dvec2& theta_phi) const noexcept {
        const double sin_phi = std::sin(theta_phi.y);
        return {sin_phi * std::cos(theta_phi.x), sin_phi * std::sin(theta_phi.x),
                std::cos(theta_phi.y)};
    }

private:
    [[nodiscard]] int columns() const noexcept { return 4 * resolution_; }
    [[nodiscard]] int rows() const noexcept { return 2 * resolution_; }
    [[nodiscard]] double step() const noexcept { return std::numbers::pi / rows(); }
    [[nodiscard]] int column(orientation_id id) const noexcept {
        return static_cast<int>(id) % columns();
    }
    [[nodiscard]] int row(orientation_id id) const noexcept {
        return static_cast<int>(id) / columns();
    }
    [[nodiscard]] orientation_id id_of(int column, int row) const noexcept {
        const int wrapped = ((column % columns()) + columns()) % columns();
        return static_cast<orientation_id>(row * columns() + wrapped);
    }

    int resolution_;
};
static_assert(plane_space<spherical>);

}  // namespace billow::inline BILLOW_ABI
