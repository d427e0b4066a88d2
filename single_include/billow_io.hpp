// Generated from include/billow by amalgamate.py, do not edit.
#pragma once

#include "billow.hpp"

// ---- billow/io.hpp
// All of io/. In exactly one .cpp of your program, and before any other header of billow or of the
// libraries below, say
//
//     #define BILLOW_IO_IMPLEMENTATION
//     #include <billow/io.hpp>
//
// which adds the bodies of tinygltf, tinyobjloader, stb_image and stb_image_write. A program that
// has these bodies already leaves it out.

#if defined(BILLOW_IO_IMPLEMENTATION)
#define STBI_FAILURE_USERMSG
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_BMP
#define STBI_ONLY_TGA
#define STB_IMAGE_IMPLEMENTATION
#include <stb_image.h>
#undef STB_IMAGE_IMPLEMENTATION

#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>
#undef STB_IMAGE_WRITE_IMPLEMENTATION

#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>
#undef TINYOBJLOADER_IMPLEMENTATION

// tinygltf would include it with hidden visibility.
#include <nlohmann/json.hpp>

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
#undef TINYGLTF_IMPLEMENTATION
#endif

// ---- billow/io/dds.hpp
// Images with all their mip levels as one DDS file, uncompressed.
//
// Source: Microsoft, "Programming guide for DDS" and the reference of DDS_HEADER, DDS_HEADER_DXT10.

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

// ---- billow/io/file.hpp
// Files as bytes: read whole, written aside and renamed, so that no reader meets half a file.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Largest file that is read, 4 GiB: the size that a GLB header can state.
inline constexpr std::uintmax_t max_file_size = 0xffff'ffffu;

namespace detail {

/// `text` without line breaks and other control characters, at most about 300 bytes of it.
[[nodiscard]] inline std::string one_line(std::string_view text) {
    constexpr std::size_t longest = 300;
    std::string line;
    for (const char c : text.substr(0, longest)) {
        const bool is_control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
        if (!is_control) {
            line += c;
        } else if (!line.empty() && line.back() != ' ') {
            line += ' ';
        }
    }
    while (!line.empty() && line.back() == ' ') line.pop_back();
    return text.size() > longest ? line + "…" : line;
}

/// An error whose one line names file and fault.
[[nodiscard]] inline error file_error(error_code code, const std::filesystem::path& file,
                                      std::string_view fault) {
    return {code, one_line(file.string()) + ": " + one_line(fault)};
}

/// The file that will hold the bytes until they are all there: a free name beside the target.
[[nodiscard]] inline std::filesystem::path name_aside(const std::filesystem::path& target) {
    for (int i = 0;; ++i) {
        std::filesystem::path name = target;
        name += ".part" + (i == 0 ? std::string() : std::to_string(i));
        std::error_code ignored;
        if (!std::filesystem::exists(std::filesystem::symlink_status(name, ignored))) return name;
    }
}

/// What forbids to write `target`, as far as can be told without writing.
[[nodiscard]] inline expected<done> check_target(const std::filesystem::path& target) {
    std::error_code why;
    const auto status = std::filesystem::status(target, why);
    const auto refuse = [&](std::string_view fault) {
        return file_error(error_code::unwritable, target, fault);
    };
    if (target.filename().empty()) return refuse("is not a file name");
    if (std::filesystem::is_directory(status)) return refuse("is a folder");
    if (std::filesystem::exists(status) &&
        (status.permissions() & std::filesystem::perms::owner_write) ==
            std::filesystem::perms::none) {
        return refuse("is write-protected");
    }
    const auto folder = target.parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder, why)) {
        return refuse("its folder does not exist");
    }
    return done{};
}

}  // namespace detail

/// The bytes of a file.
///
/// Fails   not_found: missing, a folder, or no right to read; malformed: empty; too_large: more
///         than `size_limit` bytes; truncated: it shrinks while being read.
[[nodiscard]] inline expected<std::vector<std::uint8_t>> read_file(
    const std::filesystem::path& file, std::uintmax_t size_limit = max_file_size) {
    const auto fail = [&](error_code code, std::string_view fault) {
        return detail::file_error(code, file, fault);
    };
    std::error_code why;
    const auto status = std::filesystem::status(file, why);
    if (!std::filesystem::exists(status)) return fail(error_code::not_found, "no such file");
    if (std::filesystem::is_directory(status)) {
        return fail(error_code::not_found, "is a folder, not a file");
    }
    if (!std::filesystem::is_regular_file(status)) {
        return fail(error_code::not_found, "is not a regular file");
    }
    const std::uintmax_t size = std::filesystem::file_size(file, why);
    if (why) return fail(error_code::not_found, "its size cannot be read: " + why.message());
    if (size == 0) return fail(error_code::malformed, "is empty");
    if (size > size_limit) {
        return fail(error_code::too_large, "has " + std::to_string(size) +
                                               " bytes, more than the " +
                                               std::to_string(size_limit) + " that are read");
    }
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return fail(error_code::not_found, "cannot be opened for reading");
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (stream.gcount() != static_cast<std::streamsize>(bytes.size())) {
        return fail(error_code::truncated, "could not be read to its end");
    }
    return bytes;
}

/// Tells before the work starts whether write_file will be able to write `file`. Leaves nothing.
///
/// Fails   unwritable.
[[nodiscard]] inline expected<done> check_writable(const std::filesystem::path& file) {
    auto checked = detail::check_target(file);
    if (!checked) return checked;
    std::error_code ignored;
    if (std::filesystem::is_other(file, ignored)) return done{};  // a device or pipe
    const auto aside = detail::name_aside(file);
    const bool is_open = std::ofstream(aside, std::ios::binary).is_open();
    if (is_open) std::filesystem::remove(aside, ignored);
    if (!is_open) {
        return detail::file_error(error_code::unwritable, file, "cannot be created in its folder");
    }
    return done{};
}

/// Writes `bytes` beside `file` and renames: `file` is there whole, or as it was before.
///
/// Fails   unwritable. Nothing is left behind then.
[[nodiscard]] inline expected<done> write_file(const std::filesystem::path& file,
                                               std::span<const std::uint8_t> bytes) {
    auto checked = detail::check_target(file);
    if (!checked) return checked;
    const auto write = [&](const std::filesystem::path& name) {
        std::ofstream stream(name, std::ios::binary | std::ios::trunc);
        stream.write(reinterpret_cast<const char*>(bytes.data()),
                     static_cast<std::streamsize>(bytes.size()));
        stream.close();
        return !stream.fail();
    };
    const auto fail = [&](std::string_view fault) {
        return detail::file_error(error_code::unwritable, file, fault);
    };
    std::error_code why;
    if (std::filesystem::is_other(file, why)) {  // a device or pipe cannot be renamed over
        return write(file) ? expected<done>(done{}) : fail("cannot be written");
    }
    // A link keeps pointing to its file.
    const auto target = std::filesystem::is_symlink(file, why)
                            ? std::filesystem::weakly_canonical(file, why)
                            : file;
    const auto aside = detail::name_aside(target);
    if (write(aside)) {
        std::filesystem::rename(aside, target, why);
        if (!why) return done{};
    }
    std::error_code ignored;
    std::filesystem::remove(aside, ignored);
    return fail(why ? "cannot be replaced: " + why.message() : "cannot be written");
}

/// The file that a relative `name` within a file of `folder` means.
///
/// Fails   unsupported: an absolute name or one that climbs out of `folder`, since a mesh from
///         elsewhere has no business in other folders.
[[nodiscard]] inline expected<std::filesystem::path> file_beside(
    const std::filesystem::path& folder, const std::filesystem::path& name) {
    const auto plain = name.lexically_normal();
    if (plain.empty() || plain.has_root_path() || *plain.begin() == "..") {
        return detail::file_error(error_code::unsupported, name,
                                  "lies outside of the folder of the file that names it; "
                                  "move it beside that file");
    }
    return folder / plain;
}

}  // namespace billow::inline BILLOW_ABI

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
// ---- billow/io/glb.hpp
// glTF 2.0 out: any mesh of ours as one .glb, the same bytes for the same mesh.
//
// Source: glTF 2.0 Specification, Khronos Group 2021.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

// ---- billow/io/image_file.hpp
// Images as files: PNG, JPEG, BMP and TGA in, PNG out, through stb_image and, where
// BILLOW_HAS_LIBDEFLATE is not defined, stb_image_write.

#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <stb_image.h>
#include <stb_image_write.h>

// ---- billow/io/png_file.hpp
// PNG by libdeflate, with filters of our own: smaller than stb_image_write's and several times as
// fast. Empty without BILLOW_HAS_LIBDEFLATE, which the CMake target billow::io defines where it finds
// libdeflate.
//
// Source: W3C, "Portable Network Graphics (PNG) Specification", second edition 2003.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string_view>
#include <vector>


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

namespace billow::inline BILLOW_ABI {

/// A node of its own for some faces of a mesh.
struct glb_node {
    std::string name{};
    std::vector<face_id> faces{};
};

struct glb_options {
    std::string name{};             ///< of mesh and node; empty: none
    std::vector<glb_node> nodes{};  ///< none: one node for all faces, called `name`
    std::string extras{};           ///< JSON text that asset.extras will hold; empty: none
    parallel threads{};             ///< images are encoded in parallel
};

namespace detail {

/// Lays out one GLB. Vertices are written with the primitives that use them, one a material.
class glb_encoder {
public:
    glb_encoder(const mesh& source, const glb_options& options) : mesh_(source), options_(options) {
        for (std::uint32_t s = 0; s < uv_set_count; ++s) {
            if (!mesh_.uv_sets[s].empty()) written_uv_sets_.push_back(s);
        }
    }

    [[nodiscard]] std::vector<std::uint8_t> run() {
        root_["asset"] = {{"version", "2.0"}, {"generator", "billow " BILLOW_VERSION}};
        if (!options_.extras.empty()) {
            root_["asset"]["extras"] = json::parse(options_.extras, nullptr, false);
        }
        root_["scene"] = 0;
        write_nodes();
        if (meshes_.empty()) {
            root_["scenes"] = json::array({json::object()});
        } else {
            write_images();
            json ids = json::array();
            json nodes = json::array();
            for (std::size_t i = 0; i < meshes_.size(); ++i) {
                json node = json::object();
                if (meshes_[i].contains("name")) node["name"] = meshes_[i]["name"];
                node["mesh"] = i;
                ids.push_back(i);
                nodes.push_back(std::move(node));
            }
            root_["scenes"] = json::array({{{"nodes", std::move(ids)}}});
            root_["nodes"] = std::move(nodes);
            root_["meshes"] = std::move(meshes_);
            for (auto* part :
                 {&materials_, &textures_, &samplers_, &images_, &accessors_, &views_}) {
                if (!part->second.empty()) root_[part->first] = std::move(part->second);
            }
            if (uses_transform_) root_["extensionsUsed"] = {"KHR_texture_transform"};
            root_["buffers"] = json::array({{{"byteLength", binary_.size()}}});
        }
        return container();
    }

private:
    using json = nlohmann::ordered_json;
    using section = std::pair<const char*, json>;

    // ---- binary

    template <class T>
    std::size_t add_view(const std::vector<T>& values, int target = 0) {
        const std::size_t offset = binary_.size();
        const std::size_t size = values.size() * sizeof(T);
        binary_.resize(offset + (size + 3) / 4 * 4, 0);
        std::memcpy(binary_.data() + offset, values.data(), size);
        json view{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}};
        if (target != 0) view["target"] = target;
        views_.second.push_back(std::move(view));
        return views_.second.size() - 1;
    }

    template <class T>
    std::size_t add_accessor(const std::vector<T>& values, int component, const char* type,
                             int target) {
        accessors_.second.push_back({{"bufferView", add_view(values, target)},
                                     {"componentType", component},
                                     {"count", values.size()},
                                     {"type", type}});
        return accessors_.second.size() - 1;
    }

    // ---- faces

    void write_nodes() {
        if (!options_.nodes.empty()) {
            for (const glb_node& node : options_.nodes) write_mesh(node.name, node.faces);
            return;
        }
        std::vector<face_id> all(mesh_.face_count());
        std::iota(all.begin(), all.end(), face_id{0});
        write_mesh(options_.name, all);
    }

    /// A mesh of these faces, and its node; nothing where there are none.
    void write_mesh(const std::string& name, const std::vector<face_id>& faces) {
        if (faces.empty()) return;
        json mesh = json::object();
        if (!name.empty()) mesh["name"] = name;
        mesh["primitives"] = write_primitives(faces);
        meshes_.push_back(std::move(mesh));
    }

    [[nodiscard]] json write_primitives(const std::vector<face_id>& mesh_faces) {
        json primitives = json::array();
        std::map<material_id, std::vector<face_id>> faces_of;
        for (const face_id face : mesh_faces) {
            const material_id id = mesh_.face_materials.empty() ? 0 : mesh_.face_materials[face];
            faces_of[id < mesh_.materials.size() ? id : no_id].push_back(face);
        }
        std::vector<std::uint32_t> new_ids(mesh_.vertex_count(), no_id);
        for (const auto& [material, faces] : faces_of) {
            std::vector<std::uint32_t> vertices;
            std::vector<std::uint32_t> indices;
            indices.reserve(faces.size() * 3);
            for (const face_id face : faces) {
                for (int c = 0; c < 3; ++c) {
                    const std::uint32_t v = mesh_.triangles[face][c];
                    if (new_ids[v] == no_id) {
                        new_ids[v] = static_cast<std::uint32_t>(vertices.size());
                        vertices.push_back(v);
                    }
                    indices.push_back(new_ids[v]);
                }
            }
            for (const std::uint32_t v : vertices) new_ids[v] = no_id;
            primitives.push_back({{"attributes", write_vertices(vertices)},
                                  {"indices", write_indices(indices, vertices.size())},
                                  {"material", material_row(material)}});
        }
        return primitives;
    }

