#include <billow/io/dds.hpp>

#include <doctest/doctest.h>

using namespace billow;

namespace {

std::uint32_t word_at(const std::vector<std::uint8_t>& file, std::size_t at) {
    return file.at(at) | static_cast<std::uint32_t>(file.at(at + 1)) << 8 |
           static_cast<std::uint32_t>(file.at(at + 2)) << 16 |
           static_cast<std::uint32_t>(file.at(at + 3)) << 24;
}

}  // namespace

TEST_SUITE("io/dds") {
    TEST_CASE("header fields lie at their documented offsets, levels follow without gaps") {
        const std::vector<image> levels{image::filled(6, 3, 4, 10), image::filled(3, 1, 4, 20),
                                        image::filled(1, 1, 4, 30)};
        const auto file = encode_dds(levels, true);
        CHECK(word_at(file, 0) == 0x20534444);
        CHECK(word_at(file, 4) == 124);
        CHECK(word_at(file, 8) == 0x2100f);
        CHECK(word_at(file, 12) == 3);  // height before width
        CHECK(word_at(file, 16) == 6);
        CHECK(word_at(file, 20) == 24);
        CHECK(word_at(file, 28) == 3);
        CHECK(word_at(file, 76) == 32);
        CHECK(word_at(file, 80) == 4);
        CHECK(word_at(file, 84) == 0x30315844);
        CHECK(word_at(file, 108) == 0x401008);
        CHECK(word_at(file, 128) == 29);
        CHECK(word_at(file, 132) == 3);
        CHECK(word_at(file, 140) == 1);
        REQUIRE(file.size() == 148 + 4 * (18 + 3 + 1));
        CHECK(file[148] == 10);
        CHECK(file[148 + 72] == 20);
        CHECK(file[148 + 84] == 30);
        CHECK(word_at(encode_dds(levels, false), 128) == 28);
    }

    TEST_CASE("one level has no mip flags; grey is spread and alpha is opaque") {
        const std::vector<image> grey{image{1, 1, 1, {7}}};
        const auto file = encode_dds(grey, false);
        CHECK(word_at(file, 8) == 0x100f);
        CHECK(word_at(file, 108) == 0x1000);
        CHECK(word_at(file, 148) == 0xff070707);
        CHECK(word_at(encode_dds(std::vector{image{1, 1, 2, {7, 9}}}, false), 148) == 0x09070707);
        CHECK(word_at(encode_dds(std::vector{image{1, 1, 3, {1, 2, 3}}}, false), 148) ==
              0xff030201);
    }
}
