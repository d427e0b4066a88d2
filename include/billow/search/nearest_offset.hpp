// The offset nearest to faces that are valid for all of a range: where a falloff is least.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 3.2: a distance
// falloff draws planes to the faces that they stand for, eq 3.8: onto the large one, not between all.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <billow/core/config.hpp>
#include <billow/policy/falloff.hpp>

namespace billow::inline BILLOW_ABI {

/// What a face asks of an offset: to be near the middle of its valid ones.
struct weighted_middle {
    float middle = 0;
    float weight = 0;  ///< ≥ 0
};

/// Of the offsets in [low, high] the one with the greatest sum of weight · falloff(distance to the
/// middle): as a rule it lies in the faces that weigh most, where a mean lies between all.
///
/// The sum is greatest in a middle or at an end of the range, since a distance falloff is steepest at 0
/// and convex beyond. Middles are gathered in cells, a 128th of their spread wide, of which the best
/// is taken, and there the median of the middles: for faces farther than a few cells apart this is
/// the offset itself.
///
/// Unit    offsets and epsilon alike.
/// Needs   low ≤ high; epsilon > 0. Reorders `middles`.
/// Gives   the middle of the range where nothing weighs; of equals the least offset.
/// Cost    O(middles), and 128² falloffs at most.
template <falloff<float> Falloff>
[[nodiscard]] double nearest_offset(std::span<weighted_middle> middles, double low, double high,
                                    double epsilon, const Falloff& weigh) {
    constexpr std::size_t cell_count = 128;
    BILLOW_ASSERT(low <= high && epsilon > 0);
    float least = 0, most = 0;
    bool is_first = true;
    for (const weighted_middle& m : middles) {
        if (!(m.weight > 0)) continue;
        least = is_first ? m.middle : std::min(least, m.middle);
        most = is_first ? m.middle : std::max(most, m.middle);
        is_first = false;
    }
    if (is_first) return (low + high) / 2;

    const float cells_per_unit = most > least ? static_cast<float>(cell_count) / (most - least) : 0;
    const auto cell_of = [&](float middle) {
        const auto cell = static_cast<std::size_t>((middle - least) * cells_per_unit);
        return std::min(cell, cell_count - 1);
    };
    std::array<double, cell_count> weights{}, sums{};
    for (const weighted_middle& m : middles) {
        if (!(m.weight > 0)) continue;
        const std::size_t cell = cell_of(m.middle);
        weights[cell] += static_cast<double>(m.weight);
        sums[cell] += static_cast<double>(m.weight) * static_cast<double>(m.middle);
    }
    std::array<float, cell_count> means{}, masses{};
    std::array<std::size_t, cell_count> cells{};
    std::size_t count = 0;
    for (std::size_t cell = 0; cell < cell_count; ++cell) {
        if (!(weights[cell] > 0)) continue;
        means[count] = static_cast<float>(sums[cell] / weights[cell]);
        masses[count] = static_cast<float>(weights[cell]);
        cells[count++] = cell;
    }
    const auto eps = static_cast<float>(epsilon);
    const auto worth = [&](float offset) {
        float sum = 0;
        for (std::size_t i = 0; i < count; ++i) {
            sum += masses[i] * weigh(std::abs(offset - means[i]), eps);
        }
        return sum;
    };
    const auto from = static_cast<float>(low), to = static_cast<float>(high);
    double best = low;
    float best_worth = worth(from);
    std::size_t best_cell = cell_count;
    for (std::size_t i = 0; i < count; ++i) {
        if (!(from < means[i] && means[i] < to)) continue;
        const float here = worth(means[i]);
        if (here > best_worth) best_worth = here, best_cell = cells[i];
    }
    if (worth(to) > best_worth) return high;
    if (best_cell == cell_count) return best;

    const auto end = std::partition(middles.begin(), middles.end(), [&](const weighted_middle& m) {
        return m.weight > 0 && cell_of(m.middle) == best_cell;
    });
    std::sort(middles.begin(), end, [](const weighted_middle& a, const weighted_middle& b) {
        return a.middle != b.middle ? a.middle < b.middle : a.weight < b.weight;
    });
    double before = 0;
    for (auto m = middles.begin(); m != end; ++m) {
        before += static_cast<double>(m->weight);
        best = static_cast<double>(m->middle);
        if (before >= weights[best_cell] / 2) break;
    }
    return std::clamp(best, low, high);
}

}  // namespace billow::inline BILLOW_ABI
