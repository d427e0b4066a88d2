// Images as files: PNG, JPEG, BMP and TGA in, PNG out, through stb_image and, where
// BILLOW_HAS_LIBDEFLATE is not defined, stb_image_write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <stb_image.h>
#include <stb_image_write.h>

#include <billow/core/expected.hpp>
#include <billow/image/image.hpp>
#include <billow/io/file.hpp>
#include <billow/io/png_file.hpp>

namespace billow::inline BILLOW_ABI {

/// Widest and highest image that is decoded, in pixels.
inline constexpr int max_image_side = 16384;

namespace detail {

/// The kind of an image that billow does not decode, by its first bytes; null for all others.
[[nodiscard]] inline const char* undecodable_kind(std::span<const std::uint8_t> bytes) {
    const auto has = [&](std::size_t offset, std::string_view text) {
        return bytes.size() >= offset + text.size() &&
               std::equal(text.begin(), text.end(), bytes.begin() + static_cast<long>(offset),
                          [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
    };
    if (has(0, "\xabKTX 20")) return "KTX2";
    if (has(0, "\xabKTX 11")) return "KTX";
    if (has(0, "RIFF") && has(8, "WEBP")) return "WebP";
    if (has(4, "ftypavif") || has(4, "ftypavis")) return "AVIF";
    if (has(0, "DDS ")) return "DDS";
    if (has(0, "GIF8")) return "GIF";
    return nullptr;
}

[[nodiscard]] inline expected<image> decode_stb(std::span<const std::uint8_t> bytes) {
    const auto size = static_cast<int>(bytes.size());
    int width = 0;
    int height = 0;
    int channels = 0;
    if (stbi_info_from_memory(bytes.data(), size, &width, &height, &channels) == 0) {
        return error{error_code::malformed, "is not a PNG, JPEG, BMP or TGA image"};
    }
    if (width <= 0 || height <= 0 || width > max_image_side || height > max_image_side) {
        return error{error_code::too_large,
                     "is an image of " + std::to_string(width) + " x " + std::to_string(height) +
                         " pixels; at most " + std::to_string(max_image_side) + " a side are read"};
    }
    // A palette may turn out to have an alpha channel only while it is decoded.
    stbi_uc* pixels = stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, 0);
    if (pixels == nullptr) {
        return error{error_code::malformed,
                     std::string("is a broken image: ") + stbi_failure_reason()};
    }
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                              static_cast<std::size_t>(channels);
    image decoded{width, height, channels, std::vector<std::uint8_t>(pixels, pixels + count)};
    stbi_image_free(pixels);
    return decoded;
}

}  // namespace detail

/// The image in the bytes of a file, with as many channels as it has.
///
/// Fails   unsupported: KTX2, WebP and others, with what to do; malformed; too_large. The message
///         does not name a file.
[[nodiscard]] inline expected<image> decode_image(std::span<const std::uint8_t> bytes) {
    if (const char* kind = detail::undecodable_kind(bytes)) {
        return error{error_code::unsupported,
                     std::string("is a ") + kind +
                         " image, which billow does not read; convert it to PNG or JPEG first"};
    }
    if (bytes.empty()) return error{error_code::malformed, "is an empty image"};
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
        return error{error_code::too_large, "is an image of more than 2 GiB"};
    }
    return detail::decode_stb(bytes);
}

/// Fails   as read_file and decode_image, naming the file.
[[nodiscard]] inline expected<image> read_image(const std::filesystem::path& file) {
    auto bytes = read_file(file);
    if (!bytes) return bytes.error();
    auto decoded = decode_image(*bytes);
    if (!decoded) {
        return detail::file_error(decoded.error().code, file, decoded.error().message);
    }
    return decoded;
}

/// The bytes of a PNG file, the same ones for the same image.
///
/// Needs   a picture that is not empty and of at most 2 GiB.
[[nodiscard]] inline std::vector<std::uint8_t> encode_png(const image& picture) {
    BILLOW_ASSERT(!picture.empty() && picture.channels >= 1 && picture.channels <= 4);
    std::vector<std::uint8_t> bytes;
#if defined(BILLOW_HAS_LIBDEFLATE)
    bytes = encode_png_deflate(picture);
    if (!bytes.empty()) return bytes;
#endif
    const auto append = [](void* to, void* from, int size) {
        const auto* first = static_cast<const std::uint8_t*>(from);
        static_cast<std::vector<std::uint8_t>*>(to)->assign(first, first + size);
    };
    stbi_write_png_to_func(append, &bytes, picture.width, picture.height, picture.channels,
                           picture.bytes.data(), picture.width * picture.channels);
    return bytes;
}

/// Fails   as write_file.
[[nodiscard]] inline expected<done> write_png(const std::filesystem::path& file,
                                              const image& picture) {
    return write_file(file, encode_png(picture));
}

}  // namespace billow::inline BILLOW_ABI
