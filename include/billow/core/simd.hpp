// Vector lanes: the one place that knows how the compiler spells them.
//
// A kernel is written once with a lane type V. With V = float it is the scalar reference, with
// V = simd::wide it works on simd::lane_count faces at once. Functions are called qualified
// (simd::abs), since a bare abs would find the integer one.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include <billow/core/config.hpp>

#if BILLOW_LANES > 4
#include <immintrin.h>
#elif BILLOW_LANES == 4 && defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace billow::inline BILLOW_ABI::simd {

/// How many floats `wide` holds. Columns are padded to max_lane_count, so kernels have no tail.
inline constexpr std::size_t lane_count = BILLOW_LANES;
inline constexpr std::size_t max_lane_count = 16;

[[nodiscard]] constexpr std::size_t padded(std::size_t size) noexcept {
    return (size + max_lane_count - 1) / max_lane_count * max_lane_count;
}

// One lane.
[[nodiscard]] inline float min(float a, float b) noexcept { return a < b ? a : b; }
[[nodiscard]] inline float max(float a, float b) noexcept { return a > b ? a : b; }
[[nodiscard]] inline float abs(float a) noexcept { return a < 0 ? -a : a; }
[[nodiscard]] inline float sqrt(float a) noexcept { return std::sqrt(a); }
[[nodiscard]] inline float select(bool mask, float yes, float no) noexcept {
    return mask ? yes : no;
}
[[nodiscard]] inline std::int32_t select(bool mask, std::int32_t yes, std::int32_t no) noexcept {
    return mask ? yes : no;
}
[[nodiscard]] inline bool any(bool mask) noexcept { return mask; }
[[nodiscard]] inline std::int32_t truncate(float a) noexcept {
    return static_cast<std::int32_t>(a);
}
[[nodiscard]] inline float to_float(std::int32_t a) noexcept { return static_cast<float>(a); }
[[nodiscard]] inline std::int32_t bits_of(float a) noexcept {
    return std::bit_cast<std::int32_t>(a);
}
[[nodiscard]] inline float from_bits(std::int32_t a) noexcept { return std::bit_cast<float>(a); }

/// Number of lanes of V, and V read from or written to memory (no alignment needed).
template <class V>
struct lanes {
    static constexpr std::size_t count = 1;
    static V load(const float* from) noexcept { return *from; }
    static std::int32_t load(const std::int32_t* from) noexcept { return *from; }
    static void store(float* to, V value) noexcept { *to = value; }
    static void store(std::int32_t* to, std::int32_t value) noexcept { *to = value; }
    static V fill(float value) noexcept { return value; }
};

#if BILLOW_LANES > 1

// GCC and Clang map these types and their operators to the instruction set that the flags grant.
typedef float wide __attribute__((vector_size(4 * BILLOW_LANES)));
typedef std::int32_t wide_int __attribute__((vector_size(4 * BILLOW_LANES)));

