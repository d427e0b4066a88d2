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

#include <cstddef>
#include <cstdint>
#include <cstring>


#if BILLOW_LANES == 4 && defined(__SSE__)
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
[[nodiscard]] inline float select(bool mask, float yes, float no) noexcept {
    return mask ? yes : no;
}
[[nodiscard]] inline std::int32_t truncate(float a) noexcept {
    return static_cast<std::int32_t>(a);
}
[[nodiscard]] inline float to_float(std::int32_t a) noexcept { return static_cast<float>(a); }

/// Number of lanes of V, and V read from or written to memory (no alignment needed).
template <class V>
struct lanes {
    static constexpr std::size_t count = 1;
    static V load(const float* from) noexcept { return *from; }
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
[[nodiscard]] inline wide select(wide_int mask, wide yes, wide no) noexcept {
    return mask ? yes : no;
}
[[nodiscard]] inline wide_int truncate(wide a) noexcept {
    return __builtin_convertvector(a, wide_int);
}
[[nodiscard]] inline wide to_float(wide_int a) noexcept { return __builtin_convertvector(a, wide); }

template <>
struct lanes<wide> {
    static constexpr std::size_t count = lane_count;
    static wide load(const float* from) noexcept {
        wide value;
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

}  // namespace billow::inline BILLOW_ABI::simd
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

// ---- billow/mesh/face_table.hpp
// The faces of a mesh as the plane search reads them: columns of floats around the origin.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
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
        double reach = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            faces.corner[k].set(row, corners[k]);
            reach = std::max(reach, glm::length(corners[k]));
        }
        faces.normal.set(row, cross / doubled_area);
        faces.area[row] = static_cast<float>(doubled_area / 2);
        faces.reach[row] = static_cast<float>(reach);
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

#include <concepts>


namespace billow::inline BILLOW_ABI {

/// Worth of drawing a face on a plane with the given normal, in scene units squared. Pure, at most
/// the area of the face, and the same for n and -n: faces are seen from both sides, and the density
/// grid keeps one row for both.
template <class P, class V = float>
concept contribution = std::copyable<P> &&
    requires(const P& worth, const face_lanes<V>& face, const vec3_lanes<V>& normal) {
    { worth(face, normal) }
    noexcept->std::same_as<V>;
};

/// Area of the face seen along the plane's normal. Source: Luksch 2009, eq 3.4. Differs by the
/// absolute value, without which faces that look the other way would count as negative.
struct projected_area {
    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        return face.area * simd::min(simd::abs(dot(face.normal, normal)), simd::lanes<V>::fill(1));
    }
};
static_assert(contribution<projected_area> && contribution<projected_area, simd::wide>);

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
/// the bin before their starts. The coverage of bin b is Σ step[0..b] - before[b].
struct ramp {
    std::int64_t step = 0;
    std::int64_t before = 0;

    friend bool operator==(const ramp&, const ramp&) = default;
};

/// One row of bins an orientation, in contributions and in uncharged penalties (weight 1).
///
/// Unit  1 / scale scene units squared.
class density_grid {
public:
    density_grid(std::size_t row_count, const offset_axis& axis, double scale)
        : axis_(axis),
          scale_(scale),
          contribution_(row_count * stride(axis)),
          penalty_(row_count * stride(axis)) {}

    [[nodiscard]] const offset_axis& axis() const noexcept { return axis_; }
    /// Units of the integers per scene unit squared.
    [[nodiscard]] double scale() const noexcept { return scale_; }
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
                const double c = static_cast<double>(contribution) / grid.scale();
                const double density = worth(row, c, static_cast<double>(penalty) / grid.scale());
                if (density > densest.density) densest = {row, bin, density, c};
            });
        }
        best[begin / chunk] = densest;
    });
    return *std::ranges::max_element(best, {}, &dense_bin::density);
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/density/rasterize.hpp
// Adds faces to density rows, and takes them out again.
//
// The loops are those that Luksch 2009 (section 4.6) found to scale: a thread owns a chunk of
// orientations and walks all faces. Within a chunk the faces come in blocks that stay in the cache,
// each block in two steps: lanes compute where the ramps start, scalars add them up.

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <span>


namespace billow::inline BILLOW_ABI {

/// The policies that make a density.
template <class Validity = hull_of_samples, class Contribution = projected_area,
          class Penalty = inner_side_penalty>
struct density_policies {
    /// Where nothing is charged, the ramps of the penalty are not drawn.
    static constexpr bool charges = !std::same_as<Penalty, no_penalty>;

