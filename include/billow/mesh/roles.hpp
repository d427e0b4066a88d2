// Which faces are foliage and which are solid: by material names, alpha, or the size of the pieces.
//
// A. Fuhrmann et al.: Extreme model simplification for forest rendering. 2005, section 3.2.2: planes
// of leaves that are searched together with the trunk slice it.
#pragma once

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/mesh/components.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

enum class face_role : std::uint8_t {
    solid,    ///< a trunk, a wall
    foliage,  ///< leaves, needles, fronds
};

/// What told the roles apart.
enum class role_rule {
    none,            ///< nothing did: every face is solid
    material_names,  ///< role_options::foliage_materials
    alpha,           ///< materials whose alpha cuts holes
    component_size,  ///< role_options::leaf
};

/// A connected component is a leaf when it is within all of these. Shares are of the whole mesh, not
/// of its largest component, so that equal leaves without a trunk are leaves, too.
struct leaf_size {
    std::size_t triangles = 200;   ///< most triangles
    double triangle_share = 0.05;  ///< of all triangles
    double area_share = 0.01;      ///< of the whole area
    double diameter_share = 0.25;  ///< of the diameter of the sphere around the mesh
};

struct role_options {
    /// Names such as "leaf*" of the materials that are foliage; * is any text, ? any character, case
    /// does not count. None: alpha decides, and where no alpha cuts, the size of components.
    std::vector<std::string> foliage_materials{};
    /// Of the texels of a base colour texture: where alpha leaves out fewer, the material is solid.
    double least_cut = 0.05;
    leaf_size leaf{};
};

/// Shape  `of_face`: one role a face.
struct face_roles {
    std::vector<face_role> of_face{};
    role_rule rule = role_rule::none;
    double foliage_area_share = 0;
    std::string reason{};  ///< one line for people

    /// The faces of a role, ascending.
    [[nodiscard]] std::vector<face_id> faces_of(face_role role) const {
        std::vector<face_id> faces;
        for (face_id face = 0; face < of_face.size(); ++face) {
            if (of_face[face] == role) faces.push_back(face);
        }
        return faces;
    }
};

