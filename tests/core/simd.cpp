#include <billow/core/simd.hpp>

#include <array>
#include <cmath>

#include <doctest/doctest.h>

namespace simd = billow::simd;

namespace {

constexpr std::array<float, 16> a{1,  -2, 3.5f, -4.25f, 0,     -0.0f,   7,  8,
                                  -9, 10, 11,   -12,    1e20f, -1e-20f, 15, 16};
constexpr std::array<float, 16> b{-1, 2, 3.5f, 4, 0.5f, 1, -7, 9, -9.5f, 1, 12, -11, 1, 1, -15, 17};

/// Applies `operation` to whole packs and to single lanes, and compares every lane.
template <class Operation>
void check_lanes(const Operation& operation) {
    using V = simd::wide;
    std::array<float, 16> wide{};
    for (std::size_t i = 0; i < 16; i += simd::lanes<V>::count) {
        simd::lanes<V>::store(wide.data() + i, operation(simd::lanes<V>::load(a.data() + i),
                                                         simd::lanes<V>::load(b.data() + i)));
    }
    for (std::size_t i = 0; i < 16; ++i) CHECK(wide[i] == operation(a[i], b[i]));
}

}  // namespace

TEST_SUITE("core/simd") {
    TEST_CASE("every lane computes what a float does") {
        check_lanes([](auto x, auto y) { return simd::min(x, y); });
        check_lanes([](auto x, auto y) { return simd::max(x, y); });
        check_lanes([](auto x, auto) { return simd::abs(x); });
        check_lanes([](auto x, auto) { return simd::sqrt(simd::abs(x)); });
        check_lanes([](auto x, auto y) { return simd::select(x < y, x * y, x - y); });
        check_lanes([](auto x, auto y) {
            using V = decltype(x);
            const V small = simd::max(simd::min(x, simd::lanes<V>::fill(100)), -y);
            return simd::to_float(simd::truncate(small));
        });
    }
    TEST_CASE("cube roots are those of doubles, in every lane") {
        using lanes = simd::lanes<simd::wide>;
        for (double exact = 1e-8; exact < 1e8; exact *= 1.003) {
            const auto cube = static_cast<float>(exact * exact * exact);
            const double root = std::cbrt(static_cast<double>(cube));
            CHECK(std::abs(simd::cube_root(cube) - root) < 3e-7 * root);
            std::array<float, simd::lane_count> packed{};
            lanes::store(packed.data(), simd::cube_root(lanes::fill(cube)));
            for (const float lane : packed) CHECK(std::abs(lane - root) < 3e-7 * root);
        }
    }
    TEST_CASE("columns are padded to whole packs of every width") {
        CHECK(simd::padded(0) == 0);
        CHECK(simd::padded(1) == simd::max_lane_count);
        CHECK(simd::padded(simd::max_lane_count) == simd::max_lane_count);
        CHECK(simd::max_lane_count % simd::lane_count == 0);
    }
}
