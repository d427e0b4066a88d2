// What a view of a scene shows: light and coverage of each pixel, in floats.
#pragma once

#include <cstddef>
#include <vector>

#include <billow/core/config.hpp>
#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// A picture with coverage. Rows from the upper edge down.
///
/// Unit  rgb: linear light, multiplied by the coverage; a: the share of the pixel that is covered,
///       0 to 1, counted in samples, so that what is thinner than a pixel counts by its area.
struct view_picture {
    int width = 0;
    int height = 0;
    std::vector<vec4> pixels{};

    [[nodiscard]] vec4& at(int x, int y) noexcept { return pixels[index_of(x, y)]; }
    [[nodiscard]] const vec4& at(int x, int y) const noexcept { return pixels[index_of(x, y)]; }

    [[nodiscard]] bool operator==(const view_picture&) const = default;

private:
    [[nodiscard]] std::size_t index_of(int x, int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
};

}  // namespace billow::inline BILLOW_ABI