    Validity validity{};
    Contribution contribution{};
    Penalty penalty{};
};
template <class Validity, class Contribution, class Penalty>
density_policies(Validity, Contribution, Penalty)
    -> density_policies<Validity, Contribution, Penalty>;

/// Integers per scene unit squared, such that the largest of the faces' contributions is 2^30.
[[nodiscard]] inline double density_scale(const face_table& faces) noexcept {
    float largest = 0;
    for (const float area : faces.area) largest = std::max(largest, area);
    return largest > 0 ? 0x1p30 / static_cast<double>(largest) : 1;
}

enum class density_change { add, remove };

namespace detail {

/// Where the ramps of a block of faces start: two that bound the contribution, two the penalty.
struct ramp_block {
    static constexpr std::size_t size = 256;
    struct starts {
        std::array<std::int32_t, size> bin;
        std::array<std::int32_t, size> before;
    };
    std::array<std::int32_t, size> height;  ///< 0: the face is not valid here
    std::array<starts, 4> start;
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
        const auto put = [&](std::size_t k, V offset) {
            const V at = simd::max(
                simd::min((offset - axis.origin) * axis.inverse_spacing, axis.bin_count), zero);
            const auto bin = simd::truncate(at);
            const V share = at - simd::to_float(bin);
            simd::lanes<V>::store(block.start[k].bin.data() + i, bin);
            simd::lanes<V>::store(block.start[k].before.data() + i,
                                  simd::truncate(exact_height * share));
        };
        put(0, valid.low);
        put(1, valid.high);
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

/// Adds sign times the block's ramps to a row, the penalty's only where it charges.
template <int Sign, bool Charges>
void add_ramp_block(const ramp_block& block, std::size_t count, std::span<ramp> contribution,
                    std::span<ramp> penalty) noexcept {
    const auto add = [&](std::span<ramp> row, const ramp_block::starts& start, std::size_t i,
                         std::int64_t sign) {
        ramp& at = row[static_cast<std::size_t>(start.bin[i])];
        at.step += sign * block.height[i];
        at.before += sign * start.before[i];
    };
    for (std::size_t i = 0; i < count; ++i) {
        add(contribution, block.start[0], i, Sign);
        add(contribution, block.start[1], i, -Sign);
        if constexpr (Charges) {
            add(penalty, block.start[2], i, Sign);
            add(penalty, block.start[3], i, -Sign);
        }
    }
}

}  // namespace detail

/// Adds faces to every row of a density grid, or removes faces that were added before.
///
/// A row stands for a cell of normals and, at offsets below 0, for the opposite normals. Each face
/// counts its contribution, measured at the cell's centre, at the offsets where the validity policy
/// allows it, and as a penalty where the penalty policy charges it; a bin that is covered in part
/// counts that part.
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
          penalty<V> Penalty>
void rasterize_density(const face_table& faces, std::span<const orientation_cell> cells,
                       const density_policies<Validity, Contribution, Penalty>& policies,
                       double epsilon, density_grid& grid,
                       density_change change = density_change::add, parallel threads = {}) {
    BILLOW_ASSERT(cells.size() == grid.row_count());
    const detail::axis_lanes<V> axis(grid, epsilon);
    // Starting threads for a few faces costs more than the faces.
    const std::size_t chunk = faces.size * cells.size() < 100'000 ? cells.size() + 1 : 8;
    constexpr bool charges = density_policies<Validity, Contribution, Penalty>::charges;
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
                    detail::add_ramp_block<1, charges>(block, count, grid.contribution(row),
                                                       grid.penalty(row));
                } else {
                    detail::add_ramp_block<-1, charges>(block, count, grid.contribution(row),
                                                        grid.penalty(row));
                }
            }
        }
    });
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/cloud/billboard_cloud.hpp
// What a plane search finds: planes, the faces on each, and the rectangles that show them.

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
                                             const plane& of, std::span<const face_id> faces,
                                             rectangle_scratch& scratch) {
    const plane base = canonical(of);
    const frame local = frame_around(base.normal);
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    double facing = 0;  // twice the area seen from the front minus that seen from behind
    double total = 0;
    std::size_t count = 0;
    for (const face_id face : faces) {
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
    }
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
/// that are mapped to it. Its front is the side that most of their area faces; where both sides
/// weigh the same (difference below 1e-6 of the area), the side away from the centre of the scene.
/// Corners (0,0), (1,0), (1,1), (0,1) of a billboard are counter-clockwise seen from its front.
///
/// Needs  planes and plane_of_face of `cloud`; one row of plane_of_face a face.
/// Gives  `cloud.billboards`, one a plane; a plane without faces has zero extents.
/// Cost   O(faces log faces), parallel over planes.
inline void fit_billboards(const mesh& mesh, billboard_cloud& cloud, parallel threads = {}) {
    BILLOW_ASSERT(cloud.plane_of_face.size() == mesh.face_count());
    const faces_of_planes faces(cloud.plane_of_face, cloud.plane_count());
    const auto plane_count = static_cast<plane_id>(cloud.plane_count());
    std::size_t most = 0;
    for (plane_id i = 0; i < plane_count; ++i) most = std::max(most, faces[i].size());
    cloud.billboards.assign(plane_count, {});

    std::vector<detail::rectangle_scratch> scratches(threads.count());
    for (auto& scratch : scratches) {
        scratch.points.resize(3 * most);
        scratch.hull.resize(3 * most + 1);
    }
    for_jobs(threads, plane_count, scratches, [&](std::size_t job, auto& scratch) {
        const auto id = static_cast<plane_id>(job);
        cloud.billboards[id] =
            detail::fit_billboard(mesh, cloud, cloud.planes[id], faces[id], scratch);
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
};

/// Measures `cloud` against the mesh that it was made of, in double. Cost O(faces).
[[nodiscard]] inline cloud_errors measure_errors(const mesh& m, const billboard_cloud& cloud) {
    cloud_errors errors;
    double area_sum = 0;
    for (face_id face = 0; face < m.face_count(); ++face) {
        const plane_id id = cloud.plane_of_face[face];
        if (id == no_id) continue;
        ++errors.mapped_faces;
        const plane& p = cloud.planes[id];
        const auto [a, b, c] = m.corners(face);
        const dvec3 normal = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)) / 2.0;
        const double area = glm::length(normal);
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
        if (largest > cloud.epsilon_of(id) * (1 + 1e-9)) ++errors.faces_beyond_epsilon;
        area_sum += area;
    }
    if (area_sum > 0) {
        errors.mean_error /= area_sum;
        errors.projected_area_share /= area_sum;
    }
    return errors;
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/search/face_sets.hpp
// Sets of faces that a search works with: those a plane takes, those a bin may take.

#include <algorithm>
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

/// The faces whose three corners lie within epsilon of `p`. Source: Luksch 2009, section 2.1.
[[nodiscard]] inline face_rows faces_valid_for(const face_table& faces, const plane& p,
                                               double epsilon, parallel threads = {}) {
    using V = simd::wide;
    const auto fill = [](double value) { return simd::lanes<V>::fill(static_cast<float>(value)); };
    const vec3_lanes<V> normal = fill_lanes<V>(vec3(p.normal));
    const V rho = fill(p.rho);
    const V eps = fill(epsilon);
    const V yes = fill(1);
    const V no = fill(0);
    return filter_rows(
        faces,
        [&](const face_lanes<V>& face) {
            const offset_interval<V> valid = valid_offsets(face, normal, eps);
            return simd::select(valid.low <= rho, simd::select(rho <= valid.high, yes, no), no);
        },
        threads);
}

/// The faces that `estimate` finds valid for some plane of a cell with an offset in
/// [low, high]: "simple validity". Source: Luksch 2009, section 2.1.
template <validity<simd::wide> Validity>
[[nodiscard]] face_rows faces_valid_for_bin(const face_table& faces, const orientation_cell& cell,
                                            double low, double high, double epsilon,
                                            const Validity& estimate, parallel threads = {}) {
    using V = simd::wide;
    const auto fill = [](double value) { return simd::lanes<V>::fill(static_cast<float>(value)); };
    const cell_lanes<V> lanes(cell);
    const V eps = fill(epsilon);
    const V bin_low = fill(low);
    const V bin_high = fill(high);
    const V yes = fill(1);
    const V no = fill(0);
    return filter_rows(
        faces,
        [&](const face_lanes<V>& face) {
            const offset_interval<V> valid = estimate(face, lanes, eps);
            const V from = simd::max(valid.low, bin_low);
            const V to = simd::min(valid.high, bin_high);
            return simd::select(from <= to, simd::select(valid.low <= valid.high, yes, no), no);
        },
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

/// The plane that the face of `row` lies in.
[[nodiscard]] inline plane supporting_plane(const face_table& faces, std::size_t row) {
    const dvec3 normal = glm::normalize(faces.normal.get(row));
    return {normal, glm::dot(normal, faces.centroid(row))};
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
#include <numeric>
#include <optional>
#include <vector>

// ---- billow/search/parts.hpp
// The parts that a plane search is put together from.

// ---- billow/search/grouping.hpp
// Which of the faces that a plane may take it does take: the concept of a grouping.

#include <concepts>
#include <numeric>


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

/// The parts of a pipeline that are chosen at compile time, each a value with its parameters:
/// `pipeline{spherical(24), density_policies{}, svd_fit{}}`.
template <plane_space Space = cube_map, class Policies = density_policies<>,
          plane_fitter Fitter = least_squares_fit, face_grouping Grouping = whole_set,
          vertex_motion Motion = fixed_vertices>
struct pipeline {
    Space space{};
    Policies policies{};
    Fitter fitter{};
    Grouping grouping{};
    Motion motion{};
};
template <class Space, class Policies = density_policies<>, class Fitter = least_squares_fit,
          class Grouping = whole_set, class Motion = fixed_vertices>
pipeline(Space, Policies = {}, Fitter = {}, Grouping = {}, Motion = {})
    -> pipeline<Space, Policies, Fitter, Grouping, Motion>;

}  // namespace billow::inline BILLOW_ABI
// ---- billow/search/refine.hpp
// From the densest bin to a plane: refinement.
//
// Décoret et al. 2003; Luksch 2009, sections 2.1 and 3.2. A bin's density promises only that many
// faces each have some valid plane in the bin, not that one plane serves them all, and the densest
// plane may lie in a neighbour. So the bin and what surrounds it are split again and again, and the
// densest part goes on, until its centre serves every face that is left.

#include <optional>
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
    bin_splitter(const Space& space, const Policies& policies, double epsilon, int per_axis,
                 parallel threads)
        : space_(space),
          policies_(policies),
          epsilon_(epsilon),
          per_axis_(per_axis),
          threads_(threads) {}

    struct child {
        plane_bin bin{};
        double density = 0;
    };

    /// The child of most contribution among `faces`. No penalty: planes that slice through foliage
    /// are wanted (Fuhrmann et al. 2005, section 3.2.2).
    [[nodiscard]] child densest_child(const face_table& faces, const plane_bin& bin) const {
        const dvec2 half = bin.patch.half_size / 2.0;
        const double spacing = (bin.rho_high - bin.rho_low) / 2;
        std::vector<orientation_patch> patches;
        std::vector<orientation_cell> cells;
        for (int j = 0; j < per_axis_; ++j) {
            for (int i = 0; i < per_axis_; ++i) {
                const dvec2 step(2 * i + 1 - per_axis_, 2 * j + 1 - per_axis_);
                patches.push_back({bin.patch.chart, bin.patch.centre + half * step, half});
                cells.push_back(cell_of_patch(space_, patches.back()));
            }
        }
        const double middle = (bin.rho_low + bin.rho_high) / 2;
        density_grid grid(cells.size(), {middle - spacing * per_axis_ / 2, spacing, per_axis_},
                          density_scale(faces));
        rasterize_density(
            faces, std::span<const orientation_cell>(cells),
            density_policies{policies_.validity, policies_.contribution, no_penalty{}}, epsilon_,
            grid, density_change::add, threads_);
        // Where several are fully covered, the one nearest to the middle: the first would drift to
        // the rim of the planes that serve all, where their centres do not.
        dense_bin best{.density = -1};
        double nearest = 0;
        for (std::size_t row = 0; row < grid.row_count(); ++row) {
            const dvec2 aside = (patches[row].centre - bin.patch.centre) / half;
            grid.for_each_bin(row, [&](int at, std::int64_t contribution, std::int64_t) {
                const double density = static_cast<double>(contribution) / grid.scale();
                const double up = 2 * at + 1 - per_axis_;
                const double distance = glm::dot(aside, aside) + up * up;
                if (density > best.density || (density == best.density && distance < nearest)) {
                    best = {row, at, density, density};
                    nearest = distance;
                }
            });
        }
        const double low = grid.axis().origin + best.bin * spacing;
        return {{patches[best.row], low, low + spacing}, best.density};
    }

private:
    const Space& space_;
    const Policies& policies_;
    double epsilon_;
    int per_axis_;
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
    const detail::bin_splitter splitter(space, policies, epsilon, options.children_per_axis,
                                        threads);
    const auto contribution_to = [&](const plane& p) {
        const face_rows valid = faces_valid_for(candidates, p, epsilon, threads);
        return std::pair(valid.size(),
                         contribution_of(candidates, valid, p.normal, policies.contribution));
    };
    double promised = std::numeric_limits<double>::infinity();
    for (int level = 0;; ++level) {
        const plane centre = centre_plane(space, bin);
        const auto [served, contribution] = contribution_to(centre);
        if (served == candidates.size || contribution >= options.sufficient_share * promised ||
            level == options.max_levels) {
            return refined_plane{centre, level};
        }
        const auto child = splitter.densest_child(candidates, bin);
        if (child.density <= 0) return std::nullopt;
        bin = child.bin;
        promised = child.density;
        const face_rows rows =
            faces_valid_for_bin(candidates, cell_of_patch(space, bin.patch), bin.rho_low,
                                bin.rho_high, epsilon, widened_centre{}, threads);
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
    refinement refine = refinement::fail_safe;
    int max_levels = 12;          ///< of refinement, > 0
    double sufficient_share = 1;  ///< refine_options::sufficient_share
};

/// What the search did.
struct greedy_statistics {
    std::size_t refinement_levels = 0;  ///< sum over the planes
    std::size_t fail_safes = 0;         ///< planes that refinement did not find
    std::size_t tweaks = 0;             ///< planes that the fitter moved
    std::size_t degenerate_faces = 0;   ///< set aside: they have no area
    std::size_t leftover_faces = 0;     ///< joined the plane of least error, see max_planes
};

struct greedy_result {
    billboard_cloud cloud{};  ///< without billboards: fit_billboards adds them
    greedy_statistics statistics{};
    std::vector<moved_face> moved{};  ///< what the motion moved, around cloud.bounds.centre
};

namespace detail {

/// The state of one search. Its methods are the steps of the method, in their order.
template <class Pipeline>
class greedy_searcher {
public:
    greedy_searcher(face_table faces, const Pipeline& parts, const greedy_options& options,
                    parallel threads)
        : remaining_(std::move(faces)),
          space_(parts.space),
          policies_(parts.policies),
          fitter_(parts.fitter),
          grouping_(parts.grouping),
          motion_(parts.motion),
          options_(options),
          threads_(threads),
          // Columns hold floats: within this margin the bound holds for the mesh's own vertices.
          epsilon_(
              std::max(options.epsilon - 1e-6 * remaining_.bounds.radius, options.epsilon / 2)),
          rows_(make_rows(space_)),
          grid_(rows_.size(), make_axis(), density_scale(remaining_)) {
        for (const orientation_id id : rows_) cells_.push_back(space_.cell(id));
    }

    greedy_result run(std::size_t face_count, const progress_function& progress) {
        result_.cloud.bounds = remaining_.bounds;
        result_.cloud.epsilon = options_.epsilon;
        result_.cloud.plane_of_face.assign(face_count, no_id);
        result_.statistics.degenerate_faces = remaining_.degenerate.size();
        const double total_area = area_sum();

        motion_.start(remaining_, epsilon_);
        change_density(remaining_, density_change::add);
        while (remaining_.size > 0 && !is_budget_spent()) {
            plane found = find_plane();
            face_rows taken = faces_taken_by(found);
            tweak(found, taken);
            group(found, taken);
            emit(found, taken);
            report(progress, "search", 1 - area_sum() / total_area);
        }
        assign_leftovers();
        result_.moved = motion_.moved_faces();
        return std::move(result_);
    }

private:
    using space_type = decltype(Pipeline::space);
    using motion_type = decltype(Pipeline::motion);

    /// One row for n and -n, which share their planes.
    [[nodiscard]] static std::vector<orientation_id> make_rows(const space_type& space) {
        std::vector<orientation_id> rows;
        for (orientation_id id = 0; id < space.orientation_count(); ++id) {
            if (id <= space.antipode(id)) rows.push_back(id);
        }
        return rows;
    }

    /// Bins over [-R, R] with a border at 0. Very small epsilons get bins of R / 2048.
    [[nodiscard]] offset_axis make_axis() const {
        constexpr double max_bins = 2048;
        const double radius = remaining_.bounds.radius;
        const double spacing = std::max(options_.epsilon / options_.rho_rate, radius / max_bins);
        const int half = std::max(1, static_cast<int>(std::ceil(radius / spacing)));
        return {-half * spacing, spacing, 2 * half};
    }

    [[nodiscard]] std::span<const orientation_cell> cells() const noexcept { return cells_; }
    [[nodiscard]] double area_sum() const noexcept {
        return std::accumulate(remaining_.area.begin(), remaining_.area.end(), 0.0);
    }
    [[nodiscard]] bool is_budget_spent() const noexcept {
        return options_.max_planes != 0 && result_.cloud.planes.size() >= options_.max_planes;
    }

    [[nodiscard]] plane find_plane() {
        const std::optional<plane_bin> bin = find_bin();
        if (!bin) return plane_of_largest_face(remaining_);
        if (options_.refine == refinement::none) return centre_plane(space_, *bin);

        const face_table candidates = select_rows(
            remaining_,
            faces_valid_for_bin(remaining_, cell_of_patch(space_, bin->patch), bin->rho_low,
                                bin->rho_high, epsilon_, widened_centre{}, threads_),
            threads_);
        const bool is_original = options_.refine == refinement::original;
        const auto refined = candidates.size == 0
                                 ? std::nullopt
                                 : refine(space_, *bin, candidates, policies_, epsilon_,
                                          {.children_per_axis = is_original ? 6 : 4,
                                           .max_levels = options_.max_levels,
                                           .sufficient_share = options_.sufficient_share},
                                          threads_);
        if (refined) {
            result_.statistics.refinement_levels += static_cast<std::size_t>(refined->level);
            return refined->plane;
        }
        ++result_.statistics.fail_safes;
        if (candidates.size == 0) return plane_of_largest_face(remaining_);
        if (is_original) return plane_of_largest_face(candidates);
        return fail_safe(*bin, candidates);
    }

    /// The densest bin; where penalties leave none above 0, that of most contribution; nothing when
    /// no face is simple-valid anywhere.
    [[nodiscard]] std::optional<plane_bin> find_bin() const {
        const double weight = policies_.penalty.weight;
        dense_bin best = densest_bin(
            grid_,
            [weight](std::size_t, double c, double p) {
                return c > 0 ? c - weight * p : -std::numeric_limits<double>::max();
            },
            threads_);
        if (best.density <= 0) {
            best = densest_bin(
                grid_, [](std::size_t, double c, double) { return c; }, threads_);
        }
        if (best.contribution <= 0) return std::nullopt;
        const double low = grid_.axis().origin + best.bin * grid_.axis().spacing;
        return plane_bin{space_.patch(rows_[best.row]), low, low + grid_.axis().spacing};
    }

    /// Of the bin's centre plane, the average plane of its faces and the planes of its largest
    /// faces, the one of most contribution. Source: Fuhrmann et al. 2005, section 3.3.2; Luksch
    /// 2009, section 3.2. Differs: at most 32 faces are tried, the largest, instead of all.
    [[nodiscard]] plane fail_safe(const plane_bin& bin, const face_table& candidates) const {
        const plane centre = centre_plane(space_, bin);
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
            const double contribution =
                contribution_of(remaining_, faces_valid_for(remaining_, p, epsilon_, threads_),
                                p.normal, policies_.contribution);
            if (contribution > most) most = contribution, best = p;
        }
        return best;
    }

    [[nodiscard]] static std::uint32_t largest_face(const face_table& faces) {
        const auto largest = std::max_element(faces.area.begin(), faces.area.end());
        return static_cast<std::uint32_t>(largest - faces.area.begin());
    }
    [[nodiscard]] static plane plane_of_largest_face(const face_table& faces) {
        return supporting_plane(faces, largest_face(faces));
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
        return taken;
    }

    [[nodiscard]] face_rows faces_allowed_on(const plane& p) const {
        face_rows rows = faces_valid_for(remaining_, p, epsilon_, threads_);
        motion_.keep_allowed(remaining_, p, rows);
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
        if (faces_valid_for(faces, moved, epsilon_, threads_).size() != faces.size) return;
        const auto contribution = [&](const plane& p) {
            return contribution_of(faces, all, p.normal, policies_.contribution);
        };
        if (!fitter_.allows_less_contribution && contribution(moved) < contribution(found)) return;
        face_rows moved_taken = faces_allowed_on(moved);
        if (!std::ranges::includes(moved_taken, taken)) return;
        found = moved;
        taken = std::move(moved_taken);
        ++result_.statistics.tweaks;
    }

    /// Leaves to later planes what the grouping does not want on this one.
    void group(const plane& found, face_rows& taken) const {
        if constexpr (!std::remove_cvref_t<decltype(grouping_)>::takes_all) {
            const face_rows kept =
                grouping_(select_rows(remaining_, taken, threads_), found, epsilon_, threads_);
            BILLOW_ASSERT(!kept.empty());
            face_rows rows;
            for (const std::uint32_t row : kept) rows.push_back(taken[row]);
            taken = std::move(rows);
        }
    }

    void emit(const plane& found, const face_rows& taken) {
        const auto id = static_cast<plane_id>(result_.cloud.planes.size());
        result_.cloud.planes.push_back(canonical(found));
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
        if (!kept.empty()) change_density(leaving, density_change::remove);
        remaining_ = select_rows(remaining_, kept, threads_);
        if constexpr (!motion_type::is_still) {
            const face_rows moving = motion_.plane_found(leaving, found, remaining_);
            change_density(select_rows(remaining_, moving, threads_), density_change::remove);
            motion_.move(remaining_, moving);
            change_density(select_rows(remaining_, moving, threads_), density_change::add);
        }
    }

    void change_density(const face_table& faces, density_change change) {
        rasterize_density(faces, cells(), policies_, epsilon_, grid_, change, threads_);
    }

    /// Gives every face that is left to the plane whose farthest corner of the face is nearest.
    void assign_leftovers() {
        result_.statistics.leftover_faces = remaining_.size;
        const std::vector<plane>& planes = result_.cloud.planes;
        threads_.for_chunks(remaining_.size, 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) {
                plane_id nearest = no_id;
                double least = std::numeric_limits<double>::infinity();
                for (plane_id id = 0; id < planes.size(); ++id) {
                    double error = 0;
                    for (const columns3& corner : remaining_.corner) {
                        error =
                            std::max(error, std::abs(signed_distance(planes[id], corner.get(row))));
                    }
                    if (error < least) least = error, nearest = id;
                }
                result_.cloud.plane_of_face[remaining_.source[row]] = nearest;
            }
        });
    }

    face_table remaining_;
    const space_type& space_;
    const decltype(Pipeline::policies)& policies_;
    const decltype(Pipeline::fitter)& fitter_;
    const decltype(Pipeline::grouping)& grouping_;
    motion_type motion_;
    greedy_options options_;
    parallel threads_;
    double epsilon_;
    std::vector<orientation_id> rows_;
    std::vector<orientation_cell> cells_;
    density_grid grid_;
    greedy_result result_;
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
    return detail::greedy_searcher<pipeline<Parts...>>(std::move(faces), parts, options, threads)
        .run(face_count, progress);
}
[[nodiscard]] inline greedy_result greedy_search(face_table faces, std::size_t face_count,
                                                 const greedy_options& options) {
    return greedy_search(std::move(faces), face_count, options, pipeline{});
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/bake/bake_cloud.hpp
// Textures for a billboard cloud: from a mesh and its billboards to atlases.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 4.5.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

// ---- billow/bake/baked_cloud.hpp
// What the baker makes of a billboard cloud: atlases, and where each billboard's tile lies.

#include <vector>


namespace billow::inline BILLOW_ABI {

/// The texels of a billboard within an atlas: columns [x, x + width), rows [y, y + height), without
/// padding. Texel rows run from the top, so the billboard's v axis points up in the tile; a rotated
/// tile has been turned by 90° clockwise (the billboard's u axis runs down, its v axis to the right).
struct tile {
    atlas_id atlas = no_id;
    int x = 0;
    int y = 0;
    int width = 0;   ///< in the atlas, so along v when rotated
    int height = 0;  ///< in the atlas, so along u when rotated
    bool is_rotated = false;
};

/// Textures of the same size and layout. Channels that say nothing are left empty.
struct atlas {
    image base_color{};  ///< RGBA, sRGB, straight alpha of 0 or 255
    /// RGB, tangent space of the tile: x to the right and y up in the atlas (so v and -u of a rotated
    /// billboard), z along its normal and above 0.
    image normal{};
    image occlusion_roughness_metallic{};  ///< RGB, linear
    image emissive{};                      ///< RGB, sRGB

    [[nodiscard]] int width() const noexcept { return base_color.width; }
    [[nodiscard]] int height() const noexcept { return base_color.height; }
};

/// One tile a billboard, in the order of the cloud's billboards.
struct baked_cloud {
    std::vector<tile> tiles{};
    std::vector<atlas> atlases{};
    double texel_size = 0;  ///< scene units a texel side, the same for every tile
    double fill = 0;        ///< share of the atlases' area that is tiles, padding not counted
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/border.hpp
// Colours for what is transparent, so that filtering and mip maps draw no halo.
//
// Luksch 2009, section 4.5; here the whole transparent area is filled, each texel from the opaque
// one that is exactly nearest.

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

/// All channels of a pixel but alpha.
inline void copy_texel(atlas& in, const ivec2& from, const ivec2& to) noexcept {
    for (image* channel :
         {&in.base_color, &in.normal, &in.occlusion_roughness_metallic, &in.emissive}) {
        if (channel->empty()) continue;
        const std::uint8_t* source = channel->pixel(from.x, from.y);
        std::copy(source, source + 3, channel->pixel(to.x, to.y));
    }
}

struct border_scratch {
    std::vector<std::int32_t> nearest{};
    nearest_scratch rows{};
};

inline void fill_tile_border(atlas& in, const pixel_rectangle& area, border_scratch& scratch) {
    const std::span nearest =
        std::span(scratch.nearest)
            .first(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height));
    const auto is_opaque = [&](int x, int y) {
        return in.base_color.pixel(area.x + x, area.y + y)[3] != 0;
    };
    nearest_pixels(area.width, area.height, is_opaque, nearest, scratch.rows);
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

/// Gives every transparent texel all channels of the nearest opaque texel: within a tile and its
/// padding the nearest of that tile, elsewhere the nearest texel of any of these. Alpha stays.
///
/// Needs  tiles whose paddings do not overlap.
/// Cost   O(texels), parallel over tiles, then over rows.
inline void fill_borders(baked_cloud& baked, int padding, parallel threads = {}) {
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
        detail::fill_tile_border(in, detail::padded(t, in, padding), scratch);
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
// ---- billow/bake/draw_set.hpp
// Which faces are drawn on each billboard: its own, and every other one that lies close enough to
// its plane. The latter close cracks between planes.
//
// Décoret et al. 2003 and Fuhrmann et al. 2005 draw all faces valid for the plane.

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
        for (std::uint32_t i = 0; i < count; ++i) {
            std::uint32_t rank = 0;
            for (std::uint32_t k = 0; k < count; ++k) rank += bayer_of(k) < bayer_of(i) ? 1u : 0u;
            rank_[i] = static_cast<std::uint8_t>(rank);
        }
    }

    /// Threshold of the sample (x, y) for a face. Faces take the thresholds in another order each:
    /// of two half-transparent leaves one above the other, the lower must show through.
    [[nodiscard]] float threshold(int x, int y, std::uint32_t shift) const noexcept {
        const std::uint32_t count = side_ * side_;
        const std::uint32_t cell =
            static_cast<std::uint32_t>(y) % side_ * side_ + static_cast<std::uint32_t>(x) % side_;
        return (static_cast<float>((rank_[cell] + shift) % count) + 0.5f) /
               static_cast<float>(count);
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
    std::array<std::uint8_t, max_supersample * max_supersample> rank_{};
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
        depths_.reserve(samples);
        faces_.reserve(samples);
    }

    /// Forgets all and looks at `window`.
    void start(const sample_window& window) {
        window_ = window;
        width_ = static_cast<std::size_t>(window.x_end - window.x_begin);
        const std::size_t size = width_ * static_cast<std::size_t>(window.y_end - window.y_begin);
        depths_.assign(size, -std::numeric_limits<float>::infinity());
        faces_.assign(size, no_id);
    }

    /// Draws a face, clipped to `range`, where its alpha lets it be seen.
    void draw(const surface& look, const orthographic_view& view, face_id face,
              const depth_range& range) noexcept {
        const std::array<dvec3, 3> p = view.project(look.source().corners(face));
        const raster_triangle triangle({dvec2(p[0]), dvec2(p[1]), dvec2(p[2])});
        if (triangle.is_empty()) return;
        const fragment_depth depth(triangle, p, range);
        if (depth.is_outside()) return;
        const face_cover cover = look.cover_of(face, triangle.area());
        if (cover.decides == face_cover::rule::always) {
            triangle.for_each_row(window_, [&](int y, int begin, int end) {
                draw_row(y, begin, end, face, depth, [](int) { return true; });
            });
            return;
        }
        const auto interpolated = [&](auto&& value) {
            return triangle.interpolate(value(0), value(1), value(2));
        };
        const affine_value u = interpolated([&](std::size_t i) { return cover.uvs[i].x; });
        const affine_value v = interpolated([&](std::size_t i) { return cover.uvs[i].y; });
        const affine_value a = interpolated([&](std::size_t i) { return cover.vertex_alpha[i]; });
        const auto shift = static_cast<std::uint32_t>(mix_bits(face));
        triangle.for_each_row(window_, [&](int y, int begin, int end) {
            const row_value row_u(u, begin, y);
            const row_value row_v(v, begin, y);
            const row_value row_a(a, begin, y);
            draw_row(y, begin, end, face, depth, [&](int step) {
                float alpha = cover.factor;
                if (cover.has_vertex_alpha) alpha *= row_a.at(step);
                if (cover.alpha != nullptr) {
                    const vec2 uv(row_u.at(step), row_v.at(step));
                    alpha *= sample_alpha(*cover.alpha, *cover.map, uv, cover.is_nearest);
                }
                return alpha >= (cover.decides == face_cover::rule::cutoff
                                     ? cover.cutoff
                                     : dither_.threshold(begin + step, y, shift));
            });
        });
    }

    [[nodiscard]] const sample_window& window() const noexcept { return window_; }
    /// The faces of row y, from window().x_begin on; no_id where nothing was drawn.
    [[nodiscard]] const face_id* faces_of_row(int y) const noexcept {
        return faces_.data() + row_offset(y);
    }

private:
    /// A value along a row, in floats from its first sample on.
    struct row_value {
        float first;
        float across;

        row_value(const affine_value& of, int x, int y) noexcept
            : first(static_cast<float>(of.at(x, y))), across(static_cast<float>(of.dx)) {}
        [[nodiscard]] float at(int step) const noexcept {
            return first + across * static_cast<float>(step);
        }
    };

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

    [[nodiscard]] std::size_t row_offset(int y) const noexcept {
        return static_cast<std::size_t>(y - window_.y_begin) * width_;
    }

    template <class IsThere>
    void draw_row(int y, int begin, int end, face_id face, const fragment_depth& depth,
                  const IsThere& is_there) noexcept {
        const std::size_t offset =
            row_offset(y) + static_cast<std::size_t>(begin - window_.x_begin);
        float* depths = depths_.data() + offset;
        face_id* faces = faces_.data() + offset;
        const row_value height(depth.plane, begin, y);
        for (int step = 0; step < end - begin; ++step) {
            const float value = std::clamp(height.at(step), depth.low, depth.high);
            if (!(value >= depths[step])) continue;
            if (value == depths[step] && face > faces[step]) continue;
            if (depth.is_clipped && !(value >= depth.kept_low && value <= depth.kept_high)) {
                continue;
            }
            if (!is_there(step)) continue;
            depths[step] = value;
            faces[step] = face;
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

    /// The look at the point of a face nearest to `point` (in samples, roughly where outside), with its normal turned to the viewer.
    [[nodiscard]] surface_sample at(face_id face, const dvec2& point) noexcept {
        entry& e = entries_[face % entries_.size()];
        if (e.look.face != face) e = entry_of(face);
        const dvec2 offset = point - e.corner;
        const double b = std::clamp(glm::dot(e.to_b, offset), 0.0, 1.0);
        const double c = std::clamp(glm::dot(e.to_c, offset), 0.0, 1.0 - b);
        surface_sample sample = look_->at(e.look, vec3(1 - b - c, b, c));
        sample.normal = normal_toward(sample, e.look, vec3(view_.axes.normal));
        return sample;
    }

private:
    struct entry {
        face_look look{};
        dvec2 corner{0};
        dvec2 to_b{0};  ///< barycentric weight of the second corner = dot(to_b, point - corner)
        dvec2 to_c{0};
    };

    [[nodiscard]] entry entry_of(face_id face) const noexcept {
        const std::array<dvec3, 3> p = view_.project(look_->source().corners(face));
        entry e;
        e.corner = dvec2(p[0]);
        const dvec2 u = dvec2(p[1]) - e.corner;
        const dvec2 v = dvec2(p[2]) - e.corner;
        const double det = u.x * v.y - u.y * v.x;
        if (det != 0) {
            e.to_b = dvec2(v.y, -v.x) / det;
            e.to_c = dvec2(-u.y, u.x) / det;
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

/// The faces of each billboard, front to back.
class draw_sets {
public:
    /// Faces that reach into the rectangle of a target and are either mapped to its plane, or valid
    /// for it: all corners within cloud.epsilon, |cos| of the angle between the normals at least
    /// `least_cosine`.
    ///
    /// Needs  `faces` of the mesh that `cloud` was searched in; one target a plane.
    /// Cost   O(faces × planes) vector operations at worst, fewer where neighbours in the mesh are
    ///        neighbours in space; parallel over planes.
    draw_sets(const face_table& faces, const billboard_cloud& cloud,
              std::span<const draw_target> targets, double least_cosine, parallel threads)
        : faces_(faces), cloud_(cloud), targets_(targets), least_cosine_(least_cosine) {
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

    template <class Visit>
    void sweep(plane_id id, const Visit& visit) const noexcept {
        using V = simd::wide;
        using lanes = simd::lanes<V>;
        const plane& of = cloud_.planes[id];
        const double rho =
            of.rho + glm::dot(of.normal, cloud_.bounds.centre - faces_.bounds.centre);
        const billboard& board = cloud_.billboards[id];
        const double reach =
            std::max({cloud_.epsilon, std::abs(board.depth_low), std::abs(board.depth_high)}) +
            1e-5 * faces_.bounds.radius;
        const vec3_lanes<V> normal = fill_lanes<V>(vec3(of.normal));
        const V offset = lanes::fill(static_cast<float>(rho));
        const V epsilon = lanes::fill(static_cast<float>(cloud_.epsilon));
        const V least_cosine = lanes::fill(static_cast<float>(least_cosine_));
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            if (std::abs(glm::dot(of.normal, blocks_[b].centre) - rho) >
                reach + blocks_[b].radius) {
                continue;
            }
            const std::size_t begin = b * block_size;
            const std::size_t end = std::min(begin + block_size, faces_.size);
            std::array<float, block_size> is_valid{};
            for (std::size_t row = begin; row < end; row += lanes::count) {
                const face_lanes<V> f = load_faces<V>(faces_, row);
                V distance = simd::abs(dot(f.corner[0], normal) - offset);
                distance = simd::max(distance, simd::abs(dot(f.corner[1], normal) - offset));
                distance = simd::max(distance, simd::abs(dot(f.corner[2], normal) - offset));
                const V cosine = simd::abs(dot(f.normal, normal));
                const V one = simd::select(distance <= epsilon, lanes::fill(1), lanes::fill(0));
                lanes::store(is_valid.data() + (row - begin),
                             simd::select(cosine >= least_cosine, one, lanes::fill(0)));
            }
            for (std::size_t row = begin; row < end; ++row) {
                const face_id face = faces_.source[row];
                if (is_valid[row - begin] != 0 || cloud_.plane_of_face[face] == id) {
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
    double least_cosine_;
    std::vector<bounding_sphere> blocks_{};
    std::vector<std::size_t> begin_{};
    std::vector<drawn_face> drawn_{};
};

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/pack.hpp
// Rectangles in, places in as few and as small atlases as can be found, out.
//
// The skyline packer is stb_rect_pack; orders, quarter turns and atlas widths are tried around it.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>


// The packer lives in our namespace, private to each translation unit, whatever the user includes.
#pragma push_macro("STBRP_DEF")
#pragma push_macro("STBRP_SORT")
#pragma push_macro("STBRP_ASSERT")
#pragma push_macro("STBRP_STATIC")
#pragma push_macro("STB_RECT_PACK_IMPLEMENTATION")
#pragma push_macro("STB_INCLUDE_STB_RECT_PACK_H")
#pragma push_macro("STB_RECT_PACK_VERSION")
#pragma push_macro("STBRP__MAXVAL")
#pragma push_macro("STBRP__NOTUSED")
#pragma push_macro("STBRP__CDECL")
#undef STBRP_DEF
#undef STBRP_SORT
#undef STBRP_ASSERT
#undef STB_INCLUDE_STB_RECT_PACK_H
#undef STB_RECT_PACK_VERSION
#undef STBRP__MAXVAL
#undef STBRP__NOTUSED
#undef STBRP__CDECL
#undef STBRP_STATIC
#undef STB_RECT_PACK_IMPLEMENTATION
#define STBRP_STATIC
#define STB_RECT_PACK_IMPLEMENTATION
#define STBRP_ASSERT(condition) BILLOW_ASSERT(condition)
// We hand the rectangles over in order: qsort would leave ties to the C library.
#define STBRP_SORT(rects, count, size, compare) static_cast<void>(compare)
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#endif
namespace billow::inline BILLOW_ABI::detail::stb {
#include <stb_rect_pack.h>
}  // namespace billow::inline BILLOW_ABI::detail::stb
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
#undef STBRP_DEF
#undef STBRP_SORT
#undef STBRP_ASSERT
#undef STBRP_STATIC
#undef STB_RECT_PACK_IMPLEMENTATION
#undef STB_INCLUDE_STB_RECT_PACK_H
#undef STB_RECT_PACK_VERSION
#undef STBRP__MAXVAL
#undef STBRP__NOTUSED
#undef STBRP__CDECL
#pragma pop_macro("STBRP__CDECL")
#pragma pop_macro("STBRP__NOTUSED")
#pragma pop_macro("STBRP__MAXVAL")
#pragma pop_macro("STB_RECT_PACK_VERSION")
#pragma pop_macro("STB_INCLUDE_STB_RECT_PACK_H")
#pragma pop_macro("STB_RECT_PACK_IMPLEMENTATION")
#pragma pop_macro("STBRP_STATIC")
#pragma pop_macro("STBRP_ASSERT")
#pragma pop_macro("STBRP_SORT")
#pragma pop_macro("STBRP_DEF")

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
};

namespace detail {

/// One way to fill one atlas, in units of the alignment.
struct pack_trial {
    std::vector<stb::stbrp_rect> rectangles{};
    int width = 0;
    int height = 0;
    std::int64_t packed_area = 0;
    bool holds_all = false;

    [[nodiscard]] std::int64_t area() const noexcept { return std::int64_t{width} * height; }
    /// More rectangles first, then less area, then the squarer atlas.
    [[nodiscard]] bool is_better_than(const pack_trial& other) const noexcept {
        if (holds_all != other.holds_all) return holds_all;
        if (!holds_all && packed_area != other.packed_area) return packed_area > other.packed_area;
        if (area() != other.area()) return area() < other.area();
        return std::max(width, height) < std::max(other.width, other.height);
    }
};

[[nodiscard]] inline int floor_power_of_two(int value) noexcept {
    int power = 1;
    while (power <= value / 2) power *= 2;
    return power;
}

/// The longest side of an atlas, in units of the alignment.
[[nodiscard]] inline int side_limit(const pack_options& options) noexcept {
    const int limit = options.max_size / options.alignment;
    return options.power_of_two ? floor_power_of_two(options.max_size) / options.alignment : limit;
}

enum class turn_rule { none, landscape, portrait };
enum class order_rule { height, longer_side, area };

class atlas_packer {
public:
    atlas_packer(std::span<const ivec2> sizes, const pack_options& options)
        : sizes_(sizes), options_(options), limit_(side_limit(options)) {}

    [[nodiscard]] packing run() {
        packing result;
        result.rectangles.resize(sizes_.size());
        std::vector<std::size_t> left(sizes_.size());
        std::iota(left.begin(), left.end(), std::size_t{0});
        while (!left.empty()) {
            const pack_trial best = best_trial(left);
            const auto atlas = static_cast<atlas_id>(result.atlas_sizes.size());
            result.atlas_sizes.push_back(
                {best.width * options_.alignment, best.height * options_.alignment});
            for (const stb::stbrp_rect& r : best.rectangles) {
                if (!r.was_packed) continue;
                const auto id = static_cast<std::size_t>(r.id);
                result.rectangles[id] = {atlas, r.x * options_.alignment + options_.padding,
                                         r.y * options_.alignment + options_.padding,
                                         r.w != units(sizes_[id].x) || r.h != units(sizes_[id].y)};
            }
            std::erase_if(left,
                          [&](std::size_t id) { return result.rectangles[id].atlas != no_id; });
        }
        return result;
    }

private:
    [[nodiscard]] int units(int size) const noexcept {
        return (size + 2 * options_.padding + options_.alignment - 1) / options_.alignment;
    }
    [[nodiscard]] static int ceil_power(int value) noexcept {
        const int power = floor_power_of_two(value);
        return power < value ? 2 * power : power;
    }

    [[nodiscard]] std::vector<stb::stbrp_rect> rectangles_of(const std::vector<std::size_t>& ids,
                                                             turn_rule turn,
                                                             order_rule order) const {
        std::vector<stb::stbrp_rect> rectangles;
        rectangles.reserve(ids.size());
        for (const std::size_t id : ids) {
            int w = units(sizes_[id].x);
            int h = units(sizes_[id].y);
            if ((turn == turn_rule::landscape && w < h) || (turn == turn_rule::portrait && w > h)) {
                std::swap(w, h);
            }
            rectangles.push_back({static_cast<int>(id), w, h, 0, 0, 0});
        }
        const auto key = [order](const stb::stbrp_rect& r) -> std::array<std::int64_t, 2> {
            const std::int64_t area = std::int64_t{r.w} * r.h;
            if (order == order_rule::height) return {r.h, r.w};
            if (order == order_rule::longer_side) return {std::max(r.w, r.h), area};
            return {area, r.h};
        };
        std::stable_sort(rectangles.begin(), rectangles.end(),
                         [&](const auto& a, const auto& b) { return key(a) > key(b); });
        return rectangles;
    }

    [[nodiscard]] pack_trial trial(std::vector<stb::stbrp_rect> rectangles, int width) {
        stb::stbrp_context context;
        nodes_.resize(static_cast<std::size_t>(width));
        stb::stbrp_init_target(&context, width, limit_, nodes_.data(), width);
        const int count = static_cast<int>(rectangles.size());
        pack_trial t;
        t.holds_all = stb::stbrp_pack_rects(&context, rectangles.data(), count) != 0;
        for (const stb::stbrp_rect& r : rectangles) {
            if (!r.was_packed) continue;
            t.packed_area += std::int64_t{r.w} * r.h;
            t.width = std::max(t.width, r.x + r.w);
            t.height = std::max(t.height, r.y + r.h);
        }
        if (options_.power_of_two) {
            t.width = ceil_power(t.width);
            t.height = ceil_power(t.height);
        }
        t.rectangles = std::move(rectangles);
        return t;
    }

    /// Widths from the square root of the area upwards to twice that, and the limit.
    [[nodiscard]] std::vector<int> widths_for(const std::vector<std::size_t>& ids) const {
        std::int64_t area = 0;
        int narrowest = 1;
        for (const std::size_t id : ids) {
            const int w = units(sizes_[id].x);
            const int h = units(sizes_[id].y);
            area += std::int64_t{w} * h;
            narrowest = std::max(narrowest, options_.allows_rotation ? std::min(w, h) : w);
        }
        std::vector<int> widths;
        if (options_.power_of_two) {
            for (int w = ceil_power(narrowest); w <= limit_; w *= 2) widths.push_back(w);
        } else {
            const double side = std::sqrt(static_cast<double>(area));
            for (const double share : {0.7, 1.0, 1.02, 1.05, 1.1, 1.2, 1.4, 2.0}) {
                widths.push_back(std::clamp(static_cast<int>(std::ceil(side * share)),
                                            std::min(narrowest, limit_), limit_));
            }
            widths.push_back(limit_);
            std::sort(widths.begin(), widths.end());
            widths.erase(std::unique(widths.begin(), widths.end()), widths.end());
        }
        return widths;
    }

    [[nodiscard]] pack_trial best_trial(const std::vector<std::size_t>& ids) {
        const std::vector<int> widths = widths_for(ids);
        pack_trial best;
        bool is_first = true;
        for (const turn_rule turn : {turn_rule::none, turn_rule::landscape, turn_rule::portrait}) {
            if (turn != turn_rule::none && !options_.allows_rotation) break;
            for (const order_rule order :
                 {order_rule::height, order_rule::longer_side, order_rule::area}) {
                const auto rectangles = rectangles_of(ids, turn, order);
                for (const int width : widths) {
                    pack_trial t = trial(rectangles, width);
                    if (is_first || t.is_better_than(best)) best = std::move(t);
                    is_first = false;
                }
            }
        }
        return best;
    }

    std::span<const ivec2> sizes_;
    pack_options options_;
    int limit_;
    std::vector<stb::stbrp_node> nodes_{};
};

}  // namespace detail

/// The longest side that a rectangle may have to fit into an atlas, pixels.
[[nodiscard]] inline int largest_side(const pack_options& options) noexcept {
    return detail::side_limit(options) * options.alignment - 2 * options.padding;
}

/// Places rectangles in atlases so that they keep their distance: the smallest atlas that several
/// orders, turns and widths give; where one atlas does not hold all, the fullest first, and so on.
///
/// Unit   pixels.
/// Needs  sides of at least 1 and at most largest_side(options); with power_of_two an alignment that
///        is a power of two, too.
/// Cost   O(n²) at worst, a few ms for a thousand rectangles. The same answer every time.
[[nodiscard]] inline packing pack_rectangles(std::span<const ivec2> sizes,
                                             const pack_options& options = {}) {
    BILLOW_ASSERT(options.alignment > 0 && options.padding >= 0);
    return detail::atlas_packer(sizes, options).run();
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/texel.hpp
// From the samples of a texel to its bytes in the atlas.
//
// Luksch 2009, section 4.5: only samples that show a face are averaged, so no halo of background.
// Fuhrmann et al. 2005, section 3.3.7: binary alpha from the covered share.

#include <algorithm>
#include <array>


namespace billow::inline BILLOW_ABI {

/// The mean look of what a texel shows.
struct texel {
    surface_sample look{};  ///< normal in scene space, turned to the front
    int samples = 0;        ///< that show a face
    bool is_opaque = false;
};

/// Shares of a texel that must be covered for it to be opaque.
struct coverage_thresholds {
    double foliage = 0.3;  ///< materials of alpha_mode::mask and blend
    double solid = 0.5;
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
                .emissive = sum_.emissive * scale};
    }

private:
    surface_sample sum_{.base_color = vec3(0),
                        .normal = vec3(0),
                        .occlusion = 0,
                        .roughness = 0,
                        .metallic = 0,
                        .emissive = vec3(0)};
    float weight_ = 0;
};

}  // namespace detail

/// The texel in column x and row y of a view's grid.
[[nodiscard]] inline texel resolve_texel(const visibility_buffer& buffer, view_shader& shader,
                                         const surface& look, int x, int y, int supersample,
                                         const coverage_thresholds& thresholds,
                                         const vec3& front) noexcept {
    std::array<texel_part, max_supersample * max_supersample> parts;
    const std::size_t count = parts_of_texel(buffer, x, y, supersample, parts);
    texel result;
    if (count == 0) return result;
    detail::look_mean mean;
    double threshold = 0;  // summed over the covered samples
    for (std::size_t i = 0; i < count; ++i) {
        const bool is_solid = look.material_of(parts[i].face).alpha == alpha_mode::opaque;
        // Solids at the centre of the texel, or the nearest point of the face: sharp where a texel
        // lies across an edge. Of leaves the centre may be a hole.
        const dvec2 point =
            is_solid ? dvec2(x + 0.5, y + 0.5) * static_cast<double>(supersample) : parts[i].centre;
        mean.add(shader.at(parts[i].face, point), static_cast<float>(parts[i].samples));
        threshold += parts[i].samples * (is_solid ? thresholds.solid : thresholds.foliage);
        result.samples += parts[i].samples;
    }
    result.look = mean.mean(front);
    const double share = static_cast<double>(result.samples) / (supersample * supersample);
    result.is_opaque = share >= threshold / result.samples - 1e-9;
    return result;
}

/// Where the texel in column x and row y of an upright tile lies in the atlas.
[[nodiscard]] inline ivec2 texel_position(const tile& t, int x, int y) noexcept {
    // A quarter turn clockwise takes the row from the top to the column from the right.
    return t.is_rotated ? ivec2(t.x + t.width - 1 - y, t.y + x) : ivec2(t.x + x, t.y + y);
}

/// Writes `value` to the channels that `to` has. Alpha tells whether the texel is opaque.
inline void write_texel(atlas& to, const tile& t, const frame& axes, int x, int y,
                        const texel& value) noexcept {
    const ivec2 at = texel_position(t, x, y);
    const surface_sample& look = value.look;
    std::uint8_t* color = to.base_color.pixel(at.x, at.y);
    for (int c = 0; c < 3; ++c) color[c] = srgb_byte_from_linear(look.base_color[c]);
    color[3] = value.is_opaque ? 255 : 0;

    const dvec3 local = axes.to_local(dvec3(look.normal));
    // A normal map holds nothing that points behind the surface: blue stays at 128 or above.
    vec3 normal(t.is_rotated ? dvec3(local.y, -local.x, local.z) : local);
    normal.z = std::max(normal.z, 0.004f);
    normal = glm::normalize(normal);
    std::uint8_t* n = to.normal.pixel(at.x, at.y);
    for (int c = 0; c < 3; ++c) n[c] = byte_from_unit(normal[c] * 0.5f + 0.5f);

    std::uint8_t* orm = to.occlusion_roughness_metallic.pixel(at.x, at.y);
    orm[0] = byte_from_unit(look.occlusion);
    orm[1] = byte_from_unit(look.roughness);
    orm[2] = byte_from_unit(look.metallic);
    std::uint8_t* emissive = to.emissive.pixel(at.x, at.y);
    for (int c = 0; c < 3; ++c) emissive[c] = srgb_byte_from_linear(look.emissive[c]);
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

struct bake_options {
    int texels = 512;           ///< texels along the diameter of the bounding sphere
    int max_atlas = 4096;       ///< longest side of an atlas, texels
    int supersample = 4;        ///< samples a texel side, 1 to 8; time grows with its square
    int padding = 8;            ///< texels around each tile; p keeps log2(p) mip levels clean
    bool power_of_two = false;  ///< sides of atlases are powers of two; costs area
    double max_extra_angle = 75 * std::numbers::pi / 180;  ///< radians between a plane and other
                                                           ///< valid faces drawn on it; 0: none
    coverage_thresholds thresholds{};
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

namespace detail {

/// One call of bake_cloud; its methods are the steps in their order.
class cloud_baker {
public:
    cloud_baker(const mesh& source, billboard_cloud& cloud, const face_table& faces,
                const bake_options& options, parallel threads, const progress_function& progress)
        : cloud_(cloud),
          faces_(faces),
          options_(options),
          threads_(threads),
          progress_(progress),
          look_(source) {}

    [[nodiscard]] baked_cloud run() {
        choose_texel_size();
        snap_to_texels(cloud_, baked_.texel_size);
        place_tiles();
        draw_tiles();
        report(progress_, "bake", 0.9);
        ensure_every_tile_shows();
        drop_silent_channels();
        fill_borders(baked_, options_.padding, threads_);
        report(progress_, "bake", 1);
        return std::move(baked_);
    }

private:
    static constexpr int band_height = 16;  ///< texel rows drawn at a time: bounds the memory

    struct job {
        plane_id plane = 0;
        int band = 0;
    };
    /// What a job found, to decide over the whole tile.
    struct job_result {
        bool has_opaque = false;
        int most_samples = 0;
        ivec2 best{0};  ///< the texel with most samples, of a tile without opaque ones
    };
    struct job_scratch {
        visibility_buffer buffer;
        view_shader shader;
    };

    [[nodiscard]] pack_options packing_options() const noexcept {
        return {.max_size = options_.max_atlas,
                .padding = options_.padding,
                .power_of_two = options_.power_of_two};
    }

    /// Luksch 2009, eq 4.1: the same object size for every texel. Where a billboard would not fit
    /// into an atlas, all become coarser.
    void choose_texel_size() {
        double largest = 0;
        for (const billboard& b : cloud_.billboards) {
            largest = std::max({largest, b.width, b.height});
        }
        const double wanted = 2 * cloud_.bounds.radius / options_.texels;
        baked_.texel_size = std::max(wanted, largest / largest_side(packing_options()));
        if (!(baked_.texel_size > 0)) baked_.texel_size = 1;  // a single point has no size
    }

    [[nodiscard]] ivec2 upright_size(const billboard& b) const noexcept {
        return {static_cast<int>(std::lround(b.width / baked_.texel_size)),
                static_cast<int>(std::lround(b.height / baked_.texel_size))};
    }

    void place_tiles() {
        std::vector<ivec2> sizes;
        for (const billboard& b : cloud_.billboards) sizes.push_back(upright_size(b));
        const packing places = pack_rectangles(sizes, packing_options());
        double tile_area = 0;
        double atlas_area = 0;
        for (const ivec2& size : places.atlas_sizes) {
            baked_.atlases.push_back(
                {image::filled(size.x, size.y, 4, 0), image::filled(size.x, size.y, 3, 0),
                 image::filled(size.x, size.y, 3, 0), image::filled(size.x, size.y, 3, 0)});
            atlas_area += static_cast<double>(size.x) * size.y;
        }
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            const packed_rectangle& r = places.rectangles[i];
            const ivec2 size = r.is_rotated ? ivec2(sizes[i].y, sizes[i].x) : sizes[i];
            baked_.tiles.push_back({r.atlas, r.x, r.y, size.x, size.y, r.is_rotated});
            tile_area += static_cast<double>(size.x) * size.y;
        }
        baked_.fill = atlas_area > 0 ? tile_area / atlas_area : 0;
    }

    void draw_tiles() {
        const int s = options_.supersample;
        std::size_t widest = 0;
        for (plane_id id = 0; id < cloud_.billboards.size(); ++id) {
            const billboard& b = cloud_.billboards[id];
            const ivec2 size = upright_size(b);
            const orthographic_view view{b.axes, b.origin + b.axes.v * b.height,
                                         baked_.texel_size / s};
            targets_.push_back({view, size.x * s, size.y * s, band_height * s});
            widest = std::max(widest, static_cast<std::size_t>(size.x * s));
            for (int band = 0; band * band_height < size.y; ++band) jobs_.push_back({id, band});
        }
        results_.resize(jobs_.size());
        const double least_cosine =
            options_.max_extra_angle > 0 ? std::cos(options_.max_extra_angle) : 2;
        const draw_sets sets(faces_, cloud_, targets_, least_cosine, threads_);
        report(progress_, "bake", 0.05);

        std::vector<job_scratch> scratches(
            threads_.count(), job_scratch{visibility_buffer(s), view_shader(look_, s)});
        for (job_scratch& scratch : scratches) {
            scratch.buffer.reserve(widest * static_cast<std::size_t>(band_height * s));
        }
        // Progress is told by the calling thread, so between slices of the jobs.
        const std::size_t slices = progress_ ? 16 : 1;
        for (std::size_t i = 0; i < slices; ++i) {
            const std::size_t begin = jobs_.size() * i / slices;
            const std::size_t end = jobs_.size() * (i + 1) / slices;
            for_jobs(threads_, end - begin, scratches, [&](std::size_t k, auto& scratch) {
                const job& j = jobs_[begin + k];
                results_[begin + k] = draw_band(j, sets[j.plane], scratch);
            });
            report(progress_, "bake",
                   0.05 + 0.85 * static_cast<double>(end) / static_cast<double>(jobs_.size()));
        }
    }

    [[nodiscard]] job_result draw_band(const job& j, std::span<const drawn_face> faces,
                                       job_scratch& scratch) noexcept {
        const int s = options_.supersample;
        const draw_target& target = targets_[j.plane];
        const billboard& board = cloud_.billboards[j.plane];
        const int first = j.band * band_height;
        const int last = std::min(first + band_height, target.rows / s);
        scratch.buffer.start({0, first * s, target.columns, last * s});
        const double slack = 1e-5 * std::max(cloud_.bounds.radius, baked_.texel_size);
        const depth_range range{board.depth_low - slack, board.depth_high + slack};
        for (const drawn_face& f : faces) {
            if (f.first_band <= j.band && j.band <= f.last_band) {
                scratch.buffer.draw(look_, target.view, f.face, range);
            }
        }
        scratch.shader.start(target.view);
        const tile& t = baked_.tiles[j.plane];
        job_result result;
        for (int y = first; y < last; ++y) {
            for (int x = 0; x < target.columns / s; ++x) {
                const texel value = resolve_texel(scratch.buffer, scratch.shader, look_, x, y, s,
                                                  options_.thresholds, vec3(board.axes.normal));
                if (value.samples == 0) continue;
                write_texel(baked_.atlases[t.atlas], t, board.axes, x, y, value);
                result.has_opaque |= value.is_opaque;
                if (value.samples > result.most_samples) {
                    result.most_samples = value.samples;
                    result.best = {x, y};
                }
            }
        }
        return result;
    }

    /// A tile without any opaque texel keeps its best covered one; one whose faces slip between all
    /// samples shows the centre of its largest face.
    void ensure_every_tile_shows() {
        std::vector<job_result> of_plane(cloud_.billboards.size());
        for (std::size_t i = 0; i < jobs_.size(); ++i) {
            job_result& total = of_plane[jobs_[i].plane];
            total.has_opaque |= results_[i].has_opaque;
            if (results_[i].most_samples > total.most_samples) {
                total.most_samples = results_[i].most_samples;
                total.best = results_[i].best;
            }
        }
        std::vector<std::size_t> largest_row(of_plane.size(), no_id);
        for (std::size_t row = 0; row < faces_.size; ++row) {
            const plane_id plane = cloud_.plane_of_face[faces_.source[row]];
            if (plane == no_id) continue;
            std::size_t& largest = largest_row[plane];
            if (largest == no_id || faces_.area[row] > faces_.area[largest]) largest = row;
        }
        for (plane_id id = 0; id < of_plane.size(); ++id) {
            if (of_plane[id].has_opaque) continue;
            const tile& t = baked_.tiles[id];
            if (of_plane[id].most_samples > 0) {
                const ivec2 at = texel_position(t, of_plane[id].best.x, of_plane[id].best.y);
                baked_.atlases[t.atlas].base_color.pixel(at.x, at.y)[3] = 255;
            } else if (largest_row[id] != no_id) {
                draw_centre(id, largest_row[id]);
            }
        }
    }

    void draw_centre(plane_id id, std::size_t row) {
        const int s = options_.supersample;
        const draw_target& target = targets_[id];
        const billboard& board = cloud_.billboards[id];
        const dvec2 centre(target.view.project(faces_.centroid(row) + faces_.bounds.centre));
        view_shader shader(look_, s);
        shader.start(target.view);
        const texel value{shader.at(faces_.source[row], centre), 1, true};
        const int x = std::clamp(static_cast<int>(centre.x) / s, 0, target.columns / s - 1);
        const int y = std::clamp(static_cast<int>(centre.y) / s, 0, target.rows / s - 1);
        const tile& t = baked_.tiles[id];
        write_texel(baked_.atlases[t.atlas], t, board.axes, x, y, value);
    }

    /// Empties channels that hold what a reader would assume without them.
    void drop_silent_channels() {
        drop_if_all(&atlas::normal, {127, 127, 254}, {129, 129, 255});
        drop_if_all(&atlas::occlusion_roughness_metallic, {255, 255, 0}, {255, 255, 0});
        drop_if_all(&atlas::emissive, {0, 0, 0}, {0, 0, 0});
    }

    void drop_if_all(image atlas::*channel, const std::array<int, 3>& low,
                     const std::array<int, 3>& high) {
        for (const atlas& a : baked_.atlases) {
            const image& values = a.*channel;
            for (std::size_t i = 0; i < a.base_color.bytes.size() / 4; ++i) {
                if (a.base_color.bytes[4 * i + 3] == 0) continue;
                for (std::size_t c = 0; c < 3; ++c) {
                    const int value = values.bytes[3 * i + c];
                    if (value < low[c] || value > high[c]) return;
                }
            }
        }
        for (atlas& a : baked_.atlases) a.*channel = {};
    }

    billboard_cloud& cloud_;
    const face_table& faces_;
    const bake_options& options_;
    parallel threads_;
    const progress_function& progress_;
    surface look_;
    baked_cloud baked_{};
    std::vector<draw_target> targets_{};
    std::vector<job> jobs_{};
    std::vector<job_result> results_{};
};

}  // namespace detail

/// Draws the textures of a cloud's billboards and packs them into atlases. Each billboard shows its
/// mapped faces and all others that are valid for its plane, seen from its front, within the depth
/// of the mapped ones.
///
/// Needs  `faces` is the table of `source`; billboards as fit_billboards gives them.
/// Gives  tiles and atlases; `cloud.billboards` are enlarged to whole texels, so that every texel
///        covers a square of baked_cloud::texel_size. That is the diameter of the bounding sphere
///        over options.texels, or more where a tile would not fit into an atlas.
/// Cost   O(samples × faces that overlap), parallel over bands of tiles; 13 bytes a texel, and for
///        each thread 8 bytes a sample of a band.
/// Source Luksch 2009, section 4.5. Differs: faces that are merely valid are drawn, too, and the
///        border is filled over the whole transparent area.
[[nodiscard]] inline baked_cloud bake_cloud(const mesh& source, const face_table& faces,
                                            billboard_cloud& cloud,
                                            const bake_options& options = {}, parallel threads = {},
                                            const progress_function& progress = {}) {
    BILLOW_ASSERT(cloud.billboards.size() == cloud.plane_count());
    BILLOW_ASSERT(cloud.plane_of_face.size() == source.face_count());
    BILLOW_ASSERT(options.texels > 0 && options.padding >= 0);
    BILLOW_ASSERT(options.supersample >= 1 && options.supersample <= max_supersample);
    BILLOW_ASSERT(options.max_atlas > 2 * options.padding + 4);
    return detail::cloud_baker(source, cloud, faces, options, threads, progress).run();
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/bake/cloud_mesh.hpp
// A baked cloud as a mesh: two triangles a billboard, one material an atlas.

#include <array>
#include <string>


namespace billow::inline BILLOW_ABI {

namespace detail {

[[nodiscard]] inline texture atlas_texture(mesh& owner, const image& picture) {
    if (picture.empty()) return {};
    owner.images.push_back(picture);
    return {.image = static_cast<image_id>(owner.images.size() - 1),
            .wrap_u = texture_wrap::clamp_to_edge,
            .wrap_v = texture_wrap::clamp_to_edge};
}

inline void add_atlas_material(mesh& to, const atlas& from) {
    material m;
    m.name = "atlas_" + std::to_string(to.materials.size());
    m.base_color_texture = atlas_texture(to, from.base_color);
    m.normal_texture = atlas_texture(to, from.normal);
    m.metallic_roughness_texture = atlas_texture(to, from.occlusion_roughness_metallic);
    m.occlusion_texture = m.metallic_roughness_texture;
    m.metallic = m.metallic_roughness_texture.is_present() ? 1.0f : 0.0f;
    m.emissive_texture = atlas_texture(to, from.emissive);
    if (m.emissive_texture.is_present()) m.emissive = vec3(1);
    m.alpha = alpha_mode::mask;
    m.alpha_cutoff = 0.5f;
    m.is_double_sided = true;
    to.materials.push_back(std::move(m));
}

}  // namespace detail

/// The texture coordinate, from the top left of the atlas, of the point (s, t) of a billboard.
[[nodiscard]] inline dvec2 atlas_uv(const tile& t, const atlas& in, const dvec2& st) noexcept {
    // Upright, t runs up. Turned clockwise, s runs down and t to the right.
    const dvec2 inside = t.is_rotated ? dvec2(st.y, st.x) : dvec2(st.x, 1 - st.y);
    return {(t.x + inside.x * t.width) / in.width(), (t.y + inside.y * t.height) / in.height()};
}

/// The cloud as textured quads where the original mesh is: vertices 4i to 4i + 3 are the corners
/// (0,0), (1,0), (1,1), (0,1) of billboard i, counter-clockwise from its front; faces 2i and 2i + 1
/// its triangles. Tangents run along the atlas's u axis, w = 1: seen from the front no tile is
/// mirrored. Feature ids are plane ids.
///
/// Needs  tiles of `cloud`.
/// Gives  materials of alpha_mode::mask, double sided, one an atlas, with their images.
[[nodiscard]] inline mesh cloud_mesh(const billboard_cloud& cloud, const baked_cloud& baked) {
    BILLOW_ASSERT(baked.tiles.size() == cloud.billboards.size());
    mesh result;
    for (const atlas& a : baked.atlases) detail::add_atlas_material(result, a);
    for (std::size_t i = 0; i < cloud.billboards.size(); ++i) {
        const billboard& b = cloud.billboards[i];
        const tile& t = baked.tiles[i];
        const auto first = static_cast<std::uint32_t>(result.positions.size());
        for (const dvec2& st : {dvec2(0, 0), dvec2(1, 0), dvec2(1, 1), dvec2(0, 1)}) {
            result.positions.push_back(
                vec3(b.origin + b.axes.u * (st.x * b.width) + b.axes.v * (st.y * b.height)));
            result.normals.push_back(vec3(b.axes.normal));
            result.tangents.push_back(vec4(vec3(t.is_rotated ? b.axes.v : b.axes.u), 1));
            result.uv_sets[0].push_back(vec2(atlas_uv(t, baked.atlases[t.atlas], st)));
            result.feature_ids.push_back(static_cast<std::uint32_t>(i));
        }
        result.triangles.push_back({first, first + 1, first + 2});
        result.triangles.push_back({first, first + 2, first + 3});
        result.face_materials.insert(result.face_materials.end(), 2, t.atlas);
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI

// ---- billow/metrics/picture.hpp
// A picture of a mesh, drawn by the rasteriser and the shading that the baker uses: to look at, and to
// measure how close a cloud comes to its original.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// An orthographic camera.
struct picture_view {
    frame axes{};       ///< u to the right, v up in the picture, the normal to the viewer
    dvec3 centre{0};    ///< the scene point in the middle of the picture
    double height = 2;  ///< scene units from the lower to the upper edge
    int width_px = 512;
    int height_px = 512;
};

/// A view of a whole sphere from the direction `from` (any length), +Y up.
[[nodiscard]] inline picture_view view_of(const bounding_sphere& sphere, const dvec3& from,
                                          int width_px = 512, int height_px = 512) {
    const dvec3 normal = glm::normalize(from);
    const bool is_vertical = std::abs(normal.y) > 0.999;
    const dvec3 up = is_vertical ? dvec3(0, 0, normal.y > 0 ? -1 : 1) : dvec3(0, 1, 0);
    const dvec3 u = glm::normalize(glm::cross(up, normal));
    const double shorter = std::min(1.0, static_cast<double>(width_px) / height_px);
    const double height = 2.04 * (sphere.radius > 0 ? sphere.radius : 1.0) / shorter;
    return {{u, glm::cross(normal, u), normal}, sphere.centre, height, width_px, height_px};
}

struct picture_options {
    int supersample = 4;                  ///< samples a pixel side, 1 to 8
    vec3 background{0.85f, 0.87f, 0.9f};  ///< linear light
    float headlight = 0.7f;               ///< light from the viewer's place
    float sky = 0.35f;                    ///< light from above, and half of it from below
};

namespace detail {

[[nodiscard]] inline vec3 lit(const surface_sample& sample, const vec3& toward_viewer,
                              const picture_options& options) noexcept {
    const float facing = std::max(0.0f, glm::dot(sample.normal, toward_viewer));
    const float sky = options.sky * sample.occlusion * (0.75f + 0.25f * sample.normal.y);
    return sample.base_color * (options.headlight * facing + sky) + sample.emissive;
}

struct picture_scratch {
    visibility_buffer buffer;
    view_shader shader;
};

}  // namespace detail

/// Draws `source` with a light at the viewer and one from the sky. Alpha is tested, all faces are
/// seen from both sides.
///
/// Needs  indices within bounds, finite positions.
/// Gives  RGB, sRGB, options.background where nothing is.
/// Cost   O(faces + samples × faces that overlap), parallel over bands of rows.
[[nodiscard]] inline image draw_picture(const mesh& source, const picture_view& from,
                                        const picture_options& options = {},
                                        parallel threads = {}) {
    constexpr int band_height = 16;
    const int s = options.supersample;
    const double sample_size = from.height / (from.height_px * s);
    const dvec3 corner = from.centre - from.axes.u * (0.5 * from.width_px * s * sample_size) +
                         from.axes.v * (0.5 * from.height);
    const draw_target target{
        {from.axes, corner, sample_size}, from.width_px * s, from.height_px * s, band_height * s};
    std::vector<drawn_face> faces;
    for (face_id face = 0; face < source.face_count(); ++face) {
        const auto [a, b, c] = source.corners(face);
        if (const auto drawn = clipped_to(target, face, {dvec3(a), dvec3(b), dvec3(c)})) {
            faces.push_back(*drawn);
        }
    }
    std::sort(faces.begin(), faces.end());

    const surface look(source);
    const vec3 toward_viewer(from.axes.normal);
    image picture = image::filled(from.width_px, from.height_px, 3, 0);
    const auto bands = static_cast<std::size_t>((from.height_px + band_height - 1) / band_height);
    std::vector<detail::picture_scratch> scratches(threads.count(),
                                                   {visibility_buffer(s), view_shader(look, s)});
    for (auto& scratch : scratches) {
        scratch.buffer.reserve(static_cast<std::size_t>(target.columns) *
                               static_cast<std::size_t>(target.band_rows));
        scratch.shader.start(target.view);
    }
    for_jobs(threads, bands, scratches, [&](std::size_t band, auto& scratch) {
        const int first = static_cast<int>(band) * band_height;
        const int last = std::min(first + band_height, from.height_px);
        scratch.buffer.start({0, first * s, target.columns, last * s});
        for (const drawn_face& f : faces) {
            if (f.first_band <= band && band <= f.last_band) {
                scratch.buffer.draw(look, target.view, f.face, {});
            }
        }
        std::array<texel_part, max_supersample * max_supersample> parts;
        for (int y = first; y < last; ++y) {
            for (int x = 0; x < from.width_px; ++x) {
                const std::size_t count = parts_of_texel(scratch.buffer, x, y, s, parts);
                vec3 sum{0};
                int covered = 0;
                for (std::size_t i = 0; i < count; ++i) {
                    const surface_sample sample = scratch.shader.at(parts[i].face, parts[i].centre);
                    sum += glm::min(detail::lit(sample, toward_viewer, options), vec3(1)) *
                           static_cast<float>(parts[i].samples);
                    covered += parts[i].samples;
                }
                sum += options.background * static_cast<float>(s * s - covered);
                std::uint8_t* pixel = picture.pixel(x, y);
                for (int c = 0; c < 3; ++c) {
                    pixel[c] = srgb_byte_from_linear(sum[c] / static_cast<float>(s * s));
                }
            }
        }
    });
    return picture;
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

// ---- billow/pipeline.hpp
// A mesh in, a billboard cloud with its textures out, in one call.

#include <chrono>
#include <cmath>
#include <string>
#include <utility>


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
    bake_options bake{};
    parallel threads{};
};

/// A textured billboard cloud, and how it came about.
struct build_result {
    billboard_cloud cloud{};
    baked_cloud baked{};
    greedy_statistics statistics{};
    cloud_errors errors{};
    double search_seconds = 0;
    double bake_seconds = 0;

    /// The cloud as a mesh that lies over the original, ready for write_glb.
    [[nodiscard]] mesh to_mesh() const { return cloud_mesh(cloud, baked); }
};

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
    if (!(options.epsilon.value > 0) || !std::isfinite(options.epsilon.value)) {
        return error{
            error_code::invalid_options,
            "epsilon is " + std::to_string(options.epsilon.value) + ", but must be greater than 0"};
    }
    expected<face_table> faces = make_face_table(source, options.threads);
    if (!faces) return faces.error();

    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    build_result result;
    if (faces->size == 0) {
        result.cloud.bounds = faces->bounds;
        result.cloud.epsilon = options.epsilon.in(faces->bounds);
        result.cloud.plane_of_face.assign(source.face_count(), no_id);
        result.statistics.degenerate_faces = source.face_count();
        return result;
    }
    greedy_options search = options.search;
    search.epsilon = options.epsilon.in(faces->bounds);
    greedy_result found =
        greedy_search(*faces, source.face_count(), search, parts, options.threads, progress);
    result.cloud = std::move(found.cloud);
    result.statistics = found.statistics;
    result.search_seconds = seconds();
    fit_billboards(source, result.cloud, options.threads);
    result.errors = measure_errors(source, result.cloud);
    result.baked =
        bake_cloud(source, *faces, result.cloud, options.bake, options.threads, progress);
    result.bake_seconds = seconds() - result.search_seconds;
    return result;
}
[[nodiscard]] inline expected<build_result> build_cloud(const mesh& source,
                                                        const build_options& options = {}) {
    return build_cloud(source, options, pipeline{});
}

}  // namespace billow::inline BILLOW_ABI
