#include <billow/image/mip_chain.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("image/mip_chain") {
    TEST_CASE("an sRGB byte survives linear light, and steps lie half way") {
        for (int i = 0; i < 256; ++i) {
            const auto byte = static_cast<std::uint8_t>(i);
            CHECK(srgb_byte_from_linear(linear_of_srgb_byte()[byte]) == byte);
        }
        for (int i = 0; i <= 5000; ++i) {
            const float light = static_cast<float>(i) / 5000.0f;
            const int exact = byte_from_unit(srgb_from_linear(light));
            const int found = srgb_byte_from_linear(light);
            CHECK(std::abs(exact - found) <=
                  (std::abs(srgb_from_linear(light) * 255.0f - static_cast<float>(exact)) > 0.499f
                       ? 1
                       : 0));
        }
        CHECK(srgb_byte_from_linear(-1) == 0);
        CHECK(srgb_byte_from_linear(7) == 255);
        CHECK(srgb_byte_from_linear(std::nanf("")) == 0);
    }

    TEST_CASE("sizes are halved down to one pixel, odd ones too") {
        const auto chain = make_mip_chain(image::filled(13, 6, 3, 77), texel_kind::srgb);
        REQUIRE(chain.size() == 4);
        CHECK(chain[1].width == 6);
        CHECK(chain[1].height == 3);
        CHECK(chain[3].width == 1);
        CHECK(chain[3].height == 1);
        for (const image& level : chain) {
            CHECK(level.bytes[0] == 77);
            CHECK(level.bytes[3] == 255);
        }
    }

    TEST_CASE("every level keeps the mean, also of odd sizes") {
        image source{7, 5, 1, {}};
        double mean = 0;
        for (int i = 0; i < 35; ++i) {
            source.bytes.push_back(static_cast<std::uint8_t>(i * 7));
            mean += i * 7 / 35.0;
        }
        const auto chain = make_mip_chain(source, texel_kind::linear);
        CHECK(std::abs(chain.back().bytes[0] - mean) <= 1);
    }

    TEST_CASE("black and white mean to the middle of linear light") {
        const image source{2, 1, 3, {0, 0, 0, 255, 255, 255}};
        CHECK(make_mip_chain(source, texel_kind::srgb).back().bytes[0] == 188);
        CHECK(make_mip_chain(source, texel_kind::linear).back().bytes[0] == 128);
    }

    TEST_CASE("what is transparent lends no colour") {
        const image source{2, 1, 4, {200, 10, 10, 255, 0, 255, 0, 0}};
        const image last = make_mip_chain(source, texel_kind::srgb_alpha).back();
        CHECK(last.bytes == std::vector<std::uint8_t>{200, 10, 10, 128});
    }
}
