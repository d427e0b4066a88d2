// One plane for the faces of several: whether their joint width is at most 2 epsilon.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <billow/fit/minimax.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/search/face_sets.hpp>

namespace billow::inline BILLOW_ABI {

/// How far faces reach along a normal, and the rows that do.
struct face_extent_along {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    std::uint32_t low_row = no_id;
    std::uint32_t high_row = no_id;

    [[nodiscard]] double width() const noexcept { return high - low; }
};

[[nodiscard]] inline face_extent_along extent_along(const face_table& faces,
                                                    std::span<const std::uint32_t> rows,
                                                    const dvec3& normal) noexcept {
    face_extent_along extent;
    for (const std::uint32_t row : rows) {
        for (const columns3& corner : faces.corner) {
            const double at = glm::dot(normal, corner.get(row));
            if (at < extent.low) extent.low = at, extent.low_row = row;
            if (at > extent.high) extent.high = at, extent.high_row = row;
        }
    }
    return extent;
}

/// The rows whose faces reach farthest along some directions, ascending: a small set whose least
/// width is nearly that of all. Cost O(rows).
[[nodiscard]] inline face_rows extreme_rows(const face_table& faces,
                                            std::span<const std::uint32_t> rows) {
    static constexpr std::size_t count = 20;
    struct extreme {
        float low = std::numeric_limits<float>::max();
        float high = -std::numeric_limits<float>::max();
        std::uint32_t low_row = no_id, high_row = no_id;
    };
    std::array<vec3, count> directions;  // a spiral of equal steps down a half sphere
    for (std::size_t i = 0; i < count; ++i) {
        const double z = (static_cast<double>(i) + 0.5) / count;
        const double around = static_cast<double>(i) * 2.399963229728653;  // the golden angle
        const double r = std::sqrt(1 - z * z);
        directions[i] = vec3(dvec3(r * std::cos(around), r * std::sin(around), z));
    }
    std::array<extreme, count> extremes;
    for (const std::uint32_t row : rows) {
        for (const columns3& corner : faces.corner) {
            const vec3 p(corner.x[row], corner.y[row], corner.z[row]);
            for (std::size_t i = 0; i < count; ++i) {
                const float at = glm::dot(directions[i], p);
                if (at < extremes[i].low) extremes[i].low = at, extremes[i].low_row = row;
                if (at > extremes[i].high) extremes[i].high = at, extremes[i].high_row = row;
            }
        }
    }
    face_rows found;
    if (rows.empty()) return found;
    for (const extreme& e : extremes) found.push_back(e.low_row), found.push_back(e.high_row);
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

namespace detail {

/// The least width of a tetrahedron: of its four heights and the distances of its three pairs of
/// opposite edges. 0 for a flat one.
[[nodiscard]] inline double tetrahedron_width(const std::array<dvec3, 4>& corner) noexcept {
    const double volume6 = std::abs(
        glm::dot(corner[1] - corner[0], glm::cross(corner[2] - corner[0], corner[3] - corner[0])));
    double largest = 0;  // of what divides the volume
    for (std::size_t i = 0; i < 4; ++i) {
        const dvec3 &a = corner[i == 0 ? 1 : 0], &b = corner[i <= 1 ? 2 : 1],
                    &c = corner[i <= 2 ? 3 : 2];
        largest = std::max(largest, glm::length(glm::cross(b - a, c - a)));
    }
    for (std::size_t i = 1; i < 4; ++i) {
        const dvec3 across = corner[i % 3 + 1] - corner[(i + 1) % 3 + 1];
        largest = std::max(largest, glm::length(glm::cross(corner[i] - corner[0], across)));
    }
    return largest > 0 ? volume6 / largest : 0;
}

/// The corner of some faces that `distance` finds farthest. Needs a row.
template <class Distance>
[[nodiscard]] dvec3 farthest_corner(const face_table& faces, std::span<const std::uint32_t> rows,
                                    const Distance& distance) noexcept {
    dvec3 best = faces.corner[0].get(rows[0]);
    double largest = -1;
    for (const std::uint32_t row : rows) {
        for (const columns3& corner : faces.corner) {
            const dvec3 p = corner.get(row);
            if (const double d = distance(p); d > largest) largest = d, best = p;
        }
    }
    return best;
}

/// Three corners of some faces that are far apart. Needs a row.
[[nodiscard]] inline std::array<dvec3, 3> wide_triangle(
    const face_table& faces, std::span<const std::uint32_t> rows) noexcept {
    const auto squared = [](const dvec3& v) { return glm::dot(v, v); };
    const dvec3 start = faces.corner[0].get(rows[0]);
    const dvec3 a = farthest_corner(faces, rows, [&](auto& p) { return squared(p - start); });
    const dvec3 b = farthest_corner(faces, rows, [&](auto& p) { return squared(p - a); });
    const dvec3 c =
        farthest_corner(faces, rows, [&](auto& p) { return squared(glm::cross(p - a, b - a)); });
    return {a, b, c};
}

/// What the width of some faces and a triangle is at least: that of a tetrahedron among them. Needs
/// a row.
[[nodiscard]] inline double least_width(const face_table& faces,
                                        std::span<const std::uint32_t> rows,
                                        const std::array<dvec3, 3>& triangle) noexcept {
    const auto& [a, b, c] = triangle;
    const dvec3 across = glm::cross(b - a, c - a);
    const double offset = glm::dot(a, across);
    const dvec3 d = farthest_corner(
        faces, rows, [&](auto& p) { return std::abs(glm::dot(p, across) - offset); });
    return tetrahedron_width({a, b, c, d});
}

/// Where a joint plane of the faces of two planes may lie: along either, between them, or around the
/// axis from the faces of one to those of the other.
[[nodiscard]] inline std::vector<dvec3> joint_normals(const dvec3& first, dvec3 second,
                                                      const dvec3& axis) {
    if (glm::dot(first, second) < 0) second = -second;
    std::vector<dvec3> normals{first, second, glm::normalize(first + second)};
    if (const double length = glm::length(axis); length > 0) {
        const frame around = frame_around(axis / length);
        for (int k = 0; k < 4; ++k) {
            const double angle = k * std::numbers::pi / 4;
            normals.push_back(around.u * std::cos(angle) + around.v * std::sin(angle));
        }
    }
    return normals;
}

}  // namespace detail

/// Looks for a plane within epsilon of all `rows`: their minimax plane (fit/minimax.hpp).
///
/// The search works on a few extreme faces, `core`; whatever face its plane leaves out joins them.
///
/// Needs   `core` of `rows`, both ascending, not empty; at least one of `normals`, where the search
///         starts from the narrowest.
/// Gives   a plane that was checked against all rows, in double, or nothing, which is no proof that
///         there is none.
/// Cost    O(rows) for every round, of which there are few; about 200 passes over the core.
[[nodiscard]] inline std::optional<plane> joint_plane(const face_table& faces,
                                                      std::span<const std::uint32_t> rows,
                                                      face_rows core,
                                                      std::span<const dvec3> normals,
                                                      double epsilon) {
    static constexpr int max_rounds = 12;
    BILLOW_ASSERT(!core.empty() && !normals.empty());
    // As exact as epsilon asks for, however small it is.
    const double finest = std::min(minimax_fit{}.last_step, 0.02 * epsilon / faces.bounds.radius);
    minimax_fit fit{.first_step = 12 * std::numbers::pi / 180, .last_step = finest};
    const auto extent = [&](const dvec3& normal) { return extent_along(faces, core, normal); };
    dvec3 normal =
        *std::ranges::min_element(normals, {}, [&](const dvec3& n) { return extent(n).width(); });
    for (int round = 0; round < max_rounds; ++round) {
        const face_table few = select_rows(faces, core, parallel{1});
        normal = fit(few, {normal, 0}).normal;
        if (extent(normal).width() > 2 * epsilon) break;
        const face_extent_along all = extent_along(faces, rows, normal);
        if (all.width() <= 2 * epsilon) return plane{normal, (all.low + all.high) / 2};
        core.push_back(all.low_row), core.push_back(all.high_row);
        fit.first_step = std::numbers::pi / 180;
    }
    return {};
}

}  // namespace billow::inline BILLOW_ABI
