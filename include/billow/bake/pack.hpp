// Rectangles in, places in as few and as small atlases as can be found, out.
//
// The skyline packer is stb_rect_pack; orders, quarter turns and atlas widths are tried around it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include <billow/core/types.hpp>

// The packer lives in our namespace, private to each translation unit, whatever the user includes.
#pragma push_macro("STBRP_DEF")
#pragma push_macro("STBRP_SORT")
#pragma push_macro("STBRP_ASSERT")
#pragma push_macro("STBRP_STATIC")
#pragma push_macro("STB_RECT_PACK_IMPLEMENTATION")
#pragma push_macro("STB_INCLUDE_STB_RECT_PACK_H")
#pragma push_macro("STB_RECT_PACK_VERSION")
#pragma push_macro("STBRP__MAXVAL")
#pragma push_macro("STBRP__NOTUSED")
#pragma push_macro("STBRP__CDECL")
#undef STBRP_DEF
#undef STBRP_SORT
#undef STBRP_ASSERT
#undef STB_INCLUDE_STB_RECT_PACK_H
#undef STB_RECT_PACK_VERSION
#undef STBRP__MAXVAL
#undef STBRP__NOTUSED
#undef STBRP__CDECL
#undef STBRP_STATIC
#undef STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_ASSERT(condition) BILLOW_ASSERT(condition)
// We hand the rectangles over in order: qsort would leave ties to the C library.
#define STBRP_SORT(rects, count, size, compare) static_cast<void>(compare)
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#endif
namespace billow::inline BILLOW_ABI::detail::stb {
#include <stb_rect_pack.h>
}  // namespace billow::inline BILLOW_ABI::detail::stb
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
#undef STBRP_DEF
#undef STBRP_SORT
#undef STBRP_ASSERT
#undef STBRP_STATIC
#undef STB_RECT_PACK_IMPLEMENTATION
#undef STB_INCLUDE_STB_RECT_PACK_H
#undef STB_RECT_PACK_VERSION
#undef STBRP__MAXVAL
#undef STBRP__NOTUSED
#undef STBRP__CDECL
#pragma pop_macro("STBRP__CDECL")
#pragma pop_macro("STBRP__NOTUSED")
#pragma pop_macro("STBRP__MAXVAL")
#pragma pop_macro("STB_RECT_PACK_VERSION")
#pragma pop_macro("STB_INCLUDE_STB_RECT_PACK_H")
#pragma pop_macro("STB_RECT_PACK_IMPLEMENTATION")
#pragma pop_macro("STBRP_STATIC")
#pragma pop_macro("STBRP_ASSERT")
#pragma pop_macro("STBRP_SORT")
#pragma pop_macro("STBRP_DEF")

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
};

namespace detail {

/// One way to fill one atlas, in units of the alignment.
struct pack_trial {
    std::vector<stb::stbrp_rect> rectangles{};
    int width = 0;
    int height = 0;
    std::int64_t packed_area = 0;
    bool holds_all = false;

    [[nodiscard]] std::int64_t area() const noexcept { return std::int64_t{width} * height; }
    /// More rectangles first, then less area, then the squarer atlas.
    [[nodiscard]] bool is_better_than(const pack_trial& other) const noexcept {
        if (holds_all != other.holds_all) return holds_all;
        if (!holds_all && packed_area != other.packed_area) return packed_area > other.packed_area;
        if (area() != other.area()) return area() < other.area();
        return std::max(width, height) < std::max(other.width, other.height);
    }
};

[[nodiscard]] inline int floor_power_of_two(int value) noexcept {
    int power = 1;
    while (power <= value / 2) power *= 2;
    return power;
}

/// The longest side of an atlas, in units of the alignment.
[[nodiscard]] inline int side_limit(const pack_options& options) noexcept {
    const int limit = options.max_size / options.alignment;
    return options.power_of_two ? floor_power_of_two(options.max_size) / options.alignment : limit;
}

enum class turn_rule { none, landscape, portrait };
enum class order_rule { height, longer_side, area };

class atlas_packer {
public:
    atlas_packer(std::span<const ivec2> sizes, const pack_options& options)
        : sizes_(sizes), options_(options), limit_(side_limit(options)) {}

    [[nodiscard]] packing run() {
        packing result;
        result.rectangles.resize(sizes_.size());
        std::vector<std::size_t> left(sizes_.size());
        std::iota(left.begin(), left.end(), std::size_t{0});
        while (!left.empty()) {
            const pack_trial best = best_trial(left);
            const auto atlas = static_cast<atlas_id>(result.atlas_sizes.size());
            result.atlas_sizes.push_back(
                {best.width * options_.alignment, best.height * options_.alignment});
            for (const stb::stbrp_rect& r : best.rectangles) {
                if (!r.was_packed) continue;
                const auto id = static_cast<std::size_t>(r.id);
                result.rectangles[id] = {atlas, r.x * options_.alignment + options_.padding,
                                         r.y * options_.alignment + options_.padding,
                                         r.w != units(sizes_[id].x) || r.h != units(sizes_[id].y)};
            }
            std::erase_if(left,
                          [&](std::size_t id) { return result.rectangles[id].atlas != no_id; });
        }
        return result;
    }

private:
    [[nodiscard]] int units(int size) const noexcept {
        return (size + 2 * options_.padding + options_.alignment - 1) / options_.alignment;
    }
    [[nodiscard]] static int ceil_power(int value) noexcept {
        const int power = floor_power_of_two(value);
        return power < value ? 2 * power : power;
    }

