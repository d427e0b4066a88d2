#include "clouds.hpp"

#include <ctime>
#include <deque>
#include <limits>

#include <billow/bake/bake_cloud.hpp>
#include <billow/bake/cloud_mesh.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/improve/drawn_mesh.hpp>
#include <billow/improve/refine_whole.hpp>
#include <billow/metrics/camera.hpp>
#include <billow/metrics/geometric_error.hpp>
#include <billow/metrics/render.hpp>
#include <billow/metrics/view_directions.hpp>
#include <billow/metrics/view_errors.hpp>
#include <billow/presets.hpp>
#include <billow/search/plane_budget.hpp>

namespace thesis {

namespace {

/// Searches run on one thread, so that processor time is what one processor takes.
constexpr parallel one_thread{1};

double processor_seconds() {
    return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

template <class... Parts>
greedy_result search(const mesh& of, const face_table& faces, const recipe& how,
                     greedy_options options, const pipeline<Parts...>& parts, bool is_refined) {
    const auto one = [&](double epsilon, std::size_t limit) {
        options.epsilon = epsilon;
        if (how.planes > 0) options.max_planes = limit + 1;
        greedy_result found = search_planes(faces, of.face_count(), options, parts, one_thread);
        const bool is_whole = options.max_planes == 0 || found.cloud.plane_count() <= limit;
        if (is_refined && is_whole) {
            refine_whole(faces, found.cloud, {}, average_fit{}, one_thread);
        }
        return found;
    };
    const double epsilon = how.epsilon * faces.bounds.radius;
    if (how.planes == 0) return one(epsilon, std::numeric_limits<std::size_t>::max() - 1);
    const auto count = [](const greedy_result& found) { return found.cloud.plane_count(); };
    return search_for_planes(how.planes, faces.bounds.radius, one, count,
                             {.first_epsilon = how.epsilon, .max_searches = 6})
        .result;
}

greedy_result search(const mesh& of, const face_table& faces, const recipe& how) {
    greedy_options options;
    options.rho_rate = how.rho_rate;
    options.refine = how.refine;
    options.skip_area = how.skip_area;
    options.falloff = how.falls ? falloff_use::everywhere : falloff_use::nowhere;
    const density_policies policies{hull_of_samples{}, projected_area{},
                                    inner_side_penalty{how.penalty}, distance_falloff{}};
    switch (how.how) {
        case method::classic: {
            const auto made = presets::classic();
            return search(of, faces, how, made.options.search, made.method, false);
        }
        case method::unfitted:
            return search(of, faces, how, options,
                          pipeline{cube_map(how.raster), policies, no_fit{}}, false);
        case method::density:
            return search(of, faces, how, options,
                          pipeline{cube_map(how.raster), policies, least_squares_fit{}}, false);
        case method::density_refined:
            return search(of, faces, how, options,
                          pipeline{cube_map(how.raster), policies, least_squares_fit{}}, true);
        case method::exact:
        case method::exact_refined:
            break;
    }
    return search(of, faces, how, options,
                  pipeline{cube_map(how.raster),
                           density_policies{hull_of_samples{}, projected_area{}, no_penalty{}},
                           least_squares_fit{}, whole_set{}, fixed_vertices{},
                           exact_method{.tangency = how.tangency}},
                  how.how == method::exact_refined);
}

}  // namespace

cloud_made make_cloud(const mesh& of, const recipe& how, const view_settings& views) {
    face_table faces = *make_face_table(of);
    cloud_made made;
    const double start = processor_seconds();
    greedy_result found = search(of, faces, how);
    made.seconds = processor_seconds() - start;
    billboard_cloud& cloud = found.cloud;
    const cloud_errors errors = measure_errors(of, cloud);
    made.planes = cloud.plane_count();
    made.epsilon = cloud.epsilon / cloud.bounds.radius;
    made.refinement_level = found.statistics.mean_refinement_level();
    made.projected_area_share = errors.projected_area_share;
    made.skipped_area_share = found.statistics.leftover_area_share;

    const weld_options weld{.kind = how.welds ? weld_kind::intersection : weld_kind::none};
    const welded_faces welded = weld_faces(of, cloud, std::span(&weld, 1));
    made.geometric = geometric_error(of, cloud, welded.moved).mean_of_radius;
    bake_options bake;
    bake.texels = views.texels;
    bake.draw.supersample = 2;
    if (welded.moved.empty()) {
        fit_billboards(of, cloud);
        made.mesh = cloud_mesh(cloud, bake_cloud(of, faces, cloud, bake));
    } else {
        const mesh drawn = drawn_mesh(of, cloud, welded.moved);
        faces = *make_face_table(drawn);
        fit_billboards(drawn, cloud);
        made.mesh = cloud_mesh(cloud, bake_cloud(drawn, faces, cloud, bake));
    }
    return made;
}

std::vector<picture_means> look_at(const mesh& original, std::span<const mesh* const> clouds,
                                   const view_settings& views) {
    std::deque<render_scene> scenes;  // they stay where they are
    scenes.emplace_back(original);
    for (const mesh* cloud : clouds) scenes.emplace_back(*cloud);
    std::vector<const render_scene*> drawn;
    for (const render_scene& scene : scenes) drawn.push_back(&scene);
    std::vector<camera> cameras;
    for (const dvec3& direction : spread_directions(views.views)) {
        cameras.push_back(orbit_camera(scenes.front().bounds, direction, 4, views.size_px));
    }
    std::vector<std::vector<picture_means>> seen(clouds.size(),
                                                 std::vector<picture_means>(cameras.size()));
    const render_options render{.supersample = views.supersample};
    for_views(drawn, cameras, render, {}, [&](std::size_t view, std::span<const view_render> all) {
        const view_picture& before = all[0].picture;
        const blurred_picture blurred = blur(before, {});
        for (std::size_t i = 0; i < clouds.size(); ++i) {
            const view_picture& after = all[i + 1].picture;
            const coverage_errors coverage = coverage_error(before, after);
            seen[i][view] = {coverage.error,
                             coverage.missing,
                             coverage.extra,
                             gap_intensity(before, after),
                             mean_color_error(before, after),
                             local_color_error(blurred, blur(after, {}))};
        }
    });
    std::vector<picture_means> means(clouds.size());
    const double weight = 1 / static_cast<double>(cameras.size());
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        for (const picture_means& view : seen[i]) {
            means[i].coverage += weight * view.coverage;
            means[i].missing += weight * view.missing;
            means[i].extra += weight * view.extra;
            means[i].gap_intensity += weight * view.gap_intensity;
            means[i].color += weight * view.color;
            means[i].local_color += weight * view.local_color;
        }
    }
    return means;
}

cloud_made search_tree(const mesh& of, double epsilon) {
    auto how = presets::tree();
    how.foliage.options.epsilon = tolerance::of_radius(epsilon);
    how.trunk.options.epsilon = how.foliage.options.epsilon;
    build_options options;
    options.threads = one_thread;
    options.bake.texels = 16;
    options.bake.draw.supersample = 1;
    const double start = processor_seconds();
    double end = start;
    const progress_function watch = [&](std::string_view stage, double) {
        if (stage == "search") end = processor_seconds();
    };
    const expected<build_result> built = build_tree(of, find_roles(of), how, options, watch);
    cloud_made made;
    made.planes = built->cloud.plane_count();
    made.epsilon = epsilon;
    made.seconds = end - start;
    made.projected_area_share = built->errors.projected_area_share;
    return made;
}

}  // namespace thesis