    std::size_t write_indices(const std::vector<std::uint32_t>& indices, std::size_t vertex_count) {
        constexpr int element_array = 34963;
        if (vertex_count > 0xffff) return add_accessor(indices, 5125, "SCALAR", element_array);
        std::vector<std::uint16_t> narrow(indices.size());
        std::transform(indices.begin(), indices.end(), narrow.begin(),
                       [](std::uint32_t i) { return static_cast<std::uint16_t>(i); });
        return add_accessor(narrow, 5123, "SCALAR", element_array);
    }

    [[nodiscard]] json write_vertices(const std::vector<std::uint32_t>& vertices) {
        constexpr int array = 34962;
        constexpr int as_float = 5126;
        json attributes = json::object();
        const auto write = [&](const std::string& name, const char* type, const auto& column) {
            if (column.empty()) return;
            std::remove_cvref_t<decltype(column)> rows;
            rows.reserve(vertices.size());
            for (const std::uint32_t v : vertices) rows.push_back(column[v]);
            attributes[name] = add_accessor(rows, as_float, type, array);
        };
        write("POSITION", "VEC3", mesh_.positions);
        vec3 low = mesh_.positions[vertices.front()];
        vec3 high = low;
        for (const std::uint32_t v : vertices) {
            low = glm::min(low, mesh_.positions[v]);
            high = glm::max(high, mesh_.positions[v]);
        }
        accessors_.second.back()["min"] = {low.x, low.y, low.z};
        accessors_.second.back()["max"] = {high.x, high.y, high.z};
        write("NORMAL", "VEC3", mesh_.normals);
        if (!mesh_.normals.empty()) write("TANGENT", "VEC4", mesh_.tangents);
        for (std::size_t i = 0; i < written_uv_sets_.size(); ++i) {
            write("TEXCOORD_" + std::to_string(i), "VEC2", mesh_.uv_sets[written_uv_sets_[i]]);
        }
        write("COLOR_0", "VEC4", mesh_.colors);
        if (!mesh_.feature_ids.empty()) {  // a whole number as float: exact up to 2^24
            std::vector<float> ids;
            ids.reserve(vertices.size());
            for (const auto v : vertices) ids.push_back(static_cast<float>(mesh_.feature_ids[v]));
            attributes["_FEATURE_ID_0"] = add_accessor(ids, as_float, "SCALAR", array);
        }
        return attributes;
    }

    // ---- materials

    /// Each material is written once, when it is met first.
    std::size_t material_row(material_id id) {
        const auto [known, is_new] = material_rows_.try_emplace(id, 0);
        if (is_new) known->second = write_material(id);
        return known->second;
    }

    std::size_t write_material(material_id id) {
        static const material plain{.metallic = 0};
        const material& m = id < mesh_.materials.size() ? mesh_.materials[id] : plain;
        const auto unit = [](float value) { return std::clamp(value, 0.0f, 1.0f); };
        json pbr = json::object();
        if (m.base_color != vec4(1)) {
            pbr["baseColorFactor"] = {unit(m.base_color.r), unit(m.base_color.g),
                                      unit(m.base_color.b), unit(m.base_color.a)};
        }
        write_texture(pbr, "baseColorTexture", m.base_color_texture);
        pbr["metallicFactor"] = unit(m.metallic);
        pbr["roughnessFactor"] = unit(m.roughness);
        write_texture(pbr, "metallicRoughnessTexture", m.metallic_roughness_texture);

        json out = json::object();
        if (!m.name.empty()) out["name"] = m.name;
        out["pbrMetallicRoughness"] = std::move(pbr);
        if (write_texture(out, "normalTexture", m.normal_texture) && m.normal_scale != 1) {
            out["normalTexture"]["scale"] = m.normal_scale;
        }
        if (write_texture(out, "occlusionTexture", m.occlusion_texture) &&
            m.occlusion_strength != 1) {
            out["occlusionTexture"]["strength"] = unit(m.occlusion_strength);
        }
        if (m.emissive != vec3(0)) {
            out["emissiveFactor"] = {unit(m.emissive.r), unit(m.emissive.g), unit(m.emissive.b)};
            write_texture(out, "emissiveTexture", m.emissive_texture);
        }
        if (m.alpha == alpha_mode::mask) {
            out["alphaMode"] = "MASK";
            out["alphaCutoff"] = std::max(m.alpha_cutoff, 0.0f);
        } else if (m.alpha == alpha_mode::blend) {
            out["alphaMode"] = "BLEND";
        }
        if (m.is_double_sided) out["doubleSided"] = true;
        materials_.second.push_back(std::move(out));
        return materials_.second.size() - 1;
    }

    /// Whether there is something to write: an image, and coordinates to see it by.
    bool write_texture(json& owner, const char* key, const texture& t) {
        const auto uv_set = std::find(written_uv_sets_.begin(), written_uv_sets_.end(), t.uv_set);
        if (t.image >= mesh_.images.size() || mesh_.images[t.image].empty() ||
            uv_set == written_uv_sets_.end()) {
            return false;
        }
        const auto image = row_of(images_in_use_, t.image);
        const auto wrap = [](texture_wrap w) {
            return w == texture_wrap::repeat          ? 10497
                   : w == texture_wrap::clamp_to_edge ? 33071
                                                      : 33648;
        };
        const json sampler{{"magFilter", t.is_nearest ? 9728 : 9729},
                           {"minFilter", t.is_nearest ? 9984 : 9987},
                           {"wrapS", wrap(t.wrap_u)},
                           {"wrapT", wrap(t.wrap_v)}};
        const json entry{{"sampler", row_of(samplers_.second, sampler)}, {"source", image}};
        json info{{"index", row_of(textures_.second, entry)}};
        if (const auto id = uv_set - written_uv_sets_.begin(); id != 0) info["texCoord"] = id;
        if (t.transform != mat3(1)) {
            info["extensions"]["KHR_texture_transform"] = transform_of(t.transform);
            uses_transform_ = true;
        }
        owner[key] = std::move(info);
        return true;
    }

    /// Offset, rotation and scale that make up a transform. A shear, which glTF has no word for, is
    /// lost; no reader of ours makes one.
    [[nodiscard]] static json transform_of(const mat3& m) {
        const double angle = std::atan2(-static_cast<double>(m[0].y), static_cast<double>(m[0].x));
        const double scale_u = std::hypot(static_cast<double>(m[0].x), static_cast<double>(m[0].y));
        const double scale_v = std::sin(angle) * static_cast<double>(m[1].x) +
                               std::cos(angle) * static_cast<double>(m[1].y);
        json out = json::object();
        if (m[2].x != 0 || m[2].y != 0) out["offset"] = {m[2].x, m[2].y};
        if (angle != 0) out["rotation"] = angle;
        if (scale_u != 1 || scale_v != 1) out["scale"] = {scale_u, scale_v};
        return out;
    }

    void write_images() {
        std::vector<std::vector<std::uint8_t>> files(images_in_use_.size());
        options_.threads.for_chunks(files.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                files[i] = encode_png(mesh_.images[images_in_use_[i]]);
            }
        });
        for (const auto& file : files) {
            images_.second.push_back({{"bufferView", add_view(file)}, {"mimeType", "image/png"}});
        }
    }

    /// Row of `value`, which is added where it is new.
    template <class Rows, class Value>
    static std::size_t row_of(Rows& rows, const Value& value) {
        const auto found = std::find(rows.begin(), rows.end(), value);
        if (found != rows.end()) return static_cast<std::size_t>(found - rows.begin());
        rows.push_back(value);
        return rows.size() - 1;
    }

    // ---- container

    [[nodiscard]] std::vector<std::uint8_t> container() const {
        std::string text = root_.dump(-1, ' ', false, json::error_handler_t::replace);
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::vector<std::uint8_t> glb;
        const auto word = [&](std::uint64_t value) {
            for (int i = 0; i < 4; ++i)
                glb.push_back(static_cast<std::uint8_t>(value >> 8 * i & 0xff));
        };
        const std::size_t binary_part = binary_.empty() ? 0 : 8 + binary_.size();
        glb.reserve(12 + 8 + text.size() + binary_part);
        word(0x46546c67);  // "glTF"
        word(2);
        word(12 + 8 + text.size() + binary_part);
        word(text.size());
        word(0x4e4f534a);  // "JSON"
        glb.insert(glb.end(), text.begin(), text.end());
        if (!binary_.empty()) {
            word(binary_.size());
            word(0x004e4942);  // "BIN"
            glb.insert(glb.end(), binary_.begin(), binary_.end());
        }
        return glb;
    }

    const mesh& mesh_;
    const glb_options& options_;
    json root_ = json::object();
    json meshes_ = json::array();
    std::map<material_id, std::size_t> material_rows_{};
    section accessors_{"accessors", json::array()};
    section views_{"bufferViews", json::array()};
    section materials_{"materials", json::array()};
    section textures_{"textures", json::array()};
    section samplers_{"samplers", json::array()};
    section images_{"images", json::array()};
    std::vector<image_id> images_in_use_{};
    std::vector<std::uint32_t> written_uv_sets_{};
    bool uses_transform_ = false;
    std::vector<std::uint8_t> binary_{};
};

}  // namespace detail

/// The bytes of a .glb that holds the mesh: one node, or those that are asked for; in each one
/// primitive a material in use; images as PNG. Same mesh, same bytes, for any number of threads.
///
/// Shape   faces in their order within a material; `feature_ids` as _FEATURE_ID_0.
/// Fails   invalid_options: extras that are not JSON; too_large: beyond the 4 GiB of a GLB; and as
///         validate().
/// Cost    O(vertices + faces + pixels).
[[nodiscard]] inline expected<std::vector<std::uint8_t>> encode_glb(
    const mesh& source, const glb_options& options = {}) {
    if (!options.extras.empty() && !nlohmann::ordered_json::accept(options.extras)) {
        return error{error_code::invalid_options, "the extras of the GLB are not JSON"};
    }
    if (auto valid = validate(source, options.threads); !valid) return valid.error();
    auto bytes = detail::glb_encoder(source, options).run();
    if (bytes.size() > max_file_size) {
        return error{error_code::too_large, "the GLB would be larger than 4 GiB"};
    }
    return bytes;
}

/// Fails   as encode_glb and write_file.
[[nodiscard]] inline expected<done> write_glb(const std::filesystem::path& file, const mesh& source,
                                              const glb_options& options = {}) {
    auto bytes = encode_glb(source, options);
    if (!bytes) return detail::file_error(bytes.error().code, file, bytes.error().message);
    return write_file(file, *bytes);
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/io/gltf.hpp
// glTF 2.0 in: .gltf and .glb, the default scene flattened into one mesh.
//
// Source: glTF 2.0 Specification, Khronos Group 2021, and the extensions' own texts.

#include <cmath>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

// ---- billow/io/gltf_material.hpp
// Materials and textures of glTF, converted and decoded when a face first uses them.

#include <cmath>
#include <map>

// ---- billow/io/gltf_document.hpp
// A glTF file opened: container split, JSON checked, typed by tinygltf, buffers within reach.
//
// glTF 2.0 Specification, Khronos Group 2021, is the source of every rule in the gltf_* headers.
//
// Files are not to be trusted. tinygltf turns JSON into structs and nothing else: buffers and images
// are taken out of the JSON before it sees it, and every offset is checked here.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#ifndef TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE
#endif
#ifndef TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#endif
#include <tiny_gltf.h>


namespace billow::inline BILLOW_ABI::detail {

using bytes_view = std::span<const std::uint8_t>;

/// A buffer or image as the JSON states it; `bytes` once it has been loaded.
struct gltf_resource {
    std::string uri{};
    std::string mime_type{};
    int buffer_view = -1;           ///< of an image
    std::uint64_t byte_length = 0;  ///< of a buffer
    bool is_meshopt_fallback = false;
    bool is_loaded = false;
    std::vector<std::uint8_t> owned{};
    bytes_view bytes{};
};

/// Moving it keeps its views valid, copying it does not.
struct gltf_document {
    std::filesystem::path file{};
    std::vector<std::uint8_t> file_bytes{};
    bytes_view binary_chunk{};
    tinygltf::Model model{};
    std::vector<gltf_resource> buffers{};
    std::vector<gltf_resource> images{};
    bool has_animations = false;

    gltf_document() = default;
    gltf_document(gltf_document&&) = default;
    gltf_document& operator=(gltf_document&&) = default;

    [[nodiscard]] billow::error fail(error_code code, std::string_view fault) const {
        return file_error(code, file, fault);
    }
};

/// `items[id]`, or null where `id` is none of its rows.
template <class T>
[[nodiscard]] T* row(std::vector<T>& items, std::int64_t id) {
    return id >= 0 && static_cast<std::uint64_t>(id) < items.size()
               ? &items[static_cast<std::size_t>(id)]
               : nullptr;
}
template <class T>
[[nodiscard]] const T* row(const std::vector<T>& items, std::int64_t id) {
    return row(const_cast<std::vector<T>&>(items), id);
}

/// The bytes that base64 text stands for; nothing where it is not base64.
[[nodiscard]] inline std::optional<std::vector<std::uint8_t>> decode_base64(std::string_view text) {
    const auto value_of = [](char c) -> unsigned {
        if (c >= 'A' && c <= 'Z') return static_cast<unsigned>(c - 'A');
        if (c >= 'a' && c <= 'z') return static_cast<unsigned>(c - 'a') + 26;
        if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0') + 52;
        if (c == '+' || c == '-') return 62;
        if (c == '/' || c == '_') return 63;
        return 64;
    };
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    std::vector<std::uint8_t> bytes;
    bytes.reserve(text.size() / 4 * 3 + 3);
    unsigned bits = 0;
    int bit_count = 0;
    for (const char c : text) {
        const unsigned value = value_of(c);
        if (value > 63) return std::nullopt;
        bits = (bits << 6 | value) & 0xffffffu;
        bit_count += 6;
        if (bit_count >= 8) {
            bit_count -= 8;
            bytes.push_back(static_cast<std::uint8_t>(bits >> bit_count & 0xffu));
        }
    }
    return bytes;
}

/// `uri` with its %XX replaced by the bytes that they mean.
[[nodiscard]] inline std::string percent_decoded(std::string_view uri) {
    const auto digit = [](char c) {
        if (c >= '0' && c <= '9') return c - '0';
        if (c >= 'a' && c <= 'f') return c - 'a' + 10;
        return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    };
    std::string text;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 &&
            digit(uri[i + 2]) >= 0) {
            text += static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
            i += 2;
        } else {
            text += uri[i];
        }
    }
    return text;
}

