#include <billow/image/alpha_coverage.hpp>

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

using namespace billow;

namespace {

alpha_block whole(const std::vector<float>& alpha, int width) {
    return {alpha, width, 0, 0, width, static_cast<int>(alpha.size()) / width};
}

/// What drawn_area says, by many points.
double counted(const alpha_block& block, const dvec2& low, const dvec2& high, float cutoff) {
    constexpr int side = 400;
    int drawn = 0;
    for (int k = 0; k < side * side; ++k) {
        const dvec2 p =
            low + (high - low) * dvec2(k % side + 0.5, k / side + 0.5) / double{side} - 0.5;
        const dvec2 corner = glm::floor(p);
        const dvec2 t = p - corner;
        const auto at = [&](int i, int j) {
            return double{block.at(static_cast<int>(corner.x) + i, static_cast<int>(corner.y) + j)};
        };
        const double value =
            glm::mix(glm::mix(at(0, 0), at(1, 0), t.x), glm::mix(at(0, 1), at(1, 1), t.x), t.y);
        drawn += value >= double{cutoff} ? 1 : 0;
    }
    return drawn * (high.x - low.x) * (high.y - low.y) / (side * side);
}

}  // namespace

TEST_SUITE("image/alpha_coverage") {
    TEST_CASE("half planes and single texels have the area of their contour") {
        const std::vector<float> step{0, 0, 1, 1, 0, 0, 1, 1};
        CHECK(drawn_area(whole(step, 4), {0, 0}, {4, 2}, 1, 0.5f) == doctest::Approx(4));
        CHECK(drawn_area(whole(step, 4), {0, 0}, {4, 2}, 1, 0.25f) == doctest::Approx(4.5));
        CHECK(drawn_area(whole(step, 4), {1.5, 0.25}, {2.5, 1}, 1, 0.25f) ==
              doctest::Approx(0.75 * 0.75));
        // Around a lone texel (1 - |x|)(1 - |y|) ≥ 1/2: 2 - 2 ln 2 of a texel.
        const std::vector<float> dot{0, 0, 0, 0, 1, 0, 0, 0, 0};
        CHECK(drawn_area(whole(dot, 3), {0, 0}, {3, 3}, 1, 0.5f) ==
              doctest::Approx(0.6137).epsilon(0.02));
    }
    TEST_CASE("any block has the area that points count, within the block alone") {
        for (std::uint32_t seed = 0; seed < 6; ++seed) {
            std::vector<float> alpha;
            random_stream random(seed);
            for (int i = 0; i < 63; ++i) alpha.push_back(static_cast<float>(random.unit()));
            const alpha_block block{alpha, 9, 2, 1, 6, 5};
            const dvec2 low(2.3, 0.9);
            const dvec2 high(7.1, 6);
            const double area = drawn_area(block, low, high, 1, 0.6f);
            CHECK(std::abs(area - counted(block, low, high, 0.6f)) < 0.2);
        }
    }
    TEST_CASE("the scale gives the wanted area, where there is one that does") {
        std::vector<float> alpha;
        random_stream random(5);
        for (int i = 0; i < 400; ++i) {
            const auto value = static_cast<float>(random.unit());
            alpha.push_back(value * value);
        }
        const alpha_block block = whole(alpha, 20);
        for (const double wanted : {20.0, 100.0, 200.0, 350.0}) {
            const float scale = alpha_scale(block, {0, 0}, {20, 20}, wanted, 0.5f);
            CHECK(drawn_area(block, {0, 0}, {20, 20}, scale, 0.5f) ==
                  doctest::Approx(wanted).epsilon(0.005));
        }
        const std::vector<float> opaque(16, 1);
        CHECK(alpha_scale(whole(opaque, 4), {0, 0}, {4, 4}, 16, 0.5f) == 1);
        const std::vector<float> nothing(16, 0);
        CHECK(alpha_scale(whole(nothing, 4), {0, 0}, {4, 4}, 0, 0.5f) == 1);
    }
}
