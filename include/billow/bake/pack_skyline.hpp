// Rectangles into one strip, by a skyline: the tops of what lies there already.
//
// Lowest place: Jylänki, "A thousand ways to pack the bin", 2010, section 2.4 (skyline bottom-left).
// Best fit: Burke, Kendall, Whitwell, "A new placement heuristic for the orthogonal stock-cutting
// problem", 2004; what counts as the best fit follows Wei et al., "A skyline heuristic for the 2D
// rectangular packing and strip packing problems", 2011.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI::detail {

/// Where a rectangle lies in a strip.
struct strip_place {
    int x = -1;  ///< below 0: nowhere
    int y = 0;
    bool is_turned = false;
};

/// The room to fill, in units.
struct strip {
    int width = 0;
    int height = 0;
    bool allows_turns = true;
    bool needs_all = true;  ///< give up at the first rectangle that has no place
};

/// What a filled strip holds.
struct strip_use {
    std::int64_t area = 0;  ///< of the rectangles that have a place
    int width = 0;          ///< of the room that they take
    int height = 0;
    bool holds_all = false;
};

enum class placing_rule {
    lowest,    ///< each rectangle, in order, where its top is lowest
    best_fit,  ///< each lowest gap, in turn, gets the rectangle that leaves least of it
};

/// Fills strips one after the other, without allocating again.
class strip_packer {
public:
    /// Where the rectangles of the last call went.
    [[nodiscard]] std::span<const strip_place> places() const noexcept { return places_; }
    /// Steps taken since the beginning: a measure of time that is the same everywhere.
    [[nodiscard]] std::int64_t steps() const noexcept { return steps_; }

    strip_use fill(std::span<const ivec2> sizes, std::span<const std::uint32_t> order,
                   placing_rule rule, const strip& room) {
        places_.assign(sizes.size(), {});
        tops_.assign(1, {0, 0});
        room_ = room;
        use_ = {};
        use_.holds_all = rule == placing_rule::lowest ? place_lowest(sizes, order)
                                                      : place_best_fit(sizes, order);
        return use_;
    }

private:
    /// A piece of the skyline; it ends where the next one begins.
    struct piece {
        int x = 0;
        int y = 0;
    };

    [[nodiscard]] int end_of(std::size_t i) const noexcept {
        return i + 1 < tops_.size() ? tops_[i + 1].x : room_.width;
    }

    [[nodiscard]] bool place_lowest(std::span<const ivec2> sizes,
                                    std::span<const std::uint32_t> order) {
        bool holds_all = true;
        for (const std::uint32_t id : order) {
            std::size_t best = tops_.size();
            int best_top = room_.height + 1;
            bool is_turned = false;
            const auto consider = [&](const ivec2& size, bool turned) {
                for (std::size_t i = 0; i < tops_.size(); ++i) {
                    ++steps_;
                    const int end = tops_[i].x + size.x;
                    if (end > room_.width) break;
                    int y = tops_[i].y;
                    for (std::size_t k = i + 1; k < tops_.size() && tops_[k].x < end; ++k) {
                        if (y + size.y >= best_top) break;
                        y = std::max(y, tops_[k].y);
                        ++steps_;
                    }
                    if (y + size.y < best_top) {
                        best = i;
                        best_top = y + size.y;
                        is_turned = turned;
                    }
                }
            };
            const ivec2 size = sizes[id];
            consider(size, false);
            if (room_.allows_turns && size.x != size.y) consider({size.y, size.x}, true);
            if (best == tops_.size()) {
                holds_all = false;
                if (room_.needs_all) return false;
                continue;
            }
            const ivec2 placed = is_turned ? ivec2(size.y, size.x) : size;
            put(id, tops_[best].x, best_top - placed.y, placed, is_turned);
        }
        return holds_all;
    }

