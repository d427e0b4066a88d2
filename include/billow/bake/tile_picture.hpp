// The texels of one billboard, before it is known where in an atlas they go.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/core/types.hpp>
#include <billow/image/image.hpp>

namespace billow::inline BILLOW_ABI {

/// Which texels of a tile are used: columns [x, x + width), rows [y, y + height).
struct texel_box {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    friend bool operator==(const texel_box&, const texel_box&) = default;
};

/// An upright tile: the billboard's u axis to the right, v up, rows from the top.
///
/// Shape  `covered` and `cut_out` have one row a texel, as every channel that is there.
struct tile_picture {
    int width = 0;
    int height = 0;
    int supersample = 1;  ///< samples a texel side
    atlas channels{};  ///< a texel without covered samples holds nothing yet; alpha: see tile_alpha
    std::vector<std::uint8_t> covered{};  ///< samples that show a face
    std::vector<std::uint8_t> cut_out{};  ///< those of them whose material has holes: leaves
    double surface_area = 0;  ///< of what is seen, in texels: tilted faces count by their own area,
                              ///< up to four times what they cover
    texel_box box{};          ///< what is kept of it

    [[nodiscard]] std::size_t texel_count() const noexcept {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    [[nodiscard]] std::size_t index(int x, int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
    [[nodiscard]] float share(std::size_t texel) const noexcept {
        return static_cast<float>(covered[texel]) / static_cast<float>(supersample * supersample);
    }
    [[nodiscard]] std::uint8_t& alpha(std::size_t texel) noexcept {
        return channels.base_color.bytes[4 * texel + 3];
    }
    [[nodiscard]] std::uint8_t alpha(std::size_t texel) const noexcept {
        return channels.base_color.bytes[4 * texel + 3];
    }
    /// The area of the faces as it is seen along the billboard's normal, in texels.
    [[nodiscard]] double covered_area() const noexcept {
        std::size_t samples = 0;
        for (const std::uint8_t count : covered) samples += count;
        return static_cast<double>(samples) / (supersample * supersample);
    }
};

/// An empty tile; with the channels that a bake fills.
[[nodiscard]] inline tile_picture empty_tile(const ivec2& size, int supersample, bool has_horizon) {
    tile_picture tile;
    tile.width = size.x;
    tile.height = size.y;
    tile.supersample = supersample;
    tile.channels = {image::filled(size.x, size.y, 4, 0), image::filled(size.x, size.y, 3, 0),
                     image::filled(size.x, size.y, 3, 0), image::filled(size.x, size.y, 3, 0)};
    if (has_horizon) tile.channels.horizon = image::filled(size.x, size.y, 4, 0);
    tile.covered.assign(tile.texel_count(), 0);
    tile.cut_out.assign(tile.texel_count(), 0);
    tile.box = {0, 0, size.x, size.y};
    return tile;
}

}  // namespace billow::inline BILLOW_ABI
