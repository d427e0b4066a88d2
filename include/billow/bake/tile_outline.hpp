// What of a tile is worth drawing: the box of its opaque texels, and a polygon around them.
#pragma once

#include <algorithm>
#include <vector>

#include <billow/bake/tile_picture.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/outline.hpp>
#include <billow/geometry/rectangle.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Columns [begin, end) of a row that an alpha test under a bilinear filter may draw: opaque texels,
/// and others with alpha beside one.
struct drawn_span {
    int begin = 0;
    int end = 0;
};

[[nodiscard]] inline bool may_be_drawn(const tile_picture& tile, int x, int y) noexcept {
    const std::uint8_t own = tile.alpha(tile.index(x, y));
    if (own >= 128 || own == 0) return own != 0;
    for (int j = std::max(0, y - 1); j <= std::min(tile.height - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(tile.width - 1, x + 1); ++i) {
            if (tile.alpha(tile.index(i, j)) >= 128) return true;
        }
    }
    return false;
}

[[nodiscard]] inline drawn_span drawn_span_of(const tile_picture& tile, int y) noexcept {
    drawn_span span{0, tile.width};
    while (span.begin < span.end && !may_be_drawn(tile, span.begin, y)) ++span.begin;
    while (span.begin < span.end && !may_be_drawn(tile, span.end - 1, y)) --span.end;
    return span;
}

}  // namespace detail

/// The texels of a tile that may be drawn; empty where none is opaque.
[[nodiscard]] inline texel_box drawn_box(const tile_picture& tile) noexcept {
    int left = tile.width;
    int right = 0;
    int top = tile.height;
    int bottom = 0;
    for (int y = 0; y < tile.height; ++y) {
        const detail::drawn_span span = detail::drawn_span_of(tile, y);
        if (span.begin >= span.end) continue;
        left = std::min(left, span.begin);
        right = std::max(right, span.end);
        top = std::min(top, y);
        bottom = y + 1;
    }
    if (left >= right) return {};
    return {left, top, right - left, bottom - top};
}

/// The smallest box around both; one that is empty does not count.
[[nodiscard]] inline texel_box joined(const texel_box& a, const texel_box& b) noexcept {
    if (a.width == 0) return b;
    if (b.width == 0) return a;
    const int x = std::min(a.x, b.x);
    const int y = std::min(a.y, b.y);
    return {x, y, std::max(a.x + a.width, b.x + b.width) - x,
            std::max(a.y + a.height, b.y + b.height) - y};
}

/// A box in a tile as it lies in the tile of the other side.
[[nodiscard]] inline texel_box mirrored(const texel_box& box, int tile_width) noexcept {
    return {tile_width - box.x - box.width, box.y, box.width, box.height};
}

/// The corners of the texels of tile.box that may be drawn, in texels from its lower left corner, as
/// far as they can lie on a convex hull. `is_back`: seen from the other side.
inline void add_drawn_corners(const tile_picture& tile, bool is_back, std::vector<dvec2>& to) {
    const texel_box& box = tile.box;
    for (int y = box.y; y < box.y + box.height; ++y) {
        const detail::drawn_span span = detail::drawn_span_of(tile, y);
        for (int x : {span.begin, span.end}) {
            if (span.begin >= span.end) break;
            x = std::clamp(x - box.x, 0, box.width);
            const double s = is_back ? box.width - x : x;
            to.emplace_back(s, box.height - (y - box.y));
            to.emplace_back(s, box.height - (y - box.y) - 1);
        }
    }
}

/// A convex polygon of at most `most_corners` corners around the corners of texels, in the box from 0
/// to 1 that `size` texels fill; see outline_polygon.
[[nodiscard]] inline std::vector<dvec2> outline_around(std::vector<dvec2> corners,
                                                       const ivec2& size, int most_corners) {
    std::vector<dvec2> hull(corners.size() + 1);
    hull.resize(convex_hull(corners, hull));
    std::vector<dvec2> outline = outline_polygon(hull, dvec2(0), dvec2(size), most_corners);
    for (dvec2& corner : outline) corner /= dvec2(size);
    return outline;
}

}  // namespace billow::inline BILLOW_ABI