/// Loads what the URI of a buffer or image means: a data URI or a file beside the document.
[[nodiscard]] inline expected<done> load_uri(const gltf_document& document, gltf_resource& resource,
                                             const std::string& what) {
    const std::string_view uri = resource.uri;
    if (uri.starts_with("data:")) {
        const std::size_t comma = uri.find(',');
        std::optional<std::vector<std::uint8_t>> bytes;
        if (comma != uri.npos && uri.substr(0, comma).ends_with(";base64")) {
            bytes = decode_base64(uri.substr(comma + 1));
        }
        if (!bytes) {
            return document.fail(error_code::malformed,
                                 what + " has a data URI that is not base64");
        }
        resource.owned = std::move(*bytes);
    } else {
        const std::size_t colon = uri.find(':');
        if (colon != uri.npos && colon > 1 && colon < uri.find('/')) {
            return document.fail(
                error_code::unsupported,
                what + " is at " + one_line(uri.substr(0, 60)) + "; store it beside the file");
        }
        auto path =
            file_beside(document.file.parent_path(), std::filesystem::path(percent_decoded(uri)));
        if (!path) {
            return document.fail(path.error().code, what + " " + path.error().message);
        }
        auto bytes = read_file(*path);
        if (!bytes) return document.fail(bytes.error().code, what + ": " + bytes.error().message);
        resource.owned = std::move(*bytes);
    }
    resource.bytes = resource.owned;
    return done{};
}

/// The bytes of a buffer, loaded at the first use.
[[nodiscard]] inline expected<bytes_view> buffer_bytes(gltf_document& document, int buffer_id) {
    const std::string what = "buffer " + std::to_string(buffer_id);
    gltf_resource* buffer = row(document.buffers, buffer_id);
    if (buffer == nullptr) return document.fail(error_code::out_of_range, what + " does not exist");
    if (!buffer->is_loaded) {
        if (buffer->is_meshopt_fallback) {
            return document.fail(error_code::unsupported,
                                 "is compressed with meshopt, which billow does not read; "
                                 "decompress it first: gltf-transform copy IN OUT");
        }
        if (!buffer->uri.empty()) {
            auto loaded = load_uri(document, *buffer, what);
            if (!loaded) return loaded.error();
        } else if (buffer_id == 0 && !document.binary_chunk.empty()) {
            buffer->bytes = document.binary_chunk;
        } else {
            return document.fail(error_code::malformed, what + " has neither URI nor binary chunk");
        }
        if (buffer->bytes.size() < buffer->byte_length) {
            return document.fail(error_code::truncated,
                                 what + " announces " + std::to_string(buffer->byte_length) +
                                     " bytes, but has " + std::to_string(buffer->bytes.size()));
        }
        buffer->bytes = buffer->bytes.first(static_cast<std::size_t>(buffer->byte_length));
        buffer->is_loaded = true;
    }
    return buffer->bytes;
}

/// The bytes of a buffer view.
[[nodiscard]] inline expected<bytes_view> view_bytes(gltf_document& document, int view_id) {
    const std::string what = "buffer view " + std::to_string(view_id);
    const tinygltf::BufferView* view = row(document.model.bufferViews, view_id);
    if (view == nullptr) return document.fail(error_code::out_of_range, what + " does not exist");
    auto buffer = buffer_bytes(document, view->buffer);
    if (!buffer) return buffer.error();
    if (view->byteOffset > buffer->size() || view->byteLength > buffer->size() - view->byteOffset) {
        return document.fail(error_code::out_of_range, what + " reaches beyond its buffer");
    }
    return buffer->subspan(view->byteOffset, view->byteLength);
}

}  // namespace billow::inline BILLOW_ABI::detail
// ---- billow/io/loaded_mesh.hpp
// What a reader delivers: the mesh, and what it left out on the way.

#include <algorithm>
#include <string>
#include <vector>


namespace billow::inline BILLOW_ABI {

/// Limits of a reader. A file of a few bytes may ask for billions of faces by its instances.
struct read_options {
    std::size_t max_faces = std::size_t{1} << 27;  ///< of the whole mesh, instances unfolded
};

/// A mesh as it came from a file. It passes validate().
struct loaded_mesh {
    billow::mesh mesh{};
    std::size_t primitives = 0;          ///< triangle primitives or groups of faces in the file
    std::size_t instances = 0;           ///< times that one was placed in the scene
    std::size_t skipped_primitives = 0;  ///< points and lines, or without positions
    std::vector<std::string> notes{};    ///< one line each: what was ignored or repaired

