// Presets: the published ways to make a billboard cloud, by name, and ours.
//
// Each reads like the parameter table of its paper. A preset is a value: change what you like before
// you give its options and its method to build_cloud.
#pragma once

#include <billow/density/rasterize.hpp>
#include <billow/fit/average.hpp>
#include <billow/fit/fit.hpp>
#include <billow/fit/least_squares.hpp>
#include <billow/mesh/roles.hpp>
#include <billow/pipeline.hpp>
#include <billow/plane_space/cube_map.hpp>
#include <billow/plane_space/spherical.hpp>
#include <billow/policy/falloff.hpp>
#include <billow/policy/orientation_bias.hpp>
#include <billow/search/compact.hpp>
#include <billow/search/weld_online.hpp>

namespace billow::inline BILLOW_ABI {

/// What a preset fixes: values in `options`, types in `method`.
template <class Pipeline>
struct preset {
    build_options options{};
    Pipeline method{};
};
template <class Pipeline>
preset(build_options, Pipeline) -> preset<Pipeline>;

/// A preset for trees, whose foliage and trunk are searched apart.
template <class Foliage, class Trunk>
struct tree_preset {
    Foliage foliage{};
    Trunk trunk{};
};
template <class Foliage, class Trunk>
tree_preset(Foliage, Trunk) -> tree_preset<Foliage, Trunk>;

namespace presets {

/// Billboard clouds as first published: penalty 10, also inside the refinement into 216 sub-bins;
/// planes as they are found; compact textures.
///
/// Source  Décoret, Durand, Sillion, Dorsey: Billboard clouds for extreme model simplification.
///         SIGGRAPH 2003. Differs: 2,593 normals, which they do not state.
[[nodiscard]] inline auto classic() {
    build_options options;
    options.epsilon = tolerance::of_radius(0.05);
    options.search.refine = refinement::original;
    options.search.penalty_in_refinement = true;
    return preset{options, pipeline{spherical(18),
                                    density_policies{intersection_of_vertices{}, projected_area{},
                                                     inner_side_penalty{10}},
                                    no_fit{}, heaviest_group{}}};
}

/// The thesis that put billboard clouds right: raster 18, 1.5 offset bins an epsilon, penalty 3,
/// distance falloff, least squares; the last 2 % of the area are not worth a plane; the cracks of
/// solids are welded.
///
/// Source  Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
///         table 5.7. Differs: a fitted plane keeps epsilon.
[[nodiscard]] inline auto thesis(model_kind kind = model_kind::solid) {
    build_options options;
    options.epsilon = tolerance::of_radius(0.05);
    options.search.rho_rate = 1.5;
    options.search.refine = refinement::fail_safe;
    options.search.skip_area = 0.02;
    options.weld.kind = kind == model_kind::solid ? weld_kind::intersection : weld_kind::none;
    return preset{options, pipeline{cube_map(18),
                                    density_policies{hull_of_samples{}, projected_area{},
                                                     inner_side_penalty{3}, distance_falloff{}},
                                    least_squares_fit{}}};
}

/// Trees: angular contribution for leaves, horizontal planes held back by 60 % from 50° on, texels
/// opaque from 0.3; the trunk is welded while it is searched, and thin parts of it get cardboard
/// planes where these show 80 %.
///
/// Source  Fuhrmann, Umlauf, Mantler: Extreme model simplification for forest rendering. Eurographics
///         Workshop on Natural Phenomena 2005, section 3.3.
[[nodiscard]] inline auto tree() {
    build_options foliage;
    foliage.epsilon = tolerance::of_radius(0.1);
    foliage.bake.alpha.thresholds.foliage = 0.3;
    build_options trunk = foliage;
    trunk.cardboard.min_coverage = 0.8;
    return tree_preset{
        preset{foliage,
               pipeline{cube_map(18),
                        density_policies{hull_of_samples{}, angular_area{}, inner_side_penalty{3},
                                         no_falloff{},
                                         horizontal_penalty{.share = 0.60, .cutoff_deg = 50}},
                        average_fit{}}},
        preset{trunk, pipeline{cube_map(18),
                               density_policies{hull_of_samples{}, projected_area{},
                                                inner_side_penalty{3}},
                               average_fit{}, whole_set{}, weld_online{}}}};
}

/// Solids, ours: the thesis's, but every face keeps epsilon.
[[nodiscard]] inline auto solid() {
    auto made = thesis(model_kind::solid);
    made.options.search.skip_area = 0;
    return made;
}

/// Trees, what measures best: leaves by exact offsets, frontal ones counting more, then refinement of
/// the whole; the trunk as in tree().
[[nodiscard]] inline auto exact_tree() {
    const auto from = tree();
    build_options foliage = from.foliage.options;
    foliage.refines_whole = true;
    return tree_preset{
        preset{foliage, pipeline{cube_map(18), from.foliage.method.policies, average_fit{},
                                 whole_set{}, fixed_vertices{}, exact_method{.tangency = 1}}},
        from.trunk};
}

}  // namespace presets

/// Makes a cloud of a tree: roles tell its faces apart.
///
/// Needs, Fails, Cost  as build_cloud for parts.
template <class Foliage, class Trunk>
[[nodiscard]] expected<build_result> build_tree(const mesh& source, const face_roles& roles,
                                                const tree_preset<Foliage, Trunk>& how,
                                                const build_options& options,
                                                const progress_function& progress = {}) {
    return build_cloud(
        source, options, progress,
        part_plan{roles.faces_of(face_role::foliage), how.foliage.options, how.foliage.method},
        part_plan{roles.faces_of(face_role::solid), how.trunk.options, how.trunk.method});
}

}  // namespace billow::inline BILLOW_ABI
