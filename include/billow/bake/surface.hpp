// What a mesh looks like at a point of one of its faces: colour, normal, and whether it is there.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include <billow/bake/sky_table.hpp>
#include <billow/bake/texture_sampler.hpp>
#include <billow/core/types.hpp>
#include <billow/image/mip_chain.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// The look of a point. Colours are linear light, the normal has length 1.
struct surface_sample {
    vec3 base_color{1};
    vec3 normal{0, 0, 1};
    float occlusion = 1;
    float roughness = 1;
    float metallic = 0;
    vec3 emissive{0};
    vec4 visible_sky{0, 0, 0, 1};  ///< sky_view::visible
};

/// How it is decided whether a sample of a face is there.
struct face_cover {
    enum class rule {
        always,
        cutoff,  ///< where alpha ≥ cutoff
        share,   ///< where alpha ≥ a threshold that differs from sample to sample
    };
    rule decides = rule::always;
    float factor = 1;  ///< multiplies the alpha of texture and vertices
    float cutoff = 0;
    const image* alpha = nullptr;  ///< none: 1 everywhere
    const texture* map = nullptr;
    bool is_nearest = false;
    std::array<vec2, 3> uvs{};
    std::array<float, 3> vertex_alpha{1, 1, 1};
    bool has_vertex_alpha = false;
};

namespace detail {

/// A texture with its mip chain and coordinates; without a chain it says nothing.
struct bound_texture {
    const texture* map = nullptr;
    const std::vector<image>* chain = nullptr;
    texel_kind kind = texel_kind::linear;

    [[nodiscard]] explicit operator bool() const noexcept { return chain != nullptr; }
};

struct bound_material {
    const material* look = nullptr;
    bound_texture base_color{};
    bound_texture metallic_roughness{};
    bound_texture normal{};
    bound_texture occlusion{};
    bound_texture emissive{};
    std::vector<image>
        cover{};  ///< alpha; of alpha_mode::mask from level 1 on the share that passes
};

struct image_chain {
    image_id image = no_id;
    texel_kind kind = texel_kind::linear;
    std::vector<billow::image> levels{};
};

/// Alpha of every level alone, which the visibility pass reads without the colours.
[[nodiscard]] inline std::vector<image> alpha_of(const std::vector<image>& chain) {
    std::vector<image> result;
    for (const image& level : chain) {
        image alpha{level.width, level.height, 1, {}};
        alpha.bytes.reserve(level.bytes.size() / 4);
        for (std::size_t i = 3; i < level.bytes.size(); i += 4) {
            alpha.bytes.push_back(level.bytes[i]);
        }
        result.push_back(std::move(alpha));
    }
    return result;
}

/// Level 0 as it is; further levels tell which share of its texels passes the alpha test. Mean alpha
/// would lose what is thin: a leaf's tip has a mean below the cutoff, yet it covers its share.
[[nodiscard]] inline std::vector<image> cover_of_mask(const std::vector<image>& chain,
                                                      const material& look) {
    image passes = chain[0];
    for (std::size_t i = 3; i < passes.bytes.size(); i += 4) {
        const float alpha = static_cast<float>(passes.bytes[i]) / 255.0f * look.base_color.w;
        passes.bytes[i] = alpha >= look.alpha_cutoff ? 255 : 0;
    }
    std::vector<image> cover = alpha_of(make_mip_chain(passes, texel_kind::linear));
    cover[0] = alpha_of({chain[0]})[0];
    return cover;
}

}  // namespace detail

/// What is constant over a face when it is drawn at some resolution.
struct face_look {
    face_id face = no_id;
    const detail::bound_material* material = nullptr;
    vec3 flat_normal{0, 0, 1};
    std::array<std::size_t, 5> levels{};  ///< mip levels, in the order of bound_material's textures
    vec3 tangent{0};                      ///< along u of the normal texture, where there is one
    vec3 bitangent{0};                    ///< up in the normal texture
};

