#include <billow/core/random.hpp>

#include <doctest/doctest.h>

TEST_SUITE("core/random") {
    TEST_CASE("a number depends on seed and index alone") {
        billow::random_stream stream(5);
        for (std::uint64_t i = 0; i < 10; ++i) CHECK(stream.unit() == billow::random_unit(5, i));
        CHECK(billow::random_unit(5, 0) != billow::random_unit(6, 0));
        CHECK(billow::random_unit(5, 0) != billow::random_unit(5, 1));
    }
    TEST_CASE("numbers fill [0, 1) evenly") {
        double sum = 0;
        double square_sum = 0;
        constexpr int count = 20000;
        for (std::uint64_t i = 0; i < count; ++i) {
            const double x = billow::random_unit(1, i);
            REQUIRE(x >= 0);
            REQUIRE(x < 1);
            sum += x;
            square_sum += x * x;
        }
        CHECK(sum / count == doctest::Approx(0.5).epsilon(0.01));
        CHECK(square_sum / count == doctest::Approx(1.0 / 3).epsilon(0.02));
    }
    TEST_CASE("between stays within its bounds") {
        billow::random_stream stream(9);
        for (int i = 0; i < 1000; ++i) {
            const double x = stream.between(-3, 2);
            REQUIRE(x >= -3);
            REQUIRE(x < 2);
        }
    }
}
