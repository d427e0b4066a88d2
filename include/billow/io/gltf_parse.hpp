// From the bytes of a .gltf or .glb to a gltf_document, without trust in any of them.
#pragma once

#include <array>

#include <billow/io/gltf_document.hpp>

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
