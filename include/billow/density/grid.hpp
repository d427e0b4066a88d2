// Density rows: how much contribution and penalty each bin of offsets has gathered.
//
// Décoret et al. 2003; Luksch 2009, sections 2.1 and 4.6. Differs: a face's interval [a, b] is not
// walked bin by bin. Its coverage of the bins is the difference of two ramps, "everything above a"
// less "everything above b", and a ramp is two numbers at the bin where it starts. So adding a face
// costs the same whatever the length of its interval, and the bins appear when the row is summed.
// The numbers are integers: addition is exact in any order, removal leaves exactly nothing behind.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Bins of offsets: bin b is [origin + b·spacing, origin + (b + 1)·spacing].
struct offset_axis {
    double origin = 0;
    double spacing = 1;
    int bin_count = 0;

    [[nodiscard]] double centre_of(double bin) const noexcept {
        return origin + (bin + 0.5) * spacing;
    }
};

/// Ramps that start in one bin: `step` is their joint height, `before` the part of it that lies in
/// the bin before their starts. The coverage of bin b is Σ step[0..b] - before[b]. A value of that
/// bin alone is taken off `before`.
struct ramp {
    std::int64_t step = 0;
    std::int64_t before = 0;

    friend bool operator==(const ramp&, const ramp&) = default;
};

/// One row of bins an orientation, in contributions and in uncharged penalties (weight 1).
///
/// Unit  1 / scale scene units squared; contributions 1 / (scale · contribution_unit).
class density_grid {
public:
    density_grid(std::size_t row_count, const offset_axis& axis, double scale,
                 int contribution_unit = 1)
        : axis_(axis),
          scale_(scale),
          contribution_unit_(contribution_unit),
          contribution_(row_count * stride(axis)),
          penalty_(row_count * stride(axis)) {}

    [[nodiscard]] const offset_axis& axis() const noexcept { return axis_; }
    /// Units of the integers per scene unit squared.
    [[nodiscard]] double scale() const noexcept { return scale_; }
    /// Units of a contribution per unit of a penalty: what weights are multiples of.
    [[nodiscard]] int contribution_unit() const noexcept { return contribution_unit_; }
    [[nodiscard]] double contribution_scale() const noexcept { return scale_ * contribution_unit_; }
    [[nodiscard]] std::size_t row_count() const noexcept {
        return contribution_.size() / stride(axis_);
    }

    /// bin_count + 1 ramps: a ramp may start at the very end.
    [[nodiscard]] std::span<ramp> contribution(std::size_t row) noexcept {
        return std::span(contribution_).subspan(row * stride(axis_), stride(axis_));
    }
    [[nodiscard]] std::span<ramp> penalty(std::size_t row) noexcept {
        return std::span(penalty_).subspan(row * stride(axis_), stride(axis_));
    }

    /// Calls `visit(bin, contribution, penalty)` for each bin of a row, in order.
    template <class Visit>
    void for_each_bin(std::size_t row, const Visit& visit) const {
        const ramp* c = contribution_.data() + row * stride(axis_);
        const ramp* p = penalty_.data() + row * stride(axis_);
        std::int64_t c_height = 0;
        std::int64_t p_height = 0;
        for (int bin = 0; bin < axis_.bin_count; ++bin, ++c, ++p) {
            c_height += c->step;
            p_height += p->step;
            visit(bin, c_height - c->before, p_height - p->before);
        }
    }

private:
    [[nodiscard]] static std::size_t stride(const offset_axis& axis) noexcept {
        return static_cast<std::size_t>(axis.bin_count) + 1;
    }

    offset_axis axis_;
    double scale_;
    int contribution_unit_;
    std::vector<ramp> contribution_;
    std::vector<ramp> penalty_;
};

/// A bin and its density, contribution - weight · penalty, in scene units squared.
struct dense_bin {
    std::size_t row = 0;
    int bin = 0;
    double density = 0;
    double contribution = 0;
};

/// The bin that `worth(row, contribution, penalty)` values most, a double; among equals the first.
/// Needs at least one row and bin. Cost O(rows · bins), parallel over rows.
template <class Worth>
[[nodiscard]] dense_bin densest_bin(const density_grid& grid, const Worth& worth,
                                    parallel threads = {}) {
    const dense_bin none{.density = -std::numeric_limits<double>::infinity()};
    // Enough bins a chunk to pay for a thread.
    const std::size_t chunk = 1 + 100'000 / static_cast<std::size_t>(grid.axis().bin_count);
    std::vector<dense_bin> best((grid.row_count() + chunk - 1) / chunk, none);
    threads.for_chunks(grid.row_count(), chunk, [&](std::size_t begin, std::size_t end) {
        dense_bin densest = none;
        for (std::size_t row = begin; row < end; ++row) {
            grid.for_each_bin(row, [&](int bin, std::int64_t contribution, std::int64_t penalty) {
                const double c = static_cast<double>(contribution) / grid.contribution_scale();
                const double density = worth(row, c, static_cast<double>(penalty) / grid.scale());
                if (density > densest.density) densest = {row, bin, density, c};
            });
        }
        best[begin / chunk] = densest;
    });
    return *std::ranges::max_element(best, {}, &dense_bin::density);
}

}  // namespace billow::inline BILLOW_ABI