    /// Adds a note once.
    void note(std::string text) {
        if (std::find(notes.begin(), notes.end(), text) == notes.end()) {
            notes.push_back(std::move(text));
        }
    }
};

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI::detail {

/// Numbers of a JSON array or a number, `fallback` where they are missing.
template <std::size_t Count>
[[nodiscard]] std::array<double, Count> numbers_of(const tinygltf::Value& object, const char* key,
                                                   std::array<double, Count> fallback) {
    if (!object.IsObject() || !object.Has(key)) return fallback;
    const tinygltf::Value& value = object.Get(key);
    const auto finite = [](const tinygltf::Value& v, double otherwise) {
        const double number = v.IsNumber() ? v.GetNumberAsDouble() : otherwise;
        return std::isfinite(number) ? number : otherwise;
    };
    if (value.IsArray() && value.ArrayLen() == Count) {
        for (std::size_t i = 0; i < Count; ++i) {
            fallback[i] = finite(value.Get(static_cast<int>(i)), fallback[i]);
        }
    } else if (Count == 1) {
        fallback[0] = finite(value, fallback[0]);
    }
    return fallback;
}

/// The number as an id, -1 where it is none.
[[nodiscard]] inline int id_of(double number) {
    return number >= 0 && number <= 0x7fff'ffff ? static_cast<int>(number) : -1;
}

/// uv' = translation · rotation · scale · uv of KHR_texture_transform.
[[nodiscard]] inline mat3 texture_transform(const std::array<double, 2>& offset, double angle_rad,
                                            const std::array<double, 2>& scale) {
    const double c = std::cos(angle_rad);
    const double s = std::sin(angle_rad);
    const auto column = [](double x, double y, double z) {
        return vec3(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
    };
    return mat3(column(c * scale[0], -s * scale[0], 0), column(s * scale[1], c * scale[1], 0),
                column(offset[0], offset[1], 1));
}

class gltf_materials {
public:
    gltf_materials(gltf_document& document, loaded_mesh& target)
        : document_(document), target_(target) {}

    /// Row in mesh::materials of a glTF material; -1 means the default one.
    [[nodiscard]] expected<material_id> use(int gltf_id) {
        if (const auto known = rows_.find(gltf_id); known != rows_.end()) return known->second;
        material converted;
        if (gltf_id >= 0) {
            const tinygltf::Material* source = row(document_.model.materials, gltf_id);
            if (source == nullptr) {
                return document_.fail(error_code::out_of_range,
                                      "material " + std::to_string(gltf_id) + " does not exist");
            }
            auto done = convert(*source, converted);
            if (!done) return done.error();
        }
        auto& materials = target_.mesh.materials;
        materials.push_back(std::move(converted));
        return rows_[gltf_id] = static_cast<material_id>(materials.size() - 1);
    }

private:
    [[nodiscard]] expected<done> convert(const tinygltf::Material& from, material& to) {
        to.name = from.name;
        to.alpha = from.alphaMode == "MASK"    ? alpha_mode::mask
                   : from.alphaMode == "BLEND" ? alpha_mode::blend
                                               : alpha_mode::opaque;
        to.alpha_cutoff = number(from.alphaCutoff, 0.5);
        to.is_double_sided = from.doubleSided;

        const auto& pbr = from.pbrMetallicRoughness;
        to.base_color = color(pbr.baseColorFactor);
        to.metallic = unit(number(pbr.metallicFactor, 1));
        to.roughness = unit(number(pbr.roughnessFactor, 1));
        const auto strength = numbers_of<1>(
            extension(from.extensions, "KHR_materials_emissive_strength"), "emissiveStrength", {1});
        for (int i = 0; i < 3; ++i) {
            const double factor = from.emissiveFactor[static_cast<std::size_t>(i)] * strength[0];
            to.emissive[i] = unit(number(factor, 0));
            if (factor > 1) target_.note("emission above 1 is clamped");
        }
        to.normal_scale = number(from.normalTexture.scale, 1);
        to.occlusion_strength = unit(number(from.occlusionTexture.strength, 1));

        if (from.extensions.contains("KHR_materials_pbrSpecularGlossiness")) {
            return convert_specular_glossiness(from, to);
        }
        if (auto done = use_texture(pbr.baseColorTexture, to.base_color_texture); !done)
            return done;
        if (from.extensions.contains("KHR_materials_unlit")) {
            target_.note("unlit materials are taken as rough ones");
            to.metallic = 0;
            to.roughness = 1;
            to.emissive = vec3(0);
            return done{};
        }
        if (auto done = use_texture(pbr.metallicRoughnessTexture, to.metallic_roughness_texture);
            !done) {
            return done;
        }
        return convert_surface(from, to);
    }

    [[nodiscard]] expected<done> convert_surface(const tinygltf::Material& from, material& to) {
        if (auto done = use_texture(from.normalTexture, to.normal_texture); !done) return done;
        if (auto done = use_texture(from.occlusionTexture, to.occlusion_texture); !done)
            return done;
        return use_texture(from.emissiveTexture, to.emissive_texture);
    }

    /// The diffuse part stands in for the base colour; nothing is metal.
    [[nodiscard]] expected<done> convert_specular_glossiness(const tinygltf::Material& from,
                                                             material& to) {
        const auto& values = extension(from.extensions, "KHR_materials_pbrSpecularGlossiness");
        const auto diffuse = numbers_of<4>(values, "diffuseFactor", {1, 1, 1, 1});
        to.base_color = color({diffuse.begin(), diffuse.end()});
        to.metallic = 0;
        to.roughness = unit(number(1 - numbers_of<1>(values, "glossinessFactor", {1})[0], 1));
        if (values.IsObject() && values.Has("diffuseTexture")) {
            const tinygltf::Value& texture = values.Get("diffuseTexture");
            tinygltf::TextureInfo info;
            info.index = id_of(numbers_of<1>(texture, "index", {-1})[0]);
            info.texCoord = id_of(numbers_of<1>(texture, "texCoord", {0})[0]);
            if (texture.IsObject() && texture.Has("extensions") &&
                texture.Get("extensions").IsObject()) {
                info.extensions = texture.Get("extensions").Get<tinygltf::Value::Object>();
            }
            if (auto done = use_texture(info, to.base_color_texture); !done) return done;
        }
        return convert_surface(from, to);
    }

    template <class Info>
    [[nodiscard]] expected<done> use_texture(const Info& info, texture& to) {
        if (info.index < 0) return done{};
        const tinygltf::Texture* source = row(document_.model.textures, info.index);
        const std::string what = "texture " + std::to_string(info.index);
        if (source == nullptr)
            return document_.fail(error_code::out_of_range, what + " does not exist");

        int uv_set = info.texCoord;
        const auto& transform = extension(info.extensions, "KHR_texture_transform");
        if (transform.IsObject()) {
            to.transform = texture_transform(numbers_of<2>(transform, "offset", {0, 0}),
                                             numbers_of<1>(transform, "rotation", {0})[0],
                                             numbers_of<2>(transform, "scale", {1, 1}));
            uv_set = id_of(numbers_of<1>(transform, "texCoord", {static_cast<double>(uv_set)})[0]);
        }
        if (uv_set < 0 || uv_set >= static_cast<int>(uv_set_count)) {
            target_.note(what + " uses TEXCOORD_" + std::to_string(uv_set) +
                         ", of which billow reads 0 and 1: it is left out");
            return done{};
        }
        to.uv_set = static_cast<std::uint32_t>(uv_set);

        if (source->sampler >= 0) {
            const tinygltf::Sampler* sampler = row(document_.model.samplers, source->sampler);
            if (sampler == nullptr) {
                return document_.fail(error_code::out_of_range, what + " names a missing sampler");
            }
            to.wrap_u = wrap_of(sampler->wrapS);
            to.wrap_v = wrap_of(sampler->wrapT);
            to.is_nearest = sampler->magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
        }
        if (source->source < 0) {
            for (const char* name :
                 {"KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif"}) {
                if (source->extensions.contains(name)) {
                    return document_.fail(error_code::unsupported,
                                          what + " is there by " + name +
                                              " only, which billow does not read; convert its "
                                              "images to PNG or JPEG first");
                }
            }
            target_.note(what + " has no image: it is left out");
            return done{};
        }
        auto image = use_image(source->source);
        if (!image) return image.error();
        to.image = *image;
        return done{};
    }

    [[nodiscard]] expected<image_id> use_image(int gltf_id) {
        if (const auto known = images_.find(gltf_id); known != images_.end()) return known->second;
        const std::string what = "image " + std::to_string(gltf_id);
        gltf_resource* source = row(document_.images, gltf_id);
        if (source == nullptr)
            return document_.fail(error_code::out_of_range, what + " does not exist");
        if (!source->uri.empty()) {
            auto loaded = load_uri(document_, *source, what);
            if (!loaded) return loaded.error();
        } else if (source->buffer_view >= 0) {
            auto bytes = view_bytes(document_, source->buffer_view);
            if (!bytes) return bytes.error();
            source->bytes = *bytes;
        } else {
            return document_.fail(error_code::malformed, what + " has neither URI nor buffer view");
        }
        auto decoded = decode_image(source->bytes);
        source->owned = {};
        source->bytes = {};
        if (!decoded) {
            return document_.fail(decoded.error().code, what + " " + decoded.error().message);
        }
        auto& images = target_.mesh.images;
        images.push_back(std::move(*decoded));
        return images_[gltf_id] = static_cast<image_id>(images.size() - 1);
    }

    [[nodiscard]] static const tinygltf::Value& extension(const tinygltf::ExtensionMap& all,
                                                          const char* name) {
        static const tinygltf::Value none;
        const auto found = all.find(name);
        return found == all.end() ? none : found->second;
    }
    [[nodiscard]] static float number(double value, double otherwise) {
        const auto narrow = static_cast<float>(value);
        return std::isfinite(narrow) ? narrow : static_cast<float>(otherwise);
    }
    [[nodiscard]] static float unit(float value) { return std::clamp(value, 0.0f, 1.0f); }
    [[nodiscard]] static vec4 color(const std::vector<double>& factors) {
        vec4 result(1);
        for (int i = 0; i < 4 && static_cast<std::size_t>(i) < factors.size(); ++i) {
            result[i] = unit(number(factors[static_cast<std::size_t>(i)], 1));
        }
        return result;
    }
    [[nodiscard]] static texture_wrap wrap_of(int mode) {
        switch (mode) {
            case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
                return texture_wrap::clamp_to_edge;
            case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
                return texture_wrap::mirrored_repeat;
            default:
                return texture_wrap::repeat;
        }
    }

    gltf_document& document_;
    loaded_mesh& target_;
    std::map<int, material_id> rows_{};
    std::map<int, image_id> images_{};
};

}  // namespace billow::inline BILLOW_ABI::detail
// ---- billow/io/gltf_parse.hpp
// From the bytes of a .gltf or .glb to a gltf_document, without trust in any of them.

#include <array>


namespace billow::inline BILLOW_ABI::detail {

/// Splits the container into `json` and the binary chunk; a bare .gltf is all JSON.
[[nodiscard]] inline expected<bytes_view> split_glb(gltf_document& document) {
    const bytes_view bytes = document.file_bytes;
    const auto word = [&](std::size_t at) {
        return static_cast<std::uint32_t>(bytes[at]) |
               static_cast<std::uint32_t>(bytes[at + 1]) << 8 |
               static_cast<std::uint32_t>(bytes[at + 2]) << 16 |
               static_cast<std::uint32_t>(bytes[at + 3]) << 24;
    };
    constexpr std::uint32_t magic = 0x46546c67;       // "glTF"
    constexpr std::uint32_t json_chunk = 0x4e4f534a;  // "JSON"
    constexpr std::uint32_t bin_chunk = 0x004e4942;   // "BIN"
    if (bytes.size() < 4 || word(0) != magic) return bytes;

    if (bytes.size() < 12)
        return document.fail(error_code::truncated, "ends within its GLB header");
    if (word(4) != 2) {
        return document.fail(error_code::unsupported, "is GLB version " + std::to_string(word(4)) +
                                                          "; billow reads version 2");
    }
    const std::size_t length = word(8);
    if (length > bytes.size()) {
        return document.fail(error_code::truncated, "announces " + std::to_string(length) +
                                                        " bytes, but has " +
                                                        std::to_string(bytes.size()));
    }
    std::optional<bytes_view> json;
    bool has_binary = false;
    for (std::size_t at = 12; at < length;) {
        if (length - at < 8) {
            return document.fail(error_code::truncated, "ends within the header of a GLB chunk");
        }
        const std::size_t size = word(at);
        const std::uint32_t kind = word(at + 4);
        at += 8;
        if (size > length - at)
            return document.fail(error_code::truncated, "ends within a GLB chunk");
        if (!json) {
            if (kind != json_chunk) {
                return document.fail(error_code::malformed, "does not begin with a JSON chunk");
            }
            json = bytes.subspan(at, size);
        } else if (kind == bin_chunk && !has_binary) {
            document.binary_chunk = bytes.subspan(at, size);
            has_binary = true;
        }
        at += size;
    }
    if (!json) return document.fail(error_code::malformed, "has no JSON chunk");
    return *json;
}

/// Deepest nesting of brackets in JSON text. Recursion over the parsed JSON may go that deep.
[[nodiscard]] inline std::size_t nesting_of(bytes_view json) {
    std::size_t depth = 0;
    std::size_t deepest = 0;
    bool is_text = false;
    for (std::size_t i = 0; i < json.size(); ++i) {
        const char c = static_cast<char>(json[i]);
        if (is_text) {
            if (c == '\\') ++i;
            if (c == '"') is_text = false;
        } else if (c == '"') {
            is_text = true;
        } else if (c == '{' || c == '[') {
            deepest = std::max(deepest, ++depth);
        } else if ((c == '}' || c == ']') && depth > 0) {
            --depth;
        }
    }
    return deepest;
}

/// Drops what nobody reads, and writes 1.0 as 1, since ids may be spelled so and tinygltf refuses
/// them. Numbers beyond 2^53 become null, which the typed reading refuses.
inline void normalize_json(nlohmann::json& value) {
    if (value.is_object()) value.erase("extras");
    if (value.is_structured()) {
        for (auto& child : value) normalize_json(child);
    } else if (value.is_number_float()) {
        const double number = value.get<double>();
        if (number == std::trunc(number) && std::abs(number) <= 0x1p53) {
            if (number < 0) {
                value = static_cast<std::int64_t>(number);
            } else {
                value = static_cast<std::uint64_t>(number);
            }
        }
    } else if (value.is_number_integer() && std::abs(value.get<double>()) > 0x1p53) {
        value = nullptr;
    }
}

/// Takes the array `name` of buffers or images out of the JSON.
[[nodiscard]] inline expected<std::vector<gltf_resource>> take_resources(
    const gltf_document& document, nlohmann::json& root, const char* name) {
    std::vector<gltf_resource> resources;
    const auto found = root.find(name);
    if (found == root.end()) return resources;
    const auto fail = [&](const char* fault) {
        return document.fail(error_code::malformed, std::string(name) + " " + fault);
    };
    for (auto& item : *found) {
        if (!item.is_object()) return fail("holds something else than objects");
        gltf_resource resource;
        if (const auto uri = item.find("uri"); uri != item.end()) {
            if (!uri->is_string()) return fail("has a URI that is not text");
            resource.uri = std::move(uri->get_ref<std::string&>());
        }
        if (const auto mime = item.find("mimeType"); mime != item.end() && mime->is_string()) {
            resource.mime_type = mime->get<std::string>();
        }
        if (const auto view = item.find("bufferView"); view != item.end()) {
            if (!view->is_number_unsigned() || view->get<std::uint64_t>() > 0x7fff'ffff) {
                return fail("has a bufferView that is not an id");
            }
            resource.buffer_view = view->get<int>();
        }
        if (const auto length = item.find("byteLength"); length != item.end()) {
            if (!length->is_number_unsigned()) return fail("has a byteLength that is not a size");
            resource.byte_length = length->get<std::uint64_t>();
        }
        if (const auto all = item.find("extensions"); all != item.end() && all->is_object()) {
            for (const char* meshopt : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
                if (all->contains(meshopt) && resource.uri.empty()) {
                    resource.is_meshopt_fallback = true;
                }
            }
        }
        resources.push_back(std::move(resource));
    }
    root.erase(found);
    return resources;
}

/// Refuses a file that asks for what billow cannot do.
[[nodiscard]] inline expected<done> check_required_extensions(const gltf_document& document,
                                                              const nlohmann::json& names) {
    // Read, or without a say in shape and base colour.
    static constexpr std::array known{
        "EXT_mesh_features",
        "EXT_mesh_gpu_instancing",
        "EXT_structural_metadata",
        "EXT_texture_avif",
        "EXT_texture_webp",
        "KHR_animation_pointer",
        "KHR_lights_punctual",
        "KHR_materials_anisotropy",
        "KHR_materials_clearcoat",
        "KHR_materials_diffuse_transmission",
        "KHR_materials_dispersion",
        "KHR_materials_emissive_strength",
        "KHR_materials_ior",
        "KHR_materials_iridescence",
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_materials_sheen",
        "KHR_materials_specular",
        "KHR_materials_transmission",
        "KHR_materials_unlit",
        "KHR_materials_variants",
        "KHR_materials_volume",
        "KHR_mesh_quantization",
        "KHR_texture_basisu",
        "KHR_texture_transform",
        "KHR_xmp_json_ld",
    };  // an image of an unread kind is refused where a material uses it
    for (const auto& item : names) {
        if (!item.is_string()) continue;
        const auto& name = item.get_ref<const std::string&>();
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        std::string advice = "export it without";
        if (name.find("draco") != name.npos || name.find("meshopt") != name.npos) {
            advice = "decompress it first: gltf-transform copy IN OUT";
        }
        return document.fail(
            error_code::unsupported,
            "needs the extension " + one_line(name) + ", which billow does not read; " + advice);
    }
    return done{};
}

/// Opens a glTF file. Nothing but the JSON has been looked at then.
[[nodiscard]] inline expected<gltf_document> parse_gltf(const std::filesystem::path& file,
                                                        std::vector<std::uint8_t> bytes) {
    gltf_document document;
    document.file = file;
    document.file_bytes = std::move(bytes);
    const auto json = split_glb(document);
    if (!json) return json.error();

    const auto malformed = [&](std::string_view fault) {
        return document.fail(error_code::malformed, fault);
    };
    constexpr std::size_t deepest = 128;
    if (nesting_of(*json) > deepest) return malformed("has JSON nested more than 128 levels deep");
    nlohmann::json root = nlohmann::json::parse(json->begin(), json->end(), nullptr, false);
    if (root.is_discarded()) return malformed("is not valid JSON");
    if (!root.is_object()) return malformed("is JSON, but not an object");
    if (const auto asset = root.find("asset"); asset != root.end() && asset->is_object()) {
        const auto version = asset->find("version");
        if (version == asset->end() || !version->is_string()) {
            return malformed("does not state its glTF version");
        }
        const auto text = version->get<std::string>();
        if (!text.starts_with("2.") && text != "2") {
            return document.fail(error_code::unsupported,
                                 "is glTF " + one_line(text) + "; billow reads glTF 2");
        }
    } else {
        return malformed("is not glTF: it has no asset object");
    }

    for (const char* name :
         {"accessors", "animations", "bufferViews", "buffers", "cameras", "images", "materials",
          "meshes", "nodes", "samplers", "scenes", "skins", "textures", "extensionsRequired"}) {
        if (root.contains(name) && !root[name].is_array()) {
            return malformed(std::string(name) + " is not an array");
        }
    }
    if (const auto names = root.find("extensionsRequired"); names != root.end()) {
        auto checked = check_required_extensions(document, *names);
        if (!checked) return checked.error();
    }
    for (auto& accessor :
         root.contains("accessors") ? root["accessors"] : nlohmann::json::array()) {
        if (accessor.is_object()) {
            accessor.erase("min");
            accessor.erase("max");
        }
    }
    normalize_json(root);
    auto buffers = take_resources(document, root, "buffers");
    if (!buffers) return buffers.error();
    document.buffers = std::move(*buffers);
    auto images = take_resources(document, root, "images");
    if (!images) return images.error();
    document.images = std::move(*images);
    document.has_animations = root.erase("animations") + root.erase("skins") > 0;
    root.erase("cameras");
    root.erase("extensions");

    const std::string text = root.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    std::string faults;
    std::string warnings;
    tinygltf::TinyGLTF parser;
    const bool is_read = parser.LoadASCIIFromString(
        &document.model, &faults, &warnings, text.data(), static_cast<unsigned>(text.size()), {});
    if (!is_read || !faults.empty()) {
        return malformed(faults.empty() ? "breaks the rules of glTF" : faults);
    }
    return document;
}

}  // namespace billow::inline BILLOW_ABI::detail
// ---- billow/io/gltf_primitive.hpp
// A primitive of a glTF mesh as triangles of its own vertices, in the space of its node.

#include <array>
#include <map>

// ---- billow/io/gltf_accessor.hpp
// Accessors of glTF: typed, strided, normalised and sparse columns, read into plain ones.

#include <cstring>
#include <initializer_list>
#include <limits>


namespace billow::inline BILLOW_ABI::detail {

/// The values of an accessor, `width` of them an element.
template <class T>
struct gltf_column {
    std::vector<T> values{};
    std::size_t width = 1;

    [[nodiscard]] std::size_t size() const noexcept { return values.size() / width; }
    [[nodiscard]] const T* operator[](std::size_t i) const noexcept {
        return values.data() + i * width;
    }
};

/// Bytes of a component; 0 for a type that accessors cannot have.
[[nodiscard]] inline std::size_t component_size(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return 4;
        default:
            return 0;
    }
}

/// Reads one component, little endian, at `from`.
template <class T>
[[nodiscard]] T read_component(const std::uint8_t* from, int type, bool is_normalized) {
    const auto as = [&]<class Stored>(Stored) {
        Stored stored;
        std::memcpy(&stored, from, sizeof stored);
        if constexpr (std::is_floating_point_v<T> && std::is_integral_v<Stored>) {
            if (is_normalized) {
                return std::max(
                    static_cast<T>(stored) / static_cast<T>(std::numeric_limits<Stored>::max()),
                    T(-1));
            }
        }
        return static_cast<T>(stored);
    };
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return as(std::int8_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return as(std::uint8_t{});
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return as(std::int16_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return as(std::uint16_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return as(std::uint32_t{});
        default:
            if constexpr (std::is_floating_point_v<T>) return as(float{});
            return T{};  // callers refuse floats where integers are due
    }
}

/// Whether `count` elements of `size` bytes, `stride` apart from `offset` on, end within `limit`.
[[nodiscard]] constexpr bool fits(std::uint64_t offset, std::uint64_t count, std::uint64_t stride,
                                  std::uint64_t size, std::uint64_t limit) noexcept {
    if (count == 0) return true;
    if (offset > limit || size > limit - offset) return false;
    return stride == 0 || count - 1 <= (limit - offset - size) / stride;
}

/// The column of an accessor.
///
/// Shape   as many values an element as the accessor has, one of `widths`.
/// Fails   out_of_range: a missing id, or bytes beyond the view; malformed: another type than asked
///         for; and what view_bytes may fail with. Nothing large is allocated before all is checked.
template <class T>
[[nodiscard]] expected<gltf_column<T>> read_accessor(gltf_document& document, int accessor_id,
                                                     std::initializer_list<std::size_t> widths) {
    const std::string what = "accessor " + std::to_string(accessor_id);
    const auto fail = [&](error_code code, const std::string& fault) {
        return document.fail(code, what + " " + fault);
    };
    const tinygltf::Accessor* found = row(document.model.accessors, accessor_id);
    if (found == nullptr) return fail(error_code::out_of_range, "does not exist");
    const tinygltf::Accessor& accessor = *found;

    const std::size_t component = component_size(accessor.componentType);
    const bool is_float = accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT;
    if (component == 0 || (std::is_integral_v<T> && is_float)) {
        return fail(error_code::malformed, "has a component type that its use does not allow");
    }
    std::size_t width = 0;
    switch (accessor.type) {
        case TINYGLTF_TYPE_SCALAR:
            width = 1;
            break;
        case TINYGLTF_TYPE_VEC2:
            width = 2;
            break;
        case TINYGLTF_TYPE_VEC3:
            width = 3;
            break;
        case TINYGLTF_TYPE_VEC4:
            width = 4;
            break;
        default:
            break;
    }
    if (std::find(widths.begin(), widths.end(), width) == widths.end()) {
        return fail(error_code::malformed, "has a type that its use does not allow");
    }

    const std::size_t element = component * width;
    const std::size_t count = accessor.count;
    gltf_column<T> column{{}, width};
    const auto read_element = [&](std::size_t i, const std::uint8_t* from) {
        for (std::size_t c = 0; c < width; ++c) {
            column.values[i * width + c] = read_component<T>(
                from + c * component, accessor.componentType, accessor.normalized);
        }
    };

    if (accessor.bufferView >= 0) {
        auto bytes = view_bytes(document, accessor.bufferView);
        if (!bytes) return bytes.error();
        const auto& view =
            document.model.bufferViews[static_cast<std::size_t>(accessor.bufferView)];
        const std::size_t stride = view.byteStride == 0 ? element : view.byteStride;
        if (!fits(accessor.byteOffset, count, stride, element, bytes->size())) {
            return fail(error_code::out_of_range, "of " + std::to_string(count) +
                                                      " elements reaches beyond buffer view " +
                                                      std::to_string(accessor.bufferView));
        }
        column.values.resize(count * width);
        for (std::size_t i = 0; i < count; ++i) {
            read_element(i, bytes->data() + accessor.byteOffset + i * stride);
        }
    } else {
        constexpr std::size_t most_zeros = std::size_t{1} << 24;  // no byte of the file backs them
        if (count > most_zeros) {
            return fail(error_code::too_large,
                        "of " + std::to_string(count) + " elements has no buffer view");
        }
        column.values.resize(count * width);
    }

    if (accessor.sparse.isSparse) {
        const auto& sparse = accessor.sparse;
        const std::size_t index_size = component_size(sparse.indices.componentType);
        if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0 ||
            index_size == 0 || sparse.indices.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) {
            return fail(error_code::malformed, "has a sparse part of negative size or wrong type");
        }
        auto indices = view_bytes(document, sparse.indices.bufferView);
        if (!indices) return indices.error();
        auto values = view_bytes(document, sparse.values.bufferView);
        if (!values) return values.error();
        const auto sparse_count = static_cast<std::size_t>(sparse.count);
        const auto index_offset = static_cast<std::size_t>(sparse.indices.byteOffset);
        const auto value_offset = static_cast<std::size_t>(sparse.values.byteOffset);
        if (!fits(index_offset, sparse_count, index_size, index_size, indices->size()) ||
            !fits(value_offset, sparse_count, element, element, values->size())) {
            return fail(error_code::out_of_range, "has a sparse part beyond its buffer view");
        }
        for (std::size_t i = 0; i < sparse_count; ++i) {
            const auto target =
                read_component<std::uint32_t>(indices->data() + index_offset + i * index_size,
                                              sparse.indices.componentType, false);
            if (target >= count) {
                return fail(error_code::out_of_range, "has a sparse index beyond its last element");
            }
            read_element(target, values->data() + value_offset + i * element);
        }
    }
    return column;
}

}  // namespace billow::inline BILLOW_ABI::detail

namespace billow::inline BILLOW_ABI::detail {

/// Columns hold one row a vertex, or none.
struct gltf_primitive {
    int material = -1;
    std::vector<vec3> positions{};
    std::vector<vec3> normals{};
    std::vector<vec4> tangents{};
    std::array<std::vector<vec2>, uv_set_count> uv_sets{};
    std::vector<vec4> colors{};
    std::vector<std::uint32_t> feature_ids{};
    std::vector<uvec3> triangles{};

    /// Gives every face its own corners and its own normal, as glTF asks for where normals lack.
    void make_flat() {
        const auto unfold = [&](auto& column) {
            if (column.empty()) return;
            std::remove_reference_t<decltype(column)> unfolded;
            unfolded.reserve(triangles.size() * 3);
            for (const uvec3& t : triangles) {
                for (int c = 0; c < 3; ++c) unfolded.push_back(column[t[c]]);
            }
            column = std::move(unfolded);
        };
        unfold(positions);
        unfold(tangents);
        for (auto& uv_set : uv_sets) unfold(uv_set);
        unfold(colors);
        unfold(feature_ids);
        normals.resize(positions.size());
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            const auto first = static_cast<std::uint32_t>(i * 3);
            triangles[i] = uvec3(first, first + 1, first + 2);
            const dvec3 a(positions[first]);
            const dvec3 b(positions[first + 1]);
            const dvec3 c(positions[first + 2]);
            const dvec3 across = glm::cross(b - a, c - a);
            const double length = glm::length(across);
            const vec3 normal(length > 0 ? across / length : dvec3(0, 0, 1));
            std::fill_n(normals.begin() + static_cast<std::ptrdiff_t>(first), 3, normal);
        }
    }
};

/// Number of triangles that `count` indices make in a mode of glTF; 0 for points and lines.
[[nodiscard]] inline std::size_t triangle_count(int mode, std::size_t count) {
    if (mode == TINYGLTF_MODE_TRIANGLES) return count / 3;
    return mode >= TINYGLTF_MODE_TRIANGLE_STRIP && count >= 3 ? count - 2 : 0;
}

/// Positions in the index column of the i-th triangle's corners, all front sides alike.
[[nodiscard]] inline std::array<std::size_t, 3> corners_of(int mode, std::size_t i) {
    switch (mode) {
        case TINYGLTF_MODE_TRIANGLE_STRIP:
            return {i, i + 1 + i % 2, i + 2 - i % 2};
        case TINYGLTF_MODE_TRIANGLE_FAN:
            return {i + 1, i + 2, 0};
        default:
            return {3 * i, 3 * i + 1, 3 * i + 2};
    }
}

/// Reads primitives. Decoded accessors are kept, since primitives like to share them.
class gltf_primitive_reader {
public:
    gltf_primitive_reader(gltf_document& document, loaded_mesh& target)
        : document_(document), target_(target) {}

    /// Needs   a primitive of triangles with positions.
    [[nodiscard]] expected<gltf_primitive> read(const tinygltf::Primitive& from) {
        const auto attribute = [&](const char* name) {
            const auto found = from.attributes.find(name);
            return found == from.attributes.end() ? -1 : found->second;
        };
        auto positions = column(attribute("POSITION"), {3});
        if (!positions) return positions.error();
        const std::size_t vertex_count = (*positions)->size();
        if (vertex_count >= no_id) {
            return document_.fail(error_code::too_large, "has a primitive of 2^32 vertices");
        }

        gltf_primitive to;
        to.material = from.material;
        auto used = read_triangles(from, vertex_count, to);
        if (!used) return used.error();
        const std::vector<std::uint32_t>& vertices = *used;

        // Copies the rows of the vertices in use.
        const auto fill = [&](const char* name, std::initializer_list<std::size_t> widths,
                              auto& column_to, const auto& convert) -> expected<done> {
            const int id = attribute(name);
            if (id < 0) return done{};
            auto values = column(id, widths);
            if (!values) return values.error();
            if ((*values)->size() != vertex_count) {
                return document_.fail(error_code::malformed,
                                      std::string("has a primitive of ") +
                                          std::to_string(vertex_count) + " positions, but " +
                                          std::to_string((*values)->size()) + " of " + name);
            }
            column_to.reserve(vertices.size());
            for (const std::uint32_t v : vertices) {
                column_to.push_back(convert((**values)[v], (*values)->width));
            }
            return done{};
        };
        const auto as_vec2 = [&](const float* v, std::size_t) {
            if (std::isfinite(v[0]) && std::isfinite(v[1])) return vec2(v[0], v[1]);
            target_.note("texture coordinates that are not finite are set to 0");
            return vec2(0);
        };
        const auto as_vec3 = [](const float* v, std::size_t) { return vec3(v[0], v[1], v[2]); };
        const auto as_vec4 = [](const float* v, std::size_t) {
            return vec4(v[0], v[1], v[2], v[3]);
        };
        const auto as_color = [](const float* v, std::size_t width) {
            vec4 color(1);
            for (std::size_t c = 0; c < width; ++c) {
                if (std::isfinite(v[c])) color[static_cast<int>(c)] = std::clamp(v[c], 0.0f, 1.0f);
            }
            return color;
        };
        const auto as_id = [](const float* v, std::size_t) {
            const double id = std::round(static_cast<double>(*v));
            return id >= 0 && id < no_id ? static_cast<std::uint32_t>(id) : no_id;
        };
        for (const auto& filled :
             {fill("POSITION", {3}, to.positions, as_vec3),
              fill("NORMAL", {3}, to.normals, as_vec3), fill("TANGENT", {4}, to.tangents, as_vec4),
              fill("TEXCOORD_0", {2}, to.uv_sets[0], as_vec2),
              fill("TEXCOORD_1", {2}, to.uv_sets[1], as_vec2),
              fill("COLOR_0", {3, 4}, to.colors, as_color),
              fill("_FEATURE_ID_0", {1}, to.feature_ids, as_id)}) {
            if (!filled) return filled.error();
        }
        return to;
    }

private:
    /// Fills the triangles of `to` with ids among the vertices in use, and gives these, in the order of use.
    [[nodiscard]] expected<std::vector<std::uint32_t>> read_triangles(
        const tinygltf::Primitive& from, std::size_t vertex_count, gltf_primitive& to) {
        std::vector<std::uint32_t> indices;
        std::uint32_t restart = no_id;
        if (from.indices >= 0) {
            auto read = read_accessor<std::uint32_t>(document_, from.indices, {1});
            if (!read) return read.error();
            indices = std::move(read->values);
            const auto& accessor =
                document_.model.accessors[static_cast<std::size_t>(from.indices)];
            restart >>= 32 - 8 * component_size(accessor.componentType);
        } else {
            indices.resize(vertex_count);
            for (std::size_t i = 0; i < vertex_count; ++i)
                indices[i] = static_cast<std::uint32_t>(i);
        }
        const std::size_t count = triangle_count(from.mode, indices.size());
        to.triangles.reserve(count);
        std::vector<std::uint32_t> used;
        if (new_ids_.size() < vertex_count) new_ids_.resize(vertex_count, no_id);
        for (std::size_t i = 0; i < count; ++i) {
            uvec3 triangle;
            int c = 0;
            for (const std::size_t corner : corners_of(from.mode, i)) {
                const std::uint32_t index = indices[corner];
                if (index == restart) {
                    return document_.fail(
                        error_code::malformed,
                        "has primitive restart in its indices, which glTF forbids");
                }
                if (index >= vertex_count) {
                    return document_.fail(error_code::out_of_range,
                                          "has index " + std::to_string(index) +
                                              " in a primitive of " + std::to_string(vertex_count) +
                                              " vertices");
                }
                std::uint32_t& new_id = new_ids_[index];
                if (new_id == no_id) {
                    new_id = static_cast<std::uint32_t>(used.size());
                    used.push_back(index);
                }
                triangle[c++] = new_id;
            }
            to.triangles.push_back(triangle);
        }
        for (const std::uint32_t v : used) new_ids_[v] = no_id;
        return used;
    }

    [[nodiscard]] expected<const gltf_column<float>*> column(
        int accessor_id, std::initializer_list<std::size_t> widths) {
        const auto known = columns_.find(accessor_id);
        if (known != columns_.end() &&
            std::find(widths.begin(), widths.end(), known->second.width) != widths.end()) {
            return &known->second;
        }
        auto read = read_accessor<float>(document_, accessor_id, widths);
        if (!read) return read.error();
        return &columns_.insert_or_assign(accessor_id, std::move(*read)).first->second;
    }

    gltf_document& document_;
    loaded_mesh& target_;
    std::map<int, gltf_column<float>> columns_{};
    std::vector<std::uint32_t> new_ids_{};  // all no_id between two primitives
};

}  // namespace billow::inline BILLOW_ABI::detail
// ---- billow/io/gltf_scene.hpp
// Which mesh stands where: the node graph of a glTF file unfolded.

#include <array>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>


namespace billow::inline BILLOW_ABI::detail {

/// A mesh of the file at a place in the scene.
struct gltf_draw {
    int mesh = -1;
    glm::dmat4 to_scene{1};
};

[[nodiscard]] inline glm::dmat4 placement(const glm::dvec3& translation, const glm::dquat& rotation,
                                          const glm::dvec3& scale) {
    glm::dmat4 matrix = glm::mat4_cast(rotation);
    for (int i = 0; i < 3; ++i) matrix[i] *= scale[i];
    matrix[3] = glm::dvec4(translation, 1);
    return matrix;
}

/// The transform of a node to its parent; the identity for parts of the wrong length.
[[nodiscard]] inline glm::dmat4 local_matrix(const tinygltf::Node& node) {
    if (node.matrix.size() == 16) {
        glm::dmat4 matrix;
        for (int i = 0; i < 16; ++i)
            matrix[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
        return matrix;
    }
    const auto& t = node.translation;
    const auto& r = node.rotation;
    const auto& s = node.scale;
    return placement(t.size() == 3 ? glm::dvec3(t[0], t[1], t[2]) : glm::dvec3(0),
                     r.size() == 4 ? glm::dquat(r[3], r[0], r[1], r[2]) : glm::dquat(1, 0, 0, 0),
                     s.size() == 3 ? glm::dvec3(s[0], s[1], s[2]) : glm::dvec3(1));
}

/// Places of EXT_mesh_gpu_instancing, relative to the node.
[[nodiscard]] inline expected<std::vector<glm::dmat4>> instance_matrices(
    gltf_document& document, const tinygltf::Value& extension) {
    std::array<gltf_column<float>, 3> columns;  // translation, rotation, scale
    std::size_t count = 0;
    bool has_any = false;
    if (extension.IsObject() && extension.Has("attributes")) {
        const tinygltf::Value& attributes = extension.Get("attributes");
        static constexpr std::array names{"TRANSLATION", "ROTATION", "SCALE"};
        for (std::size_t i = 0; i < names.size(); ++i) {
            if (!attributes.IsObject() || !attributes.Has(names[i])) continue;
            const tinygltf::Value& id = attributes.Get(names[i]);
            auto column = read_accessor<float>(document, id.IsInt() ? id.GetNumberAsInt() : -1,
                                               {i == 1 ? std::size_t{4} : std::size_t{3}});
            if (!column) return column.error();
            if (has_any && column->size() != count) {
                return document.fail(error_code::malformed,
                                     "has instances whose columns differ in length");
            }
            count = column->size();
            has_any = true;
            columns[i] = std::move(*column);
        }
    }
    if (!has_any) return std::vector<glm::dmat4>{glm::dmat4(1)};
    std::vector<glm::dmat4> matrices;
    matrices.reserve(count);
    const auto& [translations, rotations, scales] = columns;
    for (std::size_t i = 0; i < count; ++i) {
        const auto point = [i](const gltf_column<float>& column, double otherwise) {
            if (column.values.empty()) return glm::dvec3(otherwise);
            return glm::dvec3(column[i][0], column[i][1], column[i][2]);
        };
        glm::dquat rotation(1, 0, 0, 0);
        if (!rotations.values.empty()) {
            const float* r = rotations[i];
            rotation = glm::normalize(glm::dquat(r[3], r[0], r[1], r[2]));
        }
        matrices.push_back(placement(point(translations, 0), rotation, point(scales, 1)));
    }
    return matrices;
}

/// The nodes that the unfolding starts from: of the default scene, else of the first, else all that
/// are nobody's children.
[[nodiscard]] inline expected<std::vector<int>> root_nodes(const gltf_document& document) {
    const auto& model = document.model;
    if (!model.scenes.empty() || model.defaultScene >= 0) {
        const auto* scene = row(model.scenes, std::max(model.defaultScene, 0));
        if (scene == nullptr) {
            return document.fail(error_code::out_of_range, "its default scene does not exist");
        }
        return scene->nodes;
    }
    std::vector<bool> is_child(model.nodes.size(), false);
    for (const auto& node : model.nodes) {
        for (const int child : node.children) {
            if (row(model.nodes, child) != nullptr)
                is_child[static_cast<std::size_t>(child)] = true;
        }
    }
    std::vector<int> roots;
    for (std::size_t i = 0; i < is_child.size(); ++i) {
        if (!is_child[i]) roots.push_back(static_cast<int>(i));
    }
    if (roots.empty() && !model.nodes.empty()) {
        return document.fail(error_code::malformed, "its nodes form a circle");
    }
    return roots;
}

/// Every mesh of the scene at its place, in the order of the file. A file of meshes without nodes
/// shows each of them once.
///
/// Fails   out_of_range: a missing scene, node or mesh; malformed: a node that is reached twice, as
///         in a circle; too_large: more than `max_draws`.
[[nodiscard]] inline expected<std::vector<gltf_draw>> unfold_scene(gltf_document& document,
                                                                   std::size_t max_draws) {
    const auto& model = document.model;
    std::vector<gltf_draw> draws;
    if (model.nodes.empty() && model.scenes.empty()) {
        for (std::size_t i = 0; i < model.meshes.size(); ++i) {
            draws.push_back({static_cast<int>(i), glm::dmat4(1)});
        }
        return draws;
    }
    auto roots = root_nodes(document);
    if (!roots) return roots.error();

    struct visit {
        int node;
        glm::dmat4 to_scene;  // of the parent
    };
    std::vector<visit> pending;
    const auto push = [&](const std::vector<int>& nodes, const glm::dmat4& to_scene) {
        for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
            pending.push_back({*node, to_scene});
        }
    };
    push(*roots, glm::dmat4(1));
    std::vector<bool> is_visited(model.nodes.size(), false);
    while (!pending.empty()) {
        const visit next = pending.back();
        pending.pop_back();
        const std::string what = "node " + std::to_string(next.node);
        const tinygltf::Node* node = row(model.nodes, next.node);
        if (node == nullptr)
            return document.fail(error_code::out_of_range, what + " does not exist");
        if (is_visited[static_cast<std::size_t>(next.node)]) {
            return document.fail(error_code::malformed,
                                 what + " is reached twice: the nodes are not a tree");
        }
        is_visited[static_cast<std::size_t>(next.node)] = true;

        const glm::dmat4 to_scene = next.to_scene * local_matrix(*node);
        if (node->mesh >= 0) {
            if (row(model.meshes, node->mesh) == nullptr) {
                return document.fail(error_code::out_of_range, what + " names a missing mesh");
            }
            const auto instancing = node->extensions.find("EXT_mesh_gpu_instancing");
            if (instancing == node->extensions.end()) {
                draws.push_back({node->mesh, to_scene});
            } else {
                auto places = instance_matrices(document, instancing->second);
                if (!places) return places.error();
                for (const auto& place : *places) draws.push_back({node->mesh, to_scene * place});
            }
            if (draws.size() > max_draws) {
                return document.fail(
                    error_code::too_large,
                    "places its meshes more than " + std::to_string(max_draws) + " times");
            }
        }
        push(node->children, to_scene);
    }
    return draws;
}

}  // namespace billow::inline BILLOW_ABI::detail

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Normal matrix of a transform: cofactors, which unlike the inverse exist for flat scales too.
[[nodiscard]] inline glm::dmat3 normal_matrix(const glm::dmat3& m) {
    return glm::dmat3(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
}

/// `v` at unit length; zero where it has none.
[[nodiscard]] inline vec3 unit_or_zero(const dvec3& v) {
    const double length = glm::length(v);
    return std::isfinite(length) && length > 0 ? vec3(v / length) : vec3(0);
}

/// Replaces normals without direction by those of the faces around. Gives how many there were.
inline std::size_t repair_normals(mesh& m) {
    const auto is_bad = [&](std::uint32_t v) { return m.normals[v] == vec3(0); };
    const auto count =
        static_cast<std::size_t>(std::count(m.normals.begin(), m.normals.end(), vec3(0)));
    if (count == 0) return 0;
    std::vector<dvec3> sums(m.vertex_count(), dvec3(0));
    for (std::size_t face = 0; face < m.face_count(); ++face) {
        const auto [a, b, c] = m.corners(static_cast<face_id>(face));
        const dvec3 across = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
        for (int i = 0; i < 3; ++i) sums[m.triangles[face][i]] += across;
    }
    for (std::uint32_t v = 0; v < sums.size(); ++v) {
        if (!is_bad(v)) continue;
        const vec3 normal = unit_or_zero(sums[v]);
        m.normals[v] = normal == vec3(0) ? vec3(0, 0, 1) : normal;
    }
    return count;
}

/// Reads the default scene in the order: where meshes stand, what is in them, all together.
class gltf_flattener {
public:
    gltf_flattener(gltf_document& document, const read_options& options)
        : document_(document), options_(options) {}

    [[nodiscard]] expected<loaded_mesh> run() {
        auto draws = unfold_scene(document_, options_.max_faces);
        if (!draws) return draws.error();
        if (document_.has_animations) target_.note("animation and skin are left out: bind pose");
        if (auto done = check_size(*draws); !done) return done.error();
        if (auto done = read_primitives(*draws); !done) return done.error();
        choose_columns();
        for (const gltf_draw& draw : *draws) {
            for (const std::size_t id : primitives_of_mesh_[draw.mesh]) {
                append(primitives_[id], materials_of_primitive_[id], draw.to_scene);
                ++target_.instances;
            }
        }
        if (auto valid = validate(target_.mesh); !valid) {
            return document_.fail(valid.error().code, valid.error().message);
        }
        if (repair_normals(target_.mesh) > 0) target_.note("normals of no direction are replaced");
        drop_textures_without_uv();
        return std::move(target_);
    }

private:
    [[nodiscard]] static bool is_read(const tinygltf::Primitive& primitive) {
        return primitive.mode >= TINYGLTF_MODE_TRIANGLES &&
               primitive.attributes.contains("POSITION");
    }

    /// Refuses what would unfold to more faces than wanted, before anything is decoded.
    [[nodiscard]] expected<done> check_size(const std::vector<gltf_draw>& draws) {
        std::uint64_t faces = 0;
        for (const gltf_draw& draw : draws) {
            const auto& mesh = document_.model.meshes[static_cast<std::size_t>(draw.mesh)];
            for (const auto& primitive : mesh.primitives) {
                if (!is_read(primitive)) continue;
                const int counted = primitive.indices >= 0 ? primitive.indices
                                                           : primitive.attributes.at("POSITION");
                const auto* accessor = row(document_.model.accessors, counted);
                // The count is a claim so far, so it may be beyond everything.
                const std::size_t most = options_.max_faces + 1;
                if (accessor != nullptr) {
                    faces += std::min(most, triangle_count(primitive.mode, accessor->count));
                }
                if (faces > options_.max_faces) {
                    return document_.fail(
                        error_code::too_large,
                        "claims more than " + std::to_string(options_.max_faces) + " faces");
                }
            }
        }
        return done{};
    }

    [[nodiscard]] expected<done> read_primitives(const std::vector<gltf_draw>& draws) {
        gltf_primitive_reader reader(document_, target_);
        gltf_materials materials(document_, target_);
        for (const gltf_draw& draw : draws) {
            const auto [entry, is_new] = primitives_of_mesh_.try_emplace(draw.mesh);
            if (!is_new) continue;
            const auto& mesh = document_.model.meshes[static_cast<std::size_t>(draw.mesh)];
            for (const auto& source : mesh.primitives) {
                if (source.mode < 0 || source.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
                    return document_.fail(error_code::malformed, "has a primitive of unknown mode");
                }
                if (!source.targets.empty()) target_.note("morph targets are left out: base shape");
                if (!is_read(source)) {
                    ++target_.skipped_primitives;
                    continue;
                }
                if (needs_draco(source)) {
                    return document_.fail(error_code::unsupported,
                                          "is compressed with Draco, which billow does not read; "
                                          "decompress it first: gltf-transform copy IN OUT");
                }
                auto primitive = reader.read(source);
                if (!primitive) return primitive.error();
                auto material = materials.use(source.material);
                if (!material) return material.error();
                entry->second.push_back(primitives_.size());
                primitives_.push_back(std::move(*primitive));
                materials_of_primitive_.push_back(*material);
            }
        }
        target_.primitives = primitives_.size();
        return done{};
    }

    /// Whether the uncompressed form that the extension allows beside it is missing.
    [[nodiscard]] bool needs_draco(const tinygltf::Primitive& primitive) const {
        if (!primitive.extensions.contains("KHR_draco_mesh_compression")) return false;
        const auto* positions = row(document_.model.accessors, primitive.attributes.at("POSITION"));
        return positions != nullptr && positions->bufferView < 0;
    }

    /// A column is there when one primitive has it, and the others are given the plainest values.
    void choose_columns() {
        bool can_keep_tangents = true;
        has_features_ = !primitives_.empty();
        for (std::size_t i = 0; i < primitives_.size(); ++i) {
            const gltf_primitive& p = primitives_[i];
            const material& m = target_.mesh.materials[materials_of_primitive_[i]];
            has_normals_ |= !p.normals.empty();
            has_tangents_ |= !p.tangents.empty();
            can_keep_tangents &= !p.tangents.empty() || !m.normal_texture.is_present();
            for (std::size_t s = 0; s < uv_set_count; ++s) has_uvs_[s] |= !p.uv_sets[s].empty();
            has_colors_ |= !p.colors.empty();
            has_features_ &= !p.feature_ids.empty() || p.positions.empty();
        }
        if (has_tangents_ && !(can_keep_tangents && has_normals_)) {
            has_tangents_ = false;
            target_.note("tangents are left out: not every primitive that needs them has some");
        }
        if (!has_normals_) return;
        for (gltf_primitive& p : primitives_) {
            if (p.normals.empty()) p.make_flat();
        }
    }

    void append(const gltf_primitive& from, material_id material, const glm::dmat4& to_scene) {
        mesh& to = target_.mesh;
        const glm::dmat3 linear(to_scene);
        const bool is_mirrored = glm::determinant(linear) < 0;
        const glm::dmat3 for_normals = is_mirrored ? -normal_matrix(linear) : normal_matrix(linear);
        const auto first = static_cast<std::uint32_t>(to.positions.size());
        const std::size_t count = from.positions.size();

        for (const vec3& p : from.positions) {
            to.positions.emplace_back(glm::dvec3(to_scene * glm::dvec4(dvec3(p), 1)));
        }
        if (has_normals_) {
            for (const vec3& n : from.normals) {
                to.normals.push_back(unit_or_zero(for_normals * dvec3(n)));
            }
        }
        if (has_tangents_) append_tangents(from, linear, is_mirrored);
        for (std::size_t s = 0; s < uv_set_count; ++s) {
            append_column(to.uv_sets[s], from.uv_sets[s], has_uvs_[s], count, vec2(0));
        }
        append_column(to.colors, from.colors, has_colors_, count, vec4(1));
        append_column(to.feature_ids, from.feature_ids, has_features_, count, 0u);
        for (uvec3 t : from.triangles) {
            if (is_mirrored) std::swap(t.y, t.z);
            to.triangles.push_back(t + first);
        }
        to.face_materials.resize(to.triangles.size(), material);
    }

    void append_tangents(const gltf_primitive& from, const glm::dmat3& linear, bool is_mirrored) {
        const std::size_t first = target_.mesh.tangents.size();
        for (std::size_t i = 0; i < from.positions.size(); ++i) {
            const vec4 given = from.tangents.empty() ? vec4(0, 0, 0, 1) : from.tangents[i];
            vec3 direction = unit_or_zero(linear * dvec3(given));
            if (direction == vec3(0)) {  // any direction along the surface
                const vec3 n = target_.mesh.normals[first + i];
                direction = unit_or_zero(
                    glm::cross(dvec3(n), std::abs(n.x) < 0.9f ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
                if (direction == vec3(0)) direction = vec3(1, 0, 0);
            }
            // The mirrored frame is left-handed, so the bitangent's side changes too.
            const bool is_negative = (given.w < 0) != is_mirrored;
            target_.mesh.tangents.emplace_back(direction, is_negative ? -1.0f : 1.0f);
        }
    }

    template <class T>
    static void append_column(std::vector<T>& to, const std::vector<T>& from, bool is_wanted,
                              std::size_t count, const T& plain) {
        if (!is_wanted) return;
        if (from.empty()) {
            to.resize(to.size() + count, plain);
        } else {
            to.insert(to.end(), from.begin(), from.end());
        }
    }

    void drop_textures_without_uv() {
        for (material& m : target_.mesh.materials) {
            for (texture* t : {&m.base_color_texture, &m.metallic_roughness_texture,
                               &m.normal_texture, &m.occlusion_texture, &m.emissive_texture}) {
                if (!t->is_present() || !target_.mesh.uv_sets[t->uv_set].empty()) continue;
                *t = {};
                target_.note("textures without texture coordinates are left out");
            }
        }
    }

    gltf_document& document_;
    const read_options& options_;
    loaded_mesh target_{};
    std::vector<gltf_primitive> primitives_{};
    std::vector<material_id> materials_of_primitive_{};
    std::map<int, std::vector<std::size_t>> primitives_of_mesh_{};
    bool has_normals_ = false;
    bool has_tangents_ = false;
    std::array<bool, uv_set_count> has_uvs_{};
    bool has_colors_ = false;
    bool has_features_ = false;
};

/// The mesh in the bytes of a glTF file; `file` names it and says where its other files lie.
[[nodiscard]] inline expected<loaded_mesh> read_gltf_bytes(const std::filesystem::path& file,
                                                           std::vector<std::uint8_t> bytes,
                                                           const read_options& options) {
    auto document = parse_gltf(file, std::move(bytes));
    if (!document) return document.error();
    return gltf_flattener(*document, options).run();
}

}  // namespace detail

/// Reads the default scene of a .gltf or .glb file into one mesh in scene space.
///
/// Gives   the mesh, valid, with what was left out. Points and lines are skipped and counted, skins
///         keep their bind pose, morph targets their base shape.
/// Fails   with one line that names file and fault. unsupported says what to do.
/// Cost    O(bytes + faces of all instances).
[[nodiscard]] inline expected<loaded_mesh> read_gltf(const std::filesystem::path& file,
                                                     const read_options& options = {}) {
    auto bytes = read_file(file);
    if (!bytes) return bytes.error();
    return detail::read_gltf_bytes(file, std::move(*bytes), options);
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/io/mesh_file.hpp
// Any mesh file: the reader is chosen by what is in the file, then by its name.

// ---- billow/io/obj.hpp
// Wavefront OBJ in, with MTL, through tinyobjloader.

#include <istream>
#include <streambuf>
#include <unordered_map>

#include <tiny_obj_loader.h>

// ---- billow/io/obj_material.hpp
// MTL materials in the terms of metallic-roughness.
//
// MTL has no fixed colour space; its numbers are taken as sRGB, as the screens of its time showed
// them, and its textures as sRGB.

#include <algorithm>
#include <map>
#include <optional>

#include <tiny_obj_loader.h>


namespace billow::inline BILLOW_ABI::detail {

/// `color` as RGBA, its alpha taken from `opacity` (its alpha, else its first channel) by nearest
/// texel. The result is as large as the larger of the two.
[[nodiscard]] inline image with_opacity(const image& color, const image& opacity) {
    image out = image::filled(std::max(color.width, opacity.width),
                              std::max(color.height, opacity.height), 4, 255);
    const bool has_alpha = opacity.channels == 2 || opacity.channels == 4;
    for (int y = 0; y < out.height; ++y) {
        for (int x = 0; x < out.width; ++x) {
            const auto nearest = [&](const image& from) {
                const auto scaled = [](int i, int to_size, int from_size) {
                    return static_cast<int>(static_cast<std::int64_t>(i) * from_size / to_size);
                };
                return from.pixel(scaled(x, out.width, from.width),
                                  scaled(y, out.height, from.height));
            };
            const std::uint8_t* c = nearest(color);
            std::uint8_t* to = out.pixel(x, y);
            for (int i = 0; i < 3; ++i) to[i] = c[color.channels >= 3 ? i : 0];
            to[3] = nearest(opacity)[has_alpha ? opacity.channels - 1 : 0];
        }
    }
    return out;
}

class obj_materials {
public:
    obj_materials(std::filesystem::path folder, loaded_mesh& target)
        : folder_(std::move(folder)), target_(target) {}

    void add(const tinyobj::material_t& from) {
        material to;
        to.name = from.name;
        const bool has_map = !from.diffuse_texname.empty();
        // Where Kd lacks, tinyobjloader puts 0.6, or 0 after a material that had one.
        const vec3 kd(from.diffuse[0], from.diffuse[1], from.diffuse[2]);
        const bool lacks_kd = has_map && (kd == vec3(0.6f) || kd == vec3(0));
        for (int i = 0; i < 3; ++i) {
            to.base_color[i] = lacks_kd ? 1.0f : linear(kd[i]);
            to.emissive[i] = linear(from.emission[i]);
        }
        to.base_color.a = std::clamp(from.dissolve, 0.0f, 1.0f);
        if (to.base_color.a < 1) to.alpha = alpha_mode::blend;
        to.metallic = std::clamp(from.metallic, 0.0f, 1.0f);
        to.roughness = from.roughness > 0 ? std::min(from.roughness, 1.0f) : 1.0f;

        add_base_color(from, to);
        if (const auto id = load(from.normal_texname)) {
            to.normal_texture = textured(*id, from.normal_texopt);
        }
        if (const auto id = load(from.emissive_texname)) {
            to.emissive_texture = textured(*id, from.emissive_texopt);
            if (to.emissive == vec3(0)) to.emissive = vec3(1);
        }
        if (!from.bump_texname.empty() && from.normal_texname.empty()) {
            target_.note("material " + one_line(from.name) +
                         ": map_Bump is a height map and left out; name normal maps norm");
        }
        if (!from.roughness_texname.empty() || !from.metallic_texname.empty()) {
            target_.note("material " + one_line(from.name) + ": map_Pr and map_Pm are left out");
        }
        target_.mesh.materials.push_back(std::move(to));
    }

private:
    void add_base_color(const tinyobj::material_t& from, material& to) {
        const auto color = load(from.diffuse_texname);
        const auto opacity = load(from.alpha_texname);
        auto& images = target_.mesh.images;
        if (opacity) {
            const auto key = std::pair(color.value_or(no_id), *opacity);
            auto [joined, is_new] = joined_.try_emplace(key, static_cast<image_id>(images.size()));
            if (is_new) {
                const image white = image::filled(1, 1, 3, 255);
                images.push_back(with_opacity(color ? images[*color] : white, images[*opacity]));
            }
            to.base_color_texture =
                textured(joined->second, color ? from.diffuse_texopt : from.alpha_texopt);
            to.alpha = alpha_mode::mask;
        } else if (color) {
            to.base_color_texture = textured(*color, from.diffuse_texopt);
            if (images[*color].channels == 2 || images[*color].channels == 4) {
                to.alpha = alpha_mode::mask;
            }
        }
    }

    /// An image beside the OBJ; a note where it cannot be read.
    [[nodiscard]] std::optional<image_id> load(std::string name) {
        if (name.empty()) return std::nullopt;
        std::replace(name.begin(), name.end(), '\\', '/');
        if (const auto known = images_.find(name); known != images_.end()) return known->second;
        const auto path = file_beside(folder_, name);
        auto decoded = path ? read_image(*path) : expected<image>(path.error());
        std::optional<image_id> id;
        if (decoded) {
            id = static_cast<image_id>(target_.mesh.images.size());
            target_.mesh.images.push_back(std::move(*decoded));
        } else {
            target_.note("texture left out: " + decoded.error().message);
        }
        return images_[name] = id;
    }

    /// OBJ counts v from the bottom, so the transform is turned along with it.
    [[nodiscard]] static texture textured(image_id id, const tinyobj::texture_option_t& option) {
        texture t;
        t.image = id;
        if (option.clamp) t.wrap_u = t.wrap_v = texture_wrap::clamp_to_edge;
        const auto [su, sv] = std::pair(option.scale[0], option.scale[1]);
        t.transform[0].x = su;
        t.transform[1].y = sv;
        t.transform[2].x = option.origin_offset[0];
        t.transform[2].y = 1 - sv - option.origin_offset[1];
        return t;
    }

    [[nodiscard]] static float linear(float value) {
        return linear_from_srgb(std::clamp(value, 0.0f, 1.0f));
    }

    std::filesystem::path folder_;
    loaded_mesh& target_;
    std::map<std::string, std::optional<image_id>> images_{};
    std::map<std::pair<image_id, image_id>, image_id> joined_{};
};

}  // namespace billow::inline BILLOW_ABI::detail
// ---- billow/io/polygon.hpp
// Polygons as files hold them, planar or not, convex or not, into triangles.

#include <array>
#include <numeric>
#include <span>
#include <vector>


namespace billow::inline BILLOW_ABI::detail {

/// Twice the vector area of a polygon: its normal, however bent it is (Newell's method).
[[nodiscard]] inline dvec3 area_vector(std::span<const dvec3> corners) {
    dvec3 sum(0);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        // Relative to the first corner, so that distance from the origin costs no digits.
        sum += glm::cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
    }
    return sum;
}

/// Triangles of a simple polygon, always two fewer than it has corners, all turning as it does.
///
/// Shape   ids into `corners`, of which there are at least 3.
/// Cost    O(n) for a convex polygon, at worst O(n³).
/// Source  Ear clipping: Meisters, "Polygons have ears", 1975.
[[nodiscard]] inline std::vector<std::array<std::size_t, 3>> triangulate_polygon(
    std::span<const dvec3> corners) {
    std::vector<std::array<std::size_t, 3>> triangles;
    std::vector<std::size_t> rest(corners.size());
    std::iota(rest.begin(), rest.end(), std::size_t{0});
    const dvec3 normal = area_vector(corners);
    // Positive when a, b, c turn as the polygon does.
    const auto turn = [&](std::size_t a, std::size_t b, std::size_t c) {
        return glm::dot(glm::cross(corners[b] - corners[a], corners[c] - corners[a]), normal);
    };
    const auto is_ear = [&](std::size_t a, std::size_t b, std::size_t c) {
        if (!(turn(a, b, c) > 0)) return false;
        for (const std::size_t p : rest) {
            if (p == a || p == b || p == c) continue;
            if (corners[p] == corners[a] || corners[p] == corners[b] || corners[p] == corners[c]) {
                continue;  // a bridge to a hole visits its ends twice
            }
            if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
        }
        return true;
    };
    std::size_t at = 0;  // the ear's first corner; going on from the last ear avoids thin fans
    while (rest.size() > 3) {
        const std::size_t count = rest.size();
        std::size_t tried = 0;
        while (tried < count &&
               !is_ear(rest[at % count], rest[(at + 1) % count], rest[(at + 2) % count])) {
            ++at;
            ++tried;
        }
        at %= count;
        const std::size_t tip =
            (at + 1) % count;  // no ear at all: a degenerate polygon, cut anyway
        triangles.push_back({rest[at], rest[tip], rest[(at + 2) % count]});
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(tip));
        at = tip < at ? at - 1 : at + 1;
    }
    triangles.push_back({rest[0], rest[1], rest[2]});
    return triangles;
}

}  // namespace billow::inline BILLOW_ABI::detail

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Bytes as a stream, without a copy.
class bytes_stream : private std::streambuf, public std::istream {
public:
    explicit bytes_stream(std::span<const std::uint8_t> bytes) : std::istream(this) {
        // A get area is not written to.
        char* begin = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));
        setg(begin, begin, begin + bytes.size());
    }
};

