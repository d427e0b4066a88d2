// All that two pictures of a view tell about a cloud, and what many views tell together.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 5.1: the metrics for evenly spread views, their mean and their maximum.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/metrics/color_error.hpp>
#include <billow/metrics/coverage_error.hpp>
#include <billow/metrics/flip.hpp>
#include <billow/metrics/gap.hpp>
#include <billow/metrics/statistic.hpp>
#include <billow/metrics/view_picture.hpp>

namespace billow::inline BILLOW_ABI {

/// What a cloud's pictures are measured by. Each is 0 for the same pictures, and grows as they
/// differ; the gap intensity alone may fall below 0.
///
/// Unit  shares, 1 for all of the original, but ΔE*76 for colours; ꟻLIP is 0 to 1.
template <class T>
struct picture_metrics {
    T coverage{};        ///< coverage_errors::error
    T missing{};         ///< coverage_errors::missing
    T extra{};           ///< coverage_errors::extra
    T extra_of_cloud{};  ///< coverage_errors::extra_of_cloud
    T gap_intensity{};   ///< gap_errors::intensity
    T hole_share{};      ///< gap_errors::hole_share
    T color{};           ///< color_errors::mean
    T common_color{};    ///< color_errors::common
    T local_color{};     ///< color_errors::local
    T flip{};            ///< flip_errors::mean
    T object_flip{};     ///< flip_errors::over_object

    [[nodiscard]] bool operator==(const picture_metrics&) const = default;
};

using view_errors = picture_metrics<double>;           ///< of one view
using errors_over_views = picture_metrics<statistic>;  ///< of many

/// A metric by name, for tables and files.
struct picture_metric {
    std::string_view name{};
    std::string_view unit{};
    double view_errors::*of_view = nullptr;
    statistic errors_over_views::*over_views = nullptr;
};

inline constexpr std::array<picture_metric, 11> all_picture_metrics{{
    {"coverage", "share", &view_errors::coverage, &errors_over_views::coverage},
    {"missing", "share", &view_errors::missing, &errors_over_views::missing},
    {"extra", "share", &view_errors::extra, &errors_over_views::extra},
    {"extra_of_cloud", "share", &view_errors::extra_of_cloud, &errors_over_views::extra_of_cloud},
    {"gap_intensity", "share", &view_errors::gap_intensity, &errors_over_views::gap_intensity},
    {"hole_share", "share", &view_errors::hole_share, &errors_over_views::hole_share},
    {"color", "delta_e76", &view_errors::color, &errors_over_views::color},
    {"common_color", "delta_e76", &view_errors::common_color, &errors_over_views::common_color},
    {"local_color", "delta_e76", &view_errors::local_color, &errors_over_views::local_color},
    {"flip", "flip", &view_errors::flip, &errors_over_views::flip},
    {"object_flip", "flip", &view_errors::object_flip, &errors_over_views::object_flip},
}};

static_assert(sizeof(view_errors) == all_picture_metrics.size() * sizeof(double));

struct measure_options {
    gap_options gap{};
    color_options color{};
    flip_options flip{};
};

/// What is derived from one picture alone. That of an original serves all of its clouds.
struct picture_percept {
    blurred_picture blurred{};
    flip_percept seen{};
};

/// Needs  a picture of at least one pixel.
[[nodiscard]] inline picture_percept perceive(const view_picture& picture,
                                              const measure_options& options = {}) {
    return {blur(picture, options.color), seen_in(picture, options.flip)};
}

/// All metrics of a pair of pictures of the same view.
///
/// Needs  pictures of the same size, percepts of them made with the same options.
/// Cost   O(pixels).
[[nodiscard]] inline view_errors measure_pair(const view_picture& original,
                                              const picture_percept& original_percept,
                                              const view_picture& cloud,
                                              const picture_percept& cloud_percept,
                                              const measure_options& options = {}) {
    const coverage_errors coverage = coverage_error(original, cloud);
    const gap_errors gap = gap_error(original, cloud, options.gap);
    const flip_errors flip =
        flip_error(flip_map(original_percept.seen, cloud_percept.seen), original, cloud);
    return {.coverage = coverage.error,
            .missing = coverage.missing,
            .extra = coverage.extra,
            .extra_of_cloud = coverage.extra_of_cloud,
            .gap_intensity = gap.intensity,
            .hole_share = gap.hole_share,
            .color = mean_color_error(original, cloud),
            .common_color = common_color_error(original, cloud),
            .local_color = local_color_error(original_percept.blurred, cloud_percept.blurred),
            .flip = flip.mean,
            .object_flip = flip.over_object};
}

[[nodiscard]] inline view_errors measure_pair(const view_picture& original,
                                              const view_picture& cloud,
                                              const measure_options& options = {}) {
    return measure_pair(original, perceive(original, options), cloud, perceive(cloud, options),
                        options);
}

/// measure_pair of each view, parallel over views.
///
/// Shape  as many originals as clouds, the same view in the same row.
/// Needs  pairs of pictures as measure_pair, some 80 bytes a pixel for each thread.
/// Gives  the same bits for any number of threads.
[[nodiscard]] inline std::vector<view_errors> measure_views(std::span<const view_picture> originals,
                                                            std::span<const view_picture> clouds,
                                                            const measure_options& options = {},
                                                            parallel threads = {}) {
    BILLOW_ASSERT(originals.size() == clouds.size());
    std::vector<view_errors> errors(originals.size());
    threads.for_chunks(errors.size(), 1, [&](std::size_t view, std::size_t) {
        errors[view] = measure_pair(originals[view], clouds[view], options);
    });
    return errors;
}

/// Mean, 95 % and worst of each metric over views, by metric, with the view that is worst by it.
[[nodiscard]] inline errors_over_views over_views(std::span<const view_errors> views) {
    errors_over_views result;
    std::vector<double> values(views.size());
    for (const picture_metric& metric : all_picture_metrics) {
        for (std::size_t i = 0; i < views.size(); ++i) values[i] = views[i].*metric.of_view;
        result.*metric.over_views = statistic_of(values);
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI
