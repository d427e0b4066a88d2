// A glTF file opened: container split, JSON checked, typed by tinygltf, buffers within reach.
//
// glTF 2.0 Specification, Khronos Group 2021, is the source of every rule in the gltf_* headers.
//
// Files are not to be trusted. tinygltf turns JSON into structs and nothing else: buffers and images
// are taken out of the JSON before it sees it, and every offset is checked here.
#pragma once

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

#include <billow/core/expected.hpp>
#include <billow/io/file.hpp>

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
