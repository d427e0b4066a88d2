// Tiles into atlases: where each goes, and its texels there.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/pack.hpp>
#include <billow/bake/tile_picture.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/image/image.hpp>

namespace billow::inline BILLOW_ABI {

/// Where the texel in column x and row y of an upright tile lies in the atlas.
[[nodiscard]] inline ivec2 texel_position(const tile& t, int x, int y) noexcept {
    // A quarter turn clockwise takes the row from the top to the column from the right.
    return t.is_rotated ? ivec2(t.x + t.width - 1 - y, t.y + x) : ivec2(t.x + x, t.y + y);
}

namespace detail {

/// Copies tile.box of one channel.
inline void place_channel(const tile_picture& tile, const image& from, const struct tile& place,
                          image& to) {
    if (to.empty()) return;
    const texel_box& box = tile.box;
    for (int y = 0; y < box.height; ++y) {
        for (int x = 0; x < box.width; ++x) {
            const ivec2 at = texel_position(place, x, y);
            std::copy_n(from.pixel(box.x + x, box.y + y), from.channels, to.pixel(at.x, at.y));
        }
    }
}

/// Turns tangent space normals with their tile: x becomes -y, and y becomes x.
inline void turn_normals(const struct tile& place, image& normals) {
    for (int y = place.y; y < place.y + place.height; ++y) {
        for (int x = place.x; x < place.x + place.width; ++x) {
            std::uint8_t* n = normals.pixel(x, y);
            n[1] = static_cast<std::uint8_t>(255 - std::exchange(n[0], n[1]));
        }
    }
}

}  // namespace detail

/// Packs the boxes of tiles into atlases and copies what they hold; a mark for each texel of an atlas
/// whether a tile has covered samples there.
struct placed_tiles {
    std::vector<tile> tiles{};
    std::vector<atlas> atlases{};
    std::vector<std::vector<char>> is_covered{};  ///< one list an atlas
    double fill = 0;                              ///< see baked_cloud::fill
};

/// Needs  tiles whose boxes are not empty and fit, see largest_side; all with the same channels.
/// Cost   of the packer, and O(texels), parallel over tiles.
[[nodiscard]] inline placed_tiles place_tiles(std::span<const tile_picture> tiles,
                                              const pack_options& options, normal_style normals,
                                              parallel threads = {}) {
    std::vector<ivec2> sizes;
    sizes.reserve(tiles.size());
    for (const tile_picture& t : tiles) sizes.emplace_back(t.box.width, t.box.height);
    const packing places = pack_rectangles(sizes, options);
    placed_tiles result;
    const bool has_horizon = !tiles.empty() && !tiles.front().channels.horizon.empty();
    double atlas_area = 0;
    for (const ivec2& size : places.atlas_sizes) {
        result.atlases.push_back(
            {image::filled(size.x, size.y, 4, 0), image::filled(size.x, size.y, 3, 0),
             image::filled(size.x, size.y, 3, 0), image::filled(size.x, size.y, 3, 0)});
        if (has_horizon) result.atlases.back().horizon = image::filled(size.x, size.y, 4, 0);
        const auto texels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
        result.is_covered.emplace_back(texels, char{0});
        atlas_area += static_cast<double>(texels);
    }
    double tile_area = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const packed_rectangle& r = places.rectangles[i];
        const ivec2 size = r.is_rotated ? ivec2(sizes[i].y, sizes[i].x) : sizes[i];
        result.tiles.push_back({r.atlas, r.x, r.y, size.x, size.y, r.is_rotated});
        tile_area += static_cast<double>(size.x) * size.y;
    }
    result.fill = atlas_area > 0 ? tile_area / atlas_area : 0;
    threads.for_chunks(tiles.size(), 1, [&](std::size_t i, std::size_t) {
        const tile& place = result.tiles[i];
        atlas& to = result.atlases[place.atlas];
        const atlas& from = tiles[i].channels;
        detail::place_channel(tiles[i], from.base_color, place, to.base_color);
        detail::place_channel(tiles[i], from.normal, place, to.normal);
        detail::place_channel(tiles[i], from.occlusion_roughness_metallic, place,
                              to.occlusion_roughness_metallic);
        detail::place_channel(tiles[i], from.emissive, place, to.emissive);
        detail::place_channel(tiles[i], from.horizon, place, to.horizon);
        if (place.is_rotated &&
            (normals == normal_style::folded || normals == normal_style::sheets)) {
            detail::turn_normals(place, to.normal);
        }
        const texel_box& box = tiles[i].box;
        std::vector<char>& marks = result.is_covered[place.atlas];
        for (int y = 0; y < box.height; ++y) {
            for (int x = 0; x < box.width; ++x) {
                if (tiles[i].covered[tiles[i].index(box.x + x, box.y + y)] == 0) continue;
                const ivec2 at = texel_position(place, x, y);
                marks[static_cast<std::size_t>(at.y) * static_cast<std::size_t>(to.width()) +
                      static_cast<std::size_t>(at.x)] = 1;
            }
        }
    });
    return result;
}

}  // namespace billow::inline BILLOW_ABI