    [[nodiscard]] bool place_best_fit(std::span<const ivec2> sizes,
                                      std::span<const std::uint32_t> order) {
        left_.assign(order.begin(), order.end());
        std::int64_t spare = std::int64_t{room_.width} * room_.height;  // may stay empty
        for (const ivec2& size : sizes) spare -= std::int64_t{size.x} * size.y;
        while (!left_.empty()) {
            std::size_t gap = 0;
            for (std::size_t i = 1; i < tops_.size(); ++i) {
                if (tops_[i].y < tops_[gap].y) gap = i;
            }
            const int x = tops_[gap].x;
            const int y = tops_[gap].y;
            const int width = end_of(gap) - x;
            const int wall_left = gap > 0 ? tops_[gap - 1].y : room_.height;
            const int wall_right = gap + 1 < tops_.size() ? tops_[gap + 1].y : room_.height;
            const fit best =
                best_fit(sizes, {width, room_.height - y}, {wall_left - y, wall_right - y});
            steps_ += static_cast<std::int64_t>(tops_.size());
            if (best.score == 0) {  // nothing fits: the gap is lost
                const int level = std::min(wall_left, wall_right);
                spare -= std::int64_t{width} * (level - y);
                if (tops_.size() == 1 || (room_.needs_all && spare < 0)) return false;
                raise(x, x + width, level);
                continue;
            }
            const std::uint32_t id = left_[best.at];
            left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(best.at));
            const ivec2 placed = best.is_turned ? ivec2(sizes[id].y, sizes[id].x) : sizes[id];
            put(id, wall_left >= wall_right ? x : x + width - placed.x, y, placed, best.is_turned);
        }
        return true;
    }

    struct fit {
        int score = 0;
        std::size_t at = 0;
        bool is_turned = false;
    };

    /// The first of the rectangles left that fits a gap best: it spans the gap and is level with a
    /// wall, spans it, is level with the higher wall, with the lower one, or just fits.
    [[nodiscard]] fit best_fit(std::span<const ivec2> sizes, const ivec2& gap,
                               const ivec2& walls) noexcept {
        const int higher = std::max(walls.x, walls.y);
        const int lower = std::min(walls.x, walls.y);
        fit best;
        const auto consider = [&](std::size_t at, int w, int h, bool is_turned) {
            if (w > gap.x || h > gap.y) return;
            const bool is_level = h == higher || h == lower;
            const int score = w == gap.x ? 4 + is_level : h == higher ? 3 : 1 + is_level;
            if (score > best.score) best = {score, at, is_turned};
        };
        std::size_t at = 0;
        for (; at < left_.size() && best.score < 5; ++at) {
            const ivec2 size = sizes[left_[at]];
            consider(at, size.x, size.y, false);
            if (room_.allows_turns) consider(at, size.y, size.x, true);
        }
        steps_ += static_cast<std::int64_t>(at);
        return best;
    }

    void put(std::uint32_t id, int x, int y, const ivec2& size, bool is_turned) {
        places_[id] = {x, y, is_turned};
        use_.area += std::int64_t{size.x} * size.y;
        use_.width = std::max(use_.width, x + size.x);
        use_.height = std::max(use_.height, y + size.y);
        raise(x, x + size.x, y + size.y);
        steps_ += 8;
    }

    /// Sets the skyline from `begin` to `end` to `level`; pieces of one level become one.
    void raise(int begin, int end, int level) {
        const auto at = [this](std::size_t i) {
            return tops_.begin() + static_cast<std::ptrdiff_t>(i);
        };
        std::size_t first = 0;  // the first piece that starts at `begin` or after it
        while (first < tops_.size() && tops_[first].x < begin) ++first;
        std::size_t last = first;  // the first piece that starts after `end`, or at it
        while (last < tops_.size() && tops_[last].x < end) ++last;
        const int after = tops_[last - 1].y;  // the level of what `end` cuts
        const bool goes_on = end < (last < tops_.size() ? tops_[last].x : room_.width);
        const bool joins_before = first > 0 && tops_[first - 1].y == level;
        const bool joins_after = !goes_on && last < tops_.size() && tops_[last].y == level;
        if (joins_after) ++last;
        tops_.erase(at(first), at(last));
        if (goes_on && after != level) tops_.insert(at(first), {end, after});
        if (!joins_before) tops_.insert(at(first), {begin, level});
    }

    std::vector<strip_place> places_{};
    std::vector<piece> tops_{};
    std::vector<std::uint32_t> left_{};
    strip room_{};
    strip_use use_{};
    std::int64_t steps_ = 0;
};

}  // namespace billow::inline BILLOW_ABI::detail
