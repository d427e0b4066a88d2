// PNG by libdeflate, with filters of our own: smaller than stb_image_write's and several times as
// fast. Empty without BILLOW_HAS_LIBDEFLATE, which the CMake target billow::io defines where it finds
// libdeflate.
//
// Source: W3C, "Portable Network Graphics (PNG) Specification", second edition 2003.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/image/image.hpp>

#if defined(BILLOW_HAS_LIBDEFLATE)
#include <libdeflate.h>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// What the Paeth filter expects of a byte (section 9.4): of left, above and above left the one
/// nearest to left + above - above left.
[[nodiscard]] inline int paeth(int left, int above, int corner) noexcept {
    const int to_left = std::abs(above - corner);
    const int to_above = std::abs(left - corner);
    const int to_corner = std::abs(left + above - 2 * corner);
    const int upper = to_above <= to_corner ? above : corner;
    return to_left <= to_above && to_left <= to_corner ? left : upper;
}

/// One filtered row (section 9.2) at `out`; gives the sum of its bytes as signed magnitudes.
template <class Expect>
std::uint32_t filter_row(const std::uint8_t* row, const std::uint8_t* above, std::size_t size,
                         std::size_t channels, std::uint8_t* out, const Expect& expect) noexcept {
    std::uint32_t sum = 0;
    const auto put = [&](std::size_t i, int left, int corner) {
        const auto value = static_cast<std::uint8_t>(row[i] - expect(left, above[i], corner));
        out[i] = value;
        sum += static_cast<std::uint32_t>(std::abs(static_cast<std::int8_t>(value)));
    };
    for (std::size_t i = 0; i < channels; ++i) put(i, 0, 0);
    for (std::size_t i = channels; i < size; ++i) put(i, row[i - channels], above[i - channels]);
    return sum;
}

struct row_range {
    std::size_t first = 0;
    std::size_t count = 0;
};

/// Some rows of a picture, each with its filter before it: that of least sum (section 12.8), or none.
[[nodiscard]] inline std::vector<std::uint8_t> filtered_rows(const image& picture, row_range rows,
                                                             bool has_filters) {
    const auto channels = static_cast<std::size_t>(picture.channels);
    const std::size_t size = static_cast<std::size_t>(picture.width) * channels;
    std::vector<std::uint8_t> out((size + 1) * rows.count);
    const std::vector<std::uint8_t> no_row(size, 0);
    std::vector<std::uint8_t> trial(5 * size);
    for (std::size_t i = 0; i < rows.count; ++i) {
        const std::size_t y = rows.first + i;
        std::uint8_t* to = out.data() + i * (size + 1);
        const std::uint8_t* row = picture.bytes.data() + y * size;
        const std::uint8_t* above = y > 0 ? row - size : no_row.data();
        if (!has_filters) {
            std::copy_n(row, size, to + 1);
            continue;
        }
        const auto filter = [&](std::size_t kind, const auto& expect) {
            return filter_row(row, above, size, channels, trial.data() + kind * size, expect);
        };
        const std::array<std::uint32_t, 5> sums{
            filter(0, [](int, int, int) { return 0; }),
            filter(1, [](int left, int, int) { return left; }),
            filter(2, [](int, int up, int) { return up; }),
            filter(3, [](int left, int up, int) { return (left + up) / 2; }), filter(4, paeth)};
        const auto best =
            static_cast<std::size_t>(std::min_element(sums.begin(), sums.end()) - sums.begin());
        *to = static_cast<std::uint8_t>(best);
        std::copy_n(trial.data() + best * size, size, to + 1);
    }
    return out;
}

}  // namespace detail

/// The bytes of a PNG file, the same ones for the same image; none where memory is lacking.
///
/// Needs   a picture of 1 to 4 channels that is not empty and of less than 2 GiB.
/// Cost    O(pixels), about 15 ns a byte.
[[nodiscard]] inline std::vector<std::uint8_t> encode_png_deflate(const image& picture) {
    BILLOW_ASSERT(!picture.empty() && picture.channels >= 1 && picture.channels <= 4);
    constexpr int level = 6;  // higher ones take much longer for 1 % less
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(level), &libdeflate_free_compressor);
    if (!compressor) return {};
    const auto pack = [&](const detail::row_range& range, bool has_filters) {
        const auto rows = detail::filtered_rows(picture, range, has_filters);
        std::vector<std::uint8_t> packed(
            libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
        packed.resize(libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(),
                                               packed.data(), packed.size()));
        return packed;
    };
    // Photographs want filters; leaves scattered over an atlas, whose borders repeat their texels,
    // mostly do not. The middle quarter tells.
    const auto height = static_cast<std::size_t>(picture.height);
    const detail::row_range sample{height * 3 / 8, (height + 3) / 4};
    const bool has_filters = pack(sample, true).size() < pack(sample, false).size();
    const std::vector<std::uint8_t> packed = pack({0, height}, has_filters);

    std::vector<std::uint8_t> file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    file.reserve(packed.size() + 64);
    const auto append_word = [](std::vector<std::uint8_t>& to, std::size_t value) {
        for (int shift = 24; shift >= 0; shift -= 8) {
            to.push_back(static_cast<std::uint8_t>(value >> shift & 0xff));
        }
    };
    const auto append_chunk = [&](std::string_view name, std::span<const std::uint8_t> data) {
        append_word(file, data.size());
        const std::size_t checked = file.size();
        file.insert(file.end(), name.begin(), name.end());
        file.insert(file.end(), data.begin(), data.end());
        append_word(file, libdeflate_crc32(0, file.data() + checked, file.size() - checked));
    };
    constexpr std::array<std::uint8_t, 5> colour_type{0, 0, 4, 2, 6};
    std::vector<std::uint8_t> header;
    append_word(header, static_cast<std::size_t>(picture.width));
    append_word(header, static_cast<std::size_t>(picture.height));
    const std::uint8_t type = colour_type[static_cast<std::size_t>(picture.channels)];
    // 8 bits, colour type, deflate, the five filters, not interlaced.
    header.insert(header.end(), {8, type, 0, 0, 0});
    append_chunk("IHDR", header);
    append_chunk("IDAT", packed);
    append_chunk("IEND", {});
    return file;
}

}  // namespace billow::inline BILLOW_ABI
#endif
