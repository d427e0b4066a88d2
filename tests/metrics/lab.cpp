#include <billow/metrics/lab.hpp>

#include <array>
#include <cmath>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>
#include <billow/image/image.hpp>

using namespace billow;

TEST_SUITE("metrics/lab") {
    TEST_CASE("sRGB's white, black, grey and corners have their published L*a*b*") {
        struct published {
            vec3 srgb;
            vec3 lab;
        };
        const published values[] = {
            {{1, 1, 1}, {100, 0, 0}},
            {{0, 0, 0}, {0, 0, 0}},
            {{1, 0, 0}, {53.2408f, 80.0925f, 67.2032f}},
            {{0, 1, 0}, {87.7347f, -86.1827f, 83.1793f}},
            {{0, 0, 1}, {32.2970f, 79.1875f, -107.8602f}},
            {{1, 1, 0}, {97.1393f, -21.5537f, 94.4780f}},
            {{0, 1, 1}, {91.1132f, -48.0875f, -14.1312f}},
            {{1, 0, 1}, {60.3242f, 98.2343f, -60.8249f}},
            {{128 / 255.0f, 128 / 255.0f, 128 / 255.0f}, {53.585f, 0, 0}},
        };
        for (const auto& [srgb, lab] : values) {
            const vec3 linear(linear_from_srgb(srgb.x), linear_from_srgb(srgb.y),
                              linear_from_srgb(srgb.z));
            CHECK(delta_e76(lab_from_linear(linear), lab) < 5e-3);
        }
    }
    TEST_CASE("light that is turned to XYZ and back is the same") {
        random_stream random(1);
        for (int i = 0; i < 1000; ++i) {
            const color_lanes<float> light{static_cast<float>(random.unit()),
                                           static_cast<float>(random.unit()),
                                           static_cast<float>(random.unit())};
            const auto back = linear_of_relative_xyz(relative_xyz(light));
            CHECK(std::abs(back.x - light.x) < 2e-6f);
            CHECK(std::abs(back.y - light.y) < 2e-6f);
            CHECK(std::abs(back.z - light.z) < 2e-6f);
        }
    }
    TEST_CASE("L*a*b* is that of the standard's formula in doubles, on both sides of its knee") {
        const auto f = [](double t) {
            const double delta = 6.0 / 29;
            return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
        };
        for (double t = 0; t < 1.5; t += 0.0007) {
            const auto lab = lab_of_relative_xyz(
                color_lanes<float>{static_cast<float>(t), static_cast<float>(t / 2), 0.3f});
            CHECK(std::abs(lab.x - (116 * f(t / 2) - 16)) < 1e-4);
            CHECK(std::abs(lab.y - 500 * (f(t) - f(t / 2))) < 5e-4);
            CHECK(std::abs(lab.z - 200 * (f(t / 2) - f(0.3))) < 2e-4);
        }
    }
    TEST_CASE("lanes give what floats give") {
        using lanes = simd::lanes<simd::wide>;
        for (float t = 0; t < 1; t += 0.01f) {
            const auto one = lab_of_relative_xyz(color_lanes<float>{t, t / 2, 1 - t});
            const auto many = lab_of_relative_xyz(
                color_lanes<simd::wide>{lanes::fill(t), lanes::fill(t / 2), lanes::fill(1 - t)});
            std::array<float, simd::lane_count> lane{};
            lanes::store(lane.data(), many.y);
            for (const float a : lane) CHECK(std::abs(a - one.y) < 1e-3f);
        }
    }
    TEST_CASE("black and white are 100 apart") {
        CHECK(delta_e76(lab_from_linear({0, 0, 0}), lab_from_linear({1, 1, 1})) ==
              doctest::Approx(100).epsilon(1e-5));
    }
}
