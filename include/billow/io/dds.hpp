// Images with all their mip levels as one DDS file, uncompressed.
//
// Source: Microsoft, "Programming guide for DDS" and the reference of DDS_HEADER, DDS_HEADER_DXT10.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <billow/core/expected.hpp>
#include <billow/image/image.hpp>
#include <billow/io/file.hpp>

namespace billow::inline BILLOW_ABI {

/// The bytes of a DDS file: RGBA of 8 bits a channel, the levels one after the other without gaps.
///
/// Shape   images of 1 to 4 channels, each further one half as large, rounded down, at least 1.
///         Grey is spread to three channels, missing alpha is 255.
/// Needs   at least one level.
/// Cost    O(pixels).
[[nodiscard]] inline std::vector<std::uint8_t> encode_dds(std::span<const image> levels,
                                                          bool is_srgb) {
    BILLOW_ASSERT(!levels.empty() && !levels[0].empty());
    std::vector<std::uint8_t> bytes;
    const auto word = [&](std::uint32_t value) {
        for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
    };
    const auto words = [&](int count, std::uint32_t value) {
        for (int i = 0; i < count; ++i) word(value);
    };
    const auto level_count = static_cast<std::uint32_t>(levels.size());
    const bool has_mips = level_count > 1;
    std::size_t pixels = 0;
    for (const image& level : levels) pixels += level.bytes.size();
    bytes.reserve(148 + 4 * pixels / static_cast<std::size_t>(levels[0].channels));

    word(0x20534444);  // "DDS "
    word(124);         // size of the header
    // Caps, height, width, pitch, pixel format; and the count of levels.
    word(0x1u | 0x2u | 0x4u | 0x8u | 0x1000u | (has_mips ? 0x20000u : 0u));
    word(static_cast<std::uint32_t>(levels[0].height));
    word(static_cast<std::uint32_t>(levels[0].width));
    word(static_cast<std::uint32_t>(levels[0].width) * 4);  // bytes a row of the first level
    word(0);                                                // depth
    word(level_count);
    words(11, 0);
    word(32);          // size of the pixel format
    word(0x4);         // it is named by four characters:
    word(0x30315844);  // "DX10"
    words(5, 0);
    word(0x1000u | (has_mips ? 0x400008u : 0u));  // texture; mip map, complex
    words(4, 0);
    word(is_srgb ? 29 : 28);  // DXGI_FORMAT_R8G8B8A8_UNORM_SRGB, …_UNORM
    word(3);                  // two dimensions
    word(0);
    word(1);  // one image
    word(0);  // what alpha means is not said

    for (std::size_t i = 0; i < levels.size(); ++i) {
        const image& level = levels[i];
        BILLOW_ASSERT(i >= 31 || (level.width == std::max(1, levels[0].width >> i) &&
                                  level.height == std::max(1, levels[0].height >> i)));
        const auto channels = static_cast<std::size_t>(level.channels);
        if (channels == 4) {
            bytes.insert(bytes.end(), level.bytes.begin(), level.bytes.end());
            continue;
        }
        for (std::size_t at = 0; at < level.bytes.size(); at += channels) {
            const std::uint8_t* p = level.bytes.data() + at;
            const bool is_grey = channels < 3;
            const std::uint8_t alpha = channels == 2 ? p[1] : std::uint8_t{255};
            bytes.insert(bytes.end(), {p[0], p[is_grey ? 0 : 1], p[is_grey ? 0 : 2], alpha});
        }
    }
    return bytes;
}

/// Fails   as write_file.
[[nodiscard]] inline expected<done> write_dds(const std::filesystem::path& file,
                                              std::span<const image> levels, bool is_srgb) {
    return write_file(file, encode_dds(levels, is_srgb));
}

}  // namespace billow::inline BILLOW_ABI
