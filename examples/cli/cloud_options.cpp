// The options of all verbs that make clouds, and what each changes.

#include "cloud_options.hpp"

#include <algorithm>
#include <cmath>

#include <billow/metrics/nearest_planes.hpp>

#include "names.hpp"
#include "shared.hpp"

namespace cli {

using namespace billow;

namespace {

recipe solid_recipe(const std::string& preset) {
    if (preset == "classic") return recipe_of(presets::classic());
    if (preset == "thesis") return recipe_of(presets::thesis());
    if (preset == "tree") return recipe_of(presets::tree().trunk);
    return recipe_of(presets::solid());
}

recipe foliage_recipe(const std::string& preset) {
    if (preset == "classic") return recipe_of(presets::classic());
    if (preset == "thesis") return recipe_of(presets::thesis(model_kind::foliage));
    if (preset == "tree") return recipe_of(presets::tree().foliage);
    if (preset == "solid") return recipe_of(presets::solid());
    return recipe_of(presets::exact_tree().foliage);
}

recipe trunk_recipe(const std::string& preset) {
    return preset == "auto" ? solid_recipe("tree") : solid_recipe(preset);
}

/// "billboards", "keep" or "reduce:0.2".
std::pair<trunk_use, double> parse_trunk(const std::string& text) {
    if (text == "billboards") return {trunk_use::billboards, 1};
    if (text == "keep") return {trunk_use::keep, 1};
    if (text.starts_with("reduce:")) {
        const double share = parse_share("--trunk", text.substr(7));
        if (share > 0) return {trunk_use::reduce, share};
    }
    throw CLI::ValidationError("--trunk", "'" + text +
                                              "' is neither billboards nor keep nor a share of its "
                                              "triangles such as reduce:20%");
}

/// Sets how a part is welded, before or after its planes are found.
void choose_weld(recipe& how, const std::string& name) {
    how.method.motion.is_welding = name == "online";
    how.options.weld.kind = name == "online" ? weld_kind::none : kind_in(weld_kind_names, name);
}

bool is_given(const CLI::Option* option) { return option->count() > 0; }

/// Divides the number of planes that was asked for: a part gets its share of the roots of the areas,
/// for planes grow slower than area; at least one.
void divide_planes(recipe& foliage, recipe& trunk, double foliage_area_share) {
    const double of_foliage = std::sqrt(foliage_area_share);
    const double of_trunk = std::sqrt(1 - foliage_area_share);
    const auto divide = [&](std::size_t& foliage_planes, std::size_t& trunk_planes) {
        const std::size_t all = foliage_planes;
        if (all == 0) return;
        const double wanted = double(all) * of_trunk / (of_trunk + of_foliage);
        trunk_planes = std::clamp<std::size_t>(std::size_t(std::round(wanted)), 1, all - 1);
        foliage_planes = all - trunk_planes;
    };
    divide(foliage.options.planes, trunk.options.planes);
    divide(foliage.options.search.max_planes, trunk.options.search.max_planes);
}

const CLI::IsMember contribution_names{{"projected", "angular"}};
const CLI::IsMember weld_names{{"none", "first", "intersection", "online"}};

}  // namespace

cloud_options::cloud_options(CLI::App& verb) : verb_(verb) {
    add_preset_options();
    add_plane_options();
    add_density_options();
    add_seam_options();
    add_trunk_options();
    add_texture_options();
}

void cloud_options::check() const {
    for (const bool is_trunk : {false, true}) {
        recipe how = solid_recipe(preset_);
        change_all(how, is_trunk);
        if (how.options.bake.max_atlas <= 2 * how.options.bake.padding + 4) {
            throw CLI::ValidationError("--padding", "leaves no room within --max-atlas");
        }
    }
    const bool is_for_trunk = parse_trunk(trunk_).first != trunk_use::billboards ||
                              std::ranges::any_of(trunk_options_, is_given);
    if (verb_.count("--refine-whole") + verb_.count("--effort") > 0 &&
        verb_.count("--compact") > 0) {
        throw CLI::ValidationError("--refine-whole", "would join what --compact keeps apart");
    }
    if (verb_.count("--trunk-alpha") > 0 && verb_.count("--alpha-threshold") == 0) {
        throw CLI::ValidationError("--trunk-alpha",
                                   "needs --alpha-threshold: without it areas decide");
    }
    if (split_ == "off" && is_for_trunk) {
        throw CLI::ValidationError("--split", "off leaves no trunk for the options of trunks");
    }
    if (!distance_.empty()) static_cast<void>(parse_distance("--distance", distance_));
}

void cloud_options::change_all(recipe& how, bool is_trunk) const {
    for (const change& apply : changes_) apply(how);
    if (!is_trunk) return;
    for (const change& apply : trunk_changes_) apply(how);
}

model_description cloud_options::look_at(const mesh& source) const {
    return describe(source, {.foliage_materials = foliage_materials_});
}

bool cloud_options::wants_split(const model_description& model) const {
    if (split_ != "auto") return split_ == "on";
    const bool is_asked = !foliage_materials_.empty() || trunk_ != "billboards" ||
                          std::ranges::any_of(trunk_options_, is_given);
    const bool is_for_trees = preset_ == "auto" || preset_ == "tree";
    return is_asked || (is_for_trees && model.kind == model_kind::split);
}

model_recipe cloud_options::recipe_for(const mesh& source) const {
    model_recipe how = recipe_of_model(source);
    if (!distance_.empty()) choose_for_distance(source, how);
    return how;
}

void cloud_options::choose_for_distance(const mesh& source, model_recipe& how) const {
    const bounding_sphere bounds = bounding_sphere_of(source);
    const double distance = parse_distance("--distance", distance_).in(bounds);
    if (!(distance > 0)) return;  // radii of a mesh without any
    const viewing_options seen{.distance = distance,
                               .screen = screen_.screen(),
                               .pixel_error = screen_.pixel_error,
                               .texel_error = texel_error_};
    how.view = {seen, choose_for(bounds, seen)};
    apply(how.view->choice, how.whole.options);
    if (how.trunk && verb_.count("--trunk-epsilon") == 0) {
        apply(how.view->choice, how.trunk->options);
    }
}

model_recipe cloud_options::recipe_of_model(const mesh& source) const {
    const model_description model = look_at(source);
    model_recipe result;
    result.preset = preset_;
    if (preset_ == "auto" || split_ == "auto") result.note = model.reason;
    const bool has_both = model.roles.foliage_area_share > 0 && model.roles.foliage_area_share < 1;
    if (!wants_split(model) || !has_both) {
        result.whole = recipe_for_whole(model);
        if (wants_split(model)) result.note = model.reason + "; there is nothing to split";
        return result;
    }
    result.whole = foliage_recipe(preset_);
    change_all(result.whole, false);
    std::tie(result.use, result.reduced_share) = parse_trunk(trunk_);
    const build_options& asked = result.whole.options;
    const bool has_billboards = result.use == trunk_use::billboards;
    if (has_billboards && (asked.planes == 1 || asked.search.max_planes == 1)) {
        result.whole = recipe_for_whole(model);  // one plane is for both
        return result;
    }
    result.trunk = trunk_recipe(preset_);
    change_all(*result.trunk, true);
    result.roles = model.roles;
    if (has_billboards) {
        divide_planes(result.whole, *result.trunk, model.roles.foliage_area_share);
    }
    return result;
}

recipe cloud_options::recipe_for_whole(const mesh& source) const {
    return recipe_for_whole(look_at(source));
}

recipe cloud_options::recipe_for_whole(const model_description& model) const {
    const bool is_solid = model.kind == model_kind::solid;
    recipe how = is_solid ? solid_recipe(preset_) : foliage_recipe(preset_);
    change_all(how, false);
    return how;
}

void cloud_options::add_preset_options() {
    group_ = "Presets";
    verb_
        .add_option(
            "--preset", preset_,
            "What the other options start from. auto: what measures best, for a solid or a tree as "
            "materials and connected components tell: solid, or the exact search for the leaves of "
            "tree, refined as a whole; classic: Decoret et al. 2003; thesis: Luksch 2009; tree: "
            "Fuhrmann et al. 2005, trunk "
            "and foliage apart; solid: the thesis, no face beyond epsilon")
        ->check(CLI::IsMember({"auto", "classic", "thesis", "tree", "solid"}))
        ->capture_default_str()
        ->group(group_);
}

void cloud_options::add_plane_options() {
    group_ = "Planes";
    add<std::string>("--epsilon", "10% for foliage, 5% for solids",
                     "Largest distance of a vertex to its plane: P% of the bounding sphere's "
                     "radius, or a number in scene units",
                     [](recipe& how, const std::string& text) {
                         how.options.epsilon = parse_tolerance("--epsilon", text);
                     });
    CLI::Option* about =
        add<std::size_t>("--planes", "0",
                         "About so many planes: epsilon is searched for; 0: epsilon is as given",
                         [](recipe& how, std::size_t planes) { how.options.planes = planes; })
            ->check(CLI::Range(0, 100000));
    CLI::Option* at_most =
        add<std::size_t>(
            "--max-planes", "0",
            "Most planes, 0: as many as epsilon asks for; faces that are left go to the "
            "plane of least error, beyond epsilon; without cardboard planes, unless "
            "--cardboard is given",
            [](recipe& how, std::size_t most) {
                how.options.search.max_planes = most;
                if (most > 0) how.options.cardboard.min_coverage = 0;
            })
            ->check(CLI::Range(0, 1000000));
    at_most->excludes(about);
    add<std::string>("--plane-space", "cube", "How normals are sampled",
                     [](recipe& how, const std::string& name) {
                         const int raster = how.method.space.resolution();
                         if (name == "spherical") {
                             how.method.space = spherical(raster);
                         } else {
                             how.method.space = cube_map(raster);
                         }
                     })
        ->check(CLI::IsMember({"cube", "spherical"}));
    add<int>("--raster", "18",
             "Normals along a side of the cube, or a quarter of the equator; even",
             [](recipe& how, int raster) {
                 if (how.method.space.is_spherical()) {
                     how.method.space = spherical(raster);
                 } else {
                     how.method.space = cube_map(raster);
                 }
             })
        ->check(CLI::Range(2, 128))
        ->check([](const std::string& text) {
            return std::stoi(text) % 2 == 0 ? std::string() : "the raster must be even";
        });
    add<double>("--rho-rate", "1.5", "Offset bins an epsilon", [](recipe& how, double rate) {
        how.options.search.rho_rate = rate;
    })->check(CLI::Range(0.1, 16.0));
    add<std::string>("--refine", "fail-safe",
                     "From the densest bin to a plane: 216 sub-bins, 64 sub-bins with a fail-safe, "
                     "or its centre",
                     [](recipe& how, const std::string& name) {
                         how.options.search.refine = kind_in(refinement_names, name);
                     })
        ->check(CLI::IsMember(names_in(refinement_names)));
    add<std::string>("--fit", "least-squares; trees: average",
                     "Move planes to their faces, where epsilon allows it",
                     [](recipe& how, const std::string& name) {
                         chosen_fit& fit = how.method.fitter;
                         if (name == "none") fit = no_fit{};
                         if (name == "average") fit = average_fit{};
                         if (name == "svd") fit = svd_fit{};
                         if (name == "least-squares") fit = least_squares_fit{};
                         if (name == "minimax") fit = minimax_fit{};
                     })
        ->check(CLI::IsMember({"none", "average", "svd", "least-squares", "minimax"}));
    add<std::string>(
        "--search", "grid",
        "How planes are looked for: in a density grid, or exactly, offset by offset",
        [](recipe& how, const std::string& name) { how.method.search.is_exact = name == "exact"; })
        ->check(CLI::IsMember({"grid", "exact"}));
    add<double>("--tangency", "0; auto, foliage of trees: 1",
                "Of the exact search: how much more faces count that lie along their plane",
                [](recipe& how, double tangency) { how.method.search.exact.tangency = tangency; })
        ->check(CLI::Range(0.0, 100.0));
    add_flag("--refine-whole",
             "After the search (auto: for foliage of trees) merge and exchange planes, and give "
             "faces to the plane that they lie "
             "along most; not with --weld online or --compact",
             [](recipe& how) { how.options.refines_whole = true; });
    add<std::size_t>("--effort", "24", "Exchanges of planes that --refine-whole tries",
                     [](recipe& how, std::size_t effort) {
                         how.options.whole.effort = effort;
                         how.options.refines_whole = true;
                     })
        ->check(CLI::Range(0, 1000000));
    CLI::Option* coverage = add<std::string>(
        "--coverage", "100%; thesis: 98%",
        "End when planes hold this share of the area; the rest goes to near planes "
        "or is dropped",
        [](recipe& how, const std::string& text) {
            const double share = parse_share("--coverage", text);
            if (share < 0.01) {
                throw CLI::ValidationError("--coverage", "must be 1% at least");
            }
            how.options.search.skip_area = 1 - share;
        });
    add<std::string>("--skip-area", "0%; thesis: 2%",
                     "End when less than this share of the area is left; it goes to near planes or "
                     "is dropped",
                     [](recipe& how, const std::string& text) {
                         how.options.search.skip_area = parse_share("--skip-area", text, 0.99);
                     })
        ->excludes(coverage);
    add<std::string>("--min-contribution", "0%",
                     "End before a plane that would collect less than this share of the area",
                     [](recipe& how, const std::string& text) {
                         how.options.search.min_contribution =
                             parse_share("--min-contribution", text, 0.99);
                     });
}

void cloud_options::add_density_options() {
    group_ = "Density";
    add<std::string>(
        "--contribution", "projected; foliage of trees: angular",
        "What a face is worth on a plane: its projected area, or its area falling with "
        "the angle",
        [](recipe& how, const std::string& name) {
            how.method.policies.contribution.is_angular = name == "angular";
        })
        ->check(contribution_names);
    add<double>(
        "--normal-threshold", "90", "Largest angle between a face and its plane, degrees; 90: any",
        [](recipe& how, double degrees) { how.method.policies.contribution.limit_angle(degrees); })
        ->check(CLI::Range(0.0, 90.0));
    add<double>("--penalty", "3; classic: 10",
                "Weight of faces that a plane just misses on its inner side; 0: none",
                [](recipe& how, double weight) { how.method.policies.penalty.weight = weight; })
        ->check(CLI::Range(0.0, 1000.0));
    add_flag("--penalty-in-refinement", "Charge the penalty in sub-bins, too (classic does)",
             [](recipe& how) { how.options.search.penalty_in_refinement = true; });
    add<std::string>("--falloff", "off; thesis and solid: on; not for the exact search",
                     "Count faces less that lie off a plane; refine: in the refinement only",
                     [](recipe& how, const std::string& name) {
                         how.options.search.falloff = kind_in(falloff_names, name);
                     })
        ->check(CLI::IsMember(names_in(falloff_names)));
    add<double>("--falloff-strength", "1", "1: half at epsilon, 0.25: four fifths, 0: off",
                [](recipe& how, double strength) {
                    how.method.policies.falloff.strength = strength;
                    if (strength == 0) how.options.search.falloff = falloff_use::nowhere;
                })
        ->check(CLI::Range(0.0, 100.0));
    add<std::string>(
        "--horizontal-penalty", "0%; foliage of trees: 60%",
        "Share of their density that horizontal planes lose, for viewers on the ground",
        [](recipe& how, const std::string& text) {
            how.method.policies.bias.horizontal_share = parse_share("--horizontal-penalty", text);
        });
    add<std::string>("--fly-over", "0%",
                     "Share of their density that vertical planes lose, for viewers above",
                     [](recipe& how, const std::string& text) {
                         how.method.policies.bias.vertical_share = parse_share("--fly-over", text);
                     });
    add<std::string>("--up", "y", "The axis that points up, for these two",
                     [](recipe& how, const std::string& axis) {
                         how.method.policies.bias.up =
                             dvec3(axis == "x" ? 1 : 0, axis == "y" ? 1 : 0, axis == "z" ? 1 : 0);
                     })
        ->check(CLI::IsMember({"x", "y", "z"}));
    add<double>(
        "--distribution", "0",
        "Share of their density that planes parallel to earlier ones lose; 0.3 spreads them",
        [](recipe& how, double strength) { how.options.search.distribution.strength = strength; })
        ->check(CLI::Range(0.0, 1.0));
}

void cloud_options::add_seam_options() {
    group_ = "Between planes";
    add_flag("--compact", "A plane takes one group of faces that lie together (classic does)",
             [](recipe& how) {
                 how.method.grouping.is_compact = true;
                 how.options.refines_whole = false;  // it would join what lies apart
             });
    add<std::string>("--weld", "none; solids: intersection, trunks: online",
                     "Move vertices where planes meet: onto their first plane, onto the common "
                     "intersection, or while planes are searched",
                     choose_weld)
        ->check(weld_names);
    add<double>("--weld-angle", "15", "Least angle between planes that are welded, degrees",
                [](recipe& how, double degrees) {
                    how.options.weld.min_angle = degrees * std::numbers::pi / 180;
                })
        ->check(CLI::Range(1.0, 90.0));
    add<std::string>("--cardboard", "0%; trunks: 80%",
                     "Give thin parts a second plane across where it shows this share; 0%: none",
                     [](recipe& how, const std::string& text) {
                         how.options.cardboard.min_coverage = parse_share("--cardboard", text);
                     });
    add<std::string>("--cracks", "none",
                     "envelope: draw faces that reach into another plane's slab there, too",
                     [](recipe& how, const std::string& name) {
                         how.options.bake.draw.cracks = kind_in(crack_names, name);
                     })
        ->check(CLI::IsMember(names_in(crack_names)));
}

void cloud_options::add_trunk_options() {
    group_ = "Trunk and foliage";
    verb_
        .add_option(
            "--split", split_,
            "Search trunk and foliage apart; auto: where the preset is auto or tree and the "
            "model has both, or another option of this group is given")
        ->check(CLI::IsMember({"auto", "on", "off"}))
        ->capture_default_str()
        ->group(group_);
    verb_
        .add_option("--foliage-materials", foliage_materials_,
                    "Names of the materials that are foliage, e.g. \"leaf*\"; without it alpha and "
                    "the size of connected components tell")
        ->group(group_);
    verb_
        .add_option(
            "--trunk", trunk_,
            "billboards; keep: the trunk stays a mesh; reduce:0.2: a mesh of a fifth of its "
            "triangles")
        ->capture_default_str()
        ->group(group_);
    add_for_trunk<std::string>("--trunk-epsilon", "as --epsilon", "--epsilon of the trunk",
                               [](recipe& how, const std::string& text) {
                                   how.options.epsilon = parse_tolerance("--trunk-epsilon", text);
                               });
    add_for_trunk<std::string>("--trunk-contribution", "projected", "--contribution of the trunk",
                               [](recipe& how, const std::string& name) {
                                   how.method.policies.contribution.is_angular = name == "angular";
                               })
        ->check(contribution_names);
    add_for_trunk<std::string>("--trunk-weld", "online", "--weld of the trunk", choose_weld)
        ->check(weld_names);
    add_for_trunk<std::string>("--trunk-cardboard", "80%", "--cardboard of the trunk",
                               [](recipe& how, const std::string& text) {
                                   how.options.cardboard.min_coverage =
                                       parse_share("--trunk-cardboard", text);
                               });
    add_for_trunk<std::string>("--trunk-alpha", "30%, opaque materials 50%",
                               "--alpha-threshold of the trunk, where that is given",
                               [](recipe& how, const std::string& text) {
                                   const double share = parse_share("--trunk-alpha", text);
                                   how.options.bake.alpha.thresholds = {share, share};
                               });
}

void cloud_options::add_texture_options() {
    group_ = "Textures";
    CLI::Option* texels =
        add<int>("--texels", "512", "Texels along the diameter of the bounding sphere",
                 [](recipe& how, int count) { how.options.bake.texels = count; })
            ->check(CLI::Range(1, 65536));
    add<double>("--texels-per-unit", "0", "Texels along a scene unit; 0: as --texels says",
                [](recipe& how, double count) { how.options.bake.texels_per_unit = count; })
        ->check(CLI::Range(0.0, 1e9))
        ->excludes(texels);
    add<int>("--max-atlas", "4096", "Longest side of an atlas, texels", [](recipe& how, int side) {
        how.options.bake.max_atlas = side;
    })->check(CLI::Range(64, 16384));
    add<int>("--atlases", "0", "Most atlases: texels become coarser until all fit; 0: any number",
             [](recipe& how, int count) { how.options.bake.max_atlases = count; })
        ->check(CLI::Range(0, 1000));
    add<int>("--supersample", "4", "Samples along a texel's side", [](recipe& how, int samples) {
        how.options.bake.draw.supersample = samples;
    })->check(CLI::Range(1, max_supersample));
    add_texture_looks();
    add<int>("--padding", "8", "Texels between tiles; 2^n keep n mip levels apart",
             [](recipe& how, int count) { how.options.bake.padding = count; })
        ->check(CLI::Range(0, 256));
    add_flag("--power-of-two", "Make the atlas' sides powers of two",
             [](recipe& how) { how.options.bake.power_of_two = true; });
}

void cloud_options::add_distance_options() {
    group_ = "Distance";
    CLI::Option* distance =
        verb_
            .add_option("--distance", distance_,
                        "Choose epsilon and texels for a cloud that is seen from there: the eye's "
                        "distance to the centre of the bounding sphere, in scene units, 40 or 40m, "
                        "or in radii, 12R")
            ->group(group_);
    for (const char* chosen : {"--epsilon", "--planes", "--texels", "--texels-per-unit"}) {
        distance->excludes(verb_.get_option(chosen));
    }
    add_screen_options(verb_, screen_, group_, "Pixels that a vertex may be off there");
    verb_.add_option("--texel-error", texel_error_, "Pixels that a texel may cover there")
        ->check(CLI::Range(0.01, 1000.0))
        ->capture_default_str()
        ->group(group_);
    for (const char* of_it : {"--pixel-error", "--screen", "--fov", "--texel-error"}) {
        verb_.get_option(of_it)->needs(distance);
    }
}

void cloud_options::add_texture_looks() {
    add<std::string>("--alpha", "binary",
                     "What alpha holds: 0 or 1, the covered share, or the signed distance to the "
                     "outline; all for an alpha test at a half",
                     [](recipe& how, const std::string& name) {
                         how.options.bake.alpha.kind = kind_in(alpha_names, name);
                     })
        ->check(CLI::IsMember(names_in(alpha_names)));
    CLI::Option* area =
        add<std::string>(
            "--alpha-area", "covered",
            "Opaque area of a tile: what the faces cover, seen along its normal; their "
            "own surface, so that tilted leaves keep theirs; or as "
            "--alpha-threshold gives",
            [](recipe& how, const std::string& name) {
                how.options.bake.alpha.area = kind_in(area_names, name);
            })
            ->check(CLI::IsMember(names_in(area_names)));
    add<std::string>("--alpha-threshold", "30%, opaque materials 50%",
                     "Covered share from which a texel is opaque, whatever the area",
                     [](recipe& how, const std::string& text) {
                         const double share = parse_share("--alpha-threshold", text);
                         how.options.bake.alpha.thresholds = {share, share};
                         how.options.bake.alpha.area = opaque_area::thresholds;
                     })
        ->excludes(area);
    add<std::string>("--normals", "folded",
                     "folded: of the front, on a double-sided polygon; sheets: front and back on "
                     "polygons of their own; object: in scene space; dome: in scene space, blended "
                     "with the directions out of the crown",
                     [](recipe& how, const std::string& name) {
                         how.options.bake.draw.normals = kind_in(normal_names, name);
                     })
        ->check(CLI::IsMember(names_in(normal_names)));
    add<std::string>("--dome", "80%",
                     "Weight of the directions out of the crown, for --normals dome",
                     [](recipe& how, const std::string& text) {
                         how.options.bake.draw.dome = parse_share("--dome", text);
                     });
    add<std::string>("--sides", "one",
                     "Tiles a billboard; auto: two where its front and back look different",
                     [](recipe& how, const std::string& name) {
                         how.options.bake.sides = kind_in(side_names, name);
                     })
        ->check(CLI::IsMember(names_in(side_names)));
    add<std::string>("--outline", "rect",
                     "Polygons around what is opaque: rectangles, or of up to so many corners",
                     [](recipe& how, const std::string& name) {
                         how.options.bake.outline_corners = name == "rect" ? 0 : std::stoi(name);
                     })
        ->check(CLI::IsMember({"rect", "4", "5", "6", "7", "8"}));
    add<int>("--occlusion", "0",
             "Rays to the sky from each point: darkens what sees little of it; 0: none",
             [](recipe& how, int rays) { how.options.bake.occlusion.rays = rays; })
        ->check(CLI::Range(0, 4096));
}

}  // namespace cli
