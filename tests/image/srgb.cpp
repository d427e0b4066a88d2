#include <billow/image/srgb.hpp>

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <billow/image/image.hpp>

using namespace billow;

TEST_SUITE("image/srgb") {
    TEST_CASE("every byte survives the way to linear light and back") {
        for (int byte = 0; byte < 256; ++byte) {
            const float linear = linear_of_srgb_byte()[static_cast<std::size_t>(byte)];
            CHECK(srgb_byte_from_linear(linear) == byte);
            CHECK(srgb_from_linear(linear) * 255 == doctest::Approx(byte).epsilon(1e-3));
        }
    }
    TEST_CASE("the byte is the nearest one, wherever the light lies") {
        for (int i = 0; i <= 20000; ++i) {
            const float linear = static_cast<float>(i) / 20000;
            const double exact = 255 * static_cast<double>(srgb_from_linear(linear));
            CHECK(std::abs(srgb_byte_from_linear(linear) - exact) <= 0.5 + 1e-3);
        }
    }
    TEST_CASE("light beyond [0, 1] is clamped") {
        CHECK(srgb_byte_from_linear(-1) == 0);
        CHECK(srgb_byte_from_linear(7) == 255);
        CHECK(srgb_byte_from_linear(std::numeric_limits<float>::infinity()) == 255);
        CHECK(srgb_byte_from_linear(std::nanf("")) == 0);
    }
}
