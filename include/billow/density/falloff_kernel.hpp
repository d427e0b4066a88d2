// The weights of a distance falloff, tabulated for the bins of a density row.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <billow/density/grid.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// The weights of a falloff for valid offsets whose ends are rounded to quarters of a bin. Their
/// number is small, so faces are counted by them first and weighted afterwards, all at once.
class falloff_kernel {
public:
    static constexpr int parts = 4;       ///< of a bin
    static constexpr int unit = 1 << 12;  ///< weights are multiples of 1 / unit

    falloff_kernel() = default;

    /// `most_length`: of valid offsets; longer ones are weighted as if they ended there. `epsilon`
    /// and lengths in bins.
    template <class Falloff>
    falloff_kernel(const Falloff& weigh, double epsilon, double most_length, int bin_count)
        : lengths_(static_cast<int>(std::ceil(most_length * parts)) + 2),
          bins_(lengths_ / parts + 2),
          bin_count_(bin_count),
          weights_(static_cast<std::size_t>(parts * lengths_ * bins_)) {
        std::size_t at = 0;
        for (int low = 0; low < parts; ++low) {
            for (int length = 0; length < lengths_; ++length) {
                const double middle = (low + 0.5 * length) / parts;
                for (int bin = 0; bin < bins_; ++bin) {
                    const double centre = (bin + 0.5) * parts;
                    const bool counts = (low <= centre && centre <= low + length) ||
                                        bin == static_cast<int>(middle);
                    const double distance = std::max(0.0, std::abs(bin + 0.5 - middle) - 0.5);
                    const float weight =
                        weigh(static_cast<float>(distance), static_cast<float>(epsilon));
                    weights_[at++] = counts ? std::lround(static_cast<double>(weight) * unit) : 0;
                }
            }
        }
    }

    [[nodiscard]] bool empty() const noexcept { return weights_.empty(); }
    [[nodiscard]] int lengths() const noexcept { return lengths_; }
    /// Bins before the axis that valid offsets may start in and still reach it.
    [[nodiscard]] int lead() const noexcept { return bins_; }
    /// Pairs of a rounded low end, from `lead` on, and a length: low · lengths() + length.
    [[nodiscard]] std::size_t key_count() const noexcept {
        return static_cast<std::size_t>((bin_count_ + lead() + 1) * parts * lengths_);
    }

    /// Adds `height` faces of the key to a row.
    void add(std::size_t key, std::int64_t height, std::span<ramp> row) const noexcept {
        const int low = static_cast<int>(key) / lengths_;
        const int length = static_cast<int>(key) % lengths_;
        const std::int64_t* weight =
            weights_.data() + static_cast<std::size_t>((low % parts * lengths_ + length) * bins_);
        const int first = low / parts - lead();
        const int begin = std::max(first, 0);
        const int end = std::min(first + bins_, bin_count_);
        for (int bin = begin; bin < end; ++bin) {
            row[static_cast<std::size_t>(bin)].before -= height * weight[bin - first];
        }
    }

private:
    int lengths_ = 0;  ///< in parts of a bin, that are told apart
    int bins_ = 0;     ///< that the longest may touch
    int bin_count_ = 0;
    std::vector<std::int64_t> weights_{};
};

}  // namespace detail

}  // namespace billow::inline BILLOW_ABI
