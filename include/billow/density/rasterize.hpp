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

#include <billow/core/parallel.hpp>
#include <billow/core/simd.hpp>
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

/// Integers per scene unit squared, such that the largest of the faces' contributions is 2^30.
[[nodiscard]] inline double density_scale(const face_table& faces) noexcept {
    float largest = 0;
    for (const float area : faces.area) largest = std::max(largest, area);
    return largest > 0 ? 0x1p30 / static_cast<double>(largest) : 1;
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

/// Fills a block for the faces [first, first + count) and one cell. Returns whether any is valid.
template <class V, class Policies>
bool fill_ramp_block(const face_table& faces, std::size_t first, std::size_t count,
                     const cell_lanes<V>& cell, const axis_lanes<V>& axis, const Policies& policies,
                     ramp_block& block) noexcept {
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
            using lanes = simd::lanes<V>;
            const V low = in_bins(valid.low);
            const V high = in_bins(valid.high);
            const V end = clip(high);
            const V whole = simd::to_float(simd::truncate(end));
            const V begin = simd::to_float(simd::truncate(clip(low)));
            lanes::store(block.sample.first.data() + i, begin);
            // An interval that ends where a bin begins does not touch it.
            const V last = simd::select(whole < end, whole, whole - lanes::fill(1));
            lanes::store(block.sample.last.data() + i,
                         simd::select(height >= lanes::fill(1), last, begin - lanes::fill(1)));
            lanes::store(block.sample.middle.data() + i, (low + high) * lanes::fill(0.5f));
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
/// bin that a face's valid offsets touch. A value of one bin is a ramp's `before` of less than 0.
///
/// Source  Luksch 2009, section 3.2, with the intent of eq 3.7: half a bin is free.
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

/// Adds sign times a block of faces to one row of a grid.
template <int Sign, class V, class Policies>
void add_block(const ramp_block& block, std::size_t count, const axis_lanes<V>& axis,
               const Policies& policies, density_grid& grid, std::size_t row) noexcept {
    if constexpr (Policies::falls) {
        add_samples<Sign>(block, count, axis, policies.falloff, grid.contribution(row));
    }
    add_ramps<Sign, Policies>(block, count, grid.contribution(row), grid.penalty(row));
}

}  // namespace detail

/// Adds faces to every row of a density grid, or removes faces that were added before.
///
/// A row stands for a cell of normals and, at offsets below 0, for the opposite normals. Each face
/// counts its contribution, measured at the cell's centre, at the offsets where the validity policy
/// allows it, and as a penalty where the penalty policy charges it; a bin that is covered in part
/// counts that part. Under a falloff a bin counts the contribution as weighted at its centre, however
/// much of it is covered.
///
/// Shape   `cells`: one a row of `grid`.
/// Unit    `epsilon` in scene units.
/// Needs   the grid's scale ≤ density_scale(faces) of the faces that are ever added; to remove, the
///         same cells, policies and epsilon as when the faces were added.
/// Gives   contributions ≥ 0, and exactly 0 when all faces have been removed; the same integers for
///         any number of threads and any order of faces.
/// Cost    O(faces · rows), parallel over rows, no allocation.
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
    // Starting threads for a few faces costs more than the faces.
    const std::size_t chunk = faces.size * cells.size() < 100'000 ? cells.size() + 1 : 8;
    threads.for_chunks(cells.size(), chunk, [&](std::size_t begin, std::size_t end) {
        detail::ramp_block block;
        for (std::size_t first = 0; first < faces.padded_size(); first += block.size) {
            const std::size_t count = std::min(block.size, faces.padded_size() - first);
            for (std::size_t row = begin; row < end; ++row) {
                const cell_lanes<V> cell(cells[row]);
                if (!detail::fill_ramp_block(faces, first, count, cell, axis, policies, block)) {
                    continue;
                }
                if (change == density_change::add) {
                    detail::add_block<1>(block, count, axis, policies, grid, row);
                } else {
                    detail::add_block<-1>(block, count, axis, policies, grid, row);
                }
            }
        }
    });
}

}  // namespace billow::inline BILLOW_ABI
