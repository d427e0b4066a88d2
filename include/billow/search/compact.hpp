// Compact sets: a plane takes faces that lie together, not islands with empty texels between them.
//
// Décoret et al. 2003 ("compact sets"); Luksch, "Implementation of an Improved Billboard Cloud
// Algorithm", 2009, sections 2.1 and 3.3 ("texture clustering").
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include <billow/core/disjoint_sets.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/geometry/rectangle.hpp>
#include <billow/policy/contribution.hpp>
#include <billow/search/grouping.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// The rectangle that a face covers on a plane, along the axes of a frame.
struct face_extent {
    dvec2 low{0};
    dvec2 high{0};
};

[[nodiscard]] inline dvec2 corner_on_plane(const face_table& faces, const frame& axes,
                                           std::size_t row, std::size_t k) noexcept {
    const dvec3 corner = faces.corner[k].get(row);
    return {glm::dot(axes.u, corner), glm::dot(axes.v, corner)};
}

[[nodiscard]] inline std::vector<face_extent> extents_on_plane(const face_table& faces,
                                                               const frame& axes,
                                                               parallel threads) {
    std::vector<face_extent> extents(faces.size);
    threads.for_chunks(faces.size, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const dvec2 a = corner_on_plane(faces, axes, row, 0);
            const dvec2 b = corner_on_plane(faces, axes, row, 1);
            const dvec2 c = corner_on_plane(faces, axes, row, 2);
            extents[row] = {glm::min(glm::min(a, b), c), glm::max(glm::max(a, b), c)};
        }
    });
    return extents;
}

/// The longer side of the median face's extent. Needs a face.
[[nodiscard]] inline double median_extent(std::span<const face_extent> extents) {
    std::vector<double> sides;
    sides.reserve(extents.size());
    for (const face_extent& e : extents) {
        sides.push_back(std::max(e.high.x - e.low.x, e.high.y - e.low.y));
    }
    const auto middle = sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2);
    std::nth_element(sides.begin(), middle, sides.end());
    return *middle;
}

/// The island of each face, numbered from 0: faces are of one island when a chain of cells that they
/// occupy, side by side or corner to corner, joins them. A face occupies all cells that its extent
/// touches. Cost O(faces + cells they occupy); at most ceil(2 · radius / cell + 1)² cells.
[[nodiscard]] inline std::vector<std::uint32_t> islands_of(std::span<const face_extent> extents,
                                                           double radius, double cell,
                                                           std::size_t& island_count) {
    const int side = static_cast<int>(2 * radius / cell) + 1;
    const auto column = [&](double at) {
        return std::clamp(static_cast<int>((at + radius) / cell), 0, side - 1);
    };
    const auto id = [&](int x, int y) { return static_cast<std::uint32_t>(y * side + x); };
    disjoint_sets cells(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    std::vector<char> is_occupied(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    std::vector<std::uint32_t> first_cell;
    first_cell.reserve(extents.size());
    for (const face_extent& e : extents) {
        const int left = column(e.low.x), right = column(e.high.x);
        const int bottom = column(e.low.y), top = column(e.high.y);
        first_cell.push_back(id(left, bottom));
        for (int y = bottom; y <= top; ++y) {
            for (int x = left; x <= right; ++x) is_occupied[id(x, y)] = 1;
        }
    }
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            if (!is_occupied[id(x, y)]) continue;
            const auto join = [&](int i, int j) {
                if (i >= 0 && i < side && j < side && is_occupied[id(i, j)]) {
                    cells.join(id(x, y), id(i, j));
                }
            };
            join(x + 1, y), join(x - 1, y + 1), join(x, y + 1), join(x + 1, y + 1);
        }
    }
    // Empty cells are sets too: number those of faces only.
    std::vector<std::uint32_t> number(is_occupied.size(), no_id);
    std::vector<std::uint32_t> island;
    island.reserve(extents.size());
    std::uint32_t count = 0;
    for (const std::uint32_t at : first_cell) {
        std::uint32_t& n = number[cells.leader(at)];
        if (n == no_id) n = count++;
        island.push_back(n);
    }
    island_count = count;
    return island;
}

/// A convex outline, and the area of the least rectangle around it.
struct outline {
    std::vector<dvec2> hull{};
    double rectangle = 0;
};

