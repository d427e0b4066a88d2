// What the tool tells of a cloud that it has made.

#include "report.hpp"

#include <cstdio>

#include <nlohmann/json.hpp>

namespace cli {

using json = nlohmann::ordered_json;
using namespace billow;

namespace {

const char* name_of(refinement kind) {
    switch (kind) {
        case refinement::original:
            return "original";
        case refinement::fail_safe:
            return "fail-safe";
        case refinement::none:
            return "none";
    }
    return "";
}

/// As --epsilon takes it.
std::string text_of(const tolerance& length) {
    char text[40];
    std::snprintf(text, sizeof text, length.is_of_radius ? "%.6g%%" : "%.6g",
                  length.is_of_radius ? 100 * length.value : length.value);
    return text;
}

json options_json(const recipe& how) {
    const build_options& options = how.options;
    json chosen;
    chosen["epsilon"] = text_of(options.epsilon);
    chosen["max_planes"] = options.search.max_planes;
    chosen["plane_space"] = how.is_spherical ? "spherical" : "cube";
    chosen["raster"] = how.raster;
    chosen["rho_rate"] = options.search.rho_rate;
    chosen["penalty"] = how.penalty;
    chosen["refine"] = name_of(options.search.refine);
    chosen["fit"] = how.fit;
    chosen["texels"] = options.bake.texels;
    chosen["max_atlas"] = options.bake.max_atlas;
    chosen["supersample"] = options.bake.supersample;
    chosen["padding"] = options.bake.padding;
    chosen["power_of_two"] = options.bake.power_of_two;
    return chosen;
}

}  // namespace

/// Filled field by field: one long initialiser list of JSON takes compilers minutes.
std::string report_json(const finished_build& of) {
    const build_result& result = of.result;
    const cloud_errors& errors = result.errors;
    const greedy_statistics& search = result.statistics;
    const double epsilon = result.cloud.epsilon;
    const std::size_t faces = of.loaded.mesh.face_count();

    json report;
    report["generator"] = "billow " BILLOW_VERSION;
    report["faces"] = faces;
    report["planes"] = result.cloud.plane_count();
    report["triangles"] = 2 * result.cloud.plane_count();
    report["epsilon"] = epsilon;
    report["radius"] = result.cloud.bounds.radius;
    report["max_error"] = errors.max_error;
    report["mean_error"] = errors.mean_error;
    report["max_error_over_epsilon"] = epsilon > 0 ? errors.max_error / epsilon : 0.0;
    report["projected_area_share"] = errors.projected_area_share;
    report["mapped_faces"] = errors.mapped_faces;
    report["skipped_faces"] = faces - errors.mapped_faces - search.degenerate_faces;
    report["degenerate_faces"] = search.degenerate_faces;
    report["leftover_faces"] = search.leftover_faces;
    report["faces_beyond_epsilon"] = errors.faces_beyond_epsilon;
    json& refined = report["refinement"];
    refined["levels"] = search.refinement_levels;
    refined["fail_safes"] = search.fail_safes;
    refined["tweaks"] = search.tweaks;

    const auto& atlases = result.baked.atlases;
    json& atlas = report["atlas"];
    atlas["width"] = atlases.empty() ? 0 : atlases.front().width();
    atlas["height"] = atlases.empty() ? 0 : atlases.front().height();
    atlas["fill"] = result.baked.fill;
    atlas["count"] = atlases.size();
    atlas["texel_size"] = result.baked.texel_size;

    json& seconds = report["seconds"];
    seconds["load"] = of.seconds.load;
    seconds["search"] = result.search_seconds;
    seconds["bake"] = result.bake_seconds;
    seconds["write"] = of.seconds.write;
    seconds["total"] = of.seconds.total;
    report["threads"] = of.how.options.threads.count();
    report["notes"] = of.loaded.notes;
    report["options"] = options_json(of.how);
    return report.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

void print_summary(const finished_build& of) {
    const build_result& result = of.result;
    const double epsilon = result.cloud.epsilon;
    for (const std::string& note : of.loaded.notes) std::printf("note: %s\n", note.c_str());
    std::printf("%s: %zu faces -> %zu planes, %zu triangles\n", of.input.string().c_str(),
                of.loaded.mesh.face_count(), result.cloud.plane_count(),
                2 * result.cloud.plane_count());
    std::printf("error: largest %.4g (%.3f epsilon), mean %.4g; epsilon %.4g, radius %.4g\n",
                result.errors.max_error, epsilon > 0 ? result.errors.max_error / epsilon : 0.0,
                result.errors.mean_error, epsilon, result.cloud.bounds.radius);
    for (const atlas& a : result.baked.atlases) {
        std::printf("atlas: %d x %d texels of %.4g, %.0f %% filled\n", a.width(), a.height(),
                    result.baked.texel_size, 100 * result.baked.fill);
    }
    if (result.errors.faces_beyond_epsilon > 0) {
        std::printf("note: --max-planes leaves %zu faces beyond epsilon\n",
                    result.errors.faces_beyond_epsilon);
    }
    const double wished = 2 * result.cloud.bounds.radius / of.how.options.bake.texels;
    if (result.baked.texel_size > 1.001 * wished) {
        std::printf("note: texels are %.2f times larger than asked for, to fit --max-atlas\n",
                    result.baked.texel_size / wished);
    }
    std::printf("wrote %s in %.2f s\n", of.output.string().c_str(), of.seconds.total);
}

}  // namespace cli
