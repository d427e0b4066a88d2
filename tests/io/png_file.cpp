#include <billow/io/png_file.hpp>

#include <algorithm>
#include <vector>

#include <doctest/doctest.h>

#include <stb_image.h>
#include <stb_image_write.h>

#include <billow/core/random.hpp>
#include <billow/io/image_file.hpp>

#if defined(BILLOW_HAS_LIBDEFLATE)
using namespace billow;

namespace {

/// Smooth, noisy and empty rows, so that every filter wins somewhere.
image rows_of_many_kinds(int width, int height, int channels) {
    image picture = image::filled(width, height, channels, 0);
    random_stream random(static_cast<std::uint64_t>(width * 7 + height * 3 + channels));
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            for (int c = 0; c < channels; ++c) {
                const int noise = static_cast<int>(random.unit() * 256);
                const int values[] = {0, 3 * x + c, 5 * y + x * x, noise, (x + y) * 2 + noise / 64};
                picture.pixel(x, y)[c] = static_cast<std::uint8_t>(values[y / 3 % 5] & 0xff);
            }
        }
    }
    return picture;
}

bool is_kept(const image& picture) {
    const auto file = encode_png_deflate(picture);
    int width = 0;
    int height = 0;
    int channels = 0;
    stbi_uc* pixels = stbi_load_from_memory(file.data(), static_cast<int>(file.size()), &width,
                                            &height, &channels, 0);
    if (pixels == nullptr) return false;
    const bool is_equal = width == picture.width && height == picture.height &&
                          channels == picture.channels &&
                          std::equal(picture.bytes.begin(), picture.bytes.end(), pixels);
    stbi_image_free(pixels);
    return is_equal;
}

}  // namespace

TEST_SUITE("io/png_file") {
    TEST_CASE("stb decodes every byte as it was, for all channels and any size") {
        for (int channels = 1; channels <= 4; ++channels) {
            for (const ivec2 size : {ivec2(1, 1), ivec2(1, 17), ivec2(31, 1), ivec2(2, 2),
                                     ivec2(33, 47), ivec2(257, 65)}) {
                CAPTURE(channels);
                CAPTURE(size.x);
                CHECK(is_kept(rows_of_many_kinds(size.x, size.y, channels)));
            }
        }
    }
    TEST_CASE("each filter is taken where it gives the least sum") {
        const image picture = rows_of_many_kinds(64, 60, 3);
        const auto rows = detail::filtered_rows(picture, {0, 60}, true);
        int taken[5] = {};
        for (std::size_t y = 0; y < 60; ++y) ++taken[rows[y * (64 * 3 + 1)]];
        int kinds = 0;
        for (const int count : taken) kinds += count > 0 ? 1 : 0;
        CHECK(kinds >= 4);
    }
    TEST_CASE("texels that repeat without an order are written without filters") {
        image picture = image::filled(200, 200, 4, 255);
        random_stream random(3);
        const std::uint8_t colours[4][3] = {{90, 140, 31}, {17, 66, 203}, {250, 5, 77}, {9, 98, 9}};
        for (std::size_t i = 0; i < picture.bytes.size(); i += 4) {
            std::copy_n(colours[static_cast<std::size_t>(random.unit() * 4)], 3,
                        picture.bytes.data() + i);
        }
        const auto filtered = detail::filtered_rows(picture, {0, 200}, true);
        const auto plain = detail::filtered_rows(picture, {0, 200}, false);
        const auto packed_size = [](const std::vector<std::uint8_t>& rows) {
            std::vector<std::uint8_t> packed(2 * rows.size());
            libdeflate_compressor* compressor = libdeflate_alloc_compressor(6);
            REQUIRE(compressor != nullptr);
            const std::size_t size = libdeflate_zlib_compress(compressor, rows.data(), rows.size(),
                                                              packed.data(), packed.size());
            libdeflate_free_compressor(compressor);
            return size;
        };
        CHECK(packed_size(plain) < packed_size(filtered));
        CHECK(encode_png_deflate(picture).size() == packed_size(plain) + 57);  // chunks around it
        CHECK(is_kept(picture));
    }
    TEST_CASE("the chunks of a file are those of the specification, with their checksums") {
        const auto file = encode_png_deflate(image{1, 1, 4, {1, 2, 3, 4}});
        const std::vector<std::uint8_t> head{
            0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13, 'I',  'H',  'D',  'R', 0,
            0,    0,   1,   0,   0,    0,    1,    8,    6, 0, 0, 0,  0x1f, 0x15, 0xc4, 0x89};
        REQUIRE(file.size() > head.size() + 12);
        CHECK(std::equal(head.begin(), head.end(), file.begin()));
        const std::vector<std::uint8_t> end{0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};
        CHECK(std::equal(end.rbegin(), end.rend(), file.rbegin()));
    }
    TEST_CASE("a picture is smaller than stb_image_write makes it, and what encode_png writes") {
        const image picture = rows_of_many_kinds(256, 256, 4);
        const auto file = encode_png_deflate(picture);
        CHECK(encode_png(picture) == file);
        std::size_t size = 0;
        stbi_write_png_to_func(
            [](void* to, void*, int bytes) {
                *static_cast<std::size_t*>(to) += static_cast<std::size_t>(bytes);
            },
            &size, picture.width, picture.height, 4, picture.bytes.data(), picture.width * 4);
        CHECK(file.size() < size);
    }
}
#endif