/// Reads material libraries that lie beside the OBJ, and notes those that do not.
class obj_library_reader : public tinyobj::MaterialReader {
public:
    obj_library_reader(std::filesystem::path folder, loaded_mesh& target)
        : folder_(std::move(folder)), target_(target) {}

    bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                    std::map<std::string, int>* ids, std::string* warnings,
                    std::string* faults) override {
        const auto path = file_beside(folder_, name);
        auto bytes = path ? read_file(*path) : expected<std::vector<std::uint8_t>>(path.error());
        if (!bytes) {
            target_.note("materials left out: " + bytes.error().message);
            return true;  // the next name of the same line would be tried otherwise
        }
        bytes_stream stream(*bytes);
        tinyobj::LoadMtl(ids, materials, &stream, warnings, faults);
        return true;
    }

private:
    std::filesystem::path folder_;
    loaded_mesh& target_;
};

/// Refuses positions that tinyobjloader would read as 0: those that are no finite numbers.
[[nodiscard]] inline expected<done> check_obj_positions(const std::filesystem::path& file,
                                                        std::string_view text) {
    std::size_t line_number = 0;
    while (!text.empty()) {
        ++line_number;
        std::string_view line = text.substr(0, text.find_first_of("\n\r"));
        text.remove_prefix(line.size());
        text.remove_prefix(text.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, text.size()));
        const auto skip_blanks = [&] {
            line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
        };
        skip_blanks();
        if (line.size() < 2 || line[0] != 'v' || (line[1] != ' ' && line[1] != '\t')) continue;
        line.remove_prefix(1);
        for (int i = 0; i < 3; ++i) {
            skip_blanks();
            const std::string_view number = line.substr(0, line.find_first_of(" \t"));
            line.remove_prefix(number.size());
            if (!number.empty() && number.find_first_not_of("0123456789+-.eE") == number.npos) {
                continue;
            }
            const bool is_word = number.find_first_of("nN") != number.npos;
            return file_error(is_word ? error_code::not_finite : error_code::malformed, file,
                              "vertex on line " + std::to_string(line_number) +
                                  " has not three finite coordinates");
        }
    }
    return done{};
}

