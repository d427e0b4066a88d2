#include <billow/policy/falloff.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("policy/falloff") {
    TEST_CASE("a face counts fully in the middle, half at epsilon, 0.8 there with strength 0.25") {
        CHECK(distance_falloff{}(0.0f, 0.25f) == 1);
        CHECK(distance_falloff{}(0.25f, 0.25f) == 0.5f);
        CHECK(double(distance_falloff{0.25}(0.25f, 0.25f)) == doctest::Approx(0.8));
        CHECK(distance_falloff{0}(0.25f, 0.25f) == 1);
        CHECK(no_falloff{}(0.25f, 0.25f) == 1);
    }
    TEST_CASE("the weight falls without a jump and stays above 0") {
        float before = 1;
        for (int i = 1; i <= 4000; ++i) {
            const float weight = distance_falloff{}(float(i) * 1e-3f, 1.0f);
            CHECK(weight < before);
            CHECK(before - weight < 1.1e-3f);
            CHECK(weight > 0);
            before = weight;
        }
    }
}
