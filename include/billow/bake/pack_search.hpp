// The order and the width of a strip that pack its rectangles best.
//
// A local search over orders, as in Wei et al., "A skyline heuristic for the 2D rectangular packing
// and strip packing problems", 2011; here the width of the strip is searched for as well, and the
// time goes to fewer and fewer candidates. Time is counted in steps, so the answer does not depend on
// the machine.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include <billow/bake/pack_skyline.hpp>
#include <billow/core/random.hpp>
#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI::detail {

[[nodiscard]] inline int floor_power_of_two(int value) noexcept {
    int power = 1;
    while (power <= value / 2) power *= 2;
    return power;
}

[[nodiscard]] inline int ceil_power_of_two(int value) noexcept {
    const int power = floor_power_of_two(value);
    return power < value ? 2 * power : power;
}

/// How long to search for the places of `count` rectangles; a step is some 4 ns.
[[nodiscard]] inline std::int64_t search_steps(std::size_t count) noexcept {
    const auto n = static_cast<std::int64_t>(count);
    return std::min<std::int64_t>(5'000'000, 200'000 * n) + 20'000 * n;
}

/// Searches for the best places of rectangles in one atlas. Lengths are in units of the alignment.
class strip_search {
public:
    /// Needs  sizes that fit into a square of `limit`, turned if `allows_turns`.
    ///        `steps` for all atlases that it takes; search_steps(sizes.size()) is a good number.
    strip_search(std::span<const ivec2> sizes, int limit, bool allows_turns, std::int64_t steps)
        : sizes_(sizes), limit_(limit), allows_turns_(allows_turns) {
        for (const ivec2& size : sizes_) {
            area_ += std::int64_t{size.x} * size.y;
            narrowest_ = std::max(narrowest_, allows_turns ? std::min(size.x, size.y) : size.x);
        }
        const auto count = static_cast<std::int64_t>(sizes_.size());
        steps_ = steps / (1 + area_ / (std::int64_t{limit} * limit));
        is_long_ = count * count > steps_ / 4;
        make_orders();
    }

    /// Steps taken.
    [[nodiscard]] std::int64_t steps() const noexcept { return packer_.steps(); }

    /// Places of all rectangles in the least area, or of as many as one atlas holds.
    [[nodiscard]] std::vector<strip_place> smallest() {
        if (area_ <= std::int64_t{limit_} * limit_) {
            const double side = std::sqrt(static_cast<double>(area_));
            const auto within = [this](double width) {
                return std::clamp(static_cast<int>(std::ceil(width)), narrowest_, limit_);
            };
            least_width_ = within(side / longest_ratio);
            most_width_ = within(side * longest_ratio);
            room_height_ = limit_;
            start(steps_ / 3);
            if (!found_.empty()) {
                improve(steps_ - steps_ / 3);
                return places_of(found_[0]);
            }
        }
        fill_fixed({limit_, limit_}, steps_);
        return places_of(found_[0]);
    }

    /// The same in an atlas whose sides are powers of two.
    ///
    /// Needs  a limit that is one.
    [[nodiscard]] std::vector<strip_place> smallest_power_of_two() {
        std::vector<ivec2> rooms;
        for (int width = limit_; width >= narrowest_; width /= 2) {
            for (int height = limit_; std::int64_t{width} * height >= area_; height /= 2) {
                if (holds_each({width, height})) rooms.emplace_back(width, height);
            }
        }
        std::stable_sort(rooms.begin(), rooms.end(), [](const ivec2& a, const ivec2& b) {
            const auto key = [](const ivec2& r) {
                return std::tuple(std::int64_t{r.x} * r.y, std::max(r.x, r.y));
            };
            return key(a) < key(b);
        });
        if (rooms.empty()) rooms.emplace_back(limit_, limit_);
        for (const ivec2& room : rooms) {
            fill_fixed(room, steps_ / 4);
            if (found_[0].score.left == 0) break;
        }
        return places_of(found_[0]);
    }

private:
    static constexpr double longest_ratio = 1.42;  ///< its square is the ratio of an atlas' sides
    static constexpr std::size_t most_candidates = 16;
    static constexpr int halvings = 4;

    using order = std::vector<std::uint32_t>;

    struct quality {
        std::int64_t left = 0;  ///< area without a place
        std::int64_t area = 0;
        int longest = 0;
        // NOLINTNEXTLINE(modernize-use-nullptr): the 0 is of the comparison that the compiler writes
        friend auto operator<=>(const quality&, const quality&) = default;
    };
    struct candidate {
        quality score{};
        order sequence{};
        placing_rule rule{};
        strip room{};
    };

    [[nodiscard]] bool holds_each(const ivec2& room) const noexcept {
        return std::all_of(sizes_.begin(), sizes_.end(), [&](const ivec2& s) {
            return (s.x <= room.x && s.y <= room.y) ||
                   (allows_turns_ && s.y <= room.x && s.x <= room.y);
        });
    }

    void make_orders() {
        const auto add = [this](auto key) {
            order sequence(sizes_.size());
            std::iota(sequence.begin(), sequence.end(), 0u);
            std::stable_sort(sequence.begin(), sequence.end(),
                             [&](auto a, auto b) { return key(sizes_[a]) > key(sizes_[b]); });
            orders_.push_back(std::move(sequence));
        };
        using keys = std::tuple<std::int64_t, int>;
        const auto low = [](const ivec2& s) { return std::min(s.x, s.y); };
        const auto high = [](const ivec2& s) { return std::max(s.x, s.y); };
        add([=](const ivec2& s) { return keys(high(s), low(s)); });
        add([=](const ivec2& s) { return keys(std::int64_t{s.x} * s.y, high(s)); });
        add([=](const ivec2& s) { return keys(s.x + s.y, high(s)); });
        add([=](const ivec2& s) { return keys(low(s), high(s)); });
        add([=](const ivec2& s) { return keys(s.y, s.x); });
    }

    [[nodiscard]] quality try_out(const order& sequence, placing_rule rule, const strip& room) {
        const strip_use use = packer_.fill(sizes_, sequence, rule, room);
        return {area_ - use.area, std::int64_t{use.width} * use.height,
                std::max(use.width, use.height)};
    }

    [[nodiscard]] bool is_perfect(const quality& q) const noexcept {
        return q.left == 0 && (is_fixed_ || q.area == area_);
    }

    /// All orders and rules over widths that lie ever closer together.
    void start(std::int64_t steps) {
        found_.clear();
        const std::int64_t end = packer_.steps() + steps;
        const int widths = std::min(64, most_width_ - least_width_ + 1);
        for (int i = 0; i < widths; ++i) {
            const strip room{least_width_ + spread(i), room_height_, allows_turns_, !is_fixed_};
            for (const placing_rule rule : {placing_rule::lowest, placing_rule::best_fit}) {
                if (is_long_ && rule == placing_rule::best_fit) continue;
                for (const order& sequence : orders_) {
                    if (packer_.steps() > end && !found_.empty()) break;
                    const quality q = try_out(sequence, rule, room);
                    if (q.left == 0 || is_fixed_) found_.push_back({q, sequence, rule, room});
                }
            }
        }
        sort_found(found_.size());
        found_.resize(std::min(found_.size(), most_candidates));
    }

    /// The i-th of the widths, from far apart to close together: van der Corput's sequence.
    [[nodiscard]] int spread(int i) const noexcept {
        double share = 0;
        double digit = 0.5;
        for (int rest = i + 1; rest > 0; rest /= 2, digit /= 2) share += (rest % 2) * digit;
        return static_cast<int>(share * (most_width_ - least_width_ + 1));
    }

    void sort_found(std::size_t count) {
        std::stable_sort(found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(count),
                         [](const auto& a, const auto& b) { return a.score < b.score; });
    }

    /// Changes orders and widths, keeps what is not worse; every so often the worse half goes.
    void improve(std::int64_t steps) {
        std::size_t count = found_.size();
        const std::int64_t begin = packer_.steps();
        for (int round = 1; round <= halvings + 1 && !is_perfect(found_[0].score); ++round) {
            const std::int64_t stop = begin + steps / (halvings + 1) * round;
            for (std::size_t i = 0; packer_.steps() < stop; i = (i + 1) % count) {
                vary(found_[i]);
                if (is_perfect(found_[i].score)) break;
            }
            sort_found(count);
            count = (count + 1) / 2;
        }
    }

    void vary(candidate& c) {
        const auto count = static_cast<double>(sizes_.size());
        const auto pick = [&] { return static_cast<std::ptrdiff_t>(random_.between(0, count)); };
        changed_ = c.sequence;
        for (int change = random_.unit() < 0.5 ? 1 : 2; change > 0; --change) {
            const auto a = changed_.begin() + pick();
            const auto b = changed_.begin() + pick();
            if (random_.unit() < 0.5) {
                std::iter_swap(a, b);
            } else if (a < b) {
                std::rotate(a, a + 1, b + 1);
            } else {
                std::rotate(b, a, a + 1);
            }
        }
        strip room = c.room;
        if (!is_fixed_) {
            if (random_.unit() < 0.3) {
                room.width += static_cast<int>(random_.between(0, 7)) - 3;
                room.width = std::clamp(room.width, least_width_, most_width_);
            }
            room.height =
                static_cast<int>(std::min<std::int64_t>(room_height_, c.score.area / room.width));
        }
        const quality q = try_out(changed_, c.rule, room);
        if (q > c.score) return;
        c.score = q;
        c.room = room;
        std::swap(c.sequence, changed_);
    }

    /// As much as can be found into a room of fixed size.
    void fill_fixed(const ivec2& room, std::int64_t steps) {
        is_fixed_ = true;
        least_width_ = most_width_ = room.x;
        room_height_ = room.y;
        start(steps / 3);
        improve(steps - steps / 3);
    }

    [[nodiscard]] std::vector<strip_place> places_of(const candidate& c) {
        static_cast<void>(try_out(c.sequence, c.rule, c.room));
        return {packer_.places().begin(), packer_.places().end()};
    }

    std::span<const ivec2> sizes_;
    int limit_;
    bool allows_turns_;
    std::int64_t area_ = 0;
    int narrowest_ = 1;
    std::int64_t steps_ = 0;  ///< the search ends after so many
    bool is_long_ = false;    ///< too many rectangles for the best fit, which takes n²
    bool is_fixed_ = false;   ///< the room is given: fill it, rather than find the smallest
    int least_width_ = 0;
    int most_width_ = 0;
    int room_height_ = 0;
    std::vector<order> orders_{};
    std::vector<candidate> found_{};
    order changed_{};
    strip_packer packer_{};
    random_stream random_{1};
};

}  // namespace billow::inline BILLOW_ABI::detail
