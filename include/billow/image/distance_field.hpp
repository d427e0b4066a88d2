// Signed distance fields: alpha whose half value runs along an outline, however it is magnified.
//
// Green, "Improved alpha-tested magnification for vector textures and special effects", 2007.
// Differs: the outline is not taken from a larger binary picture but from the covered shares of the
// texels themselves, as the curve on which their bilinear mean crosses a threshold.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Distance of a point to a segment.
[[nodiscard]] inline double distance_to_segment(const dvec2& p, const dvec2& a,
                                                const dvec2& b) noexcept {
    const dvec2 along = b - a;
    const double length = glm::dot(along, along);
    const double share = length > 0 ? std::clamp(glm::dot(p - a, along) / length, 0.0, 1.0) : 0;
    return glm::distance(p, a + along * share);
}

/// Where the bilinear mean of four values crosses `level`: up to two segments in the unit square
/// whose corners (0,0), (1,0), (1,1), (0,1) hold `value`. Of the two ways to join four crossings the
/// one that the value in the middle asks for.
struct level_segments {
    std::array<std::array<dvec2, 2>, 2> segment{};
    std::size_t count = 0;

    level_segments(const std::array<double, 4>& value, double level) noexcept {
        static constexpr std::array<std::array<double, 2>, 4> at{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
        std::array<dvec2, 4> crossing;
        int crossings = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t j = (i + 1) % 4;
            if ((value[i] >= level) == (value[j] >= level)) continue;
            const double share = (level - value[i]) / (value[j] - value[i]);
            const dvec2 a{at[i][0], at[i][1]};
            const dvec2 b{at[j][0], at[j][1]};
            crossing[static_cast<std::size_t>(crossings++)] = a + (b - a) * share;
        }
        if (crossings == 2) {
            segment[count++] = {crossing[0], crossing[1]};
        } else if (crossings == 4) {
            const bool is_inside = (value[0] + value[1] + value[2] + value[3]) / 4 >= level;
            const std::size_t first = is_inside == (value[0] >= level) ? 0 : 1;
            // Around the corners that the middle does not belong to.
            segment[count++] = {crossing[first], crossing[first + 1]};
            segment[count++] = {crossing[first + 2], crossing[(first + 3) % 4]};
        }
    }
};

}  // namespace detail

/// Distance of each texel's centre to the outline of what is covered, in texels, positive inside, at
/// most `spread` either way. Beyond the grid nothing is covered.
///
/// Shape  `covered` and the result: width · height, rows from the top; shares in [0, 1].
/// Needs  0 < level < 1, spread > 0.
/// Cost   O(texels + outline · spread²).
[[nodiscard]] inline std::vector<float> signed_distances(std::span<const float> covered, int width,
                                                         int height, double level, double spread) {
    BILLOW_ASSERT(covered.size() ==
                  static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const auto index = [width](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    };
    const auto value = [&](int x, int y) {
        const bool is_in = x >= 0 && y >= 0 && x < width && y < height;
        return is_in ? static_cast<double>(covered[index(x, y)]) : 0.0;
    };
    std::vector<float> distance(covered.size(), static_cast<float>(spread));
    const int reach = static_cast<int>(std::ceil(spread));
    for (int y = -1; y < height; ++y) {
        for (int x = -1; x < width; ++x) {
            const std::array<double, 4> corner{value(x, y), value(x + 1, y), value(x + 1, y + 1),
                                               value(x, y + 1)};
            const detail::level_segments outline(corner, level);
            for (std::size_t s = 0; s < outline.count; ++s) {
                const dvec2 origin(x, y);
                const dvec2 a = origin + outline.segment[s][0];
                const dvec2 b = origin + outline.segment[s][1];
                for (int j = std::max(0, y - reach); j < std::min(height, y + 2 + reach); ++j) {
                    for (int i = std::max(0, x - reach); i < std::min(width, x + 2 + reach); ++i) {
                        float& least = distance[index(i, j)];
                        least = std::min(least, static_cast<float>(detail::distance_to_segment(
                                                    dvec2(i, j), a, b)));
                    }
                }
            }
        }
    }
    for (std::size_t i = 0; i < distance.size(); ++i) {
        if (static_cast<double>(covered[i]) < level) distance[i] = -distance[i];
    }
    return distance;
}

/// A signed distance as a byte: 0 at -spread, 255 at spread, and the threshold of a half between.
[[nodiscard]] inline std::uint8_t byte_from_distance(float distance, double spread) noexcept {
    const double share = 0.5 + 0.5 * static_cast<double>(distance) / spread;
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

}  // namespace billow::inline BILLOW_ABI
