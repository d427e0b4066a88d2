// The offsets along one normal at which faces are valid and charged, a block of faces at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <billow/core/simd.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/policy/contribution.hpp>
#include <billow/policy/penalty.hpp>
#include <billow/policy/validity.hpp>

namespace billow::inline BILLOW_ABI {

/// Buckets of offsets, side by side from `low` to `high`; what lies outside is of the first or the
/// last one.
///
/// A bucket is what `bucket_of` says, which never falls when the offset grows: an interval [low, high]
/// touches the buckets from bucket_of(low) to bucket_of(high) and no others, however floats round.
class offset_buckets {
public:
    /// Needs low < high, count > 0.
    offset_buckets(double low, double high, int count) noexcept
        : count_(count),
          per_unit_(static_cast<float>(count / (high - low))),
          shift_(static_cast<float>(-low * count / (high - low))) {}

    [[nodiscard]] int count() const noexcept { return count_; }
    template <class V>
    [[nodiscard]] V position(V offset) const noexcept {
        const auto fill = [](float value) { return simd::lanes<V>::fill(value); };
        const V at = offset * fill(per_unit_) + fill(shift_);
        return simd::max(simd::min(at, fill(static_cast<float>(count_ - 1))), fill(0));
    }
    [[nodiscard]] std::int32_t bucket_of(float offset) const noexcept {
        return simd::truncate(position(offset));
    }

private:
    int count_;
    float per_unit_;
    float shift_;
};

namespace detail {

/// Offsets of a block of faces, with the buckets of both ends.
struct offset_ends {
    static constexpr std::size_t block_size = 256;
    std::array<float, block_size> low;
    std::array<float, block_size> high;
    std::array<std::int32_t, block_size> first;
    std::array<std::int32_t, block_size> last;

    template <class V>
    void store(std::size_t i, const offset_interval<V>& offsets,
               const offset_buckets& buckets) noexcept {
        using lanes = simd::lanes<V>;
        lanes::store(low.data() + i, offsets.low);
        lanes::store(high.data() + i, offsets.high);
        lanes::store(first.data() + i, simd::truncate(buckets.position(offsets.low)));
        lanes::store(last.data() + i, simd::truncate(buckets.position(offsets.high)));
    }
};

/// The faces of a block as planes of one normal see them.
struct offset_block {
    static constexpr std::size_t size = offset_ends::block_size;
    std::array<std::int32_t, size> weight;  ///< contribution in integers; 0: never valid
    offset_ends valid;                      ///< [low, high]
    offset_ends above;                      ///< charged: [low, high), none below 0
    offset_ends below;                      ///< charged: (low, high], none above 0
};

/// What decides about a face's offsets and weight.
template <class Contribution, class Penalty>
struct offset_rules {
    const Contribution& worth;
    const Penalty& penalty;
    offset_buckets buckets;
    float epsilon;
    float scale;  ///< integers per scene unit squared: density_scale
    bool charges;

    /// Fills `block` for the faces [first, first + count). Needs count ≤ the block's size, both
    /// multiples of the lanes. Of a penalty, the side of negative offsets is that of the opposite
    /// normal, whose inner side is the upper one.
    template <class V = simd::wide>
    void measure(const face_table& faces, std::size_t first, std::size_t count, const vec3& normal,
                 offset_block& block) const noexcept {
        using lanes = simd::lanes<V>;
        const vec3_lanes<V> n = fill_lanes<V>(normal);
        const V zero = lanes::fill(0);
        const V eps = lanes::fill(epsilon);
        const V unit = lanes::fill(scale);
        for (std::size_t i = 0; i < count; i += lanes::count) {
            const face_lanes<V> face = load_faces<V>(faces, first + i);
            const offset_interval<V> valid = valid_offsets(face, n, eps);
            const V weight = simd::select(valid.low <= valid.high, worth(face, n) * unit, zero);
            lanes::store(block.weight.data() + i, simd::truncate(weight));
            block.valid.store(i, valid, buckets);
            if (!charges) continue;
            const offset_interval<V> above = penalty(valid, eps);
            const offset_interval<V> mirrored =
                penalty(offset_interval<V>{-valid.high, -valid.low}, eps);
            block.above.store(i, offset_interval<V>{simd::max(above.low, zero), above.high},
                              buckets);
            block.below.store(i, offset_interval<V>{-mirrored.high, simd::min(-mirrored.low, zero)},
                              buckets);
        }
    }
};

}  // namespace detail

}  // namespace billow::inline BILLOW_ABI
