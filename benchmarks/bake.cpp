// Textures by texel, packing by tile.
#include <billow/bake/bake_cloud.hpp>

#include <vector>

#include <billow/bake/mips.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/core/random.hpp>
#include <billow/improve/cardboard.hpp>
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

void bake(benchmark::State& state, const bench::scene& scene, unsigned threads,
          const bake_options& options = {}) {
    const billboard_cloud cloud = cloud_of(scene);
    const auto bake_once = [&] {
        billboard_cloud snapped = cloud;
        return bake_cloud(scene.mesh, scene.faces, snapped, options, {threads});
    };
    double texels = 0;
    for (const tile& t : bake_once().tiles) texels += static_cast<double>(t.width) * t.height;
    bench::repeat(state, {"ms_per_megatexel", 1e3, texels / 1e6}, bake_once);
    state.counters["tiles"] = static_cast<double>(cloud.plane_count());
}

void cardboard(benchmark::State& state, const bench::scene& scene) {
    const billboard_cloud cloud = cloud_of(scene);
    std::size_t added = 0;
    bench::repeat(state, bench::ns_per_face(scene.mesh.face_count()), [&] {
        billboard_cloud more = cloud;
        added = add_cardboard_planes(scene.mesh, more, {}, {1});
    });
    state.counters["added"] = static_cast<double>(added);
}

void mips(benchmark::State& state, const bench::scene& scene, unsigned threads) {
    billboard_cloud cloud = cloud_of(scene);
    const baked_cloud baked = bake_cloud(scene.mesh, scene.faces, cloud, {}, {});
    double texels = 0;
    for (const atlas& a : baked.atlases) texels += static_cast<double>(a.width()) * a.height();
    std::size_t levels = 0;
    bench::repeat(state, {"ms_per_megatexel", 1e3, texels / 1e6},
                  [&] { levels = make_mips(baked, {}, {threads})[0].base_color.size(); });
    state.counters["levels"] = static_cast<double>(levels);
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
            "bake.mips/leaf_soup", 1'000, "scalar", threads,
            [=](benchmark::State& state) { mips(state, bench::leaves(1'000), threads); });
        bench::add_row(
            "bake.bake_cloud/broadleaf", 20'000, "scalar", threads, [=](benchmark::State& state) {
                static const bench::scene tree(*grow(*with_face_count(broadleaf(), 20'000, 1), 1));
                bake(state, tree, threads);
            });
    }
    for (const std::size_t size : {1'000u, 113'016u}) {
        for (const auto cracks : {crack_reduction::none, crack_reduction::envelope}) {
            const bool is_plain = cracks == crack_reduction::none;
            bench::add_row(is_plain ? "bake.cracks/none" : "bake.cracks/envelope", size, bench::isa,
                           1, [=](benchmark::State& state) {
                               bake(state, bench::leaves(size), 1, {.draw = {.cracks = cracks}});
                           });
        }
        bench::add_row("improve.cardboard/leaf_soup", size, "scalar", 1,
                       [=](benchmark::State& state) { cardboard(state, bench::leaves(size)); });
    }
    for (const std::size_t size : {100u, 1'000u}) {
        bench::add_row("bake.pack/random", size, "scalar", 1,
                       [=](benchmark::State& state) { pack(state, size); });
    }
    return true;
}();

}  // namespace
