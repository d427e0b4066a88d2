// Files as bytes: read whole, written aside and renamed, so that no reader meets half a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <billow/core/expected.hpp>

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
