// Rays against a mesh: building the tree, and the sky that leaves and vertices see.
#include <billow/bake/occlusion.hpp>

#include <array>

#include <billow/geometry/ray_tree.hpp>
#include <billow/plants/species.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

void build(benchmark::State& state, const bench::scene& scene) {
    const face_table& faces = scene.faces;
    bench::repeat(state, bench::ns_per_face(faces.size), [&] {
        const ray_tree tree(faces.size, [&](std::uint32_t row) {
            return std::array{vec3(faces.corner[0].get(row)), vec3(faces.corner[1].get(row)),
                              vec3(faces.corner[2].get(row))};
        });
        benchmark::DoNotOptimize(&tree);
    });
}

void see(benchmark::State& state, const bench::scene& scene, unsigned threads) {
    const surface look(scene.mesh);
    const occlusion_options options;
    double rays = 0;
    const double leaf_extent = options.leaf_extent * scene.faces.bounds.radius;
    for (const sky_patch& patch :
         find_sky_sites(scene.mesh, scene.faces, leaf_extent, options.rays).patches) {
        rays += patch.rays;
    }
    bench::repeat(state, {"ns_per_ray", 1e9, rays}, [&] {
        benchmark::DoNotOptimize(see_sky(look, scene.faces, options, {threads}).views.data());
    });
    state.counters["rays"] = rays;
}

const bench::scene& tree_20k() {
    static const bench::scene tree(*grow(*with_face_count(broadleaf(), 20'000, 1), 1));
    return tree;
}

const bool occlusion_rows = [] {
    bench::add_row("geometry.ray_tree/leaf_soup", 1'000, bench::isa, 1,
                   [](benchmark::State& state) { build(state, bench::leaves(1'000)); });
    bench::add_row("geometry.ray_tree/broadleaf", 20'000, bench::isa, 1,
                   [](benchmark::State& state) { build(state, tree_20k()); });
    for (const unsigned threads : {1u, 2u}) {
        bench::add_row("bake.see_sky/leaf_soup", 1'000, bench::isa, threads,
                       [=](benchmark::State& state) { see(state, bench::leaves(1'000), threads); });
        bench::add_row("bake.see_sky/broadleaf", 20'000, bench::isa, threads,
                       [=](benchmark::State& state) { see(state, tree_20k(), threads); });
    }
    return true;
}();

}  // namespace
