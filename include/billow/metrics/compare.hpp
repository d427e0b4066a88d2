// Clouds compared with their original: every metric from many sides, and what drawing costs.
//
// Luksch, "An improved billboard cloud generation algorithm", 2009, section 5.1: evenly spread views
// of a model, the mean and the worst of each metric.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/geometry/screen.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/metrics/camera.hpp>
#include <billow/metrics/draw_cost.hpp>
#include <billow/metrics/geometric_error.hpp>
#include <billow/metrics/nearest_planes.hpp>
#include <billow/metrics/render.hpp>
#include <billow/metrics/render_scene.hpp>
#include <billow/metrics/statistic.hpp>
#include <billow/metrics/view_directions.hpp>
#include <billow/metrics/view_errors.hpp>

namespace billow::inline BILLOW_ABI {

struct compare_options {
    int views = 42;       ///< directions, evenly spread, ≥ 1
    int size_px = 512;    ///< side of the pictures, which the original fills
    double distance = 4;  ///< of the eye to the original's centre, in its radii, > 1
    lod_screen screen{};  ///< whose pixels the geometric error and ꟻLIP count
    int supersample = 4;  ///< samples a pixel side
    gap_options gap{};
    color_options color{};
};

/// What one cloud's pictures and file tell.
///
/// Shape  `views` and `view_overdraw`: a row a view.
struct cloud_comparison {
    draw_cost cost{};
    std::vector<view_errors> views{};
    errors_over_views errors{};
    std::vector<double> view_overdraw{};
    statistic overdraw{};
    /// None where the file does not say which plane a vertex lies on. Lower bounds: see
    /// find_nearest_planes. Faces that the cloud keeps as they are do not count, not as undrawn either.
    std::optional<geometric_errors> geometric{};
    nearest_planes planes{};
};

/// Clouds beside each other. Every cloud was seen by the same cameras.
struct comparison {
    bounding_sphere bounds{};       ///< of the original, which the cameras frame
    std::vector<camera> cameras{};  ///< cameras[i].axes.normal points to the viewer
    double pixels_per_degree = 0;   ///< of the pictures, for ꟻLIP
    draw_cost original{};
    std::vector<double> original_view_overdraw{};
    statistic original_overdraw{};
    std::vector<cloud_comparison> clouds{};
};

/// Whether single-sided faces of a mesh are compared by what their front shows, as engines draw them:
/// those of clouds, which know their planes. Others are drawn from both sides, as clouds are baked.
[[nodiscard]] inline bool culls_backs(const mesh& of) noexcept { return !of.feature_ids.empty(); }

namespace detail {

/// The cameras of a comparison, with the pictures' pixels a degree: so many that ꟻLIP sees what an
/// observer of the screen does, for whom the object is as large as at this distance.
inline void set_cameras(comparison& to, const compare_options& options) {
    for (const dvec3& direction : spread_directions(options.views)) {
        to.cameras.push_back(orbit_camera(to.bounds, direction, options.distance, options.size_px));
    }
    const double radius = to.bounds.radius > 0 ? to.bounds.radius : 1.0;
    const double distance = options.distance * radius;
    const double scale = options.size_px / (to.cameras.front().height * distance);
    to.pixels_per_degree = std::max(1.0, pixels_per_degree_at(distance, options.screen, scale));
}

inline void measure_geometry(cloud_comparison& to, const mesh& original, const mesh& cloud,
                             const compare_options& options, parallel threads) {
    if (cloud.feature_ids.empty()) return;
    to.planes = find_nearest_planes(original, cloud, threads);
    const double distance = options.distance * to.planes.planes.bounds.radius;
    to.geometric = geometric_error(original, to.planes.planes, {}, {distance, options.screen});
    to.geometric->undrawn -= to.planes.kept;
}

}  // namespace detail

/// Draws the original and every cloud from all sides and measures the pictures.
///
/// Needs   meshes that validate() accepts; at least one view, size_px ≥ 1, distance > 1.
/// Gives   0 by every picture metric for a cloud that is the original; the same bits for any number
///         of threads.
/// Cost    O(views × (faces + pixels)) for each mesh, and as find_nearest_planes; parallel over
///         views. Some 250 bytes a pixel for each thread.
[[nodiscard]] inline comparison compare(const mesh& original, std::span<const mesh* const> clouds,
                                        const compare_options& options = {}, parallel threads = {},
                                        const progress_function& progress = {}) {
    BILLOW_ASSERT(options.views >= 1 && options.size_px >= 1 && options.distance > 1);
    comparison result;
    std::deque<render_scene> scenes;  // they stay where they are
    scenes.emplace_back(original, culls_backs(original));
    for (const mesh* cloud : clouds) scenes.emplace_back(*cloud, culls_backs(*cloud));
    std::vector<const render_scene*> drawn;
    drawn.reserve(scenes.size());
    for (const render_scene& scene : scenes) drawn.push_back(&scene);

    result.bounds = scenes.front().bounds;
    detail::set_cameras(result, options);
    const std::size_t views = result.cameras.size();
    result.original = draw_cost_of(original);
    result.original_view_overdraw.resize(views);
    result.clouds.resize(clouds.size());
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        result.clouds[i].cost = draw_cost_of(*clouds[i]);
        result.clouds[i].views.resize(views);
        result.clouds[i].view_overdraw.resize(views);
    }

