// Polygons as files hold them, planar or not, convex or not, into triangles.
#pragma once

#include <array>
#include <numeric>
#include <span>
#include <vector>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI::detail {

/// Twice the vector area of a polygon: its normal, however bent it is (Newell's method).
[[nodiscard]] inline dvec3 area_vector(std::span<const dvec3> corners) {
    dvec3 sum(0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        // Relative to the first corner, so that distance from the origin costs no digits.
        sum += glm::cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
    }
    return sum;
}

/// Triangles of a simple polygon, always two fewer than it has corners, all turning as it does.
///
/// Shape   ids into `corners`, of which there are at least 3.
/// Cost    O(n) for a convex polygon, at worst O(n³).
/// Source  Ear clipping: Meisters, "Polygons have ears", 1975.
[[nodiscard]] inline std::vector<std::array<std::size_t, 3>> triangulate_polygon(
    std::span<const dvec3> corners) {
    std::vector<std::array<std::size_t, 3>> triangles;
    std::vector<std::size_t> rest(corners.size());
    std::iota(rest.begin(), rest.end(), std::size_t{0});
    const dvec3 normal = area_vector(corners);
    // Positive when a, b, c turn as the polygon does.
    const auto turn = [&](std::size_t a, std::size_t b, std::size_t c) {
        return glm::dot(glm::cross(corners[b] - corners[a], corners[c] - corners[a]), normal);
    };
    const auto is_ear = [&](std::size_t a, std::size_t b, std::size_t c) {
        if (!(turn(a, b, c) > 0)) return false;
        for (const std::size_t p : rest) {
            if (p == a || p == b || p == c) continue;
            if (corners[p] == corners[a] || corners[p] == corners[b] || corners[p] == corners[c]) {
                continue;  // a bridge to a hole visits its ends twice
            }
            if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
        }
        return true;
    };
    std::size_t at = 0;  // the ear's first corner; going on from the last ear avoids thin fans
    while (rest.size() > 3) {
        const std::size_t count = rest.size();
        std::size_t tried = 0;
        while (tried < count &&
               !is_ear(rest[at % count], rest[(at + 1) % count], rest[(at + 2) % count])) {
            ++at;
            ++tried;
        }
        at %= count;
        const std::size_t tip =
            (at + 1) % count;  // no ear at all: a degenerate polygon, cut anyway
        triangles.push_back({rest[at], rest[tip], rest[(at + 2) % count]});
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(tip));
        at = tip < at ? at - 1 : at + 1;
    }
    triangles.push_back({rest[0], rest[1], rest[2]});
    return triangles;
}

}  // namespace billow::inline BILLOW_ABI::detail