/// A mesh made ready for shading: the mip chains of the textures that its faces use.
///
/// Needs  the mesh outlives it; indices within bounds.
class surface {
public:
    explicit surface(const mesh& source) : mesh_(source) {
        std::vector<char> is_used(source.materials.size() + 1, 0);
        for (face_id face = 0; face < source.face_count(); ++face) is_used[material_row(face)] = 1;
        chains_.reserve(source.materials.size() * 5);
        materials_.resize(is_used.size());
        for (std::size_t row = 0; row < is_used.size(); ++row) {
            static const mesh no_materials;
            const bool is_plain = row + 1 == is_used.size();
            materials_[row].look = is_plain ? &no_materials.material_of(0) : &source.materials[row];
            if (is_used[row] != 0) bind(materials_[row]);
        }
        for (const vec4& color : source.colors) has_vertex_alpha_ |= color.w < 1;
    }
    surface(const surface&) = delete;
    surface& operator=(const surface&) = delete;

    /// From now on the sky that `sky` says is visible multiplies the occlusion. Needs: it outlives
    /// this; the table of source().
    void light_by(const sky_table& sky) noexcept { sky_ = &sky; }

    [[nodiscard]] const mesh& source() const noexcept { return mesh_; }
    [[nodiscard]] const material& material_of(face_id face) const noexcept {
        return *materials_[material_row(face)].look;
    }

    /// How to decide whether samples of a face are there, when it covers `sample_area` of them.
    [[nodiscard]] face_cover cover_of(face_id face, double sample_area) const noexcept {
        const detail::bound_material& bound = materials_[material_row(face)];
        const material& look = *bound.look;
        face_cover cover;
        if (look.alpha == alpha_mode::opaque) return cover;
        cover.decides =
            look.alpha == alpha_mode::mask ? face_cover::rule::cutoff : face_cover::rule::share;
        cover.factor = look.base_color.w;
        cover.cutoff = look.alpha_cutoff;
        const uvec3 corners = mesh_.triangles[face];
        if (has_vertex_alpha_) {
            cover.has_vertex_alpha = true;
            for (int k = 0; k < 3; ++k) {
                cover.vertex_alpha[static_cast<std::size_t>(k)] = mesh_.colors[corners[k]].w;
            }
        }
        if (bound.cover.empty()) return cover;
        cover.map = bound.base_color.map;
        cover.uvs = uvs_of(bound.base_color, corners);
        // Vertex alpha moves the cutoff, which the shares were computed for: then level 0 must do.
        const bool needs_exact = look.alpha == alpha_mode::mask && has_vertex_alpha_;
        const std::size_t level =
            needs_exact ? 0 : level_for(bound.base_color, cover.uvs, sample_area);
        cover.alpha = &bound.cover[level];
        // The texels of further levels are about as large as a sample: one of them says enough.
        cover.is_nearest = level > 0 || cover.map->is_nearest;
        if (level > 0 && look.alpha == alpha_mode::mask) {
            cover.decides = face_cover::rule::share;
            cover.factor = 1;
        }
        return cover;
    }

    /// What at() needs to know of a face that covers `texel_area` texels.
    [[nodiscard]] face_look look_at(face_id face, double texel_area) const noexcept {
        const detail::bound_material& bound = materials_[material_row(face)];
        face_look look;
        look.face = face;
        look.material = &bound;
        const auto [a, b, c] = mesh_.corners(face);
        const dvec3 cross = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
        const double length = glm::length(cross);
        if (length > 0) look.flat_normal = vec3(cross / length);
        const uvec3 corners = mesh_.triangles[face];
        const std::array textures{&bound.base_color, &bound.metallic_roughness, &bound.normal,
                                  &bound.occlusion, &bound.emissive};
        for (std::size_t i = 0; i < textures.size(); ++i) {
            if (*textures[i]) {
                look.levels[i] = level_for(*textures[i], uvs_of(*textures[i], corners), texel_area);
            }
        }
        if (bound.normal) set_tangents(look, uvs_of(bound.normal, corners));
        return look;
    }