    const measure_options measure{
        options.gap, options.color, {.pixels_per_degree = result.pixels_per_degree}};
    const render_options render{.supersample = options.supersample, .counts_fragments = true};
    const auto caller = std::this_thread::get_id();
    std::atomic<std::size_t> done{0};
    report(progress, "compare", 0);
    for_views(drawn, result.cameras, render, threads,
              [&](std::size_t view, std::span<const view_render> seen) {
                  const view_picture& before = seen[0].picture;
                  const picture_percept percept = perceive(before, measure);
                  result.original_view_overdraw[view] = seen[0].counts.overdraw();
                  for (std::size_t i = 0; i < clouds.size(); ++i) {
                      cloud_comparison& to = result.clouds[i];
                      const view_picture& after = seen[i + 1].picture;
                      to.views[view] =
                          measure_pair(before, percept, after, perceive(after, measure), measure);
                      to.view_overdraw[view] = seen[i + 1].counts.overdraw();
                  }
                  const auto share = static_cast<double>(++done) / static_cast<double>(views);
                  if (std::this_thread::get_id() == caller) report(progress, "compare", share);
              });
    report(progress, "compare", 1);

    result.original_overdraw = statistic_of(result.original_view_overdraw);
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        cloud_comparison& to = result.clouds[i];
        to.errors = over_views(to.views);
        to.overdraw = statistic_of(to.view_overdraw);
        detail::measure_geometry(to, original, *clouds[i], options, threads);
    }
    return result;
}

/// One cloud alone.
[[nodiscard]] inline comparison compare(const mesh& original, const mesh& cloud,
                                        const compare_options& options = {}, parallel threads = {},
                                        const progress_function& progress = {}) {
    const std::array<const mesh*, 1> one{&cloud};
    return compare(original, one, options, threads, progress);
}

/// Views worth looking at: for each cloud the worst and the best by coverage and the worst by ꟻLIP,
/// then evenly spread ones up to `count`.
///
/// Gives  rows of cameras, ascending, each once; at least one where count ≥ 1, at most `count`.
[[nodiscard]] inline std::vector<std::size_t> telling_views(const comparison& of,
                                                            std::size_t count) {
    std::vector<std::size_t> chosen;
    const std::size_t views = of.cameras.size();
    const auto add = [&](std::size_t view) {
        const bool is_new = std::find(chosen.begin(), chosen.end(), view) == chosen.end();
        if (is_new && chosen.size() < count) chosen.push_back(view);
    };
    for (const cloud_comparison& cloud : of.clouds) {
        add(cloud.errors.coverage.worst_view);
        add(cloud.errors.object_flip.worst_view);
        const auto by_coverage = [](const view_errors& a, const view_errors& b) {
            return a.coverage < b.coverage;
        };
        const auto best = std::min_element(cloud.views.begin(), cloud.views.end(), by_coverage);
        add(static_cast<std::size_t>(best - cloud.views.begin()));
    }
    for (std::size_t parts = 2; chosen.size() < std::min(count, views); ++parts) {
        for (std::size_t i = 1; i < parts; ++i) add(i * views / parts);
        if (parts > 2 * views) add(0);
    }
    std::sort(chosen.begin(), chosen.end());
    return chosen;
}

}  // namespace billow::inline BILLOW_ABI