/// Turns what tinyobjloader holds into a mesh.
class obj_flattener {
public:
    obj_flattener(const std::filesystem::path& file, const read_options& options,
                  const tinyobj::attrib_t& attributes)
        : file_(file), options_(options), attributes_(attributes) {}

    [[nodiscard]] expected<loaded_mesh> run(const std::vector<tinyobj::shape_t>& shapes,
                                            const std::vector<tinyobj::material_t>& materials,
                                            loaded_mesh target) {
        target_ = std::move(target);
        obj_materials converted(file_.parent_path(), target_);
        for (const auto& m : materials) converted.add(m);
        material_count_ = materials.size();
        for (const auto& shape : shapes) note_columns(shape.mesh);
        has_colors_ = std::any_of(attributes_.colors.begin(), attributes_.colors.end(),
                                  [](float c) { return c != 1; });
        for (const auto& shape : shapes) {
            if (!shape.lines.indices.empty()) ++target_.skipped_primitives;
            if (!shape.points.indices.empty()) ++target_.skipped_primitives;
            if (shape.mesh.indices.empty()) continue;
            ++target_.primitives;
            ++target_.instances;
            if (auto done = add_shape(shape.mesh); !done) return done.error();
        }
        if (auto valid = validate(target_.mesh); !valid) {
            return file_error(valid.error().code, file_, valid.error().message);
        }
        return std::move(target_);
    }

private:
    struct corner_hash {
        std::size_t operator()(const std::array<int, 3>& c) const noexcept {
            std::uint64_t bits = static_cast<std::uint32_t>(c[0]);
            bits = mix_bits(bits << 32 | static_cast<std::uint32_t>(c[1]));
            return static_cast<std::size_t>(mix_bits(bits ^ static_cast<std::uint32_t>(c[2])));
        }
    };

