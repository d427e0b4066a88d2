// Species: a grammar, how it is walked, and what grows on it. Give one to grow() to get a mesh.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include <billow/plants/branch_mesh.hpp>
#include <billow/plants/grammar.hpp>
#include <billow/plants/leaf_mesh.hpp>
#include <billow/plants/skeleton.hpp>
#include <billow/plants/textures.hpp>
#include <billow/plants/turtle.hpp>

namespace billow::inline BILLOW_ABI {

struct species {
    std::string name{};
    grammar rules{};
    unsigned generations = 5;
    double height = 8;  ///< of the highest twig above the ground, in scene units (metres)
    turtle_options turtle{};
    radius_options radii{};
    branch_options branches{};
    leaf_options leaves{};
    bark_image_options bark{};
    leaf_image_options foliage{};
};

/// A broadleaf tree of 8 m and, seed by seed, 15,000 to 23,000 faces: a stem that carries on to the
/// top (A) with limbs at the golden angle, which branch (B) to both sides and rise to the light. A
/// twig keeps its leaves for three generations (L, K, J).
[[nodiscard]] inline species broadleaf() {
    return {.name = "broadleaf",
            .rules = {.axiom = "F(0.45)F(0.45)F(0.45)F(0.45)A",
                      .productions = {{'A',
                                       "F(0.55)[&(62)\"(0.88)$/(90)B]/(137.508)"
                                       "F(0.55)[&(58)\"(0.8)$/(90)B]/(137.508)\"(0.92)A"},
                                      {'B', "FL[&(45)\"B]/(155)\"(0.92)B", 0.72},
                                      {'B', "FL/(155)\"(0.94)B", 0.28},
                                      {'L', "K"},
                                      {'K', "J"},
                                      {'J', ""}},
                      .finish = {{'A', "FL"}, {'B', "FL"}, {'K', "L"}, {'J', "L"}}},
            .generations = 10,
            .turtle = {.shrink = 0.75,
                       .angle_jitter = 0.2,
                       .length_jitter = 0.25,
                       .wander_deg = 6,
                       .tropism = {0, 0.14, 0}},
            .radii = {.trunk = 0.14},
            .leaves = {.per_site = 3.2, .length = 0.34}};
}

/// The tree of the forest paper (see forest_paper_grammar): 4^n segments for n generations.
[[nodiscard]] inline species forest_paper_tree(third_branch spelling = third_branch::turned) {
    return {.name = "forest paper",
            .rules = forest_paper_grammar(spelling),
            .generations = 5,
            .turtle = {.angle_deg = 28, .angle_jitter = 0.25, .length_jitter = 0.25},
            .leaves = {.per_site = 1, .length = 0.7}};
}

namespace detail {

/// The skeleton of a species in its final size.
[[nodiscard]] inline expected<skeleton> grow_skeleton(const species& kind, std::uint64_t seed) {
    if (!(kind.height > 0) || !std::isfinite(kind.height) || !(kind.radii.trunk > 0)) {
        return error{error_code::invalid_options,
                     "a plant's height and trunk radius must be above zero"};
    }
    const auto word = expand(kind.rules, {.generations = kind.generations, .seed = seed});
    if (!word) return word.error();
    auto bones = interpret(*word, kind.turtle, mix_bits(seed));
    if (!bones) return bones;
    if (auto scaled = scale_to_height(*bones, kind.height); !scaled) return scaled.error();
    assign_radii(*bones, kind.radii);
    return bones;
}

}  // namespace detail

/// The species with as many generations and leaves as make a plant of `face_count` faces: at most
/// 60 % of them bark, the others leaves, whose size keeps the crown as dense as it was.
///
/// Gives   a species that grows `face_count` faces, or one less, from this `seed`.
/// Fails   as grow; invalid_options when `face_count` is too small for the species' stem.
[[nodiscard]] inline expected<species> with_face_count(species kind, std::size_t face_count,
                                                       std::uint64_t seed = 1) {
    const auto usual = detail::grow_skeleton(kind, seed);
    if (!usual) return usual.error();
    const double usual_leaves = double(usual->leaf_count()) * kind.leaves.per_site;
    std::size_t bark_faces = 0, sites = 0;
    unsigned best = 0;
    for (unsigned generation = 0;; ++generation) {
        kind.generations = generation;
        const auto bones = detail::grow_skeleton(kind, seed);
        if (!bones) return bones.error();
        mesh bark;
        add_branches(bark, *bones, kind.branches);
        const bool is_first = sites == 0;
        if (bark.face_count() > (is_first ? face_count : face_count * 3 / 5)) break;
        if (!is_first && bark.face_count() <= bark_faces) break;  // a grammar that does not grow
        best = generation;
        bark_faces = bark.face_count();
        sites = bones->leaf_count();
    }
    if (sites == 0) {
        return error{error_code::invalid_options, "no plant of this species has as few as " +
                                                      std::to_string(face_count) +
                                                      " faces, leaves among them"};
    }
    kind.generations = best;
    const std::size_t leaf_quads = (face_count - bark_faces) / 2;
    const auto leaves = static_cast<double>(leaf_quads);
    kind.leaves.per_site = (leaves + 0.5) / double(sites);
    kind.leaves.length *= std::clamp(std::sqrt(usual_leaves / std::max(1.0, leaves)), 0.4, 3.0);
    return kind;
}

/// A plant of the species: bark (material 0, "bark", opaque) and leaves (material 1, "leaf", alpha
/// mask, double-sided). Y is up, the root stands on the origin. The same seed gives the same bytes.
///
/// Fails   as expand, interpret and scale_to_height do; invalid_options for a height or trunk
///         radius of zero or less.
[[nodiscard]] inline expected<mesh> grow(const species& kind, std::uint64_t seed = 1) {
    const auto bones = detail::grow_skeleton(kind, seed);
    if (!bones) return bones.error();
    mesh plant;
    add_branches(plant, *bones, kind.branches, 0);
    leaf_options leaves = kind.leaves;
    leaves.variants = kind.foliage.variants;
    add_leaves(plant, *bones, leaves, 1, mix_bits(seed) + 1);
    plant.images = {bark_image(kind.bark), leaf_image(kind.foliage)};
    plant.materials = {
        {.name = "bark", .base_color_texture = {.image = 0}, .metallic = 0, .roughness = 0.95f},
        {.name = "leaf",
         .base_color_texture = {.image = 1,
                                .wrap_u = texture_wrap::clamp_to_edge,
                                .wrap_v = texture_wrap::clamp_to_edge},
         .metallic = 0,
         .roughness = 0.75f,
         .alpha = alpha_mode::mask,
         .alpha_cutoff = 0.5f,
         .is_double_sided = true}};
    return plant;
}

/// The broadleaf tree with `face_count` faces, or one less: foliage of any size for trials.
///
/// Fails   as with_face_count.
[[nodiscard]] inline expected<mesh> tree_of_about(std::size_t face_count, std::uint64_t seed = 1) {
    const auto kind = with_face_count(broadleaf(), face_count, seed);
    if (!kind) return kind.error();
    return grow(*kind, seed);
}

}  // namespace billow::inline BILLOW_ABI
