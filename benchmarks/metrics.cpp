// Pictures of views compared: all metrics, and the dearest of them.
#include <billow/metrics/view_errors.hpp>

#include <billow/metrics/render.hpp>
#include <billow/metrics/view_directions.hpp>
#include <billow/plants/species.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

/// 512 x 512 pixels of a tree from evenly spread directions, and of the tree turned by half a degree:
/// details are displaced by a few pixels, as on a cloud's planes.
struct pairs {
    std::vector<view_picture> originals{};
    std::vector<view_picture> clouds{};

    pairs(const mesh& tree, int views) {
        const render_scene scene(tree);
        for (const dvec3& direction : spread_directions(views)) {
            const dvec3 turned = direction + 0.01 * glm::cross(direction, dvec3(0, 1, 0));
            originals.push_back(render_view(scene, orbit_camera(scene.bounds, direction)));
            clouds.push_back(render_view(scene, orbit_camera(scene.bounds, turned)));
        }
    }
};

const pairs& pairs_of(std::size_t face_count) {
    if (face_count == 1'000) {
        static const pairs leaves(bench::leaves(1'000).mesh, 2);
        return leaves;
    }
    static const pairs tree(*grow(*with_face_count(broadleaf(), 20'000, 1), 1), 42);
    return tree;
}

void measure(benchmark::State& state, std::size_t face_count, unsigned threads) {
    const pairs& views = pairs_of(face_count);
    const auto count = static_cast<double>(views.originals.size());
    bench::repeat(state, {"ms_per_pair", 1e3, count}, [&] {
        benchmark::DoNotOptimize(
            measure_views(views.originals, views.clouds, {}, {threads}).data());
    });
    state.counters["pairs"] = count;
}

template <class Metric>
void measure_one(benchmark::State& state, std::size_t face_count, const Metric& metric) {
    const pairs& views = pairs_of(face_count);
    bench::repeat(state, {"ms_per_pair", 1e3, 1},
                  [&] { benchmark::DoNotOptimize(metric(views.originals[0], views.clouds[0])); });
}

const bool rows = [] {
    for (const std::size_t size : {1'000u, 20'000u}) {
        const std::string input = size == 1'000 ? "leaf_soup" : "broadleaf";
        for (const unsigned threads : {1u, 2u}) {
            bench::add_row("metrics.measure_views/" + input, size, bench::isa, threads,
                           [=](benchmark::State& state) { measure(state, size, threads); });
        }
        bench::add_row("metrics.flip/" + input, size, bench::isa, 1, [=](benchmark::State& state) {
            measure_one(state, size, [](const view_picture& a, const view_picture& b) {
                return flip_error(a, b).mean;
            });
        });
        bench::add_row(
            "metrics.color_error/" + input, size, bench::isa, 1, [=](benchmark::State& state) {
                measure_one(state, size, [](const view_picture& a, const view_picture& b) {
                    return color_error(a, b).local;
                });
            });
        bench::add_row(
            "metrics.gap_error/" + input, size, bench::isa, 1, [=](benchmark::State& state) {
                measure_one(state, size, [](const view_picture& a, const view_picture& b) {
                    return gap_error(a, b).hole_share;
                });
            });
    }
    return true;
}();

}  // namespace
