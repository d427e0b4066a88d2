// What every plane space answers: which orientations it samples, and the cell around each.
//
// Décoret et al. 2003 sample planes on a spherical grid, Luksch 2009 (section 4.4) on a cube. Both
// divide the sphere of normals into cells; the offsets rho along a normal are divided elsewhere.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>

#include <span>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// A part of the sphere of normals as the kernels read it. A cell of three corners repeats one.
struct orientation_cell {
    vec3 centre{};
    std::array<vec3, 4> corner{};
    float chord = 0;  ///< largest distance of a corner to the centre, 2 sin(half diagonal / 2)
};

/// The cell around `centre` with three or four corners, all of length 1.
[[nodiscard]] inline orientation_cell make_cell(const dvec3& centre,
                                                std::span<const dvec3> corners) noexcept {
    BILLOW_ASSERT(corners.size() == 3 || corners.size() == 4);
    orientation_cell cell{.centre = vec3(centre)};
    double chord = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        const dvec3& corner = corners[std::min(k, corners.size() - 1)];
        cell.corner[k] = vec3(corner);
        chord = std::max(chord, glm::distance(corner, centre));
    }
    cell.chord = static_cast<float>(chord);
    return cell;
}

/// A rectangle in the (u, v) coordinates of one of a plane space's charts. It can be split and
/// moved beyond the rim of its chart, where the coordinates go on smoothly.
struct orientation_patch {
    int chart = 0;
    dvec2 centre{0};     ///< in chart coordinates
    dvec2 half_size{0};  ///< in chart coordinates
};

/// Samples of the sphere of normals. The antipode of every orientation is one too, since (n, rho)
/// and (-n, -rho) are the same plane.
template <class S>
concept plane_space = std::copyable<S> &&
    requires(const S& space, orientation_id id, const dvec3& normal, int chart, const dvec2& uv) {
    { space.orientation_count() } -> std::convertible_to<std::size_t>;
    { space.direction(id) } -> std::convertible_to<dvec3>;
    { space.antipode(id) } -> std::convertible_to<orientation_id>;
    { space.orientation_of(normal) } -> std::convertible_to<orientation_id>;
    { space.cell(id) } -> std::convertible_to<orientation_cell>;
    space.neighbours(id).begin();
    { space.patch(id) } -> std::convertible_to<orientation_patch>;
    { space.direction_at(chart, uv) } -> std::convertible_to<dvec3>;
};

/// The cell that a patch covers.
template <plane_space Space>
[[nodiscard]] orientation_cell cell_of_patch(const Space& space, const orientation_patch& patch) {
    const auto at = [&](double u, double v) {
        return space.direction_at(patch.chart, patch.centre + patch.half_size * dvec2(u, v));
    };
    return make_cell(at(0, 0), std::array{at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)});
}

/// A few ids: the neighbours of an orientation.
class orientation_list {
public:
    void add_once(orientation_id id) noexcept {
        if (std::ranges::find(*this, id) == end()) ids_[size_++] = id;
    }
    [[nodiscard]] const orientation_id* begin() const noexcept { return ids_.data(); }
    [[nodiscard]] const orientation_id* end() const noexcept { return ids_.data() + size_; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }

private:
    std::array<orientation_id, 12> ids_{};
    std::size_t size_ = 0;
};

}  // namespace billow::inline BILLOW_ABI
