// Textures by texel, packing by tile.
#include <billow/bake/bake_cloud.hpp>

#include <vector>

#include <billow/cloud/fit_billboards.hpp>
#include <billow/core/random.hpp>
#include <billow/plants/species.hpp>
#include <billow/search/greedy.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

billboard_cloud cloud_of(const bench::scene& scene) {
    const double epsilon = bench::epsilon_share * scene.faces.bounds.radius;
    billboard_cloud cloud =
        greedy_search(scene.faces, scene.mesh.face_count(), {.epsilon = epsilon}).cloud;
    fit_billboards(scene.mesh, cloud);
    return cloud;
}

void bake(benchmark::State& state, const bench::scene& scene, unsigned threads) {
    const billboard_cloud cloud = cloud_of(scene);
    const auto bake_once = [&] {
        billboard_cloud snapped = cloud;
        return bake_cloud(scene.mesh, scene.faces, snapped, {}, {threads});
    };
    double texels = 0;
    for (const tile& t : bake_once().tiles) texels += static_cast<double>(t.width) * t.height;
    bench::repeat(state, {"ms_per_megatexel", 1e3, texels / 1e6}, bake_once);
    state.counters["tiles"] = static_cast<double>(cloud.plane_count());
}

void pack(benchmark::State& state, std::size_t size) {
    random_stream random(1);
    std::vector<ivec2> tiles;
    for (std::size_t i = 0; i < size; ++i) {
        tiles.emplace_back(random.between(4, 200), random.between(4, 200));
    }
    std::size_t atlases = 0;
    bench::repeat(state, {"us_per_tile", 1e6, static_cast<double>(size)},
                  [&] { atlases = pack_rectangles(tiles).atlas_sizes.size(); });
    state.counters["atlases"] = static_cast<double>(atlases);
}

const bool rows = [] {
    for (const unsigned threads : {1u, 2u}) {
        bench::add_row(
            "bake.bake_cloud/leaf_soup", 1'000, "scalar", threads,
            [=](benchmark::State& state) { bake(state, bench::leaves(1'000), threads); });
        bench::add_row(
            "bake.bake_cloud/broadleaf", 20'000, "scalar", threads, [=](benchmark::State& state) {
                static const bench::scene tree(*grow(*with_face_count(broadleaf(), 20'000, 1), 1));
                bake(state, tree, threads);
            });
    }
    for (const std::size_t size : {100u, 1'000u}) {
        bench::add_row("bake.pack/random", size, "scalar", 1,
                       [=](benchmark::State& state) { pack(state, size); });
    }
    return true;
}();

}  // namespace
