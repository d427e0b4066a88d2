// Small pictures that tests of metrics compare.
#pragma once

#include <cstdint>

#include <billow/core/random.hpp>
#include <billow/metrics/view_picture.hpp>

namespace support {

inline billow::view_picture empty_picture(int width, int height) {
    return {width, height,
            std::vector<billow::vec4>(static_cast<std::size_t>(width) *
                                      static_cast<std::size_t>(height))};
}

/// Fills columns [x, x + width) of rows [y, y + height) with one colour, wholly covered.
inline void fill(billow::view_picture& picture, int x, int y, int width, int height,
                 const billow::vec4& value) {
    for (int j = y; j < y + height; ++j) {
        for (int i = x; i < x + width; ++i) picture.at(i, j) = value;
    }
}

/// A picture of 32 x 32 with a square of 20 x 20 whose corner is at (x, y).
inline billow::view_picture square_at(int x, int y,
                                      const billow::vec4& value = {0.2f, 0.5f, 0.1f, 1}) {
    billow::view_picture picture = empty_picture(32, 32);
    fill(picture, x, y, 20, 20, value);
    return picture;
}

/// Random colours and coverages; a third of the pixels is empty and a third is covered wholly.
inline billow::view_picture random_picture(int width, int height, std::uint64_t seed) {
    billow::random_stream random(seed);
    const auto unit = [&random] { return static_cast<float>(random.unit()); };
    billow::view_picture picture = empty_picture(width, height);
    for (billow::vec4& p : picture.pixels) {
        const double kind = random.unit() * 3;
        const float coverage = kind < 1 ? 0.0f : kind < 2 ? 1.0f : unit();
        const billow::vec3 color(unit(), unit(), unit());
        p = billow::vec4(color * coverage, coverage);
    }
    return picture;
}

}  // namespace support