    /// The look of the point with barycentric `weights` (sum 1) of a face.
    [[nodiscard]] surface_sample at(const face_look& look, const vec3& weights) const noexcept {
        const detail::bound_material& bound = *look.material;
        const material& m = *bound.look;
        const uvec3 corners = mesh_.triangles[look.face];
        const auto sampled = [&](const detail::bound_texture& t, std::size_t level) {
            return sample_texture(*t.chain, t.kind, *t.map, uv_at(t, corners, weights), level);
        };
        surface_sample sample;
        sample.base_color = vec3(m.base_color);
        if (bound.base_color) {
            sample.base_color *= vec3(sampled(bound.base_color, look.levels[0]));
        }
        if (!mesh_.colors.empty()) {
            sample.base_color *= vec3(mixed(mesh_.colors, corners, weights));
        }
        sample.roughness = m.roughness;
        sample.metallic = m.metallic;
        if (bound.metallic_roughness) {
            const vec4 value = sampled(bound.metallic_roughness, look.levels[1]);
            sample.roughness *= value.y;
            sample.metallic *= value.z;
        }
        if (bound.occlusion) {
            const vec4 value = sampled(bound.occlusion, look.levels[3]);
            sample.occlusion = 1 + m.occlusion_strength * (value.x - 1);
        }
        if (sky_ != nullptr) {
            const sky_view view = sky_->at(look.face, weights);
            sample.occlusion *= view.open;
            sample.visible_sky = view.visible;
        }
        sample.emissive = m.emissive;
        if (bound.emissive) sample.emissive *= vec3(sampled(bound.emissive, look.levels[4]));
        sample.normal = look.flat_normal;
        if (!mesh_.normals.empty()) {
            sample.normal = normalized_or(mixed(mesh_.normals, corners, weights), look.flat_normal);
        }
        if (bound.normal) {
            const vec4 value = sampled(bound.normal, look.levels[2]);
            sample.normal = bumped(look, sample.normal, corners, weights, vec3(value));
        }
        return sample;
    }

private:
    template <class T>
    [[nodiscard]] static T mixed(const std::vector<T>& column, const uvec3& corners,
                                 const vec3& weights) noexcept {
        return column[corners.x] * weights.x + column[corners.y] * weights.y +
               column[corners.z] * weights.z;
    }
    [[nodiscard]] static vec3 normalized_or(const vec3& v, const vec3& otherwise) noexcept {
        const float length = glm::length(v);
        return length > 1e-12f ? v / length : otherwise;
    }

    [[nodiscard]] std::size_t material_row(face_id face) const noexcept {
        const std::size_t count = mesh_.materials.size();
        const std::size_t row = mesh_.face_materials.empty() ? 0 : mesh_.face_materials[face];
        return row < count ? row : count;
    }

    [[nodiscard]] std::array<vec2, 3> uvs_of(const detail::bound_texture& t,
                                             const uvec3& corners) const noexcept {
        const std::vector<vec2>& uvs = mesh_.uv_sets[t.map->uv_set];
        return {transformed(*t.map, uvs[corners.x]), transformed(*t.map, uvs[corners.y]),
                transformed(*t.map, uvs[corners.z])};
    }
    [[nodiscard]] vec2 uv_at(const detail::bound_texture& t, const uvec3& corners,
                             const vec3& weights) const noexcept {
        return transformed(*t.map, mixed(mesh_.uv_sets[t.map->uv_set], corners, weights));
    }

    [[nodiscard]] static std::size_t level_for(const detail::bound_texture& t,
                                               const std::array<vec2, 3>& uvs,
                                               double area) noexcept {
        const dvec2 p = dvec2(uvs[1]) - dvec2(uvs[0]);
        const dvec2 q = dvec2(uvs[2]) - dvec2(uvs[0]);
        const image& base = t.chain->front();
        const double texels = 0.5 * std::abs(p.x * q.y - p.y * q.x) * base.width * base.height;
        return level_of_footprint(texels / std::max(area, 1e-12), t.chain->size());
    }