[[nodiscard]] inline outline outline_of(std::vector<dvec2> points) {
    outline result{.hull = std::vector<dvec2>(points.size() + 1)};
    result.hull.resize(convex_hull(points, result.hull));
    result.rectangle = minimum_rectangle(result.hull).area();
    return result;
}

}  // namespace detail

/// Takes the island of most contribution, and others for which a plane of their own would cost more
/// than the empty texels between. The rest stays for later planes, which may be the same one again.
///
/// Two islands share a plane when
///   (rectangle around both - rectangle of each) · texel_cost < 1,
/// areas in squares of the radius, so that texel_cost says how many planes an empty area of one
/// radius squared is worth. With T texels along the diameter that area is T² / 4 texels: at T = 512
/// and the default, 16,384 empty texels pay for one more plane.
///
/// Source: Décoret et al. 2003, who weigh the number of planes against compact textures; Luksch 2009,
/// section 3.3. Differs: a grid on the plane finds the islands; only the plane at hand is searched
/// for its heaviest one, not the runners-up, as the thesis advises.
template <contribution<float> Contribution = projected_area>
struct heaviest_group {
    static constexpr bool takes_all = false;

    double texel_cost = 4;  ///< planes a radius squared, ≥ 0; 0 takes every face
    double cell_faces = 2;  ///< side of a grid cell in median faces, > 0: smaller gaps part nothing
    double least_cell = 0.05;  ///< side of a grid cell in radii, at least, ≥ 0.01
    Contribution worth{};      ///< weighs the islands

    /// Cost O(faces log faces), partly parallel.
    [[nodiscard]] face_rows operator()(const face_table& valid, const plane& p, double,
                                       parallel threads = {}) const {
        const frame axes = frame_around(p.normal);
        const double radius = valid.bounds.radius;
        face_rows kept(valid.size);
        std::iota(kept.begin(), kept.end(), 0u);
        if (valid.size < 2 || !(texel_cost > 0)) return kept;

        const auto extents = detail::extents_on_plane(valid, axes, threads);
        const double cell =
            std::max(cell_faces * detail::median_extent(extents), least_cell * radius);
        std::size_t island_count = 0;
        const auto island = detail::islands_of(extents, radius, cell, island_count);
        if (island_count == 1) return kept;
        const auto is_taken = choose(valid, axes, p, island, island_count);
        std::erase_if(kept, [&](std::uint32_t row) { return !is_taken[island[row]]; });
        return kept;
    }

private:
    /// The heaviest island, then in order of weight each that costs less here than on its own, until
    /// no other does.
    [[nodiscard]] std::vector<char> choose(const face_table& valid, const frame& axes,
                                           const plane& p, std::span<const std::uint32_t> island,
                                           std::size_t island_count) const {
        const vec3_lanes<float> normal = fill_lanes<float>(vec3(p.normal));
        std::vector<double> weight(island_count);
        std::vector<std::vector<dvec2>> points(island_count);
        for (std::size_t row = 0; row < valid.size; ++row) {
            weight[island[row]] +=
                static_cast<double>(worth(load_faces<float>(valid, row), normal));
            for (std::size_t k = 0; k < 3; ++k) {
                points[island[row]].push_back(detail::corner_on_plane(valid, axes, row, k));
            }
        }
        std::vector<detail::outline> outlines;
        outlines.reserve(island_count);
        for (auto& of_island : points) {
            outlines.push_back(detail::outline_of(std::move(of_island)));
        }
        std::vector<std::uint32_t> order(island_count);
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::stable_sort(order, std::greater{}, [&](auto i) { return weight[i]; });

        const double plane_worth = valid.bounds.radius * valid.bounds.radius / texel_cost;
        std::vector<char> is_taken(island_count);
        is_taken[order[0]] = 1;
        detail::outline all = outlines[order[0]];
        for (bool grows = true; grows;) {
            grows = false;
            for (const std::uint32_t i : order) {
                if (is_taken[i]) continue;
                std::vector<dvec2> both = all.hull;
                both.insert(both.end(), outlines[i].hull.begin(), outlines[i].hull.end());
                detail::outline joint = detail::outline_of(std::move(both));
                if (joint.rectangle - all.rectangle - outlines[i].rectangle < plane_worth) {
                    is_taken[i] = 1;
                    all = std::move(joint);
                    grows = true;
                }
            }
        }
        return is_taken;
    }
};
static_assert(face_grouping<heaviest_group<>>);

}  // namespace billow::inline BILLOW_ABI