#if BILLOW_LANES == 4 && defined(__SSE__)
// GCC 12 spells a comparison out in four instructions when several selections share it.
[[nodiscard]] inline wide min(wide a, wide b) noexcept { return _mm_min_ps(a, b); }
[[nodiscard]] inline wide max(wide a, wide b) noexcept { return _mm_max_ps(a, b); }
#else
[[nodiscard]] inline wide min(wide a, wide b) noexcept { return a < b ? a : b; }
[[nodiscard]] inline wide max(wide a, wide b) noexcept { return a > b ? a : b; }
#endif
[[nodiscard]] inline wide abs(wide a) noexcept {
    return reinterpret_cast<wide>(reinterpret_cast<wide_int>(a) & 0x7fffffff);
}
// Compilers know no operator for it. IEEE 754 rounds it alike everywhere.
[[nodiscard]] inline wide sqrt(wide a) noexcept {
#if BILLOW_LANES == 16
    return _mm512_sqrt_ps(a);
#elif BILLOW_LANES == 8
    return _mm256_sqrt_ps(a);
#elif defined(__SSE__)
    return _mm_sqrt_ps(a);
#else
    for (std::size_t i = 0; i < lane_count; ++i) a[i] = std::sqrt(a[i]);
    return a;
#endif
}
[[nodiscard]] inline wide select(wide_int mask, wide yes, wide no) noexcept {
    return mask ? yes : no;
}
[[nodiscard]] inline wide_int select(wide_int mask, wide_int yes, wide_int no) noexcept {
    return mask ? yes : no;
}
/// Whether a comparison holds in any lane.
[[nodiscard]] inline bool any(wide_int mask) noexcept {
#if BILLOW_LANES == 16
    return _mm512_test_epi32_mask(reinterpret_cast<__m512i>(mask),
                                  reinterpret_cast<__m512i>(mask)) != 0;
#elif BILLOW_LANES == 8
    return _mm256_movemask_ps(reinterpret_cast<__m256>(mask)) != 0;
#elif defined(__SSE__)
    return _mm_movemask_ps(reinterpret_cast<__m128>(mask)) != 0;
#else
    for (std::size_t i = 0; i < lane_count; ++i) {
        if (mask[i] != 0) return true;
    }
    return false;
#endif
}
[[nodiscard]] inline wide_int truncate(wide a) noexcept {
    return __builtin_convertvector(a, wide_int);
}
[[nodiscard]] inline wide to_float(wide_int a) noexcept { return __builtin_convertvector(a, wide); }
[[nodiscard]] inline wide_int bits_of(wide a) noexcept { return reinterpret_cast<wide_int>(a); }
[[nodiscard]] inline wide from_bits(wide_int a) noexcept { return reinterpret_cast<wide>(a); }

template <>
struct lanes<wide> {
    static constexpr std::size_t count = lane_count;
    static wide load(const float* from) noexcept {
        wide value;
        std::memcpy(&value, from, sizeof value);
        return value;
    }
    static wide_int load(const std::int32_t* from) noexcept {
        wide_int value;
        std::memcpy(&value, from, sizeof value);
        return value;
    }
    static void store(float* to, wide value) noexcept { std::memcpy(to, &value, sizeof value); }
    static void store(std::int32_t* to, wide_int value) noexcept {
        std::memcpy(to, &value, sizeof value);
    }
    static wide fill(float value) noexcept { return wide{} + value; }
};

#else

using wide = float;

#endif

/// The cube root of a number from 1e-25 to 1e25, off by less than a share of 3e-7. A float's bits,
/// taken as a number, are nearly its logarithm: a third of them starts two steps of Halley's.
template <class V>
[[nodiscard]] V cube_root(V a) noexcept {
    V root = from_bits(truncate(to_float(bits_of(a)) * (1.0f / 3.0f) + 709'921'077.0f));
    for (int step = 0; step < 2; ++step) {
        const V cube = root * root * root;
        root = root * (cube + (a + a)) / ((cube + cube) + a);
    }
    return root;
}

/// What truncate gives, and what a comparison does.
template <class V>
using int_lanes = decltype(truncate(V{}));
template <class V>
using mask_lanes = decltype(V{} < V{});

/// of(0), of(1), … in the lanes: faster than by way of memory.
template <class V, class Of>
[[nodiscard]] inline int_lanes<V> int_lanes_of(const Of& of) noexcept {
    return [&]<std::size_t... I>(std::index_sequence<I...>) { return int_lanes<V>{of(I)...}; }
    (std::make_index_sequence<lanes<V>::count>{});
}

/// 0, 1, 2, … in the lanes.
template <class V>
[[nodiscard]] inline V lane_numbers() noexcept {
    constexpr float numbers[max_lane_count] = {0, 1, 2,  3,  4,  5,  6,  7,
                                               8, 9, 10, 11, 12, 13, 14, 15};
    return lanes<V>::load(numbers);
}

}  // namespace billow::inline BILLOW_ABI::simd
