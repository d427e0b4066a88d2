// One float a pixel, and filters that work along rows and columns.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <billow/core/simd.hpp>

namespace billow::inline BILLOW_ABI {

/// One float a pixel. Rows from the upper edge down, padded so that loops over lanes have no tail;
/// what the padding holds means nothing.
struct channel {
    int width = 0;
    int height = 0;
    std::size_t stride = 0;  ///< floats from a row to the next
    std::vector<float> values{};

    channel() = default;
    channel(int columns, int rows)
        : width(columns),
          height(rows),
          stride(simd::padded(static_cast<std::size_t>(columns))),
          values(stride * static_cast<std::size_t>(rows)) {}

    [[nodiscard]] float* row(int y) noexcept {
        return values.data() + static_cast<std::size_t>(y) * stride;
    }
    [[nodiscard]] const float* row(int y) const noexcept {
        return values.data() + static_cast<std::size_t>(y) * stride;
    }
    [[nodiscard]] float at(int x, int y) const noexcept { return row(y)[x]; }
};

/// Weights of an odd number of neighbours, the pixel itself in the middle.
using filter_weights = std::vector<float>;

/// The weights of a Gaussian, sampled at the middles of pixels up to `radius` and scaled to a sum of
/// 1. Weights that a float could not tell from 0 beside the largest one are left out.
///
/// Unit  pixels.        Needs  sigma > 0, radius ≥ 0.
[[nodiscard]] inline filter_weights gaussian_weights(double sigma, int radius) {
    const auto at = [sigma](int x) { return std::exp(-0.5 * x * x / (sigma * sigma)); };
    while (radius > 0 && at(radius) < 1e-8) --radius;
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) sum += at(x);
    filter_weights weights;
    for (int x = -radius; x <= radius; ++x) weights.push_back(static_cast<float>(at(x) / sum));
    return weights;
}

namespace detail {

/// Σ weight · value, neighbour by neighbour.
struct weighted_sum {
    std::span<const float> weights{};

    [[nodiscard]] std::size_t count() const noexcept { return weights.size(); }
    template <class V>
    [[nodiscard]] V first(V value) const noexcept {
        return value * weights[0];
    }
    template <class V>
    [[nodiscard]] V next(V sum, V value, std::size_t k) const noexcept {
        return sum + value * weights[k];
    }
};

/// The least of so many neighbours.
struct least_of {
    std::size_t neighbours = 1;

    [[nodiscard]] std::size_t count() const noexcept { return neighbours; }
    template <class V>
    [[nodiscard]] V first(V value) const noexcept {
        return value;
    }
    template <class V>
    [[nodiscard]] V next(V least, V value, std::size_t) const noexcept {
        return simd::min(least, value);
    }
};

/// Folds values[k] for k = 0, 1, … into `to`, a block of max_lane_count floats.
template <class V, class Fold, class At>
void fold_block(const Fold& fold, const At& at, float* to) noexcept {
    constexpr std::size_t lanes = simd::lanes<V>::count;
    std::array<V, simd::max_lane_count / lanes> folded;
    const float* from = at(0);
    for (std::size_t i = 0; i < folded.size(); ++i) {
        folded[i] = fold.first(simd::lanes<V>::load(from + i * lanes));
    }
    for (std::size_t k = 1; k < fold.count(); ++k) {
        from = at(k);
        for (std::size_t i = 0; i < folded.size(); ++i) {
            folded[i] = fold.next(folded[i], simd::lanes<V>::load(from + i * lanes), k);
        }
    }
    for (std::size_t i = 0; i < folded.size(); ++i) {
        simd::lanes<V>::store(to + i * lanes, folded[i]);
    }
}

template <class V, class Fold>
[[nodiscard]] channel fold_rows(const channel& from, const Fold& fold) {
    const std::size_t radius = fold.count() / 2;
    const auto width = static_cast<std::size_t>(from.width);
    channel to(from.width, from.height);
    std::vector<float> line(from.stride + 2 * radius);
    for (int y = 0; y < from.height; ++y) {
        const float* row = from.row(y);
        const auto inner = line.begin() + static_cast<std::ptrdiff_t>(radius);
        std::fill(line.begin(), inner, row[0]);
        std::fill(std::copy(row, row + width, inner), line.end(), row[width - 1]);
        for (std::size_t x = 0; x < to.stride; x += simd::max_lane_count) {
            const float* first = line.data() + x;
            fold_block<V>(
                fold, [first](std::size_t k) { return first + k; }, to.row(y) + x);
        }
    }
    return to;
}

template <class V, class Fold>
[[nodiscard]] channel fold_columns(const channel& from, const Fold& fold) {
    const auto radius = static_cast<int>(fold.count() / 2);
    channel to(from.width, from.height);
    std::vector<const float*> rows(fold.count());
    for (int y = 0; y < from.height; ++y) {
        for (std::size_t k = 0; k < rows.size(); ++k) {
            const int neighbour = y - radius + static_cast<int>(k);
            rows[k] = from.row(std::clamp(neighbour, 0, from.height - 1));
        }
        for (std::size_t x = 0; x < to.stride; x += simd::max_lane_count) {
            fold_block<V>(
                fold, [&rows, x](std::size_t k) { return rows[k] + x; }, to.row(y) + x);
        }
    }
    return to;
}

}  // namespace detail

/// Each pixel's weighted sum of its neighbours in the row; beyond the edge the outermost pixel is
/// read again. `weights[0]` is that of the leftmost neighbour.
///
/// Needs  a channel of at least one pixel, an odd number of weights.
/// Cost   O(pixels · weights). V = float is the reference, to which lanes are equal bit by bit where
///        the compiler does not contract sums.
template <class V = simd::wide>
[[nodiscard]] channel filter_rows(const channel& from, std::span<const float> weights) {
    BILLOW_ASSERT(from.width > 0 && from.height > 0 && weights.size() % 2 == 1);
    return detail::fold_rows<V>(from, detail::weighted_sum{weights});
}

/// The same along columns; `weights[0]` is that of the uppermost neighbour.
template <class V = simd::wide>
[[nodiscard]] channel filter_columns(const channel& from, std::span<const float> weights) {
    BILLOW_ASSERT(from.width > 0 && from.height > 0 && weights.size() % 2 == 1);
    return detail::fold_columns<V>(from, detail::weighted_sum{weights});
}

/// Blurs along both.
[[nodiscard]] inline channel blurred(const channel& from, std::span<const float> weights) {
    return filter_columns(filter_rows(from, weights), weights);
}

/// The least value within `radius` pixels along rows and columns: a square of 2 radius + 1. What is
/// beyond the edge does not count. Cost O(pixels · radius).
[[nodiscard]] inline channel eroded(const channel& from, int radius) {
    BILLOW_ASSERT(from.width > 0 && from.height > 0 && radius >= 0);
    const detail::least_of least{2 * static_cast<std::size_t>(radius) + 1};
    return detail::fold_columns<simd::wide>(detail::fold_rows<simd::wide>(from, least), least);
}

}  // namespace billow::inline BILLOW_ABI
