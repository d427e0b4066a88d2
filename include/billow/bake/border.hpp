// Colours for what is empty, so that filtering and mip maps draw no halo.
//
// Luksch 2009, section 4.5; here the whole empty area is filled, each texel from the one that is
// exactly nearest of those where a face is seen, opaque or not.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/core/jobs.hpp>
#include <billow/core/types.hpp>
#include <billow/image/nearest.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

struct pixel_rectangle {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
};

/// The tile with its padding, as far as the atlas goes.
[[nodiscard]] inline pixel_rectangle padded(const tile& t, const atlas& in, int padding) noexcept {
    const int x = std::max(0, t.x - padding);
    const int y = std::max(0, t.y - padding);
    return {x, y, std::min(in.width(), t.x + t.width + padding) - x,
            std::min(in.height(), t.y + t.height + padding) - y};
}

/// All channels of a pixel but the alpha of its colour.
inline void copy_texel(atlas& in, const ivec2& from, const ivec2& to) noexcept {
    for (image* channel :
         {&in.base_color, &in.normal, &in.occlusion_roughness_metallic, &in.emissive}) {
        if (channel->empty()) continue;
        const std::uint8_t* source = channel->pixel(from.x, from.y);
        std::copy(source, source + 3, channel->pixel(to.x, to.y));
    }
    if (in.horizon.empty()) return;
    std::copy_n(in.horizon.pixel(from.x, from.y), 4, in.horizon.pixel(to.x, to.y));
}

struct border_scratch {
    std::vector<std::int32_t> nearest{};
    nearest_scratch rows{};
};

inline void fill_tile_border(atlas& in, const std::vector<char>& is_covered,
                             const pixel_rectangle& area, border_scratch& scratch) {
    const std::span nearest =
        std::span(scratch.nearest)
            .first(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height));
    const auto is_seed = [&](int x, int y) {
        return is_covered[static_cast<std::size_t>(area.y + y) *
                              static_cast<std::size_t>(in.width()) +
                          static_cast<std::size_t>(area.x + x)] != 0;
    };
    nearest_pixels(area.width, area.height, is_seed, nearest, scratch.rows);
    for (int y = 0; y < area.height; ++y) {
        for (int x = 0; x < area.width; ++x) {
            const std::int32_t from = nearest[static_cast<std::size_t>(y * area.width + x)];
            if (from == no_pixel || from == y * area.width + x) continue;
            copy_texel(in, {area.x + from % area.width, area.y + from / area.width},
                       {area.x + x, area.y + y});
        }
    }
}

inline void fill_between_tiles(atlas& in, const std::vector<char>& is_filled, parallel threads) {
    const int width = in.width();
    std::vector<std::int32_t> nearest(is_filled.size());
    nearest_scratch scratch;
    const auto is_seed = [&](int x, int y) {
        return is_filled[static_cast<std::size_t>(y * width + x)] != 0;
    };
    nearest_pixels(width, in.height(), is_seed, nearest, scratch, threads);
    const auto rows = static_cast<std::size_t>(in.height());
    threads.for_chunks(rows, 64, [&](std::size_t begin, std::size_t end) {
        for (auto i = begin * static_cast<std::size_t>(width);
             i < end * static_cast<std::size_t>(width); ++i) {
            const std::int32_t from = nearest[i];
            const auto to = static_cast<std::int32_t>(i);
            if (from == no_pixel || from == to) continue;
            copy_texel(in, {from % width, from / width}, {to % width, to / width});
        }
    });
}

}  // namespace detail

/// Gives every empty texel all channels of the nearest covered texel: within a tile and its padding
/// the nearest of that tile, elsewhere the nearest texel of any of these. Alpha stays.
///
/// Shape  `is_covered`: for each atlas a mark a texel, see placed_tiles.
/// Needs  tiles whose paddings do not overlap.
/// Cost   O(texels), parallel over tiles, then over rows.
inline void fill_borders(baked_cloud& baked, const std::vector<std::vector<char>>& is_covered,
                         int padding, parallel threads = {}) {
    BILLOW_ASSERT(is_covered.size() == baked.atlases.size());
    std::size_t largest = 0;
    std::size_t widest_rows = 0;
    for (const tile& t : baked.tiles) {
        const auto area = detail::padded(t, baked.atlases[t.atlas], padding);
        const auto w = static_cast<std::size_t>(area.width);
        const auto h = static_cast<std::size_t>(area.height);
        largest = std::max(largest, w * h);
        widest_rows = std::max(widest_rows, nearest_scratch_size(area.width, area.height));
    }
    std::vector<detail::border_scratch> scratches(threads.count());
    for (auto& scratch : scratches) {
        scratch.nearest.resize(largest);
        scratch.rows.envelopes.resize(widest_rows);
    }
    for_jobs(threads, baked.tiles.size(), scratches, [&](std::size_t job, auto& scratch) {
        const tile& t = baked.tiles[job];
        atlas& in = baked.atlases[t.atlas];
        detail::fill_tile_border(in, is_covered[t.atlas], detail::padded(t, in, padding), scratch);
    });
    for (atlas_id id = 0; id < baked.atlases.size(); ++id) {
        atlas& in = baked.atlases[id];
        const auto width = static_cast<std::size_t>(in.width());
        std::vector<char> is_filled(width * static_cast<std::size_t>(in.height()), 0);
        for (const tile& t : baked.tiles) {
            if (t.atlas != id) continue;
            const auto area = detail::padded(t, in, padding);
            for (int y = area.y; y < area.y + area.height; ++y) {
                std::fill_n(
                    is_filled.begin() + static_cast<std::ptrdiff_t>(y) * in.width() + area.x,
                    area.width, char{1});
            }
        }
        detail::fill_between_tiles(in, is_filled, threads);
    }
}

}  // namespace billow::inline BILLOW_ABI
