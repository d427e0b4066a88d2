// Any mesh file: the reader is chosen by what is in the file, then by its name.
#pragma once

#include <billow/io/gltf.hpp>
#include <billow/io/obj.hpp>

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