    [[nodiscard]] std::vector<stb::stbrp_rect> rectangles_of(const std::vector<std::size_t>& ids,
                                                             turn_rule turn,
                                                             order_rule order) const {
        std::vector<stb::stbrp_rect> rectangles;
        rectangles.reserve(ids.size());
        for (const std::size_t id : ids) {
            int w = units(sizes_[id].x);
            int h = units(sizes_[id].y);
            if ((turn == turn_rule::landscape && w < h) || (turn == turn_rule::portrait && w > h)) {
                std::swap(w, h);
            }
            rectangles.push_back({static_cast<int>(id), w, h, 0, 0, 0});
        }
        const auto key = [order](const stb::stbrp_rect& r) -> std::array<std::int64_t, 2> {
            const std::int64_t area = std::int64_t{r.w} * r.h;
            if (order == order_rule::height) return {r.h, r.w};
            if (order == order_rule::longer_side) return {std::max(r.w, r.h), area};
            return {area, r.h};
        };
        std::stable_sort(rectangles.begin(), rectangles.end(),
                         [&](const auto& a, const auto& b) { return key(a) > key(b); });
        return rectangles;
    }

    [[nodiscard]] pack_trial trial(std::vector<stb::stbrp_rect> rectangles, int width) {
        stb::stbrp_context context;
        nodes_.resize(static_cast<std::size_t>(width));
        stb::stbrp_init_target(&context, width, limit_, nodes_.data(), width);
        const int count = static_cast<int>(rectangles.size());
        pack_trial t;
        t.holds_all = stb::stbrp_pack_rects(&context, rectangles.data(), count) != 0;
        for (const stb::stbrp_rect& r : rectangles) {
            if (!r.was_packed) continue;
            t.packed_area += std::int64_t{r.w} * r.h;
            t.width = std::max(t.width, r.x + r.w);
            t.height = std::max(t.height, r.y + r.h);
        }
        if (options_.power_of_two) {
            t.width = ceil_power(t.width);
            t.height = ceil_power(t.height);
        }
        t.rectangles = std::move(rectangles);
        return t;
    }

    /// Widths from the square root of the area upwards to twice that, and the limit.
    [[nodiscard]] std::vector<int> widths_for(const std::vector<std::size_t>& ids) const {
        std::int64_t area = 0;
        int narrowest = 1;
        for (const std::size_t id : ids) {
            const int w = units(sizes_[id].x);
            const int h = units(sizes_[id].y);
            area += std::int64_t{w} * h;
            narrowest = std::max(narrowest, options_.allows_rotation ? std::min(w, h) : w);
        }
        std::vector<int> widths;
        if (options_.power_of_two) {
            for (int w = ceil_power(narrowest); w <= limit_; w *= 2) widths.push_back(w);
        } else {
            const double side = std::sqrt(static_cast<double>(area));
            for (const double share : {0.7, 1.0, 1.02, 1.05, 1.1, 1.2, 1.4, 2.0}) {
                widths.push_back(std::clamp(static_cast<int>(std::ceil(side * share)),
                                            std::min(narrowest, limit_), limit_));
            }
            widths.push_back(limit_);
            std::sort(widths.begin(), widths.end());
            widths.erase(std::unique(widths.begin(), widths.end()), widths.end());
        }
        return widths;
    }

    [[nodiscard]] pack_trial best_trial(const std::vector<std::size_t>& ids) {
        const std::vector<int> widths = widths_for(ids);
        pack_trial best;
        bool is_first = true;
        for (const turn_rule turn : {turn_rule::none, turn_rule::landscape, turn_rule::portrait}) {
            if (turn != turn_rule::none && !options_.allows_rotation) break;
            for (const order_rule order :
                 {order_rule::height, order_rule::longer_side, order_rule::area}) {
                const auto rectangles = rectangles_of(ids, turn, order);
                for (const int width : widths) {
                    pack_trial t = trial(rectangles, width);
                    if (is_first || t.is_better_than(best)) best = std::move(t);
                    is_first = false;
                }
            }
        }
        return best;
    }

    std::span<const ivec2> sizes_;
    pack_options options_;
    int limit_;
    std::vector<stb::stbrp_node> nodes_{};
};

}  // namespace detail

/// The longest side that a rectangle may have to fit into an atlas, pixels.
[[nodiscard]] inline int largest_side(const pack_options& options) noexcept {
    return detail::side_limit(options) * options.alignment - 2 * options.padding;
}

/// Places rectangles in atlases so that they keep their distance: the smallest atlas that several
/// orders, turns and widths give; where one atlas does not hold all, the fullest first, and so on.
///
/// Unit   pixels.
/// Needs  sides of at least 1 and at most largest_side(options); with power_of_two an alignment that
///        is a power of two, too.
/// Cost   O(n²) at worst, a few ms for a thousand rectangles. The same answer every time.
[[nodiscard]] inline packing pack_rectangles(std::span<const ivec2> sizes,
                                             const pack_options& options = {}) {
    BILLOW_ASSERT(options.alignment > 0 && options.padding >= 0);
    return detail::atlas_packer(sizes, options).run();
}

}  // namespace billow::inline BILLOW_ABI
