// Adds faces to density rows, and takes them out again.
//
// The loops are those that Luksch 2009 (section 4.6) found to scale: a thread owns a chunk of
// orientations and walks all faces. Within a chunk the faces come in blocks that stay in the cache,
// each block in two steps: lanes compute where the ramps start, scalars add them up.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <span>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/core/simd.hpp>
#include <billow/density/falloff_kernel.hpp>
#include <billow/density/grid.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/plane_space/plane_space.hpp>
#include <billow/policy/contribution.hpp>
#include <billow/policy/falloff.hpp>
#include <billow/policy/orientation_bias.hpp>
#include <billow/policy/penalty.hpp>
#include <billow/policy/validity.hpp>

namespace billow::inline BILLOW_ABI {

/// The policies that make a density.
template <class Validity = hull_of_samples, class Contribution = projected_area,
          class Penalty = inner_side_penalty, class Falloff = no_falloff, class Bias = no_bias>
struct density_policies {
    /// Where nothing is charged, the ramps of the penalty are not drawn.
    static constexpr bool charges = !std::same_as<Penalty, no_penalty>;
    /// Where contributions fall off, bins sample them instead of counting what is covered.
    static constexpr bool falls = Falloff::falls;

    Validity validity{};
    Contribution contribution{};
    Penalty penalty{};
    Falloff falloff{};
    Bias bias{};
};
template <class Validity, class Contribution = projected_area, class Penalty = inner_side_penalty,
          class Falloff = no_falloff, class Bias = no_bias>
density_policies(Validity, Contribution = {}, Penalty = {}, Falloff = {}, Bias = {})
    -> density_policies<Validity, Contribution, Penalty, Falloff, Bias>;

/// The same policies, without a falloff.
template <class Validity, class Contribution, class Penalty, class Falloff, class Bias>
[[nodiscard]] auto without_falloff(
    const density_policies<Validity, Contribution, Penalty, Falloff, Bias>& p) {
    return density_policies{p.validity, p.contribution, p.penalty, no_falloff{}, p.bias};
}

/// Integers per scene unit squared, such that the largest of the faces' contributions is 2^30, or all
/// together are 2^50, whichever is less: weighted they stay within 64 bits.
[[nodiscard]] inline double density_scale(const face_table& faces) noexcept {
    float largest = 0;
    double all = 0;
    for (const float area : faces.area) {
        largest = std::max(largest, area);
        all += static_cast<double>(area);
    }
    return largest > 0 ? std::min(0x1p30 / static_cast<double>(largest), 0x1p50 / all) : 1;
}

enum class density_change { add, remove };

namespace detail {

/// Where the ramps of a block of faces start: two that bound the contribution, two the penalty.
/// Under a falloff the contribution is sampled instead, in the bins from first to last.
struct ramp_block {
    static constexpr std::size_t size = 256;
    struct starts {
        std::array<std::int32_t, size> bin;
        std::array<std::int32_t, size> before;
    };
    struct samples {
        std::array<float, size> first;
        std::array<float, size> last;    ///< below first: no bin is touched
        std::array<float, size> middle;  ///< of the valid offsets, in bins
    };
    std::array<std::int32_t, size> height;  ///< 0: the face is not valid here
    std::array<starts, 4> start;
    samples sample;
    std::array<std::int32_t, size> key;  ///< of a falloff's kernel
};

/// Constants of a grid in lanes.
template <class V>
struct axis_lanes {
    V origin, inverse_spacing, bin_count, scale, epsilon;

