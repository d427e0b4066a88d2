// MTL materials in the terms of metallic-roughness.
//
// MTL has no fixed colour space; its numbers are taken as sRGB, as the screens of its time showed
// them, and its textures as sRGB.
#pragma once

#include <algorithm>
#include <map>
#include <optional>

#include <tiny_obj_loader.h>

#include <billow/io/image_file.hpp>
#include <billow/io/loaded_mesh.hpp>

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
