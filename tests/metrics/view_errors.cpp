#include <billow/metrics/view_errors.hpp>

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <billow/metrics/render.hpp>
#include <billow/metrics/view_directions.hpp>
#include <billow/shapes/box.hpp>

#include "support/meshes.hpp"
#include "support/pictures.hpp"

using namespace billow;

namespace {

/// Pictures of 32 x 32 of a mesh from several directions.
std::vector<view_picture> pictures_of(const mesh& drawn) {
    const render_scene scene(drawn);
    std::vector<view_picture> pictures;
    for (const dvec3& direction : spread_directions(12)) {
        pictures.push_back(render_view(scene, orbit_camera({{0, 0, 0}, 1}, direction, 4, 32)));
    }
    return pictures;
}

}  // namespace

TEST_SUITE("metrics/view_errors") {
    TEST_CASE("a mesh compared with itself is 0 by every metric from every side") {
        const auto pictures = pictures_of(box({1, 0.8f, 0.6f}));
        const auto errors = measure_views(pictures, pictures);
        CHECK(over_views(errors) == errors_over_views{});
        for (const view_errors& e : errors) CHECK(e == view_errors{});
    }
    TEST_CASE("half of a square that is removed is half of it from every side") {
        mesh square;
        support::add_square(square, {0, 0, 0}, {0.6f, 0.1f, 0.2f}, {-0.1f, 0.6f, 0.3f});
        mesh half = square;
        half.triangles.pop_back();
        const auto all = over_views(measure_views(pictures_of(square), pictures_of(half)));
        CHECK(all.missing.mean == doctest::Approx(0.5).epsilon(0.02));
        CHECK(all.missing.worst < 0.6);  // the nearer half is larger
        CHECK(all.coverage.mean == doctest::Approx(all.missing.mean));
        CHECK(all.extra.worst == 0);
        CHECK(all.common_color.worst < 1);
        CHECK(all.object_flip.mean > 0.2);
    }
    TEST_CASE(
        "a removed side of a box shows its inside, which covers as much but looks otherwise") {
        const mesh whole = box({1, 0.8f, 0.6f});
        mesh open = whole;
        open.triangles.pop_back();
        open.triangles.pop_back();
        const auto all = over_views(measure_views(pictures_of(whole), pictures_of(open)));
        CHECK(all.missing.mean < 0.05);
        CHECK(all.extra.worst < 1e-6);
        CHECK(all.local_color.worst > 1);
        CHECK(all.object_flip.worst > 0.02);
    }
    TEST_CASE("a pair's errors are those of each metric") {
        const auto a = support::random_picture(31, 22, 1);
        const auto b = support::random_picture(31, 22, 2);
        const measure_options options{
            .gap = {.depth_px = 1}, .color = {.sigma_px = 3}, .flip = {.pixels_per_degree = 30}};
        const view_errors e = measure_pair(a, b, options);
        CHECK(e.coverage == coverage_error(a, b).error);
        CHECK(e.missing == coverage_error(a, b).missing);
        CHECK(e.extra == coverage_error(a, b).extra);
        CHECK(e.extra_of_cloud == coverage_error(a, b).extra_of_cloud);
        CHECK(e.gap_intensity == gap_error(a, b, options.gap).intensity);
        CHECK(e.hole_share == gap_error(a, b, options.gap).hole_share);
        CHECK(e.color == color_error(a, b, options.color).mean);
        CHECK(e.common_color == color_error(a, b, options.color).common);
        CHECK(e.local_color == color_error(a, b, options.color).local);
        CHECK(e.flip == flip_error(a, b, options.flip).mean);
        CHECK(e.object_flip == flip_error(a, b, options.flip).over_object);
        const auto percept = perceive(a, options);
        CHECK(measure_pair(a, percept, b, perceive(b, options), options) == e);
    }
    TEST_CASE("errors have the same bits for any number of threads") {
        std::vector<view_picture> a;
        std::vector<view_picture> b;
        for (std::uint64_t seed = 0; seed < 9; ++seed) {
            a.push_back(support::random_picture(20, 30, seed));
            b.push_back(support::random_picture(20, 30, seed + 50));
        }
        const auto one = measure_views(a, b, {}, {1});
        for (const unsigned threads : {2u, 3u, 8u}) {
            CHECK(measure_views(a, b, {}, {threads}) == one);
        }
    }
    TEST_CASE("each metric has its mean and its own worst view") {
        std::vector<view_errors> views(3);
        double value = 1;
        for (const picture_metric& metric : all_picture_metrics) {
            for (view_errors& view : views) view.*metric.of_view = value++;
            views[1].*metric.of_view += 100;
        }
        const errors_over_views all = over_views(views);
        value = 1;
        for (const picture_metric& metric : all_picture_metrics) {
            CHECK((all.*metric.over_views).mean == doctest::Approx(value + 1 + 100.0 / 3));
            CHECK((all.*metric.over_views).worst == value + 101);
            CHECK((all.*metric.over_views).worst_view == 1);
            value += 3;
        }
        CHECK(all.missing.worst == 5 + 100);
        CHECK(over_views({}) == errors_over_views{});
    }
    TEST_CASE("names differ") {
        for (const picture_metric& a : all_picture_metrics) {
            for (const picture_metric& b : all_picture_metrics) {
                CHECK((a.name == b.name) == (a.of_view == b.of_view));
            }
        }
    }
}
