// A number for each view, in three that tell: the mean, what nearly all stay below, and the worst.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <billow/core/config.hpp>

namespace billow::inline BILLOW_ABI {

struct statistic {
    double mean = 0;
    /// The least of the values that at least 95 % of them do not exceed: of n values in ascending
    /// order the one at place ⌈0.95 n⌉, counted from 1. No mean of two; of fewer than 20 the worst.
    double p95 = 0;
    double worst = 0;            ///< the largest
    std::size_t worst_view = 0;  ///< its row, of equal ones the first

    [[nodiscard]] bool operator==(const statistic&) const = default;
};

/// Of one value a view; all 0 without views.
///
/// Needs  finite values.
/// Gives  the same bits for the same values in the same order: the mean is summed in double, in
///        order.
/// Cost   O(views).
[[nodiscard]] inline statistic statistic_of(std::span<const double> values) {
    if (values.empty()) return {};
    statistic result;
    for (const double value : values) result.mean += value;
    result.mean /= static_cast<double>(values.size());
    const auto worst = std::max_element(values.begin(), values.end());
    result.worst = *worst;
    result.worst_view = static_cast<std::size_t>(worst - values.begin());
    // In integers: 0.95 n is no double where it matters, at whole numbers.
    const std::size_t place = (values.size() * 95 + 99) / 100;
    std::vector<double> sorted(values.begin(), values.end());
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(place - 1);
    std::nth_element(sorted.begin(), at, sorted.end());
    result.p95 = *at;
    return result;
}

}  // namespace billow::inline BILLOW_ABI
