// Directions to look at a model from, evenly spread.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// `count` unit directions on a spiral from +Y to -Y, each for the same share of the sphere: the i-th
/// is the middle of the i-th of `count` zones of equal area, turned by i golden angles.
///
/// Source  Vogel, "A better way to construct the sunflower head", Mathematical Biosciences 44, 1979,
///         on the sphere.
[[nodiscard]] inline std::vector<dvec3> spread_directions(int count = 42) {
    constexpr double golden_angle = std::numbers::pi * (3 - 2.2360679774997896964);  // (3 - √5) π
    std::vector<dvec3> directions;
    directions.reserve(static_cast<std::size_t>(count > 0 ? count : 0));
    for (int i = 0; i < count; ++i) {
        const double y = 1 - (2.0 * i + 1) / count;
        const double across = std::sqrt(1 - y * y);
        const double turn = golden_angle * i;
        directions.emplace_back(across * std::cos(turn), y, across * std::sin(turn));
    }
    return directions;
}

}  // namespace billow::inline BILLOW_ABI