    void set_tangents(face_look& look, const std::array<vec2, 3>& uvs) const noexcept {
        const auto [a, b, c] = mesh_.corners(look.face);
        const vec3 e1 = b - a;
        const vec3 e2 = c - a;
        const vec2 d1 = uvs[1] - uvs[0];
        const vec2 d2 = uvs[2] - uvs[0];
        const float det = d1.x * d2.y - d1.y * d2.x;
        const float side = det < 0 ? -1.0f : 1.0f;
        look.tangent = normalized_or((e1 * d2.y - e2 * d1.y) * side, vec3(0));
        look.bitangent = -normalized_or((e2 * d1.x - e1 * d2.x) * side, vec3(0));  // v runs down
    }

    /// The normal of a normal texture's `value` around the smooth normal `n`.
    [[nodiscard]] vec3 bumped(const face_look& look, const vec3& n, const uvec3& corners,
                              const vec3& weights, const vec3& value) const noexcept {
        const float scale = look.material->look->normal_scale;
        const vec3 local = (value * 2.0f - 1.0f) * vec3(scale, scale, 1);
        vec3 t = look.tangent;
        vec3 b = look.bitangent;
        if (!mesh_.tangents.empty()) {
            t = vec3(mixed(mesh_.tangents, corners, weights));
            b = glm::cross(n, t) * mesh_.tangents[corners.x].w;
        }
        t = normalized_or(t - n * glm::dot(n, t), vec3(0));
        const float side = glm::dot(glm::cross(n, t), b) < 0 ? -1.0f : 1.0f;
        b = glm::cross(n, t) * side;
        return normalized_or(t * local.x + b * local.y + n * local.z, n);
    }

    [[nodiscard]] detail::bound_texture bound(const texture& t, texel_kind kind) {
        const bool is_usable = t.image < mesh_.images.size() && !mesh_.images[t.image].empty() &&
                               t.uv_set < uv_set_count && !mesh_.uv_sets[t.uv_set].empty();
        if (!is_usable) return {};
        for (const auto& chain : chains_) {
            if (chain->image == t.image && chain->kind == kind) return {&t, &chain->levels, kind};
        }
        chains_.push_back(std::make_unique<detail::image_chain>(
            detail::image_chain{t.image, kind, make_mip_chain(mesh_.images[t.image], kind)}));
        return {&t, &chains_.back()->levels, kind};
    }

    void bind(detail::bound_material& to) {
        const material& look = *to.look;
        const bool is_opaque = look.alpha == alpha_mode::opaque;
        to.base_color =
            bound(look.base_color_texture, is_opaque ? texel_kind::srgb : texel_kind::srgb_alpha);
        to.normal = bound(look.normal_texture, texel_kind::linear);
        to.metallic_roughness = bound(look.metallic_roughness_texture, texel_kind::linear);
        to.occlusion = bound(look.occlusion_texture, texel_kind::linear);
        if (look.emissive != vec3(0)) to.emissive = bound(look.emissive_texture, texel_kind::srgb);
        if (is_opaque || !to.base_color) return;
        to.cover = look.alpha == alpha_mode::mask
                       ? detail::cover_of_mask(*to.base_color.chain, look)
                       : detail::alpha_of(*to.base_color.chain);
    }

    const mesh& mesh_;
    const sky_table* sky_ = nullptr;
    std::vector<std::unique_ptr<detail::image_chain>> chains_{};
    std::vector<detail::bound_material> materials_{};
    bool has_vertex_alpha_ = false;
};

/// The normal of a sample as it is seen from the side that `toward` (unit length) points to. A
/// surface seen from behind, or a double-sided one whose normal points away, shows the other side;
/// a smooth normal that leaves the view at a grazing face does not turn around.
[[nodiscard]] inline vec3 normal_toward(const surface_sample& sample, const face_look& look,
                                        const vec3& toward) noexcept {
    if (glm::dot(sample.normal, toward) >= 0) return sample.normal;
    const bool is_seen_from_behind = glm::dot(look.flat_normal, toward) < 0;
    return is_seen_from_behind || look.material->look->is_double_sided ? -sample.normal
                                                                       : sample.normal;
}

}  // namespace billow::inline BILLOW_ABI
