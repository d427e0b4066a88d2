// Meshes with every plane in a colour of its own, to look at.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/image/image.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// A colour, linear light, that differs from those of nearby ids; dark grey for no_id.
[[nodiscard]] inline vec3 color_of_plane(std::uint32_t id) noexcept {
    if (id == no_id) return vec3(0.06f);
    // Hues a golden section apart never come back; lightness changes as well.
    constexpr double golden_section = 0.61803398874989485;
    const double hue = 6 * std::fmod(id * golden_section, 1.0);
    const auto part = [hue](double middle) {
        const double away = std::abs(std::remainder(hue - middle, 6.0));
        return std::min(1.0, std::max(0.0, 2 - away));
    };
    constexpr double lightness[] = {1.0, 0.55, 0.8};
    const double light = lightness[id % 3];
    constexpr double white = 0.12;
    const vec3 pure(part(0), part(2), part(4));
    return vec3(static_cast<float>(white)) + pure * static_cast<float>(light * (0.9 - white));
}

/// The mesh with its alpha but without its looks: each face has the colour of its row in `ids`.
/// Corners are no longer shared.
///
/// Needs  a row of `ids` a face.
[[nodiscard]] inline mesh colored_by(const mesh& source, std::span<const std::uint32_t> ids) {
    BILLOW_ASSERT(ids.size() == source.face_count());
    mesh result;
    const auto unshare = [&](const auto& from, auto& to) {
        if (from.empty()) return;
        to.reserve(3 * source.face_count());
        for (const uvec3& t : source.triangles) {
            for (int k = 0; k < 3; ++k) to.push_back(from[t[k]]);
        }
    };
    unshare(source.positions, result.positions);
    unshare(source.normals, result.normals);
    unshare(source.feature_ids, result.feature_ids);
    for (std::size_t i = 0; i < uv_set_count; ++i) unshare(source.uv_sets[i], result.uv_sets[i]);
    for (face_id face = 0; face < source.face_count(); ++face) {
        result.triangles.push_back(uvec3(0, 1, 2) + 3u * face);
        for (int k = 0; k < 3; ++k) {
            const float alpha =
                source.colors.empty() ? 1.0f : source.colors[source.triangles[face][k]].w;
            result.colors.emplace_back(color_of_plane(ids[face]), alpha);
        }
    }
    result.face_materials = source.face_materials;
    for (const material& look : source.materials) {
        material plain;
        plain.base_color = vec4(1, 1, 1, look.base_color.w);
        plain.metallic = 0;
        plain.alpha = look.alpha;
        plain.alpha_cutoff = look.alpha_cutoff;
        plain.is_double_sided = look.is_double_sided;
        if (look.alpha != alpha_mode::opaque) plain.base_color_texture = look.base_color_texture;
        result.materials.push_back(std::move(plain));
    }
    result.images.resize(source.images.size());
    for (const material& look : result.materials) {
        const image_id id = look.base_color_texture.image;
        if (id >= source.images.size() || !result.images[id].empty()) continue;
        image& white = result.images[id] = source.images[id];
        const auto channels = static_cast<std::size_t>(white.channels);
        const std::size_t colors = channels == 2 || channels == 4 ? channels - 1 : channels;
        for (std::size_t i = 0; i < white.bytes.size(); i += channels) {
            for (std::size_t c = 0; c < colors; ++c) white.bytes[i + c] = 255;
        }
    }
    return result;
}

/// The feature id of each face: that of its first corner; no_id where the mesh has none.
[[nodiscard]] inline std::vector<std::uint32_t> features_of_faces(const mesh& of) {
    std::vector<std::uint32_t> ids(of.face_count(), no_id);
    if (of.feature_ids.empty()) return ids;
    for (face_id face = 0; face < of.face_count(); ++face) {
        ids[face] = of.feature_ids[of.triangles[face].x];
    }
    return ids;
}

}  // namespace billow::inline BILLOW_ABI
