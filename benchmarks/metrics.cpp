// Views of a scene by face.
#include <billow/metrics/render.hpp>

#include <array>
#include <map>
#include <string>
#include <vector>

#include <billow/metrics/view_directions.hpp>
#include <billow/plants/species.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

void render(benchmark::State& state, const mesh& m, int supersample, unsigned threads) {
    const render_scene scene(m);
    const std::array<const render_scene*, 1> scenes{&scene};
    std::vector<camera> cameras;
    for (const dvec3& d : spread_directions(6)) cameras.push_back(orbit_camera(scene.bounds, d));
    std::array<double, 6> covered{};
    bench::repeat(state, {"ms_per_view", 1e3, static_cast<double>(cameras.size())}, [&] {
        for_views(scenes, cameras, {.supersample = supersample}, {threads},
                  [&](std::size_t view, const auto& renders) {
                      covered[view] = renders[0].counts.covered;
                  });
    });
    state.counters["covered_pixels"] = covered[0];
}

/// A tree with leaves cut out of cards.
const mesh& leafy_tree(std::size_t faces) {
    static std::map<std::size_t, mesh> grown;
    const auto found = grown.find(faces);
    if (found != grown.end()) return found->second;
    return grown.emplace(faces, *tree_of_about(faces)).first->second;
}

const bool metrics_rows = [] {
    for (const int s : {2, 4}) {
        const char* samples = s == 2 ? "_2x2" : "_4x4";
        for (const std::size_t size : {1'000u, 113'016u}) {
            bench::add_row(
                std::string("metrics.render/leaf_soup") + samples, size, bench::isa, 1,
                [=](benchmark::State& state) { render(state, bench::leaves(size).mesh, s, 1); });
        }
        for (const unsigned threads : {1u, 2u}) {
            bench::add_row(
                std::string("metrics.render/broadleaf") + samples, 113'016, bench::isa, threads,
                [=](benchmark::State& state) { render(state, leafy_tree(113'016), s, threads); });
        }
    }
    return true;
}();

}  // namespace
