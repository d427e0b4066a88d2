// Whether the two sides of a billboard look different enough for a tile each.
#pragma once

#include <algorithm>
#include <cmath>

#include <billow/bake/tile_picture.hpp>
#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// How far apart the colours of two sides are: the mean, over squares of 8 × 8 texels and weighted by
/// the samples that both show, of the distance of the squares' mean sRGB colours; the squares'
/// means, so that leaves of one colour in other places do not count as a difference. A square that
/// only one side covers differs wholly.
///
/// Shape  tiles of the same size in texels, the back's columns running the other way.
/// Unit   0: equal, 1: black and white.
[[nodiscard]] inline double side_difference(const tile_picture& front, const tile_picture& back) {
    BILLOW_ASSERT(front.width == back.width && front.height == back.height);
    constexpr int square = 8;
    double sum = 0;
    double weight = 0;
    for (int top = 0; top < front.height; top += square) {
        for (int left = 0; left < front.width; left += square) {
            dvec3 color[2]{dvec3(0), dvec3(0)};
            double covered[2]{0, 0};
            const auto add = [&](int side, const tile_picture& from, int x, int y) {
                const std::size_t at = from.index(x, y);
                const auto share = static_cast<double>(from.share(at));
                const std::uint8_t* p = &from.channels.base_color.bytes[4 * at];
                color[side] += dvec3(p[0], p[1], p[2]) * (share / 255);
                covered[side] += share;
            };
            for (int y = top; y < std::min(top + square, front.height); ++y) {
                for (int x = left; x < std::min(left + square, front.width); ++x) {
                    add(0, front, x, y);
                    add(1, back, back.width - 1 - x, y);
                }
            }
            const double most = std::max(covered[0], covered[1]);
            if (most == 0) continue;
            const bool is_on_both = std::min(covered[0], covered[1]) > 0;
            const double apart =
                is_on_both
                    ? glm::distance(color[0] / covered[0], color[1] / covered[1]) / std::sqrt(3.0)
                    : 1;
            const double shown = is_on_both ? std::min(covered[0], covered[1]) : most;
            sum += apart * shown;
            weight += shown;
        }
    }
    return weight > 0 ? sum / weight : 0;
}

}  // namespace billow::inline BILLOW_ABI
