#include <billow/io/image_file.hpp>

#include <doctest/doctest.h>

#include "scratch.hpp"

using namespace billow;
using scratch::failed;

namespace {

image gradient(int width, int height, int channels) {
    image picture = image::filled(width, height, channels, 0);
    for (std::size_t i = 0; i < picture.bytes.size(); ++i) {
        picture.bytes[i] = static_cast<std::uint8_t>(i * 37 % 251);
    }
    return picture;
}

std::vector<std::uint8_t> bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

}  // namespace

TEST_SUITE("io/image_file") {
    TEST_CASE("a PNG keeps every byte, for 1 to 4 channels") {
        for (int channels = 1; channels <= 4; ++channels) {
            const image picture = gradient(13, 7, channels);
            const auto decoded = decode_image(encode_png(picture));
            REQUIRE(decoded);
            CHECK(*decoded == picture);
            CHECK(encode_png(picture) == encode_png(picture));
        }
    }

    TEST_CASE("a PNG on disk is read back") {
        const scratch::folder at;
        const image picture = gradient(3, 5, 4);
        REQUIRE(write_png(at / "a.png", picture));
        CHECK(*read_image(at / "a.png") == picture);
        CHECK(failed(read_image(at / "b.png"), error_code::not_found, "", "b.png"));
    }

    TEST_CASE("a BMP of four pixels is read") {
        // 1 x 2, 24 bits, rows from the bottom, blue first, padded to 4 bytes.
        std::vector<std::uint8_t> file(54, 0);
        file[0] = 'B';
        file[1] = 'M';
        file[2] = 62;
        file[10] = 54;
        file[14] = 40;
        file[18] = 1;
        file[22] = 2;
        file[26] = 1;
        file[28] = 24;
        for (const int byte : {255, 0, 0, 0, 0, 0, 255, 0}) {
            file.push_back(static_cast<std::uint8_t>(byte));
        }
        const auto decoded = decode_image(file);
        REQUIRE(decoded);
        CHECK(decoded->width == 1);
        CHECK(decoded->height == 2);
        CHECK(decoded->pixel(0, 0)[0] == 255);  // red above
        CHECK(decoded->pixel(0, 1)[2] == 255);  // blue below
    }

    TEST_CASE("images that are not read are named with what to do") {
        using namespace std::string_view_literals;
        const auto kind = [](std::string_view bytes) {
            const auto decoded = decode_image(bytes_of(bytes));
            REQUIRE_FALSE(decoded);
            CHECK(decoded.error().code == error_code::unsupported);
            CHECK(decoded.error().message.find("convert it to PNG") != std::string::npos);
            return decoded.error().message;
        };
        CHECK(kind("\xabKTX 20\xbb\r\n\x1a\n"sv).find("KTX2") != std::string::npos);
        CHECK(kind("RIFF\0\0\0\0WEBPVP8 "sv).find("WebP") != std::string::npos);
        CHECK(kind("\0\0\0\x20"
                   "ftypavif"sv)
                  .find("AVIF") != std::string::npos);
    }

    TEST_CASE("broken, empty and oversized images fail") {
        auto png = encode_png(gradient(64, 64, 3));
        CHECK(decode_image({}).error().code == error_code::malformed);
        CHECK(decode_image(bytes_of("no image at all")).error().code == error_code::malformed);
        CHECK(decode_image(std::span(png).first(png.size() / 2)).error().code ==
              error_code::malformed);
        png[16] = 0x7f;  // the width, big endian
        CHECK_FALSE(decode_image(png));
        png[16] = 0;
        png[17] = 1;  // 65,600 wide
        CHECK(decode_image(png).error().code == error_code::too_large);
    }
}
