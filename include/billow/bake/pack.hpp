// Rectangles in, places in as few and as small atlases as can be found, out.
//
// docs/atlas.md has what was tried and measured.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <billow/bake/pack_search.hpp>
#include <billow/bake/pack_skyline.hpp>
#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

struct pack_options {
    int max_size = 4096;        ///< longest side of an atlas, pixels
    int padding = 8;            ///< pixels kept free on each side of every rectangle
    int alignment = 4;          ///< padded rectangles and atlases start and end at multiples of it
    bool power_of_two = false;  ///< sides of atlases are powers of two; costs area
    bool allows_rotation = true;  ///< rectangles may be turned by 90°
};

/// Where a rectangle went: its first pixel, padding not counted.
struct packed_rectangle {
    atlas_id atlas = no_id;
    int x = 0;
    int y = 0;
    bool is_rotated = false;
};

struct packing {
    std::vector<packed_rectangle> rectangles{};  ///< in the order of the input
    std::vector<ivec2> atlas_sizes{};
    double fill = 0;         ///< area of the rectangles / area of the atlases
    double padded_fill = 0;  ///< the same with padding, up to multiples of the alignment
};

namespace detail {

/// The longest side of an atlas, in units of the alignment.
[[nodiscard]] inline int side_limit(const pack_options& options) noexcept {
    return (options.power_of_two ? floor_power_of_two(options.max_size) : options.max_size) /
           options.alignment;
}

/// One call of pack_rectangles. Lengths are in units of the alignment.
class atlas_packer {
public:
    atlas_packer(std::span<const ivec2> sizes, const pack_options& options)
        : sizes_(sizes),
          options_(options),
          limit_(side_limit(options)),
          steps_left_(search_steps(sizes.size())) {}

    [[nodiscard]] packing run() {
        packing result;
        result.rectangles.resize(sizes_.size());
        std::vector<std::size_t> left(sizes_.size());
        std::iota(left.begin(), left.end(), std::size_t{0});
        while (!left.empty()) fill_atlas(left, result);
        measure(result);
        return result;
    }

private:
    [[nodiscard]] ivec2 padded(const ivec2& size) const noexcept {
        const auto units = [this](int side) {
            return (side + 2 * options_.padding + options_.alignment - 1) / options_.alignment;
        };
        return {units(size.x), units(size.y)};
    }

    /// Moves rectangles from `left` to one more atlas: all, where that can be found.
    void fill_atlas(std::vector<std::size_t>& left, packing& result) {
        std::vector<ivec2> sizes;
        sizes.reserve(left.size());
        for (const std::size_t id : left) sizes.push_back(padded(sizes_[id]));
        strip_search search(sizes, limit_, options_.allows_rotation, steps_left_);
        std::vector<strip_place> places =
            options_.power_of_two ? search.smallest_power_of_two() : search.smallest();
        steps_left_ = std::max<std::int64_t>(steps_left_ - search.steps(), 0);
        turn_back(sizes, places);

        ivec2 used(0);
        const auto atlas = static_cast<atlas_id>(result.atlas_sizes.size());
        std::vector<std::size_t> kept;
        for (std::size_t i = 0; i < left.size(); ++i) {
            const strip_place& p = places[i];
            if (p.x < 0) {
                kept.push_back(left[i]);
                continue;
            }
            const ivec2 size = p.is_turned ? ivec2(sizes[i].y, sizes[i].x) : sizes[i];
            used = glm::max(used, ivec2(p.x, p.y) + size);
            result.rectangles[left[i]] = {atlas, p.x * options_.alignment + options_.padding,
                                          p.y * options_.alignment + options_.padding, p.is_turned};
        }
        ivec2 side = used * options_.alignment;
        if (options_.power_of_two) side = {ceil_power_of_two(side.x), ceil_power_of_two(side.y)};
        result.atlas_sizes.push_back(side);
        BILLOW_ASSERT(kept.size() < left.size());
        left = std::move(kept);
    }

    /// Turns a whole atlas by 90° where that leaves more area of rectangles upright.
    void turn_back(const std::vector<ivec2>& sizes, std::vector<strip_place>& places) const {
        if (!options_.allows_rotation) return;
        std::int64_t turned = 0;
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            if (places[i].x < 0) continue;
            const std::int64_t area = std::int64_t{sizes[i].x} * sizes[i].y;
            turned += places[i].is_turned ? area : -area;
        }
        if (turned <= 0) return;
        for (strip_place& p : places) {
            if (p.x < 0) continue;
            p = {p.y, p.x, !p.is_turned};
        }
    }

    void measure(packing& result) const noexcept {
        double atlases = 0;
        for (const ivec2& size : result.atlas_sizes) {
            atlases += static_cast<double>(size.x) * size.y;
        }
        for (const ivec2& size : sizes_) {
            const ivec2 whole = padded(size) * options_.alignment;
            result.fill += static_cast<double>(size.x) * size.y / atlases;
            result.padded_fill += static_cast<double>(whole.x) * whole.y / atlases;
        }
    }

    std::span<const ivec2> sizes_;
    pack_options options_;
    int limit_;
    std::int64_t steps_left_;
};

}  // namespace detail

/// The longest side that a rectangle may have to fit into an atlas, pixels.
[[nodiscard]] inline int largest_side(const pack_options& options) noexcept {
    return detail::side_limit(options) * options.alignment - 2 * options.padding;
}

/// Places rectangles in atlases so that they keep their distance: in one atlas, the smallest that is
/// found, where they fit into one; otherwise the first ones as full, so the last as small, as can be.
///
/// Unit   pixels.
/// Needs  sides of at least 1 and at most largest_side(options); with power_of_two an alignment that
///        is a power of two, too.
/// Gives  no atlas for no rectangle. Sides of an atlas about twice each other at most, but where
///        long rectangles need more. The same answer every time and everywhere.
/// Cost   a few ms for ten rectangles, 40 for 200, 0.3 s for 3,000: the search ends after a number
///        of steps, or at a fill of 1.
[[nodiscard]] inline packing pack_rectangles(std::span<const ivec2> sizes,
                                             const pack_options& options = {}) {
    BILLOW_ASSERT(options.alignment > 0 && options.padding >= 0);
    return detail::atlas_packer(sizes, options).run();
}

}  // namespace billow::inline BILLOW_ABI