    axis_lanes(const density_grid& grid, double eps) noexcept
        : origin(simd::lanes<V>::fill(static_cast<float>(grid.axis().origin))),
          inverse_spacing(simd::lanes<V>::fill(static_cast<float>(1 / grid.axis().spacing))),
          bin_count(simd::lanes<V>::fill(static_cast<float>(grid.axis().bin_count))),
          scale(simd::lanes<V>::fill(static_cast<float>(grid.scale()))),
          epsilon(simd::lanes<V>::fill(static_cast<float>(eps))) {}
};

/// Where the samples of lanes of faces lie that are valid from `low` to `high`, in bins: the bins
/// whose centres are valid, or that of the middle where none is.
template <class V>
void store_samples(V low, V high, V height, const axis_lanes<V>& axis, std::size_t i,
                   ramp_block& block) noexcept {
    using lanes = simd::lanes<V>;
    const V zero = lanes::fill(0);
    const V half = lanes::fill(0.5f);
    const V one = lanes::fill(1);
    const auto whole = [&](V bins) {
        return simd::to_float(simd::truncate(simd::max(simd::min(bins, axis.bin_count), zero)));
    };
    const V middle = (low + high) * half;
    const V own = whole(middle);
    const V own_last = simd::select(middle < zero, own - one, simd::min(own, axis.bin_count - one));
    const V first = whole(low + half);
    const V last = whole(high + half) - one;
    const auto has_none = last < first;
    const V begin = simd::select(has_none, own, first);
    const V end = simd::select(has_none, own_last, last);
    lanes::store(block.sample.first.data() + i, begin);
    lanes::store(block.sample.last.data() + i, simd::select(height >= one, end, begin - one));
    lanes::store(block.sample.middle.data() + i, middle);
}

/// Their keys of a kernel.
template <class V>
void store_keys(V low, V high, const axis_lanes<V>& axis, std::size_t i,
                const falloff_kernel& kernel, ramp_block& block) noexcept {
    using lanes = simd::lanes<V>;
    const auto fill = [](int value) { return lanes::fill(static_cast<float>(value)); };
    const V zero = lanes::fill(0);
    const V half = lanes::fill(0.5f);
    const V parts = fill(falloff_kernel::parts);
    // Truncation rounds down what is above 0: all of it is, with a lead before the axis.
    const V lead = fill(kernel.lead());
    const auto rounded = [&](V bins) {
        const V at = simd::max(simd::min(bins + lead, axis.bin_count + lead + lead), zero);
        return simd::to_float(simd::truncate(at * parts + half));
    };
    const V first = simd::min(rounded(low), (axis.bin_count + lead) * parts);
    const V length =
        simd::max(simd::min(rounded(high) - first, fill(kernel.lengths() - 1)), fill(1));
    lanes::store(block.key.data() + i, simd::truncate(first * fill(kernel.lengths()) + length));
}

/// Fills a block for the faces [first, first + count) and one cell. Returns whether any is valid.
template <class V, class Policies>
bool fill_ramp_block(const face_table& faces, std::size_t first, std::size_t count,
                     const cell_lanes<V>& cell, const axis_lanes<V>& axis, const Policies& policies,
                     const falloff_kernel& kernel, ramp_block& block) noexcept {
    const V zero = simd::lanes<V>::fill(0);
    V highest = zero;
    for (std::size_t i = 0; i < count; i += simd::lanes<V>::count) {
        const face_lanes<V> face = load_faces<V>(faces, first + i);
        const offset_interval<V> valid = policies.validity(face, cell, axis.epsilon);
        const V worth = policies.contribution(face, cell.centre) * axis.scale;
        const V height = simd::select(valid.low <= valid.high, worth, zero);
        highest = simd::max(highest, height);

        const auto rounded = simd::truncate(height);
        simd::lanes<V>::store(block.height.data() + i, rounded);
        const V exact_height = simd::to_float(rounded);
        const auto in_bins = [&](V offset) {
            return (offset - axis.origin) * axis.inverse_spacing;
        };
        const auto clip = [&](V bins) { return simd::max(simd::min(bins, axis.bin_count), zero); };
        const auto put = [&](std::size_t k, V offset) {
            const V at = clip(in_bins(offset));
            const auto bin = simd::truncate(at);
            const V share = at - simd::to_float(bin);
            simd::lanes<V>::store(block.start[k].bin.data() + i, bin);
            simd::lanes<V>::store(block.start[k].before.data() + i,
                                  simd::truncate(exact_height * share));
        };
        if constexpr (Policies::falls) {
            if (kernel.empty()) {
                store_samples<V>(in_bins(valid.low), in_bins(valid.high), height, axis, i, block);
            } else {
                store_keys<V>(in_bins(valid.low), in_bins(valid.high), axis, i, kernel, block);
            }
        } else {
            put(0, valid.low);
            put(1, valid.high);
        }
        if constexpr (Policies::charges) {
            // Below 0 the row belongs to the opposite normal, whose inner side is the upper one.
            const offset_interval<V> above = policies.penalty(valid, axis.epsilon);
            const offset_interval<V> mirrored = {-valid.high, -valid.low};
            const offset_interval<V> below = policies.penalty(mirrored, axis.epsilon);
            const auto is_above = valid.low > zero;
            put(2,
                simd::select(is_above, simd::max(above.low, zero), simd::min(-below.high, zero)));
            put(3,
                simd::select(is_above, simd::max(above.high, zero), simd::min(-below.low, zero)));
        }
    }
    alignas(64) std::array<float, simd::max_lane_count> lanes{};
    simd::lanes<V>::store(lanes.data(), highest);
    for (const float lane : lanes) {
        if (lane > 0) return true;
    }
    return false;
}

/// Adds sign times the block's contributions to a row, weighted by the falloff at the centre of each
/// bin whose centre is valid. A value of one bin is a ramp's `before` of less than 0.
///
/// Source  Luksch 2009, section 3.2, with the intent of eq 3.7: half a bin is free. Differs: Figure
///         3.7 counts every bin that valid offsets touch, which promises faces that the planes of the
///         bin then do not take, and costs up to a fifth more planes.
template <int Sign, class V, class Falloff>
void add_samples(const ramp_block& block, std::size_t count, const axis_lanes<V>& axis,
                 const Falloff& weigh, std::span<ramp> row) noexcept {
    using lanes = simd::lanes<V>;
    const V zero = lanes::fill(0);
    const V half = lanes::fill(0.5f);
    const V one = lanes::fill(1);
    const V epsilon = axis.epsilon * axis.inverse_spacing;
    alignas(64) std::array<std::int32_t, lanes::count> bins;
    alignas(64) std::array<std::int32_t, lanes::count> values;
    for (std::size_t i = 0; i < count; i += lanes::count) {
        const V height = simd::to_float(lanes::load(block.height.data() + i));
        const V middle = lanes::load(block.sample.middle.data() + i);
        const V last = lanes::load(block.sample.last.data() + i);
        V bin = lanes::load(block.sample.first.data() + i);
        lanes::store(bins.data(), simd::truncate(last - bin));
        const std::int32_t most = *std::ranges::max_element(bins);
        for (std::int32_t k = 0; k <= most; ++k) {
            const V distance = simd::max(simd::abs(bin + half - middle) - half, zero);
            const V value = height * weigh(distance, epsilon);
            lanes::store(values.data(), simd::truncate(simd::select(bin <= last, value, zero)));
            lanes::store(bins.data(), simd::truncate(simd::min(bin, axis.bin_count)));
            for (std::size_t lane = 0; lane < lanes::count; ++lane) {
                row[static_cast<std::size_t>(bins[lane])].before -= Sign * values[lane];
            }
            bin = bin + one;
        }
    }
}

/// Adds sign times the block's ramps to a row, those of the penalty only where it charges.
template <int Sign, class Policies>
void add_ramps(const ramp_block& block, std::size_t count, std::span<ramp> contribution,
               std::span<ramp> penalty) noexcept {
    const auto add = [&](std::span<ramp> row, const ramp_block::starts& start, std::size_t i,
                         std::int64_t sign) {
        ramp& at = row[static_cast<std::size_t>(start.bin[i])];
        at.step += sign * block.height[i];
        at.before += sign * start.before[i];
    };
    for (std::size_t i = 0; i < count; ++i) {
        if constexpr (!Policies::falls) {
            add(contribution, block.start[0], i, Sign);
            add(contribution, block.start[1], i, -Sign);
        }
        if constexpr (Policies::charges) {
            add(penalty, block.start[2], i, Sign);
            add(penalty, block.start[3], i, -Sign);
        }
    }
}

/// Adds sign times the samples of a block to one row, at once or counted by key.
template <int Sign>
void add_keys(const ramp_block& block, std::size_t count, const falloff_kernel& kernel,
              std::span<std::int64_t> counts, std::span<ramp> row) noexcept {
    if (counts.empty()) {
        for (std::size_t i = 0; i < count; ++i) {
            if (block.height[i] == 0) continue;
            kernel.add(static_cast<std::size_t>(block.key[i]), std::int64_t{Sign} * block.height[i],
                       row);
        }
    } else {
        for (std::size_t i = 0; i < count; ++i) {
            counts[static_cast<std::size_t>(block.key[i])] += block.height[i];
        }
    }
}

/// Adds sign times a block of faces to one row of a grid. `counts`: see add_keys.
template <int Sign, class V, class Policies>
void add_block(const ramp_block& block, std::size_t count, const axis_lanes<V>& axis,
               const Policies& policies, const falloff_kernel& kernel,
               std::span<std::int64_t> counts, density_grid& grid, std::size_t row) noexcept {
    if constexpr (Policies::falls) {
        if (kernel.empty()) {
            add_samples<Sign>(block, count, axis, policies.falloff, grid.contribution(row));
        } else {
            add_keys<Sign>(block, count, kernel, counts, grid.contribution(row));
        }
    }
    add_ramps<Sign, Policies>(block, count, grid.contribution(row), grid.penalty(row));
}

/// The kernel for a grid that make_density_grid made; none for the few bins of a refinement, where
/// faces reach far across.
template <class Policies>
[[nodiscard]] falloff_kernel kernel_for(const Policies& policies, const density_grid& grid,
                                        std::span<const orientation_cell> cells, double epsilon) {
    if constexpr (Policies::falls) {
        if (grid.contribution_unit() > 1) {
            BILLOW_ASSERT(grid.contribution_unit() == falloff_kernel::unit);
            float chord = 0;
            for (const orientation_cell& cell : cells) chord = std::max(chord, cell.chord);
            // Within a cell the offsets of a corner differ by its chord times its distance.
            const double radius = std::abs(grid.axis().origin);
            const double length = 2 * (epsilon + static_cast<double>(chord) * radius);
            const double spacing = grid.axis().spacing;
            return {policies.falloff, epsilon / spacing, length / spacing, grid.axis().bin_count};
        }
    }
    BILLOW_ASSERT(grid.contribution_unit() == 1);
    return {};
}

}  // namespace detail

/// A grid that rasterize_density can fill fastest with these policies.
template <class Policies>
[[nodiscard]] density_grid make_density_grid(const Policies&, std::size_t row_count,
                                             const offset_axis& axis, double scale) {
    return {row_count, axis, scale, Policies::falls ? detail::falloff_kernel::unit : 1};
}

/// Adds faces to every row of a density grid, or removes faces that were added before.
///
/// A row stands for a cell of normals and, at offsets below 0, for the opposite normals. Each face
/// counts its contribution, measured at the cell's centre, at the offsets where the validity policy
/// allows it, and as a penalty where the penalty policy charges it; a bin that is covered in part
/// counts that part. Under a falloff a bin counts the contribution as weighted at its centre, where that
/// is valid.
///
/// Shape   `cells`: one a row of `grid`.
/// Unit    `epsilon` in scene units.
/// Needs   the grid's scale ≤ density_scale(faces) of the faces that are ever added; to remove, the
///         same cells, policies and epsilon as when the faces were added.
/// Gives   contributions ≥ 0, and exactly 0 when all faces have been removed; the same integers for
///         any number of threads and any order of faces.
/// Cost    O(faces · rows), parallel over rows; under a falloff some 30 kB a row and thread.
/// Source  Décoret et al. 2003; Luksch 2009, sections 2.1, 3.2 and 4.6.
template <class V = simd::wide, validity<V> Validity, contribution<V> Contribution,
          penalty<V> Penalty, falloff<V> Falloff, orientation_bias Bias>
void rasterize_density(
    const face_table& faces, std::span<const orientation_cell> cells,
    const density_policies<Validity, Contribution, Penalty, Falloff, Bias>& policies,
    double epsilon, density_grid& grid, density_change change = density_change::add,
    parallel threads = {}) {
    BILLOW_ASSERT(cells.size() == grid.row_count());
    const detail::axis_lanes<V> axis(grid, epsilon);
    const detail::falloff_kernel kernel = detail::kernel_for(policies, grid, cells, epsilon);
    // Starting threads for a few faces costs more than the faces.
    const std::size_t chunk = faces.size * cells.size() < 100'000 ? cells.size() + 1 : 8;
    // Few faces are weighted one by one, many are counted by key first.
    const std::size_t keys = faces.size > kernel.key_count() ? kernel.key_count() : 0;
    threads.for_chunks(cells.size(), chunk, [&](std::size_t begin, std::size_t end) {
        detail::ramp_block block;
        std::vector<std::int64_t> counts((end - begin) * keys);
        const auto counts_of = [&](std::size_t row) {
            return std::span(counts).subspan((row - begin) * keys, keys);
        };
        for (std::size_t first = 0; first < faces.padded_size(); first += block.size) {
            const std::size_t count = std::min(block.size, faces.padded_size() - first);
            for (std::size_t row = begin; row < end; ++row) {
                const cell_lanes<V> cell(cells[row]);
                if (!detail::fill_ramp_block(faces, first, count, cell, axis, policies, kernel,
                                             block)) {
                    continue;
                }
                if (change == density_change::add) {
                    detail::add_block<1>(block, count, axis, policies, kernel, counts_of(row), grid,
                                         row);
                } else {
                    detail::add_block<-1>(block, count, axis, policies, kernel, counts_of(row),
                                          grid, row);
                }
            }
        }
        const std::int64_t sign = change == density_change::add ? 1 : -1;
        for (std::size_t row = begin; row < end && keys > 0; ++row) {
            const std::span<const std::int64_t> of_row = counts_of(row);
            for (std::size_t key = 0; key < keys; ++key) {
                if (of_row[key] != 0) kernel.add(key, sign * of_row[key], grid.contribution(row));
            }
        }
    });
}

}  // namespace billow::inline BILLOW_ABI
