// Generated from include/billow by amalgamate.py, do not edit.
#pragma once

// ---- billow/billow.hpp
// All of billow but the reading and writing of files, which is in io.hpp.

// ---- billow/core/config.hpp
// What the compiler flags grant, and the inline namespace that keeps differently built objects apart.
//
// Two translation units built with other instruction sets hold other bodies of the same inline
// functions. The linker would silently keep one of them; with the tag in the name it keeps both.

// ---- billow/core/version.hpp
// The version of the library. CMakeLists.txt reads it from here, so it is written once.

#define BILLOW_VERSION_MAJOR 0
#define BILLOW_VERSION_MINOR 1
#define BILLOW_VERSION_PATCH 0
#define BILLOW_VERSION "0.1.0"

/// Define BILLOW_SCALAR to build without vector lanes: the reference that tests compare with.
#if defined(BILLOW_SCALAR) || !(defined(__GNUC__) || defined(__clang__))
#define BILLOW_LANES 1
#define BILLOW_ISA scalar
#elif defined(__AVX512F__)
#define BILLOW_LANES 16
#define BILLOW_ISA avx512
#elif defined(__AVX2__)
#define BILLOW_LANES 8
#define BILLOW_ISA avx2
#else
#define BILLOW_LANES 4  // SSE2, NEON, or what the compiler makes of four floats
#define BILLOW_ISA x4
#endif

#if defined(_OPENMP)
#define BILLOW_THREADING omp
#else
#define BILLOW_THREADING serial
#endif

#define BILLOW_DETAIL_JOIN_(a, b, c) a##_##b##_##c
#define BILLOW_DETAIL_JOIN(a, b, c) BILLOW_DETAIL_JOIN_(a, b, c)
#define BILLOW_ABI BILLOW_DETAIL_JOIN(v0, BILLOW_ISA, BILLOW_THREADING)

#define BILLOW_DETAIL_TEXT_(a) #a
#define BILLOW_DETAIL_TEXT(a) BILLOW_DETAIL_TEXT_(a)
/// The tag as text, e.g. "v0_avx2_omp".
#define BILLOW_ABI_NAME BILLOW_DETAIL_TEXT(BILLOW_ABI)

/// Checks what the caller must guarantee. Off with NDEBUG; define it yourself to replace it.
#ifndef BILLOW_ASSERT
#include <cassert>
#define BILLOW_ASSERT(condition) assert(condition)
#endif
// ---- billow/core/disjoint_sets.hpp
// Which of many things are one, learnt pair by pair.
//
// R. E. Tarjan: Efficiency of a good but not linear set union algorithm. Journal of the ACM 22, 1975.

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

// ---- billow/core/types.hpp
// The words that every layer shares: vectors and ids.

#include <cstddef>
#include <cstdint>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>


namespace billow::inline BILLOW_ABI {

using vec2 = glm::vec2;
using vec3 = glm::vec3;
using vec4 = glm::vec4;
using dvec2 = glm::dvec2;
using dvec3 = glm::dvec3;
using uvec3 = glm::uvec3;
using ivec2 = glm::ivec2;
using mat3 = glm::mat3;

using face_id = std::uint32_t;         ///< row of mesh::triangles
using plane_id = std::uint32_t;        ///< row of billboard_cloud::planes, in the order of discovery
using orientation_id = std::uint32_t;  ///< one normal of a plane space
using material_id = std::uint32_t;     ///< row of mesh::materials
using image_id = std::uint32_t;        ///< row of mesh::images
using atlas_id = std::uint32_t;        ///< row of baked_cloud::atlases
using part_id = std::uint32_t;         ///< row of billboard_cloud::parts

/// Says "none" for every kind of id.
inline constexpr std::uint32_t no_id = std::numeric_limits<std::uint32_t>::max();

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Sets of the numbers below `size`, each its own at first.
///
/// Cost   nearly O(1) a call. Differs from the source: the least member leads its set, so that the
///        result does not depend on the order of the calls.
class disjoint_sets {
public:
    explicit disjoint_sets(std::size_t size) : parent_(size) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }

    /// The least member of the set that holds `member`.
    [[nodiscard]] std::uint32_t leader(std::uint32_t member) noexcept {
        while (parent_[member] != member) {
            member = parent_[member] = parent_[parent_[member]];
        }
        return member;
    }
    /// Makes the sets of `a` and `b` one.
    void join(std::uint32_t a, std::uint32_t b) noexcept {
        const auto [least, other] = std::minmax({leader(a), leader(b)});
        parent_[other] = least;
    }
    /// Numbers the sets from 0 on, in the order of their least members: one number a member.
    [[nodiscard]] std::vector<std::uint32_t> numbers(std::size_t& set_count) {
        std::vector<std::uint32_t> number(parent_.size());
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < number.size(); ++i) {
            const std::uint32_t least = leader(i);
            number[i] = least == i ? count++ : number[least];
        }
        set_count = count;
        return number;
    }

private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/core/expected.hpp
// A value or the reason why there is none: for what the outside world can get wrong.

#include <string>
#include <utility>
#include <variant>


namespace billow::inline BILLOW_ABI {

/// What went wrong, for programs; error::message says it to people.
enum class error_code {
    not_found,        ///< the file is missing or cannot be opened
    unwritable,       ///< the output cannot be created or written
    truncated,        ///< the file ends before what it announces
    malformed,        ///< the file breaks the rules of its format
    unsupported,      ///< the file is well formed, but uses a feature that billow does not read
    not_finite,       ///< a position is NaN or infinite
    out_of_range,     ///< an index or offset points outside of what it indexes
    too_large,        ///< a size is beyond what can be handled
    invalid_options,  ///< an option is outside of its range
};

/// The reason of a failure. `message` is one line that names the fault and, for files, the file.
struct error {
    error_code code{};
    std::string message;
};

/// A T, or the error that prevented it. Spelled as std::expected of C++23, but ours in every
/// language version, so that objects built with different ones agree on the type.
template <class T>
class expected {
public:
    expected(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    expected(billow::error why) : state_(std::in_place_index<1>, std::move(why)) {}

    [[nodiscard]] bool has_value() const noexcept { return state_.index() == 0; }
    [[nodiscard]] explicit operator bool() const noexcept { return has_value(); }

    /// Needs has_value().
    [[nodiscard]] T& value() & noexcept { return *checked(); }
    [[nodiscard]] const T& value() const& noexcept {
        return *const_cast<expected*>(this)->checked();
    }
    [[nodiscard]] T&& value() && noexcept { return std::move(*checked()); }
    [[nodiscard]] T& operator*() & noexcept { return *checked(); }
    [[nodiscard]] const T& operator*() const& noexcept { return value(); }
    [[nodiscard]] T&& operator*() && noexcept { return std::move(*checked()); }
    [[nodiscard]] T* operator->() noexcept { return checked(); }
    [[nodiscard]] const T* operator->() const noexcept { return &value(); }

    /// Needs !has_value().
    [[nodiscard]] const billow::error& error() const noexcept {
        BILLOW_ASSERT(!has_value());
        return *std::get_if<1>(&state_);
    }

private:
    T* checked() noexcept {
        BILLOW_ASSERT(has_value());
        return std::get_if<0>(&state_);
    }

    std::variant<T, billow::error> state_;
};

/// Stands for "done" where an operation has no value to give.
struct done {};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/core/jobs.hpp
// Unequal jobs handed out one by one, each worker with buffers of its own.

#include <atomic>
#include <cstddef>
#include <vector>

// ---- billow/core/parallel.hpp
// The one place that knows OpenMP. Without it everything runs on the calling thread.

#include <algorithm>
#include <cstddef>


#if defined(_OPENMP)
#include <omp.h>
#endif

namespace billow::inline BILLOW_ABI {

/// How many threads a call may use. Results never depend on it: loops are cut into chunks of fixed
/// size, and what the chunks give is joined in their order.
struct parallel {
    unsigned threads = 0;  ///< 0: as many as the machine offers

    /// The number of threads that a loop will get.
    [[nodiscard]] unsigned count() const noexcept {
#if defined(_OPENMP)
        return threads != 0 ? threads : static_cast<unsigned>(std::max(1, omp_get_num_procs()));
#else
        return 1;
#endif
    }

    /// Calls `body(begin, end)` for the chunks [0, chunk), [chunk, 2 chunk), … of [0, size).
    /// `body` must not throw, and two chunks must not write to the same place.
    template <class Body>
    void for_chunks(std::size_t size, std::size_t chunk, const Body& body) const {
        BILLOW_ASSERT(chunk > 0);
        const auto chunk_count = static_cast<std::ptrdiff_t>((size + chunk - 1) / chunk);
        const auto run = [&](std::ptrdiff_t i) {
            const std::size_t begin = static_cast<std::size_t>(i) * chunk;
            body(begin, std::min(begin + chunk, size));
        };
#if defined(_OPENMP)
        if (count() > 1 && chunk_count > 1) {
#pragma omp parallel for schedule(dynamic) num_threads(static_cast <int>(count()))
            for (std::ptrdiff_t i = 0; i < chunk_count; ++i) run(i);
            return;
        }
#endif
        for (std::ptrdiff_t i = 0; i < chunk_count; ++i) run(i);
    }
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Calls `body(job, scratch)` once for every job of [0, job_count), in no fixed order. A scratch is
/// used by one job at a time, so that bodies need not allocate.
///
/// Needs  at least one scratch; no more threads run than there are scratches. `body` must not
///        throw, two jobs must not write to the same place, and what a job gives must not depend on
///        what its scratch held.
template <class Scratch, class Body>
void for_jobs(parallel threads, std::size_t job_count, std::vector<Scratch>& scratches,
              const Body& body) {
    BILLOW_ASSERT(!scratches.empty());
    std::atomic<std::size_t> next{0};
    threads.for_chunks(scratches.size(), 1, [&](std::size_t worker, std::size_t) {
        for (std::size_t job = next++; job < job_count; job = next++) body(job, scratches[worker]);
    });
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/core/progress.hpp
// How long work tells how far it is.

#include <functional>
#include <string_view>


namespace billow::inline BILLOW_ABI {

/// Called from the calling thread with the stage's name and the share of it that is done, 0 to 1.
/// An empty function asks for no reports.
using progress_function = std::function<void(std::string_view stage, double share)>;

/// Reports when somebody listens.
inline void report(const progress_function& progress, std::string_view stage, double share) {
    if (progress) progress(stage, share);
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/core/random.hpp
// Random numbers that depend on (seed, index) alone, so that threads and call order do not matter.
//
// The mixing function is the finalizer of SplitMix64: Steele, Lea, Flood, "Fast splittable
// pseudorandom number generators", OOPSLA 2014.

#include <cstdint>


namespace billow::inline BILLOW_ABI {

/// 64 well mixed bits of `value`.
[[nodiscard]] constexpr std::uint64_t mix_bits(std::uint64_t value) noexcept {
    value += 0x9e3779b97f4a7c15u;
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebu;
    return value ^ (value >> 31);
}

/// The index-th number of the stream `seed`, uniform in [0, 1).
[[nodiscard]] constexpr double random_unit(std::uint64_t seed, std::uint64_t index) noexcept {
    return static_cast<double>(mix_bits(mix_bits(seed) ^ (index * 0xd1342543de82ef95u)) >> 11) *
           0x1p-53;
}

/// A stream of numbers with a position: random_unit(seed, 0), random_unit(seed, 1), …
class random_stream {
public:
    explicit constexpr random_stream(std::uint64_t seed) noexcept : seed_(seed) {}

    /// Uniform in [0, 1).
    [[nodiscard]] constexpr double unit() noexcept { return random_unit(seed_, index_++); }
    /// Uniform in [low, high).
    [[nodiscard]] constexpr double between(double low, double high) noexcept {
        return low + (high - low) * unit();
    }

private:
    std::uint64_t seed_;
    std::uint64_t index_ = 0;
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/core/simd.hpp
// Vector lanes: the one place that knows how the compiler spells them.
//
// A kernel is written once with a lane type V. With V = float it is the scalar reference, with
// V = simd::wide it works on simd::lane_count faces at once. Functions are called qualified
// (simd::abs), since a bare abs would find the integer one.

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>


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

// ---- billow/geometry/bounds.hpp
// The bounding sphere that every tolerance refers to.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>


namespace billow::inline BILLOW_ABI {

/// Centre and radius of a sphere, in scene units.
struct bounding_sphere {
    dvec3 centre{0};
    double radius = 0;
};

/// The sphere around the centre of the axis-aligned box that holds the points point_at(0) …
/// point_at(count - 1); not always the smallest sphere. No points give centre and radius 0.
///
/// Source  Luksch 2009, section 4.1.
template <std::invocable<std::size_t> PointAt>
[[nodiscard]] bounding_sphere bounding_sphere_of(std::size_t count, const PointAt& point_at) {
    if (count == 0) return {};
    dvec3 low{std::numeric_limits<double>::infinity()};
    dvec3 high = -low;
    for (std::size_t i = 0; i < count; ++i) {
        const dvec3 point(point_at(i));
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
    const dvec3 centre = low + (high - low) * 0.5;
    double radius_sq = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const dvec3 offset = dvec3(point_at(i)) - centre;
        radius_sq = std::max(radius_sq, glm::dot(offset, offset));
    }
    return {centre, std::sqrt(radius_sq)};
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/geometry/frame.hpp
// Right-handed orthonormal frames on a plane.

#include <cmath>


namespace billow::inline BILLOW_ABI {

/// Three orthonormal axes with u × v = normal: seen from the tip of the normal, v is u turned by
/// 90° counter-clockwise.
struct frame {
    dvec3 u{1, 0, 0};
    dvec3 v{0, 1, 0};
    dvec3 normal{0, 0, 1};

    /// (u, v, height along the normal) of a scene vector.
    [[nodiscard]] dvec3 to_local(const dvec3& vector) const noexcept {
        return {glm::dot(u, vector), glm::dot(v, vector), glm::dot(normal, vector)};
    }
    /// The scene vector of (u, v, height along the normal).
    [[nodiscard]] dvec3 to_scene(const dvec3& local) const noexcept {
        return u * local.x + v * local.y + normal * local.z;
    }
};

/// Some frame around the unit vector `normal`; a continuous choice but for normal.z = 0.
///
/// Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
[[nodiscard]] inline frame frame_around(const dvec3& normal) noexcept {
    const double sign = std::copysign(1.0, normal.z);
    const double a = -1 / (sign + normal.z);
    const double b = normal.x * normal.y * a;
    return {.u = {1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x},
            .v = {b, sign + normal.y * normal.y * a, -normal.y},
            .normal = normal};
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/geometry/outline.hpp
// Convex polygons of few corners around a shape, within a rectangle.
//
// Persson, "Particle trimming", 2009, has the use: a billboard that is cut along its outline wastes
// fewer transparent fragments. He searches all corner sets; here corners are cut off one by one, and
// each cut is chosen again while that helps.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

// ---- billow/geometry/rectangle.hpp
// Convex hulls and rectangles of least area in the plane.
//
// Hull: Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979 (monotone
// chain). Rectangle: Toussaint, "Solving geometric problems with the rotating calipers", 1983.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// A rectangle that may be turned. `axis` runs along the width, the axis turned by 90°
/// counter-clockwise along the height.
struct oriented_rectangle {
    dvec2 axis{1, 0};    ///< unit length
    dvec2 low{0};        ///< least coordinates of the rectangle along the two axes
    dvec2 extent{0, 0};  ///< width and height, ≥ 0

    [[nodiscard]] dvec2 height_axis() const noexcept { return {-axis.y, axis.x}; }
    [[nodiscard]] double area() const noexcept { return extent.x * extent.y; }
};

namespace detail {

[[nodiscard]] inline double turn(const dvec2& a, const dvec2& b, const dvec2& c) noexcept {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

}  // namespace detail

/// The corners of the convex hull, counter-clockwise, without repeated or collinear ones.
///
/// Shape  `hull` has room for one more than `points`; `points` is reordered.
/// Needs  finite points.
/// Gives  number of corners at the front of `hull`: 0, 1 or 2 for none, one point, a segment.
/// Cost   O(n log n), no allocation.
inline std::size_t convex_hull(std::span<dvec2> points, std::span<dvec2> hull) {
    BILLOW_ASSERT(hull.size() > points.size());
    const auto before = [](const dvec2& a, const dvec2& b) {
        return a.x < b.x || (a.x == b.x && a.y < b.y);
    };
    std::sort(points.begin(), points.end(), before);
    const auto end = std::unique(points.begin(), points.end());
    points = points.first(static_cast<std::size_t>(end - points.begin()));
    if (points.size() < 3) {
        std::copy(points.begin(), points.end(), hull.begin());
        return points.size();
    }
    std::size_t size = 0;
    const auto push = [&](const dvec2& point, std::size_t floor) {
        while (size >= floor + 2 && detail::turn(hull[size - 2], hull[size - 1], point) <= 0) {
            --size;
        }
        hull[size++] = point;
    };
    for (const dvec2& point : points) push(point, 0);  // lower chain, left to right
    const std::size_t floor = size - 1;
    for (std::size_t i = points.size() - 1; i-- > 0;) push(points[i], floor);
    return size - 1;  // the first corner came again
}

/// The rectangle of least area around a convex polygon; one of its sides lies on a polygon's side.
/// A point gives zero extents, a segment zero height.
///
/// Needs  corners as convex_hull gives them.
/// Cost   O(n).
[[nodiscard]] inline oriented_rectangle minimum_rectangle(std::span<const dvec2> hull) {
    if (hull.empty()) return {};
    if (hull.size() == 1) return {.low = hull[0]};
    const std::size_t n = hull.size();
    const auto next = [n](std::size_t i) { return i + 1 == n ? 0 : i + 1; };
    // The corners farthest along the side, away from it and against it, carried around.
    std::size_t right = 0;
    std::size_t top = 0;
    std::size_t left = 0;
    oriented_rectangle best;
    double best_area = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n; ++i) {
        const dvec2 side = hull[next(i)] - hull[i];
        const double length = std::hypot(side.x, side.y);
        if (!(length > 0)) continue;
        const dvec2 x = side / length;
        const dvec2 y{-x.y, x.x};
        const auto advance = [&](std::size_t from, const dvec2& direction) {
            for (std::size_t steps = 0; steps < n; ++steps) {
                if (glm::dot(hull[next(from)] - hull[from], direction) <= 0) break;
                from = next(from);
            }
            return from;
        };
        right = advance(i == 0 ? next(0) : right, x);
        top = advance(i == 0 ? right : top, y);
        left = advance(i == 0 ? top : left, -x);
        const dvec2 low{glm::dot(hull[left], x), glm::dot(hull[i], y)};
        const dvec2 high{glm::dot(hull[right], x), glm::dot(hull[top], y)};
        const dvec2 extent = glm::max(high - low, dvec2(0));
        if (const double area = extent.x * extent.y; area < best_area) {
            best_area = area;
            best = {x, low, extent};
        }
    }
    return best;
}

/// The rectangle of least area around points in any order.
///
/// Cost  O(n log n).
[[nodiscard]] inline oriented_rectangle minimum_rectangle_of(std::vector<dvec2> points) {
    std::vector<dvec2> hull(points.size() + 1);
    const std::size_t corners = convex_hull(points, hull);
    return minimum_rectangle(std::span<const dvec2>(hull).first(corners));
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Twice the area of a polygon, positive when its corners are counter-clockwise.
[[nodiscard]] inline double doubled_area(std::span<const dvec2> polygon) noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const dvec2& a = polygon[i];
        const dvec2& b = polygon[i + 1 == polygon.size() ? 0 : i + 1];
        sum += a.x * b.y - a.y * b.x;
    }
    return sum;
}

namespace detail {

/// All points p with normal·p ≤ limit.
struct half_plane {
    dvec2 normal{0};
    double limit = 0;
};

using outline_corners = std::vector<dvec2>;

/// The part of a convex polygon within a half plane, corners closer than `slack` merged.
inline void cut_polygon(const outline_corners& from, const half_plane& keep, double slack,
                        outline_corners& to) {
    to.clear();
    const auto add = [&](const dvec2& p) {
        if (to.empty() || glm::distance(to.back(), p) > slack) to.push_back(p);
    };
    for (std::size_t i = 0; i < from.size(); ++i) {
        const dvec2& a = from[i];
        const dvec2& b = from[i + 1 == from.size() ? 0 : i + 1];
        const double above_a = glm::dot(keep.normal, a) - keep.limit;
        const double above_b = glm::dot(keep.normal, b) - keep.limit;
        if (above_a <= 0) add(a);
        if ((above_a < 0 && above_b > 0) || (above_a > 0 && above_b < 0)) {
            add(a + (b - a) * (above_a / (above_a - above_b)));
        }
    }
    while (to.size() > 1 && glm::distance(to.front(), to.back()) <= slack) to.pop_back();
}

/// The lines that touch the hull: along its sides, and at evenly spread directions.
[[nodiscard]] inline std::vector<half_plane> touching_lines(std::span<const dvec2> hull) {
    constexpr int direction_count = 64;
    std::vector<half_plane> lines;
    const auto touch = [&](const dvec2& normal) {
        double limit = -std::numeric_limits<double>::infinity();
        for (const dvec2& p : hull) limit = std::max(limit, glm::dot(normal, p));
        lines.push_back({normal, limit});
    };
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const dvec2 side = hull[i + 1 == hull.size() ? 0 : i + 1] - hull[i];
        if (const double length = glm::length(side); length > 0) {
            touch(dvec2(side.y, -side.x) / length);
        }
    }
    for (int i = 0; i < direction_count; ++i) {
        const double angle = 2 * std::numbers::pi * i / direction_count;
        touch({std::cos(angle), std::sin(angle)});
    }
    return lines;
}

}  // namespace detail

/// A convex polygon of at most `most_corners` corners that holds `hull` and lies within the rectangle
/// from `low` to `high`: the rectangle, cut along lines that touch the hull, each cut the one that
/// takes most area away.
///
/// Needs  hull: a convex polygon within the rectangle, corners counter-clockwise; most_corners ≥ 4.
/// Gives  corners counter-clockwise, never more area than the rectangle. The rectangle itself, where
///        the hull has no corner.
/// Cost   O(most_corners² · (n + 64)) clips of a small polygon.
/// Source Persson 2009, see above: greedy instead of exhaustive; the corners stay in the rectangle,
///        where a texture atlas holds other tiles beyond it.
[[nodiscard]] inline std::vector<dvec2> outline_polygon(std::span<const dvec2> hull,
                                                        const dvec2& low, const dvec2& high,
                                                        int most_corners) {
    BILLOW_ASSERT(most_corners >= 4);
    detail::outline_corners rectangle{low, {high.x, low.y}, high, {low.x, high.y}};
    if (hull.empty()) return rectangle;
    const double slack = 1e-9 * glm::distance(low, high);
    const std::vector<detail::half_plane> lines = detail::touching_lines(hull);
    const auto most = static_cast<std::size_t>(most_corners);

    detail::outline_corners cut;
    /// The line that leaves the least of `from`, within `room` corners.
    const auto best_cut = [&](const detail::outline_corners& from) {
        std::size_t best = lines.size();
        double least = doubled_area(from) * (1 - 1e-9);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            detail::cut_polygon(from, lines[i], slack, cut);
            if (cut.size() < 3 || cut.size() > most) continue;
            if (const double area = doubled_area(cut); area < least) least = area, best = i;
        }
        return best;
    };
    const auto polygon_of = [&](const std::vector<std::size_t>& cuts) {
        detail::outline_corners result = rectangle;
        for (const std::size_t i : cuts) {
            detail::cut_polygon(result, lines[i], slack, cut);
            std::swap(result, cut);
        }
        return result;
    };

    std::vector<std::size_t> cuts;
    detail::outline_corners result = rectangle;
    const auto extend = [&] {
        for (std::size_t i; cuts.size() < 2 * most && (i = best_cut(result)) < lines.size();) {
            cuts.push_back(i);
            result = polygon_of(cuts);
        }
    };
    extend();
    for (int round = 0; round < 4; ++round) {
        const double before = doubled_area(result);
        for (std::size_t drop = 0; drop < cuts.size(); ++drop) {
            const std::vector<std::size_t> kept_cuts = cuts;
            const detail::outline_corners kept = result;
            cuts.erase(cuts.begin() + static_cast<std::ptrdiff_t>(drop));
            result = polygon_of(cuts);
            if (result.size() <= most) extend();
            if (result.size() > most || doubled_area(result) >= doubled_area(kept)) {
                cuts = kept_cuts;
                result = kept;
            }
        }
        if (doubled_area(result) > before * (1 - 1e-6)) break;
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/geometry/plane.hpp
// Planes in Hesse normal form.


namespace billow::inline BILLOW_ABI {

/// The points x with normal·x = rho. `normal` has length 1.
///
/// (n, rho) and (-n, -rho) are the same plane; the canonical one has rho ≥ 0, so that its normal
/// points away from the origin. Differs from Luksch 2009, eq 3.1, whose sign of rho would turn the
/// penalty to the outer side.
struct plane {
    dvec3 normal{0, 0, 1};
    double rho = 0;  ///< signed distance of the plane to the origin, along the normal

    friend bool operator==(const plane&, const plane&) = default;
};

/// Distance of `point` to `p`, positive on the side the normal points to.
[[nodiscard]] inline double signed_distance(const plane& p, const dvec3& point) noexcept {
    return glm::dot(p.normal, point) - p.rho;
}

/// The same plane with rho ≥ 0.
[[nodiscard]] inline plane canonical(const plane& p) noexcept {
    return p.rho < 0 ? plane{-p.normal, -p.rho} : p;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/geometry/plane_intersection.hpp
// The point that several planes have in common, nearest to a given one.

#include <array>
#include <cmath>
#include <optional>
#include <span>


namespace billow::inline BILLOW_ABI {

/// The point nearest to `point` that lies on all of `planes`; nothing where their normals are
/// dependent, within a sine of 1e-3.
///
/// Needs   at most three planes with unit normals.
/// Source  Luksch 2009, section 3.3, asks for this point. Each step goes to the next plane along the
///         part of its normal that is orthogonal to the normals before, so that no plane is left.
[[nodiscard]] inline std::optional<dvec3> nearest_common_point(std::span<const plane> planes,
                                                               const dvec3& point) noexcept {
    BILLOW_ASSERT(planes.size() <= 3);
    constexpr double least_sine = 1e-3;
    std::array<dvec3, 3> steps;
    dvec3 at = point;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        dvec3 step = planes[i].normal;
        for (std::size_t k = 0; k < i; ++k) step -= steps[k] * glm::dot(steps[k], step);
        const double sine = glm::length(step);
        if (!(sine > least_sine)) return std::nullopt;
        steps[i] = step / sine;
        at -= steps[i] * (signed_distance(planes[i], at) / sine);
    }
    return at;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/geometry/ray_tree.hpp
// What a ray meets: triangles in a hierarchy of boxes, several boxes or triangles tested at once.
//
// Nodes as in Wald, Benthin, Boulos: Getting rid of packets. Symposium on Interactive Ray Tracing
// 2008. Built top down by the surface area heuristic in bins: Wald: On fast construction of SAH-based
// bounding volume hierarchies. Symposium on Interactive Ray Tracing 2007. Triangles as in Möller,
// Trumbore: Fast, minimum storage ray-triangle intersection. Journal of Graphics Tools 2(1), 1997.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// The points origin + t · direction with near ≤ t ≤ far.
struct ray {
    vec3 origin{0};
    vec3 direction{0, 0, 1};  ///< any length but 0
    float near = 0;           ///< ≥ 0
    float far = std::numeric_limits<float>::infinity();
};

/// Where a ray meets a triangle.
struct ray_hit {
    std::uint32_t triangle = no_id;                           ///< no_id: it meets none
    float distance = std::numeric_limits<float>::infinity();  ///< t
    float b = 0;                                              ///< weight of the second corner
    float c = 0;                                              ///< weight of the third corner

    [[nodiscard]] explicit operator bool() const noexcept { return triangle != no_id; }
};

/// Triangles, made ready for rays. It knows no mesh: triangles are numbers below a count.
class ray_tree {
public:
    /// Boxes of a node, and triangles of a leaf.
    static constexpr std::size_t width = std::max<std::size_t>(4, simd::lane_count);

    ray_tree() = default;

    /// Builds the tree of `count` triangles; corners_of(i) gives a std::array<vec3, 3>.
    ///
    /// Needs  finite corners. Triangles without area are never met.
    /// Cost   O(count log count), on the calling thread; some 100 bytes a triangle.
    template <class CornersOf>
    ray_tree(std::size_t count, const CornersOf& corners_of) {
        if (count == 0) return;
        std::vector<item> items(count);
        for (std::size_t i = 0; i < count; ++i) {
            const std::array<vec3, 3> p = corners_of(static_cast<std::uint32_t>(i));
            items[i].box = {glm::min(p[0], glm::min(p[1], p[2])),
                            glm::max(p[0], glm::max(p[1], p[2]))};
            items[i].triangle = static_cast<std::uint32_t>(i);
        }
        nodes_.reserve(count / 2);
        blocks_.reserve(count / 2);
        (void)add_node(items, 0, corners_of);
    }

    /// Whether a triangle stands in the ray's way. Where the ray meets one,
    /// is_there(triangle, b, c) tells whether anything is there; it must not throw.
    ///
    /// Cost   O(log count) where triangles are spread; allocates nothing.
    template <class V = simd::wide, class IsThere>
    [[nodiscard]] bool is_blocked(const ray& r, const IsThere& is_there) const noexcept {
        bool is_found = false;
        walk<V>(r, [&](const ray_hit& hit, float&) {
            return is_found = is_there(hit.triangle, hit.b, hit.c);
        });
        return is_found;
    }

    /// The first triangle on the ray's way that is there; of several at the same distance the one
    /// of lowest number.
    template <class V = simd::wide, class IsThere>
    [[nodiscard]] ray_hit closest(const ray& r, const IsThere& is_there) const noexcept {
        ray_hit first;
        walk<V>(r, [&](const ray_hit& hit, float& far) {
            const bool is_nearer =
                hit.distance < first.distance ||
                (hit.distance == first.distance && hit.triangle < first.triangle);
            if (is_nearer && is_there(hit.triangle, hit.b, hit.c)) {
                first = hit;
                far = hit.distance;
            }
            return false;
        });
        return first;
    }
    [[nodiscard]] ray_hit closest(const ray& r) const noexcept {
        return closest(r, [](std::uint32_t, float, float) { return true; });
    }

private:
    struct bounds3 {
        vec3 low{std::numeric_limits<float>::infinity()};
        vec3 high{-std::numeric_limits<float>::infinity()};

        void add(const bounds3& other) noexcept {
            low = glm::min(low, other.low);
            high = glm::max(high, other.high);
        }
        [[nodiscard]] float area() const noexcept {  // half of it
            const vec3 d = glm::max(high - low, vec3(0));
            return d.x * d.y + d.y * d.z + d.z * d.x;
        }
    };
    struct item {
        bounds3 box{};
        std::uint32_t triangle = no_id;

        [[nodiscard]] vec3 centre() const noexcept { return (box.low + box.high) * 0.5f; }
    };
    using lane_values = std::array<float, width>;
    /// A child is a node, or with the highest bit set a block; no_id is none, its box is empty.
    struct node {
        std::array<lane_values, 6> bounds;  ///< low x, high x, low y, …
        std::array<std::uint32_t, width> child;
    };
    struct block {
        std::array<lane_values, 9> value;  ///< first corner, then the edges from it to the others
        std::array<std::uint32_t, width> triangle;
    };
    static constexpr std::uint32_t block_bit = 0x80000000u;
    static constexpr int deepest_sah = 24;  // beyond it triangles are halved, whatever it costs
    static constexpr std::size_t stack_size = (deepest_sah + 32) * (width - 1) + 1;

    // --- Building -----------------------------------------------------------------------------

    struct part {
        std::span<item> items{};
        float cost = 0;  ///< of not splitting it
    };
    [[nodiscard]] static part part_of(std::span<item> items) noexcept {
        bounds3 box;
        for (const item& i : items) box.add(i.box);
        return {items, box.area() * static_cast<float>(items.size())};
    }

    template <class CornersOf>
    [[nodiscard]] std::uint32_t add_node(std::span<item> items, int depth,
                                         const CornersOf& corners_of) {
        const auto id = static_cast<std::uint32_t>(nodes_.size());
        nodes_.emplace_back();
        std::array<part, width> parts{part_of(items)};
        std::size_t count = 1;
        while (count < width) {
            std::size_t largest = width;
            const auto weight = [&](const part& p) {
                return depth < deepest_sah ? p.cost : static_cast<float>(p.items.size());
            };
            for (std::size_t i = 0; i < count; ++i) {
                if (parts[i].items.size() <= width) continue;
                if (largest == width || weight(parts[i]) > weight(parts[largest])) largest = i;
            }
            if (largest == width) break;
            const std::span<item> whole = parts[largest].items;
            const std::size_t left = depth < deepest_sah ? split_by_area(whole) : whole.size() / 2;
            parts[largest] = part_of(whole.first(left));
            parts[count++] = part_of(whole.subspan(left));
        }
        for (std::size_t k = 0; k < width; ++k) {
            bounds3 box;
            std::uint32_t child = no_id;
            if (k < count) {
                for (const item& i : parts[k].items) box.add(i.box);
                child = parts[k].items.size() <= width
                            ? add_block(parts[k].items, corners_of) | block_bit
                            : add_node(parts[k].items, depth + 1, corners_of);
            }
            node& to = nodes_[id];
            to.child[k] = child;
            for (int axis = 0; axis < 3; ++axis) {
                to.bounds[static_cast<std::size_t>(2 * axis)][k] = box.low[axis];
                to.bounds[static_cast<std::size_t>(2 * axis + 1)][k] = box.high[axis];
            }
        }
        return id;
    }

    template <class CornersOf>
    [[nodiscard]] std::uint32_t add_block(std::span<const item> items,
                                          const CornersOf& corners_of) {
        block b{};
        b.triangle.fill(no_id);
        for (std::size_t k = 0; k < items.size(); ++k) {
            const std::array<vec3, 3> p = corners_of(items[k].triangle);
            b.triangle[k] = items[k].triangle;
            for (std::size_t i = 0; i < 3; ++i) {
                const auto axis = static_cast<glm::length_t>(i);
                b.value[i][k] = p[0][axis];
                b.value[3 + i][k] = p[1][axis] - p[0][axis];
                b.value[6 + i][k] = p[2][axis] - p[0][axis];
            }
        }
        blocks_.push_back(b);
        return static_cast<std::uint32_t>(blocks_.size() - 1);
    }

    [[nodiscard]] static float blocks_for(std::size_t count) noexcept {
        const std::size_t blocks = (count + width - 1) / width;
        return static_cast<float>(blocks);
    }

    /// Sorts items to two sides of a plane between bins of centres; gives how many are on the left.
    [[nodiscard]] static std::size_t split_by_area(std::span<item> items) {
        constexpr std::size_t bin_count = 16;
        bounds3 centres;
        for (const item& i : items) centres.add({i.centre(), i.centre()});
        const vec3 extent = centres.high - centres.low;
        const int across = extent.y >= extent.z ? 1 : 2;
        const int widest = extent.x >= extent[across] ? 0 : across;
        const float scale = static_cast<float>(bin_count) / extent[widest];
        if (!std::isfinite(scale)) return items.size() / 2;  // all centres are one
        const auto bin_of = [&](const item& i) {
            const float bin = (i.centre()[widest] - centres.low[widest]) * scale;
            return std::min(static_cast<std::size_t>(bin), bin_count - 1);
        };
        std::array<bounds3, bin_count> boxes{};
        std::array<std::size_t, bin_count> counts{};
        for (const item& i : items) {
            const std::size_t bin = bin_of(i);
            boxes[bin].add(i.box);
            ++counts[bin];
        }
        std::array<float, bin_count> cost_of_right{};
        bounds3 right;
        std::size_t right_count = 0;
        for (std::size_t bin = bin_count; --bin > 0;) {
            right.add(boxes[bin]);
            right_count += counts[bin];
            cost_of_right[bin] = right.area() * blocks_for(right_count);
        }
        bounds3 left;
        std::size_t left_count = 0;
        std::size_t best = 1;
        float least = std::numeric_limits<float>::infinity();
        for (std::size_t bin = 1; bin < bin_count; ++bin) {
            left.add(boxes[bin - 1]);
            left_count += counts[bin - 1];
            const float cost = left.area() * blocks_for(left_count) + cost_of_right[bin];
            if (left_count > 0 && left_count < items.size() && cost < least) {
                least = cost;
                best = bin;
            }
        }
        const auto middle = std::partition(items.begin(), items.end(),
                                           [&](const item& i) { return bin_of(i) < best; });
        return static_cast<std::size_t>(middle - items.begin());
    }

    // --- Rays ---------------------------------------------------------------------------------

    template <class V>
    struct ray_lanes {
        std::array<V, 3> origin, direction, inverse;
        std::array<std::size_t, 3> near_side, far_side;  ///< rows of node::bounds
        V near;

        explicit ray_lanes(const ray& r) noexcept : near(simd::lanes<V>::fill(r.near)) {
            for (std::size_t i = 0; i < 3; ++i) {
                const auto axis = static_cast<glm::length_t>(i);
                const float d = r.direction[axis];
                // Never 0 · ∞ where the origin lies on the side of a box.
                const float safe = std::abs(d) > 1e-18f ? d : std::copysign(1e-18f, d);
                origin[i] = simd::lanes<V>::fill(r.origin[axis]);
                direction[i] = simd::lanes<V>::fill(d);
                inverse[i] = simd::lanes<V>::fill(1 / safe);
                near_side[i] = 2 * i + (safe < 0 ? 1 : 0);
                far_side[i] = 2 * i + (safe < 0 ? 0 : 1);
            }
        }
    };

    /// Where the ray enters each box; below 0 where it misses.
    template <class V>
    static void enter(const node& n, const ray_lanes<V>& r, float far,
                      lane_values& entry) noexcept {
        using lanes = simd::lanes<V>;
        for (std::size_t k = 0; k < width; k += lanes::count) {
            const auto at = [&](std::size_t row, std::size_t axis) {
                return (lanes::load(&n.bounds[row][k]) - r.origin[axis]) * r.inverse[axis];
            };
            const V first = simd::max(simd::max(at(r.near_side[0], 0), at(r.near_side[1], 1)),
                                      simd::max(at(r.near_side[2], 2), r.near));
            const V last = simd::min(simd::min(at(r.far_side[0], 0), at(r.far_side[1], 1)),
                                     simd::min(at(r.far_side[2], 2), lanes::fill(far)));
            // Rounding of the three products; Ize: Robust BVH ray traversal. JCGT 2(2), 2013.
            const V reach = last * lanes::fill(1 + 4e-7f);
            lanes::store(&entry[k], simd::select(first <= reach, first, lanes::fill(-1)));
        }
    }

    /// Where the ray meets each triangle; below 0 where it misses.
    template <class V>
    static void meet(const block& block, const ray_lanes<V>& r, lane_values& distance,
                     lane_values& b, lane_values& c) noexcept {
        using lanes = simd::lanes<V>;
        using vector = std::array<V, 3>;
        const auto cross = [](const vector& p, const vector& q) {
            return vector{p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2],
                          p[0] * q[1] - p[1] * q[0]};
        };
        const auto dot = [](const vector& p, const vector& q) {
            return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        };
        for (std::size_t k = 0; k < width; k += lanes::count) {
            const auto load = [&](std::size_t row) {
                return vector{lanes::load(&block.value[row][k]),
                              lanes::load(&block.value[row + 1][k]),
                              lanes::load(&block.value[row + 2][k])};
            };
            const vector corner = load(0);
            const vector e1 = load(3);
            const vector e2 = load(6);
            const vector p = cross(r.direction, e2);
            const V inverse = lanes::fill(1) / dot(e1, p);
            const vector s{r.origin[0] - corner[0], r.origin[1] - corner[1],
                           r.origin[2] - corner[2]};
            const V u = dot(s, p) * inverse;
            const vector q = cross(s, e1);
            const V v = dot(r.direction, q) * inverse;
            const V t = dot(e2, q) * inverse;
            // Between two triangles that share an edge no ray slips through. NaN, of triangles
            // without area, comes last and so stays.
            const V inside = simd::min(simd::min(u, v), lanes::fill(1) - (u + v));
            const V slack = lanes::fill(-2e-6f);
            lanes::store(&distance[k], simd::select(inside >= slack, t, lanes::fill(-1)));
            lanes::store(&b[k], u);
            lanes::store(&c[k], v);
        }
    }

    /// Calls on_hit(hit, far) for triangles on the ray's way, roughly from near to far, until it
    /// gives true. It may move `far` nearer.
    template <class V, class OnHit>
    void walk(const ray& r, const OnHit& on_hit) const noexcept {
        if (nodes_.empty()) return;
        struct entered {
            std::uint32_t child;
            float entry;
        };
        const ray_lanes<V> in_lanes(r);
        float far = r.far;
        std::array<entered, stack_size> stack;
        std::size_t size = 0;
        stack[size++] = {0, r.near};
        lane_values distance, b, c;
        while (size > 0) {
            const entered next = stack[--size];
            if (next.entry > far) continue;
            if ((next.child & block_bit) == 0) {
                const node& n = nodes_[next.child];
                enter(n, in_lanes, far, distance);
                const std::size_t first = size;
                for (std::size_t k = 0; k < width; ++k) {
                    if (distance[k] < 0) continue;
                    std::size_t at = size++;  // farthest first
                    for (; at > first && stack[at - 1].entry < distance[k]; --at) {
                        stack[at] = stack[at - 1];
                    }
                    stack[at] = {n.child[k], distance[k]};
                }
                continue;
            }
            const block& triangles = blocks_[next.child & ~block_bit];
            meet(triangles, in_lanes, distance, b, c);
            for (std::size_t k = 0; k < width; ++k) {
                if (!(distance[k] >= r.near && distance[k] <= far)) continue;
                if (on_hit(ray_hit{triangles.triangle[k], distance[k], b[k], c[k]}, far)) return;
            }
        }
    }

    std::vector<node> nodes_{};
    std::vector<block> blocks_{};
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/geometry/screen.hpp
// How many pixels a length covers on a screen.

#include <algorithm>
#include <cmath>
#include <numbers>


namespace billow::inline BILLOW_ABI {

/// A perspective camera, as far as levels of detail care.
struct lod_screen {
    double fov_y = std::numbers::pi / 3;  ///< vertical field of view, radians, in (0, pi)
    int width_px = 1920;
    int height_px = 1080;
    double near = 0.01;  ///< least distance to an object's surface that counts, scene units, > 0

    /// Pixels that a length of 1 covers at a distance of 1: cot(fov_y / 2) / 2 · height.
    [[nodiscard]] double pixels_at_one() const noexcept {
        return height_px / (2 * std::tan(fov_y / 2));
    }
};

/// Largest size on the screen of a displacement by `error` somewhere in a sphere of `radius` whose
/// centre is at `distance`: error / max(distance - radius, near) · cot(fov_y / 2) / 2 · height.
///
/// Unit   lengths in scene units; gives pixels.
[[nodiscard]] inline double pixels_of_error(double error, double radius, double distance,
                                            const lod_screen& screen) noexcept {
    return error / std::max(distance - radius, screen.near) * screen.pixels_at_one();
}

/// The largest displacement that covers at most `pixels` at a distance: the inverse of
/// pixels_of_error.
[[nodiscard]] inline double error_for_pixels(double pixels, double radius, double distance,
                                             const lod_screen& screen) noexcept {
    return pixels * std::max(distance - radius, screen.near) / screen.pixels_at_one();
}

/// The least distance to the centre from which `error` covers at most `pixels`: the inverse of
/// pixels_of_error. 0 where it never covers more.
///
/// Needs  pixels > 0.
[[nodiscard]] inline double distance_for_pixels(double error, double radius, double pixels,
                                                const lod_screen& screen) noexcept {
    const double to_surface = error * screen.pixels_at_one() / pixels;
    return to_surface > screen.near ? radius + to_surface : 0;
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/image/alpha_coverage.hpp
// How much of a picture an alpha test draws, and the factor on alpha that keeps it so.
//
// Castaño, "Computing alpha mipmaps", 2010, who counts samples of a whole texture. Here the area is
// that under bilinear filtering, as a graphics card draws it: a count of texels jumps, for on the
// first levels alpha has but a few values.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>


namespace billow::inline BILLOW_ABI {

/// Columns [x, x + width) and rows [y, y + height) of an alpha channel. Outside of them the nearest
/// texel of the block is read, as by a texture that is clamped.
struct alpha_block {
    std::span<const float> alpha{};  ///< 0 to 1, rows from top to bottom
    int stride = 0;                  ///< texels a row
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    [[nodiscard]] float at(int column, int row) const noexcept {
        const auto i = static_cast<std::size_t>(std::clamp(column, x, x + width - 1));
        const auto j = static_cast<std::size_t>(std::clamp(row, y, y + height - 1));
        return alpha[j * static_cast<std::size_t>(stride) + i];
    }
};

/// The area between `low` and `high` where alpha · scale, at most 1, is at least `cutoff` once it is
/// filtered bilinearly.
///
/// Unit   texels and texels squared; the texel of column 0 reaches from 0 to 1.
/// Needs  a block that is not empty; cutoff in (0, 1].
/// Cost   O(texels). Exact along x, four lines a texel along y.
[[nodiscard]] inline double drawn_area(const alpha_block& block, const dvec2& low,
                                       const dvec2& high, float scale, float cutoff) noexcept {
    constexpr int lines = 4;
    const auto first = [](double at) { return static_cast<int>(std::floor(at - 0.5)); };
    const auto last = [](double at) { return static_cast<int>(std::ceil(at - 0.5)) - 1; };
    const auto at = [&](int i, int j) { return std::min(1.0f, scale * block.at(i, j)); };
    double area = 0;
    // A cell lies between the middles of four texels.
    for (int j = first(low.y); j <= last(high.y); ++j) {
        const double top = std::max(0.0, low.y - (j + 0.5));
        const double height = std::min(1.0, high.y - (j + 0.5)) - top;
        float a = at(first(low.x), j);
        float b = at(first(low.x), j + 1);
        for (int i = first(low.x); i <= last(high.x); ++i) {
            const float c = at(i + 1, j);
            const float d = at(i + 1, j + 1);
            const double left = std::max(0.0, low.x - (i + 0.5));
            const double width = std::min(1.0, high.x - (i + 0.5)) - left;
            double share = 0;
            if (std::min({a, b, c, d}) >= cutoff) {
                share = 1;
            } else if (std::max({a, b, c, d}) >= cutoff) {
                for (int k = 0; k < lines; ++k) {
                    const double t = top + (k + 0.5) / lines * height;
                    const double from = a + (b - a) * t;
                    const double slope = c + (d - c) * t - from;
                    const double p = from + slope * left;
                    const double q = from + slope * (left + width);
                    if (std::min(p, q) >= static_cast<double>(cutoff)) {
                        share += 1.0 / lines;
                    } else if (std::max(p, q) > static_cast<double>(cutoff)) {
                        share += (std::max(p, q) - cutoff) / (std::abs(p - q) * lines);
                    }
                }
            }
            area += share * width * height;
            a = c;
            b = d;
        }
    }
    return area;
}

/// The factor on alpha with which drawn_area is nearest to `wanted`, found by bisection; 1 where
/// that is within a thousandth.
///
/// Cost   about 20 times drawn_area.
[[nodiscard]] inline float alpha_scale(const alpha_block& block, const dvec2& low,
                                       const dvec2& high, double wanted, float cutoff) noexcept {
    const auto excess = [&](float scale) {
        return drawn_area(block, low, high, scale, cutoff) - wanted;
    };
    const double plain = excess(1);
    if (std::abs(plain) <= 1e-3 * wanted) return 1;
    // Below `cutoff` nothing is drawn, above 255 all that a byte can hold.
    float less = plain < 0 ? 1.0f : cutoff;
    float more = plain < 0 ? 255.0f : 1.0f;
    for (int i = 0; i < 18; ++i) {
        const float middle = std::sqrt(less * more);
        (excess(middle) < 0 ? less : more) = middle;
    }
    return -excess(less) <= excess(more) ? less : more;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/image/distance_field.hpp
// Signed distance fields: alpha whose half value runs along an outline, however it is magnified.
//
// Green, "Improved alpha-tested magnification for vector textures and special effects", 2007.
// Differs: the outline is not taken from a larger binary picture but from the covered shares of the
// texels themselves, as the curve on which their bilinear mean crosses a threshold.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

namespace detail {

/// Distance of a point to a segment.
[[nodiscard]] inline double distance_to_segment(const dvec2& p, const dvec2& a,
                                                const dvec2& b) noexcept {
    const dvec2 along = b - a;
    const double length = glm::dot(along, along);
    const double share = length > 0 ? std::clamp(glm::dot(p - a, along) / length, 0.0, 1.0) : 0;
    return glm::distance(p, a + along * share);
}

/// Where the bilinear mean of four values crosses `level`: up to two segments in the unit square
/// whose corners (0,0), (1,0), (1,1), (0,1) hold `value`. Of the two ways to join four crossings the
/// one that the value in the middle asks for.
struct level_segments {
    std::array<std::array<dvec2, 2>, 2> segment{};
    std::size_t count = 0;

    level_segments(const std::array<double, 4>& value, double level) noexcept {
        static constexpr std::array<std::array<double, 2>, 4> at{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
        std::array<dvec2, 4> crossing;
        int crossings = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t j = (i + 1) % 4;
            if ((value[i] >= level) == (value[j] >= level)) continue;
            const double share = (level - value[i]) / (value[j] - value[i]);
            const dvec2 a{at[i][0], at[i][1]};
            const dvec2 b{at[j][0], at[j][1]};
            crossing[static_cast<std::size_t>(crossings++)] = a + (b - a) * share;
        }
        if (crossings == 2) {
            segment[count++] = {crossing[0], crossing[1]};
        } else if (crossings == 4) {
            const bool is_inside = (value[0] + value[1] + value[2] + value[3]) / 4 >= level;
            const std::size_t first = is_inside == (value[0] >= level) ? 0 : 1;
            // Around the corners that the middle does not belong to.
            segment[count++] = {crossing[first], crossing[first + 1]};
            segment[count++] = {crossing[first + 2], crossing[(first + 3) % 4]};
        }
    }
};

}  // namespace detail

/// Distance of each texel's centre to the outline of what is covered, in texels, positive inside, at
/// most `spread` either way. Beyond the grid nothing is covered.
///
/// Shape  `covered` and the result: width · height, rows from the top; shares in [0, 1].
/// Needs  0 < level < 1, spread > 0.
/// Cost   O(texels + outline · spread²).
[[nodiscard]] inline std::vector<float> signed_distances(std::span<const float> covered, int width,
                                                         int height, double level, double spread) {
    BILLOW_ASSERT(covered.size() ==
                  static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const auto index = [width](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    };
    const auto value = [&](int x, int y) {
        const bool is_in = x >= 0 && y >= 0 && x < width && y < height;
        return is_in ? static_cast<double>(covered[index(x, y)]) : 0.0;
    };
    std::vector<float> distance(covered.size(), static_cast<float>(spread));
    const int reach = static_cast<int>(std::ceil(spread));
    for (int y = -1; y < height; ++y) {
        for (int x = -1; x < width; ++x) {
            const std::array<double, 4> corner{value(x, y), value(x + 1, y), value(x + 1, y + 1),
                                               value(x, y + 1)};
            const detail::level_segments outline(corner, level);
            for (std::size_t s = 0; s < outline.count; ++s) {
                const dvec2 origin(x, y);
                const dvec2 a = origin + outline.segment[s][0];
                const dvec2 b = origin + outline.segment[s][1];
                for (int j = std::max(0, y - reach); j < std::min(height, y + 2 + reach); ++j) {
                    for (int i = std::max(0, x - reach); i < std::min(width, x + 2 + reach); ++i) {
                        float& least = distance[index(i, j)];
                        least = std::min(least, static_cast<float>(detail::distance_to_segment(
                                                    dvec2(i, j), a, b)));
                    }
                }
            }
        }
    }
    for (std::size_t i = 0; i < distance.size(); ++i) {
        if (static_cast<double>(covered[i]) < level) distance[i] = -distance[i];
    }
    return distance;
}

/// A signed distance as a byte: 0 at -spread, 255 at spread, and the threshold of a half between.
[[nodiscard]] inline std::uint8_t byte_from_distance(float distance, double spread) noexcept {
    const double share = 0.5 + 0.5 * static_cast<double>(distance) / spread;
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/image/image.hpp
// Images of bytes, and the two spaces that their colours live in.

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Pixels of 1 to 4 bytes, rows from top to bottom, pixels from left to right, channels together.
/// Whether the colours are sRGB or linear is said where an image is used.
struct image {
    int width = 0;
    int height = 0;
    int channels = 4;
    std::vector<std::uint8_t> bytes{};  ///< width * height * channels

    [[nodiscard]] static image filled(int width, int height, int channels, std::uint8_t value) {
        const auto size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                          static_cast<std::size_t>(channels);
        return {width, height, channels, std::vector<std::uint8_t>(size, value)};
    }

    [[nodiscard]] bool empty() const noexcept { return bytes.empty(); }
    /// First byte of the pixel in column x of row y.
    [[nodiscard]] const std::uint8_t* pixel(int x, int y) const noexcept {
        return bytes.data() + offset(x, y);
    }
    [[nodiscard]] std::uint8_t* pixel(int x, int y) noexcept { return bytes.data() + offset(x, y); }
    friend bool operator==(const image&, const image&) = default;

private:
    [[nodiscard]] std::size_t offset(int x, int y) const noexcept {
        BILLOW_ASSERT(x >= 0 && x < width && y >= 0 && y < height);
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels);
    }
};

/// Linear light of an sRGB value, both in [0, 1]. Source: IEC 61966-2-1.
[[nodiscard]] inline float linear_from_srgb(float value) noexcept {
    return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

/// sRGB value of linear light, both in [0, 1]. Source: IEC 61966-2-1.
[[nodiscard]] inline float srgb_from_linear(float value) noexcept {
    return value <= 0.0031308f ? value * 12.92f : 1.055f * std::pow(value, 1 / 2.4f) - 0.055f;
}

/// Linear light of each sRGB byte.
[[nodiscard]] inline const std::array<float, 256>& linear_of_srgb_byte() noexcept {
    static const auto table = [] {
        std::array<float, 256> values{};
        for (std::size_t i = 0; i < 256; ++i) {
            values[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
        }
        return values;
    }();
    return table;
}

/// The byte nearest to `value`, which is clamped to [0, 1].
[[nodiscard]] inline std::uint8_t byte_from_unit(float value) noexcept {
    const float clamped = value > 0 ? (value < 1 ? value : 1.0f) : 0.0f;  // NaN becomes 0
    return static_cast<std::uint8_t>(clamped * 255.0f + 0.5f);
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/image/mip_chain.hpp
// Ever smaller versions of an image, so that a texture seen from afar does not alias.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

// ---- billow/image/srgb.hpp
// The nearest sRGB byte of linear light, without a power for every pixel.

#include <array>
#include <cstddef>
#include <cstdint>


namespace billow::inline BILLOW_ABI {

namespace detail {

struct srgb_steps {
    std::array<float, 257> threshold{};     ///< linear light where byte i begins; the last: never
    std::array<std::uint8_t, 4097> hint{};  ///< largest byte that begins at or below i / 4096
};

[[nodiscard]] inline const srgb_steps& srgb_steps_table() noexcept {
    static const srgb_steps table = [] {
        srgb_steps steps;
        for (std::size_t i = 1; i < 256; ++i) {
            steps.threshold[i] = linear_from_srgb((static_cast<float>(i) - 0.5f) / 255.0f);
        }
        steps.threshold[256] = 2;
        std::size_t byte = 0;
        for (std::size_t i = 0; i < steps.hint.size(); ++i) {
            while (steps.threshold[byte + 1] <= static_cast<float>(i) / 4096.0f) ++byte;
            steps.hint[i] = static_cast<std::uint8_t>(byte);
        }
        return steps;
    }();
    return table;
}

}  // namespace detail

/// The sRGB byte nearest to linear light, which is clamped to [0, 1].
[[nodiscard]] inline std::uint8_t srgb_byte_from_linear(float value) noexcept {
    const detail::srgb_steps& steps = detail::srgb_steps_table();
    const float clamped = value > 0 ? (value < 1 ? value : 1.0f) : 0.0f;  // NaN becomes 0
    std::size_t byte = steps.hint[static_cast<std::size_t>(clamped * 4096.0f)];
    while (steps.threshold[byte + 1] <= clamped) ++byte;
    return static_cast<std::uint8_t>(byte);
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// What the bytes of an image mean when they are averaged.
enum class texel_kind {
    linear,      ///< every channel by itself
    srgb,        ///< colour in linear light
    srgb_alpha,  ///< colour in linear light, weighted by alpha: what is not there has no colour
};

namespace detail {

/// The source pixels under one smaller pixel along one axis, at most 3 as sizes are halved.
struct box_taps {
    int first = 0;
    int count = 0;
    std::array<float, 3> weight{};
};

[[nodiscard]] inline std::vector<box_taps> box_taps_of(int from, int to) {
    std::vector<box_taps> taps(static_cast<std::size_t>(to));
    const double scale = static_cast<double>(from) / to;
    for (int i = 0; i < to; ++i) {
        box_taps& t = taps[static_cast<std::size_t>(i)];
        const double low = i * scale;
        const double high = std::min<double>(from, (i + 1) * scale);
        t.first = std::min(static_cast<int>(low + 1e-9), from - 1);
        for (int k = 0; k < 3 && t.first + k < from; ++k) {
            const double share =
                std::min<double>(high, t.first + k + 1) - std::max<double>(low, t.first + k);
            if (share <= 1e-9) break;
            t.weight[static_cast<std::size_t>(k)] = static_cast<float>(share / (high - low));
            t.count = k + 1;
        }
    }
    return taps;
}

/// RGBA pixels in floats: linear light, straight alpha.
struct float_image {
    int width = 0;
    int height = 0;
    std::vector<std::array<float, 4>> pixels{};
};

[[nodiscard]] inline float_image halved(const float_image& from, bool is_alpha_weighted) {
    float_image to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
    const auto columns = box_taps_of(from.width, to.width);
    const auto rows = box_taps_of(from.height, to.height);
    to.pixels.reserve(columns.size() * rows.size());
    for (const box_taps& row : rows) {
        for (const box_taps& column : columns) {
            std::array<float, 4> plain{};
            std::array<float, 3> weighted{};
            for (int j = 0; j < row.count; ++j) {
                for (int i = 0; i < column.count; ++i) {
                    const auto& p = from.pixels[static_cast<std::size_t>(row.first + j) *
                                                    static_cast<std::size_t>(from.width) +
                                                static_cast<std::size_t>(column.first + i)];
                    const float w = row.weight[static_cast<std::size_t>(j)] *
                                    column.weight[static_cast<std::size_t>(i)];
                    for (std::size_t c = 0; c < 4; ++c) plain[c] += w * p[c];
                    for (std::size_t c = 0; c < 3; ++c) weighted[c] += w * p[3] * p[c];
                }
            }
            if (is_alpha_weighted && plain[3] > 0) {
                for (std::size_t c = 0; c < 3; ++c) plain[c] = weighted[c] / plain[3];
            }
            to.pixels.push_back(plain);
        }
    }
    return to;
}

[[nodiscard]] inline float_image float_image_of(const image& from, bool is_srgb) {
    float_image to{from.width, from.height, {}};
    const auto& light = linear_of_srgb_byte();
    const auto channels = static_cast<std::size_t>(from.channels);
    to.pixels.reserve(from.bytes.size() / channels);
    for (std::size_t at = 0; at + channels <= from.bytes.size(); at += channels) {
        const std::uint8_t* p = from.bytes.data() + at;
        const bool is_grey = channels < 3;
        const auto colour = [&](std::size_t c) {
            const std::uint8_t byte = p[is_grey ? 0 : c];
            return is_srgb ? light[byte] : static_cast<float>(byte) / 255.0f;
        };
        const bool has_alpha = channels == 2 || channels == 4;
        const float alpha = has_alpha ? static_cast<float>(p[channels - 1]) / 255.0f : 1.0f;
        to.pixels.push_back({colour(0), colour(1), colour(2), alpha});
    }
    return to;
}

[[nodiscard]] inline image bytes_of(const float_image& from, bool is_srgb) {
    image to = image::filled(from.width, from.height, 4, 0);
    std::uint8_t* byte = to.bytes.data();
    for (const auto& p : from.pixels) {
        for (std::size_t c = 0; c < 3; ++c) {
            *byte++ = is_srgb ? srgb_byte_from_linear(p[c]) : byte_from_unit(p[c]);
        }
        *byte++ = byte_from_unit(p[3]);
    }
    return to;
}

}  // namespace detail

/// RGBA images, the first one as large as `source`, each further one half as large as the one
/// before (rounded down), the last one 1 × 1. Grey is spread to three channels, missing alpha is 1.
///
/// Needs  a source of at least one pixel.
/// Cost   O(pixels); 16 bytes a pixel while it works.
[[nodiscard]] inline std::vector<image> make_mip_chain(const image& source, texel_kind kind) {
    BILLOW_ASSERT(!source.empty() && source.width > 0 && source.height > 0);
    const bool is_srgb = kind != texel_kind::linear;
    detail::float_image level = detail::float_image_of(source, is_srgb);
    std::vector<image> chain{source.channels == 4 ? source : detail::bytes_of(level, is_srgb)};
    while (level.width > 1 || level.height > 1) {
        level = detail::halved(level, kind == texel_kind::srgb_alpha);
        chain.push_back(detail::bytes_of(level, is_srgb));
    }
    return chain;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/image/nearest.hpp
// For every pixel the nearest pixel of a set, by exact Euclidean distance.
//
// Meijster, Roerdink, Hesselink, "A general algorithm for computing distance transforms in linear
// time", 2000, carried from distances to the pixels that they are measured to.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Buffers of nearest_pixels, reused between calls.
struct nearest_scratch {
    struct parabola {
        int x = 0;
        int y = 0;
        int begin = 0;  ///< first column that it is nearest to
    };
    std::vector<parabola> envelopes{};  ///< a row's worth for each chunk of rows
};

inline constexpr std::int32_t no_pixel = -1;

namespace detail {

inline constexpr std::size_t nearest_chunk = 64;  ///< rows, or columns, done together

}  // namespace detail

/// How many envelopes nearest_pixels needs.
[[nodiscard]] inline std::size_t nearest_scratch_size(int width, int height) noexcept {
    const std::size_t rows = static_cast<std::size_t>(height) + detail::nearest_chunk - 1;
    return static_cast<std::size_t>(width) * (rows / detail::nearest_chunk);
}

/// Fills `nearest[y * width + x]` with the index of the nearest pixel (y' * width + x') for which
/// `is_seed(x', y')`; with no_pixel everywhere when there is none. Of equally near ones the choice
/// is fixed, but no particular one.
///
/// Shape  `nearest`: width * height. `scratch`: grown as needed.
/// Needs  width * height < 2³¹.
/// Cost   O(pixels), parallel over columns and rows.
template <class IsSeed>
void nearest_pixels(int width, int height, const IsSeed& is_seed, std::span<std::int32_t> nearest,
                    nearest_scratch& scratch, parallel threads = {1}) {
    constexpr std::size_t chunk = detail::nearest_chunk;
    const auto w = static_cast<std::size_t>(width);
    const auto h = static_cast<std::size_t>(height);
    BILLOW_ASSERT(nearest.size() == w * h);
    const std::size_t envelopes = nearest_scratch_size(width, height);
    if (scratch.envelopes.size() < envelopes) scratch.envelopes.resize(envelopes);

    // First the row of the nearest seed in the same column, downwards, then upwards.
    threads.for_chunks(w, chunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = 0; y < h; ++y) {
            for (std::size_t x = begin; x < end; ++x) {
                nearest[y * w + x] = is_seed(static_cast<int>(x), static_cast<int>(y))
                                         ? static_cast<std::int32_t>(y)
                                         : (y > 0 ? nearest[(y - 1) * w + x] : no_pixel);
            }
        }
        for (std::size_t y = h - 1; y-- > 0;) {
            for (std::size_t x = begin; x < end; ++x) {
                const std::int32_t below = nearest[(y + 1) * w + x];
                const std::int32_t above = nearest[y * w + x];
                const auto row = static_cast<std::int32_t>(y);
                if (below != no_pixel && (above == no_pixel || below - row < row - above)) {
                    nearest[y * w + x] = below;
                }
            }
        }
    });

    // Then along each row the lower envelope of the parabolas (x - x')² + distance(x')².
    threads.for_chunks(h, chunk, [&](std::size_t begin, std::size_t end) {
        const std::span envelope = std::span(scratch.envelopes).subspan(begin / chunk * w, w);
        for (std::size_t y = begin; y < end; ++y) {
            const std::span row = nearest.subspan(y * w, w);
            const auto height_sq = [&](int x) {
                const auto d = static_cast<std::int64_t>(row[static_cast<std::size_t>(x)]) -
                               static_cast<std::int64_t>(y);
                return d * d;
            };
            std::size_t size = 0;
            for (int x = 0; x < width; ++x) {
                if (row[static_cast<std::size_t>(x)] == no_pixel) continue;
                int first = 0;
                while (size > 0) {
                    const int before = envelope[size - 1].x;
                    // The first column where x is nearer than `before`.
                    const std::int64_t gain = height_sq(x) - height_sq(before) +
                                              std::int64_t{x} * x - std::int64_t{before} * before;
                    const std::int64_t span = 2 * (std::int64_t{x} - before);
                    const std::int64_t meet = gain < 0 ? 0 : gain / span + 1;
                    if (meet > envelope[size - 1].begin) {
                        first = static_cast<int>(std::min<std::int64_t>(meet, width));
                        break;
                    }
                    --size;
                }
                if (first < width) envelope[size++] = {x, row[static_cast<std::size_t>(x)], first};
            }
            if (size == 0) continue;
            for (std::size_t i = 0; i < size; ++i) {
                const int last = i + 1 < size ? envelope[i + 1].begin : width;
                for (int x = envelope[i].begin; x < last; ++x) {
                    row[static_cast<std::size_t>(x)] = envelope[i].y * width + envelope[i].x;
                }
            }
        }
    });
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/image/raster.hpp
// Which samples of a grid a triangle covers.
//
// Edge functions after Pineda, "A parallel algorithm for polygon rasterization", SIGGRAPH 1988, in
// integers, so that two triangles along a shared edge never both take a sample nor both leave it.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>


namespace billow::inline BILLOW_ABI {

/// Columns [x_begin, x_end) and rows [y_begin, y_end) of a grid of samples. The sample (x, y) lies
/// at (x + 0.5, y + 0.5); y runs down.
struct sample_window {
    int x_begin = 0;
    int y_begin = 0;
    int x_end = 0;
    int y_end = 0;
};

/// A value that changes linearly over the grid: `base` at the sample (0, 0), `dx` more each column
/// and `dy` more each row.
struct affine_value {
    double base = 0;
    double dx = 0;
    double dy = 0;

    [[nodiscard]] double at(double x, double y) const noexcept { return base + dy * y + dx * x; }
};

namespace detail {

[[nodiscard]] constexpr std::int64_t floor_div(std::int64_t a, std::int64_t b) noexcept {
    return a / b - ((a % b != 0 && (a < 0) != (b < 0)) ? 1 : 0);
}
[[nodiscard]] constexpr std::int64_t ceil_div(std::int64_t a, std::int64_t b) noexcept {
    return -floor_div(-a, b);
}

}  // namespace detail

/// A triangle snapped to 1/256 of a sample. Its winding does not matter. A sample on an edge belongs
/// to the triangle for which the edge is a left or top one.
class raster_triangle {
public:
    /// Needs  finite corners in samples. Beyond ±2²¹ samples they are moved to that limit.
    explicit raster_triangle(const std::array<dvec2, 3>& corners) noexcept {
        for (std::size_t i = 0; i < 3; ++i) {
            x_[i] = snapped(corners[i].x);
            y_[i] = snapped(corners[i].y);
        }
        doubled_area_ = (x_[1] - x_[0]) * (y_[2] - y_[0]) - (x_[2] - x_[0]) * (y_[1] - y_[0]);
    }

    /// Whether the triangle covers nothing.
    [[nodiscard]] bool is_empty() const noexcept { return doubled_area_ == 0; }
    /// In samples.
    [[nodiscard]] double area() const noexcept {
        return std::abs(static_cast<double>(doubled_area_)) / (2.0 * unit * unit);
    }

    /// Calls `visit(y, x_begin, x_end)` for every row of samples that is covered within `window`.
    template <class Visit>
    void for_each_row(const sample_window& window, const Visit& visit) const {
        if (is_empty()) return;
        std::array<edge, 3> edges;
        for (std::size_t i = 0; i < 3; ++i) edges[i] = edge_from(i);
        const auto [y_low, y_high] = std::minmax({y_[0], y_[1], y_[2]});
        const auto [x_low, x_high] = std::minmax({x_[0], x_[1], x_[2]});
        const std::int64_t first = std::max<std::int64_t>(window.y_begin, first_centre(y_low));
        const std::int64_t last = std::min<std::int64_t>(window.y_end, last_centre(y_high) + 1);
        const std::int64_t left = std::max<std::int64_t>(window.x_begin, first_centre(x_low));
        const std::int64_t right = std::min<std::int64_t>(window.x_end, last_centre(x_high) + 1);
        for (std::int64_t y = first; y < last; ++y) {
            std::int64_t begin = left;
            std::int64_t end = right;
            for (const edge& e : edges) {
                const std::int64_t start = e.start + e.down * y;  // at x = 0; covered where ≥ 0
                if (e.across > 0) {
                    begin = std::max(begin, detail::ceil_div(-start, e.across));
                } else if (e.across < 0) {
                    end = std::min(end, detail::floor_div(start, -e.across) + 1);
                } else if (start < 0) {
                    end = begin;
                }
            }
            if (begin < end) {
                visit(static_cast<int>(y), static_cast<int>(begin), static_cast<int>(end));
            }
        }
    }

    /// Whether the triangle covers half a sample or more but is narrower than one, so that it may slip
    /// between them.
    [[nodiscard]] bool is_sliver() const noexcept {
        if (std::abs(doubled_area_) < unit * unit) return false;
        double longest_sq = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t k = i == 2 ? 0 : i + 1;
            const auto dx = static_cast<double>(x_[k] - x_[i]);
            const auto dy = static_cast<double>(y_[k] - y_[i]);
            longest_sq = std::max(longest_sq, dx * dx + dy * dy);
        }
        const auto width_by_longest = static_cast<double>(doubled_area_) / unit;
        return longest_sq > width_by_longest * width_by_longest;
    }

    /// Calls `visit(y, x, at)` for samples that a sliver owes: as many as its area, rounded up where
    /// its fraction exceeds 1 - `rounding`, is more than for_each_row takes. They lie along its
    /// longer axis, spread over the columns (or rows) where it takes none, and it passes through
    /// their squares at `at` (the sample (x, y) is at (x, y) there).
    ///
    /// Cost   O(samples along it), whatever the window.
    /// Source the promise is that of Fuhrmann et al. 2005, section 3.3.7. Differs: they enlarge the
    ///        buffer until every face covers a pixel.
    template <class Visit>
    void for_each_missing(const sample_window& window, double rounding, const Visit& visit) const {
        constexpr int limit = 1 << 22;
        std::int64_t owed = static_cast<std::int64_t>(area() + rounding);
        for_each_row({-limit, -limit, limit, limit},
                     [&](int, int begin, int end) { owed -= end - begin; });
        if (owed <= 0) return;
        const sliver_axis axis(*this);
        double free_area = 0;
        const auto is_free = [&](std::int64_t i) {
            const std::int64_t j = axis.middle_sample(i);
            return !axis.takes(i, j - 1) && !axis.takes(i, j) && !axis.takes(i, j + 1);
        };
        for (std::int64_t i = axis.first(); i <= axis.last(); ++i) {
            if (is_free(i)) free_area += axis.area_in(i);
        }
        if (!(free_area > 0)) return;
        const double rate = static_cast<double>(owed) / free_area;
        double due = 0.5;
        for (std::int64_t i = axis.first(); i <= axis.last(); ++i) {
            if (!is_free(i)) continue;
            due += rate * axis.area_in(i);
            if (due < 1) continue;
            due -= 1;
            const auto at = axis.is_tall ? std::pair(axis.middle_sample(i), i)
                                         : std::pair(i, axis.middle_sample(i));
            if (at.first >= window.x_begin && at.first < window.x_end &&
                at.second >= window.y_begin && at.second < window.y_end) {
                visit(static_cast<int>(at.second), static_cast<int>(at.first), axis.middle(i));
            }
        }
    }

    /// The value that is a, b, c at the corners. Needs !is_empty().
    [[nodiscard]] affine_value interpolate(double a, double b, double c) const noexcept {
        const double ux = static_cast<double>(x_[1] - x_[0]);
        const double uy = static_cast<double>(y_[1] - y_[0]);
        const double vx = static_cast<double>(x_[2] - x_[0]);
        const double vy = static_cast<double>(y_[2] - y_[0]);
        const double scale = unit / static_cast<double>(doubled_area_);
        affine_value value;
        value.dx = ((b - a) * vy - (c - a) * uy) * scale;
        value.dy = ((c - a) * ux - (b - a) * vx) * scale;
        const double x = 0.5 - static_cast<double>(x_[0]) / unit;
        const double y = 0.5 - static_cast<double>(y_[0]) / unit;
        value.base = a + value.dx * x + value.dy * y;
        return value;
    }

private:
    static constexpr std::int64_t unit = 256;

    /// covered(x, y) = start + across * x + down * y ≥ 0 for sample columns and rows.
    struct edge {
        std::int64_t start = 0;
        std::int64_t across = 0;
        std::int64_t down = 0;
    };

    /// A triangle along its longer axis, in samples: i counts them along it, j across.
    struct sliver_axis {
        const raster_triangle& of;
        bool is_tall;
        std::array<edge, 3> edges{};
        std::array<dvec2, 3> corner{};  ///< (along, across), ascending along

        explicit sliver_axis(const raster_triangle& triangle) noexcept : of(triangle) {
            const auto [x_low, x_high] = std::minmax({of.x_[0], of.x_[1], of.x_[2]});
            const auto [y_low, y_high] = std::minmax({of.y_[0], of.y_[1], of.y_[2]});
            is_tall = y_high - y_low > x_high - x_low;
            for (std::size_t k = 0; k < 3; ++k) {
                edges[k] = of.edge_from(k);
                const dvec2 p = dvec2(of.x_[k], of.y_[k]) / static_cast<double>(unit);
                corner[k] = is_tall ? dvec2(p.y, p.x) : p;
            }
            std::sort(corner.begin(), corner.end(),
                      [](const dvec2& a, const dvec2& b) { return a.x < b.x; });
        }

        [[nodiscard]] std::int64_t first() const noexcept {
            return static_cast<std::int64_t>(std::floor(corner[0].x));
        }
        [[nodiscard]] std::int64_t last() const noexcept {
            return static_cast<std::int64_t>(std::ceil(corner[2].x)) - 1;
        }
        [[nodiscard]] bool takes(std::int64_t i, std::int64_t j) const noexcept {
            const std::int64_t x = is_tall ? j : i;
            const std::int64_t y = is_tall ? i : j;
            const auto is_inside = [&](const edge& e) {
                return e.start + e.across * x + e.down * y >= 0;
            };
            return std::all_of(edges.begin(), edges.end(), is_inside);
        }

        /// Halfway across, above the middle of column i or the end next to it.
        [[nodiscard]] dvec2 middle_of(std::int64_t i) const noexcept {
            const double at = std::clamp(static_cast<double>(i) + 0.5, corner[0].x, corner[2].x);
            const auto between = [at](const dvec2& a, const dvec2& b) {
                return b.x > a.x ? a.y + (b.y - a.y) * ((at - a.x) / (b.x - a.x)) : b.y;
            };
            const double near =
                at < corner[1].x ? between(corner[0], corner[1]) : between(corner[1], corner[2]);
            return {at, 0.5 * (between(corner[0], corner[2]) + near)};
        }
        [[nodiscard]] std::int64_t middle_sample(std::int64_t i) const noexcept {
            return static_cast<std::int64_t>(std::floor(middle_of(i).y));
        }
        [[nodiscard]] dvec2 middle(std::int64_t i) const noexcept {
            const dvec2 p = middle_of(i) - 0.5;
            return is_tall ? dvec2(p.y, p.x) : p;
        }

        [[nodiscard]] double area_in(std::int64_t i) const noexcept {
            return area_before(static_cast<double>(i) + 1) - area_before(static_cast<double>(i));
        }
        [[nodiscard]] double area_before(double at) const noexcept {
            const double low = corner[0].x;
            const double high = corner[2].x;
            const double peak = corner[1].x;
            const double area = of.area();
            if (at <= low) return 0;
            if (at >= high) return area;
            const double scale = area / (high - low);
            return at < peak ? scale * (at - low) * (at - low) / (peak - low)
                             : area - scale * (high - at) * (high - at) / (high - peak);
        }
    };

    [[nodiscard]] static std::int64_t snapped(double value) noexcept {
        constexpr double limit = 2097152.0;  // 2²¹: edge products stay below 2⁶²
        return static_cast<std::int64_t>(std::floor(std::clamp(value, -limit, limit) * unit + 0.5));
    }
    [[nodiscard]] static std::int64_t first_centre(std::int64_t at) noexcept {
        return detail::ceil_div(at - unit / 2, unit);
    }
    [[nodiscard]] static std::int64_t last_centre(std::int64_t at) noexcept {
        return detail::floor_div(at - unit / 2, unit);
    }

    [[nodiscard]] edge edge_from(std::size_t i) const noexcept {
        std::size_t from = i;
        std::size_t to = i == 2 ? 0 : i + 1;
        if (doubled_area_ < 0) std::swap(from, to);
        const std::int64_t dx = x_[to] - x_[from];
        const std::int64_t dy = y_[to] - y_[from];
        const bool is_top_left = dy < 0 || (dy == 0 && dx > 0);
        // dx (y - y0) - dy (x - x0) at the sample centres, one less where the edge is excluded.
        const std::int64_t start = dx * (unit / 2 - y_[from]) - dy * (unit / 2 - x_[from]);
        return {start - (is_top_left ? 0 : 1), -dy * unit, dx * unit};
    }

    std::array<std::int64_t, 3> x_{};
    std::array<std::int64_t, 3> y_{};
    std::int64_t doubled_area_ = 0;
};

}  // namespace billow::inline BILLOW_ABI

// ---- billow/mesh/append_mesh.hpp
// Two meshes as one.

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

// ---- billow/mesh/mesh.hpp
// The mesh that readers deliver, planes are searched in, textures are baked from and writers store.

#include <array>
#include <span>
#include <string>
#include <vector>

// ---- billow/mesh/material.hpp
// How a surface looks: the metallic-roughness model of glTF 2.0, which OBJ materials are mapped to.

#include <string>


namespace billow::inline BILLOW_ABI {

/// What a texture coordinate beyond [0, 1] means.
enum class texture_wrap { repeat, mirrored_repeat, clamp_to_edge };

/// An image as a material uses it. Texture coordinates start at the top left, as in glTF.
struct texture {
    image_id image = no_id;    ///< no_id: no texture, the factor stands alone
    std::uint32_t uv_set = 0;  ///< row of mesh::uv_sets
    texture_wrap wrap_u = texture_wrap::repeat;
    texture_wrap wrap_v = texture_wrap::repeat;
    bool is_nearest = false;  ///< magnification takes the nearest texel, not a bilinear mean
    /// uv' = (m[0] u + m[1] v + m[2]) of KHR_texture_transform, columns m.
    mat3 transform{1};

    [[nodiscard]] bool is_present() const noexcept { return image != no_id; }
};

enum class alpha_mode {
    opaque,  ///< alpha is ignored
    mask,    ///< a point is there when its alpha ≥ alpha_cutoff
    blend,   ///< alpha is the covered share
};

struct material {
    std::string name{};
    vec4 base_color{1};            ///< linear RGBA, multiplies texture and vertex colour
    texture base_color_texture{};  ///< sRGB, straight alpha
    float metallic = 1;            ///< multiplies the texture's blue
    float roughness = 1;           ///< multiplies the texture's green
    texture metallic_roughness_texture{};
    texture normal_texture{};  ///< tangent space, right-handed, y up
    float normal_scale = 1;
    texture occlusion_texture{};  ///< red: share of the surroundings that is visible
    float occlusion_strength = 1;
    vec3 emissive{0};            ///< linear RGB, multiplies the texture
    texture emissive_texture{};  ///< sRGB
    alpha_mode alpha = alpha_mode::opaque;
    float alpha_cutoff = 0.5f;  ///< of alpha_mode::mask
    bool is_double_sided = false;
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

inline constexpr std::size_t uv_set_count = 2;

/// An indexed triangle list in columns. Counter-clockwise triangles are seen from their front.
///
/// Shape  V vertices, F faces. Vertex columns hold V rows, or none where the mesh lacks the
///        attribute; face columns hold F rows.
/// Unit   positions in scene units, right-handed; colours linear.
struct mesh {
    std::vector<vec3> positions{};
    std::vector<vec3> normals{};   ///< unit length; none: every face is flat
    std::vector<vec4> tangents{};  ///< xyz unit length, w = ±1 the side of the bitangent
    std::array<std::vector<vec2>, uv_set_count> uv_sets{};
    std::vector<vec4> colors{};                ///< linear RGBA, multiplies the base colour
    std::vector<std::uint32_t> feature_ids{};  ///< of a cloud's vertices: the plane they lie on

    std::vector<uvec3> triangles{};
    std::vector<material_id> face_materials{};  ///< none: all faces use material 0

    std::vector<material> materials{};  ///< none: everything is white, rough and opaque
    std::vector<image> images{};

    [[nodiscard]] std::size_t vertex_count() const noexcept { return positions.size(); }
    [[nodiscard]] std::size_t face_count() const noexcept { return triangles.size(); }

    /// The three corners of a face.
    [[nodiscard]] std::array<vec3, 3> corners(face_id face) const noexcept {
        const uvec3 t = triangles[face];
        return {positions[t.x], positions[t.y], positions[t.z]};
    }

    /// The material of a face; a plain white one where the mesh has none.
    [[nodiscard]] const material& material_of(face_id face) const noexcept {
        static const material plain{.metallic = 0};
        const material_id id = face_materials.empty() ? 0 : face_materials[face];
        return id < materials.size() ? materials[id] : plain;
    }
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/mesh/select_faces.hpp
// Some faces of a mesh as a mesh of their own.

#include <array>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

namespace detail {

/// Calls `visit(column of a, column of b)` for each column that has one row a vertex, positions first.
template <class A, class B, class Visit>
void for_each_vertex_column(A& a, B& b, const Visit& visit) {
    visit(a.positions, b.positions);
    visit(a.normals, b.normals);
    visit(a.tangents, b.tangents);
    for (std::size_t i = 0; i < uv_set_count; ++i) visit(a.uv_sets[i], b.uv_sets[i]);
    visit(a.colors, b.colors);
    visit(a.feature_ids, b.feature_ids);
}

/// The textures of a material, constant or not.
template <class Material>
[[nodiscard]] auto textures_of(Material& m) {
    return std::array{&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture,
                      &m.occlusion_texture, &m.emissive_texture};
}

/// Gives `value` its place in `order`, where it is new.
inline std::uint32_t place_of(std::uint32_t value, std::vector<std::uint32_t>& places,
                              std::vector<std::uint32_t>& order) {
    std::uint32_t& place = places[value];
    if (place == no_id) {
        place = static_cast<std::uint32_t>(order.size());
        order.push_back(value);
    }
    return place;
}

}  // namespace detail

/// The given faces, with the vertices, materials and images that they use and no others; what is
/// copied is copied bit by bit.
///
/// Shape   faces in the given order; vertices, materials and images in the order of first use.
/// Needs   face ids below m.face_count(); indices of `m` within bounds.
/// Cost    O(vertices of `m` + faces + pixels in use).
[[nodiscard]] inline mesh select_faces(const mesh& m, std::span<const face_id> faces) {
    mesh result;
    std::vector<std::uint32_t> vertices;
    std::vector<std::uint32_t> materials;
    std::vector<std::uint32_t> images;
    std::vector<std::uint32_t> new_vertex(m.vertex_count(), no_id);
    std::vector<std::uint32_t> new_material(m.materials.size(), no_id);
    std::vector<std::uint32_t> new_image(m.images.size(), no_id);
    result.triangles.reserve(faces.size());
    for (const face_id face : faces) {
        uvec3 triangle = m.triangles[face];
        for (int k = 0; k < 3; ++k) {
            triangle[k] = detail::place_of(triangle[k], new_vertex, vertices);
        }
        result.triangles.push_back(triangle);
        const material_id id = m.face_materials.empty() ? 0 : m.face_materials[face];
        result.face_materials.push_back(
            id < m.materials.size() ? detail::place_of(id, new_material, materials) : no_id);
    }
    detail::for_each_vertex_column(m, result, [&](const auto& from, auto& to) {
        if (from.empty()) return;
        to.reserve(vertices.size());
        for (const std::uint32_t v : vertices) to.push_back(from[v]);
    });
    for (const std::uint32_t id : materials) {
        result.materials.push_back(m.materials[id]);
        for (texture* t : detail::textures_of(result.materials.back())) {
            t->image =
                t->image < m.images.size() ? detail::place_of(t->image, new_image, images) : no_id;
        }
    }
    for (const std::uint32_t id : images) result.images.push_back(m.images[id]);
    return result;
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Where normals lack, gives every face corners of its own and its flat normal.
inline void make_normals(mesh& m) {
    if (!m.normals.empty()) return;
    const mesh shared = m;
    detail::for_each_vertex_column(shared, m, [&](const auto& from, auto& to) {
        if (from.empty()) return;
        to.clear();
        to.reserve(3 * shared.face_count());
        for (const uvec3& t : shared.triangles) {
            for (int k = 0; k < 3; ++k) to.push_back(from[t[k]]);
        }
    });
    for (face_id face = 0; face < m.face_count(); ++face) {
        m.triangles[face] = uvec3(0, 1, 2) + 3u * face;
        const auto [a, b, c] = m.corners(face);
        const dvec3 cross = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
        const double length = glm::length(cross);
        m.normals.insert(m.normals.end(), 3, vec3(length > 0 ? cross / length : dvec3(0, 0, 1)));
    }
}

/// Whether shading needs tangents that are not there.
[[nodiscard]] inline bool lacks_tangents(const mesh& m) noexcept {
    return m.tangents.empty() && std::ranges::any_of(m.materials, [](const material& look) {
               return look.normal_texture.is_present();
           });
}

/// Appends rows, with `plain` for those that one side lacks. None where both do.
template <class T>
void append_rows(std::vector<T>& to, std::size_t to_count, const std::vector<T>& from,
                 std::size_t from_count, const T& plain) {
    if (to.empty() && from.empty()) return;
    if (to.empty()) to.assign(to_count, plain);
    to.insert(to.end(), from.begin(), from.end());
    to.resize(to_count + from_count, plain);
}

}  // namespace detail

/// Adds the faces of `from` behind those of `to`, with their own vertices, materials and images.
///
/// Gives   attributes that one of them lacks are filled: flat normals, which unshares vertices; uvs
///         of 0; white. Tangents stay only where nobody misses them, a viewer derives them from the
///         uvs. Where one has feature ids, the other one's vertices get those of
///         `plain_feature`.
/// Cost    O(vertices + faces + pixels) of `from`.
inline void append_mesh(mesh& to, mesh from, std::uint32_t plain_feature = 0) {
    if (to.vertex_count() > 0 && from.vertex_count() > 0) {
        if (!to.normals.empty()) detail::make_normals(from);
        if (!from.normals.empty()) detail::make_normals(to);
        if (detail::lacks_tangents(to) || detail::lacks_tangents(from)) {
            to.tangents.clear();
            from.tangents.clear();
        }
    }
    const std::size_t before = to.vertex_count();
    const std::size_t more = from.vertex_count();
    const auto append = [&](auto& rows, const auto& new_rows, const auto& plain) {
        detail::append_rows(rows, before, new_rows, more, plain);
    };
    append(to.normals, from.normals, vec3(0, 0, 1));
    append(to.tangents, from.tangents, vec4(1, 0, 0, 1));
    for (std::size_t i = 0; i < uv_set_count; ++i) append(to.uv_sets[i], from.uv_sets[i], vec2(0));
    append(to.colors, from.colors, vec4(1));
    append(to.feature_ids, from.feature_ids, plain_feature);
    append(to.positions, from.positions, vec3(0));

    // A face beyond the last material is plain; it stays so whatever comes behind.
    const auto material_ids = [](const mesh& m, std::size_t offset) {
        std::vector<material_id> ids(m.face_count(), 0);
        if (!m.face_materials.empty()) ids = m.face_materials;
        for (material_id& id : ids) {
            id = id < m.materials.size() ? id + static_cast<material_id>(offset) : no_id;
        }
        return ids;
    };
    std::vector<material_id> materials = material_ids(to, 0);
    const std::vector<material_id> new_materials = material_ids(from, to.materials.size());
    materials.insert(materials.end(), new_materials.begin(), new_materials.end());
    to.face_materials = std::move(materials);
    for (const uvec3& t : from.triangles) {
        to.triangles.push_back(t + static_cast<std::uint32_t>(before));
    }
    for (material& look : from.materials) {
        for (texture* t : detail::textures_of(look)) {
            if (t->is_present()) t->image += static_cast<image_id>(to.images.size());
        }
        to.materials.push_back(std::move(look));
    }
    std::ranges::move(from.images, std::back_inserter(to.images));
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/mesh/components.hpp
// The pieces that a mesh falls into: faces that hang together by shared vertices.

#include <algorithm>
#include <limits>
#include <vector>

// ---- billow/mesh/vertex_identity.hpp
// Which vertices are one: those at the same place, across seams of normals and uvs.

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

// ---- billow/mesh/face_table.hpp
// The faces of a mesh as the plane search reads them: columns of floats around the origin.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

// ---- billow/mesh/validate.hpp
// The door that a mesh of unknown origin passes before anything trusts it.

#include <atomic>
#include <cmath>
#include <string>


namespace billow::inline BILLOW_ABI {

/// Checks that every corner of every face exists and is finite, and that columns have their rows.
///
/// Fails   out_of_range: a corner, or a column of the wrong length; not_finite: a position. The
///         message names the first such face. Degenerate faces are fine, so is a mesh of none.
/// Cost    O(faces), parallel.
[[nodiscard]] inline expected<done> validate(const mesh& m, const parallel& threads = {}) {
    const std::size_t vertex_count = m.vertex_count();
    const auto has_rows = [](const auto& column, std::size_t rows) {
        return column.empty() || column.size() == rows;
    };
    if (!has_rows(m.normals, vertex_count) || !has_rows(m.tangents, vertex_count) ||
        !has_rows(m.uv_sets[0], vertex_count) || !has_rows(m.uv_sets[1], vertex_count) ||
        !has_rows(m.colors, vertex_count) || !has_rows(m.feature_ids, vertex_count)) {
        return error{error_code::out_of_range, "a vertex attribute has not one value a vertex"};
    }
    if (!has_rows(m.face_materials, m.face_count())) {
        return error{error_code::out_of_range, "there is not one material id a face"};
    }
    if (m.face_count() >= no_id || vertex_count >= no_id) {
        return error{error_code::too_large, "more than 2^32 - 2 faces or vertices"};
    }

    const auto is_out_of_range = [&](std::size_t face) {
        const uvec3 t = m.triangles[face];
        return t.x >= vertex_count || t.y >= vertex_count || t.z >= vertex_count;
    };
    const auto is_bad = [&](std::size_t face) {
        if (is_out_of_range(face)) return true;
        for (const vec3& p : m.corners(static_cast<face_id>(face))) {
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return true;
        }
        return false;
    };

    std::atomic<std::size_t> first_bad{m.face_count()};
    threads.for_chunks(m.face_count(), 1 << 15, [&](std::size_t begin, std::size_t end) {
        for (std::size_t face = begin; face < end; ++face) {
            if (!is_bad(face)) continue;
            std::size_t known = first_bad.load();
            while (face < known && !first_bad.compare_exchange_weak(known, face)) {
            }
            return;
        }
    });

    const std::size_t face = first_bad.load();
    if (face == m.face_count()) return done{};
    if (is_out_of_range(face)) {
        return error{error_code::out_of_range, "face " + std::to_string(face) +
                                                   " has a corner beyond the last of " +
                                                   std::to_string(vertex_count) + " vertices"};
    }
    return error{error_code::not_finite,
                 "face " + std::to_string(face) + " has a position that is NaN or infinite"};
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Three columns: the coordinates of one point or vector a face.
struct columns3 {
    std::vector<float> x{}, y{}, z{};

    void resize(std::size_t size) { x.resize(size), y.resize(size), z.resize(size); }
    void set(std::size_t row, const dvec3& value) noexcept {
        x[row] = static_cast<float>(value.x);
        y[row] = static_cast<float>(value.y);
        z[row] = static_cast<float>(value.z);
    }
    [[nodiscard]] dvec3 get(std::size_t row) const noexcept { return {x[row], y[row], z[row]}; }
};

/// The faces of a mesh that have an area.
///
/// Shape  `size` rows, padded to the widest lane with faces of area 0, so that kernels have no tail
///        and padding adds nothing to a sum.
/// Unit   scene units, relative to bounds.centre; a coordinate is off by at most 6e-8 radii.
struct face_table {
    bounding_sphere bounds{};
    std::size_t size = 0;
    std::array<columns3, 3> corner{};
    columns3 normal{};  ///< unit length, by the right-hand rule
    std::vector<float> area{};
    std::vector<float> reach{};         ///< distance of the farthest corner to the origin
    std::vector<face_id> source{};      ///< the face of the mesh, `size` rows
    std::vector<face_id> degenerate{};  ///< faces of the mesh that were set aside

    [[nodiscard]] std::size_t padded_size() const noexcept { return area.size(); }
    [[nodiscard]] dvec3 centroid(std::size_t row) const noexcept {
        return (corner[0].get(row) + corner[1].get(row) + corner[2].get(row)) / 3.0;
    }
    /// Sets a row's corners and all that follows from them but its area and normal, which are given:
    /// a face of area 0 has none of its own.
    void set(std::size_t row, const std::array<dvec3, 3>& corners, const dvec3& unit_normal,
             double face_area) noexcept {
        double farthest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            corner[k].set(row, corners[k]);
            farthest = std::max(farthest, glm::length(corners[k]));
        }
        normal.set(row, unit_normal);
        area[row] = static_cast<float>(face_area);
        reach[row] = static_cast<float>(farthest);
    }
    /// Makes room for `rows` faces and their padding.
    void resize(std::size_t rows) {
        size = rows;
        const std::size_t all = simd::padded(rows);
        for (columns3& column : corner) column.resize(all);
        normal.resize(all);
        area.resize(all);
        reach.resize(all);
        source.resize(rows);
    }
};

namespace detail {

/// Calls `visit(column)` for each column of floats of each table, side by side.
template <class Visit>
void for_each_column(const face_table& from, face_table& to, const Visit& visit) {
    const auto visit3 = [&](const columns3& a, columns3& b) {
        visit(a.x, b.x), visit(a.y, b.y), visit(a.z, b.z);
    };
    for (std::size_t i = 0; i < 3; ++i) visit3(from.corner[i], to.corner[i]);
    visit3(from.normal, to.normal);
    visit(from.area, to.area);
    visit(from.reach, to.reach);
}

}  // namespace detail

/// A face is degenerate when its area is at most this times the squared radius: it has no normal.
inline constexpr double degenerate_area_share = 1e-12;

/// Centres the faces of `m` and computes what the search needs of each.
///
/// Fails  as validate does, naming the face; too_large where areas would leave the range of floats.
/// Cost   O(faces); 60 bytes a face.
/// Source Luksch 2009, section 4.1. Differs: faces without a normal are set aside.
[[nodiscard]] inline expected<face_table> make_face_table(const mesh& m, parallel threads = {}) {
    if (const expected<done> valid = validate(m, threads); !valid) return valid.error();
    face_table faces;
    faces.bounds = bounding_sphere_of(m.face_count() * 3, [&](std::size_t i) {
        return m.positions[m.triangles[i / 3][static_cast<glm::length_t>(i % 3)]];
    });
    const double radius = faces.bounds.radius;
    if (radius != 0 && !(radius > 1e-15 && radius < 1e15)) {
        return error{error_code::too_large,
                     "its radius is beyond single precision; scale it to between 1e-15 and 1e15"};
    }
    faces.resize(m.face_count());
    std::size_t row = 0;
    for (face_id face = 0; face < m.face_count(); ++face) {
        const auto [a, b, c] = m.corners(face);
        const std::array corners{dvec3(a) - faces.bounds.centre, dvec3(b) - faces.bounds.centre,
                                 dvec3(c) - faces.bounds.centre};
        const dvec3 cross = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
        const double doubled_area = glm::length(cross);
        if (!(doubled_area > 2 * degenerate_area_share * radius * radius)) {
            faces.degenerate.push_back(face);
            continue;
        }
        faces.set(row, corners, cross / doubled_area, doubled_area / 2);
        faces.source[row++] = face;
    }
    faces.resize(row);
    detail::for_each_column(
        faces, faces, [&](const std::vector<float>&, std::vector<float>& column) {
            std::fill(column.begin() + static_cast<std::ptrdiff_t>(row), column.end(), 0.0f);
        });
    return faces;
}

/// The given rows of `faces`, in the given order, as a table of its own (without `degenerate`).
[[nodiscard]] inline face_table select_rows(const face_table& faces,
                                            std::span<const std::uint32_t> rows,
                                            parallel threads = {}) {
    face_table selected;
    selected.bounds = faces.bounds;
    selected.resize(rows.size());
    threads.for_chunks(rows.size(), 16384, [&](std::size_t begin, std::size_t end) {
        detail::for_each_column(faces, selected, [&](const auto& from, auto& to) {
            for (std::size_t i = begin; i < end; ++i) to[i] = from[rows[i]];
        });
        for (std::size_t i = begin; i < end; ++i) selected.source[i] = faces.source[rows[i]];
    });
    return selected;
}

/// Calls `visit(corner)` for the first corners of all faces, then the second and the third ones.
template <class Visit>
void for_each_corner(const face_table& faces, const Visit& visit) {
    for (const columns3& corner : faces.corner) {
        for (std::size_t row = 0; row < faces.size; ++row) visit(corner.get(row));
    }
}

/// A point or vector in each lane.
template <class V>
struct vec3_lanes {
    V x, y, z;
};

template <class V>
[[nodiscard]] inline V dot(const vec3_lanes<V>& a, const vec3_lanes<V>& b) noexcept {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// The same vector in every lane.
template <class V>
[[nodiscard]] inline vec3_lanes<V> fill_lanes(const vec3& v) noexcept {
    using lanes = simd::lanes<V>;
    return {lanes::fill(v.x), lanes::fill(v.y), lanes::fill(v.z)};
}

/// A face in each lane.
template <class V>
struct face_lanes {
    std::array<vec3_lanes<V>, 3> corner;
    vec3_lanes<V> normal;
    V area;
    V reach;
};

/// The faces of the rows [row, row + lanes). Needs row + lanes ≤ padded_size().
template <class V>
[[nodiscard]] inline face_lanes<V> load_faces(const face_table& faces, std::size_t row) noexcept {
    const auto load = [row](const std::vector<float>& column) {
        return simd::lanes<V>::load(column.data() + row);
    };
    const auto load3 = [&](const columns3& columns) -> vec3_lanes<V> {
        return {load(columns.x), load(columns.y), load(columns.z)};
    };
    return {{load3(faces.corner[0]), load3(faces.corner[1]), load3(faces.corner[2])},
            load3(faces.normal),
            load(faces.area),
            load(faces.reach)};
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// One id a vertex, the same for vertices that are one.
struct vertex_identity {
    std::vector<std::uint32_t> id{};  ///< below `count`, in the order of first occurrence
    std::size_t count = 0;
};

namespace detail {

/// Numbers points from 0 on; equal points get the same number. A NaN equals nothing.
class point_numbers {
public:
    explicit point_numbers(std::size_t most) : slots_(std::bit_ceil(2 * most + 1), no_id) {
        points_.reserve(most);
    }

    [[nodiscard]] const std::vector<dvec3>& points() const noexcept { return points_; }

    /// no_id: not numbered yet.
    [[nodiscard]] std::uint32_t find(const dvec3& point) const noexcept {
        return slots_[slot_of(point)];
    }
    std::uint32_t add(const dvec3& point) {
        std::uint32_t& slot = slots_[slot_of(point)];
        if (slot == no_id) {
            slot = static_cast<std::uint32_t>(points_.size());
            points_.push_back(point);
        }
        return slot;
    }

private:
    /// Where `point` is, or else belongs.
    [[nodiscard]] std::size_t slot_of(const dvec3& point) const noexcept {
        const dvec3 p = point + 0.0;  // -0 has other bits than the 0 that it equals
        std::uint64_t hash = mix_bits(std::bit_cast<std::uint64_t>(p.x));
        hash = mix_bits(hash ^ std::bit_cast<std::uint64_t>(p.y));
        hash = mix_bits(hash ^ std::bit_cast<std::uint64_t>(p.z));
        std::size_t slot = hash & (slots_.size() - 1);
        while (slots_[slot] != no_id && points_[slots_[slot]] != point) {
            slot = (slot + 1) & (slots_.size() - 1);
        }
        return slot;
    }

    std::vector<std::uint32_t> slots_;
    std::vector<dvec3> points_;
};

/// Joins points that are at most `tolerance` apart: they lie in the same cell of a grid with that
/// spacing or in neighbouring ones.
[[nodiscard]] inline vertex_identity joined_points(const std::vector<dvec3>& points,
                                                   double tolerance) {
    const auto size = static_cast<std::uint32_t>(points.size());
    disjoint_sets sets(size);
    point_numbers cells(size);
    std::vector<std::uint32_t> newest;  // of each cell
    std::vector<std::uint32_t> before(size, no_id);
    for (std::uint32_t i = 0; i < size; ++i) {
        const dvec3 cell = glm::floor(points[i] / tolerance);
        for (int k = 0; k < 27; ++k) {
            const std::uint32_t near =
                cells.find(cell + dvec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
            if (near == no_id) continue;
            for (std::uint32_t j = newest[near]; j != no_id; j = before[j]) {
                if (glm::distance(points[i], points[j]) <= tolerance) sets.join(i, j);
            }
        }
        const std::uint32_t own = cells.add(cell);
        if (own == newest.size()) newest.push_back(no_id);
        before[i] = std::exchange(newest[own], i);
    }
    vertex_identity identity;
    identity.id = sets.numbers(identity.count);
    return identity;
}

template <class ForEachPoint>
[[nodiscard]] vertex_identity identify(std::size_t count, double tolerance,
                                       const ForEachPoint& for_each_point) {
    BILLOW_ASSERT(tolerance >= 0);
    vertex_identity identity;
    identity.id.reserve(count);
    point_numbers numbers(count);
    for_each_point([&](const dvec3& point) { identity.id.push_back(numbers.add(point)); });
    identity.count = numbers.points().size();
    if (tolerance > 0) {
        const vertex_identity joined = joined_points(numbers.points(), tolerance);
        for (std::uint32_t& id : identity.id) id = joined.id[id];
        identity.count = joined.count;
    }
    return identity;
}

}  // namespace detail

/// Says which vertices of `m` are one: those at the same position, and those within `tolerance` of
/// each other, directly or by way of others between them. No attribute is looked at.
///
/// Shape   one id a vertex, used by a face or not.
/// Unit    tolerance in scene units, ≥ 0; 0: the same position only.
/// Cost    O(vertices); with a tolerance that holds many vertices, times their number.
[[nodiscard]] inline vertex_identity position_ids(const mesh& m, double tolerance = 0) {
    return detail::identify(m.vertex_count(), tolerance, [&](const auto& visit) {
        for (const vec3& position : m.positions) visit(dvec3(position));
    });
}

/// The same for the corners of faces. Shape: corner k of row r at k·faces.size + r.
[[nodiscard]] inline vertex_identity position_ids(const face_table& faces, double tolerance = 0) {
    return detail::identify(3 * faces.size, tolerance,
                            [&](const auto& visit) { for_each_corner(faces, visit); });
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// What makes two faces one piece.
enum class connection {
    position,  ///< corners at the same place: seams of normals and uvs do not cut
    index,     ///< the same vertex of the mesh
};

/// Faces that can be reached from each other over shared vertices.
struct mesh_component {
    std::size_t face_count = 0;
    double area = 0;      ///< scene units squared
    double diameter = 0;  ///< of the sphere around the centre of its box, scene units
};

/// Shape  `of_face`: a row of `components` for each face. Components are in the order of their first
///        faces.
struct mesh_components {
    std::vector<std::uint32_t> of_face{};
    std::vector<mesh_component> components{};
};

/// Finds the connected components of a mesh.
///
/// Needs   indices within bounds, as validate() checks.
/// Cost    O(vertices + faces).
[[nodiscard]] inline mesh_components find_components(const mesh& m,
                                                     connection by = connection::position) {
    const bool is_by_position = by == connection::position;
    const vertex_identity identity = is_by_position ? position_ids(m) : vertex_identity{};
    const auto id_of = [&](std::uint32_t v) { return is_by_position ? identity.id[v] : v; };
    disjoint_sets sets(is_by_position ? identity.count : m.vertex_count());
    for (const uvec3& t : m.triangles) {
        sets.join(id_of(t.x), id_of(t.y));
        sets.join(id_of(t.x), id_of(t.z));
    }

    struct box {
        dvec3 low{std::numeric_limits<double>::infinity()};
        dvec3 high{-std::numeric_limits<double>::infinity()};
    };
    mesh_components result;
    result.of_face.reserve(m.face_count());
    std::vector<std::uint32_t> number(is_by_position ? identity.count : m.vertex_count(), no_id);
    std::vector<box> boxes;
    for (face_id face = 0; face < m.face_count(); ++face) {
        std::uint32_t& component = number[sets.leader(id_of(m.triangles[face].x))];
        if (component == no_id) {
            component = static_cast<std::uint32_t>(boxes.size());
            result.components.emplace_back();
            boxes.emplace_back();
        }
        result.of_face.push_back(component);
        ++result.components[component].face_count;
        const auto [a, b, c] = m.corners(face);
        result.components[component].area +=
            glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a))) / 2;
        for (const vec3& corner : {a, b, c}) {
            boxes[component].low = glm::min(boxes[component].low, dvec3(corner));
            boxes[component].high = glm::max(boxes[component].high, dvec3(corner));
        }
    }
    for (face_id face = 0; face < m.face_count(); ++face) {
        const box& around = boxes[result.of_face[face]];
        double& diameter = result.components[result.of_face[face]].diameter;
        for (const vec3& corner : m.corners(face)) {
            const dvec3 centre = around.low + (around.high - around.low) * 0.5;
            diameter = std::max(diameter, 2 * glm::distance(dvec3(corner), centre));
        }
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/mesh/roles.hpp
// Which faces are foliage and which are solid: by material names, alpha, or the size of the pieces.
//
// A. Fuhrmann et al.: Extreme model simplification for forest rendering. 2005, section 3.2.2: planes
// of leaves that are searched together with the trunk slice it.

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>


namespace billow::inline BILLOW_ABI {

enum class face_role : std::uint8_t {
    solid,    ///< a trunk, a wall
    foliage,  ///< leaves, needles, fronds
};

/// What told the roles apart.
enum class role_rule {
    none,            ///< nothing did: every face is solid
    material_names,  ///< role_options::foliage_materials
    alpha,           ///< materials whose alpha cuts holes
    component_size,  ///< role_options::leaf
};

/// A connected component is a leaf when it is within all of these. Shares are of the whole mesh, not
/// of its largest component, so that equal leaves without a trunk are leaves, too.
struct leaf_size {
    std::size_t triangles = 200;   ///< most triangles
    double triangle_share = 0.05;  ///< of all triangles
    double area_share = 0.01;      ///< of the whole area
    double diameter_share = 0.25;  ///< of the diameter of the sphere around the mesh
};

struct role_options {
    /// Names such as "leaf*" of the materials that are foliage; * is any text, ? any character, case
    /// does not count. None: alpha decides, and where no alpha cuts, the size of components.
    std::vector<std::string> foliage_materials{};
    /// Of the texels of a base colour texture: where alpha leaves out fewer, the material is solid.
    double least_cut = 0.05;
    leaf_size leaf{};
};

/// Shape  `of_face`: one role a face.
struct face_roles {
    std::vector<face_role> of_face{};
    role_rule rule = role_rule::none;
    double foliage_area_share = 0;
    std::string reason{};  ///< one line for people

    /// The faces of a role, ascending.
    [[nodiscard]] std::vector<face_id> faces_of(face_role role) const {
        std::vector<face_id> faces;
        for (face_id face = 0; face < of_face.size(); ++face) {
            if (of_face[face] == role) faces.push_back(face);
        }
        return faces;
    }
};

/// Whether `text` fits `pattern`: * is any text, ? any character, case of ASCII does not count.
/// Cost  O(text × pattern).
[[nodiscard]] inline bool matches_glob(std::string_view text, std::string_view pattern) noexcept {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
    std::size_t t = 0;
    std::size_t p = 0;
    std::size_t star = std::string_view::npos;
    std::size_t after_star = 0;  // where the text goes on if the last star takes one more
    while (t < text.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            after_star = t;
        } else if (p < pattern.size() &&
                   (pattern[p] == '?' || lower(pattern[p]) == lower(text[t]))) {
            ++p, ++t;
        } else if (star != std::string_view::npos) {
            p = star + 1;
            t = ++after_star;
        } else {
            return false;
        }
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

namespace detail {

/// Whether alpha cuts holes into a surface. Where its texture has no alpha, a mask of a double-sided
/// material is taken by its word; an even transparency is glass.
[[nodiscard]] inline bool is_cut(const mesh& m, const material& look, double least_cut) {
    if (look.alpha == alpha_mode::opaque) return false;
    const image_id id = look.base_color_texture.image;
    if (id >= m.images.size() || m.images[id].empty() || m.images[id].channels != 4) {
        return look.alpha == alpha_mode::mask && look.is_double_sided;
    }
    const float cutoff = look.alpha == alpha_mode::mask ? look.alpha_cutoff : 0.5f;
    const std::vector<std::uint8_t>& bytes = m.images[id].bytes;
    std::size_t cut = 0;
    std::size_t kept = 0;
    for (std::size_t i = 3; i < bytes.size(); i += 4) {
        ++(static_cast<float>(bytes[i]) / 255.0f * look.base_color.w < cutoff ? cut : kept);
    }
    return kept > 0 && static_cast<double>(cut) >= least_cut * static_cast<double>(cut + kept);
}

[[nodiscard]] inline std::string percent(double share) {
    char text[16];
    std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
    return text;
}

/// Finds roles; its methods are the rules.
class role_finder {
public:
    role_finder(const mesh& m, const role_options& options) : mesh_(m), options_(options) {
        roles_.of_face.assign(m.face_count(), face_role::solid);
    }

    [[nodiscard]] face_roles run() {
        const auto is_named = [&](const material& m) {
            return std::ranges::any_of(options_.foliage_materials, [&](const std::string& pattern) {
                return matches_glob(m.name, pattern);
            });
        };
        const auto cuts = [&](const material& m) { return is_cut(mesh_, m, options_.least_cut); };
        if (!options_.foliage_materials.empty()) {
            by_material(role_rule::material_names, "foliage by name is ", is_named);
        } else if (!by_material(role_rule::alpha, "alpha cuts holes into ", cuts)) {
            by_component_size();
        }
        add_area();
        return std::move(roles_);
    }

private:
    template <class IsFoliage>
    bool by_material(role_rule rule, const std::string& reason, const IsFoliage& is_foliage) {
        std::vector<char> is_leafy;
        for (const material& m : mesh_.materials) is_leafy.push_back(is_foliage(m));
        std::vector<char> is_told(mesh_.materials.size(), 0);
        std::size_t count = 0;
        roles_.reason = reason;
        for (face_id face = 0; face < mesh_.face_count(); ++face) {
            const material_id id = mesh_.face_materials.empty() ? 0 : mesh_.face_materials[face];
            if (id >= is_leafy.size() || is_leafy[id] == 0) continue;
            roles_.of_face[face] = face_role::foliage;
            if (is_told[id] != 0) continue;
            is_told[id] = 1;
            if (++count > 3) continue;
            roles_.reason += (count > 1 ? ", \"" : "\"") + mesh_.materials[id].name + '"';
        }
        if (count == 0) roles_.reason += "no material";
        if (count > 3) roles_.reason += " and " + std::to_string(count - 3) + " more";
        if (count > 0) roles_.rule = rule;
        return count > 0;
    }

    void by_component_size() {
        const mesh_components pieces = find_components(mesh_);
        double area = 0;
        for (const mesh_component& piece : pieces.components) area += piece.area;
        const double diameter = 2 * bounding_sphere_of(3 * mesh_.face_count(), [&](std::size_t i) {
                                        return mesh_.corners(static_cast<face_id>(i / 3))[i % 3];
                                    }).radius;
        std::vector<face_role> role_of;
        std::size_t leaves = 0;
        for (const mesh_component& piece : pieces.components) {
            const leaf_size& most = options_.leaf;
            const bool is_leaf =
                piece.face_count <= most.triangles &&
                static_cast<double>(piece.face_count) <=
                    most.triangle_share * static_cast<double>(mesh_.face_count()) &&
                piece.area <= most.area_share * area &&
                piece.diameter <= most.diameter_share * diameter;
            role_of.push_back(is_leaf ? face_role::foliage : face_role::solid);
            if (is_leaf) ++leaves;
        }
        for (face_id face = 0; face < mesh_.face_count(); ++face) {
            roles_.of_face[face] = role_of[pieces.of_face[face]];
        }
        roles_.rule = leaves > 0 ? role_rule::component_size : role_rule::none;
        roles_.reason = std::to_string(leaves) + " of " + std::to_string(role_of.size()) +
                        " connected components are as small as leaves";
    }

    void add_area() {
        double all = 0;
        double foliage = 0;
        for (face_id face = 0; face < mesh_.face_count(); ++face) {
            const auto [a, b, c] = mesh_.corners(face);
            const double area = glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)));
            all += area;
            if (roles_.of_face[face] == face_role::foliage) foliage += area;
        }
        roles_.foliage_area_share = all > 0 ? foliage / all : 0;
    }

    const mesh& mesh_;
    const role_options& options_;
    face_roles roles_{};
};

}  // namespace detail

/// Gives every face a role. The first rule that finds foliage decides for all faces: names, where
/// some are given, and nothing else then; materials whose alpha cuts holes; components as small as
/// leaves. An opaque material is solid whatever its texture's alpha says.
///
/// Needs   indices within bounds, as validate() checks.
/// Cost    O(faces + texels of cut-out textures).
[[nodiscard]] inline face_roles find_roles(const mesh& m, const role_options& options = {}) {
    return detail::role_finder(m, options).run();
}

/// What a model is, for who has to choose how to treat it.
enum class model_kind {
    solid,    ///< one search, for closed surfaces
    foliage,  ///< one search, for leaves
    split,    ///< a trunk and its foliage, each to be searched alone
};

struct model_description {
    model_kind kind = model_kind::solid;
    face_roles roles{};
    std::string reason{};  ///< one line for people
};

/// Says what `m` is: solid where less than a tenth of the area is foliage, foliage where hardly
/// anything (a fiftieth) is solid. Small components alone are weak evidence, houses have nails: they
/// count from six tenths of the area and 50 faces on.
[[nodiscard]] inline model_description describe(const mesh& m, const role_options& options = {}) {
    model_description result;
    result.roles = find_roles(m, options);
    const double share = result.roles.foliage_area_share;
    const bool is_weak = result.roles.rule == role_rule::component_size;
    const double least = is_weak ? 0.6 : 0.1;
    const char* kind = "solid";
    if (share >= least && (!is_weak || m.face_count() >= 50)) {
        result.kind = share > 0.98 ? model_kind::foliage : model_kind::split;
        kind = share > 0.98 ? "foliage" : "split into trunk and foliage";
    }
    result.reason = std::string(kind) + ": " + result.roles.reason;
    if (share > 0) result.reason += ", " + detail::percent(share) + " of the area";
    return result;
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/plane_space/cube_map.hpp
// The cube plane space: normals through the lattice points on the surface of a cube.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
// section 4.4.

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

// ---- billow/plane_space/plane_space.hpp
// What every plane space answers: which orientations it samples, and the cell around each.
//
// Décoret et al. 2003 sample planes on a spherical grid, Luksch 2009 (section 4.4) on a cube. Both
// divide the sphere of normals into cells; the offsets rho along a normal are divided elsewhere.

#include <algorithm>
#include <array>
#include <concepts>

#include <span>


namespace billow::inline BILLOW_ABI {

/// A part of the sphere of normals as the kernels read it. A cell of three corners repeats one.
struct orientation_cell {
    vec3 centre{};
    std::array<vec3, 4> corner{};
    float chord = 0;  ///< largest distance of a corner to the centre, 2 sin(half diagonal / 2)
};

/// The cell around `centre` with three or four corners, all of length 1.
[[nodiscard]] inline orientation_cell make_cell(const dvec3& centre,
                                                std::span<const dvec3> corners) noexcept {
    BILLOW_ASSERT(corners.size() == 3 || corners.size() == 4);
    orientation_cell cell{.centre = vec3(centre)};
    double chord = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        const dvec3& corner = corners[std::min(k, corners.size() - 1)];
        cell.corner[k] = vec3(corner);
        chord = std::max(chord, glm::distance(corner, centre));
    }
    cell.chord = static_cast<float>(chord);
    return cell;
}

/// A rectangle in the (u, v) coordinates of one of a plane space's charts. It can be split and
/// moved beyond the rim of its chart, where the coordinates go on smoothly.
struct orientation_patch {
    int chart = 0;
    dvec2 centre{0};     ///< in chart coordinates
    dvec2 half_size{0};  ///< in chart coordinates
};

/// Samples of the sphere of normals. The antipode of every orientation is one too, since (n, rho)
/// and (-n, -rho) are the same plane.
template <class S>
concept plane_space = std::copyable<S> &&
    requires(const S& space, orientation_id id, const dvec3& normal, int chart, const dvec2& uv) {
    { space.orientation_count() } -> std::convertible_to<std::size_t>;
    { space.direction(id) } -> std::convertible_to<dvec3>;
    { space.antipode(id) } -> std::convertible_to<orientation_id>;
    { space.orientation_of(normal) } -> std::convertible_to<orientation_id>;
    { space.cell(id) } -> std::convertible_to<orientation_cell>;
    space.neighbours(id).begin();
    { space.patch(id) } -> std::convertible_to<orientation_patch>;
    { space.direction_at(chart, uv) } -> std::convertible_to<dvec3>;
};

/// The cell that a patch covers.
template <plane_space Space>
[[nodiscard]] orientation_cell cell_of_patch(const Space& space, const orientation_patch& patch) {
    const auto at = [&](double u, double v) {
        return space.direction_at(patch.chart, patch.centre + patch.half_size * dvec2(u, v));
    };
    return make_cell(at(0, 0), std::array{at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)});
}

/// A few ids: the neighbours of an orientation.
class orientation_list {
public:
    void add_once(orientation_id id) noexcept {
        if (std::ranges::find(*this, id) == end()) ids_[size_++] = id;
    }
    [[nodiscard]] const orientation_id* begin() const noexcept { return ids_.data(); }
    [[nodiscard]] const orientation_id* end() const noexcept { return ids_.data() + size_; }
    [[nodiscard]] std::size_t size() const noexcept { return size_; }

private:
    std::array<orientation_id, 12> ids_{};
    std::size_t size_ = 0;
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// The 6N²+2 lattice points on the surface of a cube of N³ unit boxes, pulled to the sphere.
///
/// A point's cell is the dual one: its corners are the centres of the squares around the point, four
/// but at the cube's corners, where three squares meet. Ids count the points inside the six sides
/// first, then those inside the twelve edges, then the eight corners. N is even, so that the axes
/// are orientations. Copies share their tables.
///
/// Differs from the thesis by the warp t → tan(t π/4) of the lattice, which spreads the directions
/// more evenly (largest half diagonal 4.0° instead of 4.5° at N = 18).
class cube_map {
public:
    /// Needs an even resolution N in [2, 1024]. Cost O(N²).
    explicit cube_map(int resolution = 18) : resolution_(resolution) {
        BILLOW_ASSERT(resolution >= 2 && resolution <= 1024 && resolution % 2 == 0);
        auto tables = std::make_shared<lattice>();
        tables->id.resize(6 * static_cast<std::size_t>(side()) * static_cast<std::size_t>(side()));
        for (int rim_count = 1; rim_count <= 3; ++rim_count) {  // sides, edges, corners
            for (int chart = 0; chart < 6; ++chart) {
                for (int j = 0; j <= resolution_; ++j) {
                    for (int i = 0; i <= resolution_; ++i) {
                        const point p = point_of(chart, i, j);
                        if (rims(p) != rim_count) continue;
                        const int home = first_chart(p);
                        if (home == chart) {
                            tables->id[slot(chart, i, j)] =
                                static_cast<orientation_id>(tables->points.size());
                            tables->points.push_back(p);
                        } else {  // numbered with an earlier side
                            tables->id[slot(chart, i, j)] = tables->id[slot(home, p)];
                        }
                    }
                }
            }
        }
        lattice_ = std::move(tables);
    }

    [[nodiscard]] int resolution() const noexcept { return resolution_; }
    [[nodiscard]] std::size_t orientation_count() const noexcept { return lattice_->points.size(); }

    [[nodiscard]] dvec3 direction(orientation_id id) const noexcept {
        const point& p = lattice_->points[id];
        return glm::normalize(dvec3(warp(p[0]), warp(p[1]), warp(p[2])));
    }

    [[nodiscard]] orientation_id antipode(orientation_id id) const noexcept {
        const point& p = lattice_->points[id];
        return id_of({resolution_ - p[0], resolution_ - p[1], resolution_ - p[2]});
    }

    /// The lattice point nearest to `normal` in the coordinates of the side that it pierces.
    [[nodiscard]] orientation_id orientation_of(const dvec3& normal) const noexcept {
        const dvec3 size = glm::abs(normal);
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        point p{};
        for (int k = 0; k < 3; ++k) {
            const double t = std::atan(normal[k] / size[axis]) * 4 / std::numbers::pi;  // [-1, 1]
            p[static_cast<std::size_t>(k)] =
                static_cast<int>(std::lround((t + 1) / 2 * resolution_));
        }
        return id_of(p);
    }

    [[nodiscard]] orientation_cell cell(orientation_id id) const noexcept {
        std::array<dvec3, 4> corners{};
        std::size_t count = 0;
        for_each_square(id, [&](int chart, int i, int j) {
            corners[count++] =
                direction_at(chart, {unit(2 * i + 1 - resolution_), unit(2 * j + 1 - resolution_)});
        });
        return make_cell(direction(id), std::span(corners).first(count));
    }

    /// The points that share a square: 8, at the cube's corners 6.
    [[nodiscard]] orientation_list neighbours(orientation_id id) const noexcept {
        orientation_list list;
        for_each_square(id, [&](int chart, int i, int j) {
            for (int k = 0; k < 4; ++k) {
                const orientation_id near = lattice_->id[slot(chart, i + k % 2, j + k / 2)];
                if (near != id) list.add_once(near);
            }
        });
        return list;
    }

    /// Charts are the six sides, with coordinates in [-1, 1]².
    [[nodiscard]] orientation_patch patch(orientation_id id) const noexcept {
        const point& p = lattice_->points[id];
        const int chart = first_chart(p);
        const auto [i, j] = chart_position(chart, p);
        return {.chart = chart,
                .centre = {unit(2 * i - resolution_), unit(2 * j - resolution_)},
                .half_size = {unit(1), unit(1)}};
    }
    /// Needs |u|, |v| < 2.
    [[nodiscard]] dvec3 direction_at(int chart, const dvec2& uv) const noexcept {
        dvec3 at{};
        at[chart % 3] = chart < 3 ? 1 : -1;
        at[(chart + 1) % 3] = std::tan(uv.x * std::numbers::pi / 4);
        at[(chart + 2) % 3] = std::tan(uv.y * std::numbers::pi / 4);
        return glm::normalize(at);
    }

private:
    using point = std::array<int, 3>;  ///< coordinates in [0, N], at least one of them 0 or N
    struct lattice {
        std::vector<point> points;       ///< by id
        std::vector<orientation_id> id;  ///< by slot
    };

    [[nodiscard]] int side() const noexcept { return resolution_ + 1; }
    [[nodiscard]] double unit(int doubled) const noexcept {
        return static_cast<double>(doubled) / resolution_;
    }
    [[nodiscard]] double warp(int coordinate) const noexcept {
        return std::tan(unit(2 * coordinate - resolution_) * std::numbers::pi / 4);
    }
    /// How many sides the point lies on.
    [[nodiscard]] int rims(const point& p) const noexcept {
        int count = 0;
        for (const int c : p) count += (c == 0 || c == resolution_) ? 1 : 0;
        return count;
    }
    /// Chart k < 3 is the side where coordinate k is N, chart k + 3 that where it is 0.
    [[nodiscard]] bool is_on(int chart, const point& p) const noexcept {
        return p[static_cast<std::size_t>(chart % 3)] == (chart < 3 ? resolution_ : 0);
    }
    [[nodiscard]] int first_chart(const point& p) const noexcept {
        int chart = 0;
        while (!is_on(chart, p)) ++chart;
        return chart;
    }
    [[nodiscard]] point point_of(int chart, int i, int j) const noexcept {
        point p{};
        p[static_cast<std::size_t>(chart % 3)] = chart < 3 ? resolution_ : 0;
        p[static_cast<std::size_t>((chart + 1) % 3)] = i;
        p[static_cast<std::size_t>((chart + 2) % 3)] = j;
        return p;
    }
    [[nodiscard]] std::array<int, 2> chart_position(int chart, const point& p) const noexcept {
        return {p[static_cast<std::size_t>((chart + 1) % 3)],
                p[static_cast<std::size_t>((chart + 2) % 3)]};
    }
    [[nodiscard]] std::size_t slot(int chart, int i, int j) const noexcept {
        return static_cast<std::size_t>((chart * side() + j) * side() + i);
    }
    [[nodiscard]] std::size_t slot(int chart, const point& p) const noexcept {
        const auto [i, j] = chart_position(chart, p);
        return slot(chart, i, j);
    }
    [[nodiscard]] orientation_id id_of(const point& p) const noexcept {
        return lattice_->id[slot(first_chart(p), p)];
    }
    /// Calls `visit(chart, i, j)` for the squares [i, i + 1] × [j, j + 1] that touch the point.
    template <class Visit>
    void for_each_square(orientation_id id, const Visit& visit) const {
        const point& p = lattice_->points[id];
        for (int chart = 0; chart < 6; ++chart) {
            if (!is_on(chart, p)) continue;
            const auto [i, j] = chart_position(chart, p);
            for (int k = 0; k < 4; ++k) {
                const int si = i - k % 2;
                const int sj = j - k / 2;
                if (si >= 0 && sj >= 0 && si < resolution_ && sj < resolution_)
                    visit(chart, si, sj);
            }
        }
    }

    int resolution_;
    std::shared_ptr<const lattice> lattice_;
};
static_assert(plane_space<cube_map>);

}  // namespace billow::inline BILLOW_ABI
// ---- billow/plane_space/spherical.hpp
// The spherical plane space: a grid of longitude and latitude.
//
// X. Décoret, F. Durand, F. X. Sillion, J. Dorsey: Billboard clouds for extreme model
// simplification. SIGGRAPH 2003; as described by C. Luksch: Implementation of an improved billboard
// cloud algorithm. Thesis, TU Wien 2009, sections 2.1 and 3.2.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>


namespace billow::inline BILLOW_ABI {

/// 4N longitudes times 2N latitudes: 8N² orientations, as far apart at the equator as those of
/// cube_map(N), crowded at the poles.
///
/// Cell (i, j) spans theta in [i, i + 1] · 2π / 4N and phi in [j, j + 1] · π / 2N; its id is
/// 4N · j + i. The direction is (sin phi cos theta, sin phi sin theta, cos phi): the roles of theta
/// and phi in eq 3.2 and 3.3 of the thesis disagree, here they follow eq 3.3's ranges.
class spherical {
public:
    /// Needs resolution ≥ 1.
    explicit spherical(int resolution = 18) : resolution_(resolution) {
        BILLOW_ASSERT(resolution >= 1);
    }

    [[nodiscard]] int resolution() const noexcept { return resolution_; }
    [[nodiscard]] std::size_t orientation_count() const noexcept {
        return static_cast<std::size_t>(columns()) * static_cast<std::size_t>(rows());
    }

    [[nodiscard]] dvec3 direction(orientation_id id) const noexcept {
        // The lower half mirrors the upper one exactly, so antipodes are exact negatives.
        if (row(id) >= resolution_) return -direction(antipode(id));
        return direction_at(0, patch(id).centre);
    }

    [[nodiscard]] orientation_id antipode(orientation_id id) const noexcept {
        return id_of(column(id) + columns() / 2, rows() - 1 - row(id));
    }

    /// The cell that holds `normal`, which has length 1.
    [[nodiscard]] orientation_id orientation_of(const dvec3& normal) const noexcept {
        const double theta = std::atan2(normal.y, normal.x) + 2 * std::numbers::pi;
        const double phi = std::acos(std::clamp(normal.z, -1.0, 1.0));
        return id_of(static_cast<int>(theta / step()),
                     std::min(static_cast<int>(phi / step()), rows() - 1));
    }

    [[nodiscard]] orientation_cell cell(orientation_id id) const noexcept {
        const orientation_patch p = patch(id);
        const auto at = [&](double u, double v) {
            return direction_at(0, p.centre + p.half_size * dvec2(u, v));
        };
        return make_cell(direction(id), std::array{at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)});
    }

    /// The cells that share a side or a corner: 8. Across a pole they lie half a turn away.
    [[nodiscard]] orientation_list neighbours(orientation_id id) const noexcept {
        orientation_list list;
        for (int dj = -1; dj <= 1; ++dj) {
            for (int di = -1; di <= 1; ++di) {
                int i = column(id) + di;
                int j = row(id) + dj;
                if (j < 0 || j >= rows()) {
                    i += columns() / 2;
                    j = j < 0 ? 0 : rows() - 1;
                }
                if (const orientation_id near = id_of(i, j); near != id) list.add_once(near);
            }
        }
        return list;
    }

    /// Chart 0, coordinates (theta, phi) in radians.
    [[nodiscard]] orientation_patch patch(orientation_id id) const noexcept {
        return {.chart = 0,
                .centre = {(column(id) + 0.5) * step(), (row(id) + 0.5) * step()},
                .half_size = {step() / 2, step() / 2}};
    }
    [[nodiscard]] dvec3 direction_at(int, const dvec2& theta_phi) const noexcept {
        const double sin_phi = std::sin(theta_phi.y);
        return {sin_phi * std::cos(theta_phi.x), sin_phi * std::sin(theta_phi.x),
                std::cos(theta_phi.y)};
    }

private:
    [[nodiscard]] int columns() const noexcept { return 4 * resolution_; }
    [[nodiscard]] int rows() const noexcept { return 2 * resolution_; }
    [[nodiscard]] double step() const noexcept { return std::numbers::pi / rows(); }
    [[nodiscard]] int column(orientation_id id) const noexcept {
        return static_cast<int>(id) % columns();
    }
    [[nodiscard]] int row(orientation_id id) const noexcept {
        return static_cast<int>(id) / columns();
    }
    [[nodiscard]] orientation_id id_of(int column, int row) const noexcept {
        const int wrapped = ((column % columns()) + columns()) % columns();
        return static_cast<orientation_id>(row * columns() + wrapped);
    }

    int resolution_;
};
static_assert(plane_space<spherical>);

}  // namespace billow::inline BILLOW_ABI

// ---- billow/fit/average.hpp
// Average plane: the post-plane tweak.
//
// A. Fuhrmann, E. Umlauf, S. Mantler: Extreme model simplification for forest rendering.
// Eurographics Workshop on Natural Phenomena 2005, section 3.3.3.

// ---- billow/fit/fit.hpp
// Moving a plane to the faces that it has taken: the concept of a plane fitter.

#include <concepts>


namespace billow::inline BILLOW_ABI {

/// Proposes a plane for all rows of `faces`, starting from `start`, whose normal has length 1. Gives
/// `start` where the faces determine none. Need not respect epsilon: the caller checks, and where
/// allows_less_contribution is false also that the faces' contribution does not fall.
template <class F>
concept plane_fitter = std::copyable<F> &&
    requires(const F& fit, const face_table& faces, const plane& start) {
    { fit(faces, start) } -> std::same_as<plane>;
    { fit.allows_less_contribution } -> std::convertible_to<bool>;
};

/// Keeps the plane.
struct no_fit {
    static constexpr bool allows_less_contribution = false;
    [[nodiscard]] plane operator()(const face_table&, const plane& start) const { return start; }
};
static_assert(plane_fitter<no_fit>);

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// The area-weighted mean of the faces' normals, through the mean of their centroids. Normals are
/// first turned to the side of the start plane's, else the two sides of a leaf would cancel out.
struct average_fit {
    static constexpr bool allows_less_contribution = false;
    [[nodiscard]] plane operator()(const face_table& faces, const plane& start) const {
        dvec3 normal{0};
        dvec3 centroid{0};
        double total = 0;
        for (std::size_t row = 0; row < faces.size; ++row) {
            const double area = static_cast<double>(faces.area[row]);
            const dvec3 n = faces.normal.get(row);
            normal += (glm::dot(n, start.normal) < 0 ? -n : n) * area;
            centroid += faces.centroid(row) * area;
            total += area;
        }
        const double length = glm::length(normal);
        if (!(total > 0) || length < 1e-6 * total) return start;
        normal /= length;
        return {normal, glm::dot(normal, centroid / total)};
    }
};
static_assert(plane_fitter<average_fit>);

}  // namespace billow::inline BILLOW_ABI
// ---- billow/fit/least_squares.hpp
// Regression plane: the height field of least squares over the start plane.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
// eq 3.11 to 3.14.

#include <Eigen/Cholesky>

#include <cmath>


namespace billow::inline BILLOW_ABI {

/// Heights of the faces' corners over the start plane, explained by z = s x + t y + h. Good while
/// the tilt is small, which the faces of one plane ensure. Keeps the plane when the corners lie on a
/// line. Differs from eq 3.13 and 3.14 by the normalisation of (-s, -t, 1), which they omit, and by
/// centring x and y, since the condition of the normal equations is squared.
struct least_squares_fit {
    static constexpr bool allows_less_contribution = true;
    [[nodiscard]] plane operator()(const face_table& faces, const plane& start) const {
        if (faces.size == 0) return start;
        const frame axes = frame_around(start.normal);
        dvec3 mean{0};
        for_each_corner(faces, [&](const dvec3& corner) { mean += axes.to_local(corner); });
        mean /= 3 * static_cast<double>(faces.size);
        Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
        Eigen::Vector2d right = Eigen::Vector2d::Zero();
        for_each_corner(faces, [&](const dvec3& corner) {
            const dvec3 p = axes.to_local(corner);
            const Eigen::Vector2d xy(p.x - mean.x, p.y - mean.y);
            matrix += xy * xy.transpose();
            right += xy * (p.z - mean.z);
        });
        const double trace = matrix.trace();
        const double determinant = matrix(0, 0) * matrix(1, 1) - matrix(0, 1) * matrix(1, 0);
        if (!(determinant > 1e-12 * trace * trace)) return start;
        const Eigen::Vector2d slope = matrix.ldlt().solve(right);
        const dvec3 normal = axes.to_scene(glm::normalize(dvec3(-slope.x(), -slope.y(), 1)));
        return {normal, glm::dot(normal, axes.to_scene(mean))};
    }
};
static_assert(plane_fitter<least_squares_fit>);

}  // namespace billow::inline BILLOW_ABI
// ---- billow/fit/minimax.hpp
// Minimax plane: the plane of least largest distance (Chebyshev).
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009, section
// 3.3, names the aim; the search is ours.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>


namespace billow::inline BILLOW_ABI {

/// Minimises the largest distance of a corner, half the width of the corners along the normal. The
/// width has one minimum near a plane that the faces lie on, so a pattern search finds it: eight
/// normals around the best one, closer and closer together. Never worse than the start plane moved
/// to the middle of its corners, so a plane within epsilon of its faces stays so.
///
/// Cost  about 100 passes over the corners.
struct minimax_fit {
    static constexpr bool allows_less_contribution = true;

    double first_step = 6 * std::numbers::pi / 180;    ///< radians
    double last_step = 0.05 * std::numbers::pi / 180;  ///< radians; the normal is as exact as this

    [[nodiscard]] plane operator()(const face_table& faces, const plane& start) const {
        if (faces.size == 0) return start;
        extent best = extent_along(faces, start.normal);
        dvec3 normal = start.normal;
        for (double step = first_step; step >= last_step;) {
            const frame axes = frame_around(normal);
            dvec3 narrower = normal;
            for (int k = 0; k < 8; ++k) {
                const double angle = k * std::numbers::pi / 4;
                const dvec3 aside = axes.u * std::cos(angle) + axes.v * std::sin(angle);
                const dvec3 candidate = glm::normalize(normal + aside * std::tan(step));
                const extent along = extent_along(faces, candidate);
                if (along.width() < best.width()) best = along, narrower = candidate;
            }
            if (narrower == normal) {
                step /= 2;
            } else {
                normal = narrower;
            }
        }
        return {normal, (best.low + best.high) / 2};
    }

private:
    struct extent {
        double low = std::numeric_limits<double>::infinity();
        double high = -std::numeric_limits<double>::infinity();
        [[nodiscard]] double width() const noexcept { return high - low; }
    };
    [[nodiscard]] static extent extent_along(const face_table& faces, const dvec3& normal) {
        extent along;
        for_each_corner(faces, [&](const dvec3& corner) {
            const double offset = glm::dot(normal, corner);
            along.low = std::min(along.low, offset);
            along.high = std::max(along.high, offset);
        });
        return along;
    }
};
static_assert(plane_fitter<minimax_fit>);

}  // namespace billow::inline BILLOW_ABI
// ---- billow/fit/svd.hpp
// Orthogonal regression: the plane of least squared distances.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009, eq 3.10.

#include <Eigen/Eigenvalues>


namespace billow::inline BILLOW_ABI {

/// Minimises the sum of squared distances of the faces' corners, each counted once a face: the plane
/// through their mean whose normal is the eigenvector of the least eigenvalue of their covariance,
/// which is the last singular vector of the centred corners. Corners weigh the same, since weights
/// by area raise the largest error (Luksch 2009, section 3.3). Keeps the normal when the corners lie
/// on a line or show no direction.
struct svd_fit {
    static constexpr bool allows_less_contribution = true;
    [[nodiscard]] plane operator()(const face_table& faces, const plane& start) const {
        if (faces.size == 0) return start;
        dvec3 mean{0};
        for_each_corner(faces, [&](const dvec3& p) { mean += p; });
        mean /= 3 * static_cast<double>(faces.size);
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for_each_corner(faces, [&](const dvec3& p) {
            const Eigen::Vector3d d(p.x - mean.x, p.y - mean.y, p.z - mean.z);
            covariance += d * d.transpose();
        });
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
        const Eigen::Vector3d& spread = solver.eigenvalues();  // ascending
        dvec3 normal = start.normal;
        if (spread(1) - spread(0) > 1e-9 * spread(2)) {
            const Eigen::Vector3d n = solver.eigenvectors().col(0);
            normal = glm::normalize(dvec3(n.x(), n.y(), n.z()));
            if (glm::dot(normal, start.normal) < 0) normal = -normal;
        }
        return {normal, glm::dot(normal, mean)};
    }
};
static_assert(plane_fitter<svd_fit>);

}  // namespace billow::inline BILLOW_ABI

// ---- billow/plants/branch_mesh.hpp
// Bark: frusta around the segments of a skeleton.

#include <algorithm>
#include <cmath>

// ---- billow/plants/skeleton.hpp
// What a turtle leaves behind: the axes of a plant and the places of its leaves, in columns.

#include <algorithm>
#include <cmath>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Branch segments and leaf sites. A segment comes after its parent.
///
/// Unit  scene units. A frame's normal is the heading, its u the left, its v the upper side.
struct skeleton {
    std::vector<std::uint32_t> parents{};  ///< segment that this one grows from; no_id: a root
    std::vector<dvec3> starts{}, ends{};   ///< a child starts where its parent ends
    std::vector<frame> frames{};
    std::vector<float> start_radii{}, end_radii{};  ///< filled by assign_radii

    std::vector<std::uint32_t> leaf_segments{};  ///< segment at whose end the leaf grows
    std::vector<frame> leaf_frames{};
    std::vector<float> leaf_scales{};

    [[nodiscard]] std::size_t segment_count() const noexcept { return parents.size(); }
    [[nodiscard]] std::size_t leaf_count() const noexcept { return leaf_segments.size(); }
};

/// For every segment the child that continues it: the one that turns least, if it turns by less
/// than 90°; no_id where there is none.
[[nodiscard]] inline std::vector<std::uint32_t> continuations(const skeleton& bones) {
    std::vector<std::uint32_t> heirs(bones.segment_count(), no_id);
    std::vector<double> best(bones.segment_count(), 1e-3);
    for (std::uint32_t i = 0; i < bones.segment_count(); ++i) {
        const std::uint32_t parent = bones.parents[i];
        if (parent == no_id) continue;
        const double cosine = glm::dot(bones.frames[parent].normal, bones.frames[i].normal);
        if (cosine > best[parent] + 1e-9) {  // of equal ones the first stays, on every machine
            best[parent] = cosine;
            heirs[parent] = i;
        }
    }
    return heirs;
}

/// The number of segments that nothing grows from.
[[nodiscard]] inline std::size_t tip_count(const skeleton& bones) {
    std::vector<bool> has_child(bones.segment_count());
    for (const std::uint32_t parent : bones.parents) {
        if (parent != no_id) has_child[parent] = true;
    }
    return static_cast<std::size_t>(std::ranges::count(has_child, false));
}

/// Scales the plant so that its highest segment ends at `height` above the ground, y = 0.
///
/// Fails   malformed: nothing of it is above the ground.
[[nodiscard]] inline expected<done> scale_to_height(skeleton& bones, double height) {
    double top = 0;
    for (const dvec3& end : bones.ends) top = std::max(top, end.y);
    if (!(top > 1e-9)) {
        return error{error_code::malformed, "the plant does not grow above the ground"};
    }
    const double scale = height / top;
    for (dvec3& p : bones.starts) p *= scale;
    for (dvec3& p : bones.ends) p *= scale;
    return done{};
}

struct radius_options {
    double trunk = 0.15;  ///< radius of a lone root's end, in scene units
    double flare = 1.4;   ///< how much wider a root starts at the ground
    double collar = 1.2;  ///< how much wider a branch starts than it goes on; 1: none
};

/// Radii by da Vinci's rule: at every node the parent's cross-section is the sum of its children's,
/// r² = Σ r², all tips being equal. A continuation starts with its parent's end radius; a side
/// branch starts inside its parent, never wider than that.
///
/// Source  Leonardo da Vinci, notebooks, as quoted in ABOP, section 2.1 (there with the exponent
///         as a parameter).
inline void assign_radii(skeleton& bones, const radius_options& options = {}) {
    const std::size_t count = bones.segment_count();
    const double tip_area =
        options.trunk * options.trunk / double(std::max<std::size_t>(1, tip_count(bones)));
    std::vector<double> areas(count, 0);
    for (std::size_t i = count; i-- > 0;) {
        if (areas[i] == 0) areas[i] = tip_area;
        if (bones.parents[i] != no_id) areas[bones.parents[i]] += areas[i];
    }
    const std::vector<std::uint32_t> heirs = continuations(bones);
    bones.start_radii.resize(count);
    bones.end_radii.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t parent = bones.parents[i];
        const double radius = std::sqrt(areas[i]);
        bones.end_radii[i] = static_cast<float>(radius);
        if (parent == no_id) {
            bones.start_radii[i] = static_cast<float>(radius * options.flare);
        } else if (heirs[parent] == i) {
            bones.start_radii[i] = bones.end_radii[parent];
        } else {
            bones.start_radii[i] =
                std::min(bones.end_radii[parent], static_cast<float>(radius * options.collar));
        }
    }
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct branch_options {
    unsigned sides = 10;      ///< of the thickest branch; thinner ones have fewer
    unsigned min_sides = 3;   ///< of the thinnest ones
    double bark_width = 0.5;  ///< width of the bark image, in scene units; every branch has a
                              ///< whole number of them around, at least one
};

namespace detail {

/// `vector` carried along as the unit tangent turns from `from` to `to`, without twist.
[[nodiscard]] inline dvec3 transported(const dvec3& vector, const dvec3& from, const dvec3& to) {
    const dvec3 axis = glm::cross(from, to);
    const dvec3 once = glm::cross(axis, vector);
    return vector + once + glm::cross(axis, once) / (1 + glm::dot(from, to));
}

/// Builds the frusta of one path after the other.
class bark_builder {
public:
    bark_builder(const skeleton& bones, const branch_options& options, material_id material,
                 mesh& out)
        : bones_(bones), options_(options), material_(material), out_(out) {}

    void build() {
        const std::vector<std::uint32_t> heirs = continuations(bones_);
        for (const float radius : bones_.start_radii) thickest_ = std::max(thickest_, radius);
        for (std::uint32_t i = 0; i < bones_.segment_count(); ++i) {
            const std::uint32_t parent = bones_.parents[i];
            if (parent != no_id && heirs[parent] == i) continue;
            path_.clear();
            for (std::uint32_t s = i; s != no_id; s = heirs[s]) path_.push_back(s);
            add_path();
        }
    }

private:
    /// A path has one ring more than segments; neighbours share a ring, so nothing gapes.
    void add_path() {
        const double first_radius = double(bones_.start_radii[path_.front()]);
        sides_ = std::max(options_.min_sides,
                          static_cast<unsigned>(std::lround(
                              options_.sides * std::sqrt(first_radius / double(thickest_)))));
        repeats_ = std::max(1.0, std::round(tau * first_radius / options_.bark_width));
        const auto first_ring = static_cast<std::uint32_t>(out_.vertex_count());
        const auto row = static_cast<std::uint32_t>(sides_ + 1);
        double v = 0;
        dvec3 tangent = heading(0), right = -bones_.frames[path_.front()].u;
        for (std::size_t k = 0; k <= path_.size(); ++k) {
            const dvec3 next = k == 0 || k == path_.size()
                                   ? heading(std::min(k, path_.size() - 1))
                                   : glm::normalize(heading(k - 1) + heading(k));
            right = transported(right, tangent, next);
            tangent = next;
            if (k > 0) v -= length(k - 1) * repeats_ / (pi * (radius(k - 1) + radius(k)));
            add_ring(k, tangent, right, v);
            if (k == 0) continue;
            const auto below = first_ring + static_cast<std::uint32_t>(k - 1) * row;
            for (std::uint32_t s = 0; s < sides_; ++s) {
                const std::uint32_t a = below + s, b = a + 1, c = a + row, d = c + 1;
                add_face({a, b, d});
                add_face({a, d, c});
            }
        }
        if (bones_.parents[path_.front()] == no_id) add_cap(0, first_ring, true);
        add_cap(path_.size(), first_ring + static_cast<std::uint32_t>(path_.size()) * row, false);
    }

    void add_ring(std::size_t k, const dvec3& tangent, const dvec3& right, double v) {
        const dvec3 centre = k == 0 ? bones_.starts[path_[0]] : bones_.ends[path_[k - 1]];
        const dvec3 back = glm::cross(tangent, right);
        // The surface leans by how fast the radius falls on both sides of the ring.
        const std::size_t before = k == 0 ? 0 : k - 1, after = std::min(k, path_.size() - 1);
        const double lean = (radius(before) - radius(after + 1)) /
                            (before == after ? length(before) : length(before) + length(after));
        for (unsigned s = 0; s <= sides_; ++s) {
            const double angle = tau * (s % sides_) / sides_;
            const dvec3 outward = right * std::cos(angle) + back * std::sin(angle);
            out_.positions.emplace_back(centre + outward * radius(k));
            out_.normals.emplace_back(glm::normalize(outward + tangent * lean));
            out_.uv_sets[0].emplace_back(repeats_ * s / sides_, v);
        }
    }

    /// Closes a ring with a flat fan of its own vertices.
    void add_cap(std::size_t k, std::uint32_t ring, bool looks_back) {
        const auto first = static_cast<std::uint32_t>(out_.vertex_count());
        const dvec3 axis = heading(k == 0 ? 0 : k - 1) * (looks_back ? -1.0 : 1.0);
        for (unsigned s = 0; s < sides_; ++s) {
            const double angle = tau * s / sides_;
            out_.positions.push_back(vec3(out_.positions[ring + s]));  // a copy: the column grows
            out_.normals.emplace_back(axis);
            out_.uv_sets[0].emplace_back(vec2(std::cos(angle), std::sin(angle)) *
                                         static_cast<float>(repeats_ / tau));
        }
        for (std::uint32_t s = 1; s + 1 < sides_; ++s) {
            const uvec3 face(first, first + s, first + s + 1);
            add_face(looks_back ? uvec3(face.x, face.z, face.y) : face);
        }
    }

    void add_face(const uvec3& face) {
        out_.triangles.push_back(face);
        out_.face_materials.push_back(material_);
    }

    [[nodiscard]] dvec3 heading(std::size_t k) const { return bones_.frames[path_[k]].normal; }
    [[nodiscard]] double length(std::size_t k) const {
        return glm::distance(bones_.starts[path_[k]], bones_.ends[path_[k]]);
    }
    /// Of ring k.
    [[nodiscard]] double radius(std::size_t k) const {
        return double(k == 0 ? bones_.start_radii[path_[0]] : bones_.end_radii[path_[k - 1]]);
    }

    static constexpr double pi = 3.14159265358979323846;
    static constexpr double tau = 2 * pi;

    const skeleton& bones_;
    const branch_options& options_;
    material_id material_;
    mesh& out_;
    float thickest_ = 0;
    std::vector<std::uint32_t> path_{};
    unsigned sides_ = 3;
    double repeats_ = 1;
};

}  // namespace detail

/// Adds a frustum for every segment. Segments that continue each other form a path whose rings are
/// shared and do not twist; a side branch starts on its parent's axis, inside the bark. Tips, and
/// roots at the ground, are closed.
///
/// Shape   adds to positions, normals, uv set 0, triangles and face_materials.
/// Unit    u counts the images around the branch; v falls by length · images / (2π r) along it, so
///         that the image keeps its proportions and its upper side looks to the tip.
/// Needs   radii assigned and above zero; min_sides ≥ 3; bark_width > 0.
inline void add_branches(mesh& out, const skeleton& bones, const branch_options& options = {},
                         material_id material = 0) {
    BILLOW_ASSERT(bones.end_radii.size() == bones.segment_count());
    BILLOW_ASSERT(options.min_sides >= 3 && options.bark_width > 0);
    detail::bark_builder(bones, options, material, out).build();
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/plants/grammar.hpp
// Bracketed L-systems: a word is rewritten generation by generation into the plan of a plant.
//
// Prusinkiewicz, Lindenmayer, "The Algorithmic Beauty of Plants", 1990, chapter 1. The words are
// read by plants/turtle.hpp, where the alphabet is listed.

#include <span>
#include <string>
#include <string_view>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// `symbol` becomes `successor`. Of several productions for a symbol one is drawn by weight.
struct production {
    char symbol{};
    std::string successor{};
    double weight = 1;
};

/// A symbol without a production stays. A number in parentheses belongs to the symbol before it
/// and is never rewritten; with its symbol it goes.
struct grammar {
    std::string axiom{};
    std::vector<production> productions{};
    std::vector<production> finish{};  ///< applied once, after the last generation
};

struct expand_options {
    unsigned generations = 1;
    std::uint64_t seed = 1;                          ///< of the draws between productions
    std::size_t max_symbols = std::size_t{1} << 26;  ///< longer words are an error
};

/// Looks for a bracket or a parenthesis without its partner.
///
/// Fails   malformed, with the position of the first character that has no partner.
[[nodiscard]] inline expected<done> check_brackets(std::string_view word) {
    const auto fault = [&](std::size_t at) {
        return error{error_code::malformed, "unbalanced '" + std::string(1, word[at]) +
                                                "' at position " + std::to_string(at) +
                                                " of the plant's word"};
    };
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < word.size(); ++i) {
        if (word[i] == '[') open.push_back(i);
        if (word[i] == ']') {
            if (open.empty()) return fault(i);
            open.pop_back();
        }
        if (word[i] == ')') return fault(i);
        if (word[i] == '(') {
            const std::size_t close = word.find_first_not_of("+-.0123456789", i + 1);
            if (close == std::string_view::npos || word[close] != ')') return fault(i);
            i = close;
        }
    }
    if (!open.empty()) return fault(open.back());
    return done{};
}

namespace detail {

/// One generation, or the error of a word that grew too long. The draws depend on (seed, position),
/// so they are the same in whatever order the word is read.
[[nodiscard]] inline expected<std::string> rewrite(std::string_view word,
                                                   std::span<const production> productions,
                                                   std::uint64_t seed, std::size_t max_symbols) {
    std::string next;
    for (std::size_t i = 0; i < word.size(); ++i) {
        const char symbol = word[i];
        const std::size_t last = i + 1 < word.size() && word[i + 1] == '(' ? word.find(')', i) : i;
        double total = 0;
        for (const production& p : productions) {
            if (p.symbol == symbol) total += p.weight;
        }
        if (total > 0) {
            double left = total * random_unit(seed, i);
            const production* drawn = nullptr;
            for (const production& p : productions) {
                if (p.symbol != symbol || p.weight <= 0) continue;
                drawn = &p;
                if (left < p.weight) break;
                left -= p.weight;
            }
            next += drawn->successor;
        } else {
            next += word.substr(i, last - i + 1);
        }
        i = last;
        if (next.size() > max_symbols) {
            return error{error_code::too_large, "the plant's word is longer than " +
                                                    std::to_string(max_symbols) + " symbols"};
        }
    }
    return next;
}

}  // namespace detail

/// The word after `options.generations` rewritings of the axiom and one reading of `finish`.
///
/// Fails   malformed: a bracket of axiom or successor lacks its partner; invalid_options: a weight
///         is negative, infinite or not a number; too_large: more than `max_symbols` symbols.
/// Cost    O(length of all words).
[[nodiscard]] inline expected<std::string> expand(const grammar& rules,
                                                  const expand_options& options = {}) {
    if (auto fine = check_brackets(rules.axiom); !fine) return fine.error();
    for (const auto& productions : {rules.productions, rules.finish}) {
        for (const production& p : productions) {
            if (auto fine = check_brackets(p.successor); !fine) return fine.error();
            if (!(p.weight >= 0 && p.weight < 1e300)) {
                return error{error_code::invalid_options,
                             "a production of '" + std::string(1, p.symbol) +
                                 "' has a weight below zero or without bound"};
            }
        }
    }
    expected<std::string> word = rules.axiom;
    for (unsigned generation = 0; generation <= options.generations && word; ++generation) {
        const bool is_last = generation == options.generations;
        word = detail::rewrite(*word, is_last ? rules.finish : rules.productions,
                               mix_bits(options.seed) + generation, options.max_symbols);
    }
    return word;
}

/// The third bracket of the forest paper's production.
enum class third_branch {
    as_printed,  ///< F[+FL][FL-][>FL]: the minus after the last symbol turns nothing
    turned,      ///< F[+FL][-FL][>FL]: what was almost surely meant
};

/// The tree of "Approach geometry/image for rendering forest in real time", IJMA 3(3), 2011,
/// section 4. From the axiom F, n generations give 4^n F and 4^n - 1 L.
[[nodiscard]] inline grammar forest_paper_grammar(third_branch spelling = third_branch::turned) {
    return {.axiom = "F",
            .productions = {{'F', spelling == third_branch::as_printed ? "F[+FL][FL-][>FL]"
                                                                       : "F[+FL][-FL][>FL]"}}};
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/plants/leaf_mesh.hpp
// Leaves: textured quads around the leaf sites of a skeleton.
//
// The quad stands for a leaf, or for a small twig with several; see leaf_image.

#include <cmath>


namespace billow::inline BILLOW_ABI {

struct leaf_options {
    double per_site = 4;        ///< mean number of quads at a leaf site, whole or not
    double length = 0.3;        ///< of a quad, in scene units
    double aspect = 1;          ///< width of a quad over its length
    double size_jitter = 0.2;   ///< quads differ by up to this share of their size
    double spread_deg = 55;     ///< angle between the twig and its leaves, but the one at the end
    double turn_deg = 137.508;  ///< from one leaf to the next around the twig: the golden angle
    double along = 0.7;         ///< share of the last segment that carries leaves
    double tilt = 0.5;          ///< 0: quads look at the sky, as far as they can; 1: anywhere
    double lift = 0.15;         ///< how far leaves rise towards the light; below 0 they hang
    unsigned variants = 2;      ///< the image holds variants x variants pictures
};

/// How many quads the k-th of all sites gets, so that after n sites there are floor(n · per_site).
[[nodiscard]] inline std::size_t leaves_at_site(std::size_t k, double per_site) noexcept {
    return static_cast<std::size_t>(std::floor(double(k + 1) * per_site) -
                                    std::floor(double(k) * per_site));
}

/// Adds the leaves of every site. The middle of a quad's lower edge lies on the axis of the site's
/// segment, so no leaf floats.
///
/// Shape   floor(leaf_count · per_site) quads of two faces and four vertices; adds to positions,
///         normals, uv set 0, triangles and face_materials.
/// Needs   length, aspect > 0; size_jitter < 1; variants ≥ 1.
inline void add_leaves(mesh& out, const skeleton& bones, const leaf_options& options = {},
                       material_id material = 0, std::uint64_t seed = 1) {
    BILLOW_ASSERT(options.length > 0 && options.aspect > 0 && options.variants >= 1);
    constexpr double radian = 3.14159265358979323846 / 180;
    for (std::size_t site = 0; site < bones.leaf_count(); ++site) {
        const std::uint32_t segment = bones.leaf_segments[site];
        const frame& axes = bones.leaf_frames[site];
        const std::size_t count = leaves_at_site(site, options.per_site);
        random_stream random(mix_bits(seed) + site);
        const double first_turn = random.between(0, 360);
        for (std::size_t k = 0; k < count; ++k) {
            const double share = (double(k) + (k == 0 ? 0 : random.between(-0.4, 0.4))) /
                                 double(count) * options.along;
            const dvec3 base = glm::mix(bones.ends[segment], bones.starts[segment], share);
            const double turn = radian * (first_turn + double(k) * options.turn_deg);
            const double spread = radian * options.spread_deg *
                                  (k == 0 ? random.between(0, 0.4) : random.between(0.75, 1.25));
            const dvec3 sideways = axes.u * std::cos(turn) + axes.v * std::sin(turn);
            const dvec3 up =
                glm::normalize(axes.normal * std::cos(spread) + sideways * std::sin(spread) +
                               dvec3(0, options.lift, 0));
            // What the quad looks at: the sky and something random, across its own direction.
            const dvec3 random_look(random.between(-1, 1), random.between(-1, 1),
                                    random.between(-1, 1));
            dvec3 look = glm::mix(dvec3(0, 1, 0), random_look, options.tilt);
            look -= up * glm::dot(up, look);
            const double look_length = glm::length(look);
            const dvec3 normal = look_length > 1e-3 ? look / look_length : frame_around(up).u;
            const double length = options.length * double(bones.leaf_scales[site]) *
                                  (1 + options.size_jitter * random.between(-1, 1));
            const dvec3 across = glm::cross(up, normal) * (0.5 * options.aspect * length);

            const auto cells = options.variants;
            const auto cell = static_cast<unsigned>(random.between(0, double(cells * cells)));
            const unsigned column = cell % cells;
            const unsigned row = cell / cells;
            const vec2 corner{float(column), float(row)};
            const auto first = static_cast<std::uint32_t>(out.vertex_count());
            for (const vec2& q : {vec2(0, 1), vec2(1, 1), vec2(1, 0), vec2(0, 0)}) {
                out.positions.emplace_back(base + across * double(2 * q.x - 1) +
                                           up * (length * double(1 - q.y)));
                out.normals.emplace_back(normal);
                out.uv_sets[0].push_back((corner + q) / float(cells));
            }
            out.triangles.emplace_back(first, first + 1, first + 2);
            out.triangles.emplace_back(first, first + 2, first + 3);
            out.face_materials.insert(out.face_materials.end(), 2, material);
        }
    }
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/plants/species.hpp
// Species: a grammar, how it is walked, and what grows on it. Give one to grow() to get a mesh.

#include <algorithm>
#include <cmath>
#include <string>

// ---- billow/plants/textures.hpp
// Bark and leaves, drawn by formula: the same bytes for the same seed.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>


namespace billow::inline BILLOW_ABI {

namespace detail {

/// Gradient noise in about [-0.7, 0.7] that repeats after `period` lattice cells.
///
/// Source  Perlin, "An image synthesizer", 1985; the smoothstep of 2002.
[[nodiscard]] inline double tiling_noise(double x, double y, int period_x, int period_y,
                                         std::uint64_t seed) noexcept {
    static constexpr double d = 0.70710678118654752;
    static constexpr double directions[8][2] = {{1, 0},  {d, d},   {0, 1},  {-d, d},
                                                {-1, 0}, {-d, -d}, {0, -1}, {d, -d}};
    const double cell_x = std::floor(x), cell_y = std::floor(y);
    const auto corner = [&](int dx, int dy) {
        const auto wrap = [](int i, int period) { return (i % period + period) % period; };
        const int i = wrap(int(cell_x) + dx, period_x), j = wrap(int(cell_y) + dy, period_y);
        const auto bits = mix_bits(mix_bits(seed) ^ static_cast<std::uint64_t>(j * period_x + i));
        const auto& direction = directions[bits >> 61];
        return direction[0] * (x - cell_x - dx) + direction[1] * (y - cell_y - dy);
    };
    const auto smooth = [](double t) { return t * t * t * (t * (6 * t - 15) + 10); };
    const double s = smooth(x - cell_x), t = smooth(y - cell_y);
    return std::lerp(std::lerp(corner(0, 0), corner(1, 0), s),
                     std::lerp(corner(0, 1), corner(1, 1), s), t);
}

/// Blends two colours of bytes.
[[nodiscard]] inline vec3 blend(const vec3& a, const vec3& b, double share) noexcept {
    return glm::mix(a, b, static_cast<float>(std::clamp(share, 0.0, 1.0)));
}

}  // namespace detail

struct bark_image_options {
    int size = 256;                    ///< width and height, in texels
    vec3 ridge{0.52f, 0.45f, 0.37f};   ///< sRGB of the ridges
    vec3 furrow{0.16f, 0.12f, 0.09f};  ///< sRGB between them
    int ridges = 7;                    ///< from left to right
    int plates = 3;                    ///< from top to bottom: long ridges for few, plates for many
    std::uint64_t seed = 1;
};

/// Bark: ridges of folded noise, stretched along the stem. It tiles both ways.
[[nodiscard]] inline image bark_image(const bark_image_options& options = {}) {
    image bark = image::filled(options.size, options.size, 4, 255);
    for (int y = 0; y < options.size; ++y) {
        for (int x = 0; x < options.size; ++x) {
            const double u = (x + 0.5) / options.size, v = (y + 0.5) / options.size;
            // Furrows wind: the noise is read at a place moved by a slower noise.
            const double bend = 0.09 * detail::tiling_noise(3 * u, 3 * v, 3, 3, options.seed);
            double height = 0, weight = 0.62, total = 0;
            for (int octave = 0; octave < 4; ++octave) {
                const int nx = options.ridges << octave, ny = options.plates << octave;
                const double n =
                    detail::tiling_noise((u + bend) * nx, (v + bend) * ny, nx, ny,
                                         options.seed + 1 + static_cast<std::uint64_t>(octave));
                // Folded noise: its zeros are the furrows.
                height += weight * std::min(1.0, 2.6 * std::abs(n));
                total += weight;
                weight *= 0.45;
            }
            const double stain = detail::tiling_noise(4 * u, 2 * v, 4, 2, options.seed + 9);
            const vec3 color = detail::blend(options.furrow, options.ridge, height / total) *
                               static_cast<float>(1 + 0.35 * stain);
            for (int c = 0; c < 3; ++c) {
                bark.pixel(x, y)[c] = byte_from_unit(color[c]);
            }
        }
    }
    return bark;
}

struct leaf_image_options {
    int size = 512;                   ///< width and height, in texels
    unsigned variants = 2;            ///< variants x variants pictures with other leaves and hues
    unsigned leaves = 9;              ///< on the twig of a picture; 1: a single leaf
    double slenderness = 2.1;         ///< length of a leaf over its width
    vec3 young{0.46f, 0.60f, 0.20f};  ///< sRGB of the brightest leaf
    vec3 old{0.20f, 0.36f, 0.10f};    ///< sRGB of the darkest one
    vec3 twig{0.33f, 0.25f, 0.16f};   ///< sRGB
    std::uint64_t seed = 1;
};

namespace detail {

/// A leaf of a picture: its foot, its direction, its length and a shade. Plane (x, y) with y up,
/// the picture being [0, 1]².
struct drawn_leaf {
    dvec2 foot, axis;
    double length = 0;
    double shade = 0;  ///< 0 old to 1 young
};

/// A twig from the middle of the lower edge, its leaves alternating to both sides and one in front.
[[nodiscard]] inline std::vector<drawn_leaf> arrange_leaves(const leaf_image_options& options,
                                                            std::uint64_t seed) {
    if (options.leaves <= 1) return {{{0.5, 0.06}, {0, 1}, 0.9, random_unit(seed, 0)}};
    std::vector<drawn_leaf> leaves;
    random_stream random(seed);
    const unsigned side_count = options.leaves - 1;
    for (unsigned k = 0; k < side_count; ++k) {
        const double up = (k + 0.5) / side_count;
        const double angle = (1.15 - 0.55 * up) * random.between(0.85, 1.15);
        const double side = k % 2 == 0 ? 1 : -1;
        leaves.push_back({.foot = {0.5, 0.1 + 0.5 * up},
                          .axis = {side * std::sin(angle), std::cos(angle)},
                          .length = random.between(0.36, 0.44) * (1.05 - 0.25 * up),
                          .shade = random.between(0.1, 0.7) + 0.3 * up});
    }
    leaves.push_back({.foot = {0.5, 0.6},
                      .axis = {0, 1},
                      .length = random.between(0.34, 0.38),
                      .shade = random.between(0.5, 1)});
    return leaves;
}

/// Whether `point` lies on the leaf, and then its colour: midrib, side veins, a darker rim.
[[nodiscard]] inline bool shade_leaf(const drawn_leaf& leaf, const leaf_image_options& options,
                                     const dvec2& point, vec3& color) noexcept {
    const dvec2 offset = (point - leaf.foot) / leaf.length;
    const double along = glm::dot(offset, leaf.axis);
    const double across = leaf.axis.x * offset.y - leaf.axis.y * offset.x;
    const double side = std::abs(across);
    if (along < 0 || along > 1 || side > 0.6 / options.slenderness) return false;
    const double stalk = 0.12;
    const double t = (along - stalk) / (1 - stalk);  // 0 at the blade's foot, 1 at its tip
    const double teeth = 1 + 0.06 * (std::abs(std::fmod(along * 14, 1.0) - 0.5) - 0.25);
    // Widest below the middle, rounded at the foot, drawn out at the tip.
    const double half_width =
        t <= 0 ? 0 : std::sqrt(t) * (1 - t) * (1.3 + 0.9 * t) * teeth / (1.2 * options.slenderness);
    const double rib = 0.016 * (1.3 - along);
    if (side > std::max(half_width, rib)) return false;
    const vec3 blade = blend(options.old, options.young, leaf.shade);
    if (side < rib) {
        color = blend(blade, options.young * 1.25f, 0.7);
        return true;
    }
    const double edge = side / half_width;
    const double vein = std::abs(std::fmod(along * 9 - side * 6 + 9, 1.0) - 0.5);  // 0.5: on it
    color = blade * static_cast<float>((across > 0 ? 1.06 : 0.94) * (1.05 - 0.2 * edge * edge));
    if (vein > 0.42) color = blend(color, options.young * 1.15f, 0.45 * (1 - edge));
    return true;
}

}  // namespace detail

/// Pictures of leaves on their twigs, or of single leaves, side by side; all stand on the middle
/// of their lower edge. Alpha is the covered share of a texel; texels without a leaf carry the mean
/// leaf colour, so that filters find no foreign colour at the rims.
[[nodiscard]] inline image leaf_image(const leaf_image_options& options = {}) {
    constexpr int grid = 4;  // samples along a texel's side
    image leaves = image::filled(options.size, options.size, 4, 0);
    const int cell_size = options.size / static_cast<int>(options.variants);
    dvec3 sum{0};
    double covered = 0;
    for (unsigned cell = 0; cell < options.variants * options.variants; ++cell) {
        const auto twig = detail::arrange_leaves(options, mix_bits(options.seed) + cell);
        const int left = static_cast<int>(cell % options.variants) * cell_size;
        const int top = static_cast<int>(cell / options.variants) * cell_size;
        for (int y = 0; y < cell_size; ++y) {
            for (int x = 0; x < cell_size; ++x) {
                vec3 total{0};
                int hits = 0;
                for (int s = 0; s < grid * grid; ++s) {
                    const int column = s % grid;
                    const int row = s / grid;
                    const dvec2 point((x + (column + 0.5) / grid) / cell_size,
                                      1 - (y + (row + 0.5) / grid) / cell_size);
                    vec3 color{0};
                    bool is_hit = false;
                    for (std::size_t k = twig.size(); k-- > 0 && !is_hit;) {  // the last is on top
                        is_hit = detail::shade_leaf(twig[k], options, point, color);
                    }
                    if (!is_hit && options.leaves > 1 && point.y < 0.62 &&
                        std::abs(point.x - 0.5) < 0.011 * (1.2 - point.y)) {
                        color = options.twig;
                        is_hit = true;
                    }
                    if (!is_hit) continue;
                    total += color;
                    ++hits;
                }
                if (hits == 0) continue;
                total /= float(hits);
                sum += dvec3(total) * double(hits);
                covered += hits;
                std::uint8_t* texel = leaves.pixel(left + x, top + y);
                for (int c = 0; c < 3; ++c) texel[c] = byte_from_unit(total[c]);
                texel[3] = byte_from_unit(float(hits) / float(grid * grid));
            }
        }
    }
    const vec3 mean = covered > 0 ? vec3(sum / covered) : options.old;
    for (int y = 0; y < options.size; ++y) {
        for (int x = 0; x < options.size; ++x) {
            std::uint8_t* texel = leaves.pixel(x, y);
            if (texel[3] != 0) continue;
            for (int c = 0; c < 3; ++c) texel[c] = byte_from_unit(mean[c]);
        }
    }
    return leaves;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/plants/turtle.hpp
// The turtle that walks a word of plants/grammar.hpp through space.
//
// Prusinkiewicz, Lindenmayer, "The Algorithmic Beauty of Plants", 1990, sections 1.5 to 1.7.
//
//   F f       go forward, drawing a segment / without a trace    L      grow a leaf
//   + -       turn left / right, about the upper side            [ ]    remember / return
//   & ^       pitch down / up, about the left side               "      shrink the step
//   / \ > <   roll right / left / right / left, about the heading; the forest paper uses > and
//             leaves its meaning open
//   |         turn around
//   $         roll until the left side is level, so that + and - turn along the horizon
//
// Other symbols say nothing. A number behind a symbol replaces its angle in degrees (turns), or
// multiplies its length (F f), size (L) or step (").

#include <cmath>
#include <string_view>
#include <utility>


namespace billow::inline BILLOW_ABI {

struct turtle_options {
    double step = 1;           ///< length of F, in scene units
    double shrink = 0.8;       ///< factor of "
    double angle_deg = 25;     ///< of a turn without a number
    double angle_jitter = 0;   ///< turns differ by up to this share of themselves
    double length_jitter = 0;  ///< segments differ by up to this share of their length
    double wander_deg = 0;     ///< a segment strays by up to this angle from its heading
    dvec3 tropism{0};          ///< segments bend this way; its length is the angle in radians at
                               ///< which a segment across it bends (light: +y, weight: -y)
};

namespace detail {

/// `vector` turned about the unit `axis`.
[[nodiscard]] inline dvec3 rotated(const dvec3& vector, const dvec3& axis, double angle) noexcept {
    const double c = std::cos(angle), s = std::sin(angle);
    return vector * c + glm::cross(axis, vector) * s + axis * (glm::dot(axis, vector) * (1 - c));
}

/// The frame is made orthonormal again: rotating about axes of a length that is not quite 1, one
/// after the other, triples the error every time.
[[nodiscard]] inline frame rotated(const frame& f, const dvec3& axis, double angle) noexcept {
    const dvec3 normal = glm::normalize(rotated(f.normal, axis, angle));
    const dvec3 u = rotated(f.u, axis, angle);
    const dvec3 left = glm::normalize(u - normal * glm::dot(normal, u));
    return {.u = left, .v = glm::cross(normal, left), .normal = normal};
}

/// The decimal number `text`, whatever the locale. Anything else is NaN.
[[nodiscard]] inline double parse_decimal(std::string_view text) noexcept {
    const bool is_negative = text.starts_with('-');
    if (is_negative || text.starts_with('+')) text.remove_prefix(1);
    double value = 0, unit = 0;
    bool has_digit = false;
    for (const char c : text) {
        if (c == '.' && unit == 0) {
            unit = 1;
        } else if (c >= '0' && c <= '9') {
            has_digit = true;
            value = value * 10 + (c - '0');
            unit *= 10;
        } else {
            return std::nan("");
        }
    }
    if (!has_digit) return std::nan("");
    if (unit > 0) value /= unit;
    return is_negative ? -value : value;
}

/// Reads one word. Random numbers come from (seed, position in the word).
class turtle {
public:
    turtle(std::string_view word, const turtle_options& options, std::uint64_t seed)
        : word_(word), options_(options), seed_(seed) {}

    [[nodiscard]] expected<skeleton> walk() {
        for (std::size_t i = 0; i < word_.size(); ++i) {
            position_ = i;
            const char symbol = word_[i];
            double number = std::nan("");
            if (i + 1 < word_.size() && word_[i + 1] == '(') {
                const std::size_t close = word_.find(')', i);
                number = parse_decimal(word_.substr(i + 2, close - i - 2));
                if (std::isnan(number)) {
                    return error{error_code::malformed,
                                 "no number in the parentheses at position " +
                                     std::to_string(i + 1) + " of the plant's word"};
                }
                i = close;
            }
            obey(symbol, number);
        }
        return std::move(bones_);
    }

private:
    struct state {
        dvec3 position{0};
        frame axes{.u = {-1, 0, 0}, .v = {0, 0, 1}, .normal = {0, 1, 0}};
        double step = 1;
        std::uint32_t segment = no_id;
    };

    void obey(char symbol, double number) {
        frame& f = now_.axes;
        const auto turn = [&](const dvec3& axis, double sign) {
            const double degrees = std::isnan(number) ? options_.angle_deg : number;
            f = rotated(f, axis, sign * radians(degrees) * (1 + options_.angle_jitter * jitter(0)));
        };
        const double factor = std::isnan(number) ? 1 : number;
        switch (symbol) {
            case '+':
                turn(f.v, 1);
                break;
            case '-':
                turn(f.v, -1);
                break;
            case '&':
                turn(f.u, 1);
                break;
            case '^':
                turn(f.u, -1);
                break;
            case '/':
            case '>':
                turn(f.normal, 1);
                break;
            case '\\':
            case '<':
                turn(f.normal, -1);
                break;
            case '|':
                f = {.u = -f.u, .v = f.v, .normal = -f.normal};
                break;
            case '$':
                level();
                break;
            case '"':
                now_.step *= std::isnan(number) ? options_.shrink : number;
                break;
            case '[':
                stack_.push_back(now_);
                break;
            case ']':
                now_ = stack_.back();
                stack_.pop_back();
                break;
            case 'F':
            case 'f':
                go(factor, symbol == 'F');
                break;
            case 'L':
                grow_leaf(factor);
                break;
            default:
                break;
        }
    }

    void go(double factor, bool draws) {
        frame& f = now_.axes;
        // The first segment of a root goes straight up, so that it stands flat on the ground.
        const double stray = now_.segment == no_id ? 0 : radians(options_.wander_deg);
        f = rotated(f, f.u, stray * jitter(1));
        f = rotated(f, f.v, stray * jitter(2));
        const dvec3 bend = glm::cross(f.normal, options_.tropism);
        const double angle = glm::length(bend);  // |tropism| sin of the angle to it
        if (angle > 1e-12) f = rotated(f, bend / angle, angle);
        const double length =
            options_.step * now_.step * factor * (1 + options_.length_jitter * jitter(3));
        if (!(length > 0)) return;
        const dvec3 end = now_.position + f.normal * length;
        if (draws) {
            bones_.parents.push_back(now_.segment);
            bones_.starts.push_back(now_.position);
            bones_.ends.push_back(end);
            bones_.frames.push_back(f);
            now_.segment = static_cast<std::uint32_t>(bones_.segment_count() - 1);
        } else {
            now_.segment = no_id;
        }
        now_.position = end;
    }

    /// A leaf with no segment to hang on is not grown.
    void grow_leaf(double factor) {
        if (now_.segment == no_id) return;
        bones_.leaf_segments.push_back(now_.segment);
        bones_.leaf_frames.push_back(now_.axes);
        bones_.leaf_scales.push_back(static_cast<float>(factor));
    }

    void level() {
        frame& f = now_.axes;
        const dvec3 left = glm::cross(dvec3(0, 1, 0), f.normal);
        const double length = glm::length(left);
        if (length < 1e-6) return;  // upright: every left side is level
        f.u = left / length;
        f.v = glm::cross(f.normal, f.u);
    }

    [[nodiscard]] static double radians(double degrees) noexcept {
        return degrees * (3.14159265358979323846 / 180);
    }

    /// One of four numbers in [-1, 1) that belong to the symbol.
    [[nodiscard]] double jitter(std::size_t which) const noexcept {
        return 2 * random_unit(seed_, 4 * position_ + which) - 1;
    }

    std::string_view word_;
    const turtle_options& options_;
    std::uint64_t seed_;
    std::size_t position_ = 0;
    state now_{};
    std::vector<state> stack_{};
    skeleton bones_{};
};

}  // namespace detail

/// The skeleton that `word` plans, standing on the origin and growing towards +y; radii are left
/// to assign_radii.
///
/// Fails   malformed: a bracket without partner, a number that is none; invalid_options: a length
///         or an angle that is not finite, or a step or shrink of zero or less.
/// Cost    O(length of the word).
[[nodiscard]] inline expected<skeleton> interpret(std::string_view word,
                                                  const turtle_options& options = {},
                                                  std::uint64_t seed = 1) {
    if (auto fine = check_brackets(word); !fine) return fine.error();
    const double sum = options.step + options.shrink + options.angle_deg + options.angle_jitter +
                       options.length_jitter + options.wander_deg + options.tropism.x +
                       options.tropism.y + options.tropism.z;
    if (!std::isfinite(sum) || options.step <= 0 || options.shrink <= 0) {
        return error{error_code::invalid_options,
                     "the turtle's step and shrink must be above zero, and all numbers finite"};
    }
    return detail::turtle(word, options, seed).walk();
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct species {
    std::string name{};
    grammar rules{};
    unsigned generations = 5;
    double height = 8;  ///< of the highest twig above the ground, in scene units (metres)
    turtle_options turtle{};
    radius_options radii{};
    branch_options branches{};
    leaf_options leaves{};
    bark_image_options bark{};
    leaf_image_options foliage{};
};

/// A broadleaf tree of 8 m and, seed by seed, 15,000 to 23,000 faces: a stem that carries on to the
/// top (A) with limbs at the golden angle, which branch (B) to both sides and rise to the light. A
/// twig keeps its leaves for three generations (L, K, J).
[[nodiscard]] inline species broadleaf() {
    return {.name = "broadleaf",
            .rules = {.axiom = "F(0.45)F(0.45)F(0.45)F(0.45)A",
                      .productions = {{'A',
                                       "F(0.55)[&(62)\"(0.88)$/(90)B]/(137.508)"
                                       "F(0.55)[&(58)\"(0.8)$/(90)B]/(137.508)\"(0.92)A"},
                                      {'B', "FL[&(45)\"B]/(155)\"(0.92)B", 0.72},
                                      {'B', "FL/(155)\"(0.94)B", 0.28},
                                      {'L', "K"},
                                      {'K', "J"},
                                      {'J', ""}},
                      .finish = {{'A', "FL"}, {'B', "FL"}, {'K', "L"}, {'J', "L"}}},
            .generations = 10,
            .turtle = {.shrink = 0.75,
                       .angle_jitter = 0.2,
                       .length_jitter = 0.25,
                       .wander_deg = 6,
                       .tropism = {0, 0.14, 0}},
            .radii = {.trunk = 0.14},
            .leaves = {.per_site = 3.2, .length = 0.34}};
}

/// The tree of the forest paper (see forest_paper_grammar): 4^n segments for n generations.
[[nodiscard]] inline species forest_paper_tree(third_branch spelling = third_branch::turned) {
    return {.name = "forest paper",
            .rules = forest_paper_grammar(spelling),
            .generations = 5,
            .turtle = {.angle_deg = 28, .angle_jitter = 0.25, .length_jitter = 0.25},
            .leaves = {.per_site = 1, .length = 0.7}};
}

namespace detail {

/// The skeleton of a species in its final size.
[[nodiscard]] inline expected<skeleton> grow_skeleton(const species& kind, std::uint64_t seed) {
    if (!(kind.height > 0) || !std::isfinite(kind.height) || !(kind.radii.trunk > 0)) {
        return error{error_code::invalid_options,
                     "a plant's height and trunk radius must be above zero"};
    }
    const auto word = expand(kind.rules, {.generations = kind.generations, .seed = seed});
    if (!word) return word.error();
    auto bones = interpret(*word, kind.turtle, mix_bits(seed));
    if (!bones) return bones;
    if (auto scaled = scale_to_height(*bones, kind.height); !scaled) return scaled.error();
    assign_radii(*bones, kind.radii);
    return bones;
}

}  // namespace detail

/// The species with as many generations and leaves as make a plant of `face_count` faces: at most
/// 60 % of them bark, the others leaves, whose size keeps the crown as dense as it was.
///
/// Gives   a species that grows `face_count` faces, or one less, from this `seed`.
/// Fails   as grow; invalid_options when `face_count` is too small for the species' stem.
[[nodiscard]] inline expected<species> with_face_count(species kind, std::size_t face_count,
                                                       std::uint64_t seed = 1) {
    const auto usual = detail::grow_skeleton(kind, seed);
    if (!usual) return usual.error();
    const double usual_leaves = double(usual->leaf_count()) * kind.leaves.per_site;
    std::size_t bark_faces = 0, sites = 0;
    unsigned best = 0;
    for (unsigned generation = 0;; ++generation) {
        kind.generations = generation;
        const auto bones = detail::grow_skeleton(kind, seed);
        if (!bones) return bones.error();
        mesh bark;
        add_branches(bark, *bones, kind.branches);
        const bool is_first = sites == 0;
        if (bark.face_count() > (is_first ? face_count : face_count * 3 / 5)) break;
        if (!is_first && bark.face_count() <= bark_faces) break;  // a grammar that does not grow
        best = generation;
        bark_faces = bark.face_count();
        sites = bones->leaf_count();
    }
    if (sites == 0) {
        return error{error_code::invalid_options, "no plant of this species has as few as " +
                                                      std::to_string(face_count) +
                                                      " faces, leaves among them"};
    }
    kind.generations = best;
    const std::size_t leaf_quads = (face_count - bark_faces) / 2;
    const auto leaves = static_cast<double>(leaf_quads);
    kind.leaves.per_site = (leaves + 0.5) / double(sites);
    kind.leaves.length *= std::clamp(std::sqrt(usual_leaves / std::max(1.0, leaves)), 0.4, 3.0);
    return kind;
}

/// A plant of the species: bark (material 0, "bark", opaque) and leaves (material 1, "leaf", alpha
/// mask, double-sided). Y is up, the root stands on the origin. The same seed gives the same bytes.
///
/// Fails   as expand, interpret and scale_to_height do; invalid_options for a height or trunk
///         radius of zero or less.
[[nodiscard]] inline expected<mesh> grow(const species& kind, std::uint64_t seed = 1) {
    const auto bones = detail::grow_skeleton(kind, seed);
    if (!bones) return bones.error();
    mesh plant;
    add_branches(plant, *bones, kind.branches, 0);
    leaf_options leaves = kind.leaves;
    leaves.variants = kind.foliage.variants;
    add_leaves(plant, *bones, leaves, 1, mix_bits(seed) + 1);
    plant.images = {bark_image(kind.bark), leaf_image(kind.foliage)};
    plant.materials = {
        {.name = "bark", .base_color_texture = {.image = 0}, .metallic = 0, .roughness = 0.95f},
        {.name = "leaf",
         .base_color_texture = {.image = 1,
                                .wrap_u = texture_wrap::clamp_to_edge,
                                .wrap_v = texture_wrap::clamp_to_edge},
         .metallic = 0,
         .roughness = 0.75f,
         .alpha = alpha_mode::mask,
         .alpha_cutoff = 0.5f,
         .is_double_sided = true}};
    return plant;
}

/// The broadleaf tree with `face_count` faces, or one less: foliage of any size for trials.
///
/// Fails   as with_face_count.
[[nodiscard]] inline expected<mesh> tree_of_about(std::size_t face_count, std::uint64_t seed = 1) {
    const auto kind = with_face_count(broadleaf(), face_count, seed);
    if (!kind) return kind.error();
    return grow(*kind, seed);
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/shapes/box.hpp
// Boxes: the plain one, and one with a picture on every side.

#include <string>
#include <utility>


namespace billow::inline BILLOW_ABI {

/// An axis-aligned box around the origin, every side cut into `segments` x `segments` squares.
///
/// Shape   6 sides in the order +x -x +y -y +z -z with 2 segments² faces each; the sides share no
///         vertices, so normals and uvs are exact. Every side covers uv [0, 1]², seen upright.
/// Needs   segments ≥ 1.
[[nodiscard]] inline mesh box(const vec3& size = vec3(1), int segments = 1) {
    BILLOW_ASSERT(segments >= 1);
    struct side {
        vec3 normal, right, up;
    };
    static constexpr side sides[] = {
        {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
        {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}}, {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
        {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}}};
    mesh out;
    for (const auto& [normal, right, up] : sides) {
        const auto first = static_cast<std::uint32_t>(out.vertex_count());
        const auto width = static_cast<std::uint32_t>(segments + 1);
        for (int i = 0; i <= segments; ++i) {
            for (int j = 0; j <= segments; ++j) {
                const vec2 uv(float(j) / float(segments), float(i) / float(segments));
                out.positions.push_back(
                    size * (0.5f * normal + (uv.x - 0.5f) * right + (0.5f - uv.y) * up));
                out.normals.push_back(normal);
                out.uv_sets[0].push_back(uv);
            }
        }
        for (std::uint32_t i = 0; i + 1 < width; ++i) {
            for (std::uint32_t j = 0; j + 1 < width; ++j) {
                const std::uint32_t a = first + i * width + j, c = a + width;
                out.triangles.emplace_back(a, c, c + 1);
                out.triangles.emplace_back(a, c + 1, a + 1);
            }
        }
    }
    return out;
}

/// A cube of edge 1 whose six sides carry six pictures of `size` x `size` texels, each in its own
/// image: quarters of the side's colour at four brightnesses, so a turned or mirrored side shows.
[[nodiscard]] inline mesh textured_cube(int size = 64) {
    static constexpr int colors[6][3] = {{230, 60, 50},  {60, 200, 220}, {80, 200, 70},
                                         {200, 70, 210}, {60, 90, 230},  {230, 200, 60}};
    mesh cube = box();
    for (material_id side = 0; side < 6; ++side) {
        image picture = image::filled(size, size, 4, 255);
        for (int y = 0; y < size; ++y) {
            for (int x = 0; x < size; ++x) {
                const int quarter = (2 * y >= size ? 2 : 0) + (2 * x >= size ? 1 : 0);
                for (std::size_t c = 0; c < 3; ++c) {
                    picture.pixel(x, y)[c] =
                        static_cast<std::uint8_t>(colors[side][c] * (4 - quarter) / 4);
                }
            }
        }
        cube.images.push_back(std::move(picture));
        cube.materials.push_back({.name = "side " + std::to_string(side),
                                  .base_color_texture = {.image = side,
                                                         .wrap_u = texture_wrap::clamp_to_edge,
                                                         .wrap_v = texture_wrap::clamp_to_edge},
                                  .metallic = 0});
        cube.face_materials.insert(cube.face_materials.end(), 2, side);
    }
    return cube;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/shapes/leaf_soup.hpp
// Loose leaves in a ball: foliage at its hardest, with no structure that a search could use.

#include <cmath>


namespace billow::inline BILLOW_ABI {

struct leaf_soup_options {
    float edge = 0.05f;      ///< edge of a leaf; the ball has radius 1
    std::uint64_t seed = 1;  ///< other seeds, other soups
};

/// Square leaves whose centres are uniform in the unit ball, each turned at random.
///
/// Shape   `face_count` faces, two a leaf; an odd count leaves the last leaf half. Every leaf owns
///         its four vertices and covers uv [0, 1]².
[[nodiscard]] inline mesh leaf_soup(std::size_t face_count, const leaf_soup_options& options = {}) {
    constexpr double tau = 6.283185307179586;
    mesh soup;
    const std::size_t leaf_count = (face_count + 1) / 2;
    soup.positions.reserve(4 * leaf_count);
    soup.triangles.reserve(2 * leaf_count);
    random_stream random(options.seed);
    const auto direction = [&] {
        const double z = random.between(-1, 1), angle = random.between(0, tau);
        const double r = std::sqrt(1 - z * z);
        return dvec3(r * std::cos(angle), r * std::sin(angle), z);
    };
    for (std::size_t leaf = 0; leaf < leaf_count; ++leaf) {
        const dvec3 towards = direction();
        const dvec3 centre = towards * std::cbrt(random.unit());
        const frame around = frame_around(direction());
        const double turn = random.between(0, tau), half = 0.5 * double(options.edge);
        const dvec3 right = (around.u * std::cos(turn) + around.v * std::sin(turn)) * half;
        const dvec3 up = (around.v * std::cos(turn) - around.u * std::sin(turn)) * half;
        const auto first = static_cast<std::uint32_t>(soup.vertex_count());
        for (const dvec2& corner : {dvec2(-1, -1), dvec2(1, -1), dvec2(1, 1), dvec2(-1, 1)}) {
            soup.positions.emplace_back(centre + corner.x * right + corner.y * up);
            soup.normals.emplace_back(around.normal);
            soup.uv_sets[0].emplace_back(0.5 + 0.5 * corner.x, 0.5 - 0.5 * corner.y);
        }
        soup.triangles.emplace_back(first, first + 1, first + 2);
        soup.triangles.emplace_back(first, first + 2, first + 3);
    }
    soup.triangles.resize(face_count);
    soup.materials = {{.name = "leaf",
                       .base_color = {0.15f, 0.35f, 0.08f, 1},
                       .metallic = 0,
                       .is_double_sided = true}};
    return soup;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/shapes/sphere.hpp
// Spheres.

#include <algorithm>
#include <map>
#include <utility>


namespace billow::inline BILLOW_ABI {

/// The unit sphere as an icosahedron whose faces were cut in four `levels` times: nearly equal
/// triangles, closed, no seam, normals but no uvs.
///
/// Shape   20 · 4^levels faces, 10 · 4^levels + 2 vertices.
[[nodiscard]] inline mesh icosphere(unsigned levels) {
    constexpr float g = 1.618033989f;  // the golden ratio
    mesh ball;
    ball.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (vec3& p : ball.positions) p = glm::normalize(p);
    ball.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                      {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                      {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                      {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (unsigned level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [place, is_new] = middles.try_emplace(
                std::minmax(a, b), static_cast<std::uint32_t>(ball.vertex_count()));
            if (is_new) {
                ball.positions.push_back(glm::normalize(ball.positions[a] + ball.positions[b]));
            }
            return place->second;
        };
        std::vector<uvec3> finer;
        finer.reserve(4 * ball.face_count());
        for (const uvec3& t : ball.triangles) {
            const uvec3 m(middle(t.y, t.z), middle(t.z, t.x), middle(t.x, t.y));
            finer.insert(finer.end(), {{t.x, m.z, m.y}, {m.z, t.y, m.x}, {m.y, m.x, t.z}, m});
        }
        ball.triangles = std::move(finer);
    }
    ball.normals = ball.positions;
    return ball;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/shapes/teapot.hpp
// The Utah teapot: Martin Newell, University of Utah, 1975.
//
// The control points are Newell's, in the common form whose height Blinn divided by 1.3. They are
// kept in a shorter spelling: rim, body, bottom, knob and lid turn around the axis with the handle
// length 0.56 r, so their profiles say it all (the knob is written with 0.45 for 0.8); handle and
// spout are mirrored, so one half says it all. Written out they are the 32 patches. The lid is as
// published, too: 0.1 narrower than the rim that it lies in.

#include <algorithm>
#include <array>
#include <span>
#include <utility>


namespace billow::inline BILLOW_ABI {

namespace detail {

/// Bicubic Bézier patches side by side: (3 rows + 1) x (3 columns + 1) control points, z up.
struct bezier_sheet {
    int rows = 0;
    int columns = 0;
    std::vector<dvec3> points{};

    [[nodiscard]] const dvec3& point(int row, int column) const noexcept {
        return points[static_cast<std::size_t>(row * (3 * columns + 1) + column)];
    }
};

/// The four Bernstein polynomials of degree 3 at `t`, and their derivatives.
struct bernstein {
    explicit bernstein(double t)
        : value{(1 - t) * (1 - t) * (1 - t), 3 * t * (1 - t) * (1 - t), 3 * t * t * (1 - t),
                t * t * t},
          slope{-3 * (1 - t) * (1 - t), 3 * (1 - t) * (1 - 3 * t), 3 * t * (2 - 3 * t), 3 * t * t} {
    }
    std::array<double, 4> value, slope;
};

struct surface_point {
    dvec3 position, normal;
};

/// The point of grid line (i, j) when every patch is cut into `segments` x `segments`.
[[nodiscard]] inline surface_point evaluate(const bezier_sheet& sheet, int i, int j, int segments) {
    const int row = std::min(i / segments, sheet.rows - 1);
    const int column = std::min(j / segments, sheet.columns - 1);
    const bernstein s(double(i - row * segments) / segments);
    const bernstein t(double(j - column * segments) / segments);
    dvec3 position{0}, along{0}, around{0}, twist{0};
    for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
            const dvec3& p = sheet.point(3 * row + int(a), 3 * column + int(b));
            position += s.value[a] * t.value[b] * p;
            along += s.slope[a] * t.value[b] * p;
            around += s.value[a] * t.slope[b] * p;
            twist += s.slope[a] * t.slope[b] * p;
        }
    }
    dvec3 normal = glm::cross(around, along);
    if (glm::dot(normal, normal) < 1e-18) {  // a pole: `around` vanishes, its change does not
        normal = glm::cross(i == 0 ? twist : -twist, along);
    }
    return {position, glm::normalize(normal)};
}

/// Adds the sheet, turned to y up. Faces with two corners in a pole are left out.
inline void tessellate(const bezier_sheet& sheet, int segments, mesh& out) {
    const auto first = static_cast<std::uint32_t>(out.vertex_count());
    const int height = sheet.rows * segments, width = sheet.columns * segments;
    for (int i = 0; i <= height; ++i) {
        for (int j = 0; j <= width; ++j) {
            // The last column repeats the first one bit for bit; only its u differs.
            const auto [p, n] = evaluate(sheet, i, j == width ? 0 : j, segments);
            out.positions.emplace_back(p.x, p.z, -p.y);
            out.normals.emplace_back(n.x, n.z, -n.y);
            out.uv_sets[0].emplace_back(1 - float(j) / float(width), float(i) / float(height));
        }
    }
    const auto is_pole = [&](int row) { return sheet.point(row, 0) == sheet.point(row, 1); };
    for (int i = 0; i < height; ++i) {
        for (int j = 0; j < width; ++j) {
            const auto a = first + static_cast<std::uint32_t>(i * (width + 1) + j);
            const auto c = a + static_cast<std::uint32_t>(width + 1);
            if (i > 0 || !is_pole(0)) out.triangles.emplace_back(a, a + 1, c);
            if (i + 1 < height || !is_pole(3 * sheet.rows)) {
                out.triangles.emplace_back(a + 1, c + 1, c);
            }
        }
    }
}

/// Turns a profile of (radius, height) around the z axis: four quarters.
[[nodiscard]] inline bezier_sheet turned(std::span<const dvec2> profile) {
    bezier_sheet sheet{.rows = static_cast<int>(profile.size()) / 3, .columns = 4};
    for (const dvec2& p : profile) {
        const double r = p.x, h = p.y, k = r == 0.8 ? 0.45 : 0.56 * r;
        for (const dvec2& q : {dvec2(r, 0), dvec2(r, -k), dvec2(k, -r),     //
                               dvec2(0, -r), dvec2(-k, -r), dvec2(-r, -k),  //
                               dvec2(-r, 0), dvec2(-r, k), dvec2(-k, r),    //
                               dvec2(0, r), dvec2(k, r), dvec2(r, k), dvec2(r, 0)}) {
            sheet.points.emplace_back(q, h);
        }
    }
    return sheet;
}

/// One row of a tube: the (x, z) where it crosses the plane of symmetry, and its half width.
struct tube_row {
    dvec2 from, to;
    double half_width;
};

[[nodiscard]] inline bezier_sheet mirrored(std::span<const tube_row> rows) {
    bezier_sheet sheet{.rows = static_cast<int>(rows.size()) / 3, .columns = 2};
    for (const auto& [from, to, w] : rows) {
        for (const auto& [p, y] :
             {std::pair{from, 0.0}, std::pair{from, -w}, std::pair{to, -w}, std::pair{to, 0.0},
              std::pair{to, w}, std::pair{from, w}, std::pair{from, 0.0}}) {
            sheet.points.emplace_back(p.x, y, p.y);
        }
    }
    return sheet;
}

}  // namespace detail

/// The Utah teapot, each of its 32 patches cut into `segments` x `segments` cells.
///
/// Shape   64 segments² - 8 segments faces (6,320 at 10). Vertices are shared inside rim, body and
///         bottom, knob, lid, handle and spout; along the seam of u = 0 and 1 they are doubled.
/// Unit    Newell's: 3.15 high, standing on y = 0, spout towards +x.
/// Needs   segments ≥ 1.
[[nodiscard]] inline mesh teapot(int segments) {
    BILLOW_ASSERT(segments >= 1);
    static constexpr dvec2 body[] = {
        {1.4, 2.4}, {1.3375, 2.53125}, {1.4375, 2.53125}, {1.5, 2.4},  {1.75, 1.875}, {2, 1.35},
        {2, 0.9},   {2, 0.45},         {1.5, 0.225},      {1.5, 0.15}, {1.5, 0.075},  {1.425, 0},
        {0, 0}};
    static constexpr dvec2 knob[] = {{0, 3.15}, {0.8, 3.15}, {0, 2.85}, {0.2, 2.7}};
    static constexpr dvec2 lid[] = {{0.2, 2.7}, {0.4, 2.55}, {1.3, 2.55}, {1.3, 2.4}};
    static constexpr detail::tube_row handle[] = {
        {{-1.6, 2.025}, {-1.5, 2.25}, 0.3}, {{-2.3, 2.025}, {-2.5, 2.25}, 0.3},
        {{-2.7, 2.025}, {-3, 2.25}, 0.3},   {{-2.7, 1.8}, {-3, 1.8}, 0.3},
        {{-2.7, 1.575}, {-3, 1.35}, 0.3},   {{-2.5, 1.125}, {-2.65, 0.9375}, 0.3},
        {{-2, 0.9}, {-1.9, 0.6}, 0.3}};
    static constexpr detail::tube_row spout[] = {
        {{1.7, 1.425}, {1.7, 0.6}, 0.66},       {{2.6, 1.425}, {3.1, 0.825}, 0.66},
        {{2.3, 2.1}, {2.4, 2.025}, 0.25},       {{2.7, 2.4}, {3.3, 2.4}, 0.25},
        {{2.8, 2.475}, {3.525, 2.49375}, 0.25}, {{2.9, 2.475}, {3.45, 2.5125}, 0.15},
        {{2.8, 2.4}, {3.2, 2.4}, 0.15}};

    mesh pot;
    for (const auto& sheet : {detail::turned(body), detail::turned(knob), detail::turned(lid),
                              detail::mirrored(handle), detail::mirrored(spout)}) {
        detail::tessellate(sheet, segments, pot);
    }
    pot.materials = {{.name = "porcelain",
                      .base_color = {0.85f, 0.83f, 0.78f, 1},
                      .metallic = 0,
                      .roughness = 0.3f,
                      .is_double_sided = true}};  // the inside shows between rim and lid
    return pot;
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/policy/contribution.hpp
// What drawing a face on a plane is worth: contribution.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <utility>


namespace billow::inline BILLOW_ABI {

/// Worth of drawing a face on a plane with the given normal, in scene units squared. Pure, at most
/// the area of the face, and the same for n and -n: faces are seen from both sides, and the density
/// grid keeps one row for both. A policy may have a member `least_cosine`, see least_cosine_of.
template <class P, class V = float>
concept contribution = std::copyable<P> &&
    requires(const P& worth, const face_lanes<V>& face, const vec3_lanes<V>& normal) {
    { worth(face, normal) }
    noexcept->std::same_as<V>;
};

/// The least |cosine| between the normals of a face and of a plane that may take it; 0, which allows
/// all, for a policy that does not say.
template <class Contribution>
[[nodiscard]] constexpr float least_cosine_of(const Contribution& worth) noexcept {
    if constexpr (requires { worth.least_cosine; }) {
        return worth.least_cosine;
    } else {
        return 0;
    }
}

/// Area of the face seen along the plane's normal. Source: Luksch 2009, eq 3.4. Differs by the
/// absolute value, without which faces that look the other way would count as negative.
struct projected_area {
    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        return face.area * simd::min(simd::abs(dot(face.normal, normal)), simd::lanes<V>::fill(1));
    }
};

/// Area of the face, falling in proportion to the angle between face and plane: 100, 88.9, 66.7 at
/// 0, 10 and 30 degrees, where the projected area is 100, 98.5, 86.6 and hardly tells them apart.
///
/// Source  Fuhrmann et al. 2005, section 3.3.1. The angle is that of the chord between the normals:
///         it keeps its digits near 0, where the arc cosine of a float is off by 0.02°. Within 2e-6
///         of the area, by a polynomial of our own instead of a library's, so that all lanes give
///         the same bits.
struct angular_area {
    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        const auto squared_length = [](V x, V y, V z) { return x * x + y * y + z * z; };
        const vec3_lanes<V>& f = face.normal;
        const V ahead = squared_length(f.x - normal.x, f.y - normal.y, f.z - normal.z);
        const V behind = squared_length(f.x + normal.x, f.y + normal.y, f.z + normal.z);
        const V q = simd::min(ahead, behind);
        // angle / 90° = 4 / pi · asin(sqrt(q) / 2) = sqrt(q) · sum, equal to it in six Chebyshev
        // nodes of q in [0, 2].
        const auto fill = [](float value) { return simd::lanes<V>::fill(value); };
        const V low = (fill(2.9080769e-3f) * q + fill(2.653927e-2f)) * q + fill(0.63661939f);
        const V high = (fill(5.8815534e-5f) * q - fill(5.4860026e-5f)) * q + fill(5.9644331e-4f);
        const V sum = low + high * (q * q * q);
        return face.area * simd::max(fill(1) - simd::sqrt(q) * sum, fill(0));
    }
};

/// Another contribution, but none to planes whose normal deviates more from the face's than an angle.
/// A search takes no face on such a plane.
///
/// Source  Luksch 2009, section 4.3, "normal threshold". A density measures a face at the centres of
///         the orientation cells, so the angle should exceed their half diagonal, 4° at raster 18.
template <class Contribution = projected_area>
struct within_angle {
    Contribution base;
    float least_cosine;  ///< of the angle; 0: all planes

    /// `max_angle_deg` in [0, 90], where 90 allows all planes; below 0.1 floats end, it works as 0.1.
    within_angle(Contribution contribution, double max_angle_deg) noexcept
        : base(std::move(contribution)), least_cosine(least_cosine_of(base)) {
        constexpr double radian = 0.017453292519943295;
        if (max_angle_deg >= 90) return;
        const double cosine = std::cos(std::max(max_angle_deg, 0.1) * radian);
        least_cosine = std::max(least_cosine, static_cast<float>(cosine));
    }

    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        const V cosine = simd::abs(dot(face.normal, normal));
        return simd::select(cosine >= simd::lanes<V>::fill(least_cosine), base(face, normal),
                            simd::lanes<V>::fill(0));
    }
};

static_assert(contribution<projected_area> && contribution<projected_area, simd::wide>);
static_assert(contribution<angular_area> && contribution<angular_area, simd::wide>);
static_assert(contribution<within_angle<>> && contribution<within_angle<>, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
// ---- billow/policy/falloff.hpp
// How much less a face counts on planes that lie off the middle of its valid offsets: falloff.

#include <concepts>


namespace billow::inline BILLOW_ABI {

/// Weight in (0, 1] of a face on a plane whose offset is `distance` ≥ 0 from the middle of the
/// face's valid offsets; 1 at 0, falling. Pure.
template <class P, class V = float>
concept falloff = std::copyable<P> && requires(const P& weigh, V distance, V epsilon) {
    { P::falls } -> std::convertible_to<bool>;
    { weigh(distance, epsilon) }
    noexcept->std::same_as<V>;
};

/// A face counts the same on all planes that it is valid for.
struct no_falloff {
    static constexpr bool falls = false;

    template <class V>
    [[nodiscard]] V operator()(V, V) const noexcept {
        return simd::lanes<V>::fill(1);
    }
};

/// A face counts less the farther the plane is from it: half at epsilon with strength 1. It draws
/// planes to the faces that they stand for; a bound on the distance alone is content with any.
///
/// Source  Luksch 2009, section 3.2, eq 3.6, and with strength 0.25 the weaker fall to 0.8 that he
///         mentions. The whole middle bin counts fully, which eq 3.7 intends but, adding a length to
///         1, does not do: who samples the weight in bins takes half a bin off the distance.
struct distance_falloff {
    static constexpr bool falls = true;
    double strength = 1;  ///< ≥ 0; the weight at epsilon is 1 / (strength + 1); 0: always 1

    template <class V>
    [[nodiscard]] V operator()(V distance, V epsilon) const noexcept {
        const V k = simd::lanes<V>::fill(static_cast<float>(strength));
        return epsilon / (k * distance + epsilon);
    }
};

/// Where a search lets its falloff count.
enum class falloff_use {
    everywhere,  ///< in the density grid and in refinement
    refinement,  ///< in refinement only, whose bins are finer (Luksch 2009, section 3.2)
    nowhere,     ///< as if it were no_falloff
};

static_assert(falloff<no_falloff> && falloff<no_falloff, simd::wide>);
static_assert(falloff<distance_falloff> && falloff<distance_falloff, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
// ---- billow/policy/orientation_bias.hpp
// Which orientations a search prefers: a weight on densities when they are read.
//
// Fuhrmann, Umlauf, Mantler: Extreme model simplification for forest rendering. 2005, section 3.3.5.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>
#include <tuple>


namespace billow::inline BILLOW_ABI {

/// Weight in (0, 1] of the planes with a given unit normal, the same for n and -n. Stored densities
/// stay as they are: the weight is applied when the densest bin is looked for. Pure.
template <class P>
concept orientation_bias = std::copyable<P> && requires(const P& weigh, const dvec3& normal) {
    { weigh(normal) }
    noexcept->std::same_as<double>;
};

/// A density as a search with that weight, > 0, reads it. Below 0 the density is divided: multiplied,
/// a small weight would be a reward.
[[nodiscard]] inline double biased(double density, double weight) noexcept {
    return density > 0 ? density * weight : density / weight;
}

/// All orientations count the same.
struct no_bias {
    [[nodiscard]] double operator()(const dvec3&) const noexcept { return 1; }
};

namespace detail {

/// 1 up to the cutoff, then falling with the angle to 1 - share at 90°.
[[nodiscard]] inline double slope_weight(double angle_deg, double share,
                                         double cutoff_deg) noexcept {
    // A share of 1 would forbid planes that some faces need.
    constexpr double most = 0.999;
    const double beyond = std::clamp((angle_deg - cutoff_deg) / (90 - cutoff_deg), 0.0, 1.0);
    return 1 - std::min(share, most) * beyond;
}

/// Angle between a plane's unit normal and the ground, in degrees: 90 for a horizontal plane.
[[nodiscard]] inline double elevation_deg(const dvec3& normal, const dvec3& up) noexcept {
    return std::asin(std::min(std::abs(glm::dot(normal, up)), 1.0)) * 180 / std::numbers::pi;
}

}  // namespace detail

/// Makes horizontal planes rare, for viewers near the ground: layers of foliage that one flat plane
/// could hold would be invisible from the side.
///
/// Source: Fuhrmann et al. 2005, section 3.3.5, with its 60 % and 50°.
struct horizontal_penalty {
    double share = 0.60;     ///< of the density that horizontal planes lose, [0, 1]; 0: off
    double cutoff_deg = 50;  ///< elevation of the normal from which the loss grows, [0, 90)
    dvec3 up{0, 1, 0};       ///< unit length

    [[nodiscard]] double operator()(const dvec3& normal) const noexcept {
        return detail::slope_weight(detail::elevation_deg(normal, up), share, cutoff_deg);
    }
};

/// The mirror of horizontal_penalty: makes vertical planes rare, for viewers who fly over.
struct vertical_penalty {
    double share = 0.60;     ///< of the density that vertical planes lose, [0, 1]; 0: off
    double cutoff_deg = 50;  ///< angle of the normal to `up` from which the loss grows, [0, 90)
    dvec3 up{0, 1, 0};       ///< unit length

    [[nodiscard]] double operator()(const dvec3& normal) const noexcept {
        return detail::slope_weight(90 - detail::elevation_deg(normal, up), share, cutoff_deg);
    }
};

/// Both penalties around one axis, each of them off at a share of 0.
struct viewpoint_bias {
    double horizontal_share = 0;  ///< see horizontal_penalty
    double vertical_share = 0;    ///< see vertical_penalty
    double cutoff_deg = 50;       ///< of both, [0, 90)
    dvec3 up{0, 1, 0};            ///< unit length

    [[nodiscard]] double operator()(const dvec3& normal) const noexcept {
        const horizontal_penalty horizontal{horizontal_share, cutoff_deg, up};
        const vertical_penalty vertical{vertical_share, cutoff_deg, up};
        return horizontal(normal) * vertical(normal);
    }
};

/// The product of several biases.
template <orientation_bias... Biases>
struct combined_bias {
    std::tuple<Biases...> biases{};

    combined_bias() = default;
    explicit combined_bias(const Biases&... all) requires(sizeof...(Biases) > 0) : biases(all...) {}

    [[nodiscard]] double operator()(const dvec3& normal) const noexcept {
        return std::apply([&](const Biases&... all) { return (1.0 * ... * all(normal)); }, biases);
    }
};

static_assert(orientation_bias<no_bias> && orientation_bias<horizontal_penalty> &&
              orientation_bias<vertical_penalty> && orientation_bias<viewpoint_bias> &&
              orientation_bias<combined_bias<horizontal_penalty, vertical_penalty>>);

}  // namespace billow::inline BILLOW_ABI
// ---- billow/policy/penalty.hpp
// What a plane is charged for the faces that it just misses: penalty.

#include <concepts>

// ---- billow/policy/validity.hpp
// Which offsets a face allows for an orientation: validity.
//
// A vertex is valid for a plane when it lies within epsilon of it, a face when its three vertices
// are. For one normal n these are the offsets [max n·v - eps, min n·v + eps]. Over a cell of normals
// the interval can only be estimated; Luksch 2009 (sections 2.1, 3.2) and Fuhrmann et al. 2005
// (section 3.2.1) describe different estimates of this "simple validity".

#include <algorithm>
#include <concepts>
#include <limits>


namespace billow::inline BILLOW_ABI {

/// Offsets from low to high; empty when low > high.
template <class V>
struct offset_interval {
    V low, high;
};

/// An orientation cell in every lane.
template <class V>
struct cell_lanes {
    vec3_lanes<V> centre;
    std::array<vec3_lanes<V>, 4> corner;
    V chord;

    explicit cell_lanes(const orientation_cell& cell) noexcept
        : centre(fill_lanes<V>(cell.centre)),
          corner{fill_lanes<V>(cell.corner[0]), fill_lanes<V>(cell.corner[1]),
                 fill_lanes<V>(cell.corner[2]), fill_lanes<V>(cell.corner[3])},
          chord(simd::lanes<V>::fill(cell.chord)) {}
};

/// Estimates the offsets that a face allows within a cell of normals. Pure.
template <class P, class V = float>
concept validity = std::copyable<P> &&
    requires(const P& estimate, const face_lanes<V>& face, const cell_lanes<V>& cell, V epsilon) {
    { estimate(face, cell, epsilon) }
    noexcept->std::same_as<offset_interval<V>>;
};

/// The exact offsets for one normal. Source: Luksch 2009, section 2.1.
template <class V>
[[nodiscard]] inline offset_interval<V> valid_offsets(const face_lanes<V>& face,
                                                      const vec3_lanes<V>& normal,
                                                      V epsilon) noexcept {
    const V a = dot(normal, face.corner[0]);
    const V b = dot(normal, face.corner[1]);
    const V c = dot(normal, face.corner[2]);
    return {simd::max(simd::max(a, b), c) - epsilon, simd::min(simd::min(a, b), c) + epsilon};
}

/// Estimate A: the hull of the exact intervals at the cell's corners and centre. Never too wide, may
/// miss. The right estimate of a density.
///
/// Source: Luksch 2009, section 2.1. Differs by the centre, without which a plane that the space
/// samples exactly can go unseen: two walls 1.9 epsilon apart share only planes so close to their own
/// normal that no corner has one (the "diamond" of the thesis's Figure 3.6).
struct hull_of_samples {
    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const face_lanes<V>& face,
                                                const cell_lanes<V>& cell,
                                                V epsilon) const noexcept {
        const V far = simd::lanes<V>::fill(std::numeric_limits<float>::max());
        offset_interval<V> hull{far, -far};
        const auto widen = [&](const vec3_lanes<V>& normal) {
            const offset_interval<V> at = valid_offsets(face, normal, epsilon);
            // An empty interval is moved out of the way: cheaper than to choose both ends.
            const V aside = simd::select(at.low <= at.high, simd::lanes<V>::fill(0), far);
            hull.low = simd::min(hull.low, at.low + aside);
            hull.high = simd::max(hull.high, at.high - aside);
        };
        widen(cell.centre);
        widen(cell.corner[0]);
        widen(cell.corner[1]);
        widen(cell.corner[2]);
        widen(cell.corner[3]);
        return hull;
    }
};

/// Estimate B: each vertex takes the hull of its intervals at the corners, the face their
/// intersection. Holds A; a third of the invalid faces pass. Source: Fuhrmann et al. 2005, 3.2.1.
struct intersection_of_vertices {
    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const face_lanes<V>& face,
                                                const cell_lanes<V>& cell,
                                                V epsilon) const noexcept {
        const V far = simd::lanes<V>::fill(std::numeric_limits<float>::max());
        offset_interval<V> meet{-far, far};
        for (const vec3_lanes<V>& vertex : face.corner) {
            const V a = dot(cell.corner[0], vertex);
            const V b = dot(cell.corner[1], vertex);
            const V c = dot(cell.corner[2], vertex);
            const V d = dot(cell.corner[3], vertex);
            const V least = simd::min(simd::min(a, b), simd::min(c, d));
            const V most = simd::max(simd::max(a, b), simd::max(c, d));
            meet.low = simd::max(meet.low, least - epsilon);
            meet.high = simd::min(meet.high, most + epsilon);
        }
        return meet;
    }
};

/// Estimate C: the interval of the cell's centre, widened by how far a vertex can move against the
/// plane when the normal goes to the rim of the cell. Never misses a valid plane; the right filter
/// for candidates, the wrong density.
///
/// Derived: |n·v - n_c·v| ≤ |n - n_c| |v| ≤ 2 sin(delta/2) |v| for the half diagonal delta. We take
/// the face's farthest vertex for all three, which is one column instead of three square roots.
struct widened_centre {
    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const face_lanes<V>& face,
                                                const cell_lanes<V>& cell,
                                                V epsilon) const noexcept {
        return valid_offsets(face, cell.centre, epsilon + cell.chord * face.reach);
    }
};

static_assert(validity<hull_of_samples> && validity<hull_of_samples, simd::wide>);
static_assert(validity<intersection_of_vertices> && validity<intersection_of_vertices, simd::wide>);
static_assert(validity<widened_centre> && validity<widened_centre, simd::wide>);

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// The offsets at which a plane is charged for a face, given those where the face is valid, for the
/// side rho ≥ 0 of a normal. The charge is `weight` times the face's contribution. Pure.
template <class P, class V = float>
concept penalty = std::copyable<P> &&
    requires(const P& charge, const offset_interval<V>& valid, V epsilon) {
    { charge(valid, epsilon) }
    noexcept->std::same_as<offset_interval<V>>;
    { charge.weight } -> std::convertible_to<double>;
};

/// Charges planes that lie up to epsilon further in than a face allows, which draws planes to the
/// outline. One-sided: charges on both sides would cancel out.
///
/// Source: Décoret et al. 2003 with weight 10; Luksch 2009, eq 2.3 and section 5.2, advises 2 to 5.
struct inner_side_penalty {
    double weight = 3;  ///< ≥ 0; more keeps planes closer to the outline, too much finds none

    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const offset_interval<V>& valid,
                                                V epsilon) const noexcept {
        return {valid.low - epsilon, valid.low};
    }
};

/// Charges nothing.
struct no_penalty {
    static constexpr double weight = 0;

    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const offset_interval<V>& valid, V) const noexcept {
        return {valid.low, valid.low};
    }
};

static_assert(penalty<inner_side_penalty> && penalty<inner_side_penalty, simd::wide>);
static_assert(penalty<no_penalty> && penalty<no_penalty, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
// ---- billow/policy/tangency.hpp
// How much faces that lie askew to a plane lose besides the projection: tangency.

#include <utility>


namespace billow::inline BILLOW_ABI {

/// Another contribution, times |cos|^tangency of the angle between face and plane.
///
/// Few planes alone are a poor aim: parallel slabs of one direction hold a crown within epsilon, and
/// show most of its leaves edge-on. With a tangency above 0 a plane is found for the faces that it
/// shows frontally; it still takes all that are valid for it. 0 is the base alone; 1 to 3 are useful.
/// Between two whole numbers it is the mix of their powers.
template <class Contribution = projected_area>
struct tangent_share {
    Contribution base{};
    float least_cosine = least_cosine_of(base);
    float tangency = 0;  ///< ≥ 0, at most 16

    explicit tangent_share(Contribution contribution = {}, double exponent = 0) noexcept
        : base(std::move(contribution)), tangency(static_cast<float>(exponent)) {}

    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        const V one = simd::lanes<V>::fill(1);
        const V cosine = simd::min(simd::abs(dot(face.normal, normal)), one);
        V worth = base(face, normal);
        float left = simd::min(tangency, 16.0f);
        for (; left >= 1; left -= 1) worth = worth * cosine;
        if (left > 0) worth = worth * (one - simd::lanes<V>::fill(left) * (one - cosine));
        return worth;
    }
};
static_assert(contribution<tangent_share<>> && contribution<tangent_share<>, simd::wide>);

}  // namespace billow::inline BILLOW_ABI

// ---- billow/density/falloff_kernel.hpp
// The weights of a distance falloff, tabulated for the bins of a density row.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

// ---- billow/density/grid.hpp
// Density rows: how much contribution and penalty each bin of offsets has gathered.
//
// Décoret et al. 2003; Luksch 2009, sections 2.1 and 4.6. Differs: a face's interval [a, b] is not
// walked bin by bin. Its coverage of the bins is the difference of two ramps, "everything above a"
// less "everything above b", and a ramp is two numbers at the bin where it starts. So adding a face
// costs the same whatever the length of its interval, and the bins appear when the row is summed.
// The numbers are integers: addition is exact in any order, removal leaves exactly nothing behind.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>


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
// ---- billow/density/rasterize.hpp
// Adds faces to density rows, and takes them out again.
//
// The loops are those that Luksch 2009 (section 4.6) found to scale: a thread owns a chunk of
// orientations and walks all faces. Within a chunk the faces come in blocks that stay in the cache,
// each block in two steps: lanes compute where the ramps start, scalars add them up.

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <span>
#include <vector>


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

// ---- billow/cloud/billboard_cloud.hpp
// What a plane search finds: planes, the faces on each, and the rectangles that show them.

#include <algorithm>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// A textured rectangle on a plane.
///
/// Scene point of texture coordinate (s, t) in [0, 1]²:
/// origin + s·width·axes.u + t·height·axes.v. The front, which the texture is drawn from, is the
/// side that axes.normal points to.
struct billboard {
    dvec3 origin{0};        ///< corner of the rectangle with the least u and v, scene units
    frame axes{};           ///< u along the width, v along the height
    double width = 0;       ///< scene units, ≥ 0
    double height = 0;      ///< scene units, ≥ 0
    double depth_low = 0;   ///< least signed distance of a mapped vertex to the plane, along normal
    double depth_high = 0;  ///< greatest such distance
};

/// A face that is drawn on a plane although it is mapped to another one.
struct drawn_too {
    plane_id plane = no_id;
    face_id face = no_id;

    // NOLINTNEXTLINE(modernize-use-nullptr): the 0 is of the comparison that the compiler writes
    friend auto operator<=>(const drawn_too&, const drawn_too&) = default;
};

/// What planes share that were searched together: those of a trunk, or of its foliage. Faces of one
/// part are not drawn on the planes of another.
struct cloud_part {
    double epsilon = 0;  ///< the bound on the distance of a mapped vertex to its plane, scene units
};

/// A billboard cloud without its textures.
///
/// Shape  P planes; `billboards` and `part_of_plane` have one row a plane; `plane_of_face` one row a
///        face of the mesh.
/// Unit   planes are relative to bounds.centre: a scene point p lies on plane i when
///        planes[i].normal·(p - bounds.centre) = planes[i].rho. Billboards are in scene units.
struct billboard_cloud {
    bounding_sphere bounds{};
    double epsilon = 0;                     ///< the largest of the parts'
    std::vector<plane> planes{};            ///< in the order of discovery
    std::vector<plane_id> plane_of_face{};  ///< no_id: degenerate or skipped
    std::vector<billboard> billboards{};
    std::vector<drawn_too> also_drawn{};   ///< ascending; counts for a billboard's size
    std::vector<part_id> part_of_plane{};  ///< none: all planes are of one part
    std::vector<cloud_part> parts{};       ///< none: one part with `epsilon`

    [[nodiscard]] std::size_t plane_count() const noexcept { return planes.size(); }
    [[nodiscard]] part_id part_of(plane_id plane) const noexcept {
        return part_of_plane.empty() ? 0 : part_of_plane[plane];
    }
    /// The rows of also_drawn for a plane.
    [[nodiscard]] std::span<const drawn_too> also_drawn_on(plane_id plane) const noexcept {
        const auto is_before = [plane](const drawn_too& d) { return d.plane < plane; };
        const auto is_up_to = [plane](const drawn_too& d) { return d.plane <= plane; };
        const auto all = std::span(also_drawn);
        const auto begin = std::partition_point(all.begin(), all.end(), is_before);
        const auto end = std::partition_point(begin, all.end(), is_up_to);
        return all.subspan(static_cast<std::size_t>(begin - all.begin()),
                           static_cast<std::size_t>(end - begin));
    }
    /// The bound for the faces of a plane, scene units.
    [[nodiscard]] double epsilon_of(plane_id plane) const noexcept {
        return parts.empty() ? epsilon : parts[part_of(plane)].epsilon;
    }
};

/// The faces of each plane, in ascending order.
class faces_of_planes {
public:
    /// Needs plane_of_face values below plane_count, or no_id. Cost O(faces + planes).
    faces_of_planes(std::span<const plane_id> plane_of_face, std::size_t plane_count)
        : begin_(plane_count + 1, 0) {
        for (const plane_id plane : plane_of_face) {
            if (plane != no_id) ++begin_[plane + 1];
        }
        for (std::size_t i = 0; i < plane_count; ++i) begin_[i + 1] += begin_[i];
        faces_.resize(begin_.back());
        std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
        for (std::size_t face = 0; face < plane_of_face.size(); ++face) {
            if (const plane_id plane = plane_of_face[face]; plane != no_id) {
                faces_[next[plane]++] = static_cast<face_id>(face);
            }
        }
    }

    [[nodiscard]] std::span<const face_id> operator[](plane_id plane) const noexcept {
        return std::span(faces_).subspan(begin_[plane], begin_[plane + 1] - begin_[plane]);
    }

private:
    std::vector<std::size_t> begin_;
    std::vector<face_id> faces_;
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/cloud/cracks.hpp
// How far a cloud tears its mesh apart: the edges whose faces are drawn on different planes.

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// What a cloud tears. An end of an edge is torn where its two faces draw it more than 1e-6 radii
/// apart.
struct cloud_cracks {
    double edge_length = 0;      ///< of the edges between faces on different planes, scene units
    double torn_length = 0;      ///< of those, torn at both ends; half of those torn at one
    double area = 0;             ///< length × mean width of the cracks, scene units squared
    double width = 0;            ///< of the widest crack, scene units
    std::size_t edges = 0;       ///< between faces on different planes
    std::size_t torn_edges = 0;  ///< of those, torn at an end at least
};

namespace detail {

/// A side of a face, and which vertices it joins.
struct face_side {
    std::uint32_t low = 0;  ///< vertex identities
    std::uint32_t high = 0;
    face_id face = no_id;
    std::uint8_t low_corner = 0;
    std::uint8_t high_corner = 0;
};

}  // namespace detail

/// Measures the cracks of `cloud` when `drawn` is drawn for its mesh `source`: equal faces, whose
/// corners may have moved.
///
/// Unit    tolerance as of position_ids, scene units.
/// Needs   `drawn` has the faces of `source`, in the same order.
/// Gives   sums over the edges of `source`. Where more than two faces meet at an edge, those on
///         neighbouring planes are compared.
/// Cost    O(faces log faces).
[[nodiscard]] inline cloud_cracks measure_cracks(const mesh& source, const billboard_cloud& cloud,
                                                 const mesh& drawn, double tolerance = 0) {
    BILLOW_ASSERT(drawn.face_count() == source.face_count());
    const vertex_identity vertices = position_ids(source, tolerance);
    std::vector<detail::face_side> sides;
    sides.reserve(3 * source.face_count());
    for (face_id face = 0; face < source.face_count(); ++face) {
        if (cloud.plane_of_face[face] == no_id) continue;
        for (std::uint8_t k = 0; k < 3; ++k) {
            const auto next = static_cast<std::uint8_t>((k + 1) % 3);
            const std::uint32_t a = vertices.id[source.triangles[face][k]];
            const std::uint32_t b = vertices.id[source.triangles[face][next]];
            if (a < b) sides.push_back({a, b, face, k, next});
            if (b < a) sides.push_back({b, a, face, next, k});
        }
    }
    const auto place = [&](const detail::face_side& s) {
        return std::tuple(s.low, s.high, cloud.plane_of_face[s.face], s.face);
    };
    std::sort(sides.begin(), sides.end(),
              [&](const auto& a, const auto& b) { return place(a) < place(b); });

    const auto drawn_at = [&](face_id face, std::uint8_t corner) {
        const plane& on = cloud.planes[cloud.plane_of_face[face]];
        const dvec3 p = dvec3(drawn.positions[drawn.triangles[face][corner]]) - cloud.bounds.centre;
        return p - on.normal * signed_distance(on, p);
    };
    const double least = 1e-6 * cloud.bounds.radius;
    cloud_cracks cracks;
    for (std::size_t i = 1; i < sides.size(); ++i) {
        const detail::face_side& a = sides[i - 1];
        const detail::face_side& b = sides[i];
        if (a.low != b.low || a.high != b.high) continue;
        if (cloud.plane_of_face[a.face] == cloud.plane_of_face[b.face]) continue;
        const std::array<vec3, 3> corners = source.corners(a.face);
        const double length =
            glm::distance(dvec3(corners[a.low_corner]), dvec3(corners[a.high_corner]));
        const std::array gaps{
            glm::distance(drawn_at(a.face, a.low_corner), drawn_at(b.face, b.low_corner)),
            glm::distance(drawn_at(a.face, a.high_corner), drawn_at(b.face, b.high_corner))};
        const int torn_ends = (gaps[0] > least ? 1 : 0) + (gaps[1] > least ? 1 : 0);
        ++cracks.edges;
        cracks.edge_length += length;
        cracks.torn_edges += torn_ends > 0 ? 1 : 0;
        cracks.torn_length += length * torn_ends / 2;
        cracks.area += length * (gaps[0] + gaps[1]) / 2;
        cracks.width = std::max({cracks.width, gaps[0], gaps[1]});
    }
    return cracks;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/cloud/fit_billboards.hpp
// From planes to rectangles: how large each billboard is and which way it is turned.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 4.5: the
// rectangle of least area around the projected faces.

#include <algorithm>
#include <array>
#include <limits>
#include <vector>


namespace billow::inline BILLOW_ABI {

namespace detail {

/// The frame of a billboard: of the four ways to lay v along a rectangle's axes the one that points
/// most to +Y, so that textures stand upright. On a near-horizontal plane, where no axis points up,
/// it is the one most to -Z: north on a map seen from above.
[[nodiscard]] inline frame upright_frame(const dvec3& along, const dvec3& across,
                                         const dvec3& normal) noexcept {
    const std::array axes{across, along, -across, -along};
    const double rise = std::max(std::abs(along.y), std::abs(across.y));
    const dvec3 goal = rise > 1e-3 ? dvec3(0, 1, 0) : dvec3(0, 0, -1);
    dvec3 v = axes[0];
    for (const dvec3& axis : axes) {
        if (glm::dot(axis, goal) > glm::dot(v, goal) + 1e-9) v = axis;
    }
    return {.u = glm::cross(v, normal), .v = v, .normal = normal};
}

/// Buffers for the largest plane, one set a thread.
struct rectangle_scratch {
    std::vector<dvec2> points{};
    std::vector<dvec2> hull{};
};

[[nodiscard]] inline billboard fit_billboard(const mesh& mesh, const billboard_cloud& cloud,
                                             plane_id id, std::span<const face_id> mapped,
                                             rectangle_scratch& scratch) {
    const plane base = canonical(cloud.planes[id]);
    const frame local = frame_around(base.normal);
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    double facing = 0;  // twice the area seen from the front minus that seen from behind
    double total = 0;
    std::size_t count = 0;
    const auto add = [&](face_id face) {
        std::array<dvec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = local.to_local(dvec3(mesh.corners(face)[k]) - cloud.bounds.centre);
            scratch.points[count++] = dvec2(p[k]);
            low = std::min(low, p[k].z - base.rho);
            high = std::max(high, p[k].z - base.rho);
        }
        const dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
        facing += normal.z;
        total += glm::length(normal);
    };
    for (const face_id face : mapped) add(face);
    for (const drawn_too& d : cloud.also_drawn_on(id)) add(d.face);
    if (count == 0) low = high = 0;
    const std::size_t corners = convex_hull(std::span(scratch.points).first(count), scratch.hull);
    const oriented_rectangle rectangle =
        minimum_rectangle(std::span<const dvec2>(scratch.hull).first(corners));

    const bool is_flipped = facing < -1e-6 * total;  // even halves keep the outward normal
    const auto in_scene = [&](const dvec2& v) { return local.u * v.x + local.v * v.y; };
    const dvec3 along = in_scene(rectangle.axis);
    const dvec3 across = in_scene(rectangle.height_axis());
    billboard result;
    result.axes = upright_frame(along, across, is_flipped ? -base.normal : base.normal);
    result.width =
        std::abs(glm::dot(result.axes.u, along)) > 0.5 ? rectangle.extent.x : rectangle.extent.y;
    result.height =
        std::abs(glm::dot(result.axes.v, along)) > 0.5 ? rectangle.extent.x : rectangle.extent.y;
    const dvec2 middle = rectangle.low + rectangle.extent * 0.5;
    result.origin = cloud.bounds.centre + base.normal * base.rho + along * middle.x +
                    across * middle.y - result.axes.u * (result.width * 0.5) -
                    result.axes.v * (result.height * 0.5);
    result.depth_low = is_flipped ? -high : low;
    result.depth_high = is_flipped ? -low : high;
    return result;
}

}  // namespace detail

/// Lays a rectangle on every plane: the smallest one around the projected vertices of the faces
/// that are mapped to it or in cloud.also_drawn for it. Its front is the side that most of their area faces; where both sides
/// weigh the same (difference below 1e-6 of the area), the side away from the centre of the scene.
/// Corners (0,0), (1,0), (1,1), (0,1) of a billboard are counter-clockwise seen from its front.
///
/// Needs  planes, plane_of_face and also_drawn of `cloud`; one row of plane_of_face a face.
/// Gives  `cloud.billboards`, one a plane; a plane without faces has zero extents.
/// Cost   O(faces log faces), parallel over planes.
inline void fit_billboards(const mesh& mesh, billboard_cloud& cloud, parallel threads = {}) {
    BILLOW_ASSERT(cloud.plane_of_face.size() == mesh.face_count());
    const faces_of_planes faces(cloud.plane_of_face, cloud.plane_count());
    const auto plane_count = static_cast<plane_id>(cloud.plane_count());
    std::size_t most = 0;
    for (plane_id i = 0; i < plane_count; ++i) {
        most = std::max(most, faces[i].size() + cloud.also_drawn_on(i).size());
    }
    cloud.billboards.assign(plane_count, {});

    std::vector<detail::rectangle_scratch> scratches(threads.count());
    for (auto& scratch : scratches) {
        scratch.points.resize(3 * most);
        scratch.hull.resize(3 * most + 1);
    }
    for_jobs(threads, plane_count, scratches, [&](std::size_t job, auto& scratch) {
        const auto id = static_cast<plane_id>(job);
        cloud.billboards[id] = detail::fit_billboard(mesh, cloud, id, faces[id], scratch);
    });
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/cloud/measure.hpp
// How far a cloud is from its mesh, measured on the mesh's own vertices.

#include <algorithm>
#include <cmath>


namespace billow::inline BILLOW_ABI {

/// Errors of a cloud. Distances are in scene units.
struct cloud_errors {
    double max_error = 0;             ///< largest distance of a mapped vertex to its plane
    double mean_error = 0;            ///< mean over a face's corners, area-weighted over the faces
    double projected_area_share = 0;  ///< area-weighted mean |cos| between a face and its plane: 1
        ///< when every texture is seen frontally, 0.5 for random planes
    std::size_t mapped_faces = 0;
    std::size_t faces_beyond_epsilon = 0;  ///< mapped faces with a vertex farther than epsilon
    double area_beyond_epsilon_share = 0;  ///< their area, of that of all faces
    double dropped_area_share = 0;         ///< area of the faces without a plane, of that of all
    /// Area that the mapped faces have on their planes, of the billboards' area: how much of the
    /// textures shows something. Above 1 where faces lie over each other; 0 without billboards.
    double rectangle_use = 0;
};

/// Measures `cloud` against the mesh that it was made of, in double. Cost O(faces).
[[nodiscard]] inline cloud_errors measure_errors(const mesh& m, const billboard_cloud& cloud) {
    cloud_errors errors;
    double area_sum = 0;
    double dropped_area = 0;
    for (face_id face = 0; face < m.face_count(); ++face) {
        const plane_id id = cloud.plane_of_face[face];
        const auto [a, b, c] = m.corners(face);
        const dvec3 normal = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)) / 2.0;
        const double area = glm::length(normal);
        if (id == no_id) {
            dropped_area += area;
            continue;
        }
        ++errors.mapped_faces;
        const plane& p = cloud.planes[id];
        double largest = 0;
        double sum = 0;
        for (const vec3& corner : {a, b, c}) {
            const double distance =
                std::abs(signed_distance(p, dvec3(corner) - cloud.bounds.centre));
            largest = std::max(largest, distance);
            sum += distance;
        }
        errors.max_error = std::max(errors.max_error, largest);
        errors.mean_error += area * sum / 3;
        errors.projected_area_share += std::abs(glm::dot(p.normal, normal));
        if (largest > cloud.epsilon_of(id) * (1 + 1e-9)) {
            ++errors.faces_beyond_epsilon;
            errors.area_beyond_epsilon_share += area;
        }
        area_sum += area;
    }
    if (const double all = area_sum + dropped_area; all > 0) {
        errors.area_beyond_epsilon_share /= all;
        errors.dropped_area_share = dropped_area / all;
    }
    double rectangles = 0;
    for (const billboard& b : cloud.billboards) rectangles += b.width * b.height;
    if (rectangles > 0) errors.rectangle_use = errors.projected_area_share / rectangles;
    if (area_sum > 0) {
        errors.mean_error /= area_sum;
        errors.projected_area_share /= area_sum;
    }
    return errors;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/cloud/merge.hpp
// Clouds of parts of a mesh become one cloud.

#include <algorithm>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Puts clouds of parts of one mesh side by side: the planes of the first, then those of the second …
/// Each cloud becomes a part with its own epsilon; several parts of one cloud stay several.
///
/// Needs   at least one cloud; the same centre and as many rows of plane_of_face in all of them; a
///         face mapped by one cloud at most.
/// Gives   a single cloud as it is.
/// Cost    O(clouds · faces).
[[nodiscard]] inline billboard_cloud merge_clouds(std::vector<billboard_cloud> clouds) {
    BILLOW_ASSERT(!clouds.empty());
    billboard_cloud merged = std::move(clouds.front());
    if (clouds.size() == 1) return merged;
    if (merged.parts.empty()) {
        merged.parts = {{merged.epsilon}};
        merged.part_of_plane.assign(merged.plane_count(), 0);
    }
    for (std::size_t i = 1; i < clouds.size(); ++i) {
        const billboard_cloud& cloud = clouds[i];
        BILLOW_ASSERT(cloud.bounds.centre == merged.bounds.centre);
        BILLOW_ASSERT(cloud.plane_of_face.size() == merged.plane_of_face.size());
        const auto first_plane = static_cast<plane_id>(merged.plane_count());
        const auto first_part = static_cast<part_id>(merged.parts.size());
        merged.bounds.radius = std::max(merged.bounds.radius, cloud.bounds.radius);
        merged.epsilon = std::max(merged.epsilon, cloud.epsilon);
        merged.planes.insert(merged.planes.end(), cloud.planes.begin(), cloud.planes.end());
        merged.billboards.insert(merged.billboards.end(), cloud.billboards.begin(),
                                 cloud.billboards.end());
        for (std::size_t face = 0; face < cloud.plane_of_face.size(); ++face) {
            if (cloud.plane_of_face[face] == no_id) continue;
            BILLOW_ASSERT(merged.plane_of_face[face] == no_id);
            merged.plane_of_face[face] = first_plane + cloud.plane_of_face[face];
        }
        for (const drawn_too& drawn : cloud.also_drawn) {
            merged.also_drawn.push_back({first_plane + drawn.plane, drawn.face});
        }
        for (plane_id plane = 0; plane < cloud.plane_count(); ++plane) {
            merged.part_of_plane.push_back(first_part + cloud.part_of(plane));
        }
        if (cloud.parts.empty()) {
            merged.parts.push_back({cloud.epsilon});
        } else {
            merged.parts.insert(merged.parts.end(), cloud.parts.begin(), cloud.parts.end());
        }
    }
    return merged;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/cloud/plane_order.hpp
// Planes in the order of what they hold, and how much the first of them hold together.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

namespace detail {

/// The area of the faces on each plane.
[[nodiscard]] inline std::vector<double> areas_of_planes(const face_table& faces,
                                                         const billboard_cloud& cloud) {
    std::vector<double> areas(cloud.plane_count(), 0.0);
    for (std::size_t row = 0; row < faces.size; ++row) {
        const plane_id id = cloud.plane_of_face[faces.source[row]];
        if (id != no_id) areas[id] += static_cast<double>(faces.area[row]);
    }
    return areas;
}

}  // namespace detail

/// What the planes up to each hold together, one row a plane.
struct plane_curve {
    std::vector<double>
        covered_area{};                ///< share of the faces' area; ends below 1 where faces have
                                       ///< no plane
    std::vector<double> mean_error{};  ///< mean distance of the corners of these faces to their
                                       ///< planes, weighted by area, scene units
};

/// Needs  `faces` of the mesh that `cloud` was searched in.
/// Cost   O(faces + planes).
[[nodiscard]] inline plane_curve curve_of(const face_table& faces, const billboard_cloud& cloud) {
    const std::vector<double> areas = detail::areas_of_planes(faces, cloud);
    std::vector<double> errors(areas.size(), 0.0);
    double all = 0;
    for (std::size_t row = 0; row < faces.size; ++row) {
        const auto area = static_cast<double>(faces.area[row]);
        all += area;
        const plane_id id = cloud.plane_of_face[faces.source[row]];
        if (id == no_id) continue;
        const plane& of = cloud.planes[id];
        const double rho = of.rho + glm::dot(of.normal, cloud.bounds.centre - faces.bounds.centre);
        for (const columns3& corner : faces.corner) {
            errors[id] += area / 3 * std::abs(glm::dot(of.normal, corner.get(row)) - rho);
        }
    }
    plane_curve curve;
    double area = 0;
    double error = 0;
    for (std::size_t i = 0; i < areas.size(); ++i) {
        area += areas[i];
        error += errors[i];
        curve.covered_area.push_back(all > 0 ? area / all : 0);
        curve.mean_error.push_back(area > 0 ? error / area : 0);
    }
    return curve;
}

/// Puts planes that hold more area first, among equals those that were first before. A search gives
/// them nearly so; what changes planes afterwards may not.
///
/// Needs  no billboards, faces drawn too, or parts yet.
/// Cost   O(faces + planes log planes).
inline void order_planes_by_area(const face_table& faces, billboard_cloud& cloud) {
    BILLOW_ASSERT(cloud.billboards.empty() && cloud.also_drawn.empty());
    BILLOW_ASSERT(cloud.part_of_plane.empty());
    const std::vector<double> areas = detail::areas_of_planes(faces, cloud);
    std::vector<plane_id> order(cloud.plane_count());
    std::iota(order.begin(), order.end(), plane_id{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](plane_id a, plane_id b) { return areas[a] > areas[b]; });
    std::vector<plane> planes;
    std::vector<plane_id> place(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        planes.push_back(cloud.planes[order[i]]);
        place[order[i]] = static_cast<plane_id>(i);
    }
    cloud.planes = std::move(planes);
    for (plane_id& id : cloud.plane_of_face) {
        if (id != no_id) id = place[id];
    }
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/search/compact.hpp
// Compact sets: a plane takes faces that lie together, not islands with empty texels between them.
//
// Décoret et al. 2003 ("compact sets"); Luksch, "Implementation of an Improved Billboard Cloud
// Algorithm", 2009, sections 2.1 and 3.3 ("texture clustering").

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

// ---- billow/search/grouping.hpp
// Which of the faces that a plane may take it does take: the concept of a grouping.

#include <concepts>
#include <numeric>

// ---- billow/search/face_sets.hpp
// Sets of faces that a search works with: those a plane takes, those a bin may take.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Rows of a face table, ascending.
using face_rows = std::vector<std::uint32_t>;

/// The rows for which `predicate(face_lanes<wide>)` gives a positive number, in parallel.
template <class Predicate>
[[nodiscard]] face_rows filter_rows(const face_table& faces, const Predicate& predicate,
                                    parallel threads = {}) {
    using V = simd::wide;
    static constexpr std::size_t chunk = 8192;
    std::vector<float> keeps(faces.padded_size());
    std::vector<std::size_t> counts((faces.padded_size() + chunk - 1) / chunk + 1);
    threads.for_chunks(faces.padded_size(), chunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; row += simd::lanes<V>::count) {
            simd::lanes<V>::store(keeps.data() + row, predicate(load_faces<V>(faces, row)));
        }
        std::size_t count = 0;
        for (std::size_t row = begin; row < std::min(end, faces.size); ++row) {
            if (keeps[row] > 0) ++count;
        }
        counts[begin / chunk + 1] = count;
    });
    for (std::size_t i = 1; i < counts.size(); ++i) counts[i] += counts[i - 1];
    face_rows rows(counts.back());
    threads.for_chunks(faces.padded_size(), chunk, [&](std::size_t begin, std::size_t end) {
        std::size_t at = counts[begin / chunk];
        for (std::size_t row = begin; row < std::min(end, faces.size); ++row) {
            if (keeps[row] > 0) rows[at++] = static_cast<std::uint32_t>(row);
        }
    });
    return rows;
}

namespace detail {

/// The faces whose three corners lie within epsilon of `p` and whose normal's |cosine| with that of
/// `p` is at least `least_cosine`.
[[nodiscard]] inline face_rows valid_rows(const face_table& faces, const plane& p, double epsilon,
                                          float least_cosine, parallel threads) {
    using V = simd::wide;
    const auto fill = [](double value) { return simd::lanes<V>::fill(static_cast<float>(value)); };
    const vec3_lanes<V> normal = fill_lanes<V>(vec3(p.normal));
    const V rho = fill(p.rho);
    const V eps = fill(epsilon);
    const V least = simd::lanes<V>::fill(least_cosine);
    const V yes = fill(1);
    const V no = fill(0);
    return filter_rows(
        faces,
        [&](const face_lanes<V>& face) {
            const offset_interval<V> valid = valid_offsets(face, normal, eps);
            const V near =
                simd::select(valid.low <= rho, simd::select(rho <= valid.high, yes, no), no);
            return simd::select(simd::abs(dot(face.normal, normal)) >= least, near, no);
        },
        threads);
}

}  // namespace detail

/// The faces whose three corners lie within epsilon of `p`. Source: Luksch 2009, section 2.1.
[[nodiscard]] inline face_rows faces_valid_for(const face_table& faces, const plane& p,
                                               double epsilon, parallel threads = {}) {
    return detail::valid_rows(faces, p, epsilon, 0, threads);
}

/// Those of them that the contribution policy allows on a plane with that normal: `least_cosine_of`.
template <contribution<float> Contribution>
[[nodiscard]] face_rows faces_valid_for(const face_table& faces, const plane& p, double epsilon,
                                        const Contribution& worth, parallel threads = {}) {
    return detail::valid_rows(faces, p, epsilon, least_cosine_of(worth), threads);
}

/// The faces that `estimate` finds valid for some plane of a cell with an offset in [low, high], and
/// that `worth` may allow on one: "simple validity". Source: Luksch 2009, section 2.1.
template <validity<simd::wide> Validity, contribution<float> Contribution>
[[nodiscard]] face_rows faces_valid_for_bin(const face_table& faces, const orientation_cell& cell,
                                            double low, double high, double epsilon,
                                            const Validity& estimate, const Contribution& worth,
                                            parallel threads = {}) {
    using V = simd::wide;
    const auto fill = [](double value) { return simd::lanes<V>::fill(static_cast<float>(value)); };
    const cell_lanes<V> lanes(cell);
    const V eps = fill(epsilon);
    const V bin_low = fill(low);
    const V bin_high = fill(high);
    // |n·f - n_c·f| ≤ |n - n_c|, the chord.
    const V least = simd::lanes<V>::fill(least_cosine_of(worth) - cell.chord);
    const V yes = fill(1);
    const V no = fill(0);
    return filter_rows(
        faces,
        [&](const face_lanes<V>& face) {
            const offset_interval<V> valid = estimate(face, lanes, eps);
            const V from = simd::max(valid.low, bin_low);
            const V to = simd::min(valid.high, bin_high);
            const V near =
                simd::select(from <= to, simd::select(valid.low <= valid.high, yes, no), no);
            return simd::select(simd::abs(dot(face.normal, lanes.centre)) >= least, near, no);
        },
        threads);
}
template <validity<simd::wide> Validity>
[[nodiscard]] face_rows faces_valid_for_bin(const face_table& faces, const orientation_cell& cell,
                                            double low, double high, double epsilon,
                                            const Validity& estimate, parallel threads = {}) {
    return faces_valid_for_bin(faces, cell, low, high, epsilon, estimate, projected_area{},
                               threads);
}

/// Contribution of the given rows to a plane with `normal`, summed in their order in double.
template <contribution<float> Contribution>
[[nodiscard]] double contribution_of(const face_table& faces, const face_rows& rows,
                                     const dvec3& normal, const Contribution& worth) {
    const vec3_lanes<float> n = fill_lanes<float>(vec3(normal));
    double sum = 0;
    for (const std::uint32_t row : rows) {
        sum += static_cast<double>(worth(load_faces<float>(faces, row), n));
    }
    return sum;
}

/// The same for the plane `p`, each row weighted by the falloff of `p`'s distance from the middle of
/// its valid offsets, of which half of `spacing` is free. Needs rows that are valid for `p`.
template <contribution<float> Contribution, falloff<float> Falloff>
[[nodiscard]] double contribution_of(const face_table& faces, const face_rows& rows, const plane& p,
                                     const Contribution& worth, const Falloff& weigh,
                                     double epsilon, double spacing) {
    const vec3_lanes<float> n = fill_lanes<float>(vec3(p.normal));
    const auto eps = static_cast<float>(epsilon);
    double sum = 0;
    for (const std::uint32_t row : rows) {
        const face_lanes<float> face = load_faces<float>(faces, row);
        const offset_interval<float> valid = valid_offsets(face, n, eps);
        const double middle =
            (static_cast<double>(valid.low) + static_cast<double>(valid.high)) / 2;
        const double distance = std::max(0.0, std::abs(p.rho - middle) - spacing / 2);
        sum += static_cast<double>(worth(face, n) * weigh(static_cast<float>(distance), eps));
    }
    return sum;
}

/// The plane that the face of `row` lies in.
[[nodiscard]] inline plane supporting_plane(const face_table& faces, std::size_t row) {
    const dvec3 normal = glm::normalize(faces.normal.get(row));
    return {normal, glm::dot(normal, faces.centroid(row))};
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Chooses among `valid`, the faces that are valid for a plane. The others stay for later planes.
/// Gives rows of `valid`, ascending, at least one where there is one. Pure.
template <class G>
concept face_grouping = std::copyable<G> &&
    requires(const G& choose, const face_table& valid, const plane& p, double epsilon,
             parallel threads) {
    { choose(valid, p, epsilon, threads) } -> std::same_as<face_rows>;
    { G::takes_all } -> std::convertible_to<bool>;
};

/// A plane takes every face that is valid for it.
struct whole_set {
    static constexpr bool takes_all = true;

    [[nodiscard]] face_rows operator()(const face_table& valid, const plane&, double,
                                       parallel) const {
        face_rows all(valid.size);
        std::iota(all.begin(), all.end(), 0u);
        return all;
    }
};
static_assert(face_grouping<whole_set>);

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

namespace detail {

/// The rectangle that a face covers on a plane, along the axes of a frame.
struct face_extent {
    dvec2 low{0};
    dvec2 high{0};
};

[[nodiscard]] inline dvec2 corner_on_plane(const face_table& faces, const frame& axes,
                                           std::size_t row, std::size_t k) noexcept {
    const dvec3 corner = faces.corner[k].get(row);
    return {glm::dot(axes.u, corner), glm::dot(axes.v, corner)};
}

[[nodiscard]] inline std::vector<face_extent> extents_on_plane(const face_table& faces,
                                                               const frame& axes,
                                                               parallel threads) {
    std::vector<face_extent> extents(faces.size);
    threads.for_chunks(faces.size, 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            const dvec2 a = corner_on_plane(faces, axes, row, 0);
            const dvec2 b = corner_on_plane(faces, axes, row, 1);
            const dvec2 c = corner_on_plane(faces, axes, row, 2);
            extents[row] = {glm::min(glm::min(a, b), c), glm::max(glm::max(a, b), c)};
        }
    });
    return extents;
}

/// The longer side of the median face's extent. Needs a face.
[[nodiscard]] inline double median_extent(std::span<const face_extent> extents) {
    std::vector<double> sides;
    sides.reserve(extents.size());
    for (const face_extent& e : extents) {
        sides.push_back(std::max(e.high.x - e.low.x, e.high.y - e.low.y));
    }
    const auto middle = sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2);
    std::nth_element(sides.begin(), middle, sides.end());
    return *middle;
}

/// The island of each face, numbered from 0: faces are of one island when a chain of cells that they
/// occupy, side by side or corner to corner, joins them. A face occupies all cells that its extent
/// touches. Cost O(faces + cells they occupy); at most ceil(2 · radius / cell + 1)² cells.
[[nodiscard]] inline std::vector<std::uint32_t> islands_of(std::span<const face_extent> extents,
                                                           double radius, double cell,
                                                           std::size_t& island_count) {
    const int side = static_cast<int>(2 * radius / cell) + 1;
    const auto column = [&](double at) {
        return std::clamp(static_cast<int>((at + radius) / cell), 0, side - 1);
    };
    const auto id = [&](int x, int y) { return static_cast<std::uint32_t>(y * side + x); };
    disjoint_sets cells(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    std::vector<char> is_occupied(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    std::vector<std::uint32_t> first_cell;
    first_cell.reserve(extents.size());
    for (const face_extent& e : extents) {
        const int left = column(e.low.x), right = column(e.high.x);
        const int bottom = column(e.low.y), top = column(e.high.y);
        first_cell.push_back(id(left, bottom));
        for (int y = bottom; y <= top; ++y) {
            for (int x = left; x <= right; ++x) is_occupied[id(x, y)] = 1;
        }
    }
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            if (!is_occupied[id(x, y)]) continue;
            const auto join = [&](int i, int j) {
                if (i >= 0 && i < side && j < side && is_occupied[id(i, j)]) {
                    cells.join(id(x, y), id(i, j));
                }
            };
            join(x + 1, y), join(x - 1, y + 1), join(x, y + 1), join(x + 1, y + 1);
        }
    }
    // Empty cells are sets too: number those of faces only.
    std::vector<std::uint32_t> number(is_occupied.size(), no_id);
    std::vector<std::uint32_t> island;
    island.reserve(extents.size());
    std::uint32_t count = 0;
    for (const std::uint32_t at : first_cell) {
        std::uint32_t& n = number[cells.leader(at)];
        if (n == no_id) n = count++;
        island.push_back(n);
    }
    island_count = count;
    return island;
}

/// A convex outline, and the area of the least rectangle around it.
struct outline {
    std::vector<dvec2> hull{};
    double rectangle = 0;
};

[[nodiscard]] inline outline outline_of(std::vector<dvec2> points) {
    outline result{.hull = std::vector<dvec2>(points.size() + 1)};
    result.hull.resize(convex_hull(points, result.hull));
    result.rectangle = minimum_rectangle(result.hull).area();
    return result;
}

}  // namespace detail

/// Takes the island of most contribution, and others for which a plane of their own would cost more
/// than the empty texels between. The rest stays for later planes, which may be the same one again.
///
/// Two islands share a plane when
///   (rectangle around both - rectangle of each) · texel_cost < 1,
/// areas in squares of the radius, so that texel_cost says how many planes an empty area of one
/// radius squared is worth. With T texels along the diameter that area is T² / 4 texels: at T = 512
/// and the default, 16,384 empty texels pay for one more plane.
///
/// Source: Décoret et al. 2003, who weigh the number of planes against compact textures; Luksch 2009,
/// section 3.3. Differs: a grid on the plane finds the islands; only the plane at hand is searched
/// for its heaviest one, not the runners-up, as the thesis advises.
template <contribution<float> Contribution = projected_area>
struct heaviest_group {
    static constexpr bool takes_all = false;

    double texel_cost = 4;  ///< planes a radius squared, ≥ 0; 0 takes every face
    double cell_faces = 2;  ///< side of a grid cell in median faces, > 0: smaller gaps part nothing
    double least_cell = 0.05;  ///< side of a grid cell in radii, at least, ≥ 0.01
    Contribution worth{};      ///< weighs the islands

    /// Cost O(faces log faces), partly parallel.
    [[nodiscard]] face_rows operator()(const face_table& valid, const plane& p, double,
                                       parallel threads = {}) const {
        const frame axes = frame_around(p.normal);
        const double radius = valid.bounds.radius;
        face_rows kept(valid.size);
        std::iota(kept.begin(), kept.end(), 0u);
        if (valid.size < 2 || !(texel_cost > 0)) return kept;

        const auto extents = detail::extents_on_plane(valid, axes, threads);
        const double cell =
            std::max(cell_faces * detail::median_extent(extents), least_cell * radius);
        std::size_t island_count = 0;
        const auto island = detail::islands_of(extents, radius, cell, island_count);
        if (island_count == 1) return kept;
        const auto is_taken = choose(valid, axes, p, island, island_count);
        std::erase_if(kept, [&](std::uint32_t row) { return !is_taken[island[row]]; });
        return kept;
    }

private:
    /// The heaviest island, then in order of weight each that costs less here than on its own, until
    /// no other does.
    [[nodiscard]] std::vector<char> choose(const face_table& valid, const frame& axes,
                                           const plane& p, std::span<const std::uint32_t> island,
                                           std::size_t island_count) const {
        const vec3_lanes<float> normal = fill_lanes<float>(vec3(p.normal));
        std::vector<double> weight(island_count);
        std::vector<std::vector<dvec2>> points(island_count);
        for (std::size_t row = 0; row < valid.size; ++row) {
            weight[island[row]] +=
                static_cast<double>(worth(load_faces<float>(valid, row), normal));
            for (std::size_t k = 0; k < 3; ++k) {
                points[island[row]].push_back(detail::corner_on_plane(valid, axes, row, k));
            }
        }
        std::vector<detail::outline> outlines;
        outlines.reserve(island_count);
        for (auto& of_island : points) {
            outlines.push_back(detail::outline_of(std::move(of_island)));
        }
        std::vector<std::uint32_t> order(island_count);
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::stable_sort(order, std::greater{}, [&](auto i) { return weight[i]; });

        const double plane_worth = valid.bounds.radius * valid.bounds.radius / texel_cost;
        std::vector<char> is_taken(island_count);
        is_taken[order[0]] = 1;
        detail::outline all = outlines[order[0]];
        for (bool grows = true; grows;) {
            grows = false;
            for (const std::uint32_t i : order) {
                if (is_taken[i]) continue;
                std::vector<dvec2> both = all.hull;
                both.insert(both.end(), outlines[i].hull.begin(), outlines[i].hull.end());
                detail::outline joint = detail::outline_of(std::move(both));
                if (joint.rectangle - all.rectangle - outlines[i].rectangle < plane_worth) {
                    is_taken[i] = 1;
                    all = std::move(joint);
                    grows = true;
                }
            }
        }
        return is_taken;
    }
};
static_assert(face_grouping<heaviest_group<>>);

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/direction_search.hpp
// Turning a plane to where it collects more: a pattern search over normals.
//
// Pattern search is R. Hooke, T. A. Jeeves: "Direct search" solution of numerical and statistical
// problems. Journal of the ACM, 1961. Its use here is ours: with the offset swept exactly, two
// dimensions are left, and a coarse raster of normals is enough to start from.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

// ---- billow/search/offset_sweep.hpp
// The best offset of a plane whose normal is known, exactly: a sweep over the ends of the intervals of
// offsets at which faces are valid.
//
// For one normal n a face is valid from max n·v - epsilon to min n·v + epsilon (Luksch 2009, section
// 2.1), so the best offset is where the intervals of most weight lie over each other: sort the ends,
// walk along them. Neither bins of offsets nor cells of normals are needed (Décoret et al. 2003 have
// both), so nothing is estimated and nothing has to be refined.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

// ---- billow/search/nearest_offset.hpp
// The offset nearest to faces that are valid for all of a range: where a falloff is least.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 3.2: a distance
// falloff draws planes to the faces that they stand for, eq 3.8: onto the large one, not between all.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>


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
// ---- billow/search/offset_block.hpp
// The offsets along one normal at which faces are valid and charged, a block of faces at a time.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>


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

namespace billow::inline BILLOW_ABI {

/// An offset, and what its plane collects. Unit: integers of the sweep's scale, uncharged.
struct swept_offset {
    float rho = 0;
    std::int64_t contribution = 0;
    std::int64_t penalty = 0;
    double density = -std::numeric_limits<double>::infinity();
    bool is_found = false;
};

/// What faces weigh in the buckets of one normal: the differences of two steps, of which sums from
/// the left give an upper bound of contribution and a lower bound of penalty in each bucket.
struct offset_row {
    std::span<std::int64_t> contribution;
    std::span<std::int64_t> penalty;  ///< empty where nothing is charged
};

/// How a sweep reads contribution c and penalty p: biased(c - charge · p, weight).
struct density_reading {
    double weight = 1;  ///< of the normal, > 0: orientation_bias and plane_distribution
    double charge = 0;  ///< weight of a penalty

    [[nodiscard]] double operator()(std::int64_t c, std::int64_t p) const noexcept {
        const auto contribution = static_cast<double>(c);
        return biased(charge == 0 ? contribution : contribution - charge * static_cast<double>(p),
                      weight);
    }
};

/// Buffers of a sweep, to be used again.
struct sweep_scratch {
    struct event {
        float at;
        std::int32_t bucket;
        bool is_after;  ///< counts beyond `at` only: the end of a closed interval
        std::int64_t contribution;
        std::int64_t penalty;
    };
    std::vector<event> events{};
    std::vector<std::int64_t> contribution_at{};  ///< where a bucket begins
    std::vector<std::int64_t> penalty_at{};
    std::vector<char> is_open{};
    std::vector<weighted_middle> middles{};
    detail::offset_block block{};
};

/// Sweeps of faces along normals, for one set of policies.
///
/// Weights are rounded to integers as in a density grid, so that sums do not depend on order: what a
/// row has gathered can be taken out again, and of two offsets the better one is the same for any
/// number of threads.
///
/// Differs from the validity policies of the density, which estimate the offsets of a cell of
/// normals: one normal leaves nothing to estimate, all of them are `valid_offsets`. A falloff has no
/// say in which faces a plane collects, see `nearest`.
template <contribution<simd::wide> Contribution, penalty<simd::wide> Penalty>
class offset_sweep {
public:
    /// Buckets per epsilon. They decide about time only: with more of them bounds are closer, and
    /// fewer normals have to be swept; beyond `most_buckets` rows leave the cache.
    static constexpr int buckets_per_epsilon = 64;
    static constexpr int most_buckets = 2048;

    /// `reach`: the farthest offset that matters, the radius. Keeps references to the policies.
    offset_sweep(const Contribution& worth, const Penalty& charge, double epsilon, double reach,
                 double scale)
        : rules_{worth,
                 charge,
                 offset_buckets(-reach, reach, bucket_count(reach, epsilon)),
                 static_cast<float>(epsilon),
                 static_cast<float>(scale),
                 !std::same_as<Penalty, no_penalty> && charge.weight > 0},
          charge_(charge.weight) {}

    /// The same sweep of the offsets between two only: with closer buckets, so with closer bounds.
    [[nodiscard]] offset_sweep focused(double low, double high) const noexcept {
        offset_sweep sweep = *this;
        sweep.rules_.buckets = offset_buckets(low, high, most_buckets / 2);
        sweep.rim_ = 1;  // these two hold all that lies outside
        return sweep;
    }

    [[nodiscard]] bool charges() const noexcept { return rules_.charges; }
    /// The weight that penalties have.
    [[nodiscard]] double charge() const noexcept { return charges() ? charge_ : 0; }
    [[nodiscard]] double scale() const noexcept { return static_cast<double>(rules_.scale); }
    [[nodiscard]] std::size_t row_size() const noexcept {
        return static_cast<std::size_t>(rules_.buckets.count()) + 2;
    }

    /// Adds the faces [begin, end) to a row, or takes them out. Needs multiples of the lanes.
    void change(const face_table& faces, std::size_t begin, std::size_t end, const vec3& normal,
                density_change change, const offset_row& row,
                detail::offset_block& block) const noexcept {
        for (std::size_t first = begin; first < end; first += block.size) {
            const std::size_t count = std::min(block.size, end - first);
            rules_.measure(faces, first, count, normal, block);
            if (change == density_change::add) {
                put<1>(block, count, row);
            } else {
                put<-1>(block, count, row);
            }
        }
    }

    /// No offset of the row has a greater density. Cost O(buckets).
    [[nodiscard]] double bound(const offset_row& row, const density_reading& read) const noexcept {
        std::int64_t c = 0, p = 0, most = 0;
        const std::size_t count = index(rules_.buckets.count()) - rim_;
        if (rim_ != 0) c = row.contribution[0], p = read.charge != 0 ? row.penalty[0] : 0;
        if (read.charge == 0) {
            for (std::size_t b = rim_; b < count; ++b) {
                c += row.contribution[b];
                most = std::max(most, c);
            }
            return read(most, 0);
        }
        double bound = -std::numeric_limits<double>::infinity();
        for (std::size_t b = rim_; b < count; ++b) {
            c += row.contribution[b];
            p += row.penalty[b];
            if (c > 0) bound = std::max(bound, read(c, p));
        }
        return bound;
    }

    /// The offset of most density, if it is more than `than`; of equals the least one. `row` holds
    /// `faces` and no others.
    ///
    /// Cost  O(faces + buckets), and O(e log e) for the e ends that lie in buckets whose bound is more
    ///       than `than`.
    [[nodiscard]] swept_offset best(const face_table& faces, const vec3& normal,
                                    const offset_row& row, const density_reading& read, double than,
                                    sweep_scratch& scratch) const {
        // Bounds are close: nearly always the best offset is in a bucket whose bound is near the
        // highest. Others are opened only when it was not.
        const double highest = bound(row, read);
        if (!(highest > than)) return {};
        const double near = std::max(than, highest - std::abs(highest) / 32);
        swept_offset found = best_beyond(faces, normal, row, read, near, scratch);
        if (!found.is_found && near > than) {
            found = best_beyond(faces, normal, row, read, than, scratch);
        }
        return found;
    }

    /// The same for faces that no row holds. `buckets` is one of row_size(), or two where penalties
    /// are charged; what is in it does not matter.
    [[nodiscard]] swept_offset best(const face_table& faces, const vec3& normal,
                                    const density_reading& read, double than,
                                    std::vector<std::int64_t>& buckets,
                                    sweep_scratch& scratch) const {
        buckets.assign(row_size() * (charges() ? 2 : 1), 0);
        const std::span all(buckets);
        const offset_row row{all.first(row_size()),
                             all.subspan(row_size(), all.size() - row_size())};
        change(faces, 0, faces.padded_size(), normal, density_change::add, row, scratch.block);
        return best(faces, normal, row, read, than, scratch);
    }

    /// Among the offsets around `rho` at which the same faces are valid and charged, the one nearest to
    /// the faces, each counted by its contribution and how `weigh` falls: nearest_offset.
    template <falloff<float> Falloff = distance_falloff>
    [[nodiscard]] double nearest(const face_table& faces, const vec3& normal, float rho,
                                 sweep_scratch& scratch, const Falloff& weigh = {}) const {
        constexpr float infinity = std::numeric_limits<float>::infinity();
        float low = rho < 0 ? -infinity : 0;
        float high = rho < 0 ? std::nextafter(0.0f, -1.0f) : infinity;
        if (!charges()) low = -infinity, high = infinity;
        detail::offset_block& block = scratch.block;
        std::vector<weighted_middle>& middles = scratch.middles;
        middles.clear();
        for (std::size_t first = 0; first < faces.padded_size(); first += block.size) {
            const std::size_t count = std::min(block.size, faces.padded_size() - first);
            rules_.measure(faces, first, count, normal, block);
            for (std::size_t i = 0; i < count; ++i) {
                if (block.weight[i] == 0) continue;
                const float from = block.valid.low[i], to = block.valid.high[i];
                if (from <= rho && rho <= to) {
                    low = std::max(low, from);
                    high = std::min(high, to);
                    middles.push_back(
                        {from + (to - from) / 2, static_cast<float>(block.weight[i])});
                }
                if (charges()) keep_uncharged(block, i, rho, low, high);
            }
        }
        if (middles.empty()) return static_cast<double>(rho);
        const double at =
            nearest_offset(middles, static_cast<double>(low), static_cast<double>(high),
                           static_cast<double>(rules_.epsilon), weigh);
        // As a float: a kernel must find the same faces valid.
        return static_cast<double>(std::clamp(static_cast<float>(at), low, high));
    }

private:
    using event = sweep_scratch::event;

    template <int Sign>
    void put(const detail::offset_block& block, std::size_t count,
             const offset_row& row) const noexcept {
        for (std::size_t i = 0; i < count; ++i) {
            const std::int64_t weight = Sign * std::int64_t{block.weight[i]};
            row.contribution[index(block.valid.first[i])] += weight;
            row.contribution[index(block.valid.last[i]) + 1] -= weight;
        }
        if (!rules_.charges) return;
        // Only what is charged throughout a bucket counts.
        const auto put_charge = [&](const detail::offset_ends& at, std::size_t i) {
            if (!(at.low[i] < at.high[i])) return;
            const std::int64_t weight = Sign * std::int64_t{block.weight[i]};
            const std::size_t begin = index(at.first[i]) + 1;
            row.penalty[begin] += weight;
            row.penalty[std::max(begin, index(at.last[i]))] -= weight;
        };
        for (std::size_t i = 0; i < count; ++i) {
            if (block.weight[i] == 0) continue;
            put_charge(block.above, i);
            put_charge(block.below, i);
        }
    }

    [[nodiscard]] static int bucket_count(double reach, double epsilon) noexcept {
        const double wanted = std::ceil(2 * reach / epsilon * buckets_per_epsilon);
        return static_cast<int>(std::clamp(wanted, 1.0, double{most_buckets}));
    }
    [[nodiscard]] static std::size_t index(std::int32_t bucket) noexcept {
        return static_cast<std::size_t>(bucket);
    }

    /// best() by opening all buckets that may hold more than `than`.
    [[nodiscard]] swept_offset best_beyond(const face_table& faces, const vec3& normal,
                                           const offset_row& row, const density_reading& read,
                                           double than, sweep_scratch& scratch) const {
        open_buckets(row, read, than, scratch);
        collect_events(faces, normal, read.charge != 0, scratch);
        return walk(read, than, scratch);
    }

    /// Marks the buckets that may hold more than `than`, and notes their bounds.
    void open_buckets(const offset_row& row, const density_reading& read, double than,
                      sweep_scratch& scratch) const {
        const auto count = index(rules_.buckets.count());
        scratch.is_open.assign(count, 0);
        scratch.contribution_at.resize(count);
        scratch.penalty_at.resize(count);
        std::int64_t c = 0, p = 0;
        for (std::size_t b = 0; b < count; ++b) {
            c += row.contribution[b];
            if (read.charge != 0) p += row.penalty[b];
            scratch.contribution_at[b] = c;
            scratch.penalty_at[b] = p;
            const bool is_asked_for = b >= rim_ && b + rim_ < count;
            const bool is_open = is_asked_for && c > 0 && read(c, p) > than;
            scratch.is_open[b] = is_open ? 1 : 0;
        }
    }

    /// Gathers the ends that lie in open buckets; turns the bounds of these buckets into what is
    /// valid and charged where they begin.
    void collect_events(const face_table& faces, const vec3& normal, bool counts_penalty,
                        sweep_scratch& scratch) const {
        std::vector<event>& events = scratch.events;
        events.clear();
        detail::offset_block& block = scratch.block;
        const auto is_open = [&](std::int32_t b) { return scratch.is_open[index(b)] != 0; };
        const auto add_charge = [&](const detail::offset_ends& at, std::size_t i, bool is_after) {
            if (!(at.low[i] < at.high[i])) return;
            const std::int32_t first = at.first[i], last = at.last[i];
            const std::int64_t weight = block.weight[i];
            if (is_open(first)) events.push_back({at.low[i], first, is_after, 0, weight});
            if (!is_open(last)) return;
            events.push_back({at.high[i], last, is_after, 0, -weight});
            if (first < last) scratch.penalty_at[index(last)] += weight;
        };
        for (std::size_t begin = 0; begin < faces.padded_size(); begin += block.size) {
            const std::size_t count = std::min(block.size, faces.padded_size() - begin);
            rules_.measure(faces, begin, count, normal, block);
            for (std::size_t i = 0; i < count; ++i) {
                const std::int64_t weight = block.weight[i];
                if (weight == 0) continue;
                const std::int32_t first = block.valid.first[i], last = block.valid.last[i];
                if (is_open(first)) {
                    events.push_back({block.valid.low[i], first, false, weight, 0});
                    scratch.contribution_at[index(first)] -= weight;
                }
                if (is_open(last)) events.push_back({block.valid.high[i], last, true, -weight, 0});
                if (counts_penalty) {
                    add_charge(block.above, i, false);
                    add_charge(block.below, i, true);
                }
            }
        }
        if (!counts_penalty) return;
        // Charges of either side end at 0.
        for (const float at : {std::nextafter(0.0f, -1.0f), 0.0f}) {
            const std::int32_t b = rules_.buckets.bucket_of(at);
            if (is_open(b)) events.push_back({at, b, false, 0, 0});
        }
    }

    /// Walks along the ends. Density grows only where an interval begins or a charge ends, and below 0
    /// just before an end, so the ends themselves are all that needs a look.
    [[nodiscard]] swept_offset walk(const density_reading& read, double than,
                                    sweep_scratch& scratch) const {
        std::vector<event>& events = scratch.events;
        std::sort(events.begin(), events.end(), [](const event& a, const event& b) {
            return a.at != b.at ? a.at < b.at : a.is_after < b.is_after;
        });
        swept_offset best;
        std::int64_t c = 0, p = 0;
        std::int32_t bucket = -1;
        for (std::size_t i = 0; i < events.size();) {
            if (events[i].bucket != bucket) {
                bucket = events[i].bucket;
                c = scratch.contribution_at[index(bucket)];
                p = scratch.penalty_at[index(bucket)];
            }
            const float at = events[i].at;
            const auto pass = [&](bool is_after) {
                for (; i < events.size() && events[i].at == at && events[i].is_after == is_after;
                     ++i) {
                    c += events[i].contribution;
                    p += events[i].penalty;
                }
            };
            pass(false);
            const double density = read(c, p);
            if (c > 0 && density > than) {
                than = density;
                best = {at, c, p, density, true};
            }
            pass(true);
        }
        return best;
    }

    /// Narrows [low, high] around `rho` to where no other charges of face i begin.
    static void keep_uncharged(const detail::offset_block& block, std::size_t i, float rho,
                               float& low, float& high) noexcept {
        constexpr float infinity = std::numeric_limits<float>::infinity();
        const detail::offset_ends& above = block.above;
        if (above.low[i] < above.high[i]) {
            if (rho < above.low[i]) high = std::min(high, std::nextafter(above.low[i], -infinity));
            if (rho >= above.high[i]) low = std::max(low, above.high[i]);
        }
        const detail::offset_ends& below = block.below;
        if (below.low[i] < below.high[i]) {
            if (rho <= below.low[i]) high = std::min(high, below.low[i]);
            if (rho > below.high[i]) low = std::max(low, std::nextafter(below.high[i], infinity));
        }
    }

    detail::offset_rules<Contribution, Penalty> rules_;
    double charge_;
    std::size_t rim_ = 0;  ///< buckets at either end that nobody asks for
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct direction_search_options {
    double first_step = 2.5 * std::numbers::pi / 180;  ///< radians; half of the raster's spacing
    double last_step = 0.15 * std::numbers::pi / 180;  ///< radians; the normal is as good as this
};

/// A normal with its best offset.
struct directed_plane {
    dvec3 normal{0, 0, 1};
    swept_offset at{};
};

/// Buffers of a search, to be used again.
struct direction_scratch {
    sweep_scratch sweep{};
    std::vector<std::int64_t> buckets{};
};

namespace detail {

/// The faces that may be valid for a plane whose normal is within a chord of that of `around`, and
/// whose offset is no farther from that of `around` than the plane's points inside the bounds move.
template <contribution<float> Contribution>
[[nodiscard]] face_table faces_within_reach(const face_table& faces, const directed_plane& around,
                                            double chord, double epsilon,
                                            const Contribution& worth) {
    const orientation_cell cell{.centre = vec3(around.normal), .chord = static_cast<float>(chord)};
    const double rho = static_cast<double>(around.at.rho);
    const double shift = chord * faces.bounds.radius;
    const parallel here{1};
    return select_rows(faces,
                       faces_valid_for_bin(faces, cell, rho - shift, rho + shift, epsilon,
                                           widened_centre{}, worth, here),
                       here);
}

}  // namespace detail

/// Tries six normals around the best one, closer and closer together, each with its best offset.
///
/// `weigh(normal)` is the weight of a normal, as in density_reading.
/// Needs   a start that has been swept.
/// Gives   a plane of at least the start's density. Of faces that come within reach by several long
///         moves in one direction some may go uncounted, so that it may be better than it says.
/// Cost    about 40 sweeps, of the faces within reach of the step at hand only.
template <class Sweep, contribution<float> Contribution, class Weigh>
[[nodiscard]] directed_plane search_directions(const Sweep& sweep, const face_table& faces,
                                               directed_plane best, double epsilon,
                                               const Contribution& worth, const Weigh& weigh,
                                               double charge,
                                               const direction_search_options& options,
                                               direction_scratch& scratch) {
    constexpr int most_moves = 2;  // a step; more come with the next one
    // What is charged lies up to an epsilon beyond what is valid.
    const double margin = charge != 0 ? 2 * epsilon : epsilon;
    face_table near;
    double turn = 0;
    for (double step = options.first_step; step >= options.last_step; step /= 2) {
        const double chord = 2 * std::sin((most_moves + 1) * step / 2);
        const bool is_first = step == options.first_step;
        near = detail::faces_within_reach(is_first ? faces : near, best, chord, margin, worth);
        const double rho = static_cast<double>(best.at.rho);
        const double reach = chord * faces.bounds.radius + epsilon / 16;
        const Sweep close = sweep.focused(rho - reach, rho + reach);
        for (int move = 0; move < most_moves; ++move) {
            const frame axes = frame_around(best.normal);
            directed_plane found = best;
            for (int k = 0; k < 6; ++k) {
                const double angle = turn + k * std::numbers::pi / 3;
                const dvec3 aside = axes.u * std::cos(angle) + axes.v * std::sin(angle);
                const dvec3 normal = glm::normalize(best.normal + aside * std::tan(step));
                const swept_offset at =
                    close.best(near, vec3(normal), {weigh(normal), charge}, found.at.density,
                               scratch.buckets, scratch.sweep);
                if (at.is_found) found = {normal, at};
            }
            if (found.normal == best.normal) break;
            best = found;
        }
        turn += std::numbers::pi / 6;
    }
    return best;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/exact_search.hpp
// Greedy search without a grid: the best plane over all normals of a plane space, by exact offsets.
//
// The greedy rule is that of Décoret et al. 2003; the sweep, its lazy evaluation and the search over
// normals between the samples take the place of their bins and refinement.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

// ---- billow/search/lazy_directions.hpp
// The best plane over many normals, of which few are swept: lazy evaluation.
//
// M. Minoux: Accelerated greedy algorithms for maximizing submodular set functions. 1978. What a
// plane would collect can only fall while faces leave, so what a normal was once worth bounds it for
// good: normals whose bound is below the best plane found so far need not be looked at.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// A plane through one of the normals.
struct swept_direction {
    std::size_t row = 0;
    swept_offset at{};
};

/// A row of buckets for each of a set of normals, and what is known of the best plane of each.
template <class Sweep>
class lazy_directions {
public:
    /// Keeps a reference to `sweep`. Memory: normals · sweep.row_size() integers, twice where
    /// penalties are charged: 10 MB at an epsilon of 10 % and a raster of 18.
    lazy_directions(const Sweep& sweep, std::vector<vec3> normals, parallel threads)
        : sweep_(sweep),
          threads_(threads),
          normals_(std::move(normals)),
          contribution_(normals_.size() * sweep.row_size()),
          penalty_(sweep.charges() ? contribution_.size() : 0),
          bounds_(normals_.size(), unknown),
          is_stale_(normals_.size(), 1),
          scratches_(threads.count()) {}

    [[nodiscard]] std::size_t size() const noexcept { return normals_.size(); }

    /// Adds faces to all rows, or takes them out. Cost O(faces · normals).
    void change(const face_table& faces, density_change change) {
        // Starting threads for a few faces costs more than the faces.
        const std::size_t chunk = faces.size * size() < 100'000 ? size() + 1 : rows_per_job;
        threads_.for_chunks(size(), chunk, [&](std::size_t begin, std::size_t end) {
            detail::offset_block block;
            for (std::size_t first = 0; first < faces.padded_size(); first += faces_per_pass) {
                const std::size_t last = std::min(first + faces_per_pass, faces.padded_size());
                for (std::size_t row = begin; row < end; ++row) {
                    sweep_.change(faces, first, last, normals_[row], change, row_of(row), block);
                }
            }
        });
        // Without a charge, a removal leaves all bounds true.
        const bool is_bounded = change == density_change::remove && !sweep_.charges();
        std::ranges::fill(is_stale_, 1);
        if (!is_bounded) std::ranges::fill(bounds_, unknown);
    }
    /// Takes all faces out.
    void clear() noexcept {
        std::ranges::fill(contribution_, 0);
        std::ranges::fill(penalty_, 0);
    }
    /// Bounds hold no longer: weights have grown, or something else is charged.
    void forget_bounds() noexcept {
        std::ranges::fill(bounds_, unknown);
        std::ranges::fill(is_stale_, 1);
    }

    /// The plane of most density over all normals, exactly; of equals that of the first row, and
    /// there of the least offset. Not found where no face is valid for any.
    ///
    /// `remaining` are the faces that are in the rows; `weights[row]` has not grown since the last call.
    /// Source Minoux 1978.
    template <class Weights>
    [[nodiscard]] swept_direction best(const face_table& remaining, const Weights& weights,
                                       double charge) {
        swept_direction best;
        const auto may_win = [&](const candidate& c) {
            return c.bound > best.at.density || (c.bound == best.at.density && c.row < best.row);
        };
        fill_heap();
        std::vector<candidate> batch;
        std::vector<swept_offset> swept;
        for (std::size_t most_swept = 2; !heap_.empty() && may_win(heap_.front());) {
            const bool is_stale = is_stale_[heap_.front().row] != 0;
            take_batch(is_stale, is_stale ? rows_per_job * 16 : most_swept, may_win, batch);
            if (is_stale) {
                renew_bounds(batch, weights, charge);
                continue;
            }
            sweep_batch(remaining, batch, weights, charge, best.at.density, swept);
            for (std::size_t i = 0; i < batch.size(); ++i) {
                const std::size_t row = batch[i].row;
                if (swept[i].is_found) {
                    bounds_[row] = swept[i].density;
                    if (may_win({swept[i].density, row})) best = {row, swept[i]};
                } else {
                    bounds_[row] = std::min(bounds_[row], best.at.density);
                }
            }
            most_swept = std::min<std::size_t>(2 * most_swept, 16);
        }
        return best;
    }

    /// Up to `count` planes of other rows that promise most after the last `best`, each with a
    /// normal that is farther than `chord` from those before it and from `from`.
    template <class Weights>
    [[nodiscard]] std::vector<swept_direction> runners_up(const face_table& remaining,
                                                          const Weights& weights, double charge,
                                                          std::size_t from, std::size_t count,
                                                          double chord) {
        std::vector<candidate> chosen;
        const auto is_apart = [&](std::size_t row, std::size_t other) {
            const double cosine = std::abs(glm::dot(dvec3(normals_[row]), dvec3(normals_[other])));
            return 2 - 2 * cosine > chord * chord;
        };
        fill_heap();
        std::vector<candidate> batch;
        while (chosen.size() < count && !heap_.empty() && heap_.front().bound > 0) {
            if (is_stale_[heap_.front().row] != 0) {
                take_batch(
                    true, rows_per_job * 16, [](const candidate&) { return true; }, batch);
                renew_bounds(batch, weights, charge);
                continue;
            }
            std::pop_heap(heap_.begin(), heap_.end());
            const candidate next = heap_.back();
            heap_.pop_back();
            if (is_apart(next.row, from) && std::ranges::all_of(chosen, [&](const candidate& c) {
                    return is_apart(next.row, c.row);
                })) {
                chosen.push_back(next);
            }
        }
        std::vector<swept_offset> swept;
        sweep_batch(remaining, chosen, weights, charge, unknown_density, swept);
        std::vector<swept_direction> found;
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            if (swept[i].is_found) found.push_back({chosen[i].row, swept[i]});
        }
        return found;
    }

private:
    static constexpr double unknown = std::numeric_limits<double>::infinity();
    static constexpr double unknown_density = -std::numeric_limits<double>::infinity();
    static constexpr std::size_t rows_per_job = 8;
    static constexpr std::size_t faces_per_pass = 1024;

    /// A row and its bound; less is worse, or a later row.
    struct candidate {
        double bound;
        std::size_t row;
        friend bool operator<(const candidate& a, const candidate& b) noexcept {
            return a.bound != b.bound ? a.bound < b.bound : a.row > b.row;
        }
    };

    [[nodiscard]] offset_row row_of(std::size_t row) noexcept {
        const std::size_t length = sweep_.row_size();
        const std::span penalty(penalty_);
        return {std::span(contribution_).subspan(row * length, length),
                penalty.empty() ? penalty : penalty.subspan(row * length, length)};
    }

    void fill_heap() {
        heap_.clear();
        for (std::size_t row = 0; row < size(); ++row) heap_.push_back({bounds_[row], row});
        std::make_heap(heap_.begin(), heap_.end());
    }

    /// Moves up to `most` candidates that are stale, or are not, from the top of the heap.
    template <class MayWin>
    void take_batch(bool is_stale, std::size_t most, const MayWin& may_win,
                    std::vector<candidate>& batch) {
        batch.clear();
        while (batch.size() < most && !heap_.empty() && may_win(heap_.front()) &&
               (is_stale_[heap_.front().row] != 0) == is_stale) {
            std::pop_heap(heap_.begin(), heap_.end());
            batch.push_back(heap_.back());
            heap_.pop_back();
        }
    }

    /// Sums up the rows of a batch, and puts them back with what their buckets promise.
    template <class Weights>
    void renew_bounds(const std::vector<candidate>& batch, const Weights& weights, double charge) {
        threads_.for_chunks(batch.size(), rows_per_job, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::size_t row = batch[i].row;
                const density_reading read{weights[row], charge};
                bounds_[row] = std::min(bounds_[row], sweep_.bound(row_of(row), read));
                is_stale_[row] = 0;
            }
        });
        for (const candidate& c : batch) {
            heap_.push_back({bounds_[c.row], c.row});
            std::push_heap(heap_.begin(), heap_.end());
        }
    }

    template <class Weights>
    void sweep_batch(const face_table& remaining, const std::vector<candidate>& batch,
                     const Weights& weights, double charge, double than,
                     std::vector<swept_offset>& swept) {
        swept.assign(batch.size(), {});
        // An equal density of an earlier row wins.
        than = std::nextafter(than, unknown_density);
        for_jobs(threads_, batch.size(), scratches_, [&](std::size_t i, sweep_scratch& scratch) {
            const std::size_t row = batch[i].row;
            swept[i] = sweep_.best(remaining, normals_[row], row_of(row),
                                   density_reading{weights[row], charge}, than, scratch);
        });
    }

    const Sweep& sweep_;
    parallel threads_;
    std::vector<vec3> normals_;
    std::vector<std::int64_t> contribution_;
    std::vector<std::int64_t> penalty_;
    std::vector<double> bounds_;
    std::vector<char> is_stale_;
    std::vector<sweep_scratch> scratches_;
    std::vector<candidate> heap_{};
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/parts.hpp
// The parts that a plane search is put together from.

#include <concepts>
#include <numbers>

// ---- billow/search/motion.hpp
// What happens to the vertices of the faces that are left when a plane has been found.

#include <array>
#include <concepts>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// A face of the mesh whose corners are drawn elsewhere. Unit: scene units, relative to the centre
/// of the table that was searched.
struct moved_face {
    face_id face = no_id;
    std::array<dvec3, 3> corners{};
};

/// Moves vertices during a search. The search works on a copy of its own, which it starts with all
/// faces and tells of each plane.
template <class M>
concept vertex_motion = std::copyable<M> &&
    requires(M& motion, const M& seen, const face_table& faces, const plane& p, double epsilon,
             face_table& remaining, face_rows& rows) {
    { M::is_still } -> std::convertible_to<bool>;
    { motion.start(faces, epsilon) } -> std::same_as<void>;
    /// Drops those `rows` of `faces` that must not be taken by `p` although their moved corners are
    /// valid for it.
    { seen.keep_allowed(faces, p, rows) } -> std::same_as<void>;
    /// Told that `p` has taken `faces`. Gives the rows of `remaining` whose corners move.
    { motion.plane_found(faces, p, remaining) } -> std::same_as<face_rows>;
    /// Moves the corners of those rows, and what the table derives from them.
    { seen.move(remaining, rows) } -> std::same_as<void>;
    /// All faces with a corner that has moved, by face.
    { seen.moved_faces() } -> std::same_as<std::vector<moved_face>>;
};

/// Every vertex stays where it is.
struct fixed_vertices {
    static constexpr bool is_still = true;

    void start(const face_table&, double) noexcept {}
    void keep_allowed(const face_table&, const plane&, face_rows&) const noexcept {}
    [[nodiscard]] face_rows plane_found(const face_table&, const plane&, const face_table&) {
        return {};
    }
    void move(face_table&, const face_rows&) const noexcept {}
    [[nodiscard]] std::vector<moved_face> moved_faces() const { return {}; }
};
static_assert(vertex_motion<fixed_vertices>);

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Planes are looked for in a density grid: greedy_search.
struct density_method {};

/// Planes are looked for by exact offsets, normal by normal: exact_search.
struct exact_method {
    /// How much more frontal faces count, ≥ 0, see tangent_share; 0: as the contribution policy says.
    double tangency = 0;
    /// Share of the faces' area, [0, 1]: when less is left, faces count whole, however askew, which
    /// ends the search with fewer planes; 0: never.
    double tail = 0.02;
    /// Normals that a local search starts from for each plane; 0: planes have normals of the space.
    int starts = 4;
    double last_step = 0.15 * std::numbers::pi / 180;  ///< of that search, radians, > 0
};

/// One of the two, chosen when the program runs.
struct either_method {
    bool is_exact = false;
    exact_method exact{};
};

/// Finds planes.
template <class M>
concept search_method = std::same_as<M, density_method> || std::same_as<M, exact_method> ||
    std::same_as<M, either_method>;

/// The parts of a pipeline that are chosen at compile time, each a value with its parameters:
/// `pipeline{spherical(24), density_policies{}, svd_fit{}}`.
template <plane_space Space = cube_map, class Policies = density_policies<>,
          plane_fitter Fitter = least_squares_fit, face_grouping Grouping = whole_set,
          vertex_motion Motion = fixed_vertices, search_method Search = density_method>
struct pipeline {
    Space space{};
    Policies policies{};
    Fitter fitter{};
    Grouping grouping{};
    Motion motion{};
    Search search{};
};
template <class Space, class Policies = density_policies<>, class Fitter = least_squares_fit,
          class Grouping = whole_set, class Motion = fixed_vertices, class Search = density_method>
pipeline(Space, Policies = {}, Fitter = {}, Grouping = {}, Motion = {}, Search = {})
    -> pipeline<Space, Policies, Fitter, Grouping, Motion, Search>;

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/plane_distribution.hpp
// Weights of orientations that fall with every plane found, so that planes spread over directions.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 3.3, which gives
// the idea; the formula and its numbers are ours.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// How much a plane restrains later planes of similar orientation.
struct plane_distribution {
    double strength = 0;  ///< share of the weight that the plane's own orientation loses, [0, 1];
                          ///< 0: off, 0.3 spreads planes without a need of many more
    double cutoff_deg = 25;  ///< angle to the plane from which nothing is lost, > 0
    double floor = 0.2;  ///< no weight falls below this, (0, 1]: parallel walls still get theirs
};

/// The weight of each row of a density grid: that of a bias, times what the planes so far have left.
class orientation_weights {
public:
    /// One row a cell; a row stands for the cell's centre and its opposite.
    template <orientation_bias Bias>
    orientation_weights(std::span<const orientation_cell> cells, const Bias& bias,
                        const plane_distribution& distribution)
        : distribution_(distribution), left_(cells.size(), 1.0) {
        for (const orientation_cell& cell : cells) {
            normals_.emplace_back(cell.centre);
            bias_.push_back(bias(normals_.back()));
        }
        weights_ = bias_;
    }

    [[nodiscard]] double operator[](std::size_t row) const noexcept { return weights_[row]; }

    /// Lowers the weights around the plane's normal and its opposite. Cost O(rows).
    void plane_found(const dvec3& normal) noexcept {
        if (!(distribution_.strength > 0)) return;
        for (std::size_t row = 0; row < weights_.size(); ++row) {
            const double cosine = std::min(std::abs(glm::dot(normals_[row], normal)), 1.0);
            const double angle_deg = std::acos(cosine) * 180 / std::numbers::pi;
            const double nearness = std::max(0.0, 1 - angle_deg / distribution_.cutoff_deg);
            left_[row] =
                std::max(distribution_.floor, left_[row] * (1 - distribution_.strength * nearness));
            weights_[row] = bias_[row] * left_[row];
        }
    }

private:
    plane_distribution distribution_;
    std::vector<dvec3> normals_{};
    std::vector<double> bias_{};
    std::vector<double> left_;
    std::vector<double> weights_{};
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/plane_sequence.hpp
// Planes one after the other, each with the faces that it takes: what all greedy searches share.
//
// X. Décoret, F. Durand, F. X. Sillion, J. Dorsey: Billboard clouds for extreme model
// simplification. SIGGRAPH 2003; Fuhrmann et al. 2005, section 3.3.3; Luksch 2009, section 3.2.

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

// ---- billow/search/fail_safe.hpp
// A plane for a bin that refinement found none in.
//
// Fuhrmann et al. 2005, section 3.3.2; Luksch 2009, section 3.2.

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// The row of most area; among equals the first. Needs a face.
[[nodiscard]] inline std::uint32_t largest_face(const face_table& faces) {
    const auto largest = std::max_element(faces.area.begin(), faces.area.end());
    return static_cast<std::uint32_t>(largest - faces.area.begin());
}

/// The plane that the largest face lies in: it serves at least that face. Needs a face.
[[nodiscard]] inline plane plane_of_largest_face(const face_table& faces) {
    return supporting_plane(faces, largest_face(faces));
}

/// Of the bin's centre plane, the average plane of its faces and the planes of its largest faces,
/// the one that `remaining` faces contribute most to; among equals the first of these.
///
/// Needs   candidates: those of the remaining faces that may be valid in the bin, at least one.
/// Cost    O(faces · 34), parallel.
/// Source  Fuhrmann et al. 2005, section 3.3.2; Luksch 2009, section 3.2. Differs: at most 32 faces
///         are tried, the largest, instead of all.
template <contribution<float> Contribution>
[[nodiscard]] plane fail_safe_plane(const face_table& remaining, const face_table& candidates,
                                    const plane& centre, double epsilon, const Contribution& worth,
                                    parallel threads = {}) {
    std::vector<plane> tries{centre, average_fit{}(candidates, centre)};
    face_rows order(candidates.size);
    std::iota(order.begin(), order.end(), 0u);
    const std::size_t count = std::min<std::size_t>(32, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                      order.end(), [&](std::uint32_t a, std::uint32_t b) {
                          const float area_a = candidates.area[a];
                          const float area_b = candidates.area[b];
                          return area_a != area_b ? area_a > area_b : a < b;
                      });
    for (std::size_t i = 0; i < count; ++i) {
        tries.push_back(supporting_plane(candidates, order[i]));
    }
    plane best = tries.front();
    double most = -1;
    for (const plane& p : tries) {
        const double sum = contribution_of(
            remaining, faces_valid_for(remaining, p, epsilon, worth, threads), p.normal, worth);
        if (sum > most) most = sum, best = p;
    }
    return best;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/leftovers.hpp
// What becomes of the faces that a search leaves when it stops before all of them have a plane.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 3.2.

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Which planes a skipped face may still join. The planes stay where they are.
struct skip_limits {
    double reach = 2;                ///< farthest corner of the face to the plane, epsilons, > 0
    double least_projection = 0.25;  ///< share of the face's area that the plane must show, [0, 1]:
                                     ///< less is a smear rather than a face
};

/// Distances of a face's three corners to a plane, in the unit of the table.
struct corner_distances {
    double largest = 0;
    double sum = 0;
};

[[nodiscard]] inline corner_distances distances_to(const plane& p, const face_table& faces,
                                                   std::size_t row) noexcept {
    corner_distances distances;
    for (const columns3& corner : faces.corner) {
        const double distance = std::abs(signed_distance(p, corner.get(row)));
        distances.largest = std::max(distances.largest, distance);
        distances.sum += distance;
    }
    return distances;
}

/// For each face the plane for which `cost(plane, row)` is least; among equals the first; no_id where
/// all costs are infinite. Cost O(faces · planes), parallel.
template <class Cost>
[[nodiscard]] std::vector<plane_id> cheapest_planes(const face_table& faces,
                                                    std::span<const plane> planes, const Cost& cost,
                                                    parallel threads = {}) {
    std::vector<plane_id> cheapest(faces.size, no_id);
    threads.for_chunks(faces.size, 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            double least = std::numeric_limits<double>::infinity();
            for (plane_id id = 0; id < planes.size(); ++id) {
                const double c = cost(planes[id], row);
                if (c < least) least = c, cheapest[row] = id;
            }
        }
    });
    return cheapest;
}

/// For each face the plane whose farthest corner of the face is nearest, however far that is.
[[nodiscard]] inline std::vector<plane_id> planes_of_least_error(const face_table& faces,
                                                                 std::span<const plane> planes,
                                                                 parallel threads = {}) {
    return cheapest_planes(
        faces, planes,
        [&](const plane& p, std::size_t row) { return distances_to(p, faces, row).largest; },
        threads);
}

/// For each face the nearest plane within the limits, by the sum of its corners' distances; no_id
/// where there is none.
///
/// Source  Luksch 2009, section 3.2: skipped faces go to the nearest plane, far ones are dropped.
///         Differs by limits where the thesis says "high distance", and by the face's projection.
[[nodiscard]] inline std::vector<plane_id> nearest_planes_within(const face_table& faces,
                                                                 std::span<const plane> planes,
                                                                 double epsilon,
                                                                 const skip_limits& limits,
                                                                 parallel threads = {}) {
    return cheapest_planes(
        faces, planes,
        [&](const plane& p, std::size_t row) {
            const corner_distances d = distances_to(p, faces, row);
            const bool is_near = d.largest <= limits.reach * epsilon;
            const bool is_shown =
                std::abs(glm::dot(p.normal, faces.normal.get(row))) >= limits.least_projection;
            return is_near && is_shown ? d.sum : std::numeric_limits<double>::infinity();
        },
        threads);
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// What the search did.
struct greedy_statistics {
    std::size_t refined_planes = 0;     ///< planes that refinement found
    std::size_t refinement_levels = 0;  ///< sum over those planes
    std::size_t fail_safes = 0;         ///< planes that refinement, or the sweep, did not find
    std::size_t tweaks = 0;             ///< planes that the fitter moved
    std::size_t degenerate_faces = 0;   ///< set aside: they have no area
    /// Faces without a plane when max_planes, skip_area or min_contribution ended the search, and
    /// those of them that found none afterwards: far or edge-on to all planes.
    std::size_t leftover_faces = 0;
    std::size_t dropped_faces = 0;
    /// Shares of the faces' area: of the leftover and the dropped faces, and of the leftover faces
    /// that joined a plane although a corner is beyond epsilon.
    double leftover_area_share = 0;
    double dropped_area_share = 0;
    double beyond_epsilon_area_share = 0;

    [[nodiscard]] double mean_refinement_level() const noexcept {
        return refined_planes == 0
                   ? 0
                   : static_cast<double>(refinement_levels) / static_cast<double>(refined_planes);
    }
};

struct greedy_result {
    billboard_cloud cloud{};  ///< without billboards: fit_billboards adds them
    greedy_statistics statistics{};
    std::vector<double> covered_area{};  ///< share of the faces' area on the planes up to each
    std::vector<moved_face> moved{};     ///< what the motion moved, around cloud.bounds.centre
};

namespace detail {

/// When a sequence of planes ends, and what becomes of the faces that are left: as greedy_options say.
struct sequence_options {
    double epsilon = 0;
    std::size_t max_planes = 0;
    double skip_area = 0;
    double min_contribution = 0;
    skip_limits skipped{};
};

/// Columns hold floats: within this margin the bound holds for the mesh's own vertices.
[[nodiscard]] inline double inner_epsilon(const face_table& faces, double epsilon) noexcept {
    return std::max(epsilon - 1e-6 * faces.bounds.radius, epsilon / 2);
}

/// The state of one search but for what finds the planes: a chooser.
///
/// A chooser is told of the faces that it has to serve by `change(faces, density_change)` and
/// `faces_taken(leaving, remaining)`, is asked for a plane by `find_plane(remaining, statistics)`,
/// and hears by `plane_found(plane)` what came of it.
template <class Pipeline>
class plane_sequence {
public:
    plane_sequence(face_table faces, const Pipeline& parts, const sequence_options& options,
                   parallel threads)
        : remaining_(std::move(faces)),
          policies_(parts.policies),
          fitter_(parts.fitter),
          grouping_(parts.grouping),
          motion_(parts.motion),
          options_(options),
          threads_(threads),
          epsilon_(inner_epsilon(remaining_, options.epsilon)) {}

    [[nodiscard]] const face_table& remaining() const noexcept { return remaining_; }

    template <class Chooser>
    greedy_result run(std::size_t face_count, Chooser& chooser, const progress_function& progress) {
        result_.cloud.bounds = remaining_.bounds;
        result_.cloud.epsilon = options_.epsilon;
        result_.cloud.plane_of_face.assign(face_count, no_id);
        result_.statistics.degenerate_faces = remaining_.degenerate.size();
        const double total_area = area_of(remaining_);

        motion_.start(remaining_, epsilon_);
        chooser.change(remaining_, density_change::add);
        double left = 1;
        while (remaining_.size > 0 && !is_budget_spent() && !(left < options_.skip_area)) {
            plane found = chooser.find_plane(remaining_, result_.statistics);
            face_rows taken = faces_taken_by(found);
            tweak(found, taken);
            if (collects_too_little(found, taken, total_area)) break;
            emit(found, taken, chooser);
            left = area_of(remaining_) / total_area;
            result_.covered_area.push_back(1 - left);
            report(progress, "search", 1 - left);
        }
        assign_leftovers(total_area);
        if (left > 0) report(progress, "search", 1);
        result_.moved = motion_.moved_faces();
        return std::move(result_);
    }

private:
    using motion_type = decltype(Pipeline::motion);

    [[nodiscard]] static double area_of(const face_table& faces) noexcept {
        return std::accumulate(faces.area.begin(), faces.area.end(), 0.0);
    }
    [[nodiscard]] bool is_budget_spent() const noexcept {
        return options_.max_planes != 0 && result_.cloud.planes.size() >= options_.max_planes;
    }
    /// Never true for the first plane, so that skipped faces have somewhere to go.
    [[nodiscard]] bool collects_too_little(const plane& found, const face_rows& taken,
                                           double total_area) const {
        return options_.min_contribution > 0 && !result_.cloud.planes.empty() &&
               contribution_of(remaining_, taken, found.normal, policies_.contribution) <
                   options_.min_contribution * total_area;
    }

    /// All remaining faces that are valid for the plane, not only those of the bin: re-evaluation
    /// (Luksch 2009, section 3.2). A plane that serves nobody gives way to that of the largest face,
    /// which takes at least its own face, so every round makes progress.
    [[nodiscard]] face_rows faces_taken_by(plane& found) const {
        face_rows taken = faces_allowed_on(found);
        if (taken.empty()) {
            found = plane_of_largest_face(remaining_);
            taken = faces_allowed_on(found);
        }
        if (taken.empty()) {  // epsilon is below what floats resolve
            taken.push_back(largest_face(remaining_));
        }
        return grouped(found, std::move(taken));
    }

    [[nodiscard]] face_rows faces_allowed_on(const plane& p) const {
        face_rows rows = faces_valid_for(remaining_, p, epsilon_, policies_.contribution, threads_);
        motion_.keep_allowed(remaining_, p, rows);
        return rows;
    }

    /// Those of the faces that the grouping wants on the plane. The others come again later.
    [[nodiscard]] face_rows grouped(const plane& p, face_rows rows) const {
        if constexpr (!std::remove_cvref_t<decltype(grouping_)>::takes_all) {
            const face_table faces = select_rows(remaining_, rows, threads_);
            face_rows wanted = grouping_(faces, p, epsilon_, threads_);
            BILLOW_ASSERT(!wanted.empty());
            for (std::uint32_t& row : wanted) row = rows[row];
            return wanted;
        }
        return rows;
    }

    /// Moves the plane to its faces, if all of them stay valid; then takes the faces that have become
    /// valid too. Source: Fuhrmann et al. 2005, section 3.3.3.
    void tweak(plane& found, face_rows& taken) {
        const face_table faces = select_rows(remaining_, taken, threads_);
        const plane moved = fitter_(faces, found);
        if (moved == found) return;
        face_rows all(faces.size);
        std::iota(all.begin(), all.end(), 0u);
        if (faces_valid_for(faces, moved, epsilon_, policies_.contribution, threads_).size() !=
            faces.size) {
            return;
        }
        const auto contribution = [&](const plane& p) {
            return contribution_of(faces, all, p.normal, policies_.contribution);
        };
        if (!fitter_.allows_less_contribution && contribution(moved) < contribution(found)) return;
        face_rows moved_taken = faces_allowed_on(moved);
        if (!std::ranges::includes(moved_taken, taken)) return;
        found = moved;
        taken = grouped(moved, std::move(moved_taken));
        ++result_.statistics.tweaks;
    }

    template <class Chooser>
    void emit(const plane& found, const face_rows& taken, Chooser& chooser) {
        const auto id = static_cast<plane_id>(result_.cloud.planes.size());
        result_.cloud.planes.push_back(canonical(found));
        chooser.plane_found(found);
        for (const std::uint32_t row : taken) {
            result_.cloud.plane_of_face[remaining_.source[row]] = id;
        }
        face_rows kept;
        kept.reserve(remaining_.size - taken.size());
        std::size_t next = 0;
        for (std::uint32_t row = 0; row < remaining_.size; ++row) {
            if (next < taken.size() && taken[next] == row) {
                ++next;
            } else {
                kept.push_back(row);
            }
        }
        const face_table leaving = select_rows(remaining_, taken, threads_);
        remaining_ = select_rows(remaining_, kept, threads_);
        if (!kept.empty()) chooser.faces_taken(leaving, remaining_);
        if constexpr (!motion_type::is_still) {
            const face_rows moving = motion_.plane_found(leaving, found, remaining_);
            chooser.change(select_rows(remaining_, moving, threads_), density_change::remove);
            motion_.move(remaining_, moving);
            chooser.change(select_rows(remaining_, moving, threads_), density_change::add);
        }
    }

    /// After max_planes every face keeps a plane; what is skipped goes to the nearest sensible one.
    void assign_leftovers(double total_area) {
        if (remaining_.size == 0) return;
        const std::vector<plane>& planes = result_.cloud.planes;
        const std::vector<plane_id> plane_of =
            is_budget_spent() ? planes_of_least_error(remaining_, planes, threads_)
                              : nearest_planes_within(remaining_, planes, options_.epsilon,
                                                      options_.skipped, threads_);
        greedy_statistics& statistics = result_.statistics;
        statistics.leftover_faces = remaining_.size;
        for (std::size_t row = 0; row < remaining_.size; ++row) {
            const double share = static_cast<double>(remaining_.area[row]) / total_area;
            statistics.leftover_area_share += share;
            result_.cloud.plane_of_face[remaining_.source[row]] = plane_of[row];
            if (plane_of[row] == no_id) {
                ++statistics.dropped_faces;
                statistics.dropped_area_share += share;
            } else if (distances_to(planes[plane_of[row]], remaining_, row).largest >
                       options_.epsilon) {
                statistics.beyond_epsilon_area_share += share;
            }
        }
    }

    face_table remaining_;
    const decltype(Pipeline::policies)& policies_;
    const decltype(Pipeline::fitter)& fitter_;
    const decltype(Pipeline::grouping)& grouping_;
    motion_type motion_;
    sequence_options options_;
    parallel threads_;
    double epsilon_;
    greedy_result result_{};
};

}  // namespace detail

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct exact_search_options {
    double epsilon = 0;          ///< largest distance of a vertex to its plane, scene units, > 0
    std::size_t max_planes = 0;  ///< 0: as many as it takes; else faces that are left join the
                                 ///< plane of least error, which breaks epsilon for them
    double coverage = 1;  ///< share of the faces' area, (0, 1]: the search ends when planes hold as
                          ///< much; faces that are left join a plane within `skipped`, or none
    double min_contribution = 0;        ///< as in greedy_options
    skip_limits skipped{};              ///< where faces that are left may go
    plane_distribution distribution{};  ///< restrains planes that are parallel to earlier ones
    exact_method method{};              ///< how planes are looked for
};

namespace detail {

/// A contribution, until the tail of a search begins: there the face's whole area.
template <class Contribution>
struct tail_worth {
    Contribution base;
    float least_cosine;
    bool is_tail = false;

    explicit tail_worth(const Contribution& worth) noexcept
        : base(worth), least_cosine(least_cosine_of(worth)) {}

    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        if (!is_tail) return base(face, normal);
        return simd::select(
            simd::abs(dot(face.normal, normal)) >= simd::lanes<V>::fill(least_cosine), face.area,
            simd::lanes<V>::fill(0));
    }
};

/// Finds the plane of most density: exactly over the normals of the space, then between them.
template <class Pipeline>
class exact_chooser {
public:
    exact_chooser(const face_table& faces, const Pipeline& parts,
                  const exact_search_options& options, parallel threads)
        : space_(parts.space),
          worth_(tangent_share(parts.policies.contribution, options.method.tangency)),
          method_(options.method),
          threads_(threads),
          epsilon_(inner_epsilon(faces, options.epsilon)),
          sweep_(worth_, parts.policies.penalty, epsilon_, faces.bounds.radius,
                 density_scale(faces)),
          area_(area_of(faces)),
          row_of_(space_.orientation_count()),
          cells_(make_cells()),
          weights_(cells_, parts.policies.bias, options.distribution),
          directions_(sweep_, floats(normals_), threads),
          scratches_(threads.count()) {}

    void change(const face_table& faces, density_change change) {
        directions_.change(faces, change);
    }
    void faces_taken(const face_table& leaving, const face_table& remaining) {
        if (!worth_.is_tail && area_of(remaining) < method_.tail * area_) {
            worth_.is_tail = true;
            directions_.clear();
            directions_.change(remaining, density_change::add);
        } else if (leaving.size <= remaining.size) {
            directions_.change(leaving, density_change::remove);
        } else {
            directions_.clear();
            directions_.change(remaining, density_change::add);
        }
    }
    void plane_found(const plane& found) noexcept { weights_.plane_found(found.normal); }

    [[nodiscard]] plane find_plane(const face_table& remaining, greedy_statistics& statistics) {
        double charge = sweep_.charge();
        swept_direction best = directions_.best(remaining, weights_, charge);
        if (charge != 0 && !(best.at.density > 0)) {
            charge = 0;
            directions_.forget_bounds();
            best = directions_.best(remaining, weights_, charge);
        }
        if (!best.at.is_found) {
            ++statistics.fail_safes;
            return plane_of_largest_face(remaining);
        }
        ++statistics.refined_planes;
        const directed_plane found = searched(remaining, best, charge);
        if (charge != sweep_.charge()) directions_.forget_bounds();
        const double rho = sweep_.nearest(remaining, vec3(found.normal), found.at.rho, scratch_);
        return {found.normal, rho};
    }

private:
    using space_type = decltype(Pipeline::space);
    using contribution_type =
        tail_worth<tangent_share<decltype(decltype(Pipeline::policies)::contribution)>>;
    using penalty_type = decltype(decltype(Pipeline::policies)::penalty);
    using sweep_type = offset_sweep<contribution_type, penalty_type>;

    [[nodiscard]] static double area_of(const face_table& faces) noexcept {
        return std::accumulate(faces.area.begin(), faces.area.end(), 0.0);
    }
    /// One row for n and -n, which share their planes.
    [[nodiscard]] std::vector<orientation_cell> make_cells() {
        std::vector<orientation_cell> cells;
        for (orientation_id id = 0; id < space_.orientation_count(); ++id) {
            const orientation_id opposite = space_.antipode(id);
            if (id <= opposite) {
                cells.push_back(space_.cell(id));
                normals_.push_back(space_.direction(id));
            }
            row_of_[id] =
                id <= opposite ? static_cast<std::uint32_t>(cells.size() - 1) : row_of_[opposite];
        }
        return cells;
    }
    [[nodiscard]] static std::vector<vec3> floats(const std::vector<dvec3>& normals) {
        return {normals.begin(), normals.end()};
    }

    /// The best plane near the best few normals; of equals the first.
    [[nodiscard]] directed_plane searched(const face_table& remaining, const swept_direction& best,
                                          double charge) {
        const auto directed = [&](const swept_direction& d) {
            return directed_plane{normals_[d.row], d.at};
        };
        std::vector<directed_plane> tries{directed(best)};
        if (method_.starts <= 0) return tries.front();
        const double spacing = 2 * static_cast<double>(cells_[best.row].chord);
        const auto others =
            directions_.runners_up(remaining, weights_, charge, best.row,
                                   static_cast<std::size_t>(method_.starts) - 1, spacing);
        for (const swept_direction& d : others) tries.push_back(directed(d));
        const auto weigh = [&](const dvec3& normal) {
            return weights_[row_of_[space_.orientation_of(normal)]];
        };
        const direction_search_options steps{.first_step = spacing / 4,
                                             .last_step = method_.last_step};
        for_jobs(threads_, tries.size(), scratches_,
                 [&](std::size_t i, direction_scratch& scratch) {
                     tries[i] = search_directions(sweep_, remaining, tries[i], epsilon_, worth_,
                                                  weigh, charge, steps, scratch);
                 });
        return *std::ranges::max_element(tries, {},
                                         [](const directed_plane& d) { return d.at.density; });
    }

    const space_type& space_;
    contribution_type worth_;
    exact_method method_;
    parallel threads_;
    double epsilon_;
    sweep_type sweep_;
    double area_;
    std::vector<std::uint32_t> row_of_;
    std::vector<dvec3> normals_{};
    std::vector<orientation_cell> cells_;
    orientation_weights weights_;
    lazy_directions<sweep_type> directions_;
    std::vector<direction_scratch> scratches_;
    sweep_scratch scratch_{};
};

}  // namespace detail

/// Finds planes that lie within epsilon of every vertex of every face: again and again the plane that
/// collects most, until no face is left or enough is covered.
///
/// For every normal of `parts.space` the best offset is found exactly, and with it the best plane over
/// all of these normals; pattern searches from the best few of them turn the plane to where it
/// collects more still. Of the equal offsets it takes the one nearest to the faces, and the fitter may
/// move it within epsilon. Then it takes all faces that are valid for it.
///
/// Policies: any contribution; penalties count exactly, too, but bounds are loose for them and all
/// normals are summed up for each plane; a bias and plane_distribution weigh normals, those between
/// the samples as the nearest one. Validity policies estimate what is exact here and are not asked; a
/// falloff has no say.
///
/// Guarantee. Where a face counts the same on all planes that it is valid for, as with method.tail 1,
/// what planes hold is a monotone submodular function of their set. Then the first k greedy planes
/// hold at least 1 - 1/e of what the best k hold (Nemhauser, Wolsey, Fisher 1978), and all of them are
/// at most 1 + ln(most area that a plane collects / least area of a face) times as many as are needed
/// (Wolsey 1982), the best being those among all offsets and the normals of the space; planes between
/// these normals, and the fitter's, only collect more. A contribution that depends on the normal is
/// greedy by the same rule but has no such proof, since a face that a plane shows askew is gone for
/// those that would show it better; nor have penalties, weights of normals, and groupings.
///
/// Shape, Unit, Gives: as greedy_search, whose result this is; covered_area is the curve of planes
/// against area. With coverage < 1 the faces that are left join a plane within `skipped`, which may
/// be farther than epsilon, or none: statistics tell their number and area.
/// Needs   options.epsilon > 0.
/// Fails   never.
/// Cost    O(faces · normals), twice at most, and O(remaining faces) for each normal that is swept;
///         130 bytes a face beyond the input, 10 to 32 MB for the rows of a raster of 18. Same
///         result for any thread count.
/// Source  The greedy rule: Décoret et al. 2003. G. L. Nemhauser, L. A. Wolsey, M. L. Fisher: An
///         analysis of approximations for maximizing submodular set functions I. Mathematical
///         Programming 14, 1978. L. A. Wolsey: An analysis of the greedy algorithm for the submodular
///         set covering problem. Combinatorica 2, 1982. Lazy evaluation: Minoux 1978.
template <class... Parts>
[[nodiscard]] greedy_result exact_search(face_table faces, std::size_t face_count,
                                         const exact_search_options& options,
                                         const pipeline<Parts...>& parts, parallel threads = {},
                                         const progress_function& progress = {}) {
    BILLOW_ASSERT(options.epsilon > 0 && options.coverage > 0 && options.coverage <= 1);
    detail::exact_chooser chooser(faces, parts, options, threads);
    return detail::plane_sequence(std::move(faces), parts,
                                  {.epsilon = options.epsilon,
                                   .max_planes = options.max_planes,
                                   .skip_area = 1 - options.coverage,
                                   .min_contribution = options.min_contribution,
                                   .skipped = options.skipped},
                                  threads)
        .run(face_count, chooser, progress);
}
[[nodiscard]] inline greedy_result exact_search(face_table faces, std::size_t face_count,
                                                const exact_search_options& options) {
    return exact_search(std::move(faces), face_count, options, pipeline{});
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/greedy.hpp
// The original greedy density search.
//
// X. Décoret, F. Durand, F. X. Sillion, J. Dorsey: Billboard clouds for extreme model
// simplification. SIGGRAPH 2003; with the corrections and extensions of C. Luksch: Implementation of
// an improved billboard cloud algorithm. Thesis, TU Wien 2009, and of Fuhrmann et al. 2005.

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

// ---- billow/search/refine.hpp
// From the densest bin to a plane: refinement.
//
// Décoret et al. 2003; Luksch 2009, sections 2.1 and 3.2. A bin's density promises only that many
// faces each have some valid plane in the bin, not that one plane serves them all, and the densest
// plane may lie in a neighbour. So the bin and what surrounds it are split again and again, and the
// densest part goes on, until its centre serves every face that is left.

#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// What becomes of the densest bin.
enum class refinement {
    original,   ///< split the bin and its 26 neighbours into 216 (Décoret et al. 2003)
    fail_safe,  ///< split the bin and what touches it into 64; when no plane is found, try the
    ///< planes of the bin's faces (Luksch 2009, section 3.2; Fuhrmann et al. 2005, 3.3.2)
    none,  ///< take the plane of its centre (Luksch 2009, section 3.2)
};

/// A part of plane space: the planes whose normal lies in a patch and whose offset in a range.
struct plane_bin {
    orientation_patch patch{};
    double rho_low = 0;
    double rho_high = 0;
};

/// The plane of the bin's centre.
template <plane_space Space>
[[nodiscard]] plane centre_plane(const Space& space, const plane_bin& bin) {
    return {space.direction_at(bin.patch.chart, bin.patch.centre),
            (bin.rho_low + bin.rho_high) / 2};
}

struct refine_options {
    int children_per_axis = 4;  ///< even: 4 gives 64 sub-bins (the layer that touches the bin), 6
                                ///< gives 216 (the whole neighbours)
    int max_levels = 12;        ///< > 0; each level halves the bin
    /// Share of the bin's contribution that its centre plane must serve to be taken, (0, 1]. 1 is
    /// the published rule; in soups of many small faces some always straddle a bin's border, so that
    /// it costs twelve levels and moves the plane by less than the fitting afterwards.
    double sufficient_share = 1;
    bool falls = true;  ///< whether the falloff policy counts
    /// Whether the penalty policy counts too. Fuhrmann et al. 2005 (section 3.2.2) leave it out, since
    /// planes that slice through foliage are wanted; Décoret et al. 2003 do not.
    bool penalty_counts = false;
};

/// A refined plane, and how many times its bin was split.
struct refined_plane {
    billow::plane plane{};
    int level = 0;
};

namespace detail {

/// The children of a bin along each axis, as cells and offsets, and the densest of them.
template <plane_space Space, class Policies>
class bin_splitter {
public:
    bin_splitter(const Space& space, const Policies& policies, double epsilon,
                 const refine_options& options, parallel threads)
        : space_(space),
          policies_(policies),
          epsilon_(epsilon),
          per_axis_(options.children_per_axis),
          penalty_counts_(options.penalty_counts),
          threads_(threads) {}

    struct child {
        plane_bin bin{};
        double contribution = 0;
    };

    /// The child of most density among `faces`; where penalties leave none above 0, that of most
    /// contribution.
    [[nodiscard]] child densest_child(const face_table& faces, const plane_bin& bin) const {
        const dvec2 half = bin.patch.half_size / 2.0;
        const double spacing = (bin.rho_high - bin.rho_low) / 2;
        std::vector<orientation_patch> patches;
        std::vector<orientation_cell> cells;
        std::vector<double> weights;
        for (int j = 0; j < per_axis_; ++j) {
            for (int i = 0; i < per_axis_; ++i) {
                const dvec2 step(2 * i + 1 - per_axis_, 2 * j + 1 - per_axis_);
                patches.push_back({bin.patch.chart, bin.patch.centre + half * step, half});
                cells.push_back(cell_of_patch(space_, patches.back()));
                weights.push_back(
                    policies_.bias(space_.direction_at(bin.patch.chart, patches.back().centre)));
            }
        }
        const double middle = (bin.rho_low + bin.rho_high) / 2;
        density_grid grid(cells.size(), {middle - spacing * per_axis_ / 2, spacing, per_axis_},
                          density_scale(faces));
        rasterize(faces, cells, grid);

        // Where several are worth the same, the one nearest to the middle: the first would drift to
        // the rim of the planes that serve all, where their centres do not.
        const auto densest = [&](const auto& worth) {
            dense_bin best{.density = -std::numeric_limits<double>::infinity()};
            double nearest = 0;
            for (std::size_t row = 0; row < grid.row_count(); ++row) {
                const dvec2 aside = (patches[row].centre - bin.patch.centre) / half;
                grid.for_each_bin(row, [&](int at, std::int64_t c, std::int64_t p) {
                    const double contribution = static_cast<double>(c) / grid.contribution_scale();
                    const double density =
                        worth(row, contribution, static_cast<double>(p) / grid.scale());
                    const double up = 2 * at + 1 - per_axis_;
                    const double distance = glm::dot(aside, aside) + up * up;
                    if (density > best.density || (density == best.density && distance < nearest)) {
                        best = {row, at, density, contribution};
                        nearest = distance;
                    }
                });
            }
            return best;
        };
        const double charge = policies_.penalty.weight;
        dense_bin best = densest([&](std::size_t row, double c, double p) {
            return c > 0 ? biased(c - charge * p, weights[row])
                         : -std::numeric_limits<double>::max();
        });
        if (best.density <= 0) {
            best =
                densest([&](std::size_t row, double c, double) { return biased(c, weights[row]); });
        }
        const double low = grid.axis().origin + best.bin * spacing;
        return {{patches[best.row], low, low + spacing}, best.contribution};
    }

private:
    void rasterize(const face_table& faces, std::span<const orientation_cell> cells,
                   density_grid& grid) const {
        const auto with = [&](const auto& policies) {
            rasterize_density(faces, cells, policies, epsilon_, grid, density_change::add,
                              threads_);
        };
        if (penalty_counts_) {
            with(policies_);
        } else {
            with(density_policies{policies_.validity, policies_.contribution, no_penalty{},
                                  policies_.falloff});
        }
    }

    const Space& space_;
    const Policies& policies_;
    double epsilon_;
    int per_axis_;
    bool penalty_counts_;
    parallel threads_;
};

}  // namespace detail

/// Splits `bin` until the plane of its centre serves all of the `candidates` that still have a plane
/// in it.
///
/// Needs   candidates that are simple-valid for the bin (faces_valid_for_bin with widened_centre).
/// Gives   nothing when a bin holds no face any more; after max_levels the last bin's centre.
/// Cost    O(candidates · children_per_axis²) a level, parallel.
/// Source  Luksch 2009, section 3.2. Differs: sub-bins may reach across rho = 0, where the offset
///         turns negative, instead of changing over to the opposite normal.
template <plane_space Space, class Policies>
[[nodiscard]] std::optional<refined_plane> refine(const Space& space, plane_bin bin,
                                                  face_table candidates, const Policies& policies,
                                                  double epsilon, const refine_options& options,
                                                  parallel threads = {}) {
    if constexpr (Policies::falls) {
        if (!options.falls) {
            return refine(space, bin, std::move(candidates), without_falloff(policies), epsilon,
                          options, threads);
        }
    }
    const detail::bin_splitter splitter(space, policies, epsilon, options, threads);
    // As a bin's contribution is: with the falloff where there is one, without penalty and bias.
    const auto contribution_to = [&](const plane& p, const face_rows& valid) {
        if constexpr (Policies::falls) {
            return contribution_of(candidates, valid, p, policies.contribution, policies.falloff,
                                   epsilon, bin.rho_high - bin.rho_low);
        } else {
            return contribution_of(candidates, valid, p.normal, policies.contribution);
        }
    };
    double promised = std::numeric_limits<double>::infinity();
    for (int level = 0;; ++level) {
        const plane centre = centre_plane(space, bin);
        const face_rows valid =
            faces_valid_for(candidates, centre, epsilon, policies.contribution, threads);
        if (valid.size() == candidates.size || level == options.max_levels ||
            contribution_to(centre, valid) >= options.sufficient_share * promised) {
            return refined_plane{centre, level};
        }
        const auto child = splitter.densest_child(candidates, bin);
        if (child.contribution <= 0) return std::nullopt;
        bin = child.bin;
        promised = child.contribution;
        const face_rows rows = faces_valid_for_bin(
            candidates, cell_of_patch(space, bin.patch), bin.rho_low, bin.rho_high, epsilon,
            widened_centre{}, policies.contribution, threads);
        if (rows.empty()) return std::nullopt;
        candidates = select_rows(candidates, rows, threads);
    }
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct greedy_options {
    double epsilon = 0;          ///< largest distance of a vertex to its plane, scene units, > 0
    double rho_rate = 1.5;       ///< offset bins per epsilon, > 0; Luksch 2009: stable from 0.75 on
    std::size_t max_planes = 0;  ///< 0: as many as it takes; else faces that are left join the
                                 ///< plane of least error, which breaks epsilon for them
    double skip_area = 0;  ///< share of the faces' area, [0, 1): the search ends when less is left;
                           ///< those faces join a plane within `skipped`, or none
    double min_contribution = 0;  ///< share of the faces' area, [0, 1): the search ends before a
                                  ///< plane that would collect less; its faces are skipped too
    skip_limits skipped{};        ///< where skipped faces may go
    plane_distribution distribution{};  ///< restrains planes that are parallel to earlier ones
    refinement refine = refinement::fail_safe;
    int max_levels = 12;                 ///< of refinement, > 0
    double sufficient_share = 1;         ///< refine_options::sufficient_share
    bool penalty_in_refinement = false;  ///< refine_options::penalty_counts
    falloff_use falloff = falloff_use::everywhere;
};

namespace detail {

/// Finds the plane of most density: the densest bin of a grid, refined.
template <class Pipeline>
class density_chooser {
public:
    density_chooser(const face_table& faces, const Pipeline& parts, const greedy_options& options,
                    parallel threads)
        : space_(parts.space),
          policies_(parts.policies),
          options_(options),
          threads_(threads),
          radius_(faces.bounds.radius),
          epsilon_(inner_epsilon(faces, options.epsilon)),
          rows_(make_rows(space_)),
          cells_(make_cells()),
          weights_(cells_, policies_.bias, options.distribution),
          grid_(with_grid_policies([&](const auto& used) {
              return make_density_grid(used, rows_.size(), make_axis(), density_scale(faces));
          })) {}

    void change(const face_table& faces, density_change change) {
        with_grid_policies([&](const auto& used) {
            rasterize_density(faces, cells(), used, epsilon_, grid_, change, threads_);
        });
    }
    void faces_taken(const face_table& leaving, const face_table&) {
        change(leaving, density_change::remove);
    }
    void plane_found(const plane& found) noexcept { weights_.plane_found(found.normal); }

    [[nodiscard]] plane find_plane(const face_table& remaining,
                                   greedy_statistics& statistics) const {
        const std::optional<plane_bin> bin = find_bin();
        if (!bin) return plane_of_largest_face(remaining);
        if (options_.refine == refinement::none) return centre_plane(space_, *bin);

        const face_table candidates =
            select_rows(remaining,
                        faces_valid_for_bin(remaining, cell_of_patch(space_, bin->patch),
                                            bin->rho_low, bin->rho_high, epsilon_, widened_centre{},
                                            policies_.contribution, threads_),
                        threads_);
        const bool is_original = options_.refine == refinement::original;
        const auto refined = candidates.size == 0
                                 ? std::nullopt
                                 : refine(space_, *bin, candidates, policies_, epsilon_,
                                          {.children_per_axis = is_original ? 6 : 4,
                                           .max_levels = options_.max_levels,
                                           .sufficient_share = options_.sufficient_share,
                                           .falls = options_.falloff != falloff_use::nowhere,
                                           .penalty_counts = options_.penalty_in_refinement},
                                          threads_);
        if (refined) {
            ++statistics.refined_planes;
            statistics.refinement_levels += static_cast<std::size_t>(refined->level);
            return refined->plane;
        }
        ++statistics.fail_safes;
        if (candidates.size == 0) return plane_of_largest_face(remaining);
        if (is_original) return plane_of_largest_face(candidates);
        return fail_safe_plane(remaining, candidates, centre_plane(space_, *bin), epsilon_,
                               policies_.contribution, threads_);
    }

private:
    using space_type = decltype(Pipeline::space);

    /// One row for n and -n, which share their planes.
    [[nodiscard]] static std::vector<orientation_id> make_rows(const space_type& space) {
        std::vector<orientation_id> rows;
        for (orientation_id id = 0; id < space.orientation_count(); ++id) {
            if (id <= space.antipode(id)) rows.push_back(id);
        }
        return rows;
    }

    [[nodiscard]] std::vector<orientation_cell> make_cells() const {
        std::vector<orientation_cell> cells;
        for (const orientation_id id : rows_) cells.push_back(space_.cell(id));
        return cells;
    }

    /// Bins over [-R, R] with a border at 0. Very small epsilons get bins of R / 2048.
    [[nodiscard]] offset_axis make_axis() const {
        constexpr double max_bins = 2048;
        const double spacing = std::max(options_.epsilon / options_.rho_rate, radius_ / max_bins);
        const int half = std::max(1, static_cast<int>(std::ceil(radius_ / spacing)));
        return {-half * spacing, spacing, 2 * half};
    }

    [[nodiscard]] std::span<const orientation_cell> cells() const noexcept { return cells_; }
    /// The densest bin; where penalties leave none above 0, that of most contribution; nothing when
    /// no face is simple-valid anywhere. Biases weigh both (Fuhrmann et al. 2005, section 3.3.5).
    [[nodiscard]] std::optional<plane_bin> find_bin() const {
        const double charge = policies_.penalty.weight;
        dense_bin best = densest_bin(
            grid_,
            [&](std::size_t row, double c, double p) {
                return c > 0 ? biased(c - charge * p, weights_[row])
                             : -std::numeric_limits<double>::max();
            },
            threads_);
        if (best.density <= 0) {
            best = densest_bin(
                grid_, [&](std::size_t row, double c, double) { return biased(c, weights_[row]); },
                threads_);
        }
        if (best.contribution <= 0) return std::nullopt;
        const double low = grid_.axis().origin + best.bin * grid_.axis().spacing;
        return plane_bin{space_.patch(rows_[best.row]), low, low + grid_.axis().spacing};
    }

    /// Calls `use` with the policies of the grid: falloff_use may leave the falloff to refinement.
    template <class Use>
    auto with_grid_policies(const Use& use) const {
        if constexpr (std::remove_cvref_t<decltype(policies_)>::falls) {
            if (options_.falloff != falloff_use::everywhere) return use(without_falloff(policies_));
        }
        return use(policies_);
    }

    const space_type& space_;
    const decltype(Pipeline::policies)& policies_;
    greedy_options options_;
    parallel threads_;
    double radius_;
    double epsilon_;
    std::vector<orientation_id> rows_;
    std::vector<orientation_cell> cells_;
    orientation_weights weights_;
    density_grid grid_;
};

}  // namespace detail

/// Finds planes that lie within epsilon of every vertex of every face: again and again the plane of
/// most density, until no face is left.
///
/// Shape   plane_of_face: one row a face of the mesh that `faces` was made of, `face_count` of them.
/// Unit    epsilon in scene units.
/// Needs   options.epsilon > 0, options.rho_rate > 0.
/// Gives   a cloud without billboards, in which every face that has an area lies on exactly one
///         plane; within epsilon unless max_planes cut the search short. The bound holds for the
///         mesh's own vertices down to epsilons of 2e-6 radii, where floats end.
/// Fails   never.
/// Cost    O(faces · orientations) twice, for the first density and for all removals together, and
///         O(faces · planes); 130 bytes a face beyond the input. Same result for any thread count.
/// Source  Décoret et al. 2003; Luksch 2009, sections 2.1, 3.2 and 4.3. Differs where the sources
///         err: see density/grid.hpp, policy/validity.hpp, search/refine.hpp.
template <class... Parts>
[[nodiscard]] greedy_result greedy_search(face_table faces, std::size_t face_count,
                                          const greedy_options& options,
                                          const pipeline<Parts...>& parts, parallel threads = {},
                                          const progress_function& progress = {}) {
    BILLOW_ASSERT(options.epsilon > 0 && options.rho_rate > 0);
    detail::density_chooser chooser(faces, parts, options, threads);
    return detail::plane_sequence(std::move(faces), parts,
                                  {.epsilon = options.epsilon,
                                   .max_planes = options.max_planes,
                                   .skip_area = options.skip_area,
                                   .min_contribution = options.min_contribution,
                                   .skipped = options.skipped},
                                  threads)
        .run(face_count, chooser, progress);
}
[[nodiscard]] inline greedy_result greedy_search(face_table faces, std::size_t face_count,
                                                 const greedy_options& options) {
    return greedy_search(std::move(faces), face_count, options, pipeline{});
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/plane_budget.hpp
// The epsilon that gives a cloud of about so many planes.
//
// Our own: Luksch 2009, section 5.2, looks for an epsilon by hand. The number of planes falls about
// as a power of epsilon, with small steps up and down, so the search runs in logarithms and keeps the
// best cloud it has seen rather than trust the last one.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

// ---- billow/search/search_planes.hpp
// The search that a pipeline names.

#include <concepts>
#include <type_traits>
#include <utility>


namespace billow::inline BILLOW_ABI {

/// What `method` needs of the options that all searches share. Those that are about bins and their
/// refinement have no counterpart.
[[nodiscard]] inline exact_search_options exact_options(const greedy_options& options,
                                                        const exact_method& method) {
    return {.epsilon = options.epsilon,
            .max_planes = options.max_planes,
            .coverage = 1 - options.skip_area,
            .min_contribution = options.min_contribution,
            .skipped = options.skipped,
            .distribution = options.distribution,
            .method = method};
}

/// greedy_search or exact_search, as `parts.search` says.
template <class... Parts>
[[nodiscard]] greedy_result search_planes(face_table faces, std::size_t face_count,
                                          const greedy_options& options,
                                          const pipeline<Parts...>& parts, parallel threads = {},
                                          const progress_function& progress = {}) {
    using method = std::remove_cvref_t<decltype(parts.search)>;
    const auto search_exactly = [&](const exact_method& how) {
        return exact_search(std::move(faces), face_count, exact_options(options, how), parts,
                            threads, progress);
    };
    if constexpr (std::same_as<method, exact_method>) {
        return search_exactly(parts.search);
    } else {
        if constexpr (std::same_as<method, either_method>) {
            if (parts.search.is_exact) return search_exactly(parts.search.exact);
        }
        return greedy_search(std::move(faces), face_count, options, parts, threads, progress);
    }
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct plane_budget_options {
    double first_epsilon = 0.1;   ///< where to start, shares of the radius, within the next two
    double least_epsilon = 1e-4;  ///< shares of the radius, > 0
    double most_epsilon = 1;      ///< shares of the radius
    int max_searches = 10;        ///< > 0
    double tolerance = 0.02;  ///< share of the planes asked for that may be more or fewer, ≥ 0
};

/// A result of the search that came closest to the number of planes.
template <class Result>
struct budgeted {
    Result result{};
    double epsilon = 0;  ///< scene units
    std::size_t planes = 0;
    int searches = 0;
};

/// Searches with one epsilon after the other until the number of planes is right.
///
/// `search(epsilon, limit)` gives a result. It may stop as soon as it has more than `limit` planes,
/// for then the result is of no use. `count(result)` is its number of planes, any number above
/// `limit` when the search was stopped.
///
/// Unit    epsilon and radius in scene units.
/// Needs   planes > 0, radius > 0. Both calls give the same for the same arguments.
/// Gives   the result nearest to `planes` of those seen that were not stopped; of two as near the one
///         with fewer planes. When all were stopped, that of most_epsilon.
/// Cost    max_searches searches and one more at most; those with too many planes are cut short.
template <class Search, class Count>
    requires std::invocable<const Search&, double, std::size_t>
[[nodiscard]] auto search_for_planes(std::size_t planes, double radius, const Search& search,
                                     const Count& count, const plane_budget_options& options = {}) {
    using result_type = std::invoke_result_t<const Search&, double, std::size_t>;
    BILLOW_ASSERT(planes > 0 && radius > 0 && options.max_searches > 0);
    const auto wanted = static_cast<double>(planes);
    const double allowed = options.tolerance * wanted;
    struct sample {
        double log_epsilon = 0;
        double log_planes = 0;
    };
    std::optional<sample> many;  // the largest epsilon with too many planes
    std::optional<sample> few;   // the smallest epsilon with too few
    std::optional<budgeted<result_type>> best;
    const double least = std::log(options.least_epsilon);
    const double most = std::log(options.most_epsilon);
    double at = std::clamp(std::log(options.first_epsilon), least, most);
    int searches = 0;
    while (searches < options.max_searches) {
        const double epsilon = std::exp(at) * radius;
        // More planes than this are no better than what there is; as a sample their bound will do.
        const double best_miss =
            best ? std::abs(static_cast<double>(best->planes) - wanted) : 2 * wanted + 8;
        const auto limit = static_cast<std::size_t>(wanted + std::max(best_miss, allowed));
        result_type result = search(epsilon, limit);
        const std::size_t found = count(result);
        ++searches;
        const double miss = static_cast<double>(found) - wanted;
        const bool is_better = !best || std::abs(miss) < best_miss ||
                               (std::abs(miss) == best_miss && found < best->planes);
        if (is_better && found <= limit) {
            best = budgeted<result_type>{std::move(result), epsilon, found, searches};
        }
        if (std::abs(miss) <= allowed) break;
        const sample seen{at, std::log(static_cast<double>(std::max<std::size_t>(found, 1)))};
        (miss > 0 ? many : few) = seen;
        if ((at == most && miss > 0) || (at == least && miss < 0)) break;

        const double goal = std::log(wanted);
        if (many && few) {
            // Between the two on a line, but a fifth of the way off either end: counts are rough,
            // and those of stopped searches too low.
            const double width = few->log_epsilon - many->log_epsilon;
            if (std::abs(width) < 1e-3) break;
            const double fall = many->log_planes - few->log_planes;
            const double share = fall > 0 ? (many->log_planes - goal) / fall : 0.5;
            at = many->log_epsilon + std::clamp(share, 0.2, 0.8) * width;
        } else {
            // Planes fall with a power of epsilon of about 1.5; a little farther, to enclose them.
            const double step = (seen.log_planes - goal) / 1.5;
            at = std::clamp(at + step * 1.1 + std::copysign(0.05, step), least, most);
        }
    }
    if (!best) {  // every search was stopped
        const double epsilon = options.most_epsilon * radius;
        result_type result = search(epsilon, std::numeric_limits<std::size_t>::max() - 1);
        const std::size_t found = count(result);
        best = budgeted<result_type>{std::move(result), epsilon, found, 0};
        ++searches;
    }
    best->searches = searches;
    return *std::move(best);
}

/// A greedy search, the one that the pipeline names, for a cloud of about `planes` planes.
///
/// Needs   planes > 0; options.max_planes and options.epsilon are not read.
/// Gives   the cloud, with the epsilon it keeps; no plane for a table without faces.
/// Cost    that of a few greedy searches, see search_for_planes; holds the faces a second time.
template <class... Parts>
[[nodiscard]] budgeted<greedy_result> greedy_search_for_planes(
    const face_table& faces, std::size_t face_count, std::size_t planes, greedy_options options,
    const pipeline<Parts...>& parts, parallel threads = {}, const progress_function& progress = {},
    const plane_budget_options& budget = {}) {
    double searches_done = 0;
    const double all = budget.max_searches;
    const progress_function progress_of_one = [&](std::string_view, double share) {
        report(progress, "search", (searches_done + share) / all);
    };
    const auto search = [&](double epsilon, std::size_t limit) {
        options.epsilon = epsilon;
        options.max_planes = limit + 1;
        greedy_result found =
            search_planes(faces, face_count, options, parts, threads, progress_of_one);
        ++searches_done;
        return found;
    };
    const auto count = [](const greedy_result& found) { return found.cloud.plane_count(); };
    if (faces.size == 0) {
        options.epsilon = std::max(faces.bounds.radius, 1.0);
        return {.result = search_planes(faces, face_count, options, parts, threads)};
    }
    budgeted<greedy_result> best =
        search_for_planes(planes, faces.bounds.radius, search, count, budget);
    report(progress, "search", 1);
    return best;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/weld_online.hpp
// Vertex welding during the search: the vertices of the faces that a plane takes move onto it, and
// the faces around them are searched as they are then.
//
// A. Fuhrmann, E. Umlauf, S. Mantler: Extreme model simplification for forest rendering. Eurographics
// Workshop on Natural Phenomena 2005, section 3.3.4.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

// ---- billow/search/weld_planes.hpp
// Where a vertex goes that faces on several planes share: vertex welding.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
// section 3.3; A. Fuhrmann, E. Umlauf, S. Mantler: Extreme model simplification for forest rendering.
// Eurographics Workshop on Natural Phenomena 2005, section 3.3.4.

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>


namespace billow::inline BILLOW_ABI {

enum class weld_kind {
    none,         ///< vertices stay
    first,        ///< onto the first plane of the vertex
    intersection  ///< onto the common intersection of up to three of its planes
};

struct weld_options {
    weld_kind kind = weld_kind::none;
    double min_angle = 15 * std::numbers::pi / 180;  ///< radians; a plane that is turned by less
        ///< from an earlier one of the vertex is left out; Luksch 2009 gives no number
    double tolerance = 0;  ///< vertices this close are one, scene units; 0: equal positions only
};

/// The planes that a vertex is welded to: the first ones of those it is told of.
class weld_planes {
public:
    [[nodiscard]] bool empty() const noexcept { return ids_[0] == no_id; }
    [[nodiscard]] plane_id first() const noexcept { return ids_[0]; }

    /// Takes plane `id` of `planes`, where there is room for it. Needs options.kind not none.
    /// Source: Luksch 2009, section 3.3.
    bool add(std::span<const plane> planes, plane_id id, const weld_options& options) noexcept {
        const std::size_t most = options.kind == weld_kind::first ? 1 : ids_.size();
        const double max_cosine = std::cos(options.min_angle);
        std::size_t count = 0;
        for (; count < most && ids_[count] != no_id; ++count) {
            const dvec3& normal = planes[ids_[count]].normal;
            if (std::abs(glm::dot(normal, planes[id].normal)) > max_cosine) return false;
        }
        if (count == most) return false;
        ids_[count] = id;
        return true;
    }

    /// Where the vertex goes: to the nearest point on as many of the planes as it reaches within
    /// `max_displacement`, of equally many the earliest ones.
    ///
    /// Source  Luksch 2009, section 3.3. Differs: where no two planes meet within reach, it goes
    ///         toward the nearest place where two do. Their projections of a point are apart by its
    ///         distance to their line times a sine, so no other step closes more of the crack.
    [[nodiscard]] dvec3 nearest(std::span<const plane> planes, const dvec3& vertex,
                                double max_displacement) const noexcept {
        static constexpr std::array<std::array<std::size_t, 3>, 4> tries{
            {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}};  // 3 is nobody
        if (empty() || !(max_displacement >= 0)) return vertex;
        double least = std::numeric_limits<double>::infinity();
        dvec3 step{0};
        for (const auto& some : tries) {
            std::array<plane, 3> chosen;
            std::size_t count = 0;
            bool is_known = true;
            for (const std::size_t i : some) {
                if (i == ids_.size()) continue;
                is_known = is_known && ids_[i] != no_id;
                if (is_known) chosen[count++] = planes[ids_[i]];
            }
            if (!is_known) continue;
            const auto at = nearest_common_point(std::span(chosen).first(count), vertex);
            if (!at) continue;
            const double distance = glm::distance(*at, vertex);
            if (distance <= max_displacement) return *at;
            if (count == 2 && distance < least) least = distance, step = (*at - vertex) / distance;
        }
        // Rounding up would break the promise.
        if (step != dvec3(0)) return vertex + step * (max_displacement * (1 - 1e-12));
        const plane& on = planes[first()];
        const double off = signed_distance(on, vertex);
        return std::abs(off) <= max_displacement ? vertex - on.normal * off : vertex;
    }

private:
    std::array<plane_id, 3> ids_{no_id, no_id, no_id};
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Moves vertices onto the planes that take their faces, by at most epsilon from where they were.
///
/// Needs   a table whose faces ascend, as make_face_table gives it.
/// Gives   `options.kind` first: onto the first plane, as published. intersection: later planes move
///         the vertex within the ones that it lies on, if they meet within epsilon. The corners that
///         faces have in the mesh stay within epsilon of their planes, too.
/// Cost    O(corners of the faces that a plane takes and of their neighbours) a plane; 100 bytes a
///         face. A face enters the density once more each time a corner moves.
/// Source  Fuhrmann et al. 2005, section 3.3.4. Differs: intersection, after Luksch 2009, section
///         3.3; the area that a face grows to counts only up to that of the largest one.
class weld_online {
public:
    static constexpr bool is_still = false;

    explicit weld_online(const weld_options& options = {.kind = weld_kind::intersection})
        : options_(options) {
        BILLOW_ASSERT(options.kind != weld_kind::none);
    }

    void start(const face_table& faces, double epsilon) {
        // What floats round is left of epsilon.
        epsilon_ = epsilon;
        planes_.clear();
        max_displacement_ = 0.999 * epsilon;
        source_ = faces.source;
        row_of_face_.assign(source_.empty() ? 0 : std::size_t{source_.back()} + 1, no_id);
        for (std::uint32_t row = 0; row < source_.size(); ++row) row_of_face_[source_[row]] = row;
        largest_area_ = 0;
        for (const float area : faces.area) largest_area_ = std::max(largest_area_, double{area});
        least_area_ = degenerate_area_share * faces.bounds.radius * faces.bounds.radius;
        least_shift_ = 1e-7 * faces.bounds.radius;

        const vertex_identity vertices = position_ids(faces, options_.tolerance);
        vertices_.assign(vertices.count, {});
        corners_.resize(3 * source_.size());
        original_.resize(3 * source_.size());
        begin_.assign(vertices.count + 1, 0);
        for (std::size_t row = 0; row < source_.size(); ++row) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t id = vertices.id[k * source_.size() + row];
                corners_[3 * row + k] = id;
                original_[3 * row + k] = faces.corner[k].get(row);
                ++begin_[id + 1];
            }
        }
        for (std::size_t i = 0; i < vertices.count; ++i) begin_[i + 1] += begin_[i];
        rows_.resize(corners_.size());
        std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
        for (std::size_t i = corners_.size(); i-- > 0;) {
            vertices_[corners_[i]].original = original_[i];
        }
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            vertex& v = vertices_[corners_[i]];
            v.spread = std::max(v.spread, glm::distance(v.original, original_[i]));
            rows_[next[corners_[i]]++] = static_cast<std::uint32_t>(i / 3);
        }
        for (vertex& v : vertices_) v.position = v.original;
    }

    void keep_allowed(const face_table& faces, const plane& p, face_rows& rows) const noexcept {
        std::erase_if(rows, [&](std::uint32_t row) {
            const std::size_t first = 3 * std::size_t{row_of_face_[faces.source[row]]};
            for (std::size_t i = first; i < first + 3; ++i) {
                if (is_moved(i) && std::abs(signed_distance(p, original_[i])) > epsilon_) {
                    return true;
                }
            }
            return false;
        });
    }

    [[nodiscard]] face_rows plane_found(const face_table& faces, const plane& p,
                                        const face_table& remaining) {
        const auto id = static_cast<plane_id>(planes_.size());
        planes_.push_back(p);
        face_rows moving;
        for (std::size_t row = 0; row < faces.size; ++row) {
            const std::size_t first = 3 * std::size_t{row_of_face_[faces.source[row]]};
            for (std::size_t i = first; i < first + 3; ++i) {
                vertex& v = vertices_[corners_[i]];
                if (v.last_plane == id) continue;
                v.is_torn |= v.last_plane != no_id;
                v.last_plane = id;
                if (!v.planes.add(planes_, id, options_)) continue;
                const dvec3 before = v.position;
                v.position = v.planes.nearest(planes_, v.original, max_displacement_ - v.spread);
                if (glm::distance(before, v.position) <= least_shift_) continue;
                add_rows_around(corners_[i], remaining, moving);
            }
        }
        std::sort(moving.begin(), moving.end());
        moving.erase(std::unique(moving.begin(), moving.end()), moving.end());
        return moving;
    }

    void move(face_table& remaining, const face_rows& rows) const noexcept {
        for (const std::uint32_t row : rows) {
            const std::array<dvec3, 3> corners = moved_corners(row_of_face_[remaining.source[row]]);
            const dvec3 cross = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
            const double area = glm::length(cross) / 2;
            if (area > least_area_) {
                remaining.set(row, corners, cross / (2 * area), std::min(area, largest_area_));
            } else {
                remaining.set(row, corners,
                              normal_of_line(corners, glm::normalize(remaining.normal.get(row))),
                              0);
            }
        }
    }

    /// Faces with a corner that lies on several planes.
    [[nodiscard]] std::vector<moved_face> moved_faces() const {
        std::vector<moved_face> moved;
        for (std::uint32_t row = 0; row < source_.size(); ++row) {
            bool is_torn = false;
            std::array<dvec3, 3> corners;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t i = 3 * std::size_t{row} + k;
                const bool moves = vertices_[corners_[i]].is_torn && is_moved(i);
                corners[k] = moves ? vertices_[corners_[i]].position : original_[i];
                is_torn |= moves;
            }
            if (is_torn) moved.push_back({source_[row], corners});
        }
        return moved;
    }

private:
    /// Vertices that are one.
    struct vertex {
        dvec3 original{0};
        dvec3 position{0};
        double spread = 0;  ///< of what the tolerance makes one
        weld_planes planes{};
        plane_id last_plane = no_id;
        bool is_torn = false;  ///< lies on several planes
    };

    [[nodiscard]] bool is_moved(std::size_t corner) const noexcept {
        const vertex& v = vertices_[corners_[corner]];
        return !v.planes.empty() && v.position != original_[corner];
    }
    [[nodiscard]] std::array<dvec3, 3> moved_corners(std::uint32_t row) const noexcept {
        std::array<dvec3, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = 3 * std::size_t{row} + k;
            corners[k] = is_moved(i) ? vertices_[corners_[i]].position : original_[i];
        }
        return corners;
    }

    void add_rows_around(std::uint32_t id, const face_table& remaining, face_rows& to) const {
        const auto begin = remaining.source.begin();
        const auto end = remaining.source.end();
        for (std::size_t i = begin_[id]; i < begin_[id + 1]; ++i) {
            const face_id face = source_[rows_[i]];
            const auto found = std::lower_bound(begin, end, face);
            if (found != end && *found == face) {
                to.push_back(static_cast<std::uint32_t>(found - begin));
            }
        }
    }

    /// A unit vector across the line that the corners lie on, as near to `wanted` as possible: a face
    /// without area lies in its supporting plane all the same.
    [[nodiscard]] static dvec3 normal_of_line(const std::array<dvec3, 3>& corners,
                                              const dvec3& wanted) noexcept {
        dvec3 line{0};
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec3 side = corners[(k + 1) % 3] - corners[k];
            if (glm::dot(side, side) > glm::dot(line, line)) line = side;
        }
        if (line == dvec3(0)) return wanted;
        line = glm::normalize(line);
        const dvec3 across = wanted - line * glm::dot(line, wanted);
        const double length = glm::length(across);
        return length > 1e-6 ? across / length : frame_around(line).u;
    }

    weld_options options_;
    double epsilon_ = 0;
    double max_displacement_ = 0;
    double largest_area_ = 0;
    double least_area_ = 0;
    double least_shift_ = 0;
    std::vector<plane> planes_{};
    std::vector<face_id> source_{};
    std::vector<std::uint32_t> row_of_face_{};
    std::vector<vertex> vertices_{};
    std::vector<std::uint32_t> corners_{};  ///< the vertex of corner k of row r at 3 r + k
    std::vector<dvec3> original_{};         ///< in the same order
    std::vector<std::size_t> begin_{};      ///< of a vertex, in rows_
    std::vector<std::uint32_t> rows_{};     ///< that a vertex is a corner of
};
static_assert(vertex_motion<weld_online>);

}  // namespace billow::inline BILLOW_ABI

// ---- billow/improve/cardboard.hpp
// A second billboard across thin ones: without it a stem is flat seen from the side.
//
// Fuhrmann, Umlauf, Mantler, "Extreme Model Simplification for Forest Rendering", 2005, section 3.3.6.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

struct cardboard_options {
    double min_coverage = 0.8;  ///< least area on the cardboard plane, as a share of that on the
                                ///< primary one; 0: no cardboard planes
    double min_elongation = 2;  ///< least length of the primary rectangle over its width; 1: any
    part_id only_part = no_id;  ///< planes of this part only; no_id: of all parts
};

namespace detail {

/// Looks for the cardboard plane of one primary plane.
class cardboard_finder {
public:
    cardboard_finder(const mesh& drawn, const billboard_cloud& cloud,
                     const cardboard_options& options)
        : mesh_(drawn), cloud_(cloud), options_(options) {}

    struct found {
        plane across{};
        std::vector<face_id> faces{};  ///< none: no cardboard plane
    };

    [[nodiscard]] found operator()(plane_id primary, std::span<const face_id> mapped) const {
        const plane& of = cloud_.planes[primary];
        const frame local = frame_around(of.normal);
        std::vector<dvec2> points;
        points.reserve(3 * mapped.size());
        dvec2 moment{0};
        double area = 0;
        for (const face_id face : mapped) {
            dvec2 sum{0};
            for (const dvec3& corner : corners_of(face)) {
                points.emplace_back(local.to_local(corner));
                sum += points.back();
            }
            const double weight = projected_area(face, of.normal);
            moment += sum * (weight / 3);
            area += weight;
        }
        if (!(area > 0)) return {};
        const oriented_rectangle rectangle = minimum_rectangle_of(std::move(points));
        const auto [shorter, longer] = std::minmax(rectangle.extent.x, rectangle.extent.y);
        if (longer < options_.min_elongation * shorter) return {};

        found best;
        double most = options_.min_coverage * area;
        for (const dvec2& side : {rectangle.axis, rectangle.height_axis()}) {
            const dvec3 normal = local.u * side.x + local.v * side.y;
            const plane across = canonical({normal, glm::dot(side, moment / area)});
            std::vector<face_id> faces = valid_faces(across, mapped, cloud_.epsilon_of(primary));
            double covered = 0;
            for (const face_id face : faces) covered += projected_area(face, normal);
            if (covered >= most && (best.faces.empty() || covered > most) && covered > 0) {
                most = covered;
                best = {across, std::move(faces)};
            }
        }
        return best;
    }

private:
    [[nodiscard]] std::array<dvec3, 3> corners_of(face_id face) const noexcept {
        const auto [a, b, c] = mesh_.corners(face);
        const dvec3& centre = cloud_.bounds.centre;
        return {dvec3(a) - centre, dvec3(b) - centre, dvec3(c) - centre};
    }
    [[nodiscard]] double projected_area(face_id face, const dvec3& normal) const noexcept {
        const auto [a, b, c] = corners_of(face);
        return 0.5 * std::abs(glm::dot(normal, glm::cross(b - a, c - a)));
    }
    [[nodiscard]] std::vector<face_id> valid_faces(const plane& across,
                                                   std::span<const face_id> mapped,
                                                   double epsilon) const {
        const double radius = cloud_.bounds.radius;
        std::vector<face_id> valid;
        for (const face_id face : mapped) {
            const auto [a, b, c] = corners_of(face);
            if (!(glm::length(glm::cross(b - a, c - a)) >
                  2 * degenerate_area_share * radius * radius)) {
                continue;  // nothing to draw
            }
            if (std::max({std::abs(signed_distance(across, a)),
                          std::abs(signed_distance(across, b)),
                          std::abs(signed_distance(across, c))}) <= epsilon * (1 + 1e-9)) {
                valid.push_back(face);
            }
        }
        return valid;
    }

    const mesh& mesh_;
    const billboard_cloud& cloud_;
    const cardboard_options& options_;
};

}  // namespace detail

/// Adds a cardboard plane to every plane that holds something long and thin. It is perpendicular to
/// its primary plane, goes through the centroid of the projected faces along an edge of their
/// rectangle of least area, and shows those of the primary plane's faces that are valid for it, too.
/// Of the two edges the one is taken whose plane has the larger coverage: the sum of the faces'
/// projected areas there, over the sum for all faces on the primary plane.
///
/// Needs  `drawn` as the cloud was searched in, or with moved vertices; called before
///        fit_billboards, which gives the new planes their rectangles.
/// Gives  the number of planes added. They are appended to `cloud.planes`, of the same part as their
///        primary one; their faces are in `cloud.also_drawn`. No face is mapped to them, and they
///        reach at most epsilon out of the primary plane on either side.
/// Cost   O(faces log faces), parallel over planes.
/// Source Fuhrmann et al. 2005, section 3.3.6. Differs: asks for a least elongation, as coverage
///        alone also admits lumps within 2 epsilon each way, that look alike from all sides.
inline std::size_t add_cardboard_planes(const mesh& drawn, billboard_cloud& cloud,
                                        const cardboard_options& options = {},
                                        parallel threads = {}) {
    BILLOW_ASSERT(cloud.plane_of_face.size() == drawn.face_count());
    if (!(options.min_coverage > 0)) return 0;
    const std::size_t primaries = cloud.plane_count();
    const faces_of_planes mapped(cloud.plane_of_face, primaries);
    const detail::cardboard_finder find(drawn, cloud, options);
    std::vector<detail::cardboard_finder::found> found(primaries);
    threads.for_chunks(primaries, 1, [&](std::size_t i, std::size_t) {
        const auto id = static_cast<plane_id>(i);
        if (options.only_part == no_id || options.only_part == cloud.part_of(id)) {
            found[i] = find(id, mapped[id]);
        }
    });
    for (plane_id primary = 0; primary < primaries; ++primary) {
        if (found[primary].faces.empty()) continue;
        const auto added = static_cast<plane_id>(cloud.plane_count());
        cloud.planes.push_back(found[primary].across);
        if (!cloud.part_of_plane.empty()) cloud.part_of_plane.push_back(cloud.part_of(primary));
        for (const face_id face : found[primary].faces) cloud.also_drawn.push_back({added, face});
    }
    return cloud.plane_count() - primaries;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/improve/drawn_mesh.hpp
// The mesh that is drawn on a cloud's planes when corners have moved there.

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// `source` with the corners of `moved` where they have moved to along the planes of their faces.
///
/// Across its plane a corner keeps the distance that it has in `source`. A picture on the plane is
/// the same for it, but what lay in front of something else still does, and heights above the plane
/// stay those of the source.
///
/// Shape   the faces, materials and images of `source`; a moved face has vertices of its own.
/// Needs   `moved` around cloud.bounds.centre, each with a plane; one row of plane_of_face a face.
/// Gives   normals, tangents, uvs and colours as in the source. Where that has no normals and
///         something has moved, every corner has the normal of its face in the source. Faces may
///         have lost their area.
/// Cost    O(vertices + faces), and a copy of the images.
[[nodiscard]] inline mesh drawn_mesh(const mesh& source, const billboard_cloud& cloud,
                                     std::span<const moved_face> moved) {
    if (moved.empty()) return source;
    const bool is_flat = source.normals.empty();
    mesh drawn;
    drawn.triangles = source.triangles;
    drawn.face_materials = source.face_materials;
    drawn.materials = source.materials;
    drawn.images = source.images;

    std::vector<std::uint32_t> origin;  // the vertex of the source that each vertex is made of
    const auto split = [&](face_id face) {
        for (int k = 0; k < 3; ++k) {
            origin.push_back(source.triangles[face][k]);
            drawn.triangles[face][k] = static_cast<std::uint32_t>(origin.size() - 1);
        }
    };
    if (is_flat) {
        for (face_id face = 0; face < source.face_count(); ++face) split(face);
    } else {
        origin.resize(source.vertex_count());
        std::iota(origin.begin(), origin.end(), 0u);
        for (const moved_face& m : moved) split(m.face);
    }
    detail::for_each_vertex_column(source, drawn, [&](const auto& from, auto& to) {
        if (from.empty()) return;
        to.reserve(origin.size());
        for (const std::uint32_t vertex : origin) to.push_back(from[vertex]);
    });
    if (is_flat) {
        drawn.normals.reserve(origin.size());
        for (face_id face = 0; face < source.face_count(); ++face) {
            const auto [a, b, c] = source.corners(face);
            const dvec3 cross = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
            const double length = glm::length(cross);
            const dvec3 normal = length > 0 ? cross / length : dvec3(0, 0, 1);
            drawn.normals.insert(drawn.normals.end(), 3, vec3(normal));
        }
    }
    for (const moved_face& m : moved) {
        const plane& on = cloud.planes[cloud.plane_of_face[m.face]];
        const std::array<vec3, 3> corners = source.corners(m.face);
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec3 was = dvec3(corners[k]) - cloud.bounds.centre;
            const dvec3 is = m.corners[k];
            const dvec3 at = is + on.normal * glm::dot(on.normal, was - is);
            drawn.positions[drawn.triangles[m.face][static_cast<glm::length_t>(k)]] =
                vec3(at + cloud.bounds.centre);
        }
    }
    return drawn;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/improve/envelope.hpp
// Which faces of other planes reach into what a billboard holds, so that they are drawn there, too.
//
// Huang, Novins, Wünsche, "Improved Billboard Clouds for Extreme Model Simplification", 2004, as told
// by Luksch 2009, section 2.4.

#include <algorithm>
#include <array>


namespace billow::inline BILLOW_ABI {

/// What is done against cracks between billboards while their textures are drawn.
enum class crack_reduction {
    none,     ///< a billboard shows its own faces and others that are valid for its plane
    envelope  ///< and those that reach into its envelope
};

/// The box of a billboard: its rectangle times the depths of its mapped faces.
class billboard_envelope {
public:
    /// `scale` shrinks or grows the box about its centre, `slack` then moves its sides outwards.
    /// Faces are relative to `origin`.
    billboard_envelope(const billboard& board, const dvec3& origin, double scale, double slack)
        : axes_{vec3(board.axes.u), vec3(board.axes.v), vec3(board.axes.normal)} {
        const dvec3 low(0, 0, board.depth_low);
        const dvec3 high(board.width, board.height, board.depth_high);
        const dvec3 half = (high - low) * (0.5 * scale) + slack;
        const dvec3 centre = board.axes.to_local(board.origin - origin) + (low + high) * 0.5;
        low_ = vec3(centre - half);
        high_ = vec3(centre + half);
    }

    /// 1 in the lanes of faces with a corner inside, 0 in the others.
    template <class V>
    [[nodiscard]] V reached_by(const face_lanes<V>& face) const noexcept {
        using lanes = simd::lanes<V>;
        V reached = lanes::fill(0);
        for (const vec3_lanes<V>& corner : face.corner) {
            V outside = lanes::fill(0);  // the farthest way out along an axis
            for (glm::length_t i = 0; i < 3; ++i) {
                const V at = dot(corner, fill_lanes<V>(axes_[static_cast<std::size_t>(i)]));
                outside = simd::max(
                    outside, simd::max(lanes::fill(low_[i]) - at, at - lanes::fill(high_[i])));
            }
            reached = simd::select(outside <= lanes::fill(0), lanes::fill(1), reached);
        }
        return reached;
    }

    /// Whether a sphere around faces leaves room for a corner inside.
    [[nodiscard]] bool may_meet(const bounding_sphere& sphere) const noexcept {
        for (glm::length_t i = 0; i < 3; ++i) {
            const double at = glm::dot(dvec3(axes_[static_cast<std::size_t>(i)]), sphere.centre);
            if (at + sphere.radius < low_[i] || at - sphere.radius > high_[i]) return false;
        }
        return true;
    }

private:
    std::array<vec3, 3> axes_;
    vec3 low_{};
    vec3 high_{};
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/improve/exchange.hpp
// Exchanges: planes go, others move or come to take their faces, and one plane fewer is left.
//
// Local search for the set cover problem: k sets are exchanged for fewer. Here sets are not given:
// every plane may be moved, as long as it keeps the faces that nobody else can take.

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <tuple>
#include <utility>
#include <vector>

// ---- billow/improve/joint_plane.hpp
// One plane for the faces of several: whether their joint width is at most 2 epsilon.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// How far faces reach along a normal, and the rows that do.
struct face_extent_along {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    std::uint32_t low_row = no_id;
    std::uint32_t high_row = no_id;

    [[nodiscard]] double width() const noexcept { return high - low; }
};

[[nodiscard]] inline face_extent_along extent_along(const face_table& faces,
                                                    std::span<const std::uint32_t> rows,
                                                    const dvec3& normal) noexcept {
    face_extent_along extent;
    for (const std::uint32_t row : rows) {
        for (const columns3& corner : faces.corner) {
            const double at = glm::dot(normal, corner.get(row));
            if (at < extent.low) extent.low = at, extent.low_row = row;
            if (at > extent.high) extent.high = at, extent.high_row = row;
        }
    }
    return extent;
}

/// The rows whose faces reach farthest along some directions, ascending: a small set whose least
/// width is nearly that of all. Cost O(rows).
[[nodiscard]] inline face_rows extreme_rows(const face_table& faces,
                                            std::span<const std::uint32_t> rows) {
    static constexpr std::size_t count = 20;
    struct extreme {
        float low = std::numeric_limits<float>::max();
        float high = -std::numeric_limits<float>::max();
        std::uint32_t low_row = no_id, high_row = no_id;
    };
    std::array<vec3, count> directions;  // a spiral of equal steps down a half sphere
    for (std::size_t i = 0; i < count; ++i) {
        const double z = (static_cast<double>(i) + 0.5) / count;
        const double around = static_cast<double>(i) * 2.399963229728653;  // the golden angle
        const double r = std::sqrt(1 - z * z);
        directions[i] = vec3(dvec3(r * std::cos(around), r * std::sin(around), z));
    }
    std::array<extreme, count> extremes;
    for (const std::uint32_t row : rows) {
        for (const columns3& corner : faces.corner) {
            const vec3 p(corner.x[row], corner.y[row], corner.z[row]);
            for (std::size_t i = 0; i < count; ++i) {
                const float at = glm::dot(directions[i], p);
                if (at < extremes[i].low) extremes[i].low = at, extremes[i].low_row = row;
                if (at > extremes[i].high) extremes[i].high = at, extremes[i].high_row = row;
            }
        }
    }
    face_rows found;
    if (rows.empty()) return found;
    for (const extreme& e : extremes) found.push_back(e.low_row), found.push_back(e.high_row);
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

namespace detail {

/// The least width of a tetrahedron: of its four heights and the distances of its three pairs of
/// opposite edges. 0 for a flat one.
[[nodiscard]] inline double tetrahedron_width(const std::array<dvec3, 4>& corner) noexcept {
    const double volume6 = std::abs(
        glm::dot(corner[1] - corner[0], glm::cross(corner[2] - corner[0], corner[3] - corner[0])));
    double largest = 0;  // of what divides the volume
    for (std::size_t i = 0; i < 4; ++i) {
        const dvec3 &a = corner[i == 0 ? 1 : 0], &b = corner[i <= 1 ? 2 : 1],
                    &c = corner[i <= 2 ? 3 : 2];
        largest = std::max(largest, glm::length(glm::cross(b - a, c - a)));
    }
    for (std::size_t i = 1; i < 4; ++i) {
        const dvec3 across = corner[i % 3 + 1] - corner[(i + 1) % 3 + 1];
        largest = std::max(largest, glm::length(glm::cross(corner[i] - corner[0], across)));
    }
    return largest > 0 ? volume6 / largest : 0;
}

/// The corner of some faces that `distance` finds farthest. Needs a row.
template <class Distance>
[[nodiscard]] dvec3 farthest_corner(const face_table& faces, std::span<const std::uint32_t> rows,
                                    const Distance& distance) noexcept {
    dvec3 best = faces.corner[0].get(rows[0]);
    double largest = -1;
    for (const std::uint32_t row : rows) {
        for (const columns3& corner : faces.corner) {
            const dvec3 p = corner.get(row);
            if (const double d = distance(p); d > largest) largest = d, best = p;
        }
    }
    return best;
}

/// Three corners of some faces that are far apart. Needs a row.
[[nodiscard]] inline std::array<dvec3, 3> wide_triangle(
    const face_table& faces, std::span<const std::uint32_t> rows) noexcept {
    const auto squared = [](const dvec3& v) { return glm::dot(v, v); };
    const dvec3 start = faces.corner[0].get(rows[0]);
    const dvec3 a = farthest_corner(faces, rows, [&](auto& p) { return squared(p - start); });
    const dvec3 b = farthest_corner(faces, rows, [&](auto& p) { return squared(p - a); });
    const dvec3 c =
        farthest_corner(faces, rows, [&](auto& p) { return squared(glm::cross(p - a, b - a)); });
    return {a, b, c};
}

/// What the width of some faces and a triangle is at least: that of a tetrahedron among them. Needs
/// a row.
[[nodiscard]] inline double least_width(const face_table& faces,
                                        std::span<const std::uint32_t> rows,
                                        const std::array<dvec3, 3>& triangle) noexcept {
    const auto& [a, b, c] = triangle;
    const dvec3 across = glm::cross(b - a, c - a);
    const double offset = glm::dot(a, across);
    const dvec3 d = farthest_corner(
        faces, rows, [&](auto& p) { return std::abs(glm::dot(p, across) - offset); });
    return tetrahedron_width({a, b, c, d});
}

/// Where a joint plane of the faces of two planes may lie: along either, between them, or around the
/// axis from the faces of one to those of the other.
[[nodiscard]] inline std::vector<dvec3> joint_normals(const dvec3& first, dvec3 second,
                                                      const dvec3& axis) {
    if (glm::dot(first, second) < 0) second = -second;
    std::vector<dvec3> normals{first, second, glm::normalize(first + second)};
    if (const double length = glm::length(axis); length > 0) {
        const frame around = frame_around(axis / length);
        for (int k = 0; k < 4; ++k) {
            const double angle = k * std::numbers::pi / 4;
            normals.push_back(around.u * std::cos(angle) + around.v * std::sin(angle));
        }
    }
    return normals;
}

}  // namespace detail

/// Looks for a plane within epsilon of all `rows`: their minimax plane (fit/minimax.hpp).
///
/// The search works on a few extreme faces, `core`; whatever face its plane leaves out joins them.
///
/// Needs   `core` of `rows`, both ascending, not empty; at least one of `normals`, where the search
///         starts from the narrowest.
/// Gives   a plane that was checked against all rows, in double, or nothing, which is no proof that
///         there is none.
/// Cost    O(rows) for every round, of which there are few; about 200 passes over the core.
[[nodiscard]] inline std::optional<plane> joint_plane(const face_table& faces,
                                                      std::span<const std::uint32_t> rows,
                                                      face_rows core,
                                                      std::span<const dvec3> normals,
                                                      double epsilon) {
    static constexpr int max_rounds = 12;
    BILLOW_ASSERT(!core.empty() && !normals.empty());
    // As exact as epsilon asks for, however small it is.
    const double finest = std::min(minimax_fit{}.last_step, 0.02 * epsilon / faces.bounds.radius);
    minimax_fit fit{.first_step = 12 * std::numbers::pi / 180, .last_step = finest};
    const auto extent = [&](const dvec3& normal) { return extent_along(faces, core, normal); };
    dvec3 normal =
        *std::ranges::min_element(normals, {}, [&](const dvec3& n) { return extent(n).width(); });
    for (int round = 0; round < max_rounds; ++round) {
        const face_table few = select_rows(faces, core, parallel{1});
        normal = fit(few, {normal, 0}).normal;
        if (extent(normal).width() > 2 * epsilon) break;
        const face_extent_along all = extent_along(faces, rows, normal);
        if (all.width() <= 2 * epsilon) return plane{normal, (all.low + all.high) / 2};
        core.push_back(all.low_row), core.push_back(all.high_row);
        fit.first_step = std::numbers::pi / 180;
    }
    return {};
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/improve/merge_planes.hpp
// Two planes become one: merging, and the elimination of planes that nobody needs.
//
// The density search repairs none of its early choices (Décoret et al. 2003 choose greedily). Here
// pairs of its planes are tried again, knowing all the others.

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

// ---- billow/improve/plane_cover.hpp
// Which faces each plane of a cloud may take, and which of them no other plane would.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Two planes, and the faces that these two alone can take.
struct plane_pair {
    plane_id first = no_id;
    plane_id second = no_id;
    face_rows rows{};
};

/// Planes, and the faces that lie within epsilon of each: a cover of the faces, in the words of the
/// set cover problem that a billboard cloud is.
///
/// Shape   P planes; `valid`: for each the rows of the table that it may take, ascending; `count`:
///         for each row the number of planes that may take it.
/// Unit    planes and epsilon as in the table.
class plane_cover {
public:
    /// The bound holds for the mesh's own vertices, as in greedy_search: columns hold floats.
    /// `least_cosine` as a contribution's, see least_cosine_of. `faces` must outlive the cover.
    plane_cover(const face_table& faces, std::vector<plane> planes, double epsilon,
                float least_cosine, parallel threads)
        : faces_(faces),
          threads_(threads),
          epsilon_(std::max(epsilon - 1e-6 * faces.bounds.radius, epsilon / 2)),
          planes_(std::move(planes)),
          counts_(faces.size, 0),
          origins_(planes_.size()) {
        worth_.least_cosine = least_cosine;
        std::iota(origins_.begin(), origins_.end(), 0u);
        for (const plane& p : planes_) {
            valid_.push_back(rows_for(p));
            add(counts_, valid_.back());
        }
    }

    [[nodiscard]] const face_table& faces() const noexcept { return faces_; }
    [[nodiscard]] double epsilon() const noexcept { return epsilon_; }
    /// The bound for who computes in double: the columns' floats then find the same faces valid.
    [[nodiscard]] double exact_epsilon() const noexcept {
        return std::max(epsilon_ - 1e-6 * faces_.bounds.radius, epsilon_ / 2);
    }
    [[nodiscard]] std::size_t plane_count() const noexcept { return planes_.size(); }
    [[nodiscard]] const std::vector<plane>& planes() const noexcept { return planes_; }
    /// Which of the first planes this one was, however it has moved.
    [[nodiscard]] plane_id origin(plane_id id) const noexcept { return origins_[id]; }
    [[nodiscard]] const face_rows& valid(plane_id id) const noexcept { return valid_[id]; }
    [[nodiscard]] const std::vector<std::uint32_t>& counts() const noexcept { return counts_; }

    /// The rows that any plane may take.
    [[nodiscard]] face_rows rows_for(const plane& p) const { return rows_for(p, threads_); }
    [[nodiscard]] face_rows rows_for(const plane& p, parallel threads) const {
        return faces_valid_for(faces_, p, epsilon_, worth_, threads);
    }

    /// The rows that only this plane can take.
    [[nodiscard]] face_rows essential(plane_id id) const { return essential(id, counts_); }
    /// The same where the planes are counted otherwise.
    [[nodiscard]] face_rows essential(plane_id id, std::span<const std::uint32_t> counts) const {
        face_rows rows;
        for (const std::uint32_t row : valid_[id]) {
            if (counts[row] == 1) rows.push_back(row);
        }
        return rows;
    }
    /// The pairs of planes that alone can take some faces, with these, ascending.
    [[nodiscard]] std::vector<plane_pair> essential_pairs() const;

    /// Puts another plane in the place of one. Needs `rows` as rows_for(p).
    void move(plane_id id, const plane& p, face_rows rows) {
        subtract(counts_, valid_[id]);
        planes_[id] = p;
        valid_[id] = std::move(rows);
        add(counts_, valid_[id]);
    }
    /// Later planes move up by one.
    void remove(plane_id id) {
        subtract(counts_, valid_[id]);
        planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(id));
        valid_.erase(valid_.begin() + static_cast<std::ptrdiff_t>(id));
        origins_.erase(origins_.begin() + static_cast<std::ptrdiff_t>(id));
    }

    static void add(std::span<std::uint32_t> counts, const face_rows& rows) noexcept {
        for (const std::uint32_t row : rows) ++counts[row];
    }
    static void subtract(std::span<std::uint32_t> counts, const face_rows& rows) noexcept {
        for (const std::uint32_t row : rows) --counts[row];
    }

private:
    const face_table& faces_;
    parallel threads_;
    double epsilon_;
    within_angle<> worth_{projected_area{}, 90};
    std::vector<plane> planes_;
    std::vector<face_rows> valid_{};
    std::vector<std::uint32_t> counts_;
    std::vector<plane_id> origins_;
};

inline std::vector<plane_pair> plane_cover::essential_pairs() const {
    struct shared_row {
        plane_id first, second;
        std::uint32_t row;
        // NOLINTNEXTLINE(modernize-use-nullptr): the 0 is of the comparison that the compiler writes
        auto operator<=>(const shared_row&) const = default;
    };
    std::vector<plane_id> first(faces_.size, no_id);
    std::vector<shared_row> shared;
    for (plane_id id = 0; id < planes_.size(); ++id) {
        for (const std::uint32_t row : valid_[id]) {
            if (counts_[row] != 2) continue;
            if (first[row] == no_id) {
                first[row] = id;
            } else {
                shared.push_back({first[row], id, row});
            }
        }
    }
    std::sort(shared.begin(), shared.end());
    std::vector<plane_pair> pairs;
    for (const shared_row& s : shared) {
        if (pairs.empty() || pairs.back().first != s.first || pairs.back().second != s.second) {
            pairs.push_back({s.first, s.second, {}});
        }
        pairs.back().rows.push_back(s.row);
    }
    return pairs;
}

/// Area of the given rows as a plane with `normal` shows it.
[[nodiscard]] inline double projected_area_of(const face_table& faces,
                                              std::span<const std::uint32_t> rows,
                                              const dvec3& normal) noexcept {
    double sum = 0;
    for (const std::uint32_t row : rows) {
        sum += static_cast<double>(faces.area[row]) *
               std::abs(glm::dot(normal, faces.normal.get(row)));
    }
    return sum;
}

/// All rows of both, ascending. Needs ascending rows.
[[nodiscard]] inline face_rows united(const face_rows& a, const face_rows& b) {
    face_rows both;
    both.reserve(a.size() + b.size());
    std::ranges::set_union(a, b, std::back_inserter(both));
    return both;
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Two planes, and one that can replace them.
struct merge_candidate {
    plane_id first = no_id;
    plane_id second = no_id;
    billow::plane plane{};
    double loss = 0;  ///< of projected area, scene units squared: how much worse it shows the faces
};

namespace detail {

/// One call of merge_planes.
class plane_merger {
public:
    plane_merger(plane_cover& cover, parallel threads) : cover_(cover), threads_(threads) {}

    std::size_t run() {
        const std::size_t before = cover_.plane_count();
        eliminate();
        while (merge_once()) eliminate();
        return before - cover_.plane_count();
    }

    /// Pairs whose joint width may be at most `reach` epsilons, by what bounds it from below.
    [[nodiscard]] std::vector<std::pair<plane_id, plane_id>> near_pairs(double reach) const {
        const std::vector<plane_faces> of = faces_of_all();
        std::vector<std::vector<std::tuple<double, plane_id, plane_id>>> near(of.size());
        for_each_near_pair(of, reach, [&](plane_id a, plane_id b, const face_rows&, double bound) {
            near[a].emplace_back(bound, a, b);
        });
        std::vector<std::tuple<double, plane_id, plane_id>> all;
        for (const auto& some : near) all.insert(all.end(), some.begin(), some.end());
        std::ranges::sort(all);
        std::vector<std::pair<plane_id, plane_id>> pairs;
        pairs.reserve(all.size());
        for (const auto& [bound, a, b] : all) pairs.emplace_back(a, b);
        return pairs;
    }

private:
    /// Removes planes all of whose faces are valid for others, those of least area first. One stays,
    /// for faces that are valid for none.
    void eliminate() {
        for (bool again = true; again && cover_.plane_count() > 1;) {
            again = false;
            double least = std::numeric_limits<double>::infinity();
            plane_id worst = no_id;
            for (plane_id id = 0; id < cover_.plane_count(); ++id) {
                if (!cover_.essential(id).empty()) continue;
                const double area =
                    projected_area_of(cover_.faces(), cover_.valid(id), cover_.planes()[id].normal);
                if (area < least) least = area, worst = id;
            }
            if (worst != no_id) cover_.remove(worst), again = true;
        }
    }

    /// Merges what can be merged now, by least loss, each plane once.
    bool merge_once() {
        std::vector<merge_candidate> found = candidates();
        std::ranges::sort(found, {}, [](const merge_candidate& c) {
            return std::tuple(c.loss, c.first, c.second);
        });
        std::vector<char> is_touched(cover_.plane_count(), 0);
        std::vector<plane_id> gone;
        for (const merge_candidate& c : found) {
            if (is_touched[c.first] || is_touched[c.second]) continue;
            const plane merged = canonical(c.plane);
            face_rows rows = cover_.rows_for(merged);
            // Earlier merges may have left these two more faces to care for.
            if (!std::ranges::includes(rows, needed_of(c.first, c.second))) continue;
            cover_.move(c.first, merged, std::move(rows));
            cover_.move(c.second, merged, {});
            is_touched[c.first] = is_touched[c.second] = 1;
            gone.push_back(c.second);
        }
        std::ranges::sort(gone, std::greater{});
        for (const plane_id id : gone) cover_.remove(id);
        return !gone.empty();
    }

    /// The faces that no plane but these two can take.
    [[nodiscard]] face_rows needed_of(plane_id a, plane_id b) const {
        const face_rows both = united(cover_.valid(a), cover_.valid(b));
        face_rows needed;
        std::size_t in_a = 0, in_b = 0;
        const auto holds = [](const face_rows& rows, std::size_t& at, std::uint32_t row) {
            while (at < rows.size() && rows[at] < row) ++at;
            return at < rows.size() && rows[at] == row ? 1u : 0u;
        };
        for (const std::uint32_t row : both) {
            const std::uint32_t here =
                holds(cover_.valid(a), in_a, row) + holds(cover_.valid(b), in_b, row);
            if (cover_.counts()[row] == here) needed.push_back(row);
        }
        return needed;
    }

    struct plane_faces {
        face_rows essential{};
        face_rows core{};
        dvec3 middle{0};
        std::array<dvec3, 3> triangle{};
    };

    [[nodiscard]] std::vector<plane_faces> faces_of_all() const {
        std::vector<plane_faces> of(cover_.plane_count());
        threads_.for_chunks(of.size(), 1, [&](std::size_t id, std::size_t) {
            of[id].essential = cover_.essential(static_cast<plane_id>(id));
            of[id].core = extreme_rows(cover_.faces(), of[id].essential);
            for (const std::uint32_t row : of[id].core) {
                of[id].middle += cover_.faces().centroid(row) / double(of[id].core.size());
            }
            if (!of[id].core.empty()) of[id].triangle = wide_triangle(cover_.faces(), of[id].core);
        });
        return of;
    }

    /// Calls `use(a, b, core, bound)` for a < b that are not surely wider than `reach` epsilons; in
    /// parallel, but for one a after the other.
    template <class Use>
    void for_each_near_pair(const std::vector<plane_faces>& of, double reach,
                            const Use& use) const {
        threads_.for_chunks(of.size(), 1, [&](std::size_t a, std::size_t) {
            for (std::size_t b = a + 1; b < of.size(); ++b) {
                if (of[a].core.empty() || of[b].core.empty()) continue;
                double bound = std::max(least_width(cover_.faces(), of[b].core, of[a].triangle),
                                        least_width(cover_.faces(), of[a].core, of[b].triangle));
                if (bound > reach * cover_.epsilon()) continue;
                const face_rows core = united(of[a].core, of[b].core);
                const auto triangle = wide_triangle(cover_.faces(), core);
                bound = std::max(bound, least_width(cover_.faces(), core, triangle));
                if (bound > reach * cover_.epsilon()) continue;
                use(static_cast<plane_id>(a), static_cast<plane_id>(b), core, bound);
            }
        });
    }

    /// All pairs that one plane can replace.
    [[nodiscard]] std::vector<merge_candidate> candidates() const {
        const face_table& faces = cover_.faces();
        const std::vector<plane_faces> of = faces_of_all();
        const std::vector<plane_pair> shared = cover_.essential_pairs();
        std::vector<std::vector<merge_candidate>> found(of.size());
        for_each_near_pair(of, 2, [&](plane_id a, plane_id b, face_rows core, double) {
            face_rows rows = united(of[a].essential, of[b].essential);
            const auto key = [](const plane_pair& p) { return std::pair(p.first, p.second); };
            const auto both = std::ranges::lower_bound(shared, std::pair(a, b), {}, key);
            if (both != shared.end() && both->first == a && both->second == b) {
                rows = united(rows, both->rows);
                core = united(core, extreme_rows(faces, both->rows));
            }
            const dvec3& n = cover_.planes()[a].normal;
            const dvec3& m = cover_.planes()[b].normal;
            const std::optional<plane> joint = joint_plane(
                faces, rows, std::move(core), joint_normals(n, m, of[b].middle - of[a].middle),
                cover_.exact_epsilon());
            if (!joint) return;
            const dvec3& merged = joint->normal;
            const auto loss = [&](const face_rows& some, const dvec3& normal) {
                return projected_area_of(faces, some, normal) -
                       projected_area_of(faces, some, merged);
            };
            found[a].push_back({a, b, *joint, loss(of[a].essential, n) + loss(of[b].essential, m)});
        });
        std::vector<merge_candidate> all;
        for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
        return all;
    }

    plane_cover& cover_;
    parallel threads_;
};

}  // namespace detail

/// Merges pairs of planes until none is left whose faces fit on one: those that no third plane can
/// take must have a joint width of at most 2 epsilon. Of the pairs that do, those that lose least
/// projected area come first. Planes that nobody needs go before.
///
/// Gives   how many planes are fewer. Every face that had a valid plane still has one.
/// Cost    O(planes² · 100) for the pairs that a bound rules out, joint_plane for the others, a few
///         rounds; parallel.
inline std::size_t merge_planes(plane_cover& cover, parallel threads = {}) {
    return detail::plane_merger(cover, threads).run();
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/improve/serve_most.hpp
// The plane that keeps its faces and takes the most of others: exact offsets, a local search for the
// normal.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// A plane, and what it serves.
struct served_faces {
    billow::plane plane{};
    double area = -1;  ///< of the wanted faces within epsilon; < 0: some kept face is not
    double miss = 0;   ///< how far the nearest wanted face that is not served is from being so

    friend bool operator<(const served_faces& a, const served_faces& b) noexcept {
        return std::tuple(a.area, -a.miss) < std::tuple(b.area, -b.miss);
    }
};

/// Looks for a plane within epsilon of all `kept` faces that is so of `wanted` faces of most area.
///
/// For one normal the offset is exact: every face allows an interval, and the place that most of
/// them share is at the end of one. The normal is improved by a pattern search.
class most_served {
public:
    most_served(const face_table& faces, std::span<const std::uint32_t> kept,
                std::span<const std::uint32_t> wanted, double epsilon)
        : faces_(faces), kept_(kept), wanted_(wanted), epsilon_(epsilon) {}

    /// The best plane near the best of `normals`. Needs a normal. Cost about 100 times at().
    [[nodiscard]] served_faces near(std::span<const dvec3> normals) {
        static constexpr double degree = std::numbers::pi / 180;
        served_faces best = at(normals[0]);
        for (const dvec3& normal : normals.subspan(1)) best = std::max(best, at(normal));
        const double last_step = std::min(0.5 * degree, 0.2 * epsilon_ / faces_.bounds.radius);
        for (double step = 8 * degree; step >= last_step;) {
            const frame axes = frame_around(best.plane.normal);
            served_faces better = best;
            for (int k = 0; k < 8; ++k) {
                const double angle = k * std::numbers::pi / 4;
                const dvec3 aside = axes.u * std::cos(angle) + axes.v * std::sin(angle);
                better = std::max(
                    better, at(glm::normalize(axes.normal + aside * std::tan(step)), better.area));
            }
            if (best < better) {
                best = better;
            } else {
                step /= 2;
            }
        }
        return best;
    }

    /// The best plane with a normal; less than the best where it surely serves less than `beaten`.
    /// Cost O(kept + wanted · log wanted).
    [[nodiscard]] served_faces at(const dvec3& normal, double beaten = 0) {
        interval kept{-std::numeric_limits<double>::infinity(),
                      std::numeric_limits<double>::infinity()};
        for (const std::uint32_t row : kept_) {
            const interval of = offsets_of(row, normal);
            kept = {std::max(kept.low, of.low), std::min(kept.high, of.high)};
        }
        served_faces found{.plane = {normal, (kept.low + kept.high) / 2}, .area = 0};
        if (kept.low > kept.high) {
            found.area = kept.high - kept.low;
            return found;
        }
        ends_.clear();
        found.miss = std::numeric_limits<double>::infinity();
        double all = 0;
        interval shared = kept;
        for (const std::uint32_t row : wanted_) {
            const interval of = offsets_of(row, normal);
            const double low = std::max(of.low, kept.low);
            const double high = std::min(of.high, kept.high);
            if (low <= high) {
                const auto area = static_cast<double>(faces_.area[row]);
                ends_.push_back({low, area}), ends_.push_back({high, -area});
                all += area;
                shared = {std::max(shared.low, low), std::min(shared.high, high)};
            } else {
                found.miss = std::min(found.miss, low - high);
            }
        }
        if (ends_.empty()) {
            if (kept_.empty()) found.plane.rho = 0;
            return found;
        }
        if (shared.low <= shared.high) {
            found.area = all;
            found.plane.rho = (shared.low + shared.high) / 2;
            return found;
        }
        if (all < beaten) return found;
        // Intervals begin before others end at the same place: they share it.
        std::ranges::sort(ends_, [](const end& a, const end& b) {
            return std::tuple(a.rho, -a.area) < std::tuple(b.rho, -b.area);
        });
        double area = 0;
        for (std::size_t i = 0; i + 1 < ends_.size(); ++i) {
            area += ends_[i].area;
            if (area > found.area * (1 + 1e-12)) {
                found.area = area;
                found.plane.rho = (ends_[i].rho + ends_[i + 1].rho) / 2;
            }
        }
        return found;
    }

private:
    struct interval {
        double low, high;
    };
    struct end {
        double rho, area;
    };

    [[nodiscard]] interval offsets_of(std::uint32_t row, const dvec3& normal) const noexcept {
        const double a = glm::dot(normal, faces_.corner[0].get(row));
        const double b = glm::dot(normal, faces_.corner[1].get(row));
        const double c = glm::dot(normal, faces_.corner[2].get(row));
        return {std::max({a, b, c}) - epsilon_, std::min({a, b, c}) + epsilon_};
    }

    const face_table& faces_;
    std::span<const std::uint32_t> kept_;
    std::span<const std::uint32_t> wanted_;
    double epsilon_;
    std::vector<end> ends_{};
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// What exchanging did.
struct exchange_statistics {
    std::size_t tried = 0;
    std::size_t made = 0;
};

namespace detail {

/// Planes that an exchange removes, and how others change.
struct exchange_plan {
    struct change {
        plane_id id;
        billow::plane plane;
        face_rows rows;
    };
    bool works = false;
    std::vector<change> changes{};
};

/// One call of exchange_planes.
class plane_exchanger {
public:
    plane_exchanger(plane_cover& cover, parallel threads) : cover_(cover), threads_(threads) {}

    [[nodiscard]] exchange_statistics run(std::size_t effort, const progress_function& progress) {
        exchange_statistics told;
        if (effort == 0) return told;
        std::vector<trial> trials = all_trials();
        for (std::size_t next = 0; next < trials.size() && told.tried < effort;) {
            if (cover_.plane_count() < 2) break;
            const std::size_t some = std::min({batch, trials.size() - next, effort - told.tried});
            std::vector<exchange_plan> plans(some);
            std::vector<std::vector<std::uint32_t>> scratches(
                std::min<std::size_t>(threads_.count(), some));
            for_jobs(threads_, some, scratches, [&](std::size_t i, auto& counts) {
                plans[i] = plan(trials[next + i], counts);
            });
            const auto good = std::ranges::find_if(plans, &exchange_plan::works);
            const auto failed = static_cast<std::size_t>(good - plans.begin());
            told.tried += failed;
            next += failed;
            if (good != plans.end()) {
                ++told.tried, ++told.made;
                make(trials[next], *good);
                merge_planes(cover_, threads_);
                trials = all_trials();
                next = 0;
            }
            report(progress, "exchange",
                   static_cast<double>(told.tried) / static_cast<double>(effort));
        }
        return told;
    }

private:
    /// The plane that goes; with a second one, that may become any other.
    struct trial {
        plane_id removed = no_id;
        plane_id freed = no_id;
    };

    static constexpr std::size_t batch = 8;      // fixed, so that threads do not matter
    static constexpr std::size_t receivers = 8;  // planes that may move in one trial
    static constexpr double reach = 4;           // epsilons that a pair may be wide, to be tried
    static constexpr double far = 3;  // epsilons to a plane that will hardly be moved so much
    static constexpr std::size_t most_wanted = 128;  // faces that steer the search for a plane

    /// Single planes, those of least area first, and by turns with them near pairs, narrowest first.
    [[nodiscard]] std::vector<trial> all_trials() {
        std::vector<std::pair<double, plane_id>> singles;
        for (plane_id id = 0; id < cover_.plane_count(); ++id) {
            double area = 0;
            for (const std::uint32_t row : cover_.essential(id)) {
                area += static_cast<double>(cover_.faces().area[row]);
            }
            singles.emplace_back(area, id);
        }
        std::ranges::sort(singles);
        const auto pairs = plane_merger(cover_, threads_).near_pairs(reach);
        std::vector<trial> trials;
        for (std::size_t i = 0; i < std::max(singles.size(), pairs.size()); ++i) {
            if (i < singles.size()) trials.push_back({singles[i].second, no_id});
            if (i < pairs.size()) trials.push_back({pairs[i].first, pairs[i].second});
        }
        return trials;
    }

    void make(const trial& t, exchange_plan& plan) {
        for (auto& change : plan.changes) {
            cover_.move(change.id, change.plane, std::move(change.rows));
        }
        cover_.remove(t.removed);
    }

    [[nodiscard]] exchange_plan plan(const trial& t, std::vector<std::uint32_t>& counts) const {
        exchange_plan result;
        counts = cover_.counts();
        plane_cover::subtract(counts, cover_.valid(t.removed));
        face_rows touched = cover_.valid(t.removed);
        if (t.freed != no_id) {
            plane_cover::subtract(counts, cover_.valid(t.freed));
            touched = united(touched, cover_.valid(t.freed));
        }
        face_rows orphans;
        for (const std::uint32_t row : touched) {
            if (counts[row] == 0) orphans.push_back(row);
        }
        if (t.freed != no_id) serve(t, t.freed, {}, counts, orphans, result);
        for (const plane_id id : nearest_receivers(t, orphans)) {
            if (orphans.empty()) break;
            serve(t, id, cover_.essential(id, counts), counts, orphans, result);
        }
        result.works = orphans.empty();
        return result;
    }

    /// Moves plane `id`, which must keep some faces, to where it takes the most of the orphans.
    void serve(const trial& t, plane_id id, const face_rows& kept,
               std::vector<std::uint32_t>& counts, face_rows& orphans,
               exchange_plan& result) const {
        const face_table& faces = cover_.faces();
        const double epsilon = cover_.exact_epsilon();
        face_rows core = extreme_rows(faces, kept);
        const face_rows wanted = thinned(orphans);
        const dvec3 from = cover_.planes()[id].normal;
        dvec3 apart{0};
        for (const std::uint32_t row : core) apart -= faces.centroid(row) / double(core.size());
        for (const std::uint32_t row : wanted) apart += faces.centroid(row) / double(wanted.size());
        const std::vector<dvec3> normals =
            joint_normals(from, cover_.planes()[t.removed].normal, apart);
        served_faces found;
        for (int round = 0; round < 6; ++round) {
            found = most_served(faces, core, wanted, epsilon).near(normals);
            if (!(found.area > 0)) return;
            const face_extent_along all = extent_along(faces, kept, found.plane.normal);
            const double rho = found.plane.rho;
            const bool keeps_low = kept.empty() || rho - all.low <= epsilon;
            const bool keeps_high = kept.empty() || all.high - rho <= epsilon;
            if (keeps_low && keeps_high) break;
            if (!keeps_low) core.push_back(all.low_row);
            if (!keeps_high) core.push_back(all.high_row);
        }
        face_rows rows = cover_.rows_for(found.plane, parallel{1});
        if (!std::ranges::includes(rows, kept)) return;
        face_rows left;
        std::ranges::set_difference(orphans, rows, std::back_inserter(left));
        if (left.size() == orphans.size()) return;
        if (id != t.freed) plane_cover::subtract(counts, cover_.valid(id));
        plane_cover::add(counts, rows);
        orphans = std::move(left);
        result.changes.push_back({id, canonical(found.plane), std::move(rows)});
    }

    /// The planes that the orphans are nearest to; none when one of them is far from all.
    [[nodiscard]] std::vector<plane_id> nearest_receivers(const trial& t,
                                                          const face_rows& orphans) const {
        const face_rows some = thinned(orphans);
        std::vector<double> nearest(some.size(), far);
        std::vector<std::pair<double, plane_id>> order;
        for (plane_id id = 0; id < cover_.plane_count(); ++id) {
            if (id == t.removed || id == t.freed) continue;
            double sum = 0;
            for (std::size_t i = 0; i < some.size(); ++i) {
                const double farthest =
                    distances_to(cover_.planes()[id], cover_.faces(), some[i]).largest;
                const double d = std::min(farthest / cover_.epsilon(), far);
                nearest[i] = std::min(nearest[i], d);
                sum += d;
            }
            if (sum < far * double(some.size())) order.emplace_back(sum, id);
        }
        std::vector<plane_id> ids;
        if (std::ranges::find(nearest, far) != nearest.end()) return ids;
        std::ranges::sort(order);
        for (const auto& [sum, id] : order) {
            if (ids.size() < receivers) ids.push_back(id);
        }
        return ids;
    }

    /// Few of many rows, evenly.
    [[nodiscard]] static face_rows thinned(const face_rows& rows) {
        if (rows.size() <= most_wanted) return rows;
        face_rows some;
        for (std::size_t i = 0; i < most_wanted; ++i) {
            some.push_back(rows[i * rows.size() / most_wanted]);
        }
        return some;
    }

    plane_cover& cover_;
    parallel threads_;
};

}  // namespace detail

/// Tries to do with one plane fewer, again and again: removes a plane and moves others, one after
/// the other, to where they take the most of its faces and keep their own; or removes two that are
/// near and puts one anywhere, then moves others for what is left.
///
/// Gives   what was done. Every face that had a valid plane still has one.
/// Cost    `effort` trials at most, by number, not by time: the same result on any machine. A trial
///         is about a thousand passes over a few faces and a few over all; parallel.
inline exchange_statistics exchange_planes(plane_cover& cover, std::size_t effort,
                                           parallel threads = {},
                                           const progress_function& progress = {}) {
    return detail::plane_exchanger(cover, threads).run(effort, progress);
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/improve/reassign.hpp
// Each face to the plane it is most tangent to, each plane to its faces: Lloyd's iteration, within
// epsilon.
//
// S. P. Lloyd: Least squares quantization in PCM. IEEE Transactions on Information Theory 28, 1982;
// for planes: D. Cohen-Steiner, P. Alliez, M. Desbrun: Variational shape approximation. SIGGRAPH 2004.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// For each row the plane that it is most tangent to, of those that may take it: by |cosine|, then
/// by the farthest corner's distance, then by id; no_id where none may. Cost O(sum of valid rows).
[[nodiscard]] inline std::vector<plane_id> most_tangent_planes(const plane_cover& cover) {
    const face_table& faces = cover.faces();
    std::vector<plane_id> best(faces.size, no_id);
    std::vector<double> cosine(faces.size, -1);
    for (plane_id id = 0; id < cover.plane_count(); ++id) {
        const plane& p = cover.planes()[id];
        for (const std::uint32_t row : cover.valid(id)) {
            const double c = std::abs(glm::dot(p.normal, faces.normal.get(row)));
            const bool is_better =
                c > cosine[row] ||
                (c == cosine[row] &&
                 distances_to(p, faces, row).largest <
                     distances_to(cover.planes()[best[row]], faces, row).largest);
            if (is_better) cosine[row] = c, best[row] = id;
        }
    }
    return best;
}

/// What the rows look like on their planes: the sum of area · |cosine|, and of area · distance to
/// the farthest corner. The first counts; where it is equal, the second.
struct tangency {
    double projected_area = 0;
    double distance_area = 0;
};

[[nodiscard]] inline tangency tangency_of(const face_table& faces,
                                          std::span<const std::uint32_t> rows,
                                          const plane& p) noexcept {
    tangency sum{.projected_area = projected_area_of(faces, rows, p.normal)};
    for (const std::uint32_t row : rows) {
        sum.distance_area +=
            static_cast<double>(faces.area[row]) * distances_to(p, faces, row).largest;
    }
    return sum;
}

namespace detail {

/// A plane for `rows` that shows them better than `p` and is within epsilon of all: what `fit`
/// proposes, or as near to it as epsilon and tangency allow; else `p`.
template <plane_fitter Fitter>
[[nodiscard]] plane refitted(const face_table& faces, const face_rows& rows, const plane& p,
                             const Fitter& fit, double epsilon) {
    static constexpr double least_gain = 1e-4;
    const face_table own = select_rows(faces, rows, parallel{1});
    plane goal = fit(own, p);
    if (glm::dot(goal.normal, p.normal) < 0) goal = {-goal.normal, -goal.rho};
    dvec3 through{0};  // where the proposed plane passes the middle of the faces
    double area = 0;
    for (std::size_t row = 0; row < own.size; ++row) {
        through += own.centroid(row) * double(own.area[row]);
        area += double(own.area[row]);
    }
    if (!(area > 0)) return p;
    through /= area;
    through -= goal.normal * signed_distance(goal, through);

    const tangency before = tangency_of(faces, rows, p);
    for (const double step : {1.0, 0.5, 0.25, 0.125, 0.0}) {
        const dvec3 normal = glm::normalize(p.normal + (goal.normal - p.normal) * step);
        const face_extent_along extent = extent_along(faces, rows, normal);
        const double low = extent.high - epsilon;
        const double high = extent.low + epsilon;
        if (low > high) continue;
        const plane moved = canonical({normal, std::clamp(glm::dot(normal, through), low, high)});
        const tangency after = tangency_of(faces, rows, moved);
        const double gain = after.projected_area - before.projected_area;
        const double nearer = before.distance_area - after.distance_area;
        if (gain > least_gain * before.projected_area ||
            (gain >= 0 && nearer > least_gain * area * epsilon)) {
            return moved;
        }
    }
    return p;
}

}  // namespace detail

/// What reassigning did.
struct reassign_statistics {
    std::size_t rounds = 0;
    std::size_t refits = 0;  ///< planes that moved, counted once a round
};

/// Assigns each face to the valid plane that it is most tangent to, then moves each plane to its
/// faces, until nothing changes or for `rounds` rounds.
///
/// Every step raises the projected area, the sum over the faces of area · |cosine|, or leaves it
/// and lowers their distance; a refit must gain a ten-thousandth of its plane's at least, so it ends.
///
/// Gives   planes, on which most_tangent_planes then sees the faces. None is beyond epsilon.
/// Cost    O(faces) for the fits and O(faces · planes that move), each round; parallel.
/// Source  Lloyd 1982, Cohen-Steiner et al. 2004. Differs: only valid planes are asked, and a fit
///         that would leave epsilon is followed as far as it does not.
template <plane_fitter Fitter = average_fit>
reassign_statistics reassign_faces(plane_cover& cover, std::size_t rounds, const Fitter& fit = {},
                                   parallel threads = {}) {
    const face_table& faces = cover.faces();
    reassign_statistics told;
    while (told.rounds < rounds) {
        ++told.rounds;
        const std::vector<plane_id> home = most_tangent_planes(cover);
        const auto count = cover.plane_count();
        std::vector<face_rows> own(count);
        for (std::uint32_t row = 0; row < home.size(); ++row) {
            if (home[row] != no_id) own[home[row]].push_back(row);
        }
        std::vector<plane> moved = cover.planes();
        threads.for_chunks(count, 1, [&](std::size_t id, std::size_t) {
            if (!own[id].empty()) {
                moved[id] = detail::refitted(faces, own[id], moved[id], fit, cover.exact_epsilon());
            }
        });
        std::size_t refits = 0;
        for (plane_id id = 0; id < count; ++id) {
            if (moved[id] == cover.planes()[id]) continue;
            face_rows rows = cover.rows_for(moved[id]);
            if (!std::ranges::includes(rows, own[id])) continue;  // by the rounding of floats
            cover.move(id, moved[id], std::move(rows));
            ++refits;
        }
        told.refits += refits;
        if (refits == 0) break;
    }
    return told;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/improve/refine_whole.hpp
// Refinement of the whole: what a greedy search cannot see, for it never looks back.
//
// Planes are merged, eliminated and exchanged, then faces go to the planes they are most tangent to.
// It works on the result of any search.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

struct whole_refinement_options {
    bool merge = true;  ///< two planes whose faces fit on one become one, those nobody needs go
    std::size_t effort = 24;  ///< exchanges to try, a part: more may find fewer planes; 0: none
    bool reassign = true;     ///< faces go to the plane they are most tangent to, planes follow
    std::size_t rounds = 8;   ///< of reassigning, at most; 0: faces move, planes do not
    float least_cosine = 0;   ///< between the normals of a face and its plane, as the search's
                              ///< contribution has it (least_cosine_of): 0 allows all
};

/// What refinement of the whole did.
struct whole_refinement_report {
    std::size_t planes_before = 0;
    std::size_t planes_after = 0;
    std::size_t merged_planes = 0;    ///< fewer by merging and elimination
    exchange_statistics exchanges{};  ///< each made is one plane fewer at least
    reassign_statistics reassigned{};
    std::size_t moved_faces = 0;  ///< that changed to another plane, but for those whose plane went
    double projected_area_share_before = 0;  ///< as in cloud_errors, of the faces of the table
    double projected_area_share_after = 0;
};

namespace detail {

/// Area-weighted mean |cosine| between the mapped faces and their planes.
[[nodiscard]] inline double projected_area_share(const face_table& faces,
                                                 const billboard_cloud& cloud) noexcept {
    double shown = 0;
    double all = 0;
    for (std::uint32_t row = 0; row < faces.size; ++row) {
        const plane_id id = cloud.plane_of_face[faces.source[row]];
        if (id == no_id) continue;
        const auto area = static_cast<double>(faces.area[row]);
        shown += area * std::abs(glm::dot(cloud.planes[id].normal, faces.normal.get(row)));
        all += area;
    }
    return all > 0 ? shown / all : 0;
}

/// One call of refine_whole.
template <class Fitter>
class whole_refiner {
public:
    whole_refiner(const face_table& faces, billboard_cloud& cloud,
                  const whole_refinement_options& options, const Fitter& fit, parallel threads,
                  const progress_function& progress)
        : faces_(faces),
          cloud_(cloud),
          options_(options),
          fit_(fit),
          threads_(threads),
          progress_(progress) {}

    [[nodiscard]] whole_refinement_report run() {
        told_.planes_before = cloud_.plane_count();
        told_.projected_area_share_before = projected_area_share(faces_, cloud_);
        result_.plane_of_face.assign(cloud_.plane_of_face.size(), no_id);
        new_id_.assign(cloud_.plane_count(), no_id);
        const auto parts = static_cast<part_id>(std::max<std::size_t>(1, cloud_.parts.size()));
        for (part_id part = 0; part < parts; ++part) refine_part(part);
        keep_drawn();
        cloud_.planes = std::move(result_.planes);
        cloud_.plane_of_face = std::move(result_.plane_of_face);
        cloud_.part_of_plane = std::move(result_.part_of_plane);
        cloud_.also_drawn = std::move(result_.also_drawn);
        cloud_.billboards.clear();
        told_.planes_after = cloud_.plane_count();
        told_.projected_area_share_after = projected_area_share(faces_, cloud_);
        report(progress_, "refine", 1);
        return told_;
    }

private:
    void refine_part(part_id part) {
        std::vector<plane_id> ids;
        std::vector<plane> planes;
        std::vector<plane_id> place(cloud_.plane_count(), no_id);
        for (plane_id id = 0; id < cloud_.plane_count(); ++id) {
            if (cloud_.part_of(id) != part) continue;
            place[id] = static_cast<plane_id>(ids.size());
            ids.push_back(id);
            planes.push_back(cloud_.planes[id]);
        }
        if (ids.empty()) return;
        face_rows rows;
        std::vector<plane_id> before;
        for (std::uint32_t row = 0; row < faces_.size; ++row) {
            const plane_id id = cloud_.plane_of_face[faces_.source[row]];
            if (id == no_id || place[id] == no_id) continue;
            rows.push_back(row);
            before.push_back(place[id]);
        }
        const face_table faces = select_rows(faces_, rows, threads_);
        plane_cover cover(faces, std::move(planes), cloud_.epsilon_of(ids.front()),
                          options_.least_cosine, threads_);
        refine(cover);

        const std::vector<plane_id> home = homes(cover, before);
        std::vector<char> is_used(cover.plane_count(), 0);
        for (const plane_id id : home) is_used[id] = 1;
        std::vector<plane_id> next(cover.plane_count(), no_id);
        for (plane_id id = 0; id < cover.plane_count(); ++id) {
            if (!is_used[id]) continue;
            next[id] = static_cast<plane_id>(result_.planes.size());
            new_id_[ids[cover.origin(id)]] = next[id];
            result_.planes.push_back(cover.planes()[id]);
            if (!cloud_.part_of_plane.empty()) result_.part_of_plane.push_back(part);
        }
        for (std::uint32_t row = 0; row < faces.size; ++row) {
            result_.plane_of_face[faces.source[row]] = next[home[row]];
            if (cover.origin(home[row]) != before[row]) ++told_.moved_faces;
        }
    }

    /// What is drawn on planes that are left, where it is still near.
    void keep_drawn() {
        if (cloud_.also_drawn.empty()) return;
        std::vector<std::uint32_t> row_of(cloud_.plane_of_face.size(), no_id);
        for (std::uint32_t row = 0; row < faces_.size; ++row) row_of[faces_.source[row]] = row;
        for (const drawn_too& drawn : cloud_.also_drawn) {
            const plane_id on = new_id_[drawn.plane];
            const std::uint32_t row = row_of[drawn.face];
            if (on == no_id || row == no_id || result_.plane_of_face[drawn.face] == on) continue;
            const double distance = distances_to(result_.planes[on], faces_, row).largest;
            if (distance <= cloud_.epsilon_of(drawn.plane)) {
                result_.also_drawn.push_back({on, drawn.face});
            }
        }
        std::ranges::sort(result_.also_drawn);
    }

    /// Merging comes again after reassigning, which has moved planes.
    void refine(plane_cover& cover) {
        std::size_t tried = 0;
        for (bool is_first = true;; is_first = false) {
            const std::size_t before = cover.plane_count();
            if (options_.merge) told_.merged_planes += merge_planes(cover, threads_);
            const exchange_statistics done =
                exchange_planes(cover, options_.effort - tried, threads_, progress_);
            tried += done.tried;
            told_.exchanges.tried += done.tried;
            told_.exchanges.made += done.made;
            if (!is_first && cover.plane_count() == before) return;
            if (!options_.reassign) return;
            const reassign_statistics moved =
                reassign_faces(cover, options_.rounds, fit_, threads_);
            told_.reassigned.rounds += moved.rounds;
            told_.reassigned.refits += moved.refits;
        }
    }

    /// The plane of each row: as before where that may be and reassigning is not asked for. Rows that
    /// are valid for none, since the search left them so, go to the plane of least error.
    [[nodiscard]] std::vector<plane_id> homes(const plane_cover& cover,
                                              const std::vector<plane_id>& before) const {
        std::vector<plane_id> home = most_tangent_planes(cover);
        if (!options_.reassign) {
            for (plane_id id = 0; id < cover.plane_count(); ++id) {
                for (const std::uint32_t row : cover.valid(id)) {
                    if (before[row] == cover.origin(id)) home[row] = id;
                }
            }
        }
        face_rows astray;
        for (std::uint32_t row = 0; row < home.size(); ++row) {
            if (home[row] == no_id) astray.push_back(row);
        }
        const std::vector<plane_id> nearest = planes_of_least_error(
            select_rows(cover.faces(), astray, threads_), cover.planes(), threads_);
        for (std::size_t i = 0; i < astray.size(); ++i) home[astray[i]] = nearest[i];
        return home;
    }

    const face_table& faces_;
    billboard_cloud& cloud_;
    const whole_refinement_options& options_;
    const Fitter& fit_;
    parallel threads_;
    const progress_function& progress_;
    billboard_cloud result_{};        ///< its planes, its faces on them
    std::vector<plane_id> new_id_{};  ///< of each plane; no_id: gone
    whole_refinement_report told_{};
};

}  // namespace detail

/// Refines a cloud as a whole, part for part: merges planes whose faces fit on one and eliminates
/// those that nobody needs (merge_planes), exchanges planes for fewer (exchange_planes), and gives
/// each face to the plane that it is most tangent to (reassign_faces).
///
/// Needs   a row of `faces` for every mapped face of `cloud`; no faces moved yet by welding, no
///         cardboard planes.
/// Gives   in `cloud` never more planes, in their order, without billboards: fit_billboards comes
///         afterwards. A face that was within epsilon of its plane is so of its new one; one that
///         was not, since the search was cut short, goes to a valid plane or that of least error.
///         No face joins a plane of another part; faces without a plane stay so. Of also_drawn what
///         still lies within epsilon of a plane that is left.
/// Fails   never.
/// Cost    see the parts; little against a search. Same result for any number of threads.
template <plane_fitter Fitter = average_fit>
whole_refinement_report refine_whole(const face_table& faces, billboard_cloud& cloud,
                                     const whole_refinement_options& options = {},
                                     const Fitter& fit = {}, parallel threads = {},
                                     const progress_function& progress = {}) {
    return detail::whole_refiner<Fitter>(faces, cloud, options, fit, threads, progress).run();
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/improve/weld.hpp
// Vertex welding after the search: vertices that planes tear apart move to where those planes meet.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
// section 3.3.

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// What welding did.
struct weld_statistics {
    std::size_t torn_vertices = 0;    ///< on several planes of a part
    std::size_t moved_vertices = 0;   ///< of those
    std::size_t welded_vertices = 0;  ///< of those, on all of their planes now
    double largest_displacement = 0;  ///< scene units
};

/// The faces that welding moves, by face, around cloud.bounds.centre.
struct welded_faces {
    std::vector<moved_face> moved{};
    weld_statistics statistics{};
};

namespace detail {

/// One call of weld_faces.
class welder {
public:
    welder(const mesh& source, const billboard_cloud& cloud, std::span<const weld_options> of_parts)
        : source_(source), cloud_(cloud), of_parts_(of_parts) {}

    [[nodiscard]] welded_faces run() {
        double tolerance = 0;
        bool is_asked = false;
        for (const weld_options& options : of_parts_) {
            tolerance = std::max(tolerance, options.tolerance);
            is_asked |= options.kind != weld_kind::none;
        }
        if (!is_asked) return {};
        sort_corners(position_ids(source_, tolerance));
        for (std::size_t begin = 0, end = 0; begin < corners_.size(); begin = end) {
            while (end < corners_.size() && is_one(corners_[begin], corners_[end])) ++end;
            weld(std::span(corners_).subspan(begin, end - begin));
        }
        collect();
        return std::move(result_);
    }

private:
    /// A corner of a face: of one vertex, drawn on one plane.
    struct corner {
        std::uint32_t vertex = 0;
        part_id part = 0;
        plane_id plane = 0;
        std::size_t place = 0;  ///< 3 · face + k
    };
    struct welded_corner {
        std::size_t place = 0;
        dvec3 position{0};
    };

    [[nodiscard]] static bool is_one(const corner& a, const corner& b) noexcept {
        return a.vertex == b.vertex && a.part == b.part;
    }
    [[nodiscard]] const weld_options& options_of(part_id part) const noexcept {
        return of_parts_[of_parts_.size() == 1 ? 0 : part];
    }
    /// Around cloud.bounds.centre.
    [[nodiscard]] dvec3 position_of(std::size_t place) const noexcept {
        const uvec3 t = source_.triangles[place / 3];
        return dvec3(source_.positions[t[static_cast<glm::length_t>(place % 3)]]) -
               cloud_.bounds.centre;
    }

    /// By vertex, part and plane; planes are in the order of discovery.
    void sort_corners(const vertex_identity& vertices) {
        corners_.reserve(3 * source_.face_count());
        for (std::size_t place = 0; place < 3 * source_.face_count(); ++place) {
            const plane_id on = cloud_.plane_of_face[place / 3];
            if (on == no_id || options_of(cloud_.part_of(on)).kind == weld_kind::none) continue;
            const uvec3 t = source_.triangles[place / 3];
            corners_.push_back({vertices.id[t[static_cast<glm::length_t>(place % 3)]],
                                cloud_.part_of(on), on, place});
        }
        std::sort(corners_.begin(), corners_.end(), [](const corner& a, const corner& b) {
            return std::tie(a.vertex, a.part, a.plane, a.place) <
                   std::tie(b.vertex, b.part, b.plane, b.place);
        });
    }

    /// Moves the vertex that all of `corners` are.
    void weld(std::span<const corner> corners) {
        if (corners.front().plane == corners.back().plane) return;
        ++result_.statistics.torn_vertices;
        const weld_options& options = options_of(corners.front().part);
        const dvec3 vertex = position_of(corners.front().place);
        double spread = 0;  // of what the tolerance makes one
        weld_planes planes;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            spread = std::max(spread, glm::distance(vertex, position_of(corners[i].place)));
            if (i == 0 || corners[i].plane != corners[i - 1].plane) {
                planes.add(cloud_.planes, corners[i].plane, options);
            }
        }
        const double epsilon = cloud_.epsilon_of(corners.front().plane);
        const dvec3 at = planes.nearest(cloud_.planes, vertex, epsilon - spread);
        if (at == vertex && spread == 0) return;
        ++result_.statistics.moved_vertices;
        double off = 0;
        for (const corner& c : corners) {
            off = std::max(off, std::abs(signed_distance(cloud_.planes[c.plane], at)));
            welded_.push_back({c.place, at});
            result_.statistics.largest_displacement = std::max(
                result_.statistics.largest_displacement, glm::distance(at, position_of(c.place)));
        }
        if (off <= 1e-9 * cloud_.bounds.radius) ++result_.statistics.welded_vertices;
    }

    /// Makes faces of the welded corners.
    void collect() {
        std::sort(welded_.begin(), welded_.end(),
                  [](const auto& a, const auto& b) { return a.place < b.place; });
        for (const welded_corner& w : welded_) {
            const auto face = static_cast<face_id>(w.place / 3);
            if (result_.moved.empty() || result_.moved.back().face != face) {
                const std::size_t first = w.place - w.place % 3;
                result_.moved.push_back(
                    {face, {position_of(first), position_of(first + 1), position_of(first + 2)}});
            }
            result_.moved.back().corners[w.place % 3] = w.position;
        }
    }

    const mesh& source_;
    const billboard_cloud& cloud_;
    std::span<const weld_options> of_parts_;
    std::vector<corner> corners_{};
    std::vector<welded_corner> welded_{};
    welded_faces result_{};
};

}  // namespace detail

/// Moves every vertex whose faces lie on several planes onto those planes, as far as that is possible
/// within epsilon. The faces keep their planes.
///
/// Shape   `of_parts`: one row a part of the cloud, or one for all. Parts are welded apart.
/// Unit    positions around cloud.bounds.centre.
/// Needs   one row of plane_of_face a face of `source`.
/// Gives   faces with a moved corner. No corner moves by more than the epsilon of its part; corners
///         of faces without a plane stay.
/// Cost    O(faces log faces).
/// Source  Luksch 2009, section 3.3; weld_kind::first is its variant of Fuhrmann et al. 2005.
///         Differs: planes that do not meet within epsilon are tried in pairs, and see
///         weld_planes::nearest for pairs that do not.
[[nodiscard]] inline welded_faces weld_faces(const mesh& source, const billboard_cloud& cloud,
                                             std::span<const weld_options> of_parts) {
    BILLOW_ASSERT(cloud.plane_of_face.size() == source.face_count());
    BILLOW_ASSERT(of_parts.size() == 1 || of_parts.size() == cloud.parts.size());
    return detail::welder(source, cloud, of_parts).run();
}

/// A mesh to draw instead of the source, and what was done to it.
struct welded_mesh {
    mesh drawn{};
    weld_statistics statistics{};
    cloud_cracks before{};
    cloud_cracks after{};
};

/// Welds, and measures what that helps. The result is drawn instead of `source`:
/// `fit_billboards(drawn, cloud); bake_cloud(drawn, *make_face_table(drawn), cloud)`.
///
/// Shape, Needs, Cost  as weld_faces, drawn_mesh and measure_cracks.
[[nodiscard]] inline welded_mesh weld_vertices(const mesh& source, const billboard_cloud& cloud,
                                               const weld_options& options) {
    const welded_faces welded = weld_faces(source, cloud, std::span(&options, 1));
    welded_mesh result{drawn_mesh(source, cloud, welded.moved), welded.statistics, {}, {}};
    result.before = measure_cracks(source, cloud, source, options.tolerance);
    result.after = measure_cracks(source, cloud, result.drawn, options.tolerance);
    return result;
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/bake/bake_cloud.hpp
// Textures for a billboard cloud: from a mesh and its billboards to atlases.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 4.5.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

// ---- billow/bake/baked_cloud.hpp
// What the baker makes of a billboard cloud: atlases, and where each billboard's tiles lie.

#include <cstdint>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// The texels of one side of a billboard within an atlas: columns [x, x + width), rows
/// [y, y + height), without padding. Texel rows run from the top, so the billboard's v axis points up
/// in the tile and its u axis to the right, on a back to the left; a rotated tile has been turned by
/// 90° clockwise (an axis to the right then runs down, one up to the right).
struct tile {
    atlas_id atlas = no_id;
    int x = 0;
    int y = 0;
    int width = 0;   ///< in the atlas, so along v when rotated
    int height = 0;  ///< in the atlas, so along u when rotated
    bool is_rotated = false;
};

/// How normals are told, so that they are lit rightly from both sides of a billboard.
enum class normal_style : std::uint8_t {
    folded,  ///< as seen from the front; one double-sided polygon, whose back mirrors them
    sheets,  ///< front and back each on a single-sided polygon, with tiles of their own
    object,  ///< in scene space on two single-sided polygons: the texture is no longer bound to them
    dome,    ///< as object, but blended with the directions out of the cloud's middle
};

/// Textures of the same size and layout. Channels that say nothing are left empty.
struct atlas {
    image base_color{};  ///< RGBA, sRGB, straight alpha, opaque from 128 on
    /// RGB. Tangent space of the tile: x to the right and y up in the atlas, z out of the drawn side
    /// and above 0; or scene space, see normal_style.
    image normal{};
    image occlusion_roughness_metallic{};  ///< RGB, linear
    image emissive{};                      ///< RGB, sRGB
    image horizon{};  ///< RGBA, linear: the visible sky in scene space, see decode_horizon

    [[nodiscard]] int width() const noexcept { return base_color.width; }
    [[nodiscard]] int height() const noexcept { return base_color.height; }
};

/// Shape  B billboards, T tiles: tiles 0 to B - 1 are the fronts in the order of the billboards;
///        `back_of` and `outlines` have one row a billboard, or none.
struct baked_cloud {
    std::vector<tile> tiles{};
    std::vector<std::uint32_t> back_of{};  ///< row of `tiles`; no_id: the front serves both sides
    /// Convex polygons around what is opaque, counter-clockwise from the front, in the billboard's
    /// coordinates (s, t); none: the whole rectangles.
    std::vector<std::vector<dvec2>> outlines{};
    std::vector<atlas> atlases{};
    normal_style normals = normal_style::folded;
    double texel_size = 0;    ///< scene units a texel side, the same for every tile
    double wanted_size = 0;   ///< what was asked for; less, where tiles would not fit
    double fill = 0;          ///< share of the atlases' area that is tiles, padding not counted
    double opaque_area = 0;   ///< texels of fronts that an alpha test draws
    double polygon_area = 0;  ///< texels of fronts within the outlines

    [[nodiscard]] std::uint32_t back_tile(std::size_t billboard) const noexcept {
        return back_of.empty() ? no_id : back_of[billboard];
    }
    /// Fragments that an alpha test discards, for each that it draws, over all directions: planes
    /// that nothing hides are seen as often, and as obliquely, as others.
    [[nodiscard]] double overdraw() const noexcept {
        return opaque_area > 0 ? (polygon_area - opaque_area) / opaque_area : 0;
    }
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/border.hpp
// Colours for what is empty, so that filtering and mip maps draw no halo.
//
// Luksch 2009, section 4.5; here the whole empty area is filled, each texel from the one that is
// exactly nearest of those where a face is seen, opaque or not.

#include <algorithm>
#include <array>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

namespace detail {

struct pixel_rectangle {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
};

/// The tile with its padding, as far as the atlas goes.
[[nodiscard]] inline pixel_rectangle padded(const tile& t, const atlas& in, int padding) noexcept {
    const int x = std::max(0, t.x - padding);
    const int y = std::max(0, t.y - padding);
    return {x, y, std::min(in.width(), t.x + t.width + padding) - x,
            std::min(in.height(), t.y + t.height + padding) - y};
}

/// All channels of a pixel but the alpha of its colour.
inline void copy_texel(atlas& in, const ivec2& from, const ivec2& to) noexcept {
    for (image* channel :
         {&in.base_color, &in.normal, &in.occlusion_roughness_metallic, &in.emissive}) {
        if (channel->empty()) continue;
        const std::uint8_t* source = channel->pixel(from.x, from.y);
        std::copy(source, source + 3, channel->pixel(to.x, to.y));
    }
    if (in.horizon.empty()) return;
    std::copy_n(in.horizon.pixel(from.x, from.y), 4, in.horizon.pixel(to.x, to.y));
}

struct border_scratch {
    std::vector<std::int32_t> nearest{};
    nearest_scratch rows{};
};

inline void fill_tile_border(atlas& in, const std::vector<char>& is_covered,
                             const pixel_rectangle& area, border_scratch& scratch) {
    const std::span nearest =
        std::span(scratch.nearest)
            .first(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height));
    const auto is_seed = [&](int x, int y) {
        return is_covered[static_cast<std::size_t>(area.y + y) *
                              static_cast<std::size_t>(in.width()) +
                          static_cast<std::size_t>(area.x + x)] != 0;
    };
    nearest_pixels(area.width, area.height, is_seed, nearest, scratch.rows);
    for (int y = 0; y < area.height; ++y) {
        for (int x = 0; x < area.width; ++x) {
            const std::int32_t from = nearest[static_cast<std::size_t>(y * area.width + x)];
            if (from == no_pixel || from == y * area.width + x) continue;
            copy_texel(in, {area.x + from % area.width, area.y + from / area.width},
                       {area.x + x, area.y + y});
        }
    }
}

inline void fill_between_tiles(atlas& in, const std::vector<char>& is_filled, parallel threads) {
    const int width = in.width();
    std::vector<std::int32_t> nearest(is_filled.size());
    nearest_scratch scratch;
    const auto is_seed = [&](int x, int y) {
        return is_filled[static_cast<std::size_t>(y * width + x)] != 0;
    };
    nearest_pixels(width, in.height(), is_seed, nearest, scratch, threads);
    const auto rows = static_cast<std::size_t>(in.height());
    threads.for_chunks(rows, 64, [&](std::size_t begin, std::size_t end) {
        for (auto i = begin * static_cast<std::size_t>(width);
             i < end * static_cast<std::size_t>(width); ++i) {
            const std::int32_t from = nearest[i];
            const auto to = static_cast<std::int32_t>(i);
            if (from == no_pixel || from == to) continue;
            copy_texel(in, {from % width, from / width}, {to % width, to / width});
        }
    });
}

}  // namespace detail

/// Gives every empty texel all channels of the nearest covered texel: within a tile and its padding
/// the nearest of that tile, elsewhere the nearest texel of any of these. Alpha stays.
///
/// Shape  `is_covered`: for each atlas a mark a texel, see placed_tiles.
/// Needs  tiles whose paddings do not overlap.
/// Cost   O(texels), parallel over tiles, then over rows.
inline void fill_borders(baked_cloud& baked, const std::vector<std::vector<char>>& is_covered,
                         int padding, parallel threads = {}) {
    BILLOW_ASSERT(is_covered.size() == baked.atlases.size());
    std::size_t largest = 0;
    std::size_t widest_rows = 0;
    for (const tile& t : baked.tiles) {
        const auto area = detail::padded(t, baked.atlases[t.atlas], padding);
        const auto w = static_cast<std::size_t>(area.width);
        const auto h = static_cast<std::size_t>(area.height);
        largest = std::max(largest, w * h);
        widest_rows = std::max(widest_rows, nearest_scratch_size(area.width, area.height));
    }
    std::vector<detail::border_scratch> scratches(threads.count());
    for (auto& scratch : scratches) {
        scratch.nearest.resize(largest);
        scratch.rows.envelopes.resize(widest_rows);
    }
    for_jobs(threads, baked.tiles.size(), scratches, [&](std::size_t job, auto& scratch) {
        const tile& t = baked.tiles[job];
        atlas& in = baked.atlases[t.atlas];
        detail::fill_tile_border(in, is_covered[t.atlas], detail::padded(t, in, padding), scratch);
    });
    for (atlas_id id = 0; id < baked.atlases.size(); ++id) {
        atlas& in = baked.atlases[id];
        const auto width = static_cast<std::size_t>(in.width());
        std::vector<char> is_filled(width * static_cast<std::size_t>(in.height()), 0);
        for (const tile& t : baked.tiles) {
            if (t.atlas != id) continue;
            const auto area = detail::padded(t, in, padding);
            for (int y = area.y; y < area.y + area.height; ++y) {
                std::fill_n(
                    is_filled.begin() + static_cast<std::ptrdiff_t>(y) * in.width() + area.x,
                    area.width, char{1});
            }
        }
        detail::fill_between_tiles(in, is_filled, threads);
    }
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/occlusion.hpp
// How much of the sky each leaf and vertex sees, and where: rays against the mesh itself.
//
// Fuhrmann et al.: Extreme model simplification for forest rendering. Eurographics Workshop on
// Natural Phenomena 2005, section 3.3.9; after Landis: Production-ready global illumination.
// SIGGRAPH course notes 2002.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

// ---- billow/bake/sky_sites.hpp
// Where light is measured: a leaf as a whole, everything else vertex by vertex.
//
// Fuhrmann et al.: Extreme model simplification for forest rendering. Eurographics Workshop on
// Natural Phenomena 2005, section 3.3.9: one value a leaf.

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

using site_id = std::uint32_t;

/// Rows of a face table that are measured together.
struct sky_patch {
    std::uint32_t first = 0;  ///< of sky_sites::rows
    std::uint32_t count = 0;
    bool is_leaf = false;  ///< all corners are one site; else a single face, a site a corner
    int rays = 0;
};

/// Shape  `of_face`: the sites of each face's corners. `rows`: those of the table, patch by patch.
struct sky_sites {
    std::vector<uvec3> of_face{};
    std::vector<std::uint32_t> rows{};
    std::vector<sky_patch> patches{};
    std::size_t count = 0;  ///< site 0 is that of faces without area
};

/// Whether a material is that of leaves, which light passes to both sides.
[[nodiscard]] inline bool is_foliage(const material& look) noexcept {
    return look.alpha != alpha_mode::opaque;
}

namespace detail {

/// The corners at one place whose normals are alike share a site.
class corner_sites {
public:
    corner_sites(std::size_t places, site_id first) : newest_(places, no_id), next_(first) {}

    [[nodiscard]] site_id of(std::uint32_t place, const vec3& normal) {
        constexpr float alike = 0.9f;  // 26°: an edge to be seen stays one
        for (std::uint32_t i = newest_[place]; i != no_id; i = entries_[i].before) {
            if (glm::dot(entries_[i].normal, normal) >= alike) return entries_[i].site;
        }
        const auto id = static_cast<std::uint32_t>(entries_.size());
        entries_.push_back({normal, next_, std::exchange(newest_[place], id)});
        return next_++;
    }
    [[nodiscard]] site_id end() const noexcept { return next_; }

private:
    struct entry {
        vec3 normal;
        site_id site;
        std::uint32_t before;
    };
    std::vector<entry> entries_{};
    std::vector<std::uint32_t> newest_;
    site_id next_;
};

}  // namespace detail

/// Finds the sites of a mesh. A connected component of foliage or of a double-sided material is a
/// leaf where its diameter is at most `leaf_extent`; otherwise the corners of faces are measured,
/// those at one place with normals alike together.
///
/// Unit   leaf_extent in scene units.      Needs  `faces` is the table of `m`; rays ≥ 1.
/// Gives  patches of about `rays` rays a site, so that a mesh costs by its leaves and vertices.
/// Cost   O(faces).
[[nodiscard]] inline sky_sites find_sky_sites(const mesh& m, const face_table& faces,
                                              double leaf_extent, int rays) {
    const mesh_components pieces = find_components(m);
    const vertex_identity places = position_ids(m);
    const std::size_t component_count = pieces.components.size();
    std::vector<char> is_leaf(component_count, 1);
    for (std::size_t i = 0; i < component_count; ++i) {
        is_leaf[i] = pieces.components[i].diameter <= leaf_extent ? 1 : 0;
    }
    for (face_id face = 0; face < m.face_count(); ++face) {
        const material& look = m.material_of(face);
        if (!is_foliage(look) && !look.is_double_sided) is_leaf[pieces.of_face[face]] = 0;
    }

    sky_sites sites;
    sites.of_face.assign(m.face_count(), uvec3(0));
    std::vector<std::uint32_t> rows_of_leaf(component_count, 0);
    for (const face_id face : faces.source) ++rows_of_leaf[pieces.of_face[face]];
    std::vector<site_id> site_of_leaf(component_count, 0);
    std::vector<std::uint32_t> next_row(component_count, 0);
    site_id next_site = 1;
    std::uint32_t filled = 0;
    for (std::size_t i = 0; i < component_count; ++i) {
        if (is_leaf[i] == 0 || rows_of_leaf[i] == 0) continue;
        site_of_leaf[i] = next_site++;
        sites.patches.push_back({filled, rows_of_leaf[i], true, rays});
        next_row[i] = std::exchange(filled, filled + rows_of_leaf[i]);
    }
    sites.rows.resize(faces.size);
    detail::corner_sites corners(places.count, next_site);
    for (std::uint32_t row = 0; row < faces.size; ++row) {
        const face_id face = faces.source[row];
        const std::uint32_t component = pieces.of_face[face];
        if (is_leaf[component] != 0) {
            sites.of_face[face] = uvec3(site_of_leaf[component]);
            sites.rows[next_row[component]++] = row;
            continue;
        }
        const vec3 flat(faces.normal.get(row));
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t vertex = m.triangles[face][k];
            const vec3& normal = m.normals.empty() ? flat : m.normals[vertex];
            sites.of_face[face][k] = corners.of(places.id[vertex], normal);
        }
        sites.patches.push_back({filled, 1, false, rays});
        sites.rows[filled++] = row;
    }
    sites.count = corners.end();

    // A corner gets a third of the rays of each face around it.
    std::vector<int> faces_at(sites.count, 0);
    for (const uvec3& face : sites.of_face) {
        for (int k = 0; k < 3; ++k) ++faces_at[face[k]];
    }
    for (sky_patch& patch : sites.patches) {
        if (patch.is_leaf) continue;
        const uvec3 at = sites.of_face[faces.source[sites.rows[patch.first]]];
        const int fewest = std::min({faces_at[at.x], faces_at[at.y], faces_at[at.z]});
        patch.rays = std::clamp((3 * rays + fewest - 1) / fewest, 1, rays);
    }
    return sites;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/sky_table.hpp
// What the leaves and vertices of a mesh see of the sky.

#include <vector>


namespace billow::inline BILLOW_ABI {

/// The sky from one place: foliage looks to both sides, all else to one.
struct sky_view {
    float open = 1;  ///< visible share of the sky, weighted by the cosine to the normal
    /// x, y, z: the sum of the directions that see the sky, w: their number, both over the number of
    /// all directions on the sphere. Sums, so that views can be averaged.
    vec4 visible{0, 0, 0, 1};
};

/// Shape  `of_face`: the rows of `views` that the corners of each face see.
struct sky_table {
    std::vector<uvec3> of_face{};
    std::vector<sky_view> views{};

    /// The sky from the point with barycentric `weights` of a face.
    [[nodiscard]] sky_view at(face_id face, const vec3& weights) const noexcept {
        const sky_view& a = views[of_face[face].x];
        const sky_view& b = views[of_face[face].y];
        const sky_view& c = views[of_face[face].z];
        return {a.open * weights.x + b.open * weights.y + c.open * weights.z,
                a.visible * weights.x + b.visible * weights.y + c.visible * weights.z};
    }
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/surface.hpp
// What a mesh looks like at a point of one of its faces: colour, normal, and whether it is there.

#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

// ---- billow/bake/texture_sampler.hpp
// Reading textures as glTF means it: wrap modes, bilinear filter, linear light.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// `uv` after KHR_texture_transform.
[[nodiscard]] inline vec2 transformed(const texture& t, const vec2& uv) noexcept {
    return vec2(t.transform[0]) * uv.x + vec2(t.transform[1]) * uv.y + vec2(t.transform[2]);
}

namespace detail {

/// A coordinate within [0, 1]: where the wrap mode folds it to. NaN becomes 0.
[[nodiscard]] inline float wrapped(float u, texture_wrap wrap) noexcept {
    if (u >= 0 && u <= 1) return u;
    if (wrap == texture_wrap::repeat) {
        u -= std::floor(u);
    } else if (wrap == texture_wrap::mirrored_repeat) {
        u -= 2 * std::floor(u * 0.5f);
        u = u > 1 ? 2 - u : u;
    }
    return u > 0 ? (u < 1 ? u : 1.0f) : 0.0f;
}

/// The two texels that a coordinate lies between.
struct texel_pair {
    int a = 0;
    int b = 0;
    float share_of_b = 0;
};

[[nodiscard]] inline texel_pair texels_at(float u, int size, texture_wrap wrap,
                                          bool is_nearest) noexcept {
    const float x = wrapped(u, wrap) * static_cast<float>(size);
    if (is_nearest) {
        const int texel = std::min(static_cast<int>(x), size - 1);
        return {texel, texel, 0};
    }
    const int above = static_cast<int>(x + 0.5f);  // the texel after the one before x - 0.5
    const float share = x + 0.5f - static_cast<float>(above);
    const bool repeats = wrap == texture_wrap::repeat;
    return {above > 0 ? above - 1 : (repeats ? size - 1 : 0),
            above < size ? above : (repeats ? 0 : size - 1), share};
}

/// The four texels around a point and their shares.
struct texel_quad {
    std::array<const std::uint8_t*, 4> texel;
    std::array<float, 4> share;
};

[[nodiscard]] inline texel_quad texels_around(const image& level, const texture& t, const vec2& uv,
                                              bool is_nearest) noexcept {
    const texel_pair x = texels_at(uv.x, level.width, t.wrap_u, is_nearest);
    const texel_pair y = texels_at(uv.y, level.height, t.wrap_v, is_nearest);
    const float fx = x.share_of_b;
    const float fy = y.share_of_b;
    return {{level.pixel(x.a, y.a), level.pixel(x.b, y.a), level.pixel(x.a, y.b),
             level.pixel(x.b, y.b)},
            {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}

}  // namespace detail

/// The level of a chain whose texels are closest in size to a footprint of `texels` texels of
/// level 0, counted by area.
[[nodiscard]] inline std::size_t level_of_footprint(double texels, std::size_t levels) noexcept {
    if (!(texels > 2)) return 0;  // a level has a fourth of the texels; half way is √4
    int exponent = 0;
    std::frexp(texels * 0.5, &exponent);  // texels in [2 · 4^(k-1), 2 · 4^k) is level k
    return std::min(static_cast<std::size_t>((exponent + 1) / 2), levels - 1);
}

/// Linear RGBA of one texel chain at `uv`, which the texture's transform has been applied to.
///
/// Needs  the chain that make_mip_chain gives for `kind`.
[[nodiscard]] inline vec4 sample_texture(const std::vector<image>& chain, texel_kind kind,
                                         const texture& t, const vec2& uv,
                                         std::size_t level) noexcept {
    const auto& light = linear_of_srgb_byte();
    const detail::texel_quad quad =
        detail::texels_around(chain[level], t, uv, t.is_nearest && level == 0);
    vec4 sum{0};
    vec3 weighted{0};
    for (std::size_t i = 0; i < 4; ++i) {
        const std::uint8_t* p = quad.texel[i];
        const float alpha = static_cast<float>(p[3]) * (1.0f / 255.0f);
        const vec3 colour = kind == texel_kind::linear
                                ? vec3(p[0], p[1], p[2]) * (1.0f / 255.0f)
                                : vec3(light[p[0]], light[p[1]], light[p[2]]);
        sum += vec4(colour, alpha) * quad.share[i];
        weighted += colour * (alpha * quad.share[i]);
    }
    if (kind == texel_kind::srgb_alpha && sum.w > 0) return vec4(weighted / sum.w, sum.w);
    return sum;
}

/// Alpha alone, in [0, 1], of an image with one channel.
[[nodiscard]] inline float sample_alpha(const image& level, const texture& t, const vec2& uv,
                                        bool is_nearest) noexcept {
    if (is_nearest) {
        const int x = detail::texels_at(uv.x, level.width, t.wrap_u, true).a;
        const int y = detail::texels_at(uv.y, level.height, t.wrap_v, true).a;
        return static_cast<float>(*level.pixel(x, y)) * (1.0f / 255.0f);
    }
    const detail::texel_quad quad = detail::texels_around(level, t, uv, false);
    float sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += static_cast<float>(*quad.texel[i]) * quad.share[i];
    return sum * (1.0f / 255.0f);
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// The look of a point. Colours are linear light, the normal has length 1.
struct surface_sample {
    vec3 base_color{1};
    vec3 normal{0, 0, 1};
    float occlusion = 1;
    float roughness = 1;
    float metallic = 0;
    vec3 emissive{0};
    vec4 visible_sky{0, 0, 0, 1};  ///< sky_view::visible
};

/// How it is decided whether a sample of a face is there.
struct face_cover {
    enum class rule {
        always,
        cutoff,  ///< where alpha ≥ cutoff
        share,   ///< where alpha ≥ a threshold that differs from sample to sample
    };
    rule decides = rule::always;
    float factor = 1;  ///< multiplies the alpha of texture and vertices
    float cutoff = 0;
    const image* alpha = nullptr;  ///< none: 1 everywhere
    const texture* map = nullptr;
    bool is_nearest = false;
    std::array<vec2, 3> uvs{};
    std::array<float, 3> vertex_alpha{1, 1, 1};
    bool has_vertex_alpha = false;
};

namespace detail {

/// A texture with its mip chain and coordinates; without a chain it says nothing.
struct bound_texture {
    const texture* map = nullptr;
    const std::vector<image>* chain = nullptr;
    texel_kind kind = texel_kind::linear;

    [[nodiscard]] explicit operator bool() const noexcept { return chain != nullptr; }
};

struct bound_material {
    const material* look = nullptr;
    bound_texture base_color{};
    bound_texture metallic_roughness{};
    bound_texture normal{};
    bound_texture occlusion{};
    bound_texture emissive{};
    std::vector<image>
        cover{};  ///< alpha; of alpha_mode::mask from level 1 on the share that passes
};

struct image_chain {
    image_id image = no_id;
    texel_kind kind = texel_kind::linear;
    std::vector<billow::image> levels{};
};

/// Alpha of every level alone, which the visibility pass reads without the colours.
[[nodiscard]] inline std::vector<image> alpha_of(const std::vector<image>& chain) {
    std::vector<image> result;
    for (const image& level : chain) {
        image alpha{level.width, level.height, 1, {}};
        alpha.bytes.reserve(level.bytes.size() / 4);
        for (std::size_t i = 3; i < level.bytes.size(); i += 4) {
            alpha.bytes.push_back(level.bytes[i]);
        }
        result.push_back(std::move(alpha));
    }
    return result;
}

/// Level 0 as it is; further levels tell which share of its texels passes the alpha test. Mean alpha
/// would lose what is thin: a leaf's tip has a mean below the cutoff, yet it covers its share.
[[nodiscard]] inline std::vector<image> cover_of_mask(const std::vector<image>& chain,
                                                      const material& look) {
    image passes = chain[0];
    for (std::size_t i = 3; i < passes.bytes.size(); i += 4) {
        const float alpha = static_cast<float>(passes.bytes[i]) / 255.0f * look.base_color.w;
        passes.bytes[i] = alpha >= look.alpha_cutoff ? 255 : 0;
    }
    std::vector<image> cover = alpha_of(make_mip_chain(passes, texel_kind::linear));
    cover[0] = alpha_of({chain[0]})[0];
    return cover;
}

}  // namespace detail

/// What is constant over a face when it is drawn at some resolution.
struct face_look {
    face_id face = no_id;
    const detail::bound_material* material = nullptr;
    vec3 flat_normal{0, 0, 1};
    std::array<std::size_t, 5> levels{};  ///< mip levels, in the order of bound_material's textures
    vec3 tangent{0};                      ///< along u of the normal texture, where there is one
    vec3 bitangent{0};                    ///< up in the normal texture
};

/// A mesh made ready for shading: the mip chains of the textures that its faces use.
///
/// Needs  the mesh outlives it; indices within bounds.
class surface {
public:
    explicit surface(const mesh& source) : mesh_(source) {
        std::vector<char> is_used(source.materials.size() + 1, 0);
        for (face_id face = 0; face < source.face_count(); ++face) is_used[material_row(face)] = 1;
        chains_.reserve(source.materials.size() * 5);
        materials_.resize(is_used.size());
        for (std::size_t row = 0; row < is_used.size(); ++row) {
            static const mesh no_materials;
            const bool is_plain = row + 1 == is_used.size();
            materials_[row].look = is_plain ? &no_materials.material_of(0) : &source.materials[row];
            if (is_used[row] != 0) bind(materials_[row]);
        }
        for (const vec4& color : source.colors) has_vertex_alpha_ |= color.w < 1;
    }
    surface(const surface&) = delete;
    surface& operator=(const surface&) = delete;

    /// From now on the sky that `sky` says is visible multiplies the occlusion. Needs: it outlives
    /// this; the table of source().
    void light_by(const sky_table& sky) noexcept { sky_ = &sky; }

    [[nodiscard]] const mesh& source() const noexcept { return mesh_; }
    [[nodiscard]] const material& material_of(face_id face) const noexcept {
        return *materials_[material_row(face)].look;
    }

    /// How to decide whether samples of a face are there, when it covers `sample_area` of them.
    [[nodiscard]] face_cover cover_of(face_id face, double sample_area) const noexcept {
        const detail::bound_material& bound = materials_[material_row(face)];
        const material& look = *bound.look;
        face_cover cover;
        if (look.alpha == alpha_mode::opaque) return cover;
        cover.decides =
            look.alpha == alpha_mode::mask ? face_cover::rule::cutoff : face_cover::rule::share;
        cover.factor = look.base_color.w;
        cover.cutoff = look.alpha_cutoff;
        const uvec3 corners = mesh_.triangles[face];
        if (has_vertex_alpha_) {
            cover.has_vertex_alpha = true;
            for (int k = 0; k < 3; ++k) {
                cover.vertex_alpha[static_cast<std::size_t>(k)] = mesh_.colors[corners[k]].w;
            }
        }
        if (bound.cover.empty()) return cover;
        cover.map = bound.base_color.map;
        cover.uvs = uvs_of(bound.base_color, corners);
        // Vertex alpha moves the cutoff, which the shares were computed for: then level 0 must do.
        const bool needs_exact = look.alpha == alpha_mode::mask && has_vertex_alpha_;
        const std::size_t level =
            needs_exact ? 0 : level_for(bound.base_color, cover.uvs, sample_area);
        cover.alpha = &bound.cover[level];
        // The texels of further levels are about as large as a sample: one of them says enough.
        cover.is_nearest = level > 0 || cover.map->is_nearest;
        if (level > 0 && look.alpha == alpha_mode::mask) {
            cover.decides = face_cover::rule::share;
            cover.factor = 1;
        }
        return cover;
    }

    /// What at() needs to know of a face that covers `texel_area` texels.
    [[nodiscard]] face_look look_at(face_id face, double texel_area) const noexcept {
        const detail::bound_material& bound = materials_[material_row(face)];
        face_look look;
        look.face = face;
        look.material = &bound;
        const auto [a, b, c] = mesh_.corners(face);
        const dvec3 cross = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
        const double length = glm::length(cross);
        if (length > 0) look.flat_normal = vec3(cross / length);
        const uvec3 corners = mesh_.triangles[face];
        const std::array textures{&bound.base_color, &bound.metallic_roughness, &bound.normal,
                                  &bound.occlusion, &bound.emissive};
        for (std::size_t i = 0; i < textures.size(); ++i) {
            if (*textures[i]) {
                look.levels[i] = level_for(*textures[i], uvs_of(*textures[i], corners), texel_area);
            }
        }
        if (bound.normal) set_tangents(look, uvs_of(bound.normal, corners));
        return look;
    }

    /// The look of the point with barycentric `weights` (sum 1) of a face.
    [[nodiscard]] surface_sample at(const face_look& look, const vec3& weights) const noexcept {
        const detail::bound_material& bound = *look.material;
        const material& m = *bound.look;
        const uvec3 corners = mesh_.triangles[look.face];
        const auto sampled = [&](const detail::bound_texture& t, std::size_t level) {
            return sample_texture(*t.chain, t.kind, *t.map, uv_at(t, corners, weights), level);
        };
        surface_sample sample;
        sample.base_color = vec3(m.base_color);
        if (bound.base_color) {
            sample.base_color *= vec3(sampled(bound.base_color, look.levels[0]));
        }
        if (!mesh_.colors.empty()) {
            sample.base_color *= vec3(mixed(mesh_.colors, corners, weights));
        }
        sample.roughness = m.roughness;
        sample.metallic = m.metallic;
        if (bound.metallic_roughness) {
            const vec4 value = sampled(bound.metallic_roughness, look.levels[1]);
            sample.roughness *= value.y;
            sample.metallic *= value.z;
        }
        if (bound.occlusion) {
            const vec4 value = sampled(bound.occlusion, look.levels[3]);
            sample.occlusion = 1 + m.occlusion_strength * (value.x - 1);
        }
        if (sky_ != nullptr) {
            const sky_view view = sky_->at(look.face, weights);
            sample.occlusion *= view.open;
            sample.visible_sky = view.visible;
        }
        sample.emissive = m.emissive;
        if (bound.emissive) sample.emissive *= vec3(sampled(bound.emissive, look.levels[4]));
        sample.normal = look.flat_normal;
        if (!mesh_.normals.empty()) {
            sample.normal = normalized_or(mixed(mesh_.normals, corners, weights), look.flat_normal);
        }
        if (bound.normal) {
            const vec4 value = sampled(bound.normal, look.levels[2]);
            sample.normal = bumped(look, sample.normal, corners, weights, vec3(value));
        }
        return sample;
    }

private:
    template <class T>
    [[nodiscard]] static T mixed(const std::vector<T>& column, const uvec3& corners,
                                 const vec3& weights) noexcept {
        return column[corners.x] * weights.x + column[corners.y] * weights.y +
               column[corners.z] * weights.z;
    }
    [[nodiscard]] static vec3 normalized_or(const vec3& v, const vec3& otherwise) noexcept {
        const float length = glm::length(v);
        return length > 1e-12f ? v / length : otherwise;
    }

    [[nodiscard]] std::size_t material_row(face_id face) const noexcept {
        const std::size_t count = mesh_.materials.size();
        const std::size_t row = mesh_.face_materials.empty() ? 0 : mesh_.face_materials[face];
        return row < count ? row : count;
    }

    [[nodiscard]] std::array<vec2, 3> uvs_of(const detail::bound_texture& t,
                                             const uvec3& corners) const noexcept {
        const std::vector<vec2>& uvs = mesh_.uv_sets[t.map->uv_set];
        return {transformed(*t.map, uvs[corners.x]), transformed(*t.map, uvs[corners.y]),
                transformed(*t.map, uvs[corners.z])};
    }
    [[nodiscard]] vec2 uv_at(const detail::bound_texture& t, const uvec3& corners,
                             const vec3& weights) const noexcept {
        return transformed(*t.map, mixed(mesh_.uv_sets[t.map->uv_set], corners, weights));
    }

    [[nodiscard]] static std::size_t level_for(const detail::bound_texture& t,
                                               const std::array<vec2, 3>& uvs,
                                               double area) noexcept {
        const dvec2 p = dvec2(uvs[1]) - dvec2(uvs[0]);
        const dvec2 q = dvec2(uvs[2]) - dvec2(uvs[0]);
        const image& base = t.chain->front();
        const double texels = 0.5 * std::abs(p.x * q.y - p.y * q.x) * base.width * base.height;
        return level_of_footprint(texels / std::max(area, 1e-12), t.chain->size());
    }

    void set_tangents(face_look& look, const std::array<vec2, 3>& uvs) const noexcept {
        const auto [a, b, c] = mesh_.corners(look.face);
        const vec3 e1 = b - a;
        const vec3 e2 = c - a;
        const vec2 d1 = uvs[1] - uvs[0];
        const vec2 d2 = uvs[2] - uvs[0];
        const float det = d1.x * d2.y - d1.y * d2.x;
        const float side = det < 0 ? -1.0f : 1.0f;
        look.tangent = normalized_or((e1 * d2.y - e2 * d1.y) * side, vec3(0));
        look.bitangent = -normalized_or((e2 * d1.x - e1 * d2.x) * side, vec3(0));  // v runs down
    }

    /// The normal of a normal texture's `value` around the smooth normal `n`.
    [[nodiscard]] vec3 bumped(const face_look& look, const vec3& n, const uvec3& corners,
                              const vec3& weights, const vec3& value) const noexcept {
        const float scale = look.material->look->normal_scale;
        const vec3 local = (value * 2.0f - 1.0f) * vec3(scale, scale, 1);
        vec3 t = look.tangent;
        vec3 b = look.bitangent;
        if (!mesh_.tangents.empty()) {
            t = vec3(mixed(mesh_.tangents, corners, weights));
            b = glm::cross(n, t) * mesh_.tangents[corners.x].w;
        }
        t = normalized_or(t - n * glm::dot(n, t), vec3(0));
        const float side = glm::dot(glm::cross(n, t), b) < 0 ? -1.0f : 1.0f;
        b = glm::cross(n, t) * side;
        return normalized_or(t * local.x + b * local.y + n * local.z, n);
    }

    [[nodiscard]] detail::bound_texture bound(const texture& t, texel_kind kind) {
        const bool is_usable = t.image < mesh_.images.size() && !mesh_.images[t.image].empty() &&
                               t.uv_set < uv_set_count && !mesh_.uv_sets[t.uv_set].empty();
        if (!is_usable) return {};
        for (const auto& chain : chains_) {
            if (chain->image == t.image && chain->kind == kind) return {&t, &chain->levels, kind};
        }
        chains_.push_back(std::make_unique<detail::image_chain>(
            detail::image_chain{t.image, kind, make_mip_chain(mesh_.images[t.image], kind)}));
        return {&t, &chains_.back()->levels, kind};
    }

    void bind(detail::bound_material& to) {
        const material& look = *to.look;
        const bool is_opaque = look.alpha == alpha_mode::opaque;
        to.base_color =
            bound(look.base_color_texture, is_opaque ? texel_kind::srgb : texel_kind::srgb_alpha);
        to.normal = bound(look.normal_texture, texel_kind::linear);
        to.metallic_roughness = bound(look.metallic_roughness_texture, texel_kind::linear);
        to.occlusion = bound(look.occlusion_texture, texel_kind::linear);
        if (look.emissive != vec3(0)) to.emissive = bound(look.emissive_texture, texel_kind::srgb);
        if (is_opaque || !to.base_color) return;
        to.cover = look.alpha == alpha_mode::mask
                       ? detail::cover_of_mask(*to.base_color.chain, look)
                       : detail::alpha_of(*to.base_color.chain);
    }

    const mesh& mesh_;
    const sky_table* sky_ = nullptr;
    std::vector<std::unique_ptr<detail::image_chain>> chains_{};
    std::vector<detail::bound_material> materials_{};
    bool has_vertex_alpha_ = false;
};

/// The normal of a sample as it is seen from the side that `toward` (unit length) points to. A
/// surface seen from behind, or a double-sided one whose normal points away, shows the other side;
/// a smooth normal that leaves the view at a grazing face does not turn around.
[[nodiscard]] inline vec3 normal_toward(const surface_sample& sample, const face_look& look,
                                        const vec3& toward) noexcept {
    if (glm::dot(sample.normal, toward) >= 0) return sample.normal;
    const bool is_seen_from_behind = glm::dot(look.flat_normal, toward) < 0;
    return is_seen_from_behind || look.material->look->is_double_sided ? -sample.normal
                                                                       : sample.normal;
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct occlusion_options {
    int rays = 64;             ///< a leaf or vertex; noise is about 0.4 / √rays
    double reach = 0;          ///< what is farther away hides nothing, in radii; 0: everything does
    double strength = 1;       ///< 0: nothing is darkened, 1: as measured
    double leaf_extent = 0.2;  ///< largest diameter of a leaf, in radii; 0: no leaves
    /// Where the sky is: within 90° of it. 0: all around, since an occlusion map tells what the model
    /// itself hides, and the renderer's light what the ground does.
    vec3 sky_up{0};
    std::uint64_t seed = 1;
};

namespace detail {

/// Sums over rays.
struct sky_sum {
    double weight = 0;   ///< of cosines
    double open = 0;     ///< of cosines of rays that see the sky
    double visible = 0;  ///< rays that see the sky
    double sphere = 0;   ///< rays that the whole sphere would have got
    dvec3 sum{0};        ///< of the directions that see the sky

    void add(const sky_sum& other) noexcept {
        weight += other.weight;
        open += other.open;
        visible += other.visible;
        sphere += other.sphere;
        sum += other.sum;
    }
    [[nodiscard]] sky_view view() const noexcept {
        if (!(weight > 0)) return {};
        return {.open = static_cast<float>(open / weight),
                .visible = vec4(vec3(sum / sphere), static_cast<float>(visible / sphere))};
    }
};

/// One call of see_sky.
class sky_measurer {
public:
    sky_measurer(const surface& look, const face_table& faces, const occlusion_options& options,
                 parallel threads)
        : look_(look),
          faces_(faces),
          options_(options),
          threads_(threads),
          sites_(find_sky_sites(look.source(), faces, options.leaf_extent * faces.bounds.radius,
                                options.rays)),
          tree_(faces.size, [&](std::uint32_t row) {
              return std::array{vec3(faces.corner[0].get(row)), vec3(faces.corner[1].get(row)),
                                vec3(faces.corner[2].get(row))};
          }) {
        near_ = static_cast<float>(1e-5 * faces.bounds.radius);
        if (options.reach > 0) far_ = static_cast<float>(options.reach * faces.bounds.radius);
        for (int i = 0; i < options.rays; ++i) {
            const double angle = 2 * std::numbers::pi * fraction(i * golden);
            turns_.emplace_back(std::cos(angle), std::sin(angle));
        }
    }

    [[nodiscard]] sky_table run() {
        std::vector<std::array<sky_sum, 3>> sums(sites_.patches.size());
        threads_.for_chunks(sums.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) sums[i] = measure(i);
        });
        std::vector<sky_sum> of_site(sites_.count);
        for (std::size_t i = 0; i < sums.size(); ++i) {
            const sky_patch& patch = sites_.patches[i];
            const uvec3 at = sites_.of_face[faces_.source[sites_.rows[patch.first]]];
            for (int k = 0; k < (patch.is_leaf ? 1 : 3); ++k) {
                of_site[at[k]].add(sums[i][static_cast<std::size_t>(k)]);
            }
        }
        sky_table table;
        for (const sky_sum& sum : of_site) {
            sky_view view = sum.view();
            view.open = static_cast<float>(1 - options_.strength * (1 - view.open));
            table.views.push_back(view);
        }
        table.of_face = std::move(sites_.of_face);
        return table;
    }

private:
    // Steps of sequences that fill an interval and a square evenly. The latter is Roberts' R2.
    static constexpr double golden = 0.6180339887498949;
    static constexpr dvec2 plastic{0.7548776662466927, 0.5698402909980532};

    [[nodiscard]] static double fraction(double x) noexcept { return x - std::floor(x); }

    /// The sums of the patch's corners; a leaf has only the first.
    [[nodiscard]] std::array<sky_sum, 3> measure(std::size_t id) const noexcept {
        const sky_patch& patch = sites_.patches[id];
        const face_id face = faces_.source[sites_.rows[patch.first]];
        const material& look = look_.material_of(face);
        if (is_foliage(look)) return cast(patch, 0);
        std::array<sky_sum, 3> front = cast(patch, 1);
        if (!look.is_double_sided) return front;
        // The side that the light reaches: of a body the outside, whichever way its faces turn.
        const std::array<sky_sum, 3> back = cast(patch, -1);
        const auto visible = [](const std::array<sky_sum, 3>& of) {
            return of[0].visible + of[1].visible + of[2].visible;
        };
        return visible(back) > visible(front) ? back : front;
    }

    /// Rays over the half of the sphere on one `side`, ±1, or over all of it, 0.
    [[nodiscard]] std::array<sky_sum, 3> cast(const sky_patch& patch, int side) const noexcept {
        std::array<sky_sum, 3> sums{};
        random_stream random(mix_bits(options_.seed) ^
                             mix_bits(patch.first * 3u + static_cast<unsigned>(side + 1)));
        const double lift = random.unit();
        const double angle = 2 * std::numbers::pi * random.unit();
        const dvec2 turn(std::cos(angle), std::sin(angle));
        const dvec2 shift(random.unit(), random.unit());
        double area = 0;
        for (std::uint32_t i = 0; i < patch.count; ++i) area += faces_.area[row_of(patch, i)];
        for (int i = 0; i < patch.rays; ++i) {
            dvec2 at(fraction(i * plastic.x + shift.x), fraction(i * plastic.y + shift.y));
            const std::uint32_t row = pick_face(patch, at.x, area);
            if (at.x + at.y > 1) at = 1.0 - at;
            const dvec3 weights(1 - at.x - at.y, at.x, at.y);
            const dvec3 point = faces_.corner[0].get(row) * weights.x +
                                faces_.corner[1].get(row) * weights.y +
                                faces_.corner[2].get(row) * weights.z;

            const double height = fraction((i + 0.5) / patch.rays + lift);
            const double z = side == 0 ? 2 * height - 1 : side * height;
            const double r = std::sqrt(std::max(0.0, 1 - z * z));
            const dvec2 t = turns_[static_cast<std::size_t>(i)];
            const frame axes = frame_around(faces_.normal.get(row));
            const dvec3 direction = axes.to_scene(
                {r * (t.x * turn.x - t.y * turn.y), r * (t.x * turn.y + t.y * turn.x), z});
            const bool is_visible = sees_sky(row, point, direction,
                                             mix_bits(patch.first) + static_cast<std::uint64_t>(i));
            for (int k = 0; k < (patch.is_leaf ? 1 : 3); ++k) {
                const double share = patch.is_leaf ? 1 : weights[k];
                sky_sum& sum = sums[static_cast<std::size_t>(k)];
                sum.weight += share * std::abs(z);
                sum.sphere += share * (side == 0 ? 1 : 2);
                if (!is_visible) continue;
                sum.open += share * std::abs(z);
                sum.visible += share;
                sum.sum += direction * share;
            }
        }
        return sums;
    }

    [[nodiscard]] std::uint32_t row_of(const sky_patch& patch, std::uint32_t i) const noexcept {
        return sites_.rows[patch.first + i];
    }

    /// The row that the share `at` of the patch's area falls on; `at` becomes the share within it.
    [[nodiscard]] std::uint32_t pick_face(const sky_patch& patch, double& at,
                                          double area) const noexcept {
        double left = at * area;
        std::uint32_t i = 0;
        while (i + 1 < patch.count && left >= faces_.area[row_of(patch, i)]) {
            left -= faces_.area[row_of(patch, i++)];
        }
        const std::uint32_t row = row_of(patch, i);
        at = std::clamp(left / faces_.area[row], 0.0, 1.0);
        return row;
    }

    [[nodiscard]] bool sees_sky(std::uint32_t row, const dvec3& point, const dvec3& direction,
                                std::uint64_t key) const noexcept {
        const vec3 toward(direction);
        if (glm::dot(toward, options_.sky_up) < 0) return false;
        return !tree_.is_blocked({vec3(point), toward, near_, far_},
                                 [&](std::uint32_t other, float b, float c) {
                                     return other != row && is_there(other, b, c, key);
                                 });
    }

    /// Whether the point of a face is there for the ray `key`: all of one ray see the same holes.
    [[nodiscard]] bool is_there(std::uint32_t row, float b, float c,
                                std::uint64_t key) const noexcept {
        constexpr double samples =
            256;  // a face's alpha as it looks from afar: its image stays near
        const face_cover cover = look_.cover_of(faces_.source[row], samples);
        if (cover.decides == face_cover::rule::always) return true;
        const auto mixed = [&](const auto& at) {
            return at[0] * (1 - b - c) + at[1] * b + at[2] * c;
        };
        float alpha = cover.factor;
        if (cover.has_vertex_alpha) alpha *= mixed(cover.vertex_alpha);
        if (cover.alpha != nullptr) {
            alpha *= sample_alpha(*cover.alpha, *cover.map, mixed(cover.uvs), cover.is_nearest);
        }
        if (cover.decides == face_cover::rule::cutoff) return alpha >= cover.cutoff;
        return static_cast<double>(alpha) > random_unit(key, row);
    }

    const surface& look_;
    const face_table& faces_;
    const occlusion_options& options_;
    parallel threads_;
    sky_sites sites_;
    ray_tree tree_;
    float near_ = 0;
    float far_ = std::numeric_limits<float>::infinity();
    std::vector<dvec2> turns_{};
};

}  // namespace detail

/// Measures which share of the sky the leaves and vertices of a mesh see past its own faces. Rays go
/// out evenly, from points spread over the faces. Alpha is looked at, so light falls through holes.
///
/// - Foliage: the mean over both sides, as light that falls on one shines through to the other.
/// - Other faces: their front; where they are double-sided the side that sees more, so that the
///   inside of a closed body does not count.
///
/// A leaf has one value, everything else one a vertex (see find_sky_sites).
///
/// Needs  `faces` is the table of look.source(); rays ≥ 1.
/// Gives  the same for any number of threads.
/// Cost   O(rays × (leaves + vertices) × log faces), parallel.
/// Source Fuhrmann et al. 2005, section 3.3.9. Differs: `open` is weighted by the cosine, as the
///        occlusion of glTF means it; sky_view::visible.w is their percentage.
[[nodiscard]] inline sky_table see_sky(const surface& look, const face_table& faces,
                                       const occlusion_options& options = {},
                                       parallel threads = {}) {
    BILLOW_ASSERT(options.rays >= 1 && options.leaf_extent >= 0 && options.reach >= 0);
    return detail::sky_measurer(look, faces, options, threads).run();
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/pack.hpp
// Rectangles in, places in as few and as small atlases as can be found, out.
//
// docs/atlas.md has what was tried and measured.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

// ---- billow/bake/pack_search.hpp
// The order and the width of a strip that pack its rectangles best.
//
// A local search over orders, as in Wei et al., "A skyline heuristic for the 2D rectangular packing
// and strip packing problems", 2011; here the width of the strip is searched for as well, and the
// time goes to fewer and fewer candidates. Time is counted in steps, so the answer does not depend on
// the machine.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

// ---- billow/bake/pack_skyline.hpp
// Rectangles into one strip, by a skyline: the tops of what lies there already.
//
// Lowest place: Jylänki, "A thousand ways to pack the bin", 2010, section 2.4 (skyline bottom-left).
// Best fit: Burke, Kendall, Whitwell, "A new placement heuristic for the orthogonal stock-cutting
// problem", 2004; what counts as the best fit follows Wei et al., "A skyline heuristic for the 2D
// rectangular packing and strip packing problems", 2011.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI::detail {

/// Where a rectangle lies in a strip.
struct strip_place {
    int x = -1;  ///< below 0: nowhere
    int y = 0;
    bool is_turned = false;
};

/// The room to fill, in units.
struct strip {
    int width = 0;
    int height = 0;
    bool allows_turns = true;
    bool needs_all = true;  ///< give up at the first rectangle that has no place
};

/// What a filled strip holds.
struct strip_use {
    std::int64_t area = 0;  ///< of the rectangles that have a place
    int width = 0;          ///< of the room that they take
    int height = 0;
    bool holds_all = false;
};

enum class placing_rule {
    lowest,    ///< each rectangle, in order, where its top is lowest
    best_fit,  ///< each lowest gap, in turn, gets the rectangle that leaves least of it
};

/// Fills strips one after the other, without allocating again.
class strip_packer {
public:
    /// Where the rectangles of the last call went.
    [[nodiscard]] std::span<const strip_place> places() const noexcept { return places_; }
    /// Steps taken since the beginning: a measure of time that is the same everywhere.
    [[nodiscard]] std::int64_t steps() const noexcept { return steps_; }

    strip_use fill(std::span<const ivec2> sizes, std::span<const std::uint32_t> order,
                   placing_rule rule, const strip& room) {
        places_.assign(sizes.size(), {});
        tops_.assign(1, {0, 0});
        room_ = room;
        use_ = {};
        use_.holds_all = rule == placing_rule::lowest ? place_lowest(sizes, order)
                                                      : place_best_fit(sizes, order);
        return use_;
    }

private:
    /// A piece of the skyline; it ends where the next one begins.
    struct piece {
        int x = 0;
        int y = 0;
    };

    [[nodiscard]] int end_of(std::size_t i) const noexcept {
        return i + 1 < tops_.size() ? tops_[i + 1].x : room_.width;
    }

    [[nodiscard]] bool place_lowest(std::span<const ivec2> sizes,
                                    std::span<const std::uint32_t> order) {
        bool holds_all = true;
        for (const std::uint32_t id : order) {
            std::size_t best = tops_.size();
            int best_top = room_.height + 1;
            bool is_turned = false;
            const auto consider = [&](const ivec2& size, bool turned) {
                for (std::size_t i = 0; i < tops_.size(); ++i) {
                    ++steps_;
                    const int end = tops_[i].x + size.x;
                    if (end > room_.width) break;
                    int y = tops_[i].y;
                    for (std::size_t k = i + 1; k < tops_.size() && tops_[k].x < end; ++k) {
                        if (y + size.y >= best_top) break;
                        y = std::max(y, tops_[k].y);
                        ++steps_;
                    }
                    if (y + size.y < best_top) {
                        best = i;
                        best_top = y + size.y;
                        is_turned = turned;
                    }
                }
            };
            const ivec2 size = sizes[id];
            consider(size, false);
            if (room_.allows_turns && size.x != size.y) consider({size.y, size.x}, true);
            if (best == tops_.size()) {
                holds_all = false;
                if (room_.needs_all) return false;
                continue;
            }
            const ivec2 placed = is_turned ? ivec2(size.y, size.x) : size;
            put(id, tops_[best].x, best_top - placed.y, placed, is_turned);
        }
        return holds_all;
    }

    [[nodiscard]] bool place_best_fit(std::span<const ivec2> sizes,
                                      std::span<const std::uint32_t> order) {
        left_.assign(order.begin(), order.end());
        std::int64_t spare = std::int64_t{room_.width} * room_.height;  // may stay empty
        for (const ivec2& size : sizes) spare -= std::int64_t{size.x} * size.y;
        while (!left_.empty()) {
            std::size_t gap = 0;
            for (std::size_t i = 1; i < tops_.size(); ++i) {
                if (tops_[i].y < tops_[gap].y) gap = i;
            }
            const int x = tops_[gap].x;
            const int y = tops_[gap].y;
            const int width = end_of(gap) - x;
            const int wall_left = gap > 0 ? tops_[gap - 1].y : room_.height;
            const int wall_right = gap + 1 < tops_.size() ? tops_[gap + 1].y : room_.height;
            const fit best =
                best_fit(sizes, {width, room_.height - y}, {wall_left - y, wall_right - y});
            steps_ += static_cast<std::int64_t>(tops_.size());
            if (best.score == 0) {  // nothing fits: the gap is lost
                const int level = std::min(wall_left, wall_right);
                spare -= std::int64_t{width} * (level - y);
                if (tops_.size() == 1 || (room_.needs_all && spare < 0)) return false;
                raise(x, x + width, level);
                continue;
            }
            const std::uint32_t id = left_[best.at];
            left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(best.at));
            const ivec2 placed = best.is_turned ? ivec2(sizes[id].y, sizes[id].x) : sizes[id];
            put(id, wall_left >= wall_right ? x : x + width - placed.x, y, placed, best.is_turned);
        }
        return true;
    }

    struct fit {
        int score = 0;
        std::size_t at = 0;
        bool is_turned = false;
    };

    /// The first of the rectangles left that fits a gap best: it spans the gap and is level with a
    /// wall, spans it, is level with the higher wall, with the lower one, or just fits.
    [[nodiscard]] fit best_fit(std::span<const ivec2> sizes, const ivec2& gap,
                               const ivec2& walls) noexcept {
        const int higher = std::max(walls.x, walls.y);
        const int lower = std::min(walls.x, walls.y);
        fit best;
        const auto consider = [&](std::size_t at, int w, int h, bool is_turned) {
            if (w > gap.x || h > gap.y) return;
            const bool is_level = h == higher || h == lower;
            const int score = w == gap.x ? 4 + is_level : h == higher ? 3 : 1 + is_level;
            if (score > best.score) best = {score, at, is_turned};
        };
        std::size_t at = 0;
        for (; at < left_.size() && best.score < 5; ++at) {
            const ivec2 size = sizes[left_[at]];
            consider(at, size.x, size.y, false);
            if (room_.allows_turns) consider(at, size.y, size.x, true);
        }
        steps_ += static_cast<std::int64_t>(at);
        return best;
    }

    void put(std::uint32_t id, int x, int y, const ivec2& size, bool is_turned) {
        places_[id] = {x, y, is_turned};
        use_.area += std::int64_t{size.x} * size.y;
        use_.width = std::max(use_.width, x + size.x);
        use_.height = std::max(use_.height, y + size.y);
        raise(x, x + size.x, y + size.y);
        steps_ += 8;
    }

    /// Sets the skyline from `begin` to `end` to `level`; pieces of one level become one.
    void raise(int begin, int end, int level) {
        const auto at = [this](std::size_t i) {
            return tops_.begin() + static_cast<std::ptrdiff_t>(i);
        };
        std::size_t first = 0;  // the first piece that starts at `begin` or after it
        while (first < tops_.size() && tops_[first].x < begin) ++first;
        std::size_t last = first;  // the first piece that starts after `end`, or at it
        while (last < tops_.size() && tops_[last].x < end) ++last;
        const int after = tops_[last - 1].y;  // the level of what `end` cuts
        const bool goes_on = end < (last < tops_.size() ? tops_[last].x : room_.width);
        const bool joins_before = first > 0 && tops_[first - 1].y == level;
        const bool joins_after = !goes_on && last < tops_.size() && tops_[last].y == level;
        if (joins_after) ++last;
        tops_.erase(at(first), at(last));
        if (goes_on && after != level) tops_.insert(at(first), {end, after});
        if (!joins_before) tops_.insert(at(first), {begin, level});
    }

    std::vector<strip_place> places_{};
    std::vector<piece> tops_{};
    std::vector<std::uint32_t> left_{};
    strip room_{};
    strip_use use_{};
    std::int64_t steps_ = 0;
};

}  // namespace billow::inline BILLOW_ABI::detail

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

namespace billow::inline BILLOW_ABI {

struct pack_options {
    int max_size = 4096;        ///< longest side of an atlas, pixels
    int padding = 8;            ///< pixels kept free on each side of every rectangle
    int alignment = 4;          ///< padded rectangles and atlases start and end at multiples of it
    bool power_of_two = false;  ///< sides of atlases are powers of two; costs area
    bool allows_rotation = true;  ///< rectangles may be turned by 90°
};

/// Where a rectangle went: its first pixel, padding not counted.
struct packed_rectangle {
    atlas_id atlas = no_id;
    int x = 0;
    int y = 0;
    bool is_rotated = false;
};

struct packing {
    std::vector<packed_rectangle> rectangles{};  ///< in the order of the input
    std::vector<ivec2> atlas_sizes{};
    double fill = 0;         ///< area of the rectangles / area of the atlases
    double padded_fill = 0;  ///< the same with padding, up to multiples of the alignment
};

namespace detail {

/// The longest side of an atlas, in units of the alignment.
[[nodiscard]] inline int side_limit(const pack_options& options) noexcept {
    return (options.power_of_two ? floor_power_of_two(options.max_size) : options.max_size) /
           options.alignment;
}

/// One call of pack_rectangles. Lengths are in units of the alignment.
class atlas_packer {
public:
    atlas_packer(std::span<const ivec2> sizes, const pack_options& options)
        : sizes_(sizes),
          options_(options),
          limit_(side_limit(options)),
          steps_left_(search_steps(sizes.size())) {}

    [[nodiscard]] packing run() {
        packing result;
        result.rectangles.resize(sizes_.size());
        std::vector<std::size_t> left(sizes_.size());
        std::iota(left.begin(), left.end(), std::size_t{0});
        while (!left.empty()) fill_atlas(left, result);
        measure(result);
        return result;
    }

private:
    [[nodiscard]] ivec2 padded(const ivec2& size) const noexcept {
        const auto units = [this](int side) {
            return (side + 2 * options_.padding + options_.alignment - 1) / options_.alignment;
        };
        return {units(size.x), units(size.y)};
    }

    /// Moves rectangles from `left` to one more atlas: all, where that can be found.
    void fill_atlas(std::vector<std::size_t>& left, packing& result) {
        std::vector<ivec2> sizes;
        sizes.reserve(left.size());
        for (const std::size_t id : left) sizes.push_back(padded(sizes_[id]));
        strip_search search(sizes, limit_, options_.allows_rotation, steps_left_);
        std::vector<strip_place> places =
            options_.power_of_two ? search.smallest_power_of_two() : search.smallest();
        steps_left_ = std::max<std::int64_t>(steps_left_ - search.steps(), 0);
        turn_back(sizes, places);

        ivec2 used(0);
        const auto atlas = static_cast<atlas_id>(result.atlas_sizes.size());
        std::vector<std::size_t> kept;
        for (std::size_t i = 0; i < left.size(); ++i) {
            const strip_place& p = places[i];
            if (p.x < 0) {
                kept.push_back(left[i]);
                continue;
            }
            const ivec2 size = p.is_turned ? ivec2(sizes[i].y, sizes[i].x) : sizes[i];
            used = glm::max(used, ivec2(p.x, p.y) + size);
            result.rectangles[left[i]] = {atlas, p.x * options_.alignment + options_.padding,
                                          p.y * options_.alignment + options_.padding, p.is_turned};
        }
        ivec2 side = used * options_.alignment;
        if (options_.power_of_two) side = {ceil_power_of_two(side.x), ceil_power_of_two(side.y)};
        result.atlas_sizes.push_back(side);
        BILLOW_ASSERT(kept.size() < left.size());
        left = std::move(kept);
    }

    /// Turns a whole atlas by 90° where that leaves more area of rectangles upright.
    void turn_back(const std::vector<ivec2>& sizes, std::vector<strip_place>& places) const {
        if (!options_.allows_rotation) return;
        std::int64_t turned = 0;
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            if (places[i].x < 0) continue;
            const std::int64_t area = std::int64_t{sizes[i].x} * sizes[i].y;
            turned += places[i].is_turned ? area : -area;
        }
        if (turned <= 0) return;
        for (strip_place& p : places) {
            if (p.x < 0) continue;
            p = {p.y, p.x, !p.is_turned};
        }
    }

    void measure(packing& result) const noexcept {
        double atlases = 0;
        for (const ivec2& size : result.atlas_sizes) {
            atlases += static_cast<double>(size.x) * size.y;
        }
        for (const ivec2& size : sizes_) {
            const ivec2 whole = padded(size) * options_.alignment;
            result.fill += static_cast<double>(size.x) * size.y / atlases;
            result.padded_fill += static_cast<double>(whole.x) * whole.y / atlases;
        }
    }

    std::span<const ivec2> sizes_;
    pack_options options_;
    int limit_;
    std::int64_t steps_left_;
};

}  // namespace detail

/// The longest side that a rectangle may have to fit into an atlas, pixels.
[[nodiscard]] inline int largest_side(const pack_options& options) noexcept {
    return detail::side_limit(options) * options.alignment - 2 * options.padding;
}

/// Places rectangles in atlases so that they keep their distance: in one atlas, the smallest that is
/// found, where they fit into one; otherwise the first ones as full, so the last as small, as can be.
///
/// Unit   pixels.
/// Needs  sides of at least 1 and at most largest_side(options); with power_of_two an alignment that
///        is a power of two, too.
/// Gives  no atlas for no rectangle. Sides of an atlas about twice each other at most, but where
///        long rectangles need more. The same answer every time and everywhere.
/// Cost   a few ms for ten rectangles, 40 for 200, 0.3 s for 3,000: the search ends after a number
///        of steps, or at a fill of 1.
[[nodiscard]] inline packing pack_rectangles(std::span<const ivec2> sizes,
                                             const pack_options& options = {}) {
    BILLOW_ASSERT(options.alignment > 0 && options.padding >= 0);
    return detail::atlas_packer(sizes, options).run();
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/place_tiles.hpp
// Tiles into atlases: where each goes, and its texels there.

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

// ---- billow/bake/tile_picture.hpp
// The texels of one billboard, before it is known where in an atlas they go.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Which texels of a tile are used: columns [x, x + width), rows [y, y + height).
struct texel_box {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    friend bool operator==(const texel_box&, const texel_box&) = default;
};

/// An upright tile: the billboard's u axis to the right, v up, rows from the top.
///
/// Shape  `covered` and `cut_out` have one row a texel, as every channel that is there.
struct tile_picture {
    int width = 0;
    int height = 0;
    int supersample = 1;  ///< samples a texel side
    atlas channels{};  ///< a texel without covered samples holds nothing yet; alpha: see tile_alpha
    std::vector<std::uint8_t> covered{};  ///< samples that show a face
    std::vector<std::uint8_t> cut_out{};  ///< those of them whose material has holes: leaves
    double surface_area = 0;  ///< of what is seen, in texels: tilted faces count by their own area,
                              ///< up to four times what they cover
    texel_box box{};          ///< what is kept of it

    [[nodiscard]] std::size_t texel_count() const noexcept {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    [[nodiscard]] std::size_t index(int x, int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
    [[nodiscard]] float share(std::size_t texel) const noexcept {
        return static_cast<float>(covered[texel]) / static_cast<float>(supersample * supersample);
    }
    [[nodiscard]] std::uint8_t& alpha(std::size_t texel) noexcept {
        return channels.base_color.bytes[4 * texel + 3];
    }
    [[nodiscard]] std::uint8_t alpha(std::size_t texel) const noexcept {
        return channels.base_color.bytes[4 * texel + 3];
    }
    /// The area of the faces as it is seen along the billboard's normal, in texels.
    [[nodiscard]] double covered_area() const noexcept {
        std::size_t samples = 0;
        for (const std::uint8_t count : covered) samples += count;
        return static_cast<double>(samples) / (supersample * supersample);
    }
};

/// An empty tile; with the channels that a bake fills.
[[nodiscard]] inline tile_picture empty_tile(const ivec2& size, int supersample, bool has_horizon) {
    tile_picture tile;
    tile.width = size.x;
    tile.height = size.y;
    tile.supersample = supersample;
    tile.channels = {image::filled(size.x, size.y, 4, 0), image::filled(size.x, size.y, 3, 0),
                     image::filled(size.x, size.y, 3, 0), image::filled(size.x, size.y, 3, 0)};
    if (has_horizon) tile.channels.horizon = image::filled(size.x, size.y, 4, 0);
    tile.covered.assign(tile.texel_count(), 0);
    tile.cut_out.assign(tile.texel_count(), 0);
    tile.box = {0, 0, size.x, size.y};
    return tile;
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Where the texel in column x and row y of an upright tile lies in the atlas.
[[nodiscard]] inline ivec2 texel_position(const tile& t, int x, int y) noexcept {
    // A quarter turn clockwise takes the row from the top to the column from the right.
    return t.is_rotated ? ivec2(t.x + t.width - 1 - y, t.y + x) : ivec2(t.x + x, t.y + y);
}

namespace detail {

/// Copies tile.box of one channel.
inline void place_channel(const tile_picture& tile, const image& from, const struct tile& place,
                          image& to) {
    if (to.empty()) return;
    const texel_box& box = tile.box;
    for (int y = 0; y < box.height; ++y) {
        for (int x = 0; x < box.width; ++x) {
            const ivec2 at = texel_position(place, x, y);
            std::copy_n(from.pixel(box.x + x, box.y + y), from.channels, to.pixel(at.x, at.y));
        }
    }
}

/// Turns tangent space normals with their tile: x becomes -y, and y becomes x.
inline void turn_normals(const struct tile& place, image& normals) {
    for (int y = place.y; y < place.y + place.height; ++y) {
        for (int x = place.x; x < place.x + place.width; ++x) {
            std::uint8_t* n = normals.pixel(x, y);
            n[1] = static_cast<std::uint8_t>(255 - std::exchange(n[0], n[1]));
        }
    }
}

}  // namespace detail

/// Packs the boxes of tiles into atlases and copies what they hold; a mark for each texel of an atlas
/// whether a tile has covered samples there.
struct placed_tiles {
    std::vector<tile> tiles{};
    std::vector<atlas> atlases{};
    std::vector<std::vector<char>> is_covered{};  ///< one list an atlas
    double fill = 0;                              ///< see baked_cloud::fill
};

/// Needs  tiles whose boxes are not empty and fit, see largest_side; all with the same channels.
/// Cost   of the packer, and O(texels), parallel over tiles.
[[nodiscard]] inline placed_tiles place_tiles(std::span<const tile_picture> tiles,
                                              const pack_options& options, normal_style normals,
                                              parallel threads = {}) {
    std::vector<ivec2> sizes;
    sizes.reserve(tiles.size());
    for (const tile_picture& t : tiles) sizes.emplace_back(t.box.width, t.box.height);
    const packing places = pack_rectangles(sizes, options);
    placed_tiles result;
    const bool has_horizon = !tiles.empty() && !tiles.front().channels.horizon.empty();
    double atlas_area = 0;
    for (const ivec2& size : places.atlas_sizes) {
        result.atlases.push_back(
            {image::filled(size.x, size.y, 4, 0), image::filled(size.x, size.y, 3, 0),
             image::filled(size.x, size.y, 3, 0), image::filled(size.x, size.y, 3, 0)});
        if (has_horizon) result.atlases.back().horizon = image::filled(size.x, size.y, 4, 0);
        const auto texels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
        result.is_covered.emplace_back(texels, char{0});
        atlas_area += static_cast<double>(texels);
    }
    double tile_area = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const packed_rectangle& r = places.rectangles[i];
        const ivec2 size = r.is_rotated ? ivec2(sizes[i].y, sizes[i].x) : sizes[i];
        result.tiles.push_back({r.atlas, r.x, r.y, size.x, size.y, r.is_rotated});
        tile_area += static_cast<double>(size.x) * size.y;
    }
    result.fill = atlas_area > 0 ? tile_area / atlas_area : 0;
    threads.for_chunks(tiles.size(), 1, [&](std::size_t i, std::size_t) {
        const tile& place = result.tiles[i];
        atlas& to = result.atlases[place.atlas];
        const atlas& from = tiles[i].channels;
        detail::place_channel(tiles[i], from.base_color, place, to.base_color);
        detail::place_channel(tiles[i], from.normal, place, to.normal);
        detail::place_channel(tiles[i], from.occlusion_roughness_metallic, place,
                              to.occlusion_roughness_metallic);
        detail::place_channel(tiles[i], from.emissive, place, to.emissive);
        detail::place_channel(tiles[i], from.horizon, place, to.horizon);
        if (place.is_rotated &&
            (normals == normal_style::folded || normals == normal_style::sheets)) {
            detail::turn_normals(place, to.normal);
        }
        const texel_box& box = tiles[i].box;
        std::vector<char>& marks = result.is_covered[place.atlas];
        for (int y = 0; y < box.height; ++y) {
            for (int x = 0; x < box.width; ++x) {
                if (tiles[i].covered[tiles[i].index(box.x + x, box.y + y)] == 0) continue;
                const ivec2 at = texel_position(place, x, y);
                marks[static_cast<std::size_t>(at.y) * static_cast<std::size_t>(to.width()) +
                      static_cast<std::size_t>(at.x)] = 1;
            }
        }
    });
    return result;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/side_difference.hpp
// Whether the two sides of a billboard look different enough for a tile each.

#include <algorithm>
#include <cmath>


namespace billow::inline BILLOW_ABI {

/// How far apart the colours of two sides are: the mean, over squares of 8 × 8 texels and weighted by
/// the samples that both show, of the distance of the squares' mean sRGB colours; the squares'
/// means, so that leaves of one colour in other places do not count as a difference. A square that
/// only one side covers differs wholly.
///
/// Shape  tiles of the same size in texels, the back's columns running the other way.
/// Unit   0: equal, 1: black and white.
[[nodiscard]] inline double side_difference(const tile_picture& front, const tile_picture& back) {
    BILLOW_ASSERT(front.width == back.width && front.height == back.height);
    constexpr int square = 8;
    double sum = 0;
    double weight = 0;
    for (int top = 0; top < front.height; top += square) {
        for (int left = 0; left < front.width; left += square) {
            dvec3 color[2]{dvec3(0), dvec3(0)};
            double covered[2]{0, 0};
            const auto add = [&](int side, const tile_picture& from, int x, int y) {
                const std::size_t at = from.index(x, y);
                const auto share = static_cast<double>(from.share(at));
                const std::uint8_t* p = &from.channels.base_color.bytes[4 * at];
                color[side] += dvec3(p[0], p[1], p[2]) * (share / 255);
                covered[side] += share;
            };
            for (int y = top; y < std::min(top + square, front.height); ++y) {
                for (int x = left; x < std::min(left + square, front.width); ++x) {
                    add(0, front, x, y);
                    add(1, back, back.width - 1 - x, y);
                }
            }
            const double most = std::max(covered[0], covered[1]);
            if (most == 0) continue;
            const bool is_on_both = std::min(covered[0], covered[1]) > 0;
            const double apart =
                is_on_both
                    ? glm::distance(color[0] / covered[0], color[1] / covered[1]) / std::sqrt(3.0)
                    : 1;
            const double shown = is_on_both ? std::min(covered[0], covered[1]) : most;
            sum += apart * shown;
            weight += shown;
        }
    }
    return weight > 0 ? sum / weight : 0;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/tile_alpha.hpp
// Which texels of a tile are opaque, so that as much is drawn as the faces cover.
//
// Fuhrmann et al. 2005, section 3.3.7: binary alpha by rank, 0.3 of a texel's samples. Differs: that
// threshold makes leaves fatter by what their outlines are long; here the threshold is the one of
// each tile with which the area is right. Cook et al. 2007 keep area when leaves are dropped.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// What alpha holds. All are drawn with an alpha test at a half.
enum class alpha_kind : std::uint8_t {
    binary,    ///< 0 or 255
    coverage,  ///< the covered share: antialiased with alpha to coverage, or blended
    distance,  ///< signed distance to the outline: smooth however near one comes
};

/// The opaque area that a tile is given.
enum class opaque_area : std::uint8_t {
    thresholds,  ///< whatever the thresholds give
    covered,     ///< of the faces as they are seen along the billboard's normal
    surface,     ///< of the faces themselves: tilted leaves keep their area, see tile_picture
};

/// Shares of a texel that must be covered for it to be opaque.
struct coverage_thresholds {
    double foliage = 0.3;  ///< materials of alpha_mode::mask and blend
    double solid = 0.5;
};

struct alpha_options {
    alpha_kind kind = alpha_kind::binary;
    opaque_area area = opaque_area::covered;
    coverage_thresholds thresholds{};
    double spread = 4;  ///< texels each way that distances are told, more than 0
};

namespace detail {

/// Neighbours within a tile, the texel itself included.
template <class Visit>
void for_neighbours(const tile_picture& in, int x, int y, const Visit& visit) {
    for (int j = std::max(0, y - 1); j <= std::min(in.height - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(in.width - 1, x + 1); ++i) {
            visit(in.index(i, j));
        }
    }
}

/// One call of choose_alpha for binary alpha; its methods are the steps in their order.
class binary_alpha {
public:
    binary_alpha(tile_picture& tile, const alpha_options& options)
        : tile_(tile), options_(options) {}

    void run() {
        std::vector<char> is_fine(tile_.texel_count(), 0);
        for (std::size_t i = 0; i < tile_.texel_count(); ++i) {
            const bool is_opaque = ratio(i) >= 1 - 1e-6f;
            tile_.alpha(i) = is_opaque ? 255 : 0;
            is_fine[i] = options_.area != opaque_area::thresholds && tile_.cut_out[i] > 0;
        }
        if (options_.area != opaque_area::thresholds) {
            find_thin_solids(is_fine);
            rank(is_fine);
        }
        if (options_.area == opaque_area::surface) grow();
    }

private:
    struct ranked {
        float key;
        std::uint32_t texel;
    };

    /// The covered share over the threshold of what covers it.
    [[nodiscard]] float ratio(std::size_t i) const noexcept {
        if (tile_.covered[i] == 0) return 0;
        const double leaves = static_cast<double>(tile_.cut_out[i]) / tile_.covered[i];
        const double threshold = options_.thresholds.solid +
                                 leaves * (options_.thresholds.foliage - options_.thresholds.solid);
        return static_cast<float>(tile_.share(i) / threshold);
    }

    /// Texels of solids that have no opaque one beside them: rods thinner than a texel. Along the
    /// outline of what is wider a ranking would only fray it.
    void find_thin_solids(std::vector<char>& is_fine) const {
        for (int y = 0; y < tile_.height; ++y) {
            for (int x = 0; x < tile_.width; ++x) {
                const std::size_t at = tile_.index(x, y);
                if (tile_.covered[at] == 0 || tile_.cut_out[at] > 0) continue;
                bool has_opaque = false;
                for_neighbours(tile_, x, y, [&](std::size_t i) {
                    has_opaque |= tile_.cut_out[i] == 0 && tile_.alpha(i) != 0;
                });
                if (!has_opaque) is_fine[at] = 1;
            }
        }
    }

    /// Makes as many of these texels opaque as they cover: those with most samples first, among
    /// equals those amid others, then in an order that spreads them.
    void rank(const std::vector<char>& is_fine) {
        std::vector<ranked> order;
        double wanted = 0;
        for (int y = 0; y < tile_.height; ++y) {
            for (int x = 0; x < tile_.width; ++x) {
                const std::size_t at = tile_.index(x, y);
                if (is_fine[at] == 0) continue;
                float around = 0;
                for_neighbours(tile_, x, y, [&](std::size_t i) { around += tile_.share(i); });
                order.push_back({ratio(at) + 0.004f * around + 0.001f * spread_order(x, y),
                                 static_cast<std::uint32_t>(at)});
                wanted += static_cast<double>(tile_.share(at));
            }
        }
        const auto count = std::min(order.size(), static_cast<std::size_t>(std::lround(wanted)));
        std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                         order.end(), [](const ranked& a, const ranked& b) {
                             return a.key != b.key ? a.key > b.key : a.texel < b.texel;
                         });
        for (std::size_t i = 0; i < order.size(); ++i) {
            tile_.alpha(order[i].texel) = i < count ? 255 : 0;
        }
    }

    /// In [0, 1): neighbours get values far apart. Source: Roberts, "The unreasonable effectiveness
    /// of quasirandom sequences", 2018.
    [[nodiscard]] static float spread_order(int x, int y) noexcept {
        const double value = 0.7548776662466927 * x + 0.5698402909980532 * y;
        return static_cast<float>(value - std::floor(value));
    }

    /// Adds the texels nearest to opaque ones until the area is that of the tilted faces; no farther
    /// than two texels.
    void grow() {
        std::size_t opaque = 0;
        for (std::size_t i = 0; i < tile_.texel_count(); ++i) opaque += tile_.alpha(i) != 0;
        const auto wanted = static_cast<std::size_t>(std::lround(tile_.surface_area));
        if (opaque == 0 || wanted <= opaque) return;
        std::vector<std::int32_t> nearest(tile_.texel_count());
        nearest_scratch scratch;
        const auto is_opaque = [&](int x, int y) { return tile_.alpha(tile_.index(x, y)) != 0; };
        nearest_pixels(tile_.width, tile_.height, is_opaque, nearest, scratch);
        std::vector<ranked> order;
        for (int y = 0; y < tile_.height; ++y) {
            for (int x = 0; x < tile_.width; ++x) {
                const std::size_t at = tile_.index(x, y);
                const ivec2 to(nearest[at] % tile_.width - x, nearest[at] / tile_.width - y);
                const float distance = glm::length(vec2(to));
                if (distance == 0 || distance > 2) continue;
                order.push_back({distance - tile_.share(at) + 0.001f * spread_order(x, y),
                                 static_cast<std::uint32_t>(at)});
            }
        }
        const auto count = std::min(order.size(), wanted - opaque);
        std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                         order.end(), [](const ranked& a, const ranked& b) {
                             return a.key != b.key ? a.key < b.key : a.texel < b.texel;
                         });
        for (std::size_t i = 0; i < count; ++i) tile_.alpha(order[i].texel) = 255;
    }

    tile_picture& tile_;
    const alpha_options& options_;
};

[[nodiscard]] inline double area_wanted(const tile_picture& tile, opaque_area area) noexcept {
    return area == opaque_area::surface ? tile.surface_area : tile.covered_area();
}

[[nodiscard]] inline std::vector<float> shares_of(const tile_picture& tile) {
    std::vector<float> shares(tile.texel_count());
    for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = tile.share(i);
    return shares;
}

/// The share whose contour holds the area `wanted`, found by bisection.
[[nodiscard]] inline double contour_level(const alpha_block& shares, double wanted) noexcept {
    const dvec2 high(shares.width, shares.height);
    double low_level = 0.01;
    double high_level = 1;
    for (int i = 0; i < 12; ++i) {
        const double middle = 0.5 * (low_level + high_level);
        const double area = drawn_area(shares, dvec2(0), high, 1, static_cast<float>(middle));
        (area > wanted ? low_level : high_level) = middle;
    }
    return std::min(0.5 * (low_level + high_level), 0.99);
}

/// What is added to all distances so that filtering them draws the area `wanted`: what is finer than a
/// texel has no outline that distances to it could give back.
[[nodiscard]] inline float distance_shift(std::span<const float> distances, int width, int height,
                                          double spread, double wanted) {
    std::vector<float> alpha(distances.size());
    const alpha_block block{alpha, width, 0, 0, width, height};
    double low = -0.5;
    double high = 0.5;
    for (int i = 0; i < 8; ++i) {
        const double middle = 0.5 * (low + high);
        for (std::size_t k = 0; k < alpha.size(); ++k) {
            alpha[k] = static_cast<float>(0.5 + 0.5 * (static_cast<double>(distances[k]) + middle) /
                                                    spread);
        }
        const double area = drawn_area(block, dvec2(0), dvec2(width, height), 1, 0.5f);
        (area < wanted ? low : high) = middle;
    }
    return static_cast<float>(0.5 * (low + high));
}

inline void choose_distances(tile_picture& tile, const alpha_options& options) {
    const std::vector<float> shares = shares_of(tile);
    const bool is_given = options.area == opaque_area::thresholds;
    const double wanted = area_wanted(tile, options.area);
    const alpha_block block{shares, tile.width, 0, 0, tile.width, tile.height};
    const double level = is_given ? options.thresholds.foliage : contour_level(block, wanted);
    const std::vector<float> distances =
        signed_distances(shares, tile.width, tile.height, level, options.spread);
    const float shift =
        is_given ? 0.0f
                 : distance_shift(distances, tile.width, tile.height, options.spread, wanted);
    for (std::size_t i = 0; i < shares.size(); ++i) {
        tile.alpha(i) = byte_from_distance(distances[i] + shift, options.spread);
    }
}

inline void choose_coverage(tile_picture& tile, const alpha_options& options) {
    const std::vector<float> shares = shares_of(tile);
    const alpha_block block{shares, tile.width, 0, 0, tile.width, tile.height};
    const float scale = options.area == opaque_area::thresholds
                            ? static_cast<float>(0.5 / options.thresholds.foliage)
                            : alpha_scale(block, dvec2(0), dvec2(tile.width, tile.height),
                                          area_wanted(tile, options.area), 0.5f);
    for (std::size_t i = 0; i < shares.size(); ++i) {
        tile.alpha(i) = byte_from_unit(shares[i] * scale);
    }
}

}  // namespace detail

/// Sets the alpha of a tile from the covered samples.
///
/// Gives  an opaque area (alpha of 128 on, binary: counted; else as bilinear filtering draws it) as
///        options.area says: of leaves and of rods thinner than a texel to within a texel, of other
///        solids to within half a texel of their outline. At least one opaque texel where a sample
///        is covered.
/// Cost   O(texels), with distances O(texels · spread²).
inline void choose_alpha(tile_picture& tile, const alpha_options& options) {
    if (tile.texel_count() == 0) return;
    if (options.kind == alpha_kind::binary) detail::binary_alpha(tile, options).run();
    if (options.kind == alpha_kind::coverage) detail::choose_coverage(tile, options);
    if (options.kind == alpha_kind::distance) detail::choose_distances(tile, options);
    std::size_t most = 0;
    for (std::size_t i = 0; i < tile.texel_count(); ++i) {
        if (tile.alpha(i) >= 128) return;
        if (tile.covered[i] > tile.covered[most]) most = i;
    }
    if (tile.covered[most] > 0) tile.alpha(most) = 255;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/tile_drawer.hpp
// Draws the billboards of a cloud, each into a picture of its own.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 4.5.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

// ---- billow/bake/draw_set.hpp
// Which faces are drawn on each billboard: its own, and every other one that lies close enough to
// its plane or reaches into its envelope. The latter close cracks between planes.
//
// Décoret et al. 2003 and Fuhrmann et al. 2005 draw all faces valid for the plane, Huang et al. 2004
// those in its envelope.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

// ---- billow/bake/visibility.hpp
// Which face is foremost at every sample of an orthographic view.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

// ---- billow/bake/row_alpha.hpp
// Along a row of samples, where the alpha of a face lets it be seen: several samples at once.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>


namespace billow::inline BILLOW_ABI::detail {

/// A value along a row, in floats from its first sample on.
template <class V>
struct row_value {
    V first;
    V across;

    row_value(const affine_value& of, const dvec2& at) noexcept
        : first(simd::lanes<V>::fill(static_cast<float>(of.at(at.x, at.y)))),
          across(simd::lanes<V>::fill(static_cast<float>(of.dx))) {}
    [[nodiscard]] V at(V step) const noexcept { return first + across * step; }
};

/// wrapped() of several coordinates; where not `wanted`, any number within [0, 1].
template <class V>
[[nodiscard]] V wrapped_lanes(V u, texture_wrap wrap, simd::mask_lanes<V> wanted) noexcept {
    using lanes = simd::lanes<V>;
    const V zero = lanes::fill(0);
    const V one = lanes::fill(1);
    const simd::mask_lanes<V> is_inside = (u >= zero) & (u <= one);
    if (simd::any(simd::mask_lanes<V>(wanted & (is_inside == simd::mask_lanes<V>{})))) {
        std::array<float, lanes::count> values;
        lanes::store(values.data(), u);
        for (float& value : values) value = wrapped(value, wrap);
        return lanes::load(values.data());
    }
    return simd::min(simd::max(u, zero), one);
}

/// texels_at() of several coordinates that are wrapped already.
template <class V>
struct texel_pair_lanes {
    std::array<std::int32_t, simd::lanes<V>::count> a;
    std::array<std::int32_t, simd::lanes<V>::count> b;
    V share_of_b;

    texel_pair_lanes(V u, int size, texture_wrap wrap, bool is_nearest) noexcept
        : share_of_b(simd::lanes<V>::fill(0)) {
        using lanes = simd::lanes<V>;
        const V texels = lanes::fill(static_cast<float>(size));
        const V last = lanes::fill(static_cast<float>(size - 1));
        const V x = u * texels;
        if (is_nearest) {
            lanes::store(a.data(), simd::truncate(simd::min(x, last)));
            return;
        }
        const V zero = lanes::fill(0);
        const V one = lanes::fill(1);
        const V shifted = x + lanes::fill(0.5f);
        const V above = simd::to_float(simd::truncate(shifted));
        share_of_b = shifted - above;
        const bool repeats = wrap == texture_wrap::repeat;
        const V before = simd::select(above > zero, above - one, repeats ? last : zero);
        const V after = simd::select(above < texels, above, repeats ? zero : last);
        lanes::store(a.data(), simd::truncate(before));
        lanes::store(b.data(), simd::truncate(after));
    }
};

/// sample_alpha() at several places; without meaning where not `wanted`.
template <bool IsNearest, class V>
[[nodiscard]] V sample_alpha_lanes(const image& level, const texture& t, V u, V v,
                                   simd::mask_lanes<V> wanted) noexcept {
    using lanes = simd::lanes<V>;
    const texel_pair_lanes<V> x(wrapped_lanes<V>(u, t.wrap_u, wanted), level.width, t.wrap_u,
                                IsNearest);
    const texel_pair_lanes<V> y(wrapped_lanes<V>(v, t.wrap_v, wanted), level.height, t.wrap_v,
                                IsNearest);
    const std::uint8_t* texels = level.bytes.data();
    const auto width = static_cast<std::size_t>(level.width);
    const auto values = [&](const auto& column, const auto& row) {
        return simd::to_float(simd::int_lanes_of<V>([&](std::size_t i) {
            return static_cast<std::int32_t>(texels[static_cast<std::size_t>(row[i]) * width +
                                                    static_cast<std::size_t>(column[i])]);
        }));
    };
    const V scale = lanes::fill(1.0f / 255.0f);
    if constexpr (IsNearest) return values(x.a, y.a) * scale;
    const V one = lanes::fill(1);
    const V fx = x.share_of_b;
    const V fy = y.share_of_b;
    V sum = values(x.a, y.a) * ((one - fx) * (one - fy));
    sum += values(x.b, y.a) * (fx * (one - fy));
    sum += values(x.a, y.b) * ((one - fx) * fy);
    sum += values(x.b, y.b) * (fx * fy);
    return sum * scale;
}

/// What decides over the samples of a face whose alpha counts.
class face_alpha {
public:
    /// Needs  `cover` outlives this.
    face_alpha(const face_cover& cover, const raster_triangle& triangle) noexcept : cover_(cover) {
        const auto interpolated = [&](auto&& value) {
            return triangle.interpolate(value(0), value(1), value(2));
        };
        if (cover.alpha != nullptr) {
            u_ = interpolated([&](std::size_t i) { return cover.uvs[i].x; });
            v_ = interpolated([&](std::size_t i) { return cover.uvs[i].y; });
        }
        if (cover.has_vertex_alpha) {
            vertex_ = interpolated([&](std::size_t i) { return cover.vertex_alpha[i]; });
        }
    }

    template <class V, bool IsNearest>
    struct row {
        const face_cover* cover;
        row_value<V> u;
        row_value<V> v;
        row_value<V> vertex;

        /// Alpha of the samples `step` after the first of the row.
        [[nodiscard]] V at(V step, simd::mask_lanes<V> wanted) const noexcept {
            V alpha = simd::lanes<V>::fill(cover->factor);
            if (cover->has_vertex_alpha) alpha *= vertex.at(step);
            if (cover->alpha != nullptr) {
                alpha *= sample_alpha_lanes<IsNearest>(*cover->alpha, *cover->map, u.at(step),
                                                       v.at(step), wanted);
            }
            return alpha;
        }
    };
    template <class V, bool IsNearest>
    [[nodiscard]] row<V, IsNearest> from(const dvec2& at) const noexcept {
        return {&cover_, {u_, at}, {v_, at}, {vertex_, at}};
    }

private:
    const face_cover& cover_;
    affine_value u_{};
    affine_value v_{};
    affine_value vertex_{};
};

}  // namespace billow::inline BILLOW_ABI::detail

namespace billow::inline BILLOW_ABI {

/// Samples per texel side are at most this many.
inline constexpr int max_supersample = 8;

/// A view along -axes.normal onto a grid of samples.
struct orthographic_view {
    frame axes{};            ///< u to the right, v up in the picture, the normal to the viewer
    dvec3 origin{0};         ///< the upper left corner of the grid, where depth is 0
    double sample_size = 1;  ///< scene units a sample side

    /// Column and row in samples, rows running down; height above the origin along the normal.
    [[nodiscard]] dvec3 project(const dvec3& point) const noexcept {
        const dvec3 local = axes.to_local(point - origin);
        return {local.x / sample_size, -local.y / sample_size, local.z};
    }
    [[nodiscard]] std::array<dvec3, 3> project(const std::array<vec3, 3>& corners) const noexcept {
        return {project(dvec3(corners[0])), project(dvec3(corners[1])), project(dvec3(corners[2]))};
    }
};

/// Heights along the normal between which fragments are drawn.
struct depth_range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
};

namespace detail {

/// Thresholds (k + 0.5) / S² for k < S² in the order of Bayer's dither matrix, so that any share of
/// the S × S samples of a texel is spread over it. Source: Bayer 1973.
class dither_matrix {
public:
    explicit dither_matrix(int side) : side_(static_cast<std::uint32_t>(side)) {
        BILLOW_ASSERT(side >= 1 && side <= max_supersample);
        const std::uint32_t count = side_ * side_;
        std::vector<std::uint32_t> ranks(count, 0);
        for (std::uint32_t i = 0; i < count; ++i) {
            for (std::uint32_t k = 0; k < count; ++k)
                ranks[i] += bayer_of(k) < bayer_of(i) ? 1u : 0u;
        }
        for (std::uint32_t shift = 0; shift < count; ++shift) {
            for (std::uint32_t y = 0; y < side_; ++y) {
                for (std::uint32_t x = 0; x < side_ + simd::max_lane_count; ++x) {
                    const std::uint32_t rank = (ranks[y * side_ + x % side_] + shift) % count;
                    thresholds_.push_back((static_cast<float>(rank) + 0.5f) /
                                          static_cast<float>(count));
                }
            }
        }
    }

    [[nodiscard]] std::uint32_t column(int x) const noexcept {
        const auto at = static_cast<std::uint32_t>(x);
        return (side_ & (side_ - 1)) == 0 ? at & (side_ - 1) : at % side_;
    }
    /// Thresholds of row y for a face: a pack of them can be read from every column on. Faces take them in another order each: of two half-transparent leaves one
    /// above the other, the lower must show through.
    [[nodiscard]] const float* row(int y, std::uint32_t shift) const noexcept {
        const std::size_t at = shift % (side_ * side_) * side_ + column(y);
        return thresholds_.data() + at * (side_ + simd::max_lane_count);
    }
    [[nodiscard]] float threshold(int x, int y, std::uint32_t shift) const noexcept {
        return row(y, shift)[column(x)];
    }

private:
    [[nodiscard]] std::uint32_t bayer_of(std::uint32_t cell) const noexcept {
        const std::uint32_t x = cell % side_;
        const std::uint32_t y = cell / side_;
        std::uint32_t value = 0;
        for (std::uint32_t bit = 0; bit < 3; ++bit) {
            const std::uint32_t x_bit = x >> bit & 1;
            const std::uint32_t y_bit = y >> bit & 1;
            value = value << 2 | (x_bit ^ y_bit) << 1 | y_bit;
        }
        return value;
    }

    std::uint32_t side_;
    std::vector<float> thresholds_{};
};

}  // namespace detail

/// Nearest face and its depth for a window of samples. Of two faces at the same depth the one of
/// lower id is seen, so the order of drawing does not matter; front to back is fastest.
class visibility_buffer {
public:
    /// Sample columns and rows of the dither pattern: the samples per texel side.
    explicit visibility_buffer(int supersample = 1) : dither_(supersample) {}

    /// Makes room, so that start() does not allocate.
    void reserve(std::size_t samples) {
        depths_.reserve(samples + simd::max_lane_count);
        faces_.reserve(samples + simd::max_lane_count);
    }

    /// Forgets all and looks at `window`.
    void start(const sample_window& window) {
        window_ = window;
        width_ = static_cast<std::size_t>(window.x_end - window.x_begin);
        // Packs may read beyond the last row.
        const std::size_t size =
            width_ * static_cast<std::size_t>(window.y_end - window.y_begin) + simd::max_lane_count;
        depths_.assign(size, -std::numeric_limits<float>::infinity());
        faces_.assign(size, no_id);
    }

    /// Draws a face, clipped to `range`, where its alpha lets it be seen. V = float is the scalar
    /// reference.
    template <class V = simd::wide>
    void draw(const surface& look, const orthographic_view& view, face_id face,
              const depth_range& range) noexcept {
        const std::array<dvec3, 3> p = view.project(look.source().corners(face));
        const raster_triangle triangle({dvec2(p[0]), dvec2(p[1]), dvec2(p[2])});
        if (triangle.is_empty()) return;
        const fragment_depth depth(triangle, p, range);
        if (depth.is_outside()) return;
        const face_cover cover = look.cover_of(face, triangle.area());
        if (cover.decides == face_cover::rule::always) {
            for_each_span(triangle, face, [&](int y, int begin, int end, const dvec2& at) {
                draw_row<V>(y, begin, end, face, depth, at,
                            [](int, V, simd::mask_lanes<V> wanted) { return wanted; });
            });
            return;
        }
        if (cover.is_nearest) {
            draw_alpha<V, true>(triangle, cover, face, depth);
        } else {
            draw_alpha<V, false>(triangle, cover, face, depth);
        }
    }

    [[nodiscard]] const sample_window& window() const noexcept { return window_; }
    /// The faces of row y, from window().x_begin on; no_id where nothing was drawn.
    [[nodiscard]] const face_id* faces_of_row(int y) const noexcept {
        return faces_.data() + row_offset(y);
    }

private:
    /// Depth over a face, kept within the depths of its corners: slivers must not shoot out.
    struct fragment_depth {
        affine_value plane{};
        float low = 0;  ///< of the corners
        float high = 0;
        float kept_low = 0;
        float kept_high = 0;
        bool is_clipped = false;

        fragment_depth(const raster_triangle& triangle, const std::array<dvec3, 3>& p,
                       const depth_range& range) noexcept
            : plane(triangle.interpolate(p[0].z, p[1].z, p[2].z)),
              low(static_cast<float>(std::min({p[0].z, p[1].z, p[2].z}))),
              high(static_cast<float>(std::max({p[0].z, p[1].z, p[2].z}))),
              kept_low(static_cast<float>(range.low)),
              kept_high(static_cast<float>(range.high)),
              is_clipped(low < kept_low || high > kept_high) {}

        [[nodiscard]] bool is_outside() const noexcept {
            return high < kept_low || low > kept_high;
        }
    };

    /// Calls `visit(y, begin, end, at)` for the samples of a face: those that it takes by the rule,
    /// whose first lies at `at`, and those that a sliver owes, one by one.
    template <class Visit>
    void for_each_span(const raster_triangle& triangle, face_id face, const Visit& visit) noexcept {
        triangle.for_each_row(
            window_, [&](int y, int begin, int end) { visit(y, begin, end, dvec2(begin, y)); });
        if (!triangle.is_sliver()) return;
        triangle.for_each_missing(window_, random_unit(0, face),
                                  [&](int y, int x, const dvec2& at) { visit(y, x, x + 1, at); });
    }

    template <class V, bool IsNearest>
    void draw_alpha(const raster_triangle& triangle, const face_cover& cover, face_id face,
                    const fragment_depth& depth) noexcept {
        const detail::face_alpha alpha(cover, triangle);
        if (cover.decides == face_cover::rule::cutoff) {
            const V cutoff = simd::lanes<V>::fill(cover.cutoff);
            for_each_span(triangle, face, [&](int y, int begin, int end, const dvec2& at) {
                const auto row = alpha.from<V, IsNearest>(at);
                const auto passes = [&](int, V step, simd::mask_lanes<V> wanted) {
                    return simd::mask_lanes<V>(wanted & (row.at(step, wanted) >= cutoff));
                };
                draw_row<V>(y, begin, end, face, depth, at, passes);
            });
            return;
        }
        const auto shift = static_cast<std::uint32_t>(mix_bits(face));
        for_each_span(triangle, face, [&](int y, int begin, int end, const dvec2& at) {
            const auto row = alpha.from<V, IsNearest>(at);
            const float* thresholds = dither_.row(y, shift);
            const auto passes = [&](int x, V step, simd::mask_lanes<V> wanted) {
                const V threshold = simd::lanes<V>::load(thresholds + dither_.column(x));
                return simd::mask_lanes<V>(wanted & (row.at(step, wanted) >= threshold));
            };
            draw_row<V>(y, begin, end, face, depth, at, passes);
        });
    }

    [[nodiscard]] std::size_t row_offset(int y) const noexcept {
        return static_cast<std::size_t>(y - window_.y_begin) * width_;
    }

    /// Draws samples begin to end of row y, of which the first shows the point `at`, where `is_there(step, wanted)` says so: it is given some
    /// samples, counted from `begin`, and which of them would be seen.
    template <class V, class IsThere>
    void draw_row(int y, int begin, int end, face_id face, const fragment_depth& depth,
                  const dvec2& at, const IsThere& is_there) noexcept {
        using lanes = simd::lanes<V>;
        using mask = simd::mask_lanes<V>;
        const std::size_t offset =
            row_offset(y) + static_cast<std::size_t>(begin - window_.x_begin);
        float* depths = depths_.data() + offset;
        face_id* faces = faces_.data() + offset;
        const detail::row_value<V> height(depth.plane, at);
        const V low = lanes::fill(depth.low);
        const V high = lanes::fill(depth.high);
        const V count = lanes::fill(static_cast<float>(end - begin));
        const V last = lanes::fill(static_cast<float>(lanes::count));
        const simd::int_lanes<V> id = simd::int_lanes<V>{} + static_cast<std::int32_t>(face);
        V step = simd::lane_numbers<V>();
        for (int i = 0; i < end - begin; i += static_cast<int>(lanes::count), step += last) {
            const V value = simd::min(simd::max(height.at(step), low), high);
            const V drawn = lanes::load(depths + i);
            mask is_seen = (value >= drawn) & (step < count);
            if (!simd::any(is_seen)) continue;
            if (depth.is_clipped) {
                is_seen &= value >= lanes::fill(depth.kept_low);
                is_seen &= value <= lanes::fill(depth.kept_high);
            }
            is_seen = is_there(begin + i, step, is_seen);
            if (!simd::any(is_seen)) continue;
            auto* const ids = reinterpret_cast<std::int32_t*>(faces + i);
            const auto previous = lanes::load(ids);
            // Ids count from 0, so less than 2³¹ of them are as good as signed.
            const mask is_behind = (value == drawn) & (previous < id);
            is_seen &= is_behind == mask{};
            lanes::store(depths + i, simd::select(is_seen, value, drawn));
            lanes::store(ids, simd::select(is_seen, id, previous));
        }
    }

    detail::dither_matrix dither_;
    sample_window window_{};
    std::size_t width_ = 0;
    std::vector<float> depths_{};
    std::vector<face_id> faces_{};
};

/// The samples of one texel that show the same face.
struct texel_part {
    face_id face = no_id;
    int samples = 0;
    dvec2 centre{0};  ///< their mean position, in samples
};

/// Groups the S × S samples of the texel in column x and row y by face, so that each group is shaded
/// once: sharper than the mean of filtered samples, and cheaper.
///
/// Gives  the number of groups at the front of `parts`.
inline std::size_t parts_of_texel(
    const visibility_buffer& buffer, int x, int y, int supersample,
    std::array<texel_part, max_supersample * max_supersample>& parts) noexcept {
    std::size_t count = 0;
    for (int j = y * supersample; j < (y + 1) * supersample; ++j) {
        const face_id* row = buffer.faces_of_row(j) - buffer.window().x_begin;
        for (int i = x * supersample; i < (x + 1) * supersample; ++i) {
            if (row[i] == no_id) continue;
            std::size_t part = 0;
            while (part < count && parts[part].face != row[i]) ++part;
            if (part == count) parts[count++] = {row[i], 0, dvec2(0)};
            ++parts[part].samples;
            parts[part].centre += dvec2(i + 0.5, j + 0.5);
        }
    }
    for (std::size_t i = 0; i < count; ++i) parts[i].centre /= parts[i].samples;
    return count;
}

/// Shades points of faces in a view; remembers what is constant over the faces met last.
class view_shader {
public:
    view_shader(const surface& look, int supersample) : look_(&look), supersample_(supersample) {}

    /// Forgets the faces of another view.
    void start(const orthographic_view& view) noexcept {
        view_ = view;
        for (entry& e : entries_) e.look.face = no_id;
    }

    /// The look at the point of a face nearest to `point` (in samples), with its normal turned to the
    /// viewer.
    [[nodiscard]] surface_sample at(face_id face, const dvec2& point) noexcept {
        entry& e = entries_[face % entries_.size()];
        if (e.look.face != face) e = entry_of(face);
        const dvec2 w = e.weights_near(point - e.corner);
        surface_sample sample = look_->at(e.look, vec3(1 - w.x - w.y, w.x, w.y));
        sample.normal = normal_toward(sample, e.look, vec3(view_.axes.normal));
        return sample;
    }

private:
    struct entry {
        face_look look{};
        dvec2 corner{0};
        dvec2 u{0};     ///< from the first corner to the second
        dvec2 v{0};     ///< and to the third
        dvec2 to_b{0};  ///< barycentric weight of the second corner = dot(to_b, point - corner)
        dvec2 to_c{0};

        /// Weights of the second and third corner at the point nearest to corner + offset.
        [[nodiscard]] dvec2 weights_near(const dvec2& offset) const noexcept {
            const dvec2 weights(glm::dot(to_b, offset), glm::dot(to_c, offset));
            if (weights.x >= 0 && weights.y >= 0 && weights.x + weights.y <= 1) return weights;
            dvec2 nearest{0};
            double least = std::numeric_limits<double>::infinity();
            const auto consider = [&](const dvec2& from, const dvec2& to) {
                const dvec2 start = u * from.x + v * from.y;
                const dvec2 along = u * to.x + v * to.y - start;
                const double length_sq = glm::dot(along, along);
                if (!(length_sq > 0)) return;
                const double t = std::clamp(glm::dot(offset - start, along) / length_sq, 0.0, 1.0);
                const dvec2 aside = offset - start - along * t;
                if (glm::dot(aside, aside) >= least) return;
                least = glm::dot(aside, aside);
                nearest = from + (to - from) * t;
            };
            consider({0, 0}, {1, 0});
            consider({0, 0}, {0, 1});
            consider({1, 0}, {0, 1});
            return nearest;
        }
    };

    [[nodiscard]] entry entry_of(face_id face) const noexcept {
        const std::array<dvec3, 3> p = view_.project(look_->source().corners(face));
        entry e;
        e.corner = dvec2(p[0]);
        e.u = dvec2(p[1]) - e.corner;
        e.v = dvec2(p[2]) - e.corner;
        const double det = e.u.x * e.v.y - e.u.y * e.v.x;
        if (det != 0) {
            e.to_b = dvec2(e.v.y, -e.v.x) / det;
            e.to_c = dvec2(-e.u.y, e.u.x) / det;
        }
        e.look = look_->look_at(face, 0.5 * std::abs(det) / (supersample_ * supersample_));
        return e;
    }

    const surface* look_;
    int supersample_;
    orthographic_view view_{};
    std::array<entry, 256> entries_{};
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// A face of a draw set, and the bands of texel rows that it may touch.
struct drawn_face {
    face_id face = no_id;
    std::uint16_t first_band = 0;
    std::uint16_t last_band = 0;
    float height = 0;  ///< greatest distance of a corner along the normal

    /// Front to back, and by id among equals.
    friend bool operator<(const drawn_face& a, const drawn_face& b) noexcept {
        return a.height != b.height ? a.height > b.height : a.face < b.face;
    }
};

/// What is drawn, and where, on one billboard.
struct draw_target {
    orthographic_view view{};
    int columns = 0;    ///< in samples
    int rows = 0;       ///< in samples
    int band_rows = 1;  ///< sample rows a band
};

/// Whether a face with these corners reaches into the grid of `target`, and into which bands.
[[nodiscard]] inline std::optional<drawn_face> clipped_to(
    const draw_target& target, face_id face, const std::array<dvec3, 3>& corners) noexcept {
    dvec2 low{std::numeric_limits<double>::infinity()};
    dvec2 high = -low;
    double height = -low.x;
    for (const dvec3& corner : corners) {
        const dvec3 p = target.view.project(corner);
        low = glm::min(low, dvec2(p) - 1.0);  // a sample more each way, as corners may be rounded
        high = glm::max(high, dvec2(p) + 1.0);
        height = std::max(height, p.z);
    }
    if (!(high.x >= 0 && low.x <= target.columns && high.y >= 0 && low.y <= target.rows)) {
        return std::nullopt;
    }
    const auto band_of = [&](double y) {
        const int row = static_cast<int>(std::clamp(y, 0.0, target.rows - 1.0));
        return static_cast<std::uint16_t>(row / target.band_rows);
    };
    return drawn_face{face, band_of(low.y), band_of(high.y), static_cast<float>(height)};
}

/// Which faces besides a plane's own are drawn on it.
struct draw_set_options {
    double least_cosine = 0;  ///< |cos| of the angle to the plane, of merely valid faces; 2: none
    crack_reduction cracks = crack_reduction::none;
    double envelope_scale = 1;  ///< of the box that a corner must be in, about its centre
};

/// The faces of each billboard, front to back.
class draw_sets {
public:
    /// Faces that reach into the rectangle of a target and are mapped to its plane, or in
    /// cloud.also_drawn for it, or valid for it (all corners within its epsilon, not too steep), or
    /// with crack_reduction::envelope have a corner in its envelope. The last two kinds must be
    /// mapped to a plane of the same part, or to none in a cloud without parts.
    ///
    /// Needs  `faces` of the mesh that `cloud` was searched in; one target a plane.
    /// Cost   O(faces × planes) vector operations at worst, fewer where neighbours in the mesh are
    ///        neighbours in space; parallel over planes.
    draw_sets(const face_table& faces, const billboard_cloud& cloud,
              std::span<const draw_target> targets, const draw_set_options& options,
              parallel threads)
        : faces_(faces), cloud_(cloud), targets_(targets), options_(options) {
        bound_blocks();
        const std::size_t planes = targets.size();
        std::vector<std::size_t> counts(planes, 0);
        threads.for_chunks(planes, 1, [&](std::size_t plane, std::size_t) {
            sweep(static_cast<plane_id>(plane), [&](const drawn_face&) { ++counts[plane]; });
        });
        begin_.assign(planes + 1, 0);
        for (std::size_t i = 0; i < planes; ++i) begin_[i + 1] = begin_[i] + counts[i];
        drawn_.resize(begin_.back());
        threads.for_chunks(planes, 1, [&](std::size_t plane, std::size_t) {
            std::size_t at = begin_[plane];
            sweep(static_cast<plane_id>(plane), [&](const drawn_face& f) { drawn_[at++] = f; });
            std::sort(drawn_.begin() + static_cast<std::ptrdiff_t>(begin_[plane]),
                      drawn_.begin() + static_cast<std::ptrdiff_t>(begin_[plane + 1]));
        });
    }

    [[nodiscard]] std::span<const drawn_face> operator[](plane_id plane) const noexcept {
        return std::span(drawn_).subspan(begin_[plane], begin_[plane + 1] - begin_[plane]);
    }

private:
    static constexpr std::size_t block_size = 64;

    /// A sphere around every block of rows, relative to faces_.bounds.centre.
    void bound_blocks() {
        for (std::size_t row = 0; row < faces_.size; row += block_size) {
            const std::size_t end = std::min(row + block_size, faces_.size);
            std::array<dvec3, 3 * block_size> points;
            std::size_t count = 0;
            for (std::size_t i = row; i < end; ++i) {
                for (const columns3& corner : faces_.corner) points[count++] = corner.get(i);
            }
            blocks_.push_back(bounding_sphere_of(count, [&](std::size_t i) { return points[i]; }));
        }
    }

    /// Whether a face may be drawn on a plane that nobody named for it.
    [[nodiscard]] bool may_share(face_id face, plane_id id) const noexcept {
        const plane_id home = cloud_.plane_of_face[face];
        if (home == no_id) return cloud_.parts.empty();
        return cloud_.part_of(home) == cloud_.part_of(id);
    }

    template <class Visit>
    void sweep(plane_id id, const Visit& visit) const noexcept {
        using V = simd::wide;
        using lanes = simd::lanes<V>;
        const plane& of = cloud_.planes[id];
        const double rho =
            of.rho + glm::dot(of.normal, cloud_.bounds.centre - faces_.bounds.centre);
        const billboard& board = cloud_.billboards[id];
        const double slack = 1e-5 * faces_.bounds.radius;
        const double epsilon_of_plane = cloud_.epsilon_of(id);
        const double reach =
            std::max({epsilon_of_plane, std::abs(board.depth_low), std::abs(board.depth_high)}) +
            slack;
        const bool has_envelope = options_.cracks == crack_reduction::envelope;
        const billboard_envelope envelope(board, faces_.bounds.centre, options_.envelope_scale,
                                          slack);
        const std::span<const drawn_too> also_drawn = cloud_.also_drawn_on(id);
        const vec3_lanes<V> normal = fill_lanes<V>(vec3(of.normal));
        const V offset = lanes::fill(static_cast<float>(rho));
        const V epsilon = lanes::fill(static_cast<float>(epsilon_of_plane));
        const V least_cosine = lanes::fill(static_cast<float>(options_.least_cosine));
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            if (std::abs(glm::dot(of.normal, blocks_[b].centre) - rho) >
                reach + blocks_[b].radius) {
                continue;
            }
            const std::size_t begin = b * block_size;
            const std::size_t end = std::min(begin + block_size, faces_.size);
            const bool meets_envelope = has_envelope && envelope.may_meet(blocks_[b]);
            std::array<float, block_size> is_extra{};
            for (std::size_t row = begin; row < end; row += lanes::count) {
                const face_lanes<V> f = load_faces<V>(faces_, row);
                V distance = simd::abs(dot(f.corner[0], normal) - offset);
                distance = simd::max(distance, simd::abs(dot(f.corner[1], normal) - offset));
                distance = simd::max(distance, simd::abs(dot(f.corner[2], normal) - offset));
                const V cosine = simd::abs(dot(f.normal, normal));
                const V one = simd::select(distance <= epsilon, lanes::fill(1), lanes::fill(0));
                V extra = simd::select(cosine >= least_cosine, one, lanes::fill(0));
                if (meets_envelope) extra = simd::max(extra, envelope.reached_by(f));
                lanes::store(is_extra.data() + (row - begin), extra);
            }
            for (std::size_t row = begin; row < end; ++row) {
                const face_id face = faces_.source[row];
                if (cloud_.plane_of_face[face] == id ||
                    (is_extra[row - begin] != 0 && may_share(face, id)) ||
                    std::binary_search(also_drawn.begin(), also_drawn.end(), drawn_too{id, face})) {
                    std::array<dvec3, 3> corners;
                    for (std::size_t k = 0; k < 3; ++k) {
                        corners[k] = faces_.corner[k].get(row) + faces_.bounds.centre;
                    }
                    if (const auto drawn = clipped_to(targets_[id], face, corners)) visit(*drawn);
                }
            }
        }
    }

    const face_table& faces_;
    const billboard_cloud& cloud_;
    std::span<const draw_target> targets_;
    draw_set_options options_;
    std::vector<bounding_sphere> blocks_{};
    std::vector<std::size_t> begin_{};
    std::vector<drawn_face> drawn_{};
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/texel.hpp
// From the samples of a texel to its bytes in a tile.
//
// Luksch 2009, section 4.5: only samples that show a face are averaged, so no halo of background.

#include <algorithm>
#include <array>
#include <cmath>

// ---- billow/bake/horizon.hpp
// The sky that a point sees, compressed to a cone: which directions light comes from.
//
// Fuhrmann et al. 2005, section 3.3.9, bake a "compressed horizon" that they do not define. Here it is
// a bent normal and a cone, as in Klehm et al.: Bent normals and cones in screen-space. VMV 2011.

#include <array>
#include <cstdint>


namespace billow::inline BILLOW_ABI {

/// The directions l with dot(l, axis) > cosine.
struct horizon_cone {
    vec3 axis{0};       ///< unit length; 0 where no direction is better than another
    float cosine = -1;  ///< of the angle between axis and edge: -1 the whole sky, 1 none

    /// Whether light from the direction `l`, unit length, arrives.
    [[nodiscard]] bool is_lit(const vec3& l) const noexcept { return glm::dot(l, axis) > cosine; }
};

/// The cone around the mean visible direction that is as large as what is visible, so that over all
/// directions as much light arrives. `visible` is sky_view::visible, or a mean of several.
///
/// Source  Klehm et al. 2011. Differs: they take the angle from the length of the mean direction,
///         which would open the cone for light that comes in from two opposite sides.
[[nodiscard]] inline horizon_cone cone_of(const vec4& visible) noexcept {
    const vec3 sum(visible);
    const float length = glm::length(sum);
    // A cone of angle θ is (1 - cos θ) / 2 of the sphere.
    return {length > 1e-4f ? sum / length : vec3(0), 1 - 2 * visible.w};
}

/// Four bytes: axis · 0.5 + 0.5 and cosine · 0.5 + 0.5.
[[nodiscard]] inline std::array<std::uint8_t, 4> encode_horizon(const horizon_cone& cone) noexcept {
    return {byte_from_unit(cone.axis.x * 0.5f + 0.5f), byte_from_unit(cone.axis.y * 0.5f + 0.5f),
            byte_from_unit(cone.axis.z * 0.5f + 0.5f), byte_from_unit(cone.cosine * 0.5f + 0.5f)};
}
/// The cone of a texel, as a shader reads it: axis to within 1°, cosine to within 0.004.
[[nodiscard]] inline horizon_cone decode_horizon(const std::uint8_t* texel) noexcept {
    const vec4 value = vec4(texel[0], texel[1], texel[2], texel[3]) * (2.0f / 255.0f) - 1.0f;
    const float length = glm::length(vec3(value));
    return {length > 0.5f ? vec3(value) / length : vec3(0), value.w};
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// The mean look of what a texel shows.
struct texel {
    surface_sample look{};   ///< normal in scene space, turned to the front
    int samples = 0;         ///< that show a face
    int cut_out = 0;         ///< those of them on materials of alpha_mode::mask and blend
    float surface_area = 0;  ///< of what they show, in samples, see tile_picture
};

namespace detail {

/// Sums of looks, weighted by samples.
class look_mean {
public:
    void add(const surface_sample& sample, float weight) noexcept {
        sum_.base_color += sample.base_color * weight;
        sum_.normal += sample.normal * weight;
        sum_.occlusion += sample.occlusion * weight;
        sum_.roughness += sample.roughness * weight;
        sum_.metallic += sample.metallic * weight;
        sum_.emissive += sample.emissive * weight;
        sum_.visible_sky += sample.visible_sky * weight;
        weight_ += weight;
    }
    /// Needs a sample. Normals that cancel out give `front`.
    [[nodiscard]] surface_sample mean(const vec3& front) const noexcept {
        const float scale = 1 / weight_;
        const float length = glm::length(sum_.normal);
        return {.base_color = sum_.base_color * scale,
                .normal = length > 1e-6f * weight_ ? sum_.normal / length : front,
                .occlusion = sum_.occlusion * scale,
                .roughness = sum_.roughness * scale,
                .metallic = sum_.metallic * scale,
                .emissive = sum_.emissive * scale,
                .visible_sky = sum_.visible_sky * scale};
    }

private:
    surface_sample sum_{.base_color = vec3(0),
                        .normal = vec3(0),
                        .occlusion = 0,
                        .roughness = 0,
                        .metallic = 0,
                        .emissive = vec3(0),
                        .visible_sky = vec4(0)};
    float weight_ = 0;
};

/// How much larger a face is than it looks along `front`, at most four times.
[[nodiscard]] inline float tilt_of(const mesh& source, face_id face, const vec3& front) noexcept {
    const auto [a, b, c] = source.corners(face);
    const dvec3 cross = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
    const double seen = std::abs(glm::dot(cross, dvec3(front)));
    const double area = glm::length(cross);
    return area < 4 * seen ? static_cast<float>(area / seen) : 4.0f;
}

}  // namespace detail

/// The texel in column x and row y of a view's grid; `front` is the view's normal. `surface_area` is
/// left at 0 unless `measures_surface`.
[[nodiscard]] inline texel resolve_texel(const visibility_buffer& buffer, view_shader& shader,
                                         const surface& look, int x, int y, int supersample,
                                         const vec3& front,
                                         bool measures_surface = false) noexcept {
    std::array<texel_part, max_supersample * max_supersample> parts;
    const std::size_t count = parts_of_texel(buffer, x, y, supersample, parts);
    texel result;
    if (count == 0) return result;
    detail::look_mean mean;
    for (std::size_t i = 0; i < count; ++i) {
        const bool is_solid = look.material_of(parts[i].face).alpha == alpha_mode::opaque;
        // Solids at the centre of the texel, or the nearest point of the face: sharp where a texel
        // lies across an edge. Of leaves the centre may be a hole.
        const dvec2 point =
            is_solid ? dvec2(x + 0.5, y + 0.5) * static_cast<double>(supersample) : parts[i].centre;
        mean.add(shader.at(parts[i].face, point), static_cast<float>(parts[i].samples));
        if (measures_surface) {
            result.surface_area += static_cast<float>(parts[i].samples) *
                                   detail::tilt_of(look.source(), parts[i].face, front);
        }
        result.samples += parts[i].samples;
        if (!is_solid) result.cut_out += parts[i].samples;
    }
    result.look = mean.mean(front);
    return result;
}

/// How a normal becomes a colour.
struct normal_encoding {
    frame axes{};                 ///< of the billboard, or of its back
    bool is_scene_space = false;  ///< as it is; else in the billboard's axes, and never behind it
};

[[nodiscard]] inline vec3 encoded_normal(const vec3& normal, const normal_encoding& how) noexcept {
    if (how.is_scene_space) return normal;
    vec3 local(how.axes.to_local(dvec3(normal)));
    // A tangent space normal map holds nothing behind the surface: blue stays at 128 or above.
    local.z = std::max(local.z, 0.004f);
    return glm::normalize(local);
}

/// Writes `value` to all channels that `to` has, but alpha.
inline void write_texel(tile_picture& to, const normal_encoding& normals, int x, int y,
                        const texel& value) noexcept {
    const std::size_t at = to.index(x, y);
    to.covered[at] = static_cast<std::uint8_t>(value.samples);
    to.cut_out[at] = static_cast<std::uint8_t>(value.cut_out);

    atlas& channels = to.channels;
    const surface_sample& look = value.look;
    std::uint8_t* color = channels.base_color.pixel(x, y);
    for (int c = 0; c < 3; ++c) color[c] = srgb_byte_from_linear(look.base_color[c]);
    const vec3 normal = encoded_normal(look.normal, normals);
    std::uint8_t* n = channels.normal.pixel(x, y);
    for (int c = 0; c < 3; ++c) n[c] = byte_from_unit(normal[c] * 0.5f + 0.5f);
    std::uint8_t* orm = channels.occlusion_roughness_metallic.pixel(x, y);
    orm[0] = byte_from_unit(look.occlusion);
    orm[1] = byte_from_unit(look.roughness);
    orm[2] = byte_from_unit(look.metallic);
    std::uint8_t* emissive = channels.emissive.pixel(x, y);
    for (int c = 0; c < 3; ++c) emissive[c] = srgb_byte_from_linear(look.emissive[c]);
    if (!channels.horizon.empty()) {
        const auto cone = encode_horizon(cone_of(look.visible_sky));
        std::copy(cone.begin(), cone.end(), channels.horizon.pixel(x, y));
    }
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct draw_options {
    int supersample = 4;  ///< samples a texel side, 1 to 8; time grows with its square
    double max_extra_angle = 75 * std::numbers::pi / 180;  ///< radians between a plane and other
                                                           ///< valid faces drawn on it; 0: none
    crack_reduction cracks = crack_reduction::none;
    double envelope_scale =
        1;  ///< size of the boxes that faces must reach into, above 0 to 1: less
            ///< is drawn where it does not belong, more cracks stay
    normal_style normals = normal_style::folded;
    double dome = 0.8;  ///< of normal_style::dome, the weight of the directions out of the middle
    std::vector<double> part_dome{};  ///< one a part; none: `dome` for all
    bool with_horizon = false;        ///< needs a surface that light_by() was told of
    bool measures_surface = false;    ///< fills tile_picture::surface_area
};

/// The cloud seen from behind: planes and billboards turned round their v axes.
[[nodiscard]] inline billboard_cloud turned_round(const billboard_cloud& cloud) {
    billboard_cloud back = cloud;
    for (plane& p : back.planes) p = {-p.normal, -p.rho};
    for (billboard& b : back.billboards) {
        b.origin += b.axes.u * b.width;
        b.axes = {-b.axes.u, b.axes.v, -b.axes.normal};
        b.depth_low = -std::exchange(b.depth_high, -b.depth_low);
    }
    return back;
}

/// What the faces of each billboard look like from its front.
///
/// Needs  `look` of the mesh that `faces` and `cloud` are of; billboards of whole texels, see
///        snap_to_texels. All outlive it.
class tile_drawer {
public:
    /// Cost  as draw_sets.
    tile_drawer(const surface& look, const face_table& faces, const billboard_cloud& cloud,
                double texel_size, const draw_options& options, parallel threads)
        : look_(look),
          faces_(faces),
          cloud_(cloud),
          texel_size_(texel_size),
          options_(options),
          threads_(threads),
          targets_(targets_of(options.supersample)),
          sets_(faces, cloud, targets_,
                {options.max_extra_angle > 0 ? std::cos(options.max_extra_angle) : 2,
                 options.cracks, options.envelope_scale},
                threads) {
        if (options.normals == normal_style::dome) find_middles();
    }
    tile_drawer(const tile_drawer&) = delete;
    tile_drawer& operator=(const tile_drawer&) = delete;

    /// The pictures of some billboards, whose alpha is not set yet. A billboard whose faces slip
    /// between all samples shows the centre of its largest face.
    ///
    /// Needs  1 ≤ supersample ≤ max_supersample.
    /// Cost   O(samples × faces that overlap), parallel over bands of tiles; for each thread 8 bytes
    ///        a sample of a band.
    template <class Progress>
    [[nodiscard]] std::vector<tile_picture> draw(std::span<const plane_id> ids, int supersample,
                                                 const Progress& progress) const {
        const std::vector<draw_target> targets =
            supersample == options_.supersample ? targets_ : targets_of(supersample);
        std::vector<tile_picture> tiles;
        std::vector<job> jobs;
        std::size_t widest = 0;
        for (std::size_t i = 0; i < ids.size(); ++i) {
            const ivec2 size = size_of(ids[i]);
            tiles.push_back(empty_tile(size, supersample, options_.with_horizon));
            widest = std::max(widest, static_cast<std::size_t>(size.x * supersample));
            for (int band = 0; band * band_height < size.y; ++band) {
                jobs.push_back({ids[i], i, band});
            }
        }
        std::vector<float> surface_areas(jobs.size(), 0.0f);
        std::vector<job_scratch> scratches(
            threads_.count(),
            job_scratch{visibility_buffer(supersample), view_shader(look_, supersample)});
        for (job_scratch& scratch : scratches) {
            scratch.buffer.reserve(widest * static_cast<std::size_t>(band_height * supersample));
        }
        // Progress is told by the calling thread, so between slices of the jobs.
        constexpr std::size_t slices = 16;
        for (std::size_t i = 0; i < slices; ++i) {
            const std::size_t begin = jobs.size() * i / slices;
            const std::size_t end = jobs.size() * (i + 1) / slices;
            for_jobs(threads_, end - begin, scratches, [&](std::size_t k, auto& scratch) {
                const job& j = jobs[begin + k];
                surface_areas[begin + k] = draw_band(tiles[j.tile], j, targets[j.plane], scratch);
            });
            progress(static_cast<double>(i + 1) / slices);
        }
        for (std::size_t k = 0; k < jobs.size(); ++k) {
            tiles[jobs[k].tile].surface_area += static_cast<double>(surface_areas[k]);
        }
        show_something(tiles, ids, targets);
        return tiles;
    }

private:
    static constexpr int band_height = 16;  ///< texel rows drawn at a time: bounds the memory

    struct job {
        plane_id plane = 0;
        std::size_t tile = 0;
        int band = 0;
    };
    struct job_scratch {
        visibility_buffer buffer;
        view_shader shader;
    };

    [[nodiscard]] ivec2 size_of(plane_id id) const noexcept {
        const billboard& b = cloud_.billboards[id];
        return {static_cast<int>(std::lround(b.width / texel_size_)),
                static_cast<int>(std::lround(b.height / texel_size_))};
    }

    [[nodiscard]] std::vector<draw_target> targets_of(int supersample) const {
        std::vector<draw_target> targets;
        for (plane_id id = 0; id < cloud_.billboards.size(); ++id) {
            const billboard& b = cloud_.billboards[id];
            const ivec2 size = size_of(id);
            targets.push_back({{b.axes, b.origin + b.axes.v * b.height, texel_size_ / supersample},
                               size.x * supersample,
                               size.y * supersample,
                               band_height * supersample});
        }
        return targets;
    }

    /// The middle of what each part shows, which dome normals point away from.
    void find_middles() {
        const std::size_t parts = std::max<std::size_t>(1, cloud_.parts.size());
        std::vector<dvec3> sums(parts, dvec3(0));
        std::vector<double> areas(parts, 0.0);
        for (std::size_t row = 0; row < faces_.size; ++row) {
            const plane_id plane = cloud_.plane_of_face[faces_.source[row]];
            if (plane == no_id) continue;
            const auto area = static_cast<double>(faces_.area[row]);
            sums[cloud_.part_of(plane)] += faces_.centroid(row) * area;
            areas[cloud_.part_of(plane)] += area;
        }
        for (std::size_t i = 0; i < parts; ++i) {
            middles_.push_back(faces_.bounds.centre +
                               (areas[i] > 0 ? sums[i] / areas[i] : dvec3(0)));
        }
    }

    /// The normal of a texel at `point`.
    [[nodiscard]] vec3 domed(const vec3& normal, plane_id id, const dvec3& point) const noexcept {
        const part_id part = cloud_.part_of(id);
        const double weight = options_.part_dome.empty() ? options_.dome : options_.part_dome[part];
        const dvec3 outward = point - middles_[part];
        const double length = glm::length(outward);
        if (!(length > 0)) return normal;
        const dvec3 sum = dvec3(normal) * (1 - weight) + outward * (weight / length);
        const double sum_length = glm::length(sum);
        return sum_length > 1e-9 ? vec3(sum / sum_length) : normal;
    }

    [[nodiscard]] normal_encoding encoding_of(plane_id id) const noexcept {
        return {cloud_.billboards[id].axes,
                options_.normals == normal_style::object || options_.normals == normal_style::dome};
    }

    void write(tile_picture& tile, plane_id id, const normal_encoding& normals, int x, int y,
               texel value) const noexcept {
        if (options_.normals == normal_style::dome) {
            const billboard& b = cloud_.billboards[id];
            const dvec3 point = b.origin + b.axes.u * ((x + 0.5) * texel_size_) +
                                b.axes.v * (b.height - (y + 0.5) * texel_size_);
            value.look.normal = domed(value.look.normal, id, point);
        }
        write_texel(tile, normals, x, y, value);
    }

    /// Gives the surface area that the band shows, in texels.
    [[nodiscard]] float draw_band(tile_picture& tile, const job& j, const draw_target& target,
                                  job_scratch& scratch) const noexcept {
        const int s = tile.supersample;
        const billboard& board = cloud_.billboards[j.plane];
        const int first = j.band * band_height;
        const int last = std::min(first + band_height, tile.height);
        scratch.buffer.start({0, first * s, target.columns, last * s});
        const double slack = 1e-5 * std::max(cloud_.bounds.radius, texel_size_);
        const depth_range range{board.depth_low - slack, board.depth_high + slack};
        for (const drawn_face& f : sets_[j.plane]) {
            if (f.first_band <= j.band && j.band <= f.last_band) {
                scratch.buffer.draw(look_, target.view, f.face, range);
            }
        }
        scratch.shader.start(target.view);
        const normal_encoding normals = encoding_of(j.plane);
        const vec3 front(board.axes.normal);
        float surface_area = 0;
        for (int y = first; y < last; ++y) {
            for (int x = 0; x < tile.width; ++x) {
                const texel value = resolve_texel(scratch.buffer, scratch.shader, look_, x, y, s,
                                                  front, options_.measures_surface);
                if (value.samples == 0) continue;
                write(tile, j.plane, normals, x, y, value);
                surface_area += value.surface_area;
            }
        }
        return surface_area / static_cast<float>(s * s);
    }

    void show_something(std::vector<tile_picture>& tiles, std::span<const plane_id> ids,
                        std::span<const draw_target> targets) const {
        std::vector<std::size_t> largest_row;
        for (std::size_t i = 0; i < tiles.size(); ++i) {
            const auto& covered = tiles[i].covered;
            if (std::any_of(covered.begin(), covered.end(), [](auto c) { return c > 0; })) continue;
            if (largest_row.empty()) largest_row = largest_rows();
            if (const std::size_t row = largest_row[ids[i]]; row != no_id) {
                draw_centre(tiles[i], ids[i], targets[ids[i]], row);
            }
        }
    }

    /// The row of the largest face of each plane, among those that are drawn there by right.
    [[nodiscard]] std::vector<std::size_t> largest_rows() const {
        std::vector<std::size_t> largest_row(cloud_.plane_count(), no_id);
        std::vector<std::size_t> row_of_face(cloud_.plane_of_face.size(), no_id);
        const auto consider = [&](plane_id plane, std::size_t row) {
            std::size_t& largest = largest_row[plane];
            if (largest == no_id || faces_.area[row] > faces_.area[largest]) largest = row;
        };
        for (std::size_t row = 0; row < faces_.size; ++row) {
            const face_id face = faces_.source[row];
            row_of_face[face] = row;
            if (const plane_id plane = cloud_.plane_of_face[face]; plane != no_id) {
                consider(plane, row);
            }
        }
        for (const drawn_too& d : cloud_.also_drawn) {
            if (const std::size_t row = row_of_face[d.face]; row != no_id) consider(d.plane, row);
        }
        return largest_row;
    }

    void draw_centre(tile_picture& tile, plane_id id, const draw_target& target,
                     std::size_t row) const {
        const int s = tile.supersample;
        const dvec2 centre(target.view.project(faces_.centroid(row) + faces_.bounds.centre));
        view_shader shader(look_, s);
        shader.start(target.view);
        const int x = std::clamp(static_cast<int>(centre.x) / s, 0, tile.width - 1);
        const int y = std::clamp(static_cast<int>(centre.y) / s, 0, tile.height - 1);
        write(tile, id, encoding_of(id), x, y, {shader.at(faces_.source[row], centre), 1, 0, 1});
    }

    const surface& look_;
    const face_table& faces_;
    const billboard_cloud& cloud_;
    double texel_size_;
    const draw_options& options_;
    parallel threads_;
    std::vector<draw_target> targets_;
    draw_sets sets_;
    std::vector<dvec3> middles_{};
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/tile_outline.hpp
// What of a tile is worth drawing: the box of its opaque texels, and a polygon around them.

#include <algorithm>
#include <vector>


namespace billow::inline BILLOW_ABI {

namespace detail {

/// Columns [begin, end) of a row that an alpha test under a bilinear filter may draw: opaque texels,
/// and others with alpha beside one.
struct drawn_span {
    int begin = 0;
    int end = 0;
};

[[nodiscard]] inline bool may_be_drawn(const tile_picture& tile, int x, int y) noexcept {
    const std::uint8_t own = tile.alpha(tile.index(x, y));
    if (own >= 128 || own == 0) return own != 0;
    for (int j = std::max(0, y - 1); j <= std::min(tile.height - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(tile.width - 1, x + 1); ++i) {
            if (tile.alpha(tile.index(i, j)) >= 128) return true;
        }
    }
    return false;
}

[[nodiscard]] inline drawn_span drawn_span_of(const tile_picture& tile, int y) noexcept {
    drawn_span span{0, tile.width};
    while (span.begin < span.end && !may_be_drawn(tile, span.begin, y)) ++span.begin;
    while (span.begin < span.end && !may_be_drawn(tile, span.end - 1, y)) --span.end;
    return span;
}

}  // namespace detail

/// The texels of a tile that may be drawn; empty where none is opaque.
[[nodiscard]] inline texel_box drawn_box(const tile_picture& tile) noexcept {
    int left = tile.width;
    int right = 0;
    int top = tile.height;
    int bottom = 0;
    for (int y = 0; y < tile.height; ++y) {
        const detail::drawn_span span = detail::drawn_span_of(tile, y);
        if (span.begin >= span.end) continue;
        left = std::min(left, span.begin);
        right = std::max(right, span.end);
        top = std::min(top, y);
        bottom = y + 1;
    }
    if (left >= right) return {};
    return {left, top, right - left, bottom - top};
}

/// The smallest box around both; one that is empty does not count.
[[nodiscard]] inline texel_box joined(const texel_box& a, const texel_box& b) noexcept {
    if (a.width == 0) return b;
    if (b.width == 0) return a;
    const int x = std::min(a.x, b.x);
    const int y = std::min(a.y, b.y);
    return {x, y, std::max(a.x + a.width, b.x + b.width) - x,
            std::max(a.y + a.height, b.y + b.height) - y};
}

/// A box in a tile as it lies in the tile of the other side.
[[nodiscard]] inline texel_box mirrored(const texel_box& box, int tile_width) noexcept {
    return {tile_width - box.x - box.width, box.y, box.width, box.height};
}

/// The corners of the texels of tile.box that may be drawn, in texels from its lower left corner, as
/// far as they can lie on a convex hull. `is_back`: seen from the other side.
inline void add_drawn_corners(const tile_picture& tile, bool is_back, std::vector<dvec2>& to) {
    const texel_box& box = tile.box;
    for (int y = box.y; y < box.y + box.height; ++y) {
        const detail::drawn_span span = detail::drawn_span_of(tile, y);
        for (int x : {span.begin, span.end}) {
            if (span.begin >= span.end) break;
            x = std::clamp(x - box.x, 0, box.width);
            const double s = is_back ? box.width - x : x;
            to.emplace_back(s, box.height - (y - box.y));
            to.emplace_back(s, box.height - (y - box.y) - 1);
        }
    }
}

/// A convex polygon of at most `most_corners` corners around the corners of texels, in the box from 0
/// to 1 that `size` texels fill; see outline_polygon.
[[nodiscard]] inline std::vector<dvec2> outline_around(std::vector<dvec2> corners,
                                                       const ivec2& size, int most_corners) {
    std::vector<dvec2> hull(corners.size() + 1);
    hull.resize(convex_hull(corners, hull));
    std::vector<dvec2> outline = outline_polygon(hull, dvec2(0), dvec2(size), most_corners);
    for (dvec2& corner : outline) corner /= dvec2(size);
    return outline;
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Which billboards get a tile for each of their sides.
enum class tile_sides : std::uint8_t {
    automatic,  ///< those whose sides look different
    one,        ///< none: the back shows the front's texels
    two,        ///< all
};

struct bake_options {
    int texels = 512;            ///< texels along the diameter of the bounding sphere
    double texels_per_unit = 0;  ///< texels a scene unit; 0: as `texels` says
    int max_atlas = 4096;        ///< longest side of an atlas, texels
    int max_atlases = 0;         ///< as many atlases at most, by coarser texels; 0: any number
    int padding = 8;             ///< texels around each tile; p keeps log2(p) mip levels clean
    bool power_of_two = false;   ///< sides of atlases are powers of two; costs area
    draw_options draw{};
    alpha_options alpha{};
    std::vector<coverage_thresholds> part_thresholds{};  ///< one a part; none: those of `alpha`
    int outline_corners = 0;  ///< at most so many corners a billboard, 4 or more; 0: rectangles
    tile_sides sides = tile_sides::one;      ///< normal_style::sheets: always two
    double side_difference = 0.1;            ///< of automatic sides, see side_difference()
    occlusion_options occlusion{.rays = 0};  ///< darkens what sees little sky; no rays: nothing
};

/// Enlarges every billboard about its centre to whole texels, at least one each way. Its texel
/// counts are then width / texel_size and height / texel_size, but for rounding.
inline void snap_to_texels(billboard_cloud& cloud, double texel_size) {
    for (billboard& b : cloud.billboards) {
        const auto whole = [texel_size](double extent) {
            return std::max(1.0, std::ceil(extent / texel_size - 1e-6)) * texel_size;
        };
        const double width = whole(b.width);
        const double height = whole(b.height);
        b.origin -= b.axes.u * ((width - b.width) * 0.5) + b.axes.v * ((height - b.height) * 0.5);
        b.width = width;
        b.height = height;
    }
}

/// Tiles of a cloud that are in no atlas yet.
struct drawn_tiles {
    std::vector<tile_picture> tiles{};     ///< as baked_cloud::tiles
    std::vector<std::uint32_t> back_of{};  ///< as baked_cloud::back_of
    std::vector<std::vector<dvec2>> outlines{};
    double texel_size = 0;
    double wanted_size = 0;
    double opaque_area = 0;
    double polygon_area = 0;
};

[[nodiscard]] inline pack_options packing_of(const bake_options& options) noexcept {
    return {.max_size = options.max_atlas,
            .padding = options.padding,
            .power_of_two = options.power_of_two};
}

namespace detail {

/// One call of draw_tiles; its methods are the steps in their order.
class tile_baker {
public:
    tile_baker(const mesh& source, billboard_cloud& cloud, const face_table& faces,
               const bake_options& options, parallel threads, const progress_function& progress)
        : cloud_(cloud),
          faces_(faces),
          options_(options),
          draw_(options.draw),
          threads_(threads),
          progress_(progress),
          look_(source) {
        draw_.measures_surface = options.alpha.area == opaque_area::surface;
    }

    [[nodiscard]] drawn_tiles run() {
        choose_texel_size();
        snap_to_texels(cloud_, drawn_.texel_size);
        measure_sky();
        draw_fronts();
        draw_backs();
        choose_alphas();
        crop();
        find_outlines();
        measure_areas();
        return std::move(drawn_);
    }

private:
    /// Luksch 2009, eq 4.1: the same object size for every texel. Where a billboard would not fit
    /// into an atlas, or all into as many as are allowed, all become coarser.
    void choose_texel_size() {
        double largest = 0;
        for (const billboard& b : cloud_.billboards) {
            largest = std::max({largest, b.width, b.height});
        }
        double wanted = options_.texels_per_unit > 0 ? 1 / options_.texels_per_unit
                                                     : 2 * cloud_.bounds.radius / options_.texels;
        if (!(wanted > 0)) wanted = 1;  // a single point has no size
        drawn_.wanted_size = wanted;
        drawn_.texel_size = std::max(wanted, largest / largest_side(packing_of(options_)));
        if (options_.max_atlases == 0) return;
        const double sides = options_.sides == tile_sides::one ? 1 : 2;
        for (; largest > drawn_.texel_size; drawn_.texel_size *= 1.03) {
            std::vector<ivec2> sizes;
            for (const billboard& b : cloud_.billboards) {
                const auto texels = [&](double extent) {
                    return std::max(1, static_cast<int>(std::ceil(extent / drawn_.texel_size)));
                };
                for (int side = 0; side < sides; ++side) {
                    sizes.emplace_back(texels(b.width), texels(b.height));
                }
            }
            const packing places = pack_rectangles(sizes, packing_of(options_));
            if (places.atlas_sizes.size() <= static_cast<std::size_t>(options_.max_atlases)) return;
        }
    }

    void measure_sky() {
        if (options_.occlusion.rays == 0) return;
        sky_ = see_sky(look_, faces_, options_.occlusion, threads_);
        look_.light_by(sky_);
    }

    [[nodiscard]] auto progress_between(double from, double to) const {
        return [this, from, to](double share) {
            report(progress_, "bake", from + (to - from) * share);
        };
    }
    [[nodiscard]] bool draws_two_sides() const noexcept {
        return options_.sides == tile_sides::two || draw_.normals == normal_style::sheets;
    }

    void draw_fronts() {
        std::vector<plane_id> all(cloud_.billboards.size());
        std::iota(all.begin(), all.end(), plane_id{0});
        const tile_drawer drawer(look_, faces_, cloud_, drawn_.texel_size, draw_, threads_);
        drawn_.tiles = drawer.draw(all, draw_.supersample,
                                   progress_between(0.05, draws_two_sides() ? 0.45 : 0.8));
    }

    void draw_backs() {
        if (options_.sides == tile_sides::one && !draws_two_sides()) return;
        const billboard_cloud back = turned_round(cloud_);
        const tile_drawer drawer(look_, faces_, back, drawn_.texel_size, draw_, threads_);
        std::vector<plane_id> wanted(cloud_.billboards.size());
        std::iota(wanted.begin(), wanted.end(), plane_id{0});
        if (!draws_two_sides()) {
            const auto probes = drawer.draw(wanted, 1, [](double) {});
            std::erase_if(wanted, [&](plane_id id) {
                return side_difference(drawn_.tiles[id], probes[id]) <= options_.side_difference;
            });
            if (wanted.empty()) return;
        }
        drawn_.back_of.assign(cloud_.billboards.size(), no_id);
        std::vector<tile_picture> backs =
            drawer.draw(wanted, draw_.supersample, progress_between(0.45, 0.8));
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            drawn_.back_of[wanted[i]] = static_cast<std::uint32_t>(drawn_.tiles.size());
            drawn_.tiles.push_back(std::move(backs[i]));
        }
    }

    void choose_alphas() {
        std::vector<plane_id> plane_of(drawn_.tiles.size());
        std::iota(plane_of.begin(), plane_of.end(), plane_id{0});
        for (plane_id id = 0; id < drawn_.back_of.size(); ++id) {
            if (drawn_.back_of[id] != no_id) plane_of[drawn_.back_of[id]] = id;
        }
        threads_.for_chunks(drawn_.tiles.size(), 1, [&](std::size_t i, std::size_t) {
            alpha_options how = options_.alpha;
            if (!options_.part_thresholds.empty()) {
                how.thresholds = options_.part_thresholds[cloud_.part_of(plane_of[i])];
            }
            choose_alpha(drawn_.tiles[i], how);
        });
    }

    [[nodiscard]] tile_picture* back_of(plane_id id) noexcept {
        const bool has_back = !drawn_.back_of.empty() && drawn_.back_of[id] != no_id;
        return has_back ? &drawn_.tiles[drawn_.back_of[id]] : nullptr;
    }

    /// Cuts off rows and columns that are nowhere opaque, from tiles and billboards.
    void crop() {
        for (plane_id id = 0; id < cloud_.billboards.size(); ++id) {
            tile_picture& front = drawn_.tiles[id];
            tile_picture* back = back_of(id);
            texel_box box = drawn_box(front);
            if (back != nullptr) box = joined(box, mirrored(drawn_box(*back), back->width));
            if (box.width == 0) box = {0, 0, 1, 1};
            front.box = box;
            if (back != nullptr) back->box = mirrored(box, back->width);
            billboard& b = cloud_.billboards[id];
            const double below = front.height - box.y - box.height;
            b.origin +=
                b.axes.u * (box.x * drawn_.texel_size) + b.axes.v * (below * drawn_.texel_size);
            b.width = box.width * drawn_.texel_size;
            b.height = box.height * drawn_.texel_size;
        }
    }

    void find_outlines() {
        if (options_.outline_corners == 0) return;
        drawn_.outlines.resize(cloud_.billboards.size());
        threads_.for_chunks(cloud_.billboards.size(), 1, [&](std::size_t i, std::size_t) {
            const auto id = static_cast<plane_id>(i);
            std::vector<dvec2> corners;
            add_drawn_corners(drawn_.tiles[id], false, corners);
            if (const tile_picture* back = back_of(id)) add_drawn_corners(*back, true, corners);
            const texel_box& box = drawn_.tiles[id].box;
            drawn_.outlines[id] = outline_around(std::move(corners), {box.width, box.height},
                                                 options_.outline_corners);
        });
    }

    void measure_areas() {
        for (plane_id id = 0; id < cloud_.billboards.size(); ++id) {
            const tile_picture& front = drawn_.tiles[id];
            for (std::size_t i = 0; i < front.texel_count(); ++i) {
                drawn_.opaque_area += front.alpha(i) >= 128;
            }
            const double box = static_cast<double>(front.box.width) * front.box.height;
            drawn_.polygon_area +=
                drawn_.outlines.empty() ? box : box * 0.5 * doubled_area(drawn_.outlines[id]);
        }
    }

    billboard_cloud& cloud_;
    const face_table& faces_;
    const bake_options& options_;
    draw_options draw_;
    parallel threads_;
    const progress_function& progress_;
    surface look_;
    sky_table sky_{};
    drawn_tiles drawn_{};
};

/// Empties channels that hold what a reader would assume without them.
inline void drop_if_all(baked_cloud& baked, image atlas::*channel, const std::array<int, 3>& low,
                        const std::array<int, 3>& high) {
    for (const atlas& a : baked.atlases) {
        const image& values = a.*channel;
        for (std::size_t i = 0; i < a.base_color.bytes.size() / 4; ++i) {
            if (a.base_color.bytes[4 * i + 3] == 0) continue;
            for (std::size_t c = 0; c < 3; ++c) {
                const int value = values.bytes[3 * i + c];
                if (value < low[c] || value > high[c]) return;
            }
        }
    }
    for (atlas& a : baked.atlases) a.*channel = {};
}

inline void drop_silent_channels(baked_cloud& baked) {
    const bool is_tangent_space =
        baked.normals == normal_style::folded || baked.normals == normal_style::sheets;
    if (is_tangent_space) drop_if_all(baked, &atlas::normal, {127, 127, 254}, {129, 129, 255});
    drop_if_all(baked, &atlas::occlusion_roughness_metallic, {255, 255, 0}, {255, 255, 0});
    drop_if_all(baked, &atlas::emissive, {0, 0, 0}, {0, 0, 0});
}

}  // namespace detail

/// Draws the tiles of a cloud's billboards. Each billboard shows its mapped and also-drawn faces and
/// all others of its part that are valid for its plane or, if wanted, reach into its envelope, seen
/// from its front, within the depth of the first two kinds.
///
/// Needs  `faces` is the table of `source`; billboards as fit_billboards gives them.
/// Gives  tiles; `cloud.billboards` are moved to whole texels and cropped to what is opaque, so that
///        every texel covers a square of texel_size. That is what options ask for, or more where a
///        tile would not fit into an atlas.
/// Cost   O(samples × faces that overlap), parallel over bands of tiles; 15 bytes a texel, and for
///        each thread 8 bytes a sample of a band.
/// Source Luksch 2009, section 4.5. Differs: faces that are merely valid are drawn, too.
[[nodiscard]] inline drawn_tiles draw_tiles(const mesh& source, const face_table& faces,
                                            billboard_cloud& cloud,
                                            const bake_options& options = {}, parallel threads = {},
                                            const progress_function& progress = {}) {
    BILLOW_ASSERT(cloud.billboards.size() == cloud.plane_count());
    BILLOW_ASSERT(cloud.plane_of_face.size() == source.face_count());
    BILLOW_ASSERT(!options.draw.with_horizon || options.occlusion.rays > 0);
    BILLOW_ASSERT(options.texels > 0 && options.padding >= 0);
    BILLOW_ASSERT(options.draw.supersample >= 1 && options.draw.supersample <= max_supersample);
    BILLOW_ASSERT(options.max_atlas > 2 * options.padding + 4);
    BILLOW_ASSERT(options.outline_corners == 0 || options.outline_corners >= 4);
    BILLOW_ASSERT(options.draw.envelope_scale > 0 && options.draw.envelope_scale <= 1);
    BILLOW_ASSERT(options.part_thresholds.empty() ||
                  options.part_thresholds.size() >= cloud.parts.size());
    return detail::tile_baker(source, cloud, faces, options, threads, progress).run();
}

/// Packs drawn tiles into atlases and gives colours to what is transparent in them.
///
/// Cost  of the packer, and O(texels), parallel over tiles and rows.
[[nodiscard]] inline baked_cloud pack_tiles(drawn_tiles&& drawn, const bake_options& options,
                                            parallel threads = {}) {
    placed_tiles placed =
        place_tiles(drawn.tiles, packing_of(options), options.draw.normals, threads);
    drawn.tiles.clear();
    baked_cloud baked;
    baked.tiles = std::move(placed.tiles);
    baked.back_of = std::move(drawn.back_of);
    baked.outlines = std::move(drawn.outlines);
    baked.atlases = std::move(placed.atlases);
    baked.normals = options.draw.normals;
    baked.texel_size = drawn.texel_size;
    baked.wanted_size = drawn.wanted_size;
    baked.fill = placed.fill;
    baked.opaque_area = drawn.opaque_area;
    baked.polygon_area = drawn.polygon_area;
    detail::drop_silent_channels(baked);
    fill_borders(baked, placed.is_covered, options.padding, threads);
    return baked;
}

/// draw_tiles, then pack_tiles.
[[nodiscard]] inline baked_cloud bake_cloud(const mesh& source, const face_table& faces,
                                            billboard_cloud& cloud,
                                            const bake_options& options = {}, parallel threads = {},
                                            const progress_function& progress = {}) {
    drawn_tiles drawn = draw_tiles(source, faces, cloud, options, threads, progress);
    report(progress, "bake", 0.85);
    baked_cloud baked = pack_tiles(std::move(drawn), options, threads);
    report(progress, "bake", 1);
    return baked;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/cloud_mesh.hpp
// A baked cloud as a mesh: one or two polygons a billboard, one or two materials an atlas.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// The texture coordinate, from the top left of the atlas, of the point (s, t) of the side that a
/// tile shows: s to the right, t up.
[[nodiscard]] inline dvec2 atlas_uv(const tile& t, const atlas& in, const dvec2& st) noexcept {
    // Upright, t runs up. Turned clockwise, s runs down and t to the right.
    const dvec2 inside = t.is_rotated ? dvec2(st.y, st.x) : dvec2(st.x, 1 - st.y);
    return {(t.x + inside.x * t.width) / in.width(), (t.y + inside.y * t.height) / in.height()};
}

namespace detail {

/// One call of cloud_mesh; its methods are the steps in their order.
class cloud_mesher {
public:
    cloud_mesher(const billboard_cloud& cloud, const baked_cloud& baked)
        : cloud_(cloud), baked_(baked), materials_(baked.atlases.size(), {no_id, no_id}) {}

    [[nodiscard]] mesh run() {
        const bool is_scene_space =
            baked_.normals == normal_style::object || baked_.normals == normal_style::dome;
        for (std::size_t i = 0; i < cloud_.billboards.size(); ++i) {
            const std::uint32_t back = baked_.back_tile(i);
            const bool has_two_sides = is_scene_space || back != no_id;
            add_side(i, baked_.tiles[i], false, has_two_sides);
            if (has_two_sides) add_side(i, baked_.tiles[back == no_id ? i : back], true, true);
        }
        return std::move(result_);
    }

private:
    [[nodiscard]] texture add_texture(const image& picture) {
        if (picture.empty()) return {};
        result_.images.push_back(picture);
        return {.image = static_cast<image_id>(result_.images.size() - 1),
                .wrap_u = texture_wrap::clamp_to_edge,
                .wrap_v = texture_wrap::clamp_to_edge};
    }

    [[nodiscard]] material_id material_of(atlas_id id, bool is_single_sided) {
        material_id& known = materials_[id][is_single_sided ? 1 : 0];
        if (known != no_id) return known;
        const material_id other = materials_[id][is_single_sided ? 0 : 1];
        known = static_cast<material_id>(result_.materials.size());
        if (other != no_id) {
            result_.materials.push_back(result_.materials[other]);
        } else {
            const atlas& from = baked_.atlases[id];
            material m;
            m.base_color_texture = add_texture(from.base_color);
            m.normal_texture = add_texture(from.normal);
            m.metallic_roughness_texture = add_texture(from.occlusion_roughness_metallic);
            m.occlusion_texture = m.metallic_roughness_texture;
            m.metallic = m.metallic_roughness_texture.is_present() ? 1.0f : 0.0f;
            m.emissive_texture = add_texture(from.emissive);
            if (m.emissive_texture.is_present()) m.emissive = vec3(1);
            m.alpha = alpha_mode::mask;
            m.alpha_cutoff = 0.5f;
            result_.materials.push_back(std::move(m));
        }
        material& made = result_.materials[known];
        made.name = "atlas_" + std::to_string(id) + (is_single_sided ? "_sides" : "");
        made.is_double_sided = !is_single_sided;
        return known;
    }

    void add_side(std::size_t i, const tile& t, bool is_back, bool is_single_sided) {
        const billboard& b = cloud_.billboards[i];
        static const std::array<dvec2, 4> rectangle{dvec2(0, 0), dvec2(1, 0), dvec2(1, 1),
                                                    dvec2(0, 1)};
        const std::span<const dvec2> outline =
            baked_.outlines.empty() ? std::span<const dvec2>(rectangle) : baked_.outlines[i];
        const bool is_scene_space =
            baked_.normals == normal_style::object || baked_.normals == normal_style::dome;
        // The front's tile on the back is seen through, as on a double-sided polygon.
        const bool has_own_tile = is_back && baked_.back_tile(i) != no_id;
        const vec3 normal(is_back ? -b.axes.normal : b.axes.normal);
        const vec3 right(has_own_tile ? -b.axes.u : b.axes.u);
        const vec3 along = t.is_rotated ? vec3(b.axes.v) : right;
        const float side = is_back && !has_own_tile ? -1.0f : 1.0f;
        const auto first = static_cast<std::uint32_t>(result_.positions.size());
        for (const dvec2& st : outline) {
            result_.positions.push_back(
                vec3(b.origin + b.axes.u * (st.x * b.width) + b.axes.v * (st.y * b.height)));
            // In this frame tangent space is scene space.
            result_.normals.push_back(is_scene_space ? vec3(0, 0, 1) : normal);
            result_.tangents.push_back(is_scene_space ? vec4(1, 0, 0, 1) : vec4(along, side));
            const dvec2 seen = has_own_tile ? dvec2(1 - st.x, st.y) : st;
            result_.uv_sets[0].push_back(vec2(atlas_uv(t, baked_.atlases[t.atlas], seen)));
            result_.feature_ids.push_back(static_cast<std::uint32_t>(i));
        }
        const material_id look = material_of(t.atlas, is_single_sided);
        for (std::uint32_t k = 2; k < outline.size(); ++k) {
            const uvec3 triangle = is_back ? uvec3(first, first + k, first + k - 1)
                                           : uvec3(first, first + k - 1, first + k);
            result_.triangles.push_back(triangle);
            result_.face_materials.push_back(look);
        }
    }

    const billboard_cloud& cloud_;
    const baked_cloud& baked_;
    std::vector<std::array<material_id, 2>> materials_;  ///< of each atlas: double, single sided
    mesh result_{};
};

}  // namespace detail

/// The cloud as textured polygons where the original mesh is: each billboard is a fan of triangles,
/// its corners counter-clockwise from its front: (0,0), (1,0), (1,1), (0,1) of the rectangle, or its
/// outline. Behind it, where the billboard has two sides, the same turned round. Tangents run along
/// the atlas's u axis, and with scene space normals along x. Feature ids are plane ids.
///
/// Needs  tiles of `cloud`.
/// Gives  materials of alpha_mode::mask with their images, for each atlas one that is double sided
///        and one that is not, as far as they are used.
[[nodiscard]] inline mesh cloud_mesh(const billboard_cloud& cloud, const baked_cloud& baked) {
    BILLOW_ASSERT(baked.tiles.size() >= cloud.billboards.size());
    return detail::cloud_mesher(cloud, baked).run();
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/mips.hpp
// Mip levels of baked atlases: as much of every tile is drawn on each level, and tiles never mix.
//
// Alpha is scaled for each tile and level by itself, see alpha_coverage.hpp: with one factor for a
// whole atlas dense tiles would grow where thin ones vanish.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>


namespace billow::inline BILLOW_ABI {

struct mip_options {
    int padding = 8;      ///< texels around each tile, as they were baked
    float cutoff = 0.5f;  ///< alpha from which on a texel is drawn
    int levels = 0;       ///< how many, the atlas itself counted; 0: down to 1 × 1
};

/// The levels of an atlas, channel by channel. Level 0 is the atlas itself, each further one half as
/// large, rounded down, at least 1. A channel that the atlas lacks has no levels.
struct atlas_mips {
    std::vector<image> base_color{};
    std::vector<image> normal{};
    std::vector<image> occlusion_roughness_metallic{};
    std::vector<image> emissive{};
    std::vector<image> horizon{};
    int safe_levels = 1;  ///< see safe_mip_levels
};

/// How many levels of an atlas of this size can be drawn, level 0 counted, before a bilinear filter
/// at a tile's edge reads what belongs to another tile: 1 + log2(padding) where sides are powers of
/// two. Half a texel beyond the edge is read at most, so the middle of the farthest texel read lies
/// less than a texel of that level away, and within the padding when that is as wide.
[[nodiscard]] inline int safe_mip_levels(int padding, int width, int height) noexcept {
    int count = 1;
    for (int w = width, h = height; w > 1 || h > 1; ++count) {
        w = std::max(1, w / 2);
        h = std::max(1, h / 2);
        // In 64 bits: a texel of that level is width / w wide and height / h high.
        if (std::int64_t{padding} * w < width || std::int64_t{padding} * h < height) break;
    }
    return count;
}

namespace detail {

/// A level of an atlas: whose texels are, and their alpha before it is scaled.
struct mip_layout {
    int width = 0;
    int height = 0;
    std::vector<std::uint32_t> owner{};  ///< tile, no_id between them
    std::vector<float> alpha{};
    std::vector<pixel_rectangle>
        owned{};  ///< texels of each tile; empty for those of other atlases
};

/// The texels of a level whose middles lie within `area`, texels of level 0. By the middle, not by
/// the larger share: at a corner a neighbour along an edge may have the larger one.
[[nodiscard]] inline pixel_rectangle owned_texels(const pixel_rectangle& area, const ivec2& base,
                                                  const ivec2& level) noexcept {
    const auto first = [](int at, int from, int to) {  // i + 0.5 >= at * to / from
        const std::int64_t twice = std::int64_t{2} * at * to - from;
        return twice <= 0 ? 0 : static_cast<int>((twice + 2 * from - 1) / (2 * from));
    };
    const ivec2 low(first(area.x, base.x, level.x), first(area.y, base.y, level.y));
    const ivec2 high(first(area.x + area.width, base.x, level.x),
                     first(area.y + area.height, base.y, level.y));
    return {low.x, low.y, high.x - low.x, high.y - low.y};
}

/// One call of make_mips for one atlas; its methods are the steps in their order.
class mip_maker {
public:
    mip_maker(const baked_cloud& baked, atlas_id id, const mip_options& options, parallel threads)
        : baked_(baked), atlas_(baked.atlases[id]), id_(id), options_(options), threads_(threads) {}

    [[nodiscard]] atlas_mips run() {
        lay_out();
        atlas_mips mips;
        mips.safe_levels = safe_mip_levels(options_.padding, atlas_.width(), atlas_.height());
        const auto colour = [](const std::uint8_t* p) {
            const auto& light = linear_of_srgb_byte();
            return vec4(light[p[0]], light[p[1]], light[p[2]], 0);
        };
        const auto colour_bytes = [](const vec4& v, std::uint8_t* p) {
            for (int c = 0; c < 3; ++c) p[c] = srgb_byte_from_linear(v[c]);
        };
        mips.base_color = levels_of(atlas_.base_color, colour, colour_bytes);
        keep_coverage(mips.base_color);
        mips.emissive = levels_of(atlas_.emissive, colour, colour_bytes);
        mips.normal = levels_of(
            atlas_.normal,
            [](const std::uint8_t* p) {
                return vec4(vec3(p[0], p[1], p[2]) * (2.0f / 255.0f) - 1.0f, 0);
            },
            [](const vec4& v, std::uint8_t* p) {
                const float length = glm::length(vec3(v));
                const vec3 n = length > 1e-6f ? vec3(v) / length : vec3(0, 0, 1);
                for (int c = 0; c < 3; ++c) p[c] = byte_from_unit(n[c] * 0.5f + 0.5f);
            });
        mips.occlusion_roughness_metallic = levels_of(
            atlas_.occlusion_roughness_metallic,
            [](const std::uint8_t* p) { return vec4(p[0], p[1], p[2], 0) / 255.0f; },
            [](const vec4& v, std::uint8_t* p) {
                for (int c = 0; c < 3; ++c) p[c] = byte_from_unit(v[c]);
            });
        // Cones are averaged as the directions that they let through.
        mips.horizon = levels_of(
            atlas_.horizon,
            [](const std::uint8_t* p) {
                const horizon_cone cone = decode_horizon(p);
                const float visible = (1 - cone.cosine) / 2;
                return vec4(cone.axis * visible, visible);
            },
            [](const vec4& v, std::uint8_t* p) {
                const auto bytes = encode_horizon(cone_of(v));
                std::copy(bytes.begin(), bytes.end(), p);
            });
        return mips;
    }

private:
    void lay_out() {
        const ivec2 base(atlas_.width(), atlas_.height());
        ivec2 size = base;
        while (true) {
            mip_layout& level = layouts_.emplace_back();
            level.width = size.x;
            level.height = size.y;
            const auto texels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
            level.owner.assign(texels, no_id);
            level.owned.resize(baked_.tiles.size());
            for (std::uint32_t t = 0; t < baked_.tiles.size(); ++t) {
                if (baked_.tiles[t].atlas != id_) continue;
                const auto area = padded(baked_.tiles[t], atlas_, options_.padding);
                const auto owned = level.owned[t] = owned_texels(area, base, size);
                for (int y = owned.y; y < owned.y + owned.height; ++y) {
                    std::fill_n(level.owner.begin() + std::ptrdiff_t{y} * size.x + owned.x,
                                owned.width, t);
                }
            }
            level.alpha.resize(texels);
            if (layouts_.size() == 1) {
                for (std::size_t i = 0; i < texels; ++i) {
                    level.alpha[i] =
                        static_cast<float>(atlas_.base_color.bytes[4 * i + 3]) / 255.0f;
                }
            } else {
                const mip_layout& above = layouts_[layouts_.size() - 2];
                for_texels(above, level, [&](std::size_t at, const auto& visit) {
                    float sum = 0;
                    float weight = 0;
                    visit([&](std::size_t i, float w) {
                        sum += w * above.alpha[i];
                        weight += w;
                    });
                    level.alpha[at] = sum / weight;
                });
            }
            const bool is_last = static_cast<int>(layouts_.size()) == options_.levels;
            if (is_last || (size.x == 1 && size.y == 1)) return;
            size = ivec2(std::max(1, size.x / 2), std::max(1, size.y / 2));
        }
    }

    /// Calls `body(texel, visit)` for every texel of `below`; `visit(take)` calls `take(i, weight)`
    /// for the texels of `above` under it that belong to its tile, or for all where none does.
    template <class Body>
    void for_texels(const mip_layout& above, const mip_layout& below, const Body& body) const {
        const auto columns = box_taps_of(above.width, below.width);
        const auto rows = box_taps_of(above.height, below.height);
        const auto width = static_cast<std::size_t>(below.width);
        threads_.for_chunks(rows.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t at = begin * width; at < end * width; ++at) {
                const box_taps& row = rows[at / width];
                const box_taps& column = columns[at % width];
                body(at, [&](const auto& take) {
                    for (const bool takes_all : {false, true}) {
                        bool has_taken = false;
                        for (int k = 0; k < row.count * column.count; ++k) {
                            const auto x = static_cast<std::size_t>(k % column.count);
                            const auto y = static_cast<std::size_t>(k / column.count);
                            const std::size_t i = (static_cast<std::size_t>(row.first) + y) *
                                                      static_cast<std::size_t>(above.width) +
                                                  static_cast<std::size_t>(column.first) + x;
                            if (!takes_all && above.owner[i] != below.owner[at]) continue;
                            take(i, row.weight[y] * column.weight[x]);
                            has_taken = true;
                        }
                        if (has_taken) return;
                    }
                });
            }
        });
    }

    /// The mean of a level's values under each texel of the next, weighted by alpha; of the borders'
    /// values where all is transparent.
    template <class Value>
    [[nodiscard]] std::vector<vec4> lowered(std::size_t level, const Value& value) const {
        const mip_layout& above = layouts_[level - 1];
        std::vector<vec4> result(layouts_[level].alpha.size());
        for_texels(above, layouts_[level], [&](std::size_t at, const auto& visit) {
            vec4 seen(0);
            vec4 all(0);
            float seen_weight = 0;
            float all_weight = 0;
            visit([&](std::size_t i, float w) {
                const vec4 v = value(i);
                const float a = w * above.alpha[i];
                seen += v * a;
                seen_weight += a;
                all += v * w;
                all_weight += w;
            });
            result[at] = seen_weight > 0 ? seen / seen_weight : all / all_weight;
        });
        return result;
    }

    template <class Decode, class Encode>
    [[nodiscard]] std::vector<image> levels_of(const image& source, const Decode& decode,
                                               const Encode& encode) const {
        std::vector<image> chain;
        if (source.empty()) return chain;
        chain.push_back(source);
        const auto channels = static_cast<std::size_t>(source.channels);
        std::vector<vec4> values;
        for (std::size_t level = 1; level < layouts_.size(); ++level) {
            values = level == 1 ? lowered(level,
                                          [&](std::size_t i) {
                                              return decode(source.bytes.data() + i * channels);
                                          })
                                : lowered(level, [&](std::size_t i) { return values[i]; });
            image& to = chain.emplace_back(
                image::filled(layouts_[level].width, layouts_[level].height, source.channels, 0));
            threads_.for_chunks(values.size(), 4096, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    encode(values[i], to.bytes.data() + i * channels);
                }
            });
        }
        return chain;
    }

    /// Writes alpha, scaled so that as much of each tile is drawn as on level 0.
    void keep_coverage(std::vector<image>& chain) const {
        for (std::size_t level = 1; level < layouts_.size(); ++level) {
            const std::vector<float>& alpha = layouts_[level].alpha;
            for (std::size_t i = 0; i < alpha.size(); ++i) {
                chain[level].bytes[4 * i + 3] = byte_from_unit(alpha[i]);
            }
        }
        threads_.for_chunks(baked_.tiles.size(), 1, [&](std::size_t t, std::size_t) {
            const tile& in = baked_.tiles[t];
            if (in.atlas != id_) return;
            const dvec2 low(in.x, in.y);
            const dvec2 high = low + dvec2(in.width, in.height);
            const double wanted = drawn_area(block_of(0, t), low, high, 1, options_.cutoff);
            for (std::size_t level = 1; level < layouts_.size(); ++level) {
                const alpha_block block = block_of(level, t);
                if (block.width <= 0 || block.height <= 0) continue;
                const dvec2 shrink(static_cast<double>(layouts_[level].width) / atlas_.width(),
                                   static_cast<double>(layouts_[level].height) / atlas_.height());
                const float scale = alpha_scale(block, low * shrink, high * shrink,
                                                wanted * shrink.x * shrink.y, options_.cutoff);
                for (int y = block.y; y < block.y + block.height; ++y) {
                    for (int x = block.x; x < block.x + block.width; ++x) {
                        chain[level].pixel(x, y)[3] = byte_from_unit(block.at(x, y) * scale);
                    }
                }
            }
        });
    }

    [[nodiscard]] alpha_block block_of(std::size_t level, std::size_t t) const noexcept {
        const mip_layout& in = layouts_[level];
        const pixel_rectangle& owned = in.owned[t];
        return {in.alpha, in.width, owned.x, owned.y, owned.width, owned.height};
    }

    const baked_cloud& baked_;
    const atlas& atlas_;
    atlas_id id_;
    mip_options options_;
    parallel threads_;
    std::vector<mip_layout> layouts_{};
};

}  // namespace detail

/// The mip levels of every atlas. Colours are averaged in linear light, all channels are weighted by
/// alpha, normals have unit length again, and each texel is made of one tile's texels alone: of the
/// tile in whose padding its middle lies.
///
/// Of a tile, an alpha test draws the same area on every safe level to within 2 % as long as some
/// twenty texels of it are drawn; fewer are too coarse to say it.
///
/// Needs  what fill_borders has filled, tiles whose paddings do not overlap; cutoff in (0, 1].
/// Cost   O(texels), parallel over rows and tiles; 16 bytes a texel of the atlas while it works.
[[nodiscard]] inline std::vector<atlas_mips> make_mips(const baked_cloud& baked,
                                                       const mip_options& options = {},
                                                       parallel threads = {}) {
    BILLOW_ASSERT(options.padding >= 0 && options.levels >= 0);
    BILLOW_ASSERT(options.cutoff > 0 && options.cutoff <= 1);
    std::vector<atlas_mips> mips;
    for (atlas_id id = 0; id < baked.atlases.size(); ++id) {
        mips.push_back(detail::mip_maker(baked, id, options, threads).run());
    }
    return mips;
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/metrics/baselines.hpp
// What users would take in a cloud's place: crossed quads, one flat quad, a mesh of fewer triangles.
//
// Quads in a cross are how games draw distant trees; "Approach geometry/image for rendering forest
// in real time", IJMA 3(3), 2011, section 4, has forests of single quads and of eight crossed ones.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// ---- billow/metrics/draw_cost.hpp
// What it costs to keep a mesh and to draw it: triangles, bytes of textures, fragments.

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// ---- billow/metrics/statistic.hpp
// A number for each view, in three that tell: the mean, what nearly all stay below, and the worst.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>


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

namespace billow::inline BILLOW_ABI {

/// Bytes of images that are neither packed nor compressed, with the channels they have.
struct texture_bytes {
    std::uint64_t level_0 = 0;
    std::uint64_t with_mips = 0;  ///< all levels down to 1 × 1, sides halved and rounded down

    texture_bytes& operator+=(const texture_bytes& other) noexcept {
        level_0 += other.level_0;
        with_mips += other.with_mips;
        return *this;
    }
    [[nodiscard]] bool operator==(const texture_bytes&) const = default;
};

[[nodiscard]] inline texture_bytes texture_bytes_of(const image& of) noexcept {
    if (of.empty()) return {};
    texture_bytes bytes;
    auto width = static_cast<std::uint64_t>(of.width);
    auto height = static_cast<std::uint64_t>(of.height);
    const auto channels = static_cast<std::uint64_t>(of.channels);
    bytes.level_0 = width * height * channels;
    bytes.with_mips = bytes.level_0;
    while (width > 1 || height > 1) {
        width = std::max<std::uint64_t>(1, width / 2);
        height = std::max<std::uint64_t>(1, height / 2);
        bytes.with_mips += width * height * channels;
    }
    return bytes;
}

/// Of all images of a mesh: of an original's, or of those that a cloud's mesh has brought along.
[[nodiscard]] inline texture_bytes texture_bytes_of(const mesh& of) noexcept {
    texture_bytes bytes;
    for (const image& i : of.images) bytes += texture_bytes_of(i);
    return bytes;
}

/// Of all channels of all atlases.
[[nodiscard]] inline texture_bytes texture_bytes_of(const baked_cloud& of) noexcept {
    texture_bytes bytes;
    for (const atlas& a : of.atlases) {
        bytes += texture_bytes_of(a.base_color);
        bytes += texture_bytes_of(a.normal);
        bytes += texture_bytes_of(a.occlusion_roughness_metallic);
        bytes += texture_bytes_of(a.emissive);
        bytes += texture_bytes_of(a.horizon);
    }
    return bytes;
}

struct draw_cost {
    std::size_t triangles = 0;
    texture_bytes textures{};
};

[[nodiscard]] inline draw_cost draw_cost_of(const mesh& of) noexcept {
    return {of.face_count(), texture_bytes_of(of)};
}

/// What a view counts of the fragments it draws, such as `render_counts`.
template <class C>
concept fragment_counts = requires(const C& counts) {
    { counts.overdraw() } -> std::convertible_to<double>;
};

/// Fragments drawn for each pixel covered, over views.
template <fragment_counts Counts>
[[nodiscard]] statistic overdraw_over(std::span<const Counts> views) {
    std::vector<double> values;
    values.reserve(views.size());
    for (const Counts& counts : views) values.push_back(counts.overdraw());
    return statistic_of(values);
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Makes a mesh of about a share of the triangles: reduce_mesh, or any other.
struct mesh_reducer {
    std::string_view name{};
    mesh (*reduce)(const mesh&, double share) = nullptr;
};

/// A stand-in for a mesh, by name.
struct baseline {
    std::string name{};
    billow::mesh mesh{};
};

struct baseline_options {
    std::size_t triangles = 0;              ///< of the cloud, which reduced meshes may have, > 0
    std::uint64_t bytes = 0;                ///< of the cloud, as stored_bytes_of says, > 0
    std::vector<int> quads = {1, 2, 3, 8};  ///< each a baseline of so many quads, ≥ 1
    std::vector<mesh_reducer>
        reducers{};       ///< each a baseline at equal triangles and at equal bytes
    bake_options bake{};  ///< of quads; texels follow `bytes`
};

/// Columns of vertices, indices of 4 bytes, and images as they are, without mips.
[[nodiscard]] inline std::uint64_t stored_bytes_of(const mesh& of) noexcept {
    std::uint64_t bytes = texture_bytes_of(of).level_0 + of.triangles.size() * sizeof(uvec3);
    detail::for_each_vertex_column(of, of, [&](const auto& column, const auto&) {
        bytes += column.size() * sizeof column[0];
    });
    return bytes;
}

namespace detail {

/// Horizontal normals in even steps of half a turn together. The first has the greatest sum of
/// squared cosines to the faces' normals, weighted by area: the broad side of a wall.
[[nodiscard]] inline std::vector<dvec3> crossed_normals(const face_table& faces, int count) {
    double xx = 0;
    double xz = 0;
    double zz = 0;
    for (std::uint32_t row = 0; row < faces.size; ++row) {
        const dvec3 n = faces.normal.get(row);
        const auto area = static_cast<double>(faces.area[row]);
        xx += area * n.x * n.x;
        xz += area * n.x * n.z;
        zz += area * n.z * n.z;
    }
    const double first = 0.5 * std::atan2(2 * xz, zz - xx);
    std::vector<dvec3> normals;
    for (int i = 0; i < count; ++i) {
        const double angle = first + std::numbers::pi * i / count;
        normals.emplace_back(std::sin(angle), 0, std::cos(angle));
    }
    return normals;
}

/// Quads as a cloud, each of which shows every face.
[[nodiscard]] inline billboard_cloud crossed_cloud(const mesh& of, const face_table& faces,
                                                   int count, parallel threads) {
    billboard_cloud cloud;
    cloud.bounds = faces.bounds;
    cloud.epsilon = 2 * faces.bounds.radius;
    for (const dvec3& normal : crossed_normals(faces, count)) cloud.planes.push_back({normal, 0});
    cloud.plane_of_face.assign(of.face_count(), no_id);
    for (std::uint32_t row = 0; row < faces.size; ++row) {
        const auto cosine = [&](const plane& p) {
            return std::abs(glm::dot(p.normal, faces.normal.get(row)));
        };
        const auto best = std::ranges::max_element(cloud.planes, {}, cosine);
        cloud.plane_of_face[faces.source[row]] = static_cast<plane_id>(best - cloud.planes.begin());
    }
    for (plane_id id = 0; id < cloud.plane_count(); ++id) {
        for (face_id face = 0; face < of.face_count(); ++face) {
            const plane_id own = cloud.plane_of_face[face];
            if (own != id && own != no_id) cloud.also_drawn.push_back({id, face});
        }
    }
    fit_billboards(of, cloud, threads);
    return cloud;
}

/// Halves all images of a mesh until they take at most so many bytes; they become RGBA.
inline void shrink_textures(mesh& of, std::uint64_t bytes) {
    std::vector<texel_kind> kinds(of.images.size(), texel_kind::linear);
    const auto set = [&](const texture& t, texel_kind kind) {
        if (t.image < kinds.size()) kinds[t.image] = kind;
    };
    for (const material& m : of.materials) {
        set(m.emissive_texture, texel_kind::srgb);
        set(m.base_color_texture,
            m.alpha == alpha_mode::opaque ? texel_kind::srgb : texel_kind::srgb_alpha);
    }
    const auto halve = [&](std::size_t i) {
        image& of_mesh = of.images[i];
        if (of_mesh.width * of_mesh.height <= 1) return false;
        of_mesh = std::move(make_mip_chain(of_mesh, kinds[i])[1]);
        return true;
    };
    for (bool is_halved = true; is_halved && texture_bytes_of(of).level_0 > bytes;) {
        is_halved = false;
        for (std::size_t i = 0; i < of.images.size(); ++i) is_halved |= halve(i);
    }
}

/// The reduced mesh of most bytes that takes no more than so many, where the reducer gets there.
[[nodiscard]] inline mesh reduced_to_bytes(mesh of, const mesh_reducer& by, std::uint64_t bytes) {
    shrink_textures(of, bytes / 2);
    const std::uint64_t textures = texture_bytes_of(of).level_0;
    const auto allowed = static_cast<double>(bytes - std::min(bytes, textures));
    const auto geometry_of = [&](const mesh& m) {
        return static_cast<double>(stored_bytes_of(m) - texture_bytes_of(m).level_0);
    };
    double share = allowed / geometry_of(of);
    if (share >= 1) return of;
    const double least = 1 / static_cast<double>(of.face_count());
    mesh best;
    for (int i = 0; i < 4; ++i) {
        share = std::clamp(share, least, 1.0);
        mesh tried = by.reduce(of, share);
        const double geometry = geometry_of(tried);
        const bool fits = geometry <= allowed;
        if (i == 0 || (fits && geometry > geometry_of(best)) || geometry_of(best) > allowed) {
            best = std::move(tried);
        }
        if (fits && geometry > 0.9 * allowed) break;
        if (share <= least) break;
        share *= geometry > 0 ? std::clamp(0.97 * allowed / geometry, 0.1, 4.0) : 4.0;
    }
    return best;
}

}  // namespace detail

/// Upright quads through the middle of a mesh, turned evenly about the y axis, each of which shows all
/// of it. One quad is seen from its front as the mesh is, and from its edge not at all; the first one
/// lies along the mesh's broad side.
///
/// Needs   count ≥ 1; `faces` is the table of `of`.
/// Gives   a mesh as cloud_mesh makes it: two triangles a quad, seen from both sides.
/// Cost    as bake_cloud with all faces on every plane.
[[nodiscard]] inline mesh crossed_quads(const mesh& of, const face_table& faces, int count,
                                        const bake_options& options = {}, parallel threads = {}) {
    BILLOW_ASSERT(count >= 1);
    if (faces.size == 0) return {};
    billboard_cloud cloud = detail::crossed_cloud(of, faces, count, threads);
    const baked_cloud baked = bake_cloud(of, faces, cloud, options, threads);
    return cloud_mesh(cloud, baked);
}

/// crossed_quads with as many texels as give about so many bytes, stored_bytes_of; of the few tries
/// the nearest.
///
/// Needs, Cost  as crossed_quads, at most four times.
[[nodiscard]] inline mesh crossed_quads_of_bytes(const mesh& of, const face_table& faces, int count,
                                                 std::uint64_t bytes, bake_options options = {},
                                                 parallel threads = {}) {
    const auto wanted = static_cast<double>(bytes);
    options.texels = 128;
    options.texels_per_unit = 0;
    mesh best;
    double least_miss = std::numeric_limits<double>::infinity();
    for (int tries = 0; tries < 4; ++tries) {
        mesh tried = crossed_quads(of, faces, count, options, threads);
        const auto found = static_cast<double>(stored_bytes_of(tried));
        if (const double miss = std::abs(found - wanted); miss < least_miss) {
            least_miss = miss;
            best = std::move(tried);
        }
        if (faces.size == 0 || std::abs(found - wanted) < 0.03 * wanted) break;
        const int next =
            std::clamp(static_cast<int>(std::lround(options.texels * std::sqrt(wanted / found))), 4,
                       options.max_atlas - 2 * options.padding - 4);
        if (next == options.texels) break;
        options.texels = next;
    }
    return best;
}

/// All stand-ins: quads with textures of about the cloud's bytes; each reducer's mesh of the cloud's
/// triangles, and of its bytes. For the latter textures are halved until they take at most half of
/// the bytes, the triangles get the rest.
///
/// Needs   an original that validate() accepts, with a face; options as they say.
/// Gives   names "1 quad", "8 quads", "<reducer>, equal triangles", "<reducer>, equal bytes". Where a
///         reducer cannot reach so few triangles its mesh is larger, which costs tell.
/// Cost    of the parts.
[[nodiscard]] inline std::vector<baseline> make_baselines(const mesh& original,
                                                          const baseline_options& options,
                                                          parallel threads = {}) {
    BILLOW_ASSERT(options.triangles > 0 && options.bytes > 0 && original.face_count() > 0);
    const expected<face_table> faces = make_face_table(original, threads);
    BILLOW_ASSERT(faces.has_value());
    std::vector<baseline> made;
    for (const int count : options.quads) {
        made.push_back({std::to_string(count) + (count == 1 ? " quad" : " quads"),
                        crossed_quads_of_bytes(original, *faces, count, options.bytes, options.bake,
                                               threads)});
    }
    const double share = std::min(
        1.0, static_cast<double>(options.triangles) / static_cast<double>(original.face_count()));
    for (const mesh_reducer& by : options.reducers) {
        const std::string name(by.name);
        made.push_back({name + ", equal triangles", by.reduce(original, share)});
        made.push_back(
            {name + ", equal bytes", detail::reduced_to_bytes(original, by, options.bytes)});
    }
    return made;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/camera.hpp
// Where a picture is taken from.

#include <algorithm>
#include <cmath>


namespace billow::inline BILLOW_ABI {

/// A camera with square pixels.
struct camera {
    frame axes{};          ///< u to the right, v up in the picture, the normal to the viewer
    dvec3 eye{0, 0, 4};    ///< of an orthographic camera: any point seen in the picture's middle
    double height = 0.55;  ///< of the picture in scene units; of a perspective one at distance 1
    double near_distance = 1e-3;  ///< perspective: what is nearer along -axes.normal is not seen
    bool is_orthographic = false;
    int width_px = 512;
    int height_px = 512;
};

namespace detail {

/// Axes of a view from the direction `from` (any length), +Y up, or ∓Z where that is the view.
[[nodiscard]] inline frame upright_frame(const dvec3& from) noexcept {
    const dvec3 normal = glm::normalize(from);
    const bool is_vertical = std::abs(normal.y) > 0.999;
    const dvec3 up = is_vertical ? dvec3(0, 0, normal.y > 0 ? -1 : 1) : dvec3(0, 1, 0);
    const dvec3 u = glm::normalize(glm::cross(up, normal));
    return {u, glm::cross(normal, u), normal};
}

/// So much larger than a sphere is the view that frames it.
inline constexpr double framing_margin = 1.02;

}  // namespace detail

/// A perspective camera at `eye` that looks at another point.
///
/// Unit   `fov_rad`: the angle from the lower to the upper edge.
/// Needs  eye ≠ look_at, 0 < fov_rad < π, near_distance > 0.
[[nodiscard]] inline camera perspective_camera(const dvec3& eye, const dvec3& look_at,
                                               double fov_rad, int width_px = 512,
                                               int height_px = 512, double near_distance = 1e-3) {
    BILLOW_ASSERT(near_distance > 0 && fov_rad > 0 && fov_rad < 3.1415);
    const double height = 2 * std::tan(0.5 * fov_rad);
    return {detail::upright_frame(eye - look_at),
            eye,
            height,
            near_distance,
            false,
            width_px,
            height_px};
}

/// A perspective camera that sees a whole sphere from outside: at `distance` radii R from the centre
/// its outline has the half angle asin(1 / distance), and the square picture is 2 % larger:
/// height = 2 · 1.02 / √(distance² - 1).
///
/// Needs  distance > 1.
[[nodiscard]] inline camera orbit_camera(const bounding_sphere& sphere, const dvec3& direction,
                                         double distance = 4, int size_px = 512) {
    BILLOW_ASSERT(distance > 1);
    const double radius = sphere.radius > 0 ? sphere.radius : 1.0;
    const frame axes = detail::upright_frame(direction);
    const double height = 2 * detail::framing_margin / std::sqrt(distance * distance - 1);
    return {axes,   sphere.centre + axes.normal * (distance * radius),
            height, 0.01 * (distance - 1) * radius,
            false,  size_px,
            size_px};
}

/// An orthographic camera that sees a whole sphere from the direction `from` (any length).
[[nodiscard]] inline camera view_of(const bounding_sphere& sphere, const dvec3& from,
                                    int width_px = 512, int height_px = 512) {
    const double radius = sphere.radius > 0 ? sphere.radius : 1.0;
    const double shorter = std::min(1.0, static_cast<double>(width_px) / height_px);
    const double height = 2 * detail::framing_margin * radius / shorter;
    return {detail::upright_frame(from), sphere.centre, height, 0, true, width_px, height_px};
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/channel.hpp
// One float a pixel, and filters that work along rows and columns.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>


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
// ---- billow/metrics/color_error.hpp
// How far a cloud's colours are from its original's, as the eye counts it.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 3.4, Color Error.

#include <algorithm>
#include <array>
#include <cmath>

// ---- billow/metrics/lab.hpp
// CIE L*a*b* of linear light, and the difference of two colours.
//
// CIE 15:2004, Colorimetry. The matrix of sRGB's primaries under D65 is that of B. Lindbloom,
// brucelindbloom.com, whom the thesis of Luksch (2009, section 3.4) converts by.


namespace billow::inline BILLOW_ABI {

/// Three coordinates of a colour, each a float or a pack of them.
template <class V>
struct color_lanes {
    V x{};
    V y{};
    V z{};
};

/// CIE XYZ over that of white (D65), so that white is (1, 1, 1), of linear sRGB light.
template <class V>
[[nodiscard]] color_lanes<V> relative_xyz(const color_lanes<V>& linear) noexcept {
    constexpr float white_x = 0.9504700f;
    constexpr float white_z = 1.0888300f;
    const auto [r, g, b] = linear;
    return {r * (0.4124564f / white_x) + g * (0.3575761f / white_x) + b * (0.1804375f / white_x),
            r * 0.2126729f + g * 0.7151522f + b * 0.0721750f,
            r * (0.0193339f / white_z) + g * (0.1191920f / white_z) + b * (0.9503041f / white_z)};
}

/// Linear sRGB light of relative XYZ: the inverse of relative_xyz.
template <class V>
[[nodiscard]] color_lanes<V> linear_of_relative_xyz(const color_lanes<V>& relative) noexcept {
    const V x = relative.x * 0.9504700f;
    const V y = relative.y;
    const V z = relative.z * 1.0888300f;
    return {x * 3.2404542f - y * 1.5371385f - z * 0.4985314f,
            y * 1.8760108f - x * 0.9692660f + z * 0.0415560f,
            x * 0.0556434f - y * 0.2040259f + z * 1.0572252f};
}

/// L* (0 to 100), a* and b* of relative XYZ.
template <class V>
[[nodiscard]] color_lanes<V> lab_of_relative_xyz(const color_lanes<V>& relative) noexcept {
    const auto f = [](V t) {
        constexpr float delta = 6.0f / 29.0f;
        constexpr float knee = delta * delta * delta;
        const V root = simd::cube_root(simd::max(t, simd::lanes<V>::fill(knee)));
        return simd::select(t > knee, root, t * (1 / (3 * delta * delta)) + 4.0f / 29.0f);
    };
    const V x = f(relative.x);
    const V y = f(relative.y);
    const V z = f(relative.z);
    return {y * 116.0f - 16.0f, (x - y) * 500.0f, (y - z) * 200.0f};
}

/// L* (0 to 100), a* and b* of linear sRGB light, white D65.
[[nodiscard]] inline vec3 lab_from_linear(const vec3& linear) noexcept {
    const auto lab =
        lab_of_relative_xyz(relative_xyz(color_lanes<float>{linear.x, linear.y, linear.z}));
    return {lab.x, lab.y, lab.z};
}

/// ΔE*76: the distance of two colours in L*a*b*. About 2.3 is just noticed; black and white are 100
/// apart.
[[nodiscard]] inline double delta_e76(const vec3& lab, const vec3& other) noexcept {
    return glm::distance(dvec3(lab), dvec3(other));
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/view_picture.hpp
// What a view of a scene shows: light and coverage of each pixel, in floats.

#include <cstddef>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// A picture with coverage. Rows from the upper edge down.
///
/// Unit  rgb: linear light, multiplied by the coverage; a: the share of the pixel that is covered,
///       0 to 1, counted in samples, so that what is thinner than a pixel counts by its area.
struct view_picture {
    int width = 0;
    int height = 0;
    std::vector<vec4> pixels{};

    [[nodiscard]] vec4& at(int x, int y) noexcept { return pixels[index_of(x, y)]; }
    [[nodiscard]] const vec4& at(int x, int y) const noexcept { return pixels[index_of(x, y)]; }

    [[nodiscard]] bool operator==(const view_picture&) const = default;

private:
    [[nodiscard]] std::size_t index_of(int x, int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct color_options {
    /// Standard deviation of the blur that the local error is taken after, pixels, > 0. Detail that is
    /// displaced by less is not punished.
    double sigma_px = 8;
};

/// ΔE*76, 0 for the same colours; black and white are 100 apart. 0 where a picture covers nothing.
struct color_errors {
    double mean = 0;    ///< between the mean colours of all that each picture covers: the thesis's
    double common = 0;  ///< between the mean colours of the pixels that both cover
    double local = 0;   ///< mean over what both cover, of the difference after a blur
};

/// A picture, blurred and in squares of `square_px` pixels. Colour times coverage, and coverage.
struct blurred_picture {
    int square_px = 1;
    std::array<channel, 4> channels{};

    [[nodiscard]] vec4 at(int x, int y) const noexcept {
        return {channels[0].at(x, y), channels[1].at(x, y), channels[2].at(x, y),
                channels[3].at(x, y)};
    }
};

/// Blurs colour and coverage alike: means of squares of half a sigma (at least a pixel), then a
/// Gaussian of sigma, cut off at three of them. Finer squares would show the same after such a blur.
/// Beyond the edge the outermost squares are read again.
///
/// Cost  O(pixels).
[[nodiscard]] inline blurred_picture blur(const view_picture& picture,
                                          const color_options& options = {}) {
    BILLOW_ASSERT(options.sigma_px > 0);
    blurred_picture result;
    const int side = std::max(1, static_cast<int>(options.sigma_px / 2));
    result.square_px = side;
    if (picture.pixels.empty()) return result;
    for (channel& c : result.channels) {
        c = channel((picture.width + side - 1) / side, (picture.height + side - 1) / side);
    }
    for (int y = 0; y < result.channels[0].height; ++y) {
        const int last_row = std::min((y + 1) * side, picture.height);
        for (int x = 0; x < result.channels[0].width; ++x) {
            const int last_column = std::min((x + 1) * side, picture.width);
            vec4 sum{0};
            for (int j = y * side; j < last_row; ++j) {
                for (int i = x * side; i < last_column; ++i) sum += picture.at(i, j);
            }
            sum /= static_cast<float>((last_row - y * side) * (last_column - x * side));
            for (int c = 0; c < 4; ++c) {
                result.channels[static_cast<std::size_t>(c)].row(y)[x] = sum[c];
            }
        }
    }
    const auto weights = gaussian_weights(options.sigma_px / side,
                                          static_cast<int>(std::ceil(3 * options.sigma_px / side)));
    for (channel& c : result.channels) c = blurred(c, weights);
    return result;
}

/// ΔE*76 between the mean colours, in linear light, of all that each picture covers. Not pixel by
/// pixel, since textures show detail a little displaced.
///
/// Source  Luksch 2009, section 3.4; whether means are of linear light is left open there.
[[nodiscard]] inline double mean_color_error(const view_picture& original,
                                             const view_picture& cloud) noexcept {
    const auto mean_of = [](const view_picture& picture) {
        std::array<double, 4> sum{};
        for (const vec4& p : picture.pixels) {
            for (std::size_t c = 0; c < 4; ++c) sum[c] += p[static_cast<int>(c)];
        }
        return sum;
    };
    const auto a = mean_of(original);
    const auto b = mean_of(cloud);
    if (!(a[3] > 0 && b[3] > 0)) return 0;
    return delta_e76(lab_from_linear(vec3(dvec3(a[0], a[1], a[2]) / a[3])),
                     lab_from_linear(vec3(dvec3(b[0], b[1], b[2]) / b[3])));
}

/// The same over the pixels that both cover, each weighted by the lesser of its coverages: shading
/// and textures alone, whatever the silhouettes are.
///
/// Needs  pictures of the same size.
[[nodiscard]] inline double common_color_error(const view_picture& original,
                                               const view_picture& cloud) noexcept {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    dvec3 a{0};
    dvec3 b{0};
    double weights = 0;
    for (std::size_t i = 0; i < original.pixels.size(); ++i) {
        const vec4& p = original.pixels[i];
        const vec4& q = cloud.pixels[i];
        if (!(p.a > 0 && q.a > 0)) continue;
        const double weight = std::min(p.a, q.a);
        a += dvec3(p) * (weight / p.a);
        b += dvec3(q) * (weight / q.a);
        weights += weight;
    }
    if (!(weights > 0)) return 0;
    return delta_e76(lab_from_linear(vec3(a / weights)), lab_from_linear(vec3(b / weights)));
}

/// Σw·ΔE*76 / Σw over all squares, between the colours (colour times coverage over coverage) of the
/// blurred pictures; w is the lesser of the blurred coverages. Finds wrong colours in the right
/// amount at the wrong place, which means over a picture do not.
///
/// Needs  pictures of the same size.          Cost  O(pixels).
[[nodiscard]] inline double local_color_error(const blurred_picture& original,
                                              const blurred_picture& cloud) noexcept {
    const channel& a = original.channels[3];
    const channel& b = cloud.channels[3];
    BILLOW_ASSERT(a.width == b.width && a.height == b.height);
    double sum = 0;
    double weights = 0;
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            // Where next to nothing is covered, floats hold no colour.
            const float weight = std::min(a.at(x, y), b.at(x, y));
            if (!(weight > 1e-4f)) continue;
            weights += weight;
            const vec4 p = original.at(x, y);
            const vec4 q = cloud.at(x, y);
            if (p == q) continue;
            sum +=
                weight * delta_e76(lab_from_linear(vec3(p) / p.a), lab_from_linear(vec3(q) / q.a));
        }
    }
    return weights > 0 ? sum / weights : 0;
}

[[nodiscard]] inline color_errors color_error(const view_picture& original,
                                              const view_picture& cloud,
                                              const color_options& options = {}) {
    return {mean_color_error(original, cloud), common_color_error(original, cloud),
            local_color_error(blur(original, options), blur(cloud, options))};
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/compare.hpp
// Clouds compared with their original: every metric from many sides, and what drawing costs.
//
// Luksch, "An improved billboard cloud generation algorithm", 2009, section 5.1: evenly spread views
// of a model, the mean and the worst of each metric.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <thread>
#include <vector>

// ---- billow/metrics/geometric_error.hpp
// How far a cloud moves the vertices of its mesh, in units of the scene, of the object and of a screen.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 3.4, Geometric Error.

#include <cstddef>
#include <span>

// ---- billow/metrics/displacement.hpp
// Where a cloud draws each corner of its mesh, and how far that is from elsewhere.

#include <algorithm>
#include <array>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// The faces of a mesh as a cloud draws them.
///
/// Shape  one row a face of the mesh.
/// Unit   scene units.
struct drawn_faces {
    std::vector<plane_id> plane_of_face{};  ///< of the cloud; no_id: not drawn
    std::vector<std::array<dvec3, 3>> corners{};
};

/// The mesh as it is, on no plane.
[[nodiscard]] inline drawn_faces undisplaced(const mesh& original) {
    drawn_faces result;
    result.plane_of_face.assign(original.face_count(), no_id);
    result.corners.reserve(original.face_count());
    for (face_id face = 0; face < original.face_count(); ++face) {
        const auto [a, b, c] = original.corners(face);
        result.corners.push_back({dvec3(a), dvec3(b), dvec3(c)});
    }
    return result;
}

namespace detail {

/// The foot of the perpendicular from `point` on a plane of the cloud.
[[nodiscard]] inline dvec3 foot_on(const billboard_cloud& cloud, plane_id plane,
                                   const dvec3& point) noexcept {
    const auto& p = cloud.planes[plane];
    return point - p.normal * signed_distance(p, point - cloud.bounds.centre);
}

template <class PlaneOf>
[[nodiscard]] drawn_faces drawn_on(const billboard_cloud& cloud, const drawn_faces& before,
                                   const PlaneOf& plane_of) {
    drawn_faces faces = before;
    for (face_id face = 0; face < faces.corners.size(); ++face) {
        const plane_id plane = plane_of(face);
        faces.plane_of_face[face] = plane;
        if (plane == no_id) continue;
        for (dvec3& corner : faces.corners[face]) corner = foot_on(cloud, plane, corner);
    }
    return faces;
}

}  // namespace detail

/// Where a cloud of the mesh itself draws the faces, of which some corners have `moved` around the
/// cloud's centre before. Needs the original's `undisplaced` faces.
[[nodiscard]] inline drawn_faces drawn_by(const billboard_cloud& cloud, const drawn_faces& original,
                                          std::span<const moved_face> moved = {}) {
    drawn_faces drawn =
        detail::drawn_on(cloud, original, [&](face_id face) { return cloud.plane_of_face[face]; });
    for (const moved_face& m : moved) {
        const plane_id plane = cloud.plane_of_face[m.face];
        if (plane == no_id) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            drawn.corners[m.face][k] =
                detail::foot_on(cloud, plane, m.corners[k] + cloud.bounds.centre);
        }
    }
    return drawn;
}

/// Distances between two drawings of the same faces, scene units.
struct displacement {
    double max = 0;   ///< of any corner; the faces' inner points stay below, being drawn affinely
    double mean = 0;  ///< over a face's corners, area-weighted over the faces
    std::size_t faces = 0;  ///< that the second drawing shows
};

/// How far the faces of `original` move from one drawing to the other, over those that `to` shows.
/// Cost O(faces).
[[nodiscard]] inline displacement displacement_between(const mesh& original,
                                                       const drawn_faces& from,
                                                       const drawn_faces& to) {
    displacement result;
    double area_sum = 0;
    for (face_id face = 0; face < original.face_count(); ++face) {
        if (to.plane_of_face[face] == no_id) continue;
        ++result.faces;
        const auto [a, b, c] = original.corners(face);
        const double area = glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a))) / 2;
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double moved = glm::distance(from.corners[face][k], to.corners[face][k]);
            result.max = std::max(result.max, moved);
            sum += moved;
        }
        result.mean += area * sum / 3;
        area_sum += area;
    }
    if (area_sum > 0) result.mean /= area_sum;
    return result;
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// From where an error is seen.
struct seen_from {
    double distance = 0;  ///< to the cloud's centre, scene units; 0: 4 radii, as the thesis
    lod_screen screen{};
};

/// Displacement of the vertices: the distance to where the cloud draws them, which is the distance to
/// their plane where nothing is welded. The mean weighs each vertex by the area of its faces.
struct geometric_errors {
    double mean = 0;  ///< scene units
    double max = 0;   ///< scene units
    double mean_of_radius = 0;
    double max_of_radius = 0;
    double mean_of_diameter = 0;
    double max_of_diameter = 0;
    double mean_px = 0;       ///< across the view, as large as it looks at the centre's distance
    double max_px = 0;        ///< as large as it can look: at the nearest point of the sphere
    std::size_t undrawn = 0;  ///< faces that are on no plane; they do not count above
};

/// Measures a cloud against the mesh that it was made of, of which some corners have `moved`.
///
/// Shape   cloud.plane_of_face has a row a face of the mesh.
/// Gives   shares of the radius and pixels of 0 where the cloud has no radius.
/// Cost    O(faces), in double.
/// Source  Luksch 2009, section 3.4. The thesis scales by the projection's size, which is mean_px;
///         max_px is a bound, as a switch distance needs it.
[[nodiscard]] inline geometric_errors geometric_error(const mesh& original,
                                                      const billboard_cloud& cloud,
                                                      std::span<const moved_face> moved = {},
                                                      const seen_from& from = {}) {
    const drawn_faces before = undisplaced(original);
    const displacement d = displacement_between(original, before, drawn_by(cloud, before, moved));
    geometric_errors errors{
        .mean = d.mean, .max = d.max, .undrawn = original.face_count() - d.faces};
    const double radius = cloud.bounds.radius;
    if (!(radius > 0)) return errors;
    errors.mean_of_radius = d.mean / radius;
    errors.max_of_radius = d.max / radius;
    errors.mean_of_diameter = errors.mean_of_radius / 2;
    errors.max_of_diameter = errors.max_of_radius / 2;
    const double distance = from.distance > 0 ? from.distance : 4 * radius;
    errors.mean_px = pixels_of_error(d.mean, 0, distance, from.screen);
    errors.max_px = pixels_of_error(d.max, radius, distance, from.screen);
    return errors;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/nearest_planes.hpp
// The planes of a cloud that is known by its mesh alone, and which of them each face may be on.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// The sphere around all corners of faces, as bounding_sphere_of points.
[[nodiscard]] inline bounding_sphere bounding_sphere_of(const mesh& of) {
    return bounding_sphere_of(3 * of.face_count(), [&](std::size_t i) {
        return of.positions[of.triangles[i / 3][static_cast<int>(i % 3)]];
    });
}

/// An original's faces on the planes of a cloud's mesh.
///
/// Shape  `planes.planes` ascends by feature id, without those of parts that are no plane;
///        `planes.plane_of_face` has a row a face of the original. Billboards are left out.
struct nearest_planes {
    billboard_cloud planes{};
    std::vector<std::uint32_t> feature_of_plane{};
    std::size_t kept = 0;  ///< faces that the cloud holds as they are; they are on no plane
};

namespace detail {

/// A triangle on a plane, counter-clockwise in (u, v).
using flat_triangle = std::array<dvec2, 3>;

/// Whether an edge of `a` has all of `b` beyond it, by more than `slack`.
[[nodiscard]] inline bool is_beyond_an_edge(const flat_triangle& a, const flat_triangle& b,
                                            double slack) noexcept {
    for (std::size_t k = 0; k < 3; ++k) {
        const dvec2 edge = a[(k + 1) % 3] - a[k];
        const double limit = -slack * glm::length(edge);
        const auto inside = [&](const dvec2& p) {
            return edge.x * (p.y - a[k].y) - edge.y * (p.x - a[k].x);
        };
        if (std::max({inside(b[0]), inside(b[1]), inside(b[2])}) < limit) return true;
    }
    return false;
}

[[nodiscard]] inline flat_triangle counter_clockwise(flat_triangle t) noexcept {
    const dvec2 p = t[1] - t[0];
    const dvec2 q = t[2] - t[0];
    if (p.x * q.y < p.y * q.x) std::swap(t[1], t[2]);
    return t;
}

/// A plane with the triangles that a cloud's mesh has on it.
struct drawn_plane {
    plane on{};  ///< relative to the original's centre
    frame axes{};
    std::vector<flat_triangle> triangles{};

    [[nodiscard]] flat_triangle flat(const std::array<dvec3, 3>& corners) const noexcept {
        flat_triangle result;
        for (std::size_t k = 0; k < 3; ++k) {
            result[k] = {glm::dot(axes.u, corners[k]), glm::dot(axes.v, corners[k])};
        }
        return counter_clockwise(result);
    }
    /// Whether some of a face lies over a triangle.
    [[nodiscard]] bool may_show(const std::array<dvec3, 3>& corners, double slack) const noexcept {
        const flat_triangle shape = flat(corners);
        return std::any_of(triangles.begin(), triangles.end(), [&](const flat_triangle& t) {
            return !is_beyond_an_edge(t, shape, slack) && !is_beyond_an_edge(shape, t, slack);
        });
    }
};

/// One call of find_nearest_planes; its methods are the steps in their order.
class plane_finder {
public:
    plane_finder(const mesh& original, const mesh& cloud)
        : original_(original),
          cloud_(cloud),
          bounds_(bounding_sphere_of(original)),
          slack_(1e-5 * bounds_.radius +
                 1e-6 * (std::abs(bounds_.centre.x) + std::abs(bounds_.centre.y) +
                         std::abs(bounds_.centre.z))) {}

    [[nodiscard]] nearest_planes run(parallel threads) {
        find_planes();
        result_.planes.bounds = bounds_;
        auto& plane_of_face = result_.planes.plane_of_face;
        plane_of_face.assign(original_.face_count(), no_id);
        std::vector<char> is_kept(original_.face_count(), 0);
        threads.for_chunks(plane_of_face.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t face = begin; face < end; ++face) {
                const auto corners = original_.corners(static_cast<face_id>(face));
                is_kept[face] = holds(corners) ? 1 : 0;
                if (is_kept[face] == 0) plane_of_face[face] = nearest(corners);
            }
        });
        result_.kept = static_cast<std::size_t>(std::count(is_kept.begin(), is_kept.end(), 1));
        return std::move(result_);
    }

private:
    /// Sorts the features of the cloud into planes and parts that are none.
    void find_planes() {
        std::map<std::uint32_t, std::vector<face_id>> faces_of;
        for (face_id face = 0; face < cloud_.face_count(); ++face) {
            faces_of[cloud_.feature_ids[cloud_.triangles[face].x]].push_back(face);
        }
        for (const auto& [feature, faces] : faces_of) {
            if (!add_plane(feature, faces)) {
                for (const face_id face : faces) {
                    for (const vec3& p : cloud_.corners(face)) kept_points_.push_back(key(p));
                }
            }
        }
        std::sort(kept_points_.begin(), kept_points_.end());
    }

    [[nodiscard]] std::array<dvec3, 3> centred(const std::array<vec3, 3>& corners) const noexcept {
        return {dvec3(corners[0]) - bounds_.centre, dvec3(corners[1]) - bounds_.centre,
                dvec3(corners[2]) - bounds_.centre};
    }

    /// The plane of a feature's largest triangle, if all of the feature is on it.
    bool add_plane(std::uint32_t feature, const std::vector<face_id>& faces) {
        dvec3 largest{0};
        dvec3 point{0};
        for (const face_id face : faces) {
            const auto corners = centred(cloud_.corners(face));
            const dvec3 cross = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
            if (glm::dot(cross, cross) <= glm::dot(largest, largest)) continue;
            largest = cross;
            point = corners[0];
        }
        const double length = glm::length(largest);
        if (!(length > 0)) return true;  // shows nothing
        drawn_plane added;
        added.axes = frame_around(largest / length);
        added.on = {added.axes.normal, glm::dot(added.axes.normal, point)};
        for (const face_id face : faces) {
            const auto corners = centred(cloud_.corners(face));
            for (const dvec3& p : corners) {
                if (std::abs(signed_distance(added.on, p)) > 10 * slack_) return false;
            }
            added.triangles.push_back(added.flat(corners));
        }
        result_.planes.planes.push_back(added.on);
        result_.feature_of_plane.push_back(feature);
        drawn_.push_back(std::move(added));
        return true;
    }

    using point_key = std::array<float, 3>;
    [[nodiscard]] static point_key key(const vec3& p) noexcept { return {p.x, p.y, p.z}; }

    /// Whether all corners are vertices of parts that are no plane.
    [[nodiscard]] bool holds(const std::array<vec3, 3>& corners) const noexcept {
        return std::all_of(corners.begin(), corners.end(), [&](const vec3& p) {
            return std::binary_search(kept_points_.begin(), kept_points_.end(), key(p));
        });
    }

    [[nodiscard]] plane_id nearest(const std::array<vec3, 3>& at) const noexcept {
        const auto corners = centred(at);
        plane_id best = no_id;
        double least = std::numeric_limits<double>::infinity();
        for (plane_id id = 0; id < drawn_.size(); ++id) {
            double distance = 0;
            for (const dvec3& p : corners) {
                distance = std::max(distance, std::abs(signed_distance(drawn_[id].on, p)));
            }
            if (!(distance < least) || !drawn_[id].may_show(corners, slack_)) continue;
            least = distance;
            best = id;
        }
        return best;
    }

    const mesh& original_;
    const mesh& cloud_;
    bounding_sphere bounds_;
    double slack_;  ///< files hold floats
    std::vector<drawn_plane> drawn_{};
    std::vector<point_key> kept_points_{};
    nearest_planes result_{};
};

}  // namespace detail

/// For each face of the original the plane that is nearest to its farthest corner, of those on which
/// some polygon of the cloud lies over or under the face. A file does not say which plane a face was
/// mapped to; that plane is among these, so the distances are lower bounds of those of the cloud.
///
/// Needs   cloud.feature_ids, one plane each. A feature that is not flat is a part that stayed a
///         mesh: it holds the faces whose three corners are vertices of it.
/// Gives   no_id for faces over no polygon. Of planes that are equally near the lower feature id.
/// Cost    O(faces of the original × planes), parallel over faces.
[[nodiscard]] inline nearest_planes find_nearest_planes(const mesh& original, const mesh& cloud,
                                                        parallel threads = {}) {
    BILLOW_ASSERT(cloud.feature_ids.size() == cloud.vertex_count());
    return detail::plane_finder(original, cloud).run(threads);
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/render.hpp
// Draws views of a scene: light, coverage and what else is asked for.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

// ---- billow/metrics/projected_faces.hpp
// Where the faces of a scene lie in a view, by tiles of its samples.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

// ---- billow/metrics/render_scene.hpp
// A mesh made ready for many views.

#include <array>
#include <cstddef>


namespace billow::inline BILLOW_ABI {

/// The corners of a mesh in columns, and its textures with their mip chains.
///
/// Shape  `corner`: a row a face of the mesh, padded to the widest lane with zeros.
/// Unit   scene units, relative to bounds.centre.
/// Needs  indices within bounds, finite positions; the mesh outlives it.
struct render_scene {
    explicit render_scene(const mesh& source, bool culls_backs = false)
        : is_culled(culls_backs),
          bounds(bounding_sphere_of(
              source.face_count() * 3,
              [&](std::size_t i) {
                  return source.positions[source.triangles[i / 3][static_cast<int>(i % 3)]];
              })),
          look(source) {
        for (columns3& column : corner) column.resize(simd::padded(source.face_count()));
        for (face_id face = 0; face < source.face_count(); ++face) {
            const std::array<vec3, 3> at = source.corners(face);
            for (std::size_t k = 0; k < 3; ++k) {
                corner[k].set(face, dvec3(at[k]) - bounds.centre);
            }
        }
    }

    [[nodiscard]] std::size_t face_count() const noexcept { return look.source().face_count(); }

    bool is_culled;  ///< backs of faces whose material is not double-sided are not drawn
    bounding_sphere bounds;
    std::array<columns3, 3> corner{};
    surface look;
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/sample_view.hpp
// A camera as a map from the scene to a grid of samples.
//
// Interpolation in homogeneous coordinates after Olano and Greer, "Triangle Scan Conversion using 2D
// Homogeneous Coordinates", Graphics Hardware 1997: it needs no clipped corners.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>


namespace billow::inline BILLOW_ABI {

/// dot(slope, point) + offset.
struct linear_form {
    dvec3 slope{0};
    double offset = 0;

    [[nodiscard]] double at(const dvec3& point) const noexcept {
        return glm::dot(slope, point) + offset;
    }
};

/// The grid of samples of a camera: `supersample` a pixel side, columns to the right, rows down. A
/// point is seen at (x / w, y / w) samples. Of two points on a ray the one of greater `nearness` is
/// seen: of a perspective camera that is 1 / w, of an orthographic one the height along the normal.
struct sample_view {
    linear_form x{};
    linear_form y{};
    linear_form w{};  ///< perspective: the distance along -axes.normal; orthographic: 1
    linear_form height{};
    double near_distance = 0;
    bool is_orthographic = false;
    int supersample = 1;
    int columns = 0;
    int rows = 0;

    sample_view() = default;
    sample_view(const camera& from, int samples_a_side)
        : near_distance(from.is_orthographic ? 0 : from.near_distance),
          is_orthographic(from.is_orthographic),
          supersample(samples_a_side),
          columns(from.width_px * samples_a_side),
          rows(from.height_px * samples_a_side) {
        const double scale = rows / from.height;
        const auto form = [&](const dvec3& axis, double factor) {
            return linear_form{axis * factor, -factor * glm::dot(axis, from.eye)};
        };
        height = form(from.axes.normal, 1);
        w = is_orthographic ? linear_form{dvec3(0), 1} : form(from.axes.normal, -1);
        x = form(from.axes.u, scale);
        y = form(from.axes.v, -scale);
        x = {x.slope + w.slope * (0.5 * columns), x.offset + w.offset * (0.5 * columns)};
        y = {y.slope + w.slope * (0.5 * rows), y.offset + w.offset * (0.5 * rows)};
        const frame& axes = from.axes;
        eye_ray_ = axes.normal;
        if (!is_orthographic) {
            ray_x_ = -axes.u / scale;
            ray_y_ = axes.v / scale;
            eye_ray_ += axes.u * (0.5 * columns / scale) - axes.v * (0.5 * rows / scale);
        }
    }

    [[nodiscard]] dvec3 project(const dvec3& point) const noexcept {
        return {x.at(point), y.at(point), w.at(point)};
    }
    /// The unit vector to the viewer from what is seen at a place, in samples.
    [[nodiscard]] vec3 toward_viewer(const dvec2& at) const noexcept {
        return vec3(glm::normalize(eye_ray_ + ray_x_ * at.x + ray_y_ * at.y));
    }
    /// The distance from the eye along -axes.normal. Of an orthographic camera it may be negative.
    [[nodiscard]] double distance_of(double nearness) const noexcept {
        return is_orthographic ? -nearness : 1 / nearness;
    }

private:
    dvec3 eye_ray_{0, 0, 1};
    dvec3 ray_x_{0};
    dvec3 ray_y_{0};
};

/// How the values of a face change over the grid: value / w is linear in columns and rows. With
/// `share` being the three barycentric weights divided by w, 1 / w is their sum.
struct face_gradients {
    std::array<affine_value, 3> share{};
    affine_value inverse_w{};
    affine_value nearness{};
    float nearness_low = 0;   ///< over the seen part
    float nearness_high = 0;  ///< slivers must not shoot out
    double w_least = 1;       ///< over the seen part
    double w_greatest = 1;
    double doubled_volume = 0;  ///< of the homogeneous corners: doubled area in samples · w³

    face_gradients() = default;
    face_gradients(const sample_view& view, const std::array<vec3, 3>& corners) noexcept {
        std::array<dvec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = view.project(dvec3(corners[k]));
        const dvec3 edges = glm::cross(p[1] - p[0], p[2] - p[0]);
        const double volume = glm::dot(p[0], edges);
        doubled_volume = std::abs(volume);
        if (volume == 0) return;
        const double scale = 1 / volume;
        const auto affine = [&](const dvec3& normal) {
            const dvec3 n = normal * scale;
            return affine_value{n.z + 0.5 * (n.x + n.y), n.x, n.y};
        };
        for (std::size_t k = 0; k < 3; ++k) {
            share[k] = affine(glm::cross(p[(k + 1) % 3], p[(k + 2) % 3]));
        }
        inverse_w = affine(edges);
        const auto [low, high] = std::minmax({p[0].z, p[1].z, p[2].z});
        w_least = std::max(low, view.near_distance);
        w_greatest = high;
        nearness = inverse_w;
        nearness_low = static_cast<float>(1 / w_greatest);
        nearness_high = static_cast<float>(1 / w_least);
        if (!view.is_orthographic) return;
        const dvec3 heights(view.height.at(dvec3(corners[0])), view.height.at(dvec3(corners[1])),
                            view.height.at(dvec3(corners[2])));
        nearness = combined(heights);
        nearness_low = static_cast<float>(std::min({heights.x, heights.y, heights.z}));
        nearness_high = static_cast<float>(std::max({heights.x, heights.y, heights.z}));
    }

    /// Of values at the corners, divided by w.
    [[nodiscard]] affine_value combined(const dvec3& at_corners) const noexcept {
        affine_value sum;
        for (std::size_t k = 0; k < 3; ++k) {
            const double value = at_corners[static_cast<int>(k)];
            sum.base += share[k].base * value;
            sum.dx += share[k].dx * value;
            sum.dy += share[k].dy * value;
        }
        return sum;
    }
    /// The area in samples that the whole face would cover if it were as large everywhere as where
    /// 1 / w is this: what mip levels follow from.
    [[nodiscard]] double area_at(double inverse) const noexcept {
        return 0.5 * doubled_volume * inverse * inverse * inverse;
    }
    /// Whether one mip level cannot do for the whole face: sizes differ by more than 2 in area.
    [[nodiscard]] bool is_foreshortened() const noexcept {
        return w_greatest > 1.26 * w_least;  // 2^(1/3)
    }
    /// 1 / w in its middle.
    [[nodiscard]] double middle() const noexcept { return 2 / (w_least + w_greatest); }
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// A face in a view, or a piece of one that the near plane cuts.
struct projected_face {
    face_id face = no_id;
    std::array<float, 3> x{};  ///< in samples
    std::array<float, 3> y{};
    float distance = 0;                    ///< of the nearest corner, along the view
    std::array<std::uint16_t, 4> tiles{};  ///< columns [0] to [1] and rows [2] to [3] of tiles
};

/// The faces that may cover a sample of a view, listed for each tile of the picture. Built anew for every view in the same memory.
///
/// Cost   O(faces), in lanes.
class projected_faces {
public:
    /// A tile has at most this many samples a side: its depths and faces stay in the cache.
    static constexpr int tile_samples = 128;

    void project(const render_scene& scene, const sample_view& view) {
        view_ = view;
        tile_px_ = tile_samples / view.supersample;
        const int side = tile_px_ * view.supersample;
        tile_columns_ = (view.columns + side - 1) / side;
        tile_rows_ = (view.rows + side - 1) / side;
        faces_.clear();
        begin_.assign(tile_count() + 1, 0);
        project_all(scene);
        fill_tiles();
    }

    [[nodiscard]] std::size_t tile_count() const noexcept {
        return static_cast<std::size_t>(tile_columns_) * static_cast<std::size_t>(tile_rows_);
    }
    [[nodiscard]] int tile_px() const noexcept { return tile_px_; }
    /// The pixels of a tile.
    [[nodiscard]] sample_window pixels_of(std::size_t tile) const noexcept {
        const int x = static_cast<int>(tile) % tile_columns_ * tile_px_;
        const int y = static_cast<int>(tile) / tile_columns_ * tile_px_;
        return {x, y, std::min(x + tile_px_, view_.columns / view_.supersample),
                std::min(y + tile_px_, view_.rows / view_.supersample)};
    }
    /// Calls `visit(projected_face)` front to back: by the nearest corner, by id among equals. Tiles
    /// may be visited side by side, each once.
    template <class Visit>
    void for_faces_of(std::size_t tile, const Visit& visit) {
        const auto begin = listed_.begin() + begin_[tile];
        const auto end = listed_.begin() + begin_[tile + 1];
        std::sort(begin, end);
        std::for_each(begin, end,
                      [&](std::uint64_t listed) { visit(faces_[listed & 0xffffffffu]); });
    }

private:
    using V = simd::wide;
    using lanes = simd::lanes<V>;
    /// Faces that reach farther are cut: raster_triangle takes coordinates below 2²¹.
    static constexpr float farthest = 1048576.0f;
    /// Rounding may move corners by 1/256 sample.
    static constexpr float to_centre = 0.5f - 1.0f / 64;

    struct lane_form {
        V x, y, z, offset;

        lane_form(const linear_form& form, const dvec3& origin)
            : x(lanes::fill(static_cast<float>(form.slope.x))),
              y(lanes::fill(static_cast<float>(form.slope.y))),
              z(lanes::fill(static_cast<float>(form.slope.z))),
              offset(lanes::fill(static_cast<float>(form.at(origin)))) {}
        [[nodiscard]] V at(const V& px, const V& py, const V& pz) const noexcept {
            return x * px + y * py + z * pz + offset;
        }
    };

    void project_all(const render_scene& scene) {
        const lane_form form_x(view_.x, scene.bounds.centre);
        const lane_form form_y(view_.y, scene.bounds.centre);
        const lane_form form_w(view_.w, scene.bounds.centre);
        const lane_form form_height(view_.height, scene.bounds.centre);
        const auto near_distance = static_cast<float>(view_.near_distance);
        const V zero = lanes::fill(0);
        const V one = lanes::fill(1);
        for (std::size_t row = 0; row < scene.face_count(); row += lanes::count) {
            std::array<V, 3> x;
            std::array<V, 3> y;
            std::array<V, 3> w;
            std::array<V, 3> distance;
            for (std::size_t k = 0; k < 3; ++k) {
                const V px = lanes::load(scene.corner[k].x.data() + row);
                const V py = lanes::load(scene.corner[k].y.data() + row);
                const V pz = lanes::load(scene.corner[k].z.data() + row);
                w[k] = form_w.at(px, py, pz);
                const V inverse = one / w[k];
                x[k] = form_x.at(px, py, pz) * inverse;
                y[k] = form_y.at(px, py, pz) * inverse;
                distance[k] = zero - form_height.at(px, py, pz);
            }
            const V w_low = least(w);
            V x_low = least(x);
            V x_high = greatest(x);
            V y_low = least(y);
            V y_high = greatest(y);
            const V reach =
                simd::max(simd::max(x_high, zero - x_low), simd::max(y_high, zero - y_low));
            V is_whole = simd::select(w_low >= lanes::fill(near_distance), one, zero);
            is_whole = simd::select(reach <= lanes::fill(farthest), is_whole, zero);
            std::array<block, 8> kept;
            for (std::size_t k = 0; k < 3; ++k) {
                lanes::store(kept[k].data(), x[k]);
                lanes::store(kept[k + 3].data(), y[k]);
            }
            lanes::store(kept[6].data(), is_whole);
            lanes::store(kept[7].data(), least(distance));
            std::array<int_block, 4> sample;  // first and last columns and rows
            const auto first = [&](V low) {
                low = simd::select(is_whole > zero, low, zero);
                return simd::truncate(simd::max(low, zero) + lanes::fill(to_centre));
            };
            const auto last = [&](V high, int count) {
                high = simd::select(is_whole > zero, high, zero) - lanes::fill(to_centre);
                return simd::truncate(simd::min(simd::max(high, lanes::fill(-1)),
                                                lanes::fill(static_cast<float>(count - 1))));
            };
            lanes::store(sample[0].data(), first(x_low));
            lanes::store(sample[1].data(), last(x_high, view_.columns));
            lanes::store(sample[2].data(), first(y_low));
            lanes::store(sample[3].data(), last(y_high, view_.rows));
            const std::size_t end = std::min(lanes::count, scene.face_count() - row);
            for (std::size_t lane = 0; lane < end; ++lane) {
                const auto face = static_cast<face_id>(row + lane);
                if (!(kept[6][lane] > 0)) {
                    cut(scene, face);
                    continue;
                }
                add(scene,
                    {face,
                     {kept[0][lane], kept[1][lane], kept[2][lane]},
                     {kept[3][lane], kept[4][lane], kept[5][lane]},
                     kept[7][lane]},
                    {sample[0][lane], sample[2][lane], sample[1][lane], sample[3][lane]});
            }
        }
    }

    /// Adds a face that may cover the samples of `window`, the last ones included.
    void add(const render_scene& scene, projected_face face, const sample_window& window) {
        if (window.x_begin > window.x_end || window.y_begin > window.y_end) return;
        if (scene.is_culled && is_back(face) &&
            !scene.look.material_of(face.face).is_double_sided) {
            return;
        }
        const int side = tile_px_ * view_.supersample;
        const auto tile_of = [&](int sample) { return static_cast<std::uint16_t>(sample / side); };
        face.tiles = {tile_of(window.x_begin), tile_of(window.x_end), tile_of(window.y_begin),
                      tile_of(window.y_end)};
        for_tiles(face, [&](std::size_t tile) { ++begin_[tile + 1]; });
        faces_.push_back(face);
    }

    /// Samples run down: what is counter-clockwise to the viewer has a negative area.
    [[nodiscard]] static bool is_back(const projected_face& f) noexcept {
        return (f.x[1] - f.x[0]) * (f.y[2] - f.y[0]) > (f.x[2] - f.x[0]) * (f.y[1] - f.y[0]);
    }

    template <class Visit>
    void for_tiles(const projected_face& face, const Visit& visit) const {
        for (std::size_t row = face.tiles[2]; row <= face.tiles[3]; ++row) {
            for (std::size_t column = face.tiles[0]; column <= face.tiles[1]; ++column) {
                visit(row * static_cast<std::size_t>(tile_columns_) + column);
            }
        }
    }

    void fill_tiles() {
        for (std::size_t tile = 0; tile < tile_count(); ++tile) begin_[tile + 1] += begin_[tile];
        listed_.resize(begin_.back());
        next_.assign(begin_.begin(), begin_.end() - 1);
        for (std::uint32_t i = 0; i < faces_.size(); ++i) {
            const std::uint64_t key = std::uint64_t{ascending_bits(faces_[i].distance)} << 32 | i;
            for_tiles(faces_[i], [&](std::size_t tile) { listed_[next_[tile]++] = key; });
        }
    }

    /// Bits in the order of the floats.
    [[nodiscard]] static std::uint32_t ascending_bits(float value) noexcept {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        return bits >> 31 != 0 ? ~bits : bits | 0x80000000u;
    }

    /// Adds what the planes before the eye and far beside the picture leave of a face.
    void cut(const render_scene& scene, face_id face) {
        polygon shape;
        for (const vec3& corner : scene.look.source().corners(face)) {
            shape.corner[shape.size++] = view_.project(dvec3(corner));
        }
        const double aside = 0.5 * farthest;
        keep(shape, {0, 0, 1}, view_.near_distance);
        keep(shape, {1, 0, aside}, 0);
        keep(shape, {-1, 0, aside}, 0);
        keep(shape, {0, 1, aside}, 0);
        keep(shape, {0, -1, aside}, 0);
        for (std::size_t k = 2; k < shape.size; ++k) {
            projected_face piece{.face = face, .distance = static_cast<float>(view_.near_distance)};
            const std::array fan{shape.corner[0], shape.corner[k - 1], shape.corner[k]};
            for (std::size_t i = 0; i < 3; ++i) {
                piece.x[i] = static_cast<float>(fan[i].x / fan[i].z);
                piece.y[i] = static_cast<float>(fan[i].y / fan[i].z);
            }
            const auto range = [](const std::array<float, 3>& at, int count, int& low, int& high) {
                const auto limit = static_cast<float>(count);
                const auto [least_at, greatest_at] = std::minmax({at[0], at[1], at[2]});
                low = static_cast<int>(std::clamp(least_at, 0.0f, limit) + to_centre);
                high = static_cast<int>(std::clamp(greatest_at - to_centre, -1.0f, limit - 1));
            };
            sample_window window;
            range(piece.x, view_.columns, window.x_begin, window.x_end);
            range(piece.y, view_.rows, window.y_begin, window.y_end);
            add(scene, piece, window);
        }
    }

    struct polygon {
        std::array<dvec3, 8> corner{};  // each of five planes may add one to a triangle's three
        std::size_t size = 0;
    };

    /// Leaves of `shape` what is on the side dot(normal, point) ≥ offset.
    static void keep(polygon& shape, const dvec3& normal, double offset) noexcept {
        polygon rest;
        for (std::size_t i = 0; i < shape.size; ++i) {
            const dvec3& a = shape.corner[i];
            const dvec3& b = shape.corner[i + 1 == shape.size ? 0 : i + 1];
            const double at_a = glm::dot(normal, a) - offset;
            const double at_b = glm::dot(normal, b) - offset;
            if (at_a >= 0) rest.corner[rest.size++] = a;
            // From the kept end on, so that both faces at an edge are cut at the same point.
            if (at_a >= 0 && at_b < 0)
                rest.corner[rest.size++] = a + (b - a) * (at_a / (at_a - at_b));
            if (at_b >= 0 && at_a < 0)
                rest.corner[rest.size++] = b + (a - b) * (at_b / (at_b - at_a));
        }
        shape = rest;
    }

    [[nodiscard]] static V least(const std::array<V, 3>& v) noexcept {
        return simd::min(simd::min(v[0], v[1]), v[2]);
    }
    [[nodiscard]] static V greatest(const std::array<V, 3>& v) noexcept {
        return simd::max(simd::max(v[0], v[1]), v[2]);
    }

    using block = std::array<float, simd::max_lane_count>;
    using int_block = std::array<std::int32_t, simd::max_lane_count>;

    sample_view view_{};
    int tile_px_ = 1;
    int tile_columns_ = 0;
    int tile_rows_ = 0;
    std::vector<projected_face> faces_{};
    std::vector<std::uint32_t> begin_{};  // of each tile in listed_
    std::vector<std::uint32_t> next_{};
    std::vector<std::uint64_t> listed_{};  // distances, and rows of faces_ in the lower half
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/sample_tile.hpp
// Which face is foremost at every sample of a tile of a view, in perspective or not.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Fragments drawn: samples of faces, seen or hidden.
struct fragment_count {
    std::uint64_t opaque = 0;       ///< that alpha lets be seen
    std::uint64_t transparent = 0;  ///< discarded by alpha
};

/// Nearest face and its nearness for the samples of a tile. Of two faces equally near the one that
/// is drawn first is seen; front to back is fastest.
class sample_tile {
    static constexpr int stride = projected_faces::tile_samples;

public:
    explicit sample_tile(int supersample = 1)
        : side_(supersample), count_(static_cast<std::uint32_t>(supersample * supersample)) {
        const detail::dither_matrix dither(supersample);
        const auto count = static_cast<float>(count_);
        for (int y = 0; y < side_; ++y) {
            for (int x = 0; x < stride; ++x) {
                const float rank = dither.threshold(x, y, 0) * count;
                rank_[static_cast<std::size_t>(y * stride + x)] = static_cast<std::uint8_t>(rank);
            }
        }
        for (std::size_t i = 0; i < steps_.size(); ++i) steps_[i] = static_cast<float>(i);
        for (std::uint32_t i = 0; i < 2 * count_; ++i) {
            threshold_[i] = (static_cast<float>(i % count_) + 0.5f) / count;
        }
    }

    /// Forgets all and looks at `window`: of at most tile_samples a side, starting at a pixel.
    void start(const sample_window& window) noexcept {
        window_ = window;
        for (int y = 0; y < window.y_end - window.y_begin; ++y) {
            std::fill_n(nearness_.begin() + y * stride, window.x_end - window.x_begin, nothing);
            std::fill_n(faces_.begin() + y * stride, window.x_end - window.x_begin,
                        std::bit_cast<float>(no_id));
        }
    }

    /// Draws a face where its alpha lets it be seen. With Counts adds its fragments to `count`.
    template <bool Counts>
    void draw(const surface& look, const sample_view& view, const projected_face& shape,
              fragment_count& count) noexcept {
        const raster_triangle triangle({dvec2(shape.x[0], shape.y[0]),
                                        dvec2(shape.x[1], shape.y[1]),
                                        dvec2(shape.x[2], shape.y[2])});
        if (triangle.is_empty()) return;
        const face_gradients face(view, look.source().corners(shape.face));
        face_cover cover = look.cover_of(shape.face, face.area_at(face.middle()));
        const tile_value nearness(face.nearness, window_);
        if (cover.decides == face_cover::rule::always) {
            triangle.for_each_row(window_, [&](int y, int begin, int end) {
                if constexpr (Counts) count.opaque += static_cast<std::uint64_t>(end - begin);
                const std::size_t at = index_of(begin, y);
                if (find_nearness(face, nearness.row(at), at, end - begin)) {
                    merge(at, end - begin, shape.face);
                }
            });
            return;
        }
        const alpha_values alpha(face, cover, window_);
        const auto shift = static_cast<std::uint32_t>(mix_bits(shape.face) % count_);
        const int piece = face.is_foreshortened() ? 16 : stride;
        triangle.for_each_row(window_, [&](int y, int row_begin, int row_end) {
            for (int begin = row_begin; begin < row_end; begin += piece) {
                const int size = std::min(piece, row_end - begin);
                const std::size_t at = index_of(begin, y);
                if (!find_nearness(face, nearness.row(at), at, size) && !Counts) continue;
                if (face.is_foreshortened()) {
                    const double inverse = face.inverse_w.at(begin + 0.5 * size, y);
                    cover = look.cover_of(shape.face, face.area_at(inverse));
                }
                const int opaque = discard(cover, alpha, shift, at, size);
                if constexpr (Counts) {
                    count.opaque += static_cast<std::uint64_t>(opaque);
                    count.transparent += static_cast<std::uint64_t>(size - opaque);
                }
                if (opaque > 0) merge(at, size, shape.face);
            }
        });
    }

    [[nodiscard]] const sample_window& window() const noexcept { return window_; }
    [[nodiscard]] face_id face_at(int x, int y) const noexcept {
        return std::bit_cast<face_id>(faces_[index_of(x, y)]);
    }
    [[nodiscard]] float nearness_at(int x, int y) const noexcept {
        return nearness_[index_of(x, y)];
    }

    /// Groups the samples of a pixel by face, so that each group is shaded once.
    ///
    /// Gives  the number of groups at the front of `parts`.
    std::size_t parts_of(
        int x, int y, int s,
        std::array<texel_part, max_supersample * max_supersample>& parts) const noexcept {
        std::size_t count = 0;
        for (int j = y * s; j < (y + 1) * s; ++j) {
            for (int i = 0; i < s; ++i) {
                const face_id face = face_at(x * s + i, j);
                if (face == no_id) continue;
                std::size_t part = 0;
                while (part < count && parts[part].face != face) ++part;
                if (part == count) parts[count++] = {face, 0, dvec2(0)};
                ++parts[part].samples;
                parts[part].centre += dvec2(x * s + i + 0.5, j + 0.5);
            }
        }
        for (std::size_t i = 0; i < count; ++i) parts[i].centre /= parts[i].samples;
        return count;
    }

private:
    using V = simd::wide;
    using lanes = simd::lanes<V>;

    /// A value along a row from some sample on.
    struct row_value {
        float first;
        float across;

        [[nodiscard]] float at(int step) const noexcept {
            return first + across * static_cast<float>(step);
        }
        [[nodiscard]] V at(V step) const noexcept {
            return lanes::fill(first) + lanes::fill(across) * step;
        }
    };

    /// A value over a tile, in floats.
    struct tile_value {
        float base = 0;
        float dx = 0;
        float dy = 0;

        tile_value(const affine_value& of, const sample_window& window) noexcept
            : base(static_cast<float>(of.at(window.x_begin, window.y_begin))),
              dx(static_cast<float>(of.dx)),
              dy(static_cast<float>(of.dy)) {}
        [[nodiscard]] row_value row(std::size_t at) const noexcept {
            const std::size_t y = at / stride;
            const std::size_t x = at % stride;
            return {base + dy * static_cast<float>(y) + dx * static_cast<float>(x), dx};
        }
    };

    /// What alpha depends on; each divided by w.
    struct alpha_values {
        tile_value inverse_w, u, v, alpha;
        bool is_unwrapped = true;  ///< no wrap mode matters

        alpha_values(const face_gradients& face, const face_cover& cover,
                     const sample_window& window) noexcept
            : inverse_w(face.inverse_w, window),
              u(combined(face, window, [&](std::size_t i) { return cover.uvs[i].x; })),
              v(combined(face, window, [&](std::size_t i) { return cover.uvs[i].y; })),
              alpha(combined(face, window, [&](std::size_t i) { return cover.vertex_alpha[i]; })) {
            for (const vec2& uv : cover.uvs) {
                is_unwrapped &= uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1;
            }
        }
        template <class Value>
        [[nodiscard]] static tile_value combined(const face_gradients& face,
                                                 const sample_window& window,
                                                 const Value& value) noexcept {
            return {face.combined(dvec3(value(0), value(1), value(2))), window};
        }
    };

    [[nodiscard]] std::size_t index_of(int x, int y) const noexcept {
        return static_cast<std::size_t>((y - window_.y_begin) * stride + x - window_.x_begin);
    }

    /// Sets values_ to the nearness of the samples, to -inf after them to the end of the lane. Gives
    /// whether any of them may be seen.
    bool find_nearness(const face_gradients& face, const row_value& row, std::size_t at,
                       int size) noexcept {
        const V low = lanes::fill(face.nearness_low);
        const V high = lanes::fill(face.nearness_high);
        V nearer = lanes::fill(-1);
        const auto count = static_cast<std::size_t>(size);
        for (std::size_t step = 0; step < count; step += lanes::count) {
            const V value = simd::min(simd::max(row.at(lanes::load(&steps_[step])), low), high);
            lanes::store(&values_[step], value);
            nearer = simd::max(nearer, value - lanes::load(&nearness_[at + step]));
        }
        for (std::size_t i = count; i % lanes::count != 0; ++i) values_[i] = nothing;
        std::array<float, lanes::count> greatest;
        lanes::store(greatest.data(), nearer);
        bool is_any = false;
        for (const float value : greatest) is_any |= value > 0;
        return is_any;
    }

    /// Moves samples that alpha discards to where they are not seen. Gives how many are left.
    int discard(const face_cover& cover, const alpha_values& face, std::uint32_t shift,
                std::size_t at, int size) noexcept {
        const row_value row_u = face.u.row(at);
        const row_value row_v = face.v.row(at);
        const row_value row_w = face.inverse_w.row(at);
        const auto y = static_cast<int>(at / stride);  // windows start at pixels
        const std::uint8_t* rank =
            &rank_[static_cast<std::size_t>(y % side_) * stride + at % stride];
        const float* threshold = &threshold_[shift];
        const bool is_dithered = cover.decides == face_cover::rule::share;
        const float cutoff = cover.cutoff;
        const auto count = static_cast<std::size_t>(size);
        int left = 0;
        const auto keep_if = [&](std::size_t step, float alpha) {
            const bool is_there = alpha >= (is_dithered ? threshold[rank[step]] : cutoff);
            values_[step] = is_there ? values_[step] : nothing;
            left += is_there ? 1 : 0;
        };
        if (cover.alpha != nullptr && cover.is_nearest && !cover.has_vertex_alpha &&
            face.is_unwrapped) {
            const image& level = *cover.alpha;
            const V width = lanes::fill(static_cast<float>(level.width));
            const V last_x = lanes::fill(static_cast<float>(level.width - 1));
            const V height = lanes::fill(static_cast<float>(level.height));
            const V last_y = lanes::fill(static_cast<float>(level.height - 1));
            for (std::size_t step = 0; step < count; step += lanes::count) {
                const V i = lanes::load(&steps_[step]);
                const V w = lanes::fill(1) / row_w.at(i);
                const V zero = lanes::fill(0);
                const V texel_x = simd::min(simd::max(row_u.at(i) * w * width, zero), last_x);
                const V texel_y = simd::min(simd::max(row_v.at(i) * w * height, zero), last_y);
                lanes::store(&texel_x_[step], simd::truncate(texel_x));
                lanes::store(&texel_y_[step], simd::truncate(texel_y));
            }
            const std::uint8_t* bytes = level.bytes.data();
            const std::int32_t stride_of_level = level.width;
            const float factor = cover.factor * (1.0f / 255.0f);
            for (std::size_t step = 0; step < count; ++step) {
                const std::int32_t texel = texel_y_[step] * stride_of_level + texel_x_[step];
                keep_if(step, factor * static_cast<float>(bytes[texel]));
            }
            return left;
        }
        const row_value row_a = face.alpha.row(at);
        for (std::size_t step = 0; step < count; ++step) {
            const auto i = static_cast<int>(step);
            const float w = 1 / row_w.at(i);
            float alpha = cover.factor;
            if (cover.has_vertex_alpha) alpha *= row_a.at(i) * w;
            if (cover.alpha != nullptr) {
                const vec2 uv = vec2(row_u.at(i), row_v.at(i)) * w;
                alpha *= sample_alpha(*cover.alpha, *cover.map, uv, cover.is_nearest);
            }
            keep_if(step, alpha);
        }
        return left;
    }

    /// Lets values_ be seen where they are nearer than what is there.
    void merge(std::size_t at, int size, face_id id) noexcept {
        const V face = lanes::fill(std::bit_cast<float>(id));
        for (std::size_t step = 0; step < static_cast<std::size_t>(size); step += lanes::count) {
            const V value = lanes::load(&values_[step]);
            const V before = lanes::load(&nearness_[at + step]);
            const V face_before = lanes::load(&faces_[at + step]);
            lanes::store(&nearness_[at + step], simd::max(value, before));
            lanes::store(&faces_[at + step], simd::select(value > before, face, face_before));
        }
    }

    static constexpr float nothing = -std::numeric_limits<float>::infinity();
    static constexpr std::size_t all_samples =
        std::size_t{stride} * stride + simd::max_lane_count;  // lanes may reach over the end
    template <class T>
    using row_of = std::array<T, stride + simd::max_lane_count>;

    int side_;
    std::uint32_t count_;
    std::array<std::uint8_t, max_supersample * stride> rank_{};
    std::array<float, 2 * max_supersample * max_supersample> threshold_{};
    sample_window window_{};
    row_of<float> steps_{};  ///< 0, 1, 2, …
    row_of<float> values_{};
    row_of<std::int32_t> texel_x_{};
    row_of<std::int32_t> texel_y_{};
    std::vector<float> nearness_ = std::vector<float>(all_samples);
    std::vector<float> faces_ = std::vector<float>(all_samples);  ///< bits of ids, for the lanes
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct render_options {
    int supersample = 4;           ///< samples a pixel side, 1 to 8; time grows with its square
    float headlight = 0.7f;        ///< light from the viewer's place
    float sky = 0.35f;             ///< light from above, and half of it from below
    bool keeps_faces = false;      ///< fills view_render::faces
    bool keeps_distances = false;  ///< fills view_render::distances
    bool counts_fragments =
        false;  ///< fills all of view_render::counts; alpha is read for hidden faces too
};

/// What was drawn, in pixels: samples divided by the samples of a pixel.
struct render_counts {
    double covered = 0;      ///< the sum of the picture's coverage
    double opaque = 0;       ///< fragments that alpha lets be seen, hidden or not; only on request
    double transparent = 0;  ///< fragments that alpha discards, hidden or not; only on request

    /// How often a covered pixel is drawn, what is discarded included.
    [[nodiscard]] double overdraw() const noexcept {
        return covered > 0 ? (opaque + transparent) / covered : 0.0;
    }
};

/// A view of a scene.
///
/// Shape  `faces`, `distances`: a row a pixel, or none where they were not asked for. They are those
///        of the sample nearest to the pixel's centre, of four equally near ones the lower right.
struct view_render {
    view_picture picture{};
    std::vector<face_id> faces{};    ///< no_id where nothing is
    std::vector<float> distances{};  ///< along the view, from the eye; infinite where nothing is
    render_counts counts{};
};

namespace detail {

/// Shades points of faces in a view; remembers what is constant over the faces met last.
class render_shader {
public:
    void start(const surface& look, const sample_view& view) noexcept {
        look_ = &look;
        view_ = view;
        for (entry& e : entries_) e.look.face = no_id;
    }

    /// The light of a face at the point of it that is nearest to `at`, in samples.
    [[nodiscard]] vec3 light(face_id face, const dvec2& at,
                             const render_options& options) noexcept {
        entry& e = entries_[face % entries_.size()];
        if (e.look.face != face) {
            e.gradients = face_gradients(view_, look_->source().corners(face));
            e.look = look_->look_at(face, pixels(e.gradients, e.gradients.middle()));
        }
        const auto value = [&](const affine_value& of) { return of.at(at.x - 0.5, at.y - 0.5); };
        const double inverse = value(e.gradients.inverse_w);
        const double w = inverse != 0 ? 1 / inverse : 0;
        const double b = std::clamp(value(e.gradients.share[1]) * w, 0.0, 1.0);
        const double c = std::clamp(value(e.gradients.share[2]) * w, 0.0, 1.0 - b);
        if (e.gradients.is_foreshortened()) {
            e.look = look_->look_at(face, pixels(e.gradients, inverse));
        }
        surface_sample sample = look_->at(e.look, vec3(1 - b - c, b, c));
        const vec3 toward = view_.toward_viewer(at);
        sample.normal = normal_toward(sample, e.look, toward);
        const float facing = std::max(0.0f, glm::dot(sample.normal, toward));
        const float sky = options.sky * sample.occlusion * (0.75f + 0.25f * sample.normal.y);
        return sample.base_color * (options.headlight * facing + sky) + sample.emissive;
    }

private:
    struct entry {
        face_look look{};
        face_gradients gradients{};
    };

    [[nodiscard]] double pixels(const face_gradients& face, double inverse_w) const noexcept {
        return face.area_at(inverse_w) / (view_.supersample * view_.supersample);
    }

    const surface* look_ = nullptr;
    sample_view view_{};
    std::array<entry, 256> entries_{};
};

/// What one thread draws tiles with.
struct tile_worker {
    sample_tile tile;
    render_shader shader{};
    fragment_count fragments{};
    std::uint64_t covered = 0;
};

}  // namespace detail

/// What views are drawn with: memory that is used again from view to view.
class render_scratch {
public:
    /// Draws a view into `to`, whose memory is used again.
    ///
    /// Cost   O(faces + samples × faces that overlap); parallel over tiles of the picture.
    void render(const render_scene& scene, const camera& from, const render_options& options,
                view_render& to, parallel threads = {1}) {
        BILLOW_ASSERT(options.supersample >= 1 && options.supersample <= max_supersample);
        BILLOW_ASSERT(from.width_px >= 0 && from.height_px >= 0);
        view_ = sample_view(from, options.supersample);
        start(from, options, to);
        workers_.resize(threads.count(), {sample_tile(options.supersample)});
        if (supersample_ != options.supersample) {
            for (auto& worker : workers_) worker.tile = sample_tile(options.supersample);
            supersample_ = options.supersample;
        }
        for (auto& worker : workers_) {
            worker.shader.start(scene.look, view_);
            worker.fragments = {};
            worker.covered = 0;
        }
        faces_.project(scene, view_);
        for_jobs(threads, faces_.tile_count(), workers_, [&](std::size_t tile, auto& worker) {
            draw_tile(scene, options, tile, worker, to);
        });
        fragment_count sum;
        std::uint64_t covered = 0;
        for (const auto& worker : workers_) {
            covered += worker.covered;
            sum.opaque += worker.fragments.opaque;
            sum.transparent += worker.fragments.transparent;
        }
        const auto in_pixels = [&](std::uint64_t samples) {
            return static_cast<double>(samples) / (options.supersample * options.supersample);
        };
        to.counts = {in_pixels(covered), in_pixels(sum.opaque), in_pixels(sum.transparent)};
    }

private:
    static void start(const camera& from, const render_options& options, view_render& to) {
        to.picture.width = from.width_px;
        to.picture.height = from.height_px;
        const auto size =
            static_cast<std::size_t>(from.width_px) * static_cast<std::size_t>(from.height_px);
        to.picture.pixels.resize(size);
        to.faces.resize(options.keeps_faces ? size : 0);
        to.distances.resize(options.keeps_distances ? size : 0);
    }

    void draw_tile(const render_scene& scene, const render_options& options, std::size_t tile,
                   detail::tile_worker& worker, view_render& to) {
        const sample_window pixels = faces_.pixels_of(tile);
        const int s = options.supersample;
        worker.tile.start(
            {pixels.x_begin * s, pixels.y_begin * s, pixels.x_end * s, pixels.y_end * s});
        if (options.counts_fragments) {
            faces_.for_faces_of(tile, [&](const projected_face& face) {
                worker.tile.draw<true>(scene.look, view_, face, worker.fragments);
            });
        } else {
            faces_.for_faces_of(tile, [&](const projected_face& face) {
                worker.tile.draw<false>(scene.look, view_, face, worker.fragments);
            });
        }
        const float weight = 1.0f / static_cast<float>(s * s);
        std::array<texel_part, max_supersample * max_supersample> parts;
        for (int y = pixels.y_begin; y < pixels.y_end; ++y) {
            for (int x = pixels.x_begin; x < pixels.x_end; ++x) {
                const std::size_t count = worker.tile.parts_of(x, y, s, parts);
                vec3 sum{0};
                int covered = 0;
                for (std::size_t i = 0; i < count; ++i) {
                    sum += glm::min(worker.shader.light(parts[i].face, parts[i].centre, options),
                                    vec3(1)) *
                           static_cast<float>(parts[i].samples);
                    covered += parts[i].samples;
                }
                worker.covered += static_cast<std::uint64_t>(covered);
                to.picture.at(x, y) = vec4(sum, static_cast<float>(covered)) * weight;
                keep_centre(worker.tile, x, y, options, to);
            }
        }
    }

    void keep_centre(const sample_tile& tile, int x, int y, const render_options& options,
                     view_render& to) const noexcept {
        const int s = options.supersample;
        const auto pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(to.picture.width) +
            static_cast<std::size_t>(x);
        const face_id face = tile.face_at(x * s + s / 2, y * s + s / 2);
        if (options.keeps_faces) to.faces[pixel] = face;
        if (!options.keeps_distances) return;
        const double nearness = tile.nearness_at(x * s + s / 2, y * s + s / 2);
        to.distances[pixel] = face == no_id ? std::numeric_limits<float>::infinity()
                                            : static_cast<float>(view_.distance_of(nearness));
    }

    sample_view view_{};
    int supersample_ = 0;
    projected_faces faces_{};
    std::vector<detail::tile_worker> workers_{};
};

/// Draws one view. Faces are seen from both sides, unless the scene culls their backs; alpha is
/// tested, or dithered over the samples where a material blends; the light is one at the viewer and
/// one from the sky.
///
/// Needs  options.supersample within 1 to 8.
/// Gives  pixels of 0 where nothing is. The light of each face in a pixel is cut off at 1.
/// Cost   O(faces + samples × faces that overlap); parallel over tiles of the picture.
[[nodiscard]] inline view_picture render_view(const render_scene& scene, const camera& from,
                                              const render_options& options = {},
                                              parallel threads = {}) {
    render_scratch scratch;
    view_render result;
    scratch.render(scene, from, options, result, threads);
    return std::move(result.picture);
}

/// Draws every scene from every camera, and calls `body(view, renders)` for each camera: renders[i]
/// is that of *scenes[i], until `body` returns. Calls come from several threads in no fixed order.
///
/// Needs  as render_view; `body` must not throw, and its calls must not write to the same place.
/// Cost   as render_view for each; parallel over cameras. Nothing is allocated after the first view
///        of a thread, but where a view shows more faces than those before.
template <class Body>
void for_views(std::span<const render_scene* const> scenes, std::span<const camera> cameras,
               const render_options& options, parallel threads, const Body& body) {
    struct view_worker {
        render_scratch scratch{};
        std::vector<view_render> renders{};
    };
    std::vector<view_worker> workers(threads.count());
    for (view_worker& worker : workers) worker.renders.resize(scenes.size());
    for_jobs(threads, cameras.size(), workers, [&](std::size_t view, view_worker& worker) {
        for (std::size_t i = 0; i < scenes.size(); ++i) {
            worker.scratch.render(*scenes[i], cameras[view], options, worker.renders[i]);
        }
        body(view, std::span<const view_render>(worker.renders));
    });
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/view_directions.hpp
// Directions to look at a model from, evenly spread.

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// `count` unit directions on a spiral from +Y to -Y, each for the same share of the sphere: the i-th
/// is the middle of the i-th of `count` zones of equal area, turned by i golden angles.
///
/// Source  Vogel, "A better way to construct the sunflower head", Mathematical Biosciences 44, 1979,
///         on the sphere.
[[nodiscard]] inline std::vector<dvec3> spread_directions(int count = 42) {
    constexpr double golden_angle = std::numbers::pi * (3 - 2.2360679774997896964);  // (3 - √5) π
    std::vector<dvec3> directions;
    directions.reserve(static_cast<std::size_t>(count > 0 ? count : 0));
    for (int i = 0; i < count; ++i) {
        const double y = 1 - (2.0 * i + 1) / count;
        const double across = std::sqrt(1 - y * y);
        const double turn = golden_angle * i;
        directions.emplace_back(across * std::cos(turn), y, across * std::sin(turn));
    }
    return directions;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/view_errors.hpp
// All that two pictures of a view tell about a cloud, and what many views tell together.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 5.1: the metrics for evenly spread views, their mean and their maximum.

#include <array>
#include <span>
#include <string_view>
#include <vector>

// ---- billow/metrics/coverage_error.hpp
// How much of its original a cloud covers, and what else.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 3.4, Coverage Error.

#include <algorithm>
#include <cmath>


namespace billow::inline BILLOW_ABI {

/// Shares, 0 where the pictures cover the same.
///
/// With a and b the coverage of a pixel in the original and in the cloud's picture:
struct coverage_errors {
    double error = 0;           ///< Σ|a - b| / Σa: the thesis's coverage error
    double missing = 0;         ///< Σmax(a - b, 0) / Σa
    double extra = 0;           ///< Σmax(b - a, 0) / Σa; error = missing + extra
    double extra_of_cloud = 0;  ///< Σmax(b - a, 0) / Σb, as the thesis relates it
};

/// `part` of `whole`. Of nothing there is either nothing (0) or too much, which counts as 1.
[[nodiscard]] inline double share_of(double part, double whole) noexcept {
    if (whole > 0) return part / whole;
    return part > 0 ? 1 : 0;
}

/// Compares the coverage of two pictures.
///
/// Needs   pictures of the same size.
/// Gives   an original that covers nothing makes 1 of what the cloud adds.
/// Cost    O(pixels).
/// Source  Luksch 2009, section 3.4. Differs: coverage is not a mask but antialiased, so that what is
///         thinner than a pixel counts by its area. Two halves of one pixel are then the same, which
///         a mask of as many samples would tell apart.
[[nodiscard]] inline coverage_errors coverage_error(const view_picture& original,
                                                    const view_picture& cloud) noexcept {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    double of_original = 0;
    double of_cloud = 0;
    double missing = 0;
    double extra = 0;
    for (std::size_t i = 0; i < original.pixels.size(); ++i) {
        const double a = original.pixels[i].a;
        const double b = cloud.pixels[i].a;
        of_original += a;
        of_cloud += b;
        missing += std::max(a - b, 0.0);
        extra += std::max(b - a, 0.0);
    }
    return {share_of(missing + extra, of_original), share_of(missing, of_original),
            share_of(extra, of_original), share_of(extra, of_cloud)};
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/flip.hpp
// ꟻLIP: the difference that an observer sees who flips between two pictures.
//
// Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for
// Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020: the one for pictures of
// low dynamic range. Its filters are separable and run along rows, then columns.

#include <algorithm>
#include <cmath>
#include <numbers>


namespace billow::inline BILLOW_ABI {

/// Pixels a degree of a screen seen from 0.7 m that shows 3840 pixels on 0.7 m: the paper's.
inline constexpr double usual_pixels_per_degree = 0.7 * 3840 / 0.7 * std::numbers::pi / 180;

struct flip_options {
    /// Pixels of the picture in a degree of the observer's eye, ≥ 1. The more, the smaller a pixel
    /// looks, and the less of its detail is seen.
    double pixels_per_degree = usual_pixels_per_degree;
    vec3 background{0.85f, 0.87f, 0.9f};  ///< linear light, where nothing is
};

/// Pixels a degree of a picture of an object that an observer has before him at `distance`, on a
/// `screen` of `screen_pixels_per_degree`. A picture drawn as large as the object is on the screen
/// has those of the screen; one k times as large has k times as many.
///
/// Unit   picture_scale: pixels that the picture has for a scene unit at the object's centre.
/// Needs  distance > 0.
[[nodiscard]] inline double pixels_per_degree_at(
    double distance, const lod_screen& screen, double picture_scale,
    double screen_pixels_per_degree = usual_pixels_per_degree) noexcept {
    return screen_pixels_per_degree * picture_scale * distance / screen.pixels_at_one();
}

/// What an observer sees of one picture. Made once, it serves comparisons with several.
struct flip_percept {
    channel lightness{};  ///< L* of what contrast sensitivity leaves
    channel a{};          ///< a*, Hunt-adjusted
    channel b{};
    channel edge{};   ///< size of the gradient of luminance
    channel point{};  ///< size of its second derivatives
};

namespace detail {

/// Standard deviation, in degrees, of the Gaussian whose Fourier transform the paper's table 1 gives
/// by b: σ = sqrt(b / 2)/π.
[[nodiscard]] inline double flip_sigma_deg(double b) noexcept {
    return std::sqrt(b / 2) / std::numbers::pi;
}

/// Adjusts positive weights to a sum of 1, negative ones to -1.
[[nodiscard]] inline filter_weights balanced(const std::vector<double>& raw) {
    double positive = 0;
    double negative = 0;
    for (const double w : raw) (w > 0 ? positive : negative) += std::abs(w);
    filter_weights weights;
    for (const double w : raw)
        weights.push_back(static_cast<float>(w / (w > 0 ? positive : negative)));
    return weights;
}

/// The filters of section 4.1.1 and 4.2 for a picture of so many pixels a degree.
struct flip_filters {
    filter_weights achromatic{};
    filter_weights red_green{};
    filter_weights blue_yellow[2]{};  ///< a sum of two Gaussians, the wider one first
    float wider_share = 0;            ///< of that sum
    filter_weights smooth{};          ///< across an edge
    filter_weights edge{};            ///< first derivative of a Gaussian
    filter_weights point{};           ///< second derivative

    explicit flip_filters(double pixels_per_degree) {
        // Table 1 of the paper. Its blue-yellow row has two terms; a is the height of one, b says
        // how wide it is. The other rows' second terms are 0.
        constexpr double b_achromatic = 0.0047;
        constexpr double b_red_green = 0.0053;
        constexpr double a_blue_yellow[2] = {34.1, 13.5};
        constexpr double b_blue_yellow[2] = {0.04, 0.025};
        const auto sigma = [=](double b) { return flip_sigma_deg(b) * pixels_per_degree; };
        const int radius = static_cast<int>(std::ceil(3 * sigma(b_blue_yellow[0])));
        achromatic = gaussian_weights(sigma(b_achromatic), radius);
        red_green = gaussian_weights(sigma(b_red_green), radius);
        double mass[2];
        for (std::size_t i = 0; i < 2; ++i) {
            blue_yellow[i] = gaussian_weights(sigma(b_blue_yellow[i]), radius);
            // The term's sum over the square: height over the weight in the middle, squared.
            const double middle = blue_yellow[i][blue_yellow[i].size() / 2];
            const double height = a_blue_yellow[i] * std::sqrt(std::numbers::pi / b_blue_yellow[i]);
            mass[i] = height / (middle * middle);
        }
        wider_share = static_cast<float>(mass[0] / (mass[0] + mass[1]));

        constexpr double feature_width_deg = 0.082;
        const double s = 0.5 * feature_width_deg * pixels_per_degree;
        const int reach = static_cast<int>(std::ceil(3 * s));
        std::vector<double> slope;
        std::vector<double> bend;
        std::vector<double> bell;
        for (int x = -reach; x <= reach; ++x) {
            const double g = std::exp(-0.5 * x * x / (s * s));
            bell.push_back(g);
            slope.push_back(-x * g);
            bend.push_back((x * x / (s * s) - 1) * g);
        }
        smooth = balanced(bell);
        edge = balanced(slope);
        point = balanced(bend);
    }
};

/// x · share + y · (1 - share) of each pixel.
[[nodiscard]] inline channel mixed(channel x, const channel& y, float share) {
    using lanes = simd::lanes<simd::wide>;
    for (std::size_t i = 0; i < x.values.size(); i += lanes::count) {
        const auto u = lanes::load(x.values.data() + i);
        const auto v = lanes::load(y.values.data() + i);
        lanes::store(x.values.data() + i, v + (u - v) * share);
    }
    return x;
}

/// sqrt(x² + y²) of each pixel.
[[nodiscard]] inline channel lengths(channel x, const channel& y) {
    using lanes = simd::lanes<simd::wide>;
    for (std::size_t i = 0; i < x.values.size(); i += lanes::count) {
        const auto u = lanes::load(x.values.data() + i);
        const auto v = lanes::load(y.values.data() + i);
        lanes::store(x.values.data() + i, simd::sqrt(u * u + v * v));
    }
    return x;
}

/// L*, and a* and b* that matter less in the dark (the paper's equation for Hunt's effect).
template <class V>
[[nodiscard]] color_lanes<V> hunt_adjusted(const color_lanes<V>& relative_xyz) noexcept {
    const auto lab = lab_of_relative_xyz(relative_xyz);
    const V scale = lab.x * 0.01f;
    return {lab.x, scale * lab.y, scale * lab.z};
}

/// HyAB of adjusted colours, to the power of 0.7.
[[nodiscard]] inline float color_distance(const color_lanes<float>& p,
                                          const color_lanes<float>& q) noexcept {
    const float da = p.y - q.y;
    const float db = p.z - q.z;
    return std::pow(std::abs(p.x - q.x) + std::sqrt(da * da + db * db), 0.7f);
}

/// The largest color_distance in sRGB: between green and blue.
[[nodiscard]] inline float largest_color_distance() noexcept {
    return color_distance(hunt_adjusted(relative_xyz(color_lanes<float>{0, 1, 0})),
                          hunt_adjusted(relative_xyz(color_lanes<float>{0, 0, 1})));
}

template <class V>
[[nodiscard]] V clamped_to_unit(V value) noexcept {
    return simd::min(simd::max(value, simd::lanes<V>::fill(0)), simd::lanes<V>::fill(1));
}

/// Turns filtered opponent axes in place into Hunt-adjusted L*, a*, b*.
template <class V>
void adjust(channel& l, channel& a, channel& b) noexcept {
    using lanes = simd::lanes<V>;
    for (std::size_t i = 0; i < l.values.size(); i += lanes::count) {
        const V y = lanes::load(l.values.data() + i);
        const V red_green = lanes::load(a.values.data() + i);
        const V blue_yellow = lanes::load(b.values.data() + i);
        auto light = linear_of_relative_xyz(color_lanes<V>{y + red_green, y, y - blue_yellow});
        light = {clamped_to_unit(light.x), clamped_to_unit(light.y), clamped_to_unit(light.z)};
        const auto lab = hunt_adjusted(relative_xyz(light));
        lanes::store(l.values.data() + i, lab.x);
        lanes::store(a.values.data() + i, lab.y);
        lanes::store(b.values.data() + i, lab.z);
    }
}

/// Distances up to 0.4 of the largest one take 0.95 of [0, 1], those above the rest.
[[nodiscard]] inline float spread(float distance, float largest) noexcept {
    constexpr float knee = 0.4f;
    constexpr float knee_value = 0.95f;
    const float at = distance / (knee * largest);
    if (at < 1) return at * knee_value;
    return knee_value + (distance - knee * largest) / ((1 - knee) * largest) * (1 - knee_value);
}

}  // namespace detail

/// Sections 4.1 and 4.2 of the paper for one picture: its colours, blurred by how fine a contrast the
/// eye resolves, and the edges and points of its luminance.
///
/// Needs  a picture of at least one pixel.
/// Cost   O(pixels · pixels a degree), 7 filters of a third of a degree along each side.
[[nodiscard]] inline flip_percept seen_in(const view_picture& picture,
                                          const flip_options& options = {}) {
    BILLOW_ASSERT(options.pixels_per_degree >= 1 && !picture.pixels.empty());
    const detail::flip_filters filters(options.pixels_per_degree);
    // The opponent space's axes up to offset and scale, which filters of sum 1 leave alone.
    channel y(picture.width, picture.height);
    channel red_green(picture.width, picture.height);
    channel blue_yellow(picture.width, picture.height);
    for (int row = 0; row < picture.height; ++row) {
        for (int x = 0; x < picture.width; ++x) {
            const vec4& p = picture.at(x, row);
            const vec3 over = vec3(p) + (1 - p.a) * options.background;
            const auto xyz = relative_xyz(color_lanes<float>{std::clamp(over.x, 0.0f, 1.0f),
                                                             std::clamp(over.y, 0.0f, 1.0f),
                                                             std::clamp(over.z, 0.0f, 1.0f)});
            y.row(row)[x] = xyz.y;
            red_green.row(row)[x] = xyz.x - xyz.y;
            blue_yellow.row(row)[x] = xyz.y - xyz.z;
        }
    }
    flip_percept seen;
    const channel smooth = filter_rows(y, filters.smooth);
    seen.edge = detail::lengths(filter_columns(filter_rows(y, filters.edge), filters.smooth),
                                filter_columns(smooth, filters.edge));
    seen.point = detail::lengths(filter_columns(filter_rows(y, filters.point), filters.smooth),
                                 filter_columns(smooth, filters.point));
    seen.lightness = blurred(y, filters.achromatic);
    seen.a = blurred(red_green, filters.red_green);
    seen.b = detail::mixed(blurred(blue_yellow, filters.blue_yellow[0]),
                           blurred(blue_yellow, filters.blue_yellow[1]), filters.wider_share);
    detail::adjust<simd::wide>(seen.lightness, seen.a, seen.b);
    return seen;
}

/// The difference of two pictures at each pixel: 0 where none is seen, at most 1.
///
/// Needs   percepts of the same size.          Cost  O(pixels).
/// Gives   the same whichever comes first.
/// Source  Andersson et al. 2020, ΔE = ΔE_color ^ (1 - ΔE_feature).
[[nodiscard]] inline channel flip_map(const flip_percept& first, const flip_percept& second) {
    BILLOW_ASSERT(first.edge.width == second.edge.width && first.edge.height == second.edge.height);
    const float largest = detail::largest_color_distance();
    channel map(first.edge.width, first.edge.height);
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            const auto seen = [&](const flip_percept& p) {
                return color_lanes<float>{p.lightness.at(x, y), p.a.at(x, y), p.b.at(x, y)};
            };
            const auto p = seen(first);
            const auto q = seen(second);
            if (p.x == q.x && p.y == q.y && p.z == q.z) continue;
            const float edge = std::abs(first.edge.at(x, y) - second.edge.at(x, y));
            const float point = std::abs(first.point.at(x, y) - second.point.at(x, y));
            const float feature = std::sqrt(std::max(edge, point) / std::numbers::sqrt2_v<float>);
            const float color = detail::spread(detail::color_distance(p, q), largest);
            map.row(y)[x] = std::pow(std::min(color, 1.0f), 1 - std::min(feature, 1.0f));
        }
    }
    return map;
}

[[nodiscard]] inline channel flip_map(const view_picture& first, const view_picture& second,
                                      const flip_options& options = {}) {
    return flip_map(seen_in(first, options), seen_in(second, options));
}

/// ꟻLIP of two pictures, 0 to 1.
struct flip_errors {
    double mean = 0;         ///< over the picture, as the paper's tool; empty margins lower it
    double over_object = 0;  ///< Σw·ꟻLIP / Σw, w the greater coverage: whatever the margins are
};

/// Pools a map. Needs pictures of the map's size.
[[nodiscard]] inline flip_errors flip_error(const channel& map, const view_picture& first,
                                            const view_picture& second) noexcept {
    BILLOW_ASSERT(map.width == first.width && first.width == second.width);
    BILLOW_ASSERT(map.height == first.height && first.height == second.height);
    double sum = 0;
    double over_object = 0;
    double weights = 0;
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            const double weight = std::max(first.at(x, y).a, second.at(x, y).a);
            sum += map.at(x, y);
            over_object += weight * map.at(x, y);
            weights += weight;
        }
    }
    return {sum / (static_cast<double>(map.width) * map.height),
            weights > 0 ? over_object / weights : 0};
}

[[nodiscard]] inline flip_errors flip_error(const view_picture& first, const view_picture& second,
                                            const flip_options& options = {}) {
    return flip_error(flip_map(first, second, options), first, second);
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/gap.hpp
// Cracks and holes of a cloud: how much longer its borders are than its original's, and how much of
// the original they let through.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 3.4, Gap Intensity.

#include <cstddef>


namespace billow::inline BILLOW_ABI {

struct gap_options {
    /// How far from the original's silhouette a hole begins, pixels, ≥ 0. What is missing nearer to
    /// it may be the silhouette itself, displaced; the cloud's epsilon in pixels leaves all of that
    /// out, and the ends of cracks with it.
    int depth_px = 2;
};

struct gap_errors {
    double intensity = 0;   ///< see gap_intensity
    double hole_share = 0;  ///< see hole_share
};

/// The number of border pixels: those covered by half or more with a pixel above, below, to the left
/// or to the right that is covered by less. Cost O(pixels).
[[nodiscard]] inline std::size_t border_pixels(const view_picture& picture) noexcept {
    const auto is_covered = [&](int x, int y) { return picture.at(x, y).a >= 0.5f; };
    std::size_t count = 0;
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            if (!is_covered(x, y)) continue;
            const bool is_border = (x > 0 && !is_covered(x - 1, y)) ||
                                   (x + 1 < picture.width && !is_covered(x + 1, y)) ||
                                   (y > 0 && !is_covered(x, y - 1)) ||
                                   (y + 1 < picture.height && !is_covered(x, y + 1));
            count += is_border ? 1u : 0u;
        }
    }
    return count;
}

/// (E_cloud - E_original) / E_original, E the number of border pixels. 0 for a cloud with borders as
/// long as the original's, 1 where cracks make them twice as long; below 0 where thin structures are
/// lost.
///
/// Needs   pictures of the same size.
/// Gives   1 where the cloud alone has borders.
/// Source  Luksch 2009, section 3.4, which names neither the filter nor what the difference is
///         related to: here the four neighbours, and the original's border.
[[nodiscard]] inline double gap_intensity(const view_picture& original,
                                          const view_picture& cloud) noexcept {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    const auto of_original = static_cast<double>(border_pixels(original));
    return share_of(static_cast<double>(border_pixels(cloud)) - of_original, of_original);
}

/// Σmax(e - b, 0) / Σa, a and b the coverage in the original and in the cloud's picture, e the least
/// a within depth_px along rows and columns: the share of the original that is missing inside of it.
/// Tells how large the holes are, which the gap intensity does not. Crowns that let light through
/// have little inside, and read low.
///
/// Needs  pictures of the same size.          Cost  O(pixels · depth_px).
[[nodiscard]] inline double hole_share(const view_picture& original, const view_picture& cloud,
                                       const gap_options& options = {}) {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    if (original.pixels.empty()) return 0;
    channel coverage(original.width, original.height);
    double all = 0;
    for (int y = 0; y < original.height; ++y) {
        for (int x = 0; x < original.width; ++x) {
            coverage.row(y)[x] = original.at(x, y).a;
            all += original.at(x, y).a;
        }
    }
    const channel inside = eroded(coverage, options.depth_px);
    double holes = 0;
    for (int y = 0; y < original.height; ++y) {
        for (int x = 0; x < original.width; ++x) {
            holes += std::max(0.0f, inside.at(x, y) - cloud.at(x, y).a);
        }
    }
    return share_of(holes, all);
}

[[nodiscard]] inline gap_errors gap_error(const view_picture& original, const view_picture& cloud,
                                          const gap_options& options = {}) {
    return {gap_intensity(original, cloud), hole_share(original, cloud, options)};
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// What a cloud's pictures are measured by. Each is 0 for the same pictures, and grows as they
/// differ; the gap intensity alone may fall below 0.
///
/// Unit  shares, 1 for all of the original, but ΔE*76 for colours; ꟻLIP is 0 to 1.
template <class T>
struct picture_metrics {
    T coverage{};        ///< coverage_errors::error
    T missing{};         ///< coverage_errors::missing
    T extra{};           ///< coverage_errors::extra
    T extra_of_cloud{};  ///< coverage_errors::extra_of_cloud
    T gap_intensity{};   ///< gap_errors::intensity
    T hole_share{};      ///< gap_errors::hole_share
    T color{};           ///< color_errors::mean
    T common_color{};    ///< color_errors::common
    T local_color{};     ///< color_errors::local
    T flip{};            ///< flip_errors::mean
    T object_flip{};     ///< flip_errors::over_object

    [[nodiscard]] bool operator==(const picture_metrics&) const = default;
};

using view_errors = picture_metrics<double>;           ///< of one view
using errors_over_views = picture_metrics<statistic>;  ///< of many

/// A metric by name, for tables and files.
struct picture_metric {
    std::string_view name{};
    std::string_view unit{};
    double view_errors::*of_view = nullptr;
    statistic errors_over_views::*over_views = nullptr;
};

inline constexpr std::array<picture_metric, 11> all_picture_metrics{{
    {"coverage", "share", &view_errors::coverage, &errors_over_views::coverage},
    {"missing", "share", &view_errors::missing, &errors_over_views::missing},
    {"extra", "share", &view_errors::extra, &errors_over_views::extra},
    {"extra_of_cloud", "share", &view_errors::extra_of_cloud, &errors_over_views::extra_of_cloud},
    {"gap_intensity", "share", &view_errors::gap_intensity, &errors_over_views::gap_intensity},
    {"hole_share", "share", &view_errors::hole_share, &errors_over_views::hole_share},
    {"color", "delta_e76", &view_errors::color, &errors_over_views::color},
    {"common_color", "delta_e76", &view_errors::common_color, &errors_over_views::common_color},
    {"local_color", "delta_e76", &view_errors::local_color, &errors_over_views::local_color},
    {"flip", "flip", &view_errors::flip, &errors_over_views::flip},
    {"object_flip", "flip", &view_errors::object_flip, &errors_over_views::object_flip},
}};

static_assert(sizeof(view_errors) == all_picture_metrics.size() * sizeof(double));

struct measure_options {
    gap_options gap{};
    color_options color{};
    flip_options flip{};
};

/// What is derived from one picture alone. That of an original serves all of its clouds.
struct picture_percept {
    blurred_picture blurred{};
    flip_percept seen{};
};

/// Needs  a picture of at least one pixel.
[[nodiscard]] inline picture_percept perceive(const view_picture& picture,
                                              const measure_options& options = {}) {
    return {blur(picture, options.color), seen_in(picture, options.flip)};
}

/// All metrics of a pair of pictures of the same view.
///
/// Needs  pictures of the same size, percepts of them made with the same options.
/// Cost   O(pixels).
[[nodiscard]] inline view_errors measure_pair(const view_picture& original,
                                              const picture_percept& original_percept,
                                              const view_picture& cloud,
                                              const picture_percept& cloud_percept,
                                              const measure_options& options = {}) {
    const coverage_errors coverage = coverage_error(original, cloud);
    const gap_errors gap = gap_error(original, cloud, options.gap);
    const flip_errors flip =
        flip_error(flip_map(original_percept.seen, cloud_percept.seen), original, cloud);
    return {.coverage = coverage.error,
            .missing = coverage.missing,
            .extra = coverage.extra,
            .extra_of_cloud = coverage.extra_of_cloud,
            .gap_intensity = gap.intensity,
            .hole_share = gap.hole_share,
            .color = mean_color_error(original, cloud),
            .common_color = common_color_error(original, cloud),
            .local_color = local_color_error(original_percept.blurred, cloud_percept.blurred),
            .flip = flip.mean,
            .object_flip = flip.over_object};
}

[[nodiscard]] inline view_errors measure_pair(const view_picture& original,
                                              const view_picture& cloud,
                                              const measure_options& options = {}) {
    return measure_pair(original, perceive(original, options), cloud, perceive(cloud, options),
                        options);
}

/// measure_pair of each view, parallel over views.
///
/// Shape  as many originals as clouds, the same view in the same row.
/// Needs  pairs of pictures as measure_pair, some 80 bytes a pixel for each thread.
/// Gives  the same bits for any number of threads.
[[nodiscard]] inline std::vector<view_errors> measure_views(std::span<const view_picture> originals,
                                                            std::span<const view_picture> clouds,
                                                            const measure_options& options = {},
                                                            parallel threads = {}) {
    BILLOW_ASSERT(originals.size() == clouds.size());
    std::vector<view_errors> errors(originals.size());
    threads.for_chunks(errors.size(), 1, [&](std::size_t view, std::size_t) {
        errors[view] = measure_pair(originals[view], clouds[view], options);
    });
    return errors;
}

/// Mean, 95 % and worst of each metric over views, by metric, with the view that is worst by it.
[[nodiscard]] inline errors_over_views over_views(std::span<const view_errors> views) {
    errors_over_views result;
    std::vector<double> values(views.size());
    for (const picture_metric& metric : all_picture_metrics) {
        for (std::size_t i = 0; i < views.size(); ++i) values[i] = views[i].*metric.of_view;
        result.*metric.over_views = statistic_of(values);
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct compare_options {
    int views = 42;       ///< directions, evenly spread, ≥ 1
    int size_px = 512;    ///< side of the pictures, which the original fills
    double distance = 4;  ///< of the eye to the original's centre, in its radii, > 1
    lod_screen screen{};  ///< whose pixels the geometric error and ꟻLIP count
    int supersample = 4;  ///< samples a pixel side
    gap_options gap{};
    color_options color{};
};

/// What one cloud's pictures and file tell.
///
/// Shape  `views` and `view_overdraw`: a row a view.
struct cloud_comparison {
    draw_cost cost{};
    std::vector<view_errors> views{};
    errors_over_views errors{};
    std::vector<double> view_overdraw{};
    statistic overdraw{};
    /// None where the file does not say which plane a vertex lies on. Lower bounds: see
    /// find_nearest_planes. Faces that the cloud keeps as they are do not count, not as undrawn either.
    std::optional<geometric_errors> geometric{};
    nearest_planes planes{};
};

/// Clouds beside each other. Every cloud was seen by the same cameras.
struct comparison {
    bounding_sphere bounds{};       ///< of the original, which the cameras frame
    std::vector<camera> cameras{};  ///< cameras[i].axes.normal points to the viewer
    double pixels_per_degree = 0;   ///< of the pictures, for ꟻLIP
    draw_cost original{};
    std::vector<double> original_view_overdraw{};
    statistic original_overdraw{};
    std::vector<cloud_comparison> clouds{};
};

/// Whether single-sided faces of a mesh are compared by what their front shows, as engines draw them:
/// those of clouds, which know their planes. Others are drawn from both sides, as clouds are baked.
[[nodiscard]] inline bool culls_backs(const mesh& of) noexcept { return !of.feature_ids.empty(); }

namespace detail {

/// The cameras of a comparison, with the pictures' pixels a degree: so many that ꟻLIP sees what an
/// observer of the screen does, for whom the object is as large as at this distance.
inline void set_cameras(comparison& to, const compare_options& options) {
    for (const dvec3& direction : spread_directions(options.views)) {
        to.cameras.push_back(orbit_camera(to.bounds, direction, options.distance, options.size_px));
    }
    const double radius = to.bounds.radius > 0 ? to.bounds.radius : 1.0;
    const double distance = options.distance * radius;
    const double scale = options.size_px / (to.cameras.front().height * distance);
    to.pixels_per_degree = std::max(1.0, pixels_per_degree_at(distance, options.screen, scale));
}

inline void measure_geometry(cloud_comparison& to, const mesh& original, const mesh& cloud,
                             const compare_options& options, parallel threads) {
    if (cloud.feature_ids.empty()) return;
    to.planes = find_nearest_planes(original, cloud, threads);
    const double distance = options.distance * to.planes.planes.bounds.radius;
    to.geometric = geometric_error(original, to.planes.planes, {}, {distance, options.screen});
    to.geometric->undrawn -= to.planes.kept;
}

}  // namespace detail

/// Draws the original and every cloud from all sides and measures the pictures.
///
/// Needs   meshes that validate() accepts; at least one view, size_px ≥ 1, distance > 1.
/// Gives   0 by every picture metric for a cloud that is the original; the same bits for any number
///         of threads.
/// Cost    O(views × (faces + pixels)) for each mesh, and as find_nearest_planes; parallel over
///         views. Some 250 bytes a pixel for each thread.
[[nodiscard]] inline comparison compare(const mesh& original, std::span<const mesh* const> clouds,
                                        const compare_options& options = {}, parallel threads = {},
                                        const progress_function& progress = {}) {
    BILLOW_ASSERT(options.views >= 1 && options.size_px >= 1 && options.distance > 1);
    comparison result;
    std::deque<render_scene> scenes;  // they stay where they are
    scenes.emplace_back(original, culls_backs(original));
    for (const mesh* cloud : clouds) scenes.emplace_back(*cloud, culls_backs(*cloud));
    std::vector<const render_scene*> drawn;
    drawn.reserve(scenes.size());
    for (const render_scene& scene : scenes) drawn.push_back(&scene);

    result.bounds = scenes.front().bounds;
    detail::set_cameras(result, options);
    const std::size_t views = result.cameras.size();
    result.original = draw_cost_of(original);
    result.original_view_overdraw.resize(views);
    result.clouds.resize(clouds.size());
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        result.clouds[i].cost = draw_cost_of(*clouds[i]);
        result.clouds[i].views.resize(views);
        result.clouds[i].view_overdraw.resize(views);
    }

    const measure_options measure{
        options.gap, options.color, {.pixels_per_degree = result.pixels_per_degree}};
    const render_options render{.supersample = options.supersample, .counts_fragments = true};
    const auto caller = std::this_thread::get_id();
    std::atomic<std::size_t> done{0};
    report(progress, "compare", 0);
    for_views(drawn, result.cameras, render, threads,
              [&](std::size_t view, std::span<const view_render> seen) {
                  const view_picture& before = seen[0].picture;
                  const picture_percept percept = perceive(before, measure);
                  result.original_view_overdraw[view] = seen[0].counts.overdraw();
                  for (std::size_t i = 0; i < clouds.size(); ++i) {
                      cloud_comparison& to = result.clouds[i];
                      const view_picture& after = seen[i + 1].picture;
                      to.views[view] =
                          measure_pair(before, percept, after, perceive(after, measure), measure);
                      to.view_overdraw[view] = seen[i + 1].counts.overdraw();
                  }
                  const auto share = static_cast<double>(++done) / static_cast<double>(views);
                  if (std::this_thread::get_id() == caller) report(progress, "compare", share);
              });
    report(progress, "compare", 1);

    result.original_overdraw = statistic_of(result.original_view_overdraw);
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        cloud_comparison& to = result.clouds[i];
        to.errors = over_views(to.views);
        to.overdraw = statistic_of(to.view_overdraw);
        detail::measure_geometry(to, original, *clouds[i], options, threads);
    }
    return result;
}

/// One cloud alone.
[[nodiscard]] inline comparison compare(const mesh& original, const mesh& cloud,
                                        const compare_options& options = {}, parallel threads = {},
                                        const progress_function& progress = {}) {
    const std::array<const mesh*, 1> one{&cloud};
    return compare(original, one, options, threads, progress);
}

/// Views worth looking at: for each cloud the worst and the best by coverage and the worst by ꟻLIP,
/// then evenly spread ones up to `count`.
///
/// Gives  rows of cameras, ascending, each once; at least one where count ≥ 1, at most `count`.
[[nodiscard]] inline std::vector<std::size_t> telling_views(const comparison& of,
                                                            std::size_t count) {
    std::vector<std::size_t> chosen;
    const std::size_t views = of.cameras.size();
    const auto add = [&](std::size_t view) {
        const bool is_new = std::find(chosen.begin(), chosen.end(), view) == chosen.end();
        if (is_new && chosen.size() < count) chosen.push_back(view);
    };
    for (const cloud_comparison& cloud : of.clouds) {
        add(cloud.errors.coverage.worst_view);
        add(cloud.errors.object_flip.worst_view);
        const auto by_coverage = [](const view_errors& a, const view_errors& b) {
            return a.coverage < b.coverage;
        };
        const auto best = std::min_element(cloud.views.begin(), cloud.views.end(), by_coverage);
        add(static_cast<std::size_t>(best - cloud.views.begin()));
    }
    for (std::size_t parts = 2; chosen.size() < std::min(count, views); ++parts) {
        for (std::size_t i = 1; i < parts; ++i) add(i * views / parts);
        if (parts > 2 * views) add(0);
    }
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/difference_picture.hpp
// Pictures of where a cloud's view differs from its original's.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>


namespace billow::inline BILLOW_ABI {

/// The colours of coverage_picture, linear light. Orange and blue are told apart by nearly all eyes.
struct coverage_colors {
    vec3 nothing{0.90f, 0.90f, 0.90f};
    vec3 both{0.45f, 0.45f, 0.45f};
    vec3 missing{0.66f, 0.11f, 0};  ///< of the original in the cloud
    vec3 extra{0, 0.17f, 0.45f};    ///< of the cloud beyond the original
};

/// Signed difference of coverage: pixels mix the colours by the share that each holds.
///
/// Needs  pictures of the same size.
/// Gives  RGB, sRGB.
[[nodiscard]] inline image coverage_picture(const view_picture& original, const view_picture& cloud,
                                            const coverage_colors& colors = {}) {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    image result = image::filled(original.width, original.height, 3, 0);
    for (int y = 0; y < original.height; ++y) {
        for (int x = 0; x < original.width; ++x) {
            const float a = original.at(x, y).a;
            const float b = cloud.at(x, y).a;
            const vec3 light =
                colors.nothing * (1 - std::max(a, b)) + colors.both * std::min(a, b) +
                colors.missing * std::max(a - b, 0.0f) + colors.extra * std::max(b - a, 0.0f);
            std::uint8_t* pixel = result.pixel(x, y);
            for (int c = 0; c < 3; ++c) pixel[c] = srgb_byte_from_linear(light[c]);
        }
    }
    return result;
}

/// sRGB of a share from 0, dark blue, over red to 1, light yellow; lightness grows all along.
[[nodiscard]] inline vec3 heat_color(float share) noexcept {
    static constexpr std::array<std::array<float, 3>, 5> steps{{{0.05f, 0.05f, 0.25f},
                                                                {0.40f, 0.08f, 0.42f},
                                                                {0.80f, 0.24f, 0.28f},
                                                                {0.97f, 0.58f, 0.16f},
                                                                {0.99f, 0.96f, 0.64f}}};
    const float at = std::clamp(share, 0.0f, 1.0f) * static_cast<float>(steps.size() - 1);
    const std::size_t below = std::min(static_cast<std::size_t>(at), steps.size() - 2);
    const float rest = at - static_cast<float>(below);
    vec3 color;
    for (std::size_t c = 0; c < 3; ++c) {
        color[static_cast<int>(c)] =
            steps[below][c] + (steps[below + 1][c] - steps[below][c]) * rest;
    }
    return color;
}

/// ΔE*76 after a blur, square by square: what local_color_error is the mean of. Colours are those of
/// heat_color, from 0 to `most`, faded to grey where little is covered.
///
/// Needs  pictures of the same size, blurred by the same options; most > 0.
/// Gives  RGB, sRGB; a pixel for each square of the blurred pictures.
[[nodiscard]] inline image color_difference_picture(const blurred_picture& original,
                                                    const blurred_picture& cloud,
                                                    double most = 40) {
    const channel& a = original.channels[3];
    const channel& b = cloud.channels[3];
    BILLOW_ASSERT(a.width == b.width && a.height == b.height);
    const vec3 nothing(0.95f);
    image result = image::filled(a.width, a.height, 3, 0);
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            const float weight = std::min(a.at(x, y), b.at(x, y));
            vec3 color = nothing;
            if (weight > 1e-4f) {  // as local_color_error
                const vec4 p = original.at(x, y);
                const vec4 q = cloud.at(x, y);
                const double error =
                    delta_e76(lab_from_linear(vec3(p) / p.a), lab_from_linear(vec3(q) / q.a));
                color = glm::mix(nothing, heat_color(static_cast<float>(error / most)),
                                 std::min(1.0f, 4 * weight));
            }
            std::uint8_t* pixel = result.pixel(x, y);
            for (int c = 0; c < 3; ++c) {
                pixel[c] = static_cast<std::uint8_t>(std::lround(255 * color[c]));
            }
        }
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/picture.hpp
// A picture of a mesh to look at.

#include <algorithm>
#include <cstddef>
#include <cstdint>


namespace billow::inline BILLOW_ABI {

struct picture_options {
    vec3 background{0.85f, 0.87f, 0.9f};  ///< linear light
    render_options render{};
};

/// A view before a background, in linear light, as an sRGB image of three channels.
[[nodiscard]] inline image image_of(const view_picture& picture, const vec3& background) {
    image result = image::filled(picture.width, picture.height, 3, 0);
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const vec4& seen = picture.at(x, y);
            const vec3 light = vec3(seen) + background * (1 - seen.w);
            std::uint8_t* pixel = result.pixel(x, y);
            for (int c = 0; c < 3; ++c) pixel[c] = srgb_byte_from_linear(light[c]);
        }
    }
    return result;
}

/// Draws `source` as render_view does.
///
/// Needs  indices within bounds, finite positions.
/// Gives  RGB, sRGB, options.background where nothing is.
[[nodiscard]] inline image draw_picture(const mesh& source, const camera& from,
                                        const picture_options& options = {},
                                        parallel threads = {}) {
    return image_of(render_view(render_scene(source), from, options.render, threads),
                    options.background);
}

/// Two pictures of the same height and channels in one, the first on the left.
[[nodiscard]] inline image side_by_side(const image& left, const image& right) {
    BILLOW_ASSERT(left.height == right.height && left.channels == right.channels);
    image joined = image::filled(left.width + right.width, left.height, left.channels, 0);
    for (int y = 0; y < left.height; ++y) {
        const auto bytes_of = [](const image& i) {
            return static_cast<std::ptrdiff_t>(i.width) * i.channels;
        };
        const auto row_of = [&](const image& i) { return i.bytes.begin() + y * bytes_of(i); };
        const auto end =
            std::copy_n(row_of(left), bytes_of(left), joined.bytes.begin() + y * bytes_of(joined));
        std::copy_n(row_of(right), bytes_of(right), end);
    }
    return joined;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/metrics/plane_colors.hpp
// Meshes with every plane in a colour of its own, to look at.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// A colour, linear light, that differs from those of nearby ids; dark grey for no_id.
[[nodiscard]] inline vec3 color_of_plane(std::uint32_t id) noexcept {
    if (id == no_id) return vec3(0.06f);
    // Hues a golden section apart never come back; lightness changes as well.
    constexpr double golden_section = 0.61803398874989485;
    const double hue = 6 * std::fmod(id * golden_section, 1.0);
    const auto part = [hue](double middle) {
        const double away = std::abs(std::remainder(hue - middle, 6.0));
        return std::min(1.0, std::max(0.0, 2 - away));
    };
    constexpr double lightness[] = {1.0, 0.55, 0.8};
    const double light = lightness[id % 3];
    constexpr double white = 0.12;
    const vec3 pure(part(0), part(2), part(4));
    return vec3(static_cast<float>(white)) + pure * static_cast<float>(light * (0.9 - white));
}

/// The mesh with its alpha but without its looks: each face has the colour of its row in `ids`.
/// Corners are no longer shared.
///
/// Needs  a row of `ids` a face.
[[nodiscard]] inline mesh colored_by(const mesh& source, std::span<const std::uint32_t> ids) {
    BILLOW_ASSERT(ids.size() == source.face_count());
    mesh result;
    const auto unshare = [&](const auto& from, auto& to) {
        if (from.empty()) return;
        to.reserve(3 * source.face_count());
        for (const uvec3& t : source.triangles) {
            for (int k = 0; k < 3; ++k) to.push_back(from[t[k]]);
        }
    };
    unshare(source.positions, result.positions);
    unshare(source.normals, result.normals);
    unshare(source.feature_ids, result.feature_ids);
    for (std::size_t i = 0; i < uv_set_count; ++i) unshare(source.uv_sets[i], result.uv_sets[i]);
    for (face_id face = 0; face < source.face_count(); ++face) {
        result.triangles.push_back(uvec3(0, 1, 2) + 3u * face);
        for (int k = 0; k < 3; ++k) {
            const float alpha =
                source.colors.empty() ? 1.0f : source.colors[source.triangles[face][k]].w;
            result.colors.emplace_back(color_of_plane(ids[face]), alpha);
        }
    }
    result.face_materials = source.face_materials;
    for (const material& look : source.materials) {
        material plain;
        plain.base_color = vec4(1, 1, 1, look.base_color.w);
        plain.metallic = 0;
        plain.alpha = look.alpha;
        plain.alpha_cutoff = look.alpha_cutoff;
        plain.is_double_sided = look.is_double_sided;
        if (look.alpha != alpha_mode::opaque) plain.base_color_texture = look.base_color_texture;
        result.materials.push_back(std::move(plain));
    }
    result.images.resize(source.images.size());
    for (const material& look : result.materials) {
        const image_id id = look.base_color_texture.image;
        if (id >= source.images.size() || !result.images[id].empty()) continue;
        image& white = result.images[id] = source.images[id];
        const auto channels = static_cast<std::size_t>(white.channels);
        const std::size_t colors = channels == 2 || channels == 4 ? channels - 1 : channels;
        for (std::size_t i = 0; i < white.bytes.size(); i += channels) {
            for (std::size_t c = 0; c < colors; ++c) white.bytes[i + c] = 255;
        }
    }
    return result;
}

/// The feature id of each face: that of its first corner; no_id where the mesh has none.
[[nodiscard]] inline std::vector<std::uint32_t> features_of_faces(const mesh& of) {
    std::vector<std::uint32_t> ids(of.face_count(), no_id);
    if (of.feature_ids.empty()) return ids;
    for (face_id face = 0; face < of.face_count(); ++face) {
        ids[face] = of.feature_ids[of.triangles[face].x];
    }
    return ids;
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/pipeline.hpp
// A mesh in, a billboard cloud with its textures out, in one call.

#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

// ---- billow/pipeline/build_result.hpp
// What build_cloud is asked for and what it gives.

#include <cstdint>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// A length: a share of the radius of the mesh's bounding sphere, or scene units.
struct tolerance {
    double value = 0;
    bool is_of_radius = false;

    [[nodiscard]] static constexpr tolerance of_radius(double share) noexcept {
        return {share, true};
    }
    [[nodiscard]] static constexpr tolerance scene_units(double length) noexcept {
        return {length, false};
    }
    /// In scene units.
    [[nodiscard]] constexpr double in(const bounding_sphere& bounds) const noexcept {
        return is_of_radius ? value * bounds.radius : value;
    }
};

struct build_options {
    tolerance epsilon = tolerance::of_radius(0.1);  ///< largest distance of a vertex to its plane
    greedy_options search{};                        ///< its own epsilon is not read
    std::size_t planes = 0;      ///< 0: as many as epsilon asks for; else epsilon, where the search
                                 ///< starts, is changed until there are about so many
    bool refines_whole = false;  ///< refine_whole() after the search, where no vertex has moved
    whole_refinement_options whole{};  ///< its least_cosine is not read: it is the contribution's
    weld_options weld{};  ///< after the search; weld_online of a pipeline needs none here
    cardboard_options cardboard{.min_coverage = 0};  ///< none; its part is not read
    bake_options bake{};
    bool packs_tiles = true;  ///< else build_result::drawn is left for share_atlas
    parallel threads{};
};

/// Faces whose planes are searched together, and how: a trunk, or its foliage.
template <class Pipeline = pipeline<>>
struct part_plan {
    std::vector<face_id> faces{};  ///< each once, and in no other part
    build_options options{};  ///< a share of the radius is of the whole mesh; of `bake` only the
                              ///< thresholds are read, of threads nothing
    Pipeline method{};
};
template <class Pipeline>
part_plan(std::vector<face_id>, build_options, Pipeline) -> part_plan<Pipeline>;

/// What became of the faces of a mesh: every one is counted once.
struct face_counts {
    std::size_t mapped = 0;      ///< lie on a plane
    std::size_t kept = 0;        ///< of no part: stay a mesh
    std::size_t degenerate = 0;  ///< set aside: they have no area
    std::size_t dropped = 0;     ///< have an area, but no plane wanted them

    [[nodiscard]] std::size_t all() const noexcept { return mapped + kept + degenerate + dropped; }
};

/// How the planes of a part came about.
struct part_result {
    face_counts faces{};
    std::size_t plane_count = 0;       ///< that the search found, and refinement left
    std::size_t cardboard_planes = 0;  ///< that were added to them
    double epsilon = 0;                ///< scene units
    greedy_statistics statistics{};
    whole_refinement_report refined{};  ///< of build_options::refines_whole
    plane_curve curve{};                ///< of the planes that were found, welding not counted
};

/// A textured billboard cloud, and how it came about.
struct build_result {
    billboard_cloud cloud{};
    baked_cloud baked{};
    drawn_tiles drawn{};  ///< the tiles, where they were not packed
    mesh kept{};          ///< the faces of no part, as they are in the source
    face_counts faces{};
    greedy_statistics statistics{};    ///< sums over the parts; shares are of their common area
    std::vector<part_result> parts{};  ///< in the order of the plans
    cloud_errors errors{};
    std::vector<moved_face> moved{};  ///< whose corners welding moved, around cloud.bounds.centre
    weld_statistics weld{};           ///< of the welding after the search
    cloud_cracks cracks{};            ///< where corners have moved: without that,
    cloud_cracks cracks_drawn{};      ///< and with it
    double search_seconds = 0;
    double bake_seconds = 0;

    /// The cloud as a mesh that lies over the original, ready for write_glb. What was kept comes
    /// behind it, with its own materials and the feature id after that of the last plane.
    ///
    /// Needs  tiles that were packed.
    [[nodiscard]] mesh to_mesh() const {
        mesh result = cloud_mesh(cloud, baked);
        if (kept.face_count() > 0) {
            append_mesh(result, kept, static_cast<std::uint32_t>(cloud.plane_count()));
        }
        return result;
    }
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/pipeline/cloud_builder.hpp
// The steps from a mesh to its cloud, in their order: planes for each part, one cloud, welding,
// cardboard planes, rectangles, textures.

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

namespace detail {

/// One call of build_cloud; its methods are the steps in their order.
class cloud_builder {
public:
    /// `part_of_face`: no_id for a face that is kept; empty: all faces are of part 0.
    cloud_builder(const mesh& source, const build_options& options,
                  std::vector<part_id> part_of_face, std::size_t part_count,
                  const progress_function& progress)
        : source_(source),
          options_(options),
          part_of_face_(std::move(part_of_face)),
          part_count_(part_count),
          progress_(progress) {}

    /// `search_part(part)` calls search().
    template <class SearchPart>
    [[nodiscard]] expected<build_result> run(const SearchPart& search_part) {
        expected<face_table> faces = make_face_table(source_, options_.threads);
        if (!faces) return faces.error();
        faces_ = std::move(*faces);
        for (part_id part = 0; part < part_count_; ++part) search_part(part);
        result_.cloud = merged();
        keep_faces();
        weld();
        result_.search_seconds = seconds();
        if (result_.cloud.plane_count() > 0) texture();
        result_.bake_seconds = seconds() - result_.search_seconds;
        return std::move(result_);
    }

    template <class... Parts>
    void search(part_id part, const build_options& plan, const pipeline<Parts...>& method) {
        part_result told;
        told.epsilon = plan.epsilon.in(faces_.bounds);
        greedy_result found;
        const face_rows rows = rows_of(part);
        if (rows.empty()) {
            found.cloud.bounds = faces_.bounds;
            found.cloud.epsilon = told.epsilon;
            found.cloud.plane_of_face.assign(source_.face_count(), no_id);
        } else {
            const face_table of_part = select_rows(faces_, rows, options_.threads);
            found = find_planes(of_part, plan, method);
            told.epsilon = found.cloud.epsilon;
            rows_done_ += rows.size();
            if (plan.refines_whole && found.moved.empty()) {
                whole_refinement_options how = plan.whole;
                how.least_cosine = least_cosine_of(method.policies.contribution);
                told.refined = refine_whole(of_part, found.cloud, how, average_fit{},
                                            options_.threads, progress_);
                order_planes_by_area(of_part, found.cloud);
            }
            told.curve = curve_of(of_part, found.cloud);
        }
        count_faces(part, found.cloud, told.faces);
        told.plane_count = found.cloud.plane_count();
        told.statistics = found.statistics;
        told.statistics.degenerate_faces = told.faces.degenerate;
        add_statistics(told.statistics, area_of(rows));
        clouds_.push_back(std::move(found.cloud));
        result_.moved.insert(result_.moved.end(), found.moved.begin(), found.moved.end());
        welds_.push_back(plan.weld);
        cardboards_.push_back(plan.cardboard);
        thresholds_.push_back(plan.bake.alpha.thresholds);
        result_.parts.push_back(told);
    }

private:
    template <class... Parts>
    [[nodiscard]] greedy_result find_planes(face_table faces, const build_options& plan,
                                            const pipeline<Parts...>& method) const {
        greedy_options how = plan.search;
        how.epsilon = plan.epsilon.in(faces.bounds);
        const progress_function progress = progress_of(faces.size);
        if (plan.planes == 0) {
            return search_planes(std::move(faces), source_.face_count(), how, method,
                                 options_.threads, progress);
        }
        plane_budget_options budget;
        budget.first_epsilon = how.epsilon / faces.bounds.radius;
        return greedy_search_for_planes(faces, source_.face_count(), plan.planes, how, method,
                                        options_.threads, progress, budget)
            .result;
    }

    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }
    [[nodiscard]] part_id part_of(face_id face) const noexcept {
        return part_of_face_.empty() ? 0 : part_of_face_[face];
    }
    [[nodiscard]] face_rows rows_of(part_id part) const {
        face_rows rows;
        for (std::uint32_t row = 0; row < faces_.size; ++row) {
            if (part_of(faces_.source[row]) == part) rows.push_back(row);
        }
        return rows;
    }
    [[nodiscard]] double area_of(const face_rows& rows) const {
        double area = 0;
        for (const std::uint32_t row : rows) area += static_cast<double>(faces_.area[row]);
        return area;
    }

    /// Progress of one part as progress of the whole search.
    [[nodiscard]] progress_function progress_of(std::size_t rows) const {
        if (!progress_ || part_count_ == 1) return progress_;
        const auto all = static_cast<double>(std::max<std::size_t>(1, faces_.size));
        const double before = static_cast<double>(rows_done_) / all;
        const double share = static_cast<double>(rows) / all;
        return [this, before, share](std::string_view stage, double done) {
            progress_(stage, before + share * done);
        };
    }

    void count_faces(part_id part, const billboard_cloud& cloud, face_counts& counts) const {
        std::vector<char> is_degenerate(source_.face_count(), 0);
        for (const face_id face : faces_.degenerate) is_degenerate[face] = 1;
        for (face_id face = 0; face < source_.face_count(); ++face) {
            if (part_of(face) != part) continue;
            const bool is_mapped = cloud.plane_of_face[face] != no_id;
            ++(is_mapped                  ? counts.mapped
               : is_degenerate[face] != 0 ? counts.degenerate
                                          : counts.dropped);
        }
    }

    void add_statistics(const greedy_statistics& of, double area) {
        greedy_statistics& sum = result_.statistics;
        sum.refined_planes += of.refined_planes;
        sum.refinement_levels += of.refinement_levels;
        sum.fail_safes += of.fail_safes;
        sum.tweaks += of.tweaks;
        sum.degenerate_faces += of.degenerate_faces;
        sum.leftover_faces += of.leftover_faces;
        sum.dropped_faces += of.dropped_faces;
        area_done_ += area;
        const double share = area_done_ > 0 ? area / area_done_ : 0;
        const auto add_share = [share](double& to, double more) { to += (more - to) * share; };
        add_share(sum.leftover_area_share, of.leftover_area_share);
        add_share(sum.dropped_area_share, of.dropped_area_share);
        add_share(sum.beyond_epsilon_area_share, of.beyond_epsilon_area_share);
    }

    [[nodiscard]] billboard_cloud merged() {
        if (!clouds_.empty()) return merge_clouds(std::move(clouds_));
        billboard_cloud none;
        none.bounds = faces_.bounds;
        none.plane_of_face.assign(source_.face_count(), no_id);
        return none;
    }

    void keep_faces() {
        std::vector<face_id> kept;
        for (face_id face = 0; face < source_.face_count(); ++face) {
            if (part_of(face) == no_id) kept.push_back(face);
        }
        if (!kept.empty()) result_.kept = select_faces(source_, kept);
        for (const part_result& part : result_.parts) {
            result_.faces.mapped += part.faces.mapped;
            result_.faces.degenerate += part.faces.degenerate;
            result_.faces.dropped += part.faces.dropped;
        }
        result_.faces.kept = kept.size();
        BILLOW_ASSERT(result_.faces.all() == source_.face_count());
    }

    /// Adds what is welded now to what the searches have moved.
    void weld() {
        if (welds_.empty()) return;
        welded_faces welded = weld_faces(source_, result_.cloud, welds_);
        result_.weld = welded.statistics;
        result_.moved.insert(result_.moved.end(), welded.moved.begin(), welded.moved.end());
        std::erase_if(result_.moved, [&](const moved_face& moved) {
            return result_.cloud.plane_of_face[moved.face] == no_id;
        });
        std::sort(result_.moved.begin(), result_.moved.end(),
                  [](const moved_face& a, const moved_face& b) { return a.face < b.face; });
    }

    void texture() {
        if (result_.moved.empty()) {
            bake(source_, without_kept(std::move(faces_)));
            return;
        }
        double tolerance = 0;
        for (const weld_options& weld : welds_) tolerance = std::max(tolerance, weld.tolerance);
        const mesh drawn = drawn_mesh(source_, result_.cloud, result_.moved);
        result_.cracks = measure_cracks(source_, result_.cloud, source_, tolerance);
        result_.cracks_drawn = measure_cracks(source_, result_.cloud, drawn, tolerance);
        faces_ = *make_face_table(drawn, options_.threads);  // the source's was good
        bake(drawn, without_kept(std::move(faces_)));
    }

    void bake(const mesh& drawn, const face_table& table) {
        for (part_id part = 0; part < part_count_; ++part) {
            cardboards_[part].only_part = part;
            result_.parts[part].cardboard_planes =
                add_cardboard_planes(drawn, result_.cloud, cardboards_[part], options_.threads);
        }
        fit_billboards(drawn, result_.cloud, options_.threads);
        result_.errors = measure_errors(source_, result_.cloud);
        if (result_.faces.kept > 0) result_.errors.dropped_area_share = dropped_area_share();
        bake_options how = options_.bake;
        how.part_thresholds = thresholds_;
        if (options_.packs_tiles) {
            result_.baked =
                bake_cloud(drawn, table, result_.cloud, how, options_.threads, progress_);
        } else {
            result_.drawn =
                draw_tiles(drawn, table, result_.cloud, how, options_.threads, progress_);
        }
    }

    /// Without what is kept, which has no plane either.
    [[nodiscard]] double dropped_area_share() const {
        double dropped = 0;
        double all = 0;
        for (face_id face = 0; face < source_.face_count(); ++face) {
            const auto [a, b, c] = source_.corners(face);
            const double area = glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)));
            all += area;
            const bool is_lost =
                part_of(face) != no_id && result_.cloud.plane_of_face[face] == no_id;
            if (is_lost) dropped += area;
        }
        return all > 0 ? dropped / all : 0;
    }

    /// Billboards must not show what is kept.
    [[nodiscard]] face_table without_kept(face_table faces) const {
        if (result_.faces.kept == 0) return faces;
        face_rows rows;
        for (std::uint32_t row = 0; row < faces.size; ++row) {
            if (part_of(faces.source[row]) != no_id) rows.push_back(row);
        }
        return select_rows(faces, rows, options_.threads);
    }

    const mesh& source_;
    const build_options& options_;
    std::vector<part_id> part_of_face_;
    std::size_t part_count_;
    const progress_function& progress_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    face_table faces_{};
    std::size_t rows_done_ = 0;
    double area_done_ = 0;
    std::vector<billboard_cloud> clouds_{};
    std::vector<weld_options> welds_{};
    std::vector<cardboard_options> cardboards_{};
    std::vector<coverage_thresholds> thresholds_{};
    build_result result_{};
};

}  // namespace detail

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

namespace detail {

[[nodiscard]] inline expected<done> check_options(const build_options& options) {
    if (!(options.epsilon.value > 0) || !std::isfinite(options.epsilon.value)) {
        return error{
            error_code::invalid_options,
            "epsilon is " + std::to_string(options.epsilon.value) + ", but must be greater than 0"};
    }
    return done{};
}

/// The part of each face, no_id where it is in none.
class part_membership {
public:
    explicit part_membership(std::size_t face_count) : part_of_face(face_count, no_id) {}

    void add(std::span<const face_id> faces) {
        for (const face_id face : faces) {
            BILLOW_ASSERT(face < part_of_face.size() && part_of_face[face] == no_id);
            part_of_face[face] = part_count;
        }
        ++part_count;
    }

    std::vector<part_id> part_of_face;
    part_id part_count = 0;
};

}  // namespace detail

/// Makes a billboard cloud of a mesh.
///
/// Needs   options within the ranges that greedy_options and bake_options state.
/// Fails   invalid_options: an epsilon that is not a positive number; and as make_face_table.
///         A mesh without any area gives a cloud without planes.
/// Cost    as greedy_search and bake_cloud. The cloud is the same for any number of threads.
template <class... Parts>
[[nodiscard]] expected<build_result> build_cloud(const mesh& source, const build_options& options,
                                                 const pipeline<Parts...>& parts,
                                                 const progress_function& progress = {}) {
    if (const auto good = detail::check_options(options); !good) return good.error();
    detail::cloud_builder builder(source, options, {}, 1, progress);
    return builder.run([&](part_id part) { builder.search(part, options, parts); });
}
[[nodiscard]] inline expected<build_result> build_cloud(const mesh& source,
                                                        const build_options& options = {}) {
    return build_cloud(source, options, pipeline{});
}

/// Makes one cloud of several parts of a mesh, each searched alone and in its own way: planes of
/// leaves do not slice the trunk, and a trunk may be finer or coarser than they are. All share the
/// atlases. The faces of no part stay a mesh: build_result::kept.
///
/// Needs   as above for every plan, and its faces within the mesh. Of `options`, bake and threads
///         are read; each part has its own thresholds.
/// Fails   as above.
/// Source  Fuhrmann et al. 2005, section 3.2.2.
template <class Pipeline>
[[nodiscard]] expected<build_result> build_cloud(const mesh& source, const build_options& options,
                                                 std::span<const part_plan<Pipeline>> plans,
                                                 const progress_function& progress = {}) {
    detail::part_membership members(source.face_count());
    for (const part_plan<Pipeline>& plan : plans) {
        if (const auto good = detail::check_options(plan.options); !good) return good.error();
        members.add(plan.faces);
    }
    detail::cloud_builder builder(source, options, std::move(members.part_of_face), plans.size(),
                                  progress);
    return builder.run(
        [&](part_id part) { builder.search(part, plans[part].options, plans[part].method); });
}
template <class Pipeline>
[[nodiscard]] expected<build_result> build_cloud(const mesh& source, const build_options& options,
                                                 const std::vector<part_plan<Pipeline>>& plans,
                                                 const progress_function& progress = {}) {
    return build_cloud(source, options, std::span(plans), progress);
}

/// The same for plans of different types.
template <class... Pipelines>
[[nodiscard]] expected<build_result> build_cloud(const mesh& source, const build_options& options,
                                                 const progress_function& progress,
                                                 const part_plan<Pipelines>&... plans) {
    detail::part_membership members(source.face_count());
    expected<done> good = done{};
    const auto add = [&](const auto& plan) {
        if (good) good = detail::check_options(plan.options);
        members.add(plan.faces);
    };
    (add(plans), ...);
    if (!good) return good.error();
    detail::cloud_builder builder(source, options, std::move(members.part_of_face),
                                  sizeof...(plans), progress);
    return builder.run([&](part_id part) {
        part_id next = 0;
        const auto search = [&](const auto& plan) {
            if (next++ == part) builder.search(part, plan.options, plan.method);
        };
        (search(plans), ...);
    });
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/pipeline/choose.hpp
// How fine a cloud has to be for the distance from which it is seen: epsilon and the texel's size.
//
// Luksch, "Implementation of an improved billboard cloud algorithm", 2009, section 6.2, leaves the
// choice of both for a given distance to future work. The formula is that of switch distances.

#include <algorithm>


namespace billow::inline BILLOW_ABI {

/// From where a cloud is seen, and how far it may be off there.
///
/// Needs  all above 0; no least above its most.
struct viewing_options {
    double distance = 0;  ///< from the eye to the centre of the bounding sphere, scene units
    lod_screen screen{};
    double pixel_error = 1;        ///< pixels by which a vertex may be off
    double texel_error = 1;        ///< pixels that the side of a texel may cover
    double least_epsilon = 0.005;  ///< radii; finer, a cloud has nearly as many planes as faces
    double most_epsilon = 0.5;     ///< radii; coarser, little but a single plane is left
    double least_texels = 16;      ///< along the diameter; with fewer, tiles have no outlines
    double most_texels = 2048;     ///< along the diameter; with more, atlases fill gigabytes
};

/// What was chosen. Lengths are in scene units.
struct viewing_choice {
    double pixel = 0;           ///< length that a pixel shows, at the nearest point of the sphere
    double epsilon = 0;         ///< within the bounds of the options
    double wanted_epsilon = 0;  ///< what pixel_error asks for
    double texel_size = 0;      ///< within the bounds of the options
    double wanted_texel_size = 0;  ///< what texel_error asks for
    double error_px = 0;           ///< pixels that epsilon covers: pixel_error, but for the bounds
    double texel_px = 0;           ///< pixels that a texel covers: texel_error, but for the bounds
    double object_px = 0;          ///< pixels that the diameter covers, at the centre's distance
};

/// The largest epsilon and texel that show no larger than asked for. Both are seen at the point of
/// the bounding sphere that is nearest to the eye, or at the screen's near distance where the eye is
/// closer: pixel = max(distance - radius, near) / pixels_at_one.
///
/// Gives   wanted lengths, and the same within the bounds, which do not count for a sphere without
///         a radius.
/// Source  The inverse of pixels_of_error.
[[nodiscard]] inline viewing_choice choose_for(const bounding_sphere& bounds,
                                               const viewing_options& seen) noexcept {
    BILLOW_ASSERT(seen.distance > 0 && seen.pixel_error > 0 && seen.texel_error > 0);
    const auto shown = [&](double pixels) {
        return error_for_pixels(pixels, bounds.radius, seen.distance, seen.screen);
    };
    viewing_choice choice{.pixel = shown(1),
                          .wanted_epsilon = shown(seen.pixel_error),
                          .wanted_texel_size = shown(seen.texel_error)};
    choice.epsilon = choice.wanted_epsilon;
    choice.texel_size = choice.wanted_texel_size;
    if (bounds.radius > 0) {
        const double diameter = 2 * bounds.radius;
        choice.epsilon = std::clamp(choice.epsilon, seen.least_epsilon * bounds.radius,
                                    seen.most_epsilon * bounds.radius);
        choice.texel_size = std::clamp(choice.texel_size, diameter / seen.most_texels,
                                       diameter / seen.least_texels);
    }
    choice.error_px = choice.epsilon / choice.pixel;
    choice.texel_px = choice.texel_size / choice.pixel;
    choice.object_px = pixels_of_error(2 * bounds.radius, 0, seen.distance, seen.screen);
    return choice;
}

/// Sets epsilon and the size of texels; the rest stays.
inline void apply(const viewing_choice& choice, build_options& to) noexcept {
    to.epsilon = tolerance::scene_units(choice.epsilon);
    to.bake.texels_per_unit = 1 / choice.texel_size;
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/pipeline/shared_atlas.hpp
// Several clouds in one set of atlases: one material, so one draw call for all of them.

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Faces [begin, end) of a mesh.
struct face_range {
    std::size_t begin = 0;
    std::size_t end = 0;

    [[nodiscard]] std::size_t size() const noexcept { return end - begin; }
};

/// Where a cloud lies in a mesh that it shares.
struct atlas_member {
    face_range billboards{};
    face_range kept{};  ///< what stayed a mesh
};

struct shared_atlas {
    mesh drawn{};                         ///< all clouds; feature ids count anew for each
    std::vector<atlas_member> members{};  ///< in the order of the clouds
    baked_cloud baked{};                  ///< tiles of all billboards; texel sizes are the first's
};

namespace detail {

/// The billboards and tiles of several clouds as those of one.
struct joined_tiles {
    billboard_cloud cloud{};
    drawn_tiles drawn{};

    void add(build_result& from) {
        drawn_tiles& tiles = from.drawn;
        const std::size_t before = cloud.billboards.size();
        const std::size_t fronts = from.cloud.billboards.size();
        cloud.billboards.insert(cloud.billboards.end(), from.cloud.billboards.begin(),
                                from.cloud.billboards.end());
        // Fronts stay in front of all backs, so the backs of `from` come after those that are there.
        const auto place = drawn.tiles.begin() + static_cast<std::ptrdiff_t>(before);
        const auto first_back = tiles.tiles.begin() + static_cast<std::ptrdiff_t>(fronts);
        const auto backs_begin = static_cast<std::uint32_t>(drawn.tiles.size() + fronts);
        drawn.tiles.insert(place, std::move_iterator(tiles.tiles.begin()),
                           std::move_iterator(first_back));
        drawn.tiles.insert(drawn.tiles.end(), std::move_iterator(first_back),
                           std::move_iterator(tiles.tiles.end()));
        for (std::uint32_t& back : drawn.back_of) {
            if (back != no_id) back += static_cast<std::uint32_t>(fronts);
        }
        for (std::size_t i = 0; i < fronts; ++i) {
            const std::uint32_t back = tiles.back_of.empty() ? no_id : tiles.back_of[i];
            drawn.back_of.push_back(
                back == no_id ? no_id : backs_begin + back - static_cast<std::uint32_t>(fronts));
        }
        drawn.outlines.insert(drawn.outlines.end(), std::move_iterator(tiles.outlines.begin()),
                              std::move_iterator(tiles.outlines.end()));
        drawn.opaque_area += tiles.opaque_area;
        drawn.polygon_area += tiles.polygon_area;
        if (before == 0) {
            drawn.texel_size = tiles.texel_size;
            drawn.wanted_size = tiles.wanted_size;
        }
        tiles = {};
    }
};

}  // namespace detail

/// Packs the tiles of clouds that were built with build_options::packs_tiles off, and takes them away
/// from there.
///
/// Needs   clouds baked with the same normals, outlines or none in all, and channels; `options` as
///         theirs.
/// Gives   atlases and a mesh in which each cloud has its faces together. Clouds without planes have
///         none.
[[nodiscard]] inline shared_atlas share_atlas(std::span<build_result> clouds,
                                              const bake_options& options, parallel threads = {}) {
    shared_atlas result;
    detail::joined_tiles all;
    std::vector<std::size_t> first_billboard;
    for (build_result& cloud : clouds) {
        first_billboard.push_back(all.cloud.billboards.size());
        all.add(cloud);
    }
    first_billboard.push_back(all.cloud.billboards.size());
    result.baked = pack_tiles(std::move(all.drawn), options, threads);
    result.drawn = cloud_mesh(all.cloud, result.baked);

    mesh& drawn = result.drawn;
    std::size_t face = 0;
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        const std::size_t begin = face;
        while (face < drawn.face_count() &&
               drawn.feature_ids[drawn.triangles[face].x] < first_billboard[i + 1]) {
            ++face;
        }
        result.members.push_back({.billboards = {begin, face}});
    }
    std::size_t cloud = 0;
    for (std::uint32_t& id : drawn.feature_ids) {  // ascending
        while (id >= first_billboard[cloud + 1]) ++cloud;
        id -= static_cast<std::uint32_t>(first_billboard[cloud]);
    }
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        const std::size_t begin = drawn.face_count();
        if (clouds[i].kept.face_count() > 0) {
            append_mesh(drawn, clouds[i].kept,
                        static_cast<std::uint32_t>(clouds[i].cloud.plane_count()));
        }
        result.members[i].kept = {begin, drawn.face_count()};
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/lod/chain.hpp
// Levels of detail of one mesh: billboard clouds of fewer and fewer planes, each made of the one
// above or of the mesh.
//
// Fuhrmann et al. 2005, section 3.3.8: a level that is made of the billboards of the level above
// keeps near their planes, so that a switch between the two shows less.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// ---- billow/lod/displacement.hpp
// Where a level of detail draws each corner of the original mesh, composed through the levels that it
// was made of, and how many planes two levels share.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>


namespace billow::inline BILLOW_ABI {

namespace detail {

/// Of the planes of a billboard's triangles the one that is farthest from a face. A search with
/// leftovers may part the triangles, and then any of those planes may show the face.
[[nodiscard]] inline plane_id farthest_plane(const billboard_cloud& cloud,
                                             std::span<const face_id> triangles,
                                             const std::array<dvec3, 3>& corners) noexcept {
    plane_id farthest = no_id;
    double most = -1;
    for (const face_id triangle : triangles) {
        const plane_id plane = cloud.plane_of_face[triangle];
        if (plane == no_id || plane == farthest) continue;
        double distance = 0;
        for (const dvec3& corner : corners) {
            distance = std::max(distance, glm::distance(corner, foot_on(cloud, plane, corner)));
        }
        if (distance > most) most = distance, farthest = plane;
    }
    return farthest;
}

}  // namespace detail

/// Where a cloud of the billboards of the level `above` draws the faces. Needs the billboard of each
/// face that the cloud was made of.
[[nodiscard]] inline drawn_faces drawn_through(const billboard_cloud& cloud,
                                               std::span<const plane_id> billboard_of_face,
                                               std::size_t billboard_count,
                                               const drawn_faces& above) {
    const faces_of_planes triangles(billboard_of_face, billboard_count);
    return detail::drawn_on(cloud, above, [&](face_id face) {
        const plane_id billboard = above.plane_of_face[face];
        if (billboard == no_id) return no_id;
        return detail::farthest_plane(cloud, triangles[billboard], above.corners[face]);
    });
}

/// Share of the planes of `coarse` that are nearly planes of `fine`: angle between the normals at most
/// `max_angle_rad`, and of `fine` the centre of a billboard no farther from the plane than
/// `max_distance`. 0 without planes.
[[nodiscard]] inline double share_of_kept_planes(const billboard_cloud& coarse,
                                                 const billboard_cloud& fine, double max_angle_rad,
                                                 double max_distance) {
    const double least_cosine = std::cos(max_angle_rad);
    std::size_t kept = 0;
    for (const plane& p : coarse.planes) {
        for (plane_id id = 0; id < fine.plane_count(); ++id) {
            const billboard& b = fine.billboards[id];
            const dvec3 centre = b.origin + b.axes.u * (b.width / 2) + b.axes.v * (b.height / 2);
            if (std::abs(glm::dot(p.normal, fine.planes[id].normal)) >= least_cosine &&
                std::abs(signed_distance(p, centre - coarse.bounds.centre)) <= max_distance) {
                ++kept;
                break;
            }
        }
    }
    return coarse.planes.empty()
               ? 0
               : static_cast<double>(kept) / static_cast<double>(coarse.plane_count());
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/lod/whole_billboards.hpp
// Keeps the triangles of a billboard together when a cloud's mesh is what the next planes are
// searched for.

#include <cstdint>
#include <utility>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// The billboard of each face of a cloud's mesh, which are its feature ids.
[[nodiscard]] inline std::vector<plane_id> billboards_of_faces(const mesh& cloud) {
    std::vector<plane_id> billboards;
    billboards.reserve(cloud.face_count());
    for (const uvec3& triangle : cloud.triangles) {
        billboards.push_back(cloud.feature_ids[triangle.x]);
    }
    return billboards;
}

/// Vertices stay; a plane takes all triangles of a billboard or none. Those that are left of one
/// after its others have gone, or had no area, count as the whole of it.
class whole_billboards : public fixed_vertices {
public:
    whole_billboards() = default;
    /// Needs  triangles of a billboard one after the other, as cloud_mesh lays them.
    explicit whole_billboards(std::vector<plane_id> billboard_of_face)
        : billboard_of_face_(std::move(billboard_of_face)) {}

    /// Needs  rows of `faces` in the order of the mesh, as the search keeps them.
    void keep_allowed(const face_table& faces, const plane&, face_rows& rows) const {
        const auto billboard_of = [&](std::size_t row) {
            return billboard_of_face_[faces.source[row]];
        };
        std::size_t kept = 0;
        for (std::size_t begin = 0; begin < rows.size();) {
            const plane_id billboard = billboard_of(rows[begin]);
            std::size_t end = begin + 1;
            while (end < rows.size() && billboard_of(rows[end]) == billboard) ++end;
            const std::uint32_t first = rows[begin];
            const std::uint32_t last = rows[end - 1];
            const bool is_whole = last - first == end - 1 - begin &&
                                  (first == 0 || billboard_of(first - 1) != billboard) &&
                                  (last + 1 == faces.size || billboard_of(last + 1) != billboard);
            for (; begin < end; ++begin) {
                if (is_whole) rows[kept++] = rows[begin];
            }
        }
        rows.resize(kept);
    }

private:
    std::vector<plane_id> billboard_of_face_{};
};
static_assert(vertex_motion<whole_billboards>);

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

enum class lod_source {
    level_above,  ///< incremental, Fuhrmann et al. 2005
    mesh,         ///< independent of the other levels
};

struct lod_options {
    std::vector<std::size_t> levels{24, 11, 4};  ///< most planes of each level, descending
    lod_source made_of = lod_source::level_above;
    std::size_t least_incremental =
        10;                    ///< levels of fewer planes are made of the mesh; Fuhrmann et
                               ///< al. 2005: bad results below 10
    double texel_share = 0.5;  ///< texels along the diameter, of those of the level above
    build_options build{};     ///< texels of level 0; epsilon and most planes are not read
};

/// A level of detail.
struct lod_level {
    build_result built{};
    std::size_t most_planes = 0;            ///< as asked for
    lod_source made_of = lod_source::mesh;  ///< level 0 always of the mesh
    /// No corner is drawn farther from its place, scene units: epsilon, or what was met where that is
    /// larger, and the bound of the level it is made of.
    double error_bound = 0;
    displacement error{};  ///< from the mesh, composed through the levels
    displacement jump{};   ///< from the level above, at the switch; level 0: from the mesh
};

struct lod_chain {
    bounding_sphere bounds{};  ///< of the mesh
    std::vector<lod_level> levels{};
};

/// Makes a cloud of at most `most_planes` planes, with the rest of the options as they are.
template <class B>
concept level_builder = requires(const B& build, const mesh& source, const build_options& options,
                                 std::size_t most_planes, const progress_function& progress) {
    { build(source, options, most_planes, progress) } -> std::same_as<expected<build_result>>;
};

namespace detail {

[[nodiscard]] inline std::optional<error> fault_of(const lod_options& options) {
    const auto refuse = [](const std::string& why) {
        return error{error_code::invalid_options, why};
    };
    if (options.levels.empty()) return refuse("a chain needs a level");
    std::size_t above = 10001;
    for (const std::size_t planes : options.levels) {
        if (planes < 1 || planes > 10000) {
            return refuse("a level of " + std::to_string(planes) +
                          " planes is not between 1 and 10000");
        }
        if (planes >= above) return refuse("levels must have fewer and fewer planes");
        above = planes;
    }
    if (!(options.texel_share > 0 && options.texel_share <= 1)) {
        return refuse("the share of texels must be above 0 and at most 1");
    }
    return std::nullopt;
}

}  // namespace detail

/// Makes a chain with two builders: one for the mesh, one for the mesh of a cloud, which
/// keeps billboards whole.
///
/// Shape   one level an entry of options.levels.
/// Fails   invalid_options: levels that are none, not descending or outside 1 to 10000, a texel share
///         outside (0, 1]; and as the builders.
/// Cost    that of the builders, and 100 bytes a face. Same result for any number of threads when the
///         builders' is.
/// Source  Fuhrmann et al. 2005, section 3.3.8. Differs: epsilon follows from the number of planes.
template <level_builder FromMesh, level_builder FromBillboards>
[[nodiscard]] expected<lod_chain> build_lod_chain(const mesh& source, const lod_options& options,
                                                  const FromMesh& from_mesh,
                                                  const FromBillboards& from_billboards,
                                                  const progress_function& progress = {}) {
    if (const auto fault = detail::fault_of(options)) return *fault;
    lod_chain chain;
    build_options build = options.build;
    double texel_share = 1;
    drawn_faces original;
    drawn_faces above;
    for (const std::size_t most_planes : options.levels) {
        const std::size_t number = chain.levels.size();
        const bool is_incremental = number > 0 && options.made_of == lod_source::level_above &&
                                    most_planes >= options.least_incremental;
        build.bake.texels =
            std::max(1, static_cast<int>(std::lround(options.build.bake.texels * texel_share)));
        build.bake.texels_per_unit = options.build.bake.texels_per_unit * texel_share;
        texel_share *= options.texel_share;
        progress_function tell;
        if (progress) {
            tell = [&](std::string_view stage, double share) {
                progress("level " + std::to_string(number) + ": " + std::string(stage), share);
            };
        }
        const mesh billboards = is_incremental ? cloud_mesh(chain.levels.back().built.cloud,
                                                            chain.levels.back().built.baked)
                                               : mesh{};
        auto built = is_incremental ? from_billboards(billboards, build, most_planes, tell)
                                    : from_mesh(source, build, most_planes, tell);
        if (!built) return built.error();

        lod_level level{.built = std::move(*built), .most_planes = most_planes};
        if (number == 0) {  // the builder has checked the mesh
            chain.bounds = level.built.cloud.bounds;
            original = undisplaced(source);
            above = original;
        }
        const billboard_cloud& cloud = level.built.cloud;
        level.error_bound = std::max(cloud.epsilon, level.built.errors.max_error);
        // Welding moves a corner by epsilon at most, along its plane while its distance stays.
        if (!level.built.moved.empty()) level.error_bound *= std::numbers::sqrt2;
        if (is_incremental) {
            level.made_of = lod_source::level_above;
            level.built.kept = chain.levels.back().built.kept;
            level.error_bound += chain.levels.back().error_bound;
        }
        drawn_faces drawn =
            is_incremental
                ? drawn_through(cloud, billboards_of_faces(billboards),
                                chain.levels[number - 1].built.cloud.plane_count(), above)
                : drawn_by(cloud, original, level.built.moved);
        level.error = displacement_between(source, original, drawn);
        level.jump = displacement_between(source, above, drawn);
        above = std::move(drawn);
        chain.levels.push_back(std::move(level));
    }
    return chain;
}

namespace detail {

/// An epsilon of a cloud of about `most_planes` planes and not more, scene units. Searches that find
/// more are stopped and count for nothing.
template <class... Parts>
[[nodiscard]] double epsilon_of_level(const face_table& faces, std::size_t face_count,
                                      const build_options& options, std::size_t most_planes,
                                      const pipeline<Parts...>& parts) {
    const auto search = [&](double epsilon, std::size_t limit) {
        greedy_options how = options.search;
        how.epsilon = epsilon;
        how.max_planes = most_planes + 1;
        const auto found = search_planes(faces, face_count, how, parts, options.threads);
        const std::size_t planes = found.cloud.plane_count();
        return planes > most_planes ? limit + 1 : planes;
    };
    return search_for_planes(most_planes, faces.bounds.radius, search,
                             [](std::size_t planes) { return planes; }, {.most_epsilon = 2})
        .epsilon;
}

template <class... Parts>
[[nodiscard]] expected<build_result> build_level(const mesh& source, build_options options,
                                                 std::size_t most_planes,
                                                 const pipeline<Parts...>& parts,
                                                 const progress_function& progress) {
    const auto faces = make_face_table(source, options.threads);
    if (!faces) return faces.error();
    options.epsilon = tolerance::scene_units(1);
    if (faces->size > 0) {
        report(progress, "search", 0);
        options.epsilon = tolerance::scene_units(
            epsilon_of_level(*faces, source.face_count(), options, most_planes, parts));
    }
    options.planes = 0;
    options.search.max_planes = most_planes;
    return build_cloud(source, options, parts, progress);
}

}  // namespace detail

/// Makes a chain with a pipeline. Levels that are made of billboards keep them whole instead of
/// moving vertices: billboards share none.
template <class... Parts>
[[nodiscard]] expected<lod_chain> build_lod_chain(const mesh& source, const lod_options& options,
                                                  const pipeline<Parts...>& parts,
                                                  const progress_function& progress = {}) {
    const auto from_mesh = [&](const mesh& of, const build_options& build, std::size_t most_planes,
                               const progress_function& tell) {
        return detail::build_level(of, build, most_planes, parts, tell);
    };
    const auto from_billboards = [&](const mesh& of, build_options build, std::size_t most_planes,
                                     const progress_function& tell) {
        build.search.skip_area = 0;  // a billboard shows many faces
        build.search.min_contribution = 0;
        build.weld = {};              // billboards share no vertex
        build.refines_whole = false;  // it would tear them apart
        const pipeline whole{parts.space, parts.policies, parts.fitter, parts.grouping,
                             whole_billboards(billboards_of_faces(of))};
        return detail::build_level(of, build, most_planes, whole, tell);
    };
    return build_lod_chain(source, options, from_mesh, from_billboards, progress);
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/lod/switch_distance.hpp
// From which distance a level of detail may be drawn, and how engines spell that distance.
//
// Differs from a table of fixed distances: an error in scene units becomes one in pixels, so one
// cloud serves every screen. The formula is that of meshoptimizer's clustered levels of detail.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// The distance from which each level may be drawn, finest first. Never less than that of the level
/// above, so that levels follow each other.
[[nodiscard]] inline std::vector<double> switch_distances(std::span<const double> errors,
                                                          double radius, double pixels,
                                                          const lod_screen& screen) {
    std::vector<double> distances;
    double least = 0;
    for (const double error : errors) {
        least = std::max(least, distance_for_pixels(error, radius, pixels, screen));
        distances.push_back(least);
    }
    return distances;
}

/// Height of an object of `size` over that of the screen: 1 fills it. Unity's
/// screenRelativeTransitionHeight, where size is the longest side of the object's box, and Houdini's
/// lod_screensizes. Infinite at distance 0.
[[nodiscard]] inline double relative_screen_height(double size, double distance,
                                                   const lod_screen& screen) noexcept {
    if (!(distance > 0)) return std::numeric_limits<double>::infinity();
    return size / (2 * distance * std::tan(screen.fov_y / 2));
}

/// The distance at which an object of `size` has that share of the screen's height: the inverse of
/// relative_screen_height. Needs relative_height > 0.
[[nodiscard]] inline double distance_for_screen_height(double size, double relative_height,
                                                       const lod_screen& screen) noexcept {
    return size / (2 * relative_height * std::tan(screen.fov_y / 2));
}

/// Share of the screen's area that the disc of a sphere covers, at most 1: for MSFT_screencoverage,
/// whose text leaves open what is covered. Entry i there is the end of level i, so the coverage at
/// the switch distance of level i + 1.
[[nodiscard]] inline double screen_coverage(double radius, double distance,
                                            const lod_screen& screen) noexcept {
    const double height = relative_screen_height(2 * radius, distance, screen);
    const double aspect = static_cast<double>(screen.width_px) / screen.height_px;
    return std::min(1.0, std::numbers::pi / 4 * height * height / aspect);
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/presets.hpp
// Presets: the published ways to make a billboard cloud, by name, and ours.
//
// Each reads like the parameter table of its paper. A preset is a value: change what you like before
// you give its options and its method to build_cloud.


namespace billow::inline BILLOW_ABI {

/// What a preset fixes: values in `options`, types in `method`.
template <class Pipeline>
struct preset {
    build_options options{};
    Pipeline method{};
};
template <class Pipeline>
preset(build_options, Pipeline) -> preset<Pipeline>;

/// A preset for trees, whose foliage and trunk are searched apart.
template <class Foliage, class Trunk>
struct tree_preset {
    Foliage foliage{};
    Trunk trunk{};
};
template <class Foliage, class Trunk>
tree_preset(Foliage, Trunk) -> tree_preset<Foliage, Trunk>;

namespace presets {

/// Billboard clouds as first published: penalty 10, also inside the refinement into 216 sub-bins;
/// planes as they are found; compact textures.
///
/// Source  Décoret, Durand, Sillion, Dorsey: Billboard clouds for extreme model simplification.
///         SIGGRAPH 2003. Differs: 2,593 normals, which they do not state.
[[nodiscard]] inline auto classic() {
    build_options options;
    options.epsilon = tolerance::of_radius(0.05);
    options.search.refine = refinement::original;
    options.search.penalty_in_refinement = true;
    return preset{options, pipeline{spherical(18),
                                    density_policies{intersection_of_vertices{}, projected_area{},
                                                     inner_side_penalty{10}},
                                    no_fit{}, heaviest_group{}}};
}

/// The thesis that put billboard clouds right: raster 18, 1.5 offset bins an epsilon, penalty 3,
/// distance falloff, least squares; the last 2 % of the area are not worth a plane; the cracks of
/// solids are welded.
///
/// Source  Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
///         table 5.7. Differs: a fitted plane keeps epsilon.
[[nodiscard]] inline auto thesis(model_kind kind = model_kind::solid) {
    build_options options;
    options.epsilon = tolerance::of_radius(0.05);
    options.search.rho_rate = 1.5;
    options.search.refine = refinement::fail_safe;
    options.search.skip_area = 0.02;
    options.weld.kind = kind == model_kind::solid ? weld_kind::intersection : weld_kind::none;
    return preset{options, pipeline{cube_map(18),
                                    density_policies{hull_of_samples{}, projected_area{},
                                                     inner_side_penalty{3}, distance_falloff{}},
                                    least_squares_fit{}}};
}

/// Trees: angular contribution for leaves, horizontal planes held back by 60 % from 50° on, texels
/// opaque from 0.3; the trunk is welded while it is searched, and thin parts of it get cardboard
/// planes where these show 80 %.
///
/// Source  Fuhrmann, Umlauf, Mantler: Extreme model simplification for forest rendering. Eurographics
///         Workshop on Natural Phenomena 2005, section 3.3.
[[nodiscard]] inline auto tree() {
    build_options foliage;
    foliage.epsilon = tolerance::of_radius(0.1);
    foliage.bake.alpha.thresholds.foliage = 0.3;
    build_options trunk = foliage;
    trunk.cardboard.min_coverage = 0.8;
    return tree_preset{
        preset{foliage,
               pipeline{cube_map(18),
                        density_policies{hull_of_samples{}, angular_area{}, inner_side_penalty{3},
                                         no_falloff{},
                                         horizontal_penalty{.share = 0.60, .cutoff_deg = 50}},
                        average_fit{}}},
        preset{trunk, pipeline{cube_map(18),
                               density_policies{hull_of_samples{}, projected_area{},
                                                inner_side_penalty{3}},
                               average_fit{}, whole_set{}, weld_online{}}}};
}

/// Solids, ours: the thesis's, but every face keeps epsilon.
[[nodiscard]] inline auto solid() {
    auto made = thesis(model_kind::solid);
    made.options.search.skip_area = 0;
    return made;
}

/// Trees, what measures best: leaves by exact offsets, frontal ones counting more, then refinement of
/// the whole; the trunk as in tree().
[[nodiscard]] inline auto exact_tree() {
    const auto from = tree();
    build_options foliage = from.foliage.options;
    foliage.refines_whole = true;
    return tree_preset{
        preset{foliage, pipeline{cube_map(18), from.foliage.method.policies, average_fit{},
                                 whole_set{}, fixed_vertices{}, exact_method{.tangency = 1}}},
        from.trunk};
}

}  // namespace presets

/// Makes a cloud of a tree: roles tell its faces apart.
///
/// Needs, Fails, Cost  as build_cloud for parts.
template <class Foliage, class Trunk>
[[nodiscard]] expected<build_result> build_tree(const mesh& source, const face_roles& roles,
                                                const tree_preset<Foliage, Trunk>& how,
                                                const build_options& options,
                                                const progress_function& progress = {}) {
    return build_cloud(
        source, options, progress,
        part_plan{roles.faces_of(face_role::foliage), how.foliage.options, how.foliage.method},
        part_plan{roles.faces_of(face_role::solid), how.trunk.options, how.trunk.method});
}

}  // namespace billow::inline BILLOW_ABI