    void note_columns(const tinyobj::mesh_t& shape) {
        for (const auto& i : shape.indices) {
            has_normals_ |= i.normal_index >= 0;
            has_uvs_ |= i.texcoord_index >= 0;
        }
    }

    [[nodiscard]] expected<done> add_shape(const tinyobj::mesh_t& shape) {
        std::size_t corner_count = 0;
        for (const unsigned char n : shape.num_face_vertices) corner_count += n;
        if (corner_count != shape.indices.size()) {
            return file_error(error_code::unsupported, file_,
                              "has a polygon of more than 255 corners; triangulate it first");
        }
        std::size_t first = 0;
        for (std::size_t face = 0; face < shape.num_face_vertices.size(); ++face) {
            const std::size_t count = shape.num_face_vertices[face];
            if (auto done =
                    add_polygon({shape.indices.data() + first, count}, shape.material_ids[face]);
                !done) {
                return done;
            }
            first += count;
        }
        return done{};
    }

    [[nodiscard]] expected<done> add_polygon(std::span<const tinyobj::index_t> polygon,
                                             int obj_material) {
        const auto is_within = [](int id, std::size_t numbers, std::size_t width) {
            return id >= 0 && static_cast<std::size_t>(id) < numbers / width;
        };
        corners_.clear();
        for (const auto& i : polygon) {
            if (!is_within(i.vertex_index, attributes_.vertices.size(), 3) ||
                (i.normal_index >= 0 &&
                 !is_within(i.normal_index, attributes_.normals.size(), 3)) ||
                (i.texcoord_index >= 0 &&
                 !is_within(i.texcoord_index, attributes_.texcoords.size(), 2))) {
                return file_error(error_code::out_of_range, file_,
                                  "face " + std::to_string(target_.mesh.face_count()) +
                                      " has an index beyond the last vertex");
            }
            corners_.emplace_back(three(attributes_.vertices, i.vertex_index));
        }
        vertices_.clear();
        for (const auto& i : polygon) vertices_.push_back(vertex_of(i));
        if (target_.mesh.face_count() + polygon.size() > options_.max_faces) {
            return file_error(error_code::too_large, file_,
                              "has more than " + std::to_string(options_.max_faces) + " faces");
        }
        for (const auto& t : triangulate_polygon(corners_)) {
            target_.mesh.triangles.emplace_back(vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]);
            target_.mesh.face_materials.push_back(material_of(obj_material));
        }
        return done{};
    }

    /// Same indices, same vertex. A corner without a normal is of its polygon alone.
    [[nodiscard]] std::uint32_t vertex_of(const tinyobj::index_t& i) {
        mesh& m = target_.mesh;
        const bool is_flat = has_normals_ && i.normal_index < 0;
        const auto add = [&] {
            const auto id = static_cast<std::uint32_t>(m.positions.size());
            m.positions.push_back(three(attributes_.vertices, i.vertex_index));
            if (has_normals_) m.normals.push_back(normal_of(i));
            if (has_uvs_) m.uv_sets[0].push_back(uv_of(i.texcoord_index));
            if (has_colors_) {
                const vec3 c = three(attributes_.colors, i.vertex_index);
                m.colors.emplace_back(linear(c.r), linear(c.g), linear(c.b), 1.0f);
            }
            return id;
        };
        if (is_flat) return add();
        const auto [known, is_new] =
            ids_.try_emplace({i.vertex_index, i.texcoord_index, i.normal_index}, 0u);
        if (is_new) known->second = add();
        return known->second;
    }

    [[nodiscard]] vec3 normal_of(const tinyobj::index_t& i) const {
        dvec3 normal(0);
        if (i.normal_index >= 0) normal = dvec3(three(attributes_.normals, i.normal_index));
        if (!(glm::length(normal) > 0)) normal = area_vector(corners_);
        const double length = glm::length(normal);
        return length > 0 && std::isfinite(length) ? vec3(normal / length) : vec3(0, 0, 1);
    }

    /// OBJ counts v from the bottom of the image, our textures from the top.
    [[nodiscard]] vec2 uv_of(int id) const {
        if (id < 0) return vec2(0);
        const auto at = static_cast<std::size_t>(id) * 2;
        const vec2 uv(attributes_.texcoords[at], 1 - attributes_.texcoords[at + 1]);
        return std::isfinite(uv.x) && std::isfinite(uv.y) ? uv : vec2(0);
    }

    /// Faces without a material share a white one, added when first needed.
    [[nodiscard]] material_id material_of(int obj_material) {
        if (obj_material >= 0 && static_cast<std::size_t>(obj_material) < material_count_) {
            return static_cast<material_id>(obj_material);
        }
        if (target_.mesh.materials.size() == material_count_) {
            target_.mesh.materials.push_back({.metallic = 0});
        }
        return static_cast<material_id>(material_count_);
    }

    [[nodiscard]] static vec3 three(const std::vector<float>& numbers, int id) {
        const auto at = static_cast<std::size_t>(id) * 3;
        return {numbers[at], numbers[at + 1], numbers[at + 2]};
    }
    [[nodiscard]] static float linear(float value) {
        return linear_from_srgb(std::clamp(std::isfinite(value) ? value : 1.0f, 0.0f, 1.0f));
    }

    const std::filesystem::path& file_;
    const read_options& options_;
    const tinyobj::attrib_t& attributes_;
    loaded_mesh target_{};
    std::size_t material_count_ = 0;
    bool has_normals_ = false;
    bool has_uvs_ = false;
    bool has_colors_ = false;
    std::vector<dvec3> corners_{};
    std::vector<std::uint32_t> vertices_{};
    std::unordered_map<std::array<int, 3>, std::uint32_t, corner_hash> ids_{};
};

