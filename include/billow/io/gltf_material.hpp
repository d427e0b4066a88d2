// Materials and textures of glTF, converted and decoded when a face first uses them.
#pragma once

#include <cmath>
#include <map>

#include <billow/io/gltf_document.hpp>
#include <billow/io/image_file.hpp>
#include <billow/io/loaded_mesh.hpp>

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