/// Whether `text` fits `pattern`: * is any text, ? any character, case of ASCII does not count.
/// Cost  O(text × pattern).
[[nodiscard]] inline bool matches_glob(std::string_view text, std::string_view pattern) noexcept {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
    std::size_t t = 0;
    std::size_t p = 0;
    std::size_t star = std::string_view::npos;
    std::size_t after_star = 0;  // where the text goes on if the last star takes one more
    while (t < text.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            after_star = t;
        } else if (p < pattern.size() &&
                   (pattern[p] == '?' || lower(pattern[p]) == lower(text[t]))) {
            ++p, ++t;
        } else if (star != std::string_view::npos) {
            p = star + 1;
            t = ++after_star;
        } else {
            return false;
        }
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

namespace detail {

/// Whether alpha cuts holes into a surface. Where its texture has no alpha, a mask of a double-sided
/// material is taken by its word; an even transparency is glass.
[[nodiscard]] inline bool is_cut(const mesh& m, const material& look, double least_cut) {
    if (look.alpha == alpha_mode::opaque) return false;
    const image_id id = look.base_color_texture.image;
    if (id >= m.images.size() || m.images[id].empty() || m.images[id].channels != 4) {
        return look.alpha == alpha_mode::mask && look.is_double_sided;
    }
    const float cutoff = look.alpha == alpha_mode::mask ? look.alpha_cutoff : 0.5f;
    const std::vector<std::uint8_t>& bytes = m.images[id].bytes;
    std::size_t cut = 0;
    std::size_t kept = 0;
    for (std::size_t i = 3; i < bytes.size(); i += 4) {
        ++(static_cast<float>(bytes[i]) / 255.0f * look.base_color.w < cutoff ? cut : kept);
    }
    return kept > 0 && static_cast<double>(cut) >= least_cut * static_cast<double>(cut + kept);
}

[[nodiscard]] inline std::string percent(double share) {
    char text[16];
    std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
    return text;
}

/// Finds roles; its methods are the rules.
class role_finder {
public:
    role_finder(const mesh& m, const role_options& options) : mesh_(m), options_(options) {
        roles_.of_face.assign(m.face_count(), face_role::solid);
    }

    [[nodiscard]] face_roles run() {
        const auto is_named = [&](const material& m) {
            return std::ranges::any_of(options_.foliage_materials, [&](const std::string& pattern) {
                return matches_glob(m.name, pattern);
            });
        };
        const auto cuts = [&](const material& m) { return is_cut(mesh_, m, options_.least_cut); };
        if (!options_.foliage_materials.empty()) {
            by_material(role_rule::material_names, "foliage by name is ", is_named);
        } else if (!by_material(role_rule::alpha, "alpha cuts holes into ", cuts)) {
            by_component_size();
        }
        add_area();
        return std::move(roles_);
    }

private:
    template <class IsFoliage>
    bool by_material(role_rule rule, const std::string& reason, const IsFoliage& is_foliage) {
        std::vector<char> is_leafy;
        for (const material& m : mesh_.materials) is_leafy.push_back(is_foliage(m));
        std::vector<char> is_told(mesh_.materials.size(), 0);
        std::size_t count = 0;
        roles_.reason = reason;
        for (face_id face = 0; face < mesh_.face_count(); ++face) {
            const material_id id = mesh_.face_materials.empty() ? 0 : mesh_.face_materials[face];
            if (id >= is_leafy.size() || is_leafy[id] == 0) continue;
            roles_.of_face[face] = face_role::foliage;
            if (is_told[id] != 0) continue;
            is_told[id] = 1;
            if (++count > 3) continue;
            roles_.reason += (count > 1 ? ", \"" : "\"") + mesh_.materials[id].name + '"';
        }
        if (count == 0) roles_.reason += "no material";
        if (count > 3) roles_.reason += " and " + std::to_string(count - 3) + " more";
        if (count > 0) roles_.rule = rule;
        return count > 0;
    }

    void by_component_size() {
        const mesh_components pieces = find_components(mesh_);
        double area = 0;
        for (const mesh_component& piece : pieces.components) area += piece.area;
        const double diameter = 2 * bounding_sphere_of(3 * mesh_.face_count(), [&](std::size_t i) {
                                        return mesh_.corners(static_cast<face_id>(i / 3))[i % 3];
                                    }).radius;
        std::vector<face_role> role_of;
        std::size_t leaves = 0;
        for (const mesh_component& piece : pieces.components) {
            const leaf_size& most = options_.leaf;
            const bool is_leaf =
                piece.face_count <= most.triangles &&
                static_cast<double>(piece.face_count) <=
                    most.triangle_share * static_cast<double>(mesh_.face_count()) &&
                piece.area <= most.area_share * area &&
                piece.diameter <= most.diameter_share * diameter;
            role_of.push_back(is_leaf ? face_role::foliage : face_role::solid);
            if (is_leaf) ++leaves;
        }
        for (face_id face = 0; face < mesh_.face_count(); ++face) {
            roles_.of_face[face] = role_of[pieces.of_face[face]];
        }
        roles_.rule = leaves > 0 ? role_rule::component_size : role_rule::none;
        roles_.reason = std::to_string(leaves) + " of " + std::to_string(role_of.size()) +
                        " connected components are as small as leaves";
    }

    void add_area() {
        double all = 0;
        double foliage = 0;
        for (face_id face = 0; face < mesh_.face_count(); ++face) {
            const auto [a, b, c] = mesh_.corners(face);
            const double area = glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)));
            all += area;
            if (roles_.of_face[face] == face_role::foliage) foliage += area;
        }
        roles_.foliage_area_share = all > 0 ? foliage / all : 0;
    }

    const mesh& mesh_;
    const role_options& options_;
    face_roles roles_{};
};

}  // namespace detail

/// Gives every face a role. The first rule that finds foliage decides for all faces: names, where
/// some are given, and nothing else then; materials whose alpha cuts holes; components as small as
/// leaves. An opaque material is solid whatever its texture's alpha says.
///
/// Needs   indices within bounds, as validate() checks.
/// Cost    O(faces + texels of cut-out textures).
[[nodiscard]] inline face_roles find_roles(const mesh& m, const role_options& options = {}) {
    return detail::role_finder(m, options).run();
}

/// What a model is, for who has to choose how to treat it.
enum class model_kind {
    solid,    ///< one search, for closed surfaces
    foliage,  ///< one search, for leaves
    split,    ///< a trunk and its foliage, each to be searched alone
};

struct model_description {
    model_kind kind = model_kind::solid;
    face_roles roles{};
    std::string reason{};  ///< one line for people
};

/// Says what `m` is: solid where less than a tenth of the area is foliage, foliage where hardly
/// anything (a fiftieth) is solid. Small components alone are weak evidence, houses have nails: they
/// count from six tenths of the area and 50 faces on.
[[nodiscard]] inline model_description describe(const mesh& m, const role_options& options = {}) {
    model_description result;
    result.roles = find_roles(m, options);
    const double share = result.roles.foliage_area_share;
    const bool is_weak = result.roles.rule == role_rule::component_size;
    const double least = is_weak ? 0.6 : 0.1;
    const char* kind = "solid";
    if (share >= least && (!is_weak || m.face_count() >= 50)) {
        result.kind = share > 0.98 ? model_kind::foliage : model_kind::split;
        kind = share > 0.98 ? "foliage" : "split into trunk and foliage";
    }
    result.reason = std::string(kind) + ": " + result.roles.reason;
    if (share > 0) result.reason += ", " + detail::percent(share) + " of the area";
    return result;
}

}  // namespace billow::inline BILLOW_ABI