/// The mesh in the bytes of an OBJ file; `file` names it and says where its other files lie.
[[nodiscard]] inline expected<loaded_mesh> read_obj_bytes(const std::filesystem::path& file,
                                                          std::span<const std::uint8_t> bytes,
                                                          const read_options& options) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.find('\0') != text.npos) {
        return file_error(error_code::malformed, file, "is not text, so it is no OBJ file");
    }
    if (auto checked = check_obj_positions(file, text); !checked) return checked.error();

    loaded_mesh target;
    obj_library_reader library(file.parent_path(), target);
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warnings;
    std::string faults;
    bytes_stream stream(bytes);
    // Polygons come whole: tinyobjloader would drop those with indices out of range in silence.
    constexpr bool triangulates = false;
    constexpr bool fills_colors = true;
    if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warnings, &faults, &stream, &library,
                          triangulates, fills_colors)) {
        return file_error(error_code::malformed, file,
                          faults.empty() ? "is not an OBJ file" : faults);
    }
    if (attributes.vertices.empty()) {
        return file_error(error_code::malformed, file, "is not an OBJ file: it has no vertex");
    }
    return obj_flattener(file, options, attributes).run(shapes, materials, std::move(target));
}

}  // namespace detail

/// Reads a Wavefront OBJ file with its material libraries and textures.
///
/// Gives   the mesh, valid: polygons in triangles, one vertex for each set of indices, v of texture
///         coordinates from the top. Missing libraries and textures are noted, not fatal.
/// Fails   with one line that names file and fault.
/// Cost    O(bytes), more for concave polygons.
[[nodiscard]] inline expected<loaded_mesh> read_obj(const std::filesystem::path& file,
                                                    const read_options& options = {}) {
    auto bytes = read_file(file);
    if (!bytes) return bytes.error();
    return detail::read_obj_bytes(file, *bytes, options);
}

}  // namespace billow::inline BILLOW_ABI

namespace billow::inline BILLOW_ABI {

/// Reads .gltf, .glb or .obj.
///
/// Fails   unsupported: another format; else as read_gltf and read_obj.
[[nodiscard]] inline expected<loaded_mesh> read_mesh(const std::filesystem::path& file,
                                                     const read_options& options = {}) {
    auto bytes = read_file(file);
    if (!bytes) return bytes.error();
    const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    std::string extension = file.extension().string();
    for (char& c : extension) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    const bool is_gltf = text.starts_with("glTF") || (first != text.npos && text[first] == '{') ||
                         extension == ".gltf" || extension == ".glb";
    if (is_gltf) return detail::read_gltf_bytes(file, std::move(*bytes), options);
    if (extension == ".obj") return detail::read_obj_bytes(file, *bytes, options);
    return detail::file_error(error_code::unsupported, file,
                              "is of a format that billow does not read; it reads .gltf, .glb and "
                              ".obj");
}

}  // namespace billow::inline BILLOW_ABI
// ---- billow/io/mip_files.hpp
// The mip levels of baked atlases as files: one DDS a channel, or one PNG a channel and level.

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>


namespace billow::inline BILLOW_ABI {

enum class mip_format { none, png, dds };

/// What write_mips has written.
struct mip_files {
    std::vector<std::filesystem::path> names{};
    int safe_levels = 0;  ///< of all atlases, see safe_mip_levels; 0 where nothing was written
};

/// Writes all levels of all channels: tree_basecolor.dds, tree_normal.dds, tree_orm.dds,
/// tree_emissive.dds, tree_horizon.dds for the stem "tree", as far as there are such channels; as PNG
/// tree_basecolor_mip0.png, tree_basecolor_mip1.png … Further atlases are tree_1_basecolor.dds …
///
/// Needs   as make_mips.
/// Gives   the files in the order in which they were written.
/// Fails   as write_file; what was written before stays.
[[nodiscard]] inline expected<mip_files> write_mips(const std::filesystem::path& stem,
                                                    const baked_cloud& baked, mip_format format,
                                                    const mip_options& options = {},
                                                    parallel threads = {}) {
    mip_files files;
    if (format == mip_format::none) return files;
    const auto mips = make_mips(baked, options, threads);
    for (std::size_t id = 0; id < mips.size(); ++id) {
        const atlas_mips& of = mips[id];
        files.safe_levels = id == 0 ? of.safe_levels : std::min(files.safe_levels, of.safe_levels);
        const auto name = [&](std::string_view map, const std::string& ending) {
            std::filesystem::path file = stem;
            if (id > 0) file += "_" + std::to_string(id);
            file += "_" + std::string(map) + ending;
            return file;
        };
        struct map_levels {
            std::string_view name{};
            std::span<const image> levels{};
            bool is_srgb = false;
        };
        for (const map_levels& c :
             {map_levels{"basecolor", of.base_color, true}, map_levels{"normal", of.normal},
              map_levels{"orm", of.occlusion_roughness_metallic},
              map_levels{"emissive", of.emissive, true}, map_levels{"horizon", of.horizon}}) {
            if (c.levels.empty()) continue;
            if (format == mip_format::dds) {
                files.names.push_back(name(c.name, ".dds"));
                const auto written = write_dds(files.names.back(), c.levels, c.is_srgb);
                if (!written) return written.error();
                continue;
            }
            for (std::size_t level = 0; level < c.levels.size(); ++level) {
                files.names.push_back(name(c.name, "_mip" + std::to_string(level) + ".png"));
                const auto written = write_png(files.names.back(), c.levels[level]);
                if (!written) return written.error();
            }
        }
    }
    return files;
}

}  // namespace billow::inline BILLOW_ABI
