// How much of a picture an alpha test draws, and the factor on alpha that keeps it so.
//
// Castaño, "Computing alpha mipmaps", 2010, who counts samples of a whole texture. Here the area is
// that under bilinear filtering, as a graphics card draws it: a count of texels jumps, for on the
// first levels alpha has but a few values.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Columns [x, x + width) and rows [y, y + height) of an alpha channel. Outside of them the nearest
/// texel of the block is read, as by a texture that is clamped.
struct alpha_block {
    std::span<const float> alpha{};  ///< 0 to 1, rows from top to bottom
    int stride = 0;                  ///< texels a row
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    [[nodiscard]] float at(int column, int row) const noexcept {
        const auto i = static_cast<std::size_t>(std::clamp(column, x, x + width - 1));
        const auto j = static_cast<std::size_t>(std::clamp(row, y, y + height - 1));
        return alpha[j * static_cast<std::size_t>(stride) + i];
    }
};

/// The area between `low` and `high` where alpha · scale, at most 1, is at least `cutoff` once it is
/// filtered bilinearly.
///
/// Unit   texels and texels squared; the texel of column 0 reaches from 0 to 1.
/// Needs  a block that is not empty; cutoff in (0, 1].
/// Cost   O(texels). Exact along x, four lines a texel along y.
[[nodiscard]] inline double drawn_area(const alpha_block& block, const dvec2& low,
                                       const dvec2& high, float scale, float cutoff) noexcept {
    constexpr int lines = 4;
    const auto first = [](double at) { return static_cast<int>(std::floor(at - 0.5)); };
    const auto last = [](double at) { return static_cast<int>(std::ceil(at - 0.5)) - 1; };
    const auto at = [&](int i, int j) { return std::min(1.0f, scale * block.at(i, j)); };
    double area = 0;
    // A cell lies between the middles of four texels.
    for (int j = first(low.y); j <= last(high.y); ++j) {
        const double top = std::max(0.0, low.y - (j + 0.5));
        const double height = std::min(1.0, high.y - (j + 0.5)) - top;
        float a = at(first(low.x), j);
        float b = at(first(low.x), j + 1);
        for (int i = first(low.x); i <= last(high.x); ++i) {
            const float c = at(i + 1, j);
            const float d = at(i + 1, j + 1);
            const double left = std::max(0.0, low.x - (i + 0.5));
            const double width = std::min(1.0, high.x - (i + 0.5)) - left;
            double share = 0;
            if (std::min({a, b, c, d}) >= cutoff) {
                share = 1;
            } else if (std::max({a, b, c, d}) >= cutoff) {
                for (int k = 0; k < lines; ++k) {
                    const double t = top + (k + 0.5) / lines * height;
                    const double from = a + (b - a) * t;
                    const double slope = c + (d - c) * t - from;
                    const double p = from + slope * left;
                    const double q = from + slope * (left + width);
                    if (std::min(p, q) >= static_cast<double>(cutoff)) {
                        share += 1.0 / lines;
                    } else if (std::max(p, q) > static_cast<double>(cutoff)) {
                        share += (std::max(p, q) - cutoff) / (std::abs(p - q) * lines);
                    }
                }
            }
            area += share * width * height;
            a = c;
            b = d;
        }
    }
    return area;
}

/// The factor on alpha with which drawn_area is nearest to `wanted`, found by bisection; 1 where
/// that is within a thousandth.
///
/// Cost   about 20 times drawn_area.
[[nodiscard]] inline float alpha_scale(const alpha_block& block, const dvec2& low,
                                       const dvec2& high, double wanted, float cutoff) noexcept {
    const auto excess = [&](float scale) {
        return drawn_area(block, low, high, scale, cutoff) - wanted;
    };
    const double plain = excess(1);
    if (std::abs(plain) <= 1e-3 * wanted) return 1;
    // Below `cutoff` nothing is drawn, above 255 all that a byte can hold.
    float less = plain < 0 ? 1.0f : cutoff;
    float more = plain < 0 ? 255.0f : 1.0f;
    for (int i = 0; i < 18; ++i) {
        const float middle = std::sqrt(less * more);
        (excess(middle) < 0 ? less : more) = middle;
    }
    return -excess(less) <= excess(more) ? less : more;
}

}  // namespace billow::inline BILLOW_ABI
