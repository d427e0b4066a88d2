// What the tool tells of a cloud that it has made.

#include "report.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

#include <nlohmann/json.hpp>

#include <billow/bake/mips.hpp>
#include <billow/metrics/geometric_error.hpp>

#include "names.hpp"

namespace cli {

using json = nlohmann::ordered_json;
using namespace billow;

namespace {

/// As --epsilon takes it.
std::string text_of(const tolerance& length) {
    char text[40];
    std::snprintf(text, sizeof text, length.is_of_radius ? "%.6g%%" : "%.6g",
                  length.is_of_radius ? 100 * length.value : length.value);
    return text;
}

/// Without the noise of the way to radians and back.
double degrees_of(double radians) {
    return std::round(radians * (180 / std::numbers::pi) * 1e4) / 1e4;
}

json options_json(const recipe& how) {
    const build_options& options = how.options;
    const tool_policies& density = how.method.policies;
    json chosen;
    chosen["epsilon"] = text_of(options.epsilon);
    chosen["planes"] = options.planes;
    chosen["max_planes"] = options.search.max_planes;
    chosen["plane_space"] = how.method.space.is_spherical() ? "spherical" : "cube";
    chosen["raster"] = how.method.space.resolution();
    chosen["rho_rate"] = options.search.rho_rate;
    chosen["contribution"] = density.contribution.is_angular ? "angular" : "projected";
    chosen["normal_threshold"] =
        degrees_of(std::acos(static_cast<double>(density.contribution.least_cosine)));
    chosen["penalty"] = density.penalty.weight;
    chosen["penalty_in_refinement"] = options.search.penalty_in_refinement;
    chosen["falloff"] = name_in(falloff_names, options.search.falloff);
    chosen["falloff_strength"] = density.falloff.strength;
    chosen["horizontal_penalty"] = density.bias.horizontal_share;
    chosen["fly_over"] = density.bias.vertical_share;
    chosen["up"] = density.bias.up.x > 0 ? "x" : density.bias.up.y > 0 ? "y" : "z";
    chosen["distribution"] = options.search.distribution.strength;
    chosen["refine"] = name_in(refinement_names, options.search.refine);
    chosen["fit"] = how.method.fitter.name();
    chosen["search"] = how.method.search.is_exact ? "exact" : "grid";
    chosen["tangency"] = how.method.search.exact.tangency;
    chosen["refine_whole"] = options.refines_whole;
    chosen["effort"] = options.whole.effort;
    chosen["skip_area"] = options.search.skip_area;
    chosen["min_contribution"] = options.search.min_contribution;
    chosen["compact"] = how.method.grouping.is_compact;
    chosen["weld"] = how.method.motion.is_welding ? std::string("online")
                                                  : name_in(weld_kind_names, options.weld.kind);
    chosen["weld_angle"] = degrees_of(options.weld.min_angle);
    chosen["cardboard"] = options.cardboard.min_coverage;
    return chosen;
}

json textures_json(const bake_options& options) {
    json chosen;
    chosen["texels"] = options.texels;
    chosen["max_atlas"] = options.max_atlas;
    chosen["max_atlases"] = options.max_atlases;
    chosen["supersample"] = options.draw.supersample;
    chosen["padding"] = options.padding;
    chosen["power_of_two"] = options.power_of_two;
    chosen["alpha"] = name_in(alpha_names, options.alpha.kind);
    chosen["alpha_area"] = name_in(area_names, options.alpha.area);
    chosen["normals"] = name_in(normal_names, options.draw.normals);
    chosen["sides"] = name_in(side_names, options.sides);
    chosen["outline_corners"] = options.outline_corners;
    chosen["occlusion_rays"] = options.occlusion.rays;
    chosen["cracks"] = name_in(crack_names, options.draw.cracks);
    return chosen;
}

json search_json(const greedy_statistics& search) {
    json told;
    told["mean_refinement_level"] = search.mean_refinement_level();
    told["refined_planes"] = search.refined_planes;
    told["fail_safes"] = search.fail_safes;
    told["tweaks"] = search.tweaks;
    told["leftover_faces"] = search.leftover_faces;
    told["leftover_area_share"] = search.leftover_area_share;
    told["dropped_faces"] = search.dropped_faces;
    told["dropped_area_share"] = search.dropped_area_share;
    told["beyond_epsilon_area_share"] = search.beyond_epsilon_area_share;
    return told;
}

json welding_json(const build_result& result) {
    json told;
    told["torn_vertices"] = result.weld.torn_vertices;
    told["moved_vertices"] = result.weld.moved_vertices;
    told["welded_vertices"] = result.weld.welded_vertices;
    told["largest_displacement"] = result.weld.largest_displacement;
    const auto tell_cracks = [&](const char* when, const cloud_cracks& cracks) {
        json& state = told[when];
        state["edge_length"] = cracks.edge_length;
        state["torn_length"] = cracks.torn_length;
        state["area"] = cracks.area;
    };
    if (result.moved.empty()) return told;  // cracks are not measured
    tell_cracks("cracks_before", result.cracks);
    tell_cracks("cracks_after", result.cracks_drawn);
    return told;
}

/// How far vertices are off, seen from where the cloud is for.
geometric_errors seen_errors(const finished_build& of) {
    const viewing_options& seen = of.how.view->seen;
    return geometric_error(of.loaded.mesh, of.result.cloud, of.result.moved,
                           {seen.distance, seen.screen});
}

json view_json(const finished_build& of) {
    const viewing_options& seen = of.how.view->seen;
    const viewing_choice& choice = of.how.view->choice;
    const double radius = of.result.cloud.bounds.radius;
    json told;
    told["distance"] = seen.distance;
    told["screen"] = seen.screen.height_px;
    told["fov"] = degrees_of(seen.screen.fov_y);
    told["pixel_error"] = seen.pixel_error;
    told["texel_error"] = seen.texel_error;
    told["pixel"] = choice.pixel;
    told["wanted_epsilon"] = choice.wanted_epsilon;
    told["epsilon"] = choice.epsilon;
    told["wanted_texel_size"] = choice.wanted_texel_size;
    told["texel_size"] = choice.texel_size;
    told["texels"] = 2 * radius / choice.texel_size;
    told["epsilon_px"] = choice.error_px;
    told["texel_px"] = choice.texel_px;
    told["object_px"] = choice.object_px;
    const geometric_errors errors = seen_errors(of);
    told["mean_error_px"] = errors.mean_px;
    told["max_error_px"] = errors.max_px;
    return told;
}

/// What was chosen for a distance, why, and what came of it.
void print_view(const finished_build& of) {
    const viewing_options& seen = of.how.view->seen;
    const viewing_choice& choice = of.how.view->choice;
    const double radius = of.result.cloud.bounds.radius;
    std::printf(
        "distance: at %.4g a pixel shows %.4g: epsilon %.4g (%.3g %% of the radius), texels of "
        "%.4g, %.0f along the diameter\n",
        seen.distance, choice.pixel, choice.epsilon,
        radius > 0 ? 100 * choice.epsilon / radius : 0.0, choice.texel_size,
        2 * radius / choice.texel_size);
    const double off = seen_errors(of).max_px;
    std::printf(
        "distance: the object is %.0f pixels high there; vertices are off by %.3g pixels at "
        "most%s\n",
        choice.object_px, off,
        off > 1.001 * choice.error_px ? ", some beyond epsilon: welding moves them" : "");
    if (choice.epsilon > choice.wanted_epsilon) {
        std::printf(
            "note: epsilon stays at %.3g %% of the radius, which covers %.3g pixels there; closer "
            "than %.4g draw the mesh\n",
            100 * choice.epsilon / radius, choice.error_px,
            distance_for_pixels(choice.epsilon, radius, seen.pixel_error, seen.screen));
    } else if (choice.epsilon < choice.wanted_epsilon) {
        std::printf("note: epsilon stays at %.3g %% of the radius, where %.3g %% would do\n",
                    100 * choice.epsilon / radius, 100 * choice.wanted_epsilon / radius);
    }
    if (choice.texel_size > choice.wanted_texel_size) {
        std::printf("note: texels stay at %.0f along the diameter and cover %.3g pixels there\n",
                    2 * radius / choice.texel_size, choice.texel_px);
    }
}

json refined_json(const whole_refinement_report& refined) {
    json told;
    told["planes_before"] = refined.planes_before;
    told["planes_after"] = refined.planes_after;
    told["merged_planes"] = refined.merged_planes;
    told["exchanges_tried"] = refined.exchanges.tried;
    told["exchanges_made"] = refined.exchanges.made;
    told["moved_faces"] = refined.moved_faces;
    told["projected_area_share_before"] = refined.projected_area_share_before;
    told["projected_area_share_after"] = refined.projected_area_share_after;
    return told;
}

json parts_json(const finished_build& of) {
    json parts = json::array();
    for (std::size_t i = 0; i < of.result.parts.size(); ++i) {
        const part_result& part = of.result.parts[i];
        const bool is_trunk = of.how.trunk && i == 1;
        json told;
        told["name"] = is_trunk ? "trunk" : of.how.trunk ? "foliage" : "whole";
        told["planes"] = part.plane_count;
        told["cardboard_planes"] = part.cardboard_planes;
        told["epsilon"] = part.epsilon;
        told["mapped_faces"] = part.faces.mapped;
        told["search"] = search_json(part.statistics);
        if (part.refined.planes_before > 0) told["refined"] = refined_json(part.refined);
        told["curve"]["covered_area"] = part.curve.covered_area;
        told["curve"]["mean_error"] = part.curve.mean_error;
        told["options"] = options_json(is_trunk ? *of.how.trunk : of.how.whole);
        parts.push_back(std::move(told));
    }
    return parts;
}

}  // namespace

/// Filled field by field: one long initialiser list of JSON takes compilers minutes.
std::string report_json(const finished_build& of) {
    const build_result& result = of.result;
    const cloud_errors& errors = result.errors;
    const double epsilon = result.cloud.epsilon;
    const std::size_t faces = of.loaded.mesh.face_count();

    json report;
    report["generator"] = "billow " BILLOW_VERSION;
    report["faces"] = faces;
    report["planes"] = result.cloud.plane_count();
    report["triangles"] = of.triangles;
    report["epsilon"] = epsilon;
    report["radius"] = result.cloud.bounds.radius;
    report["max_error"] = errors.max_error;
    report["mean_error"] = errors.mean_error;
    report["max_error_over_epsilon"] = epsilon > 0 ? errors.max_error / epsilon : 0.0;
    report["projected_area_share"] = errors.projected_area_share;
    report["rectangle_use"] = errors.rectangle_use;
    report["mapped_faces"] = result.faces.mapped;
    report["kept_faces"] = result.faces.kept;
    report["kept_triangles"] = result.kept.face_count();
    report["skipped_faces"] = result.faces.dropped;
    report["degenerate_faces"] = result.faces.degenerate;
    report["faces_beyond_epsilon"] = errors.faces_beyond_epsilon;
    report["preset"] = of.how.preset;
    report["model"] = of.how.note;
    if (of.how.view) report["viewing"] = view_json(of);
    report["search"] = search_json(result.statistics);
    report["welding"] = welding_json(result);
    report["parts"] = parts_json(of);

    const auto& atlases = result.baked.atlases;
    json& atlas = report["atlas"];
    atlas["width"] = atlases.empty() ? 0 : atlases.front().width();
    atlas["height"] = atlases.empty() ? 0 : atlases.front().height();
    atlas["fill"] = result.baked.fill;
    atlas["count"] = atlases.size();
    atlas["texel_size"] = result.baked.texel_size;
    atlas["wanted_texel_size"] = result.baked.wanted_size;
    atlas["tiles"] = result.baked.tiles.size();
    atlas["safe_mip_levels"] =
        atlases.empty() ? 0
                        : safe_mip_levels(of.how.whole.options.bake.padding,
                                          atlases.front().width(), atlases.front().height());
    atlas["overdraw"] = result.baked.overdraw();

    json& seconds = report["seconds"];
    seconds["load"] = of.seconds.load;
    seconds["search"] = result.search_seconds;
    seconds["bake"] = result.bake_seconds;
    seconds["write"] = of.seconds.write;
    seconds["total"] = of.seconds.total;
    report["threads"] = of.how.whole.options.threads.count();
    report["notes"] = of.loaded.notes;
    report["textures"] = textures_json(of.how.whole.options.bake);
    return report.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

void print_summary(const finished_build& of) {
    const build_result& result = of.result;
    const double epsilon = result.cloud.epsilon;
    for (const std::string& note : of.loaded.notes) std::printf("note: %s\n", note.c_str());
    if (!of.how.note.empty()) {
        std::printf("%s: %s\n", of.how.preset.c_str(), of.how.note.c_str());
    }
    if (of.how.view) print_view(of);
    const std::size_t kept = result.kept.face_count();
    std::printf("%s: %zu faces -> %zu planes, %zu triangles%s\n", of.input.string().c_str(),
                of.loaded.mesh.face_count(), result.cloud.plane_count(), of.triangles,
                kept > 0 ? (" with " + std::to_string(kept) + " of the trunk").c_str() : "");
    std::printf("error: largest %.4g (%.3f epsilon), mean %.4g; epsilon %.4g, radius %.4g\n",
                result.errors.max_error, epsilon > 0 ? result.errors.max_error / epsilon : 0.0,
                result.errors.mean_error, epsilon, result.cloud.bounds.radius);
    for (const atlas& a : result.baked.atlases) {
        std::printf("atlas: %d x %d texels of %.4g, %.0f %% filled\n", a.width(), a.height(),
                    result.baked.texel_size, 100 * result.baked.fill);
    }
    const greedy_statistics& search = result.statistics;
    if (result.errors.faces_beyond_epsilon > 0) {
        std::printf("note: %zu faces, %.3g %% of the area, are beyond epsilon\n",
                    result.errors.faces_beyond_epsilon, 100 * search.beyond_epsilon_area_share);
    }
    if (search.dropped_faces > 0) {
        std::printf("note: %zu faces, %.3g %% of the area, are far from all planes and dropped\n",
                    search.dropped_faces, 100 * search.dropped_area_share);
    }
    const double wanted = result.baked.wanted_size;
    if (result.baked.texel_size > 1.001 * wanted) {
        std::printf("note: texels are %.2f times larger than asked for, to fit %s\n",
                    result.baked.texel_size / wanted,
                    of.how.whole.options.bake.max_atlases > 0 ? "--max-atlas and --atlases"
                                                              : "--max-atlas");
    }
    std::printf("wrote %s in %.2f s\n", of.output.string().c_str(), of.seconds.total);
}

}  // namespace cli
