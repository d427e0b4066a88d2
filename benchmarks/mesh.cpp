// What comes before the search: growing a plant, making the face table.
#include <billow/plants/species.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

void grow_plant(benchmark::State& state, std::size_t size) {
    const species kind = *with_face_count(broadleaf(), size, 1);
    bench::repeat(state, bench::ns_per_face(size),
                  [&] { benchmark::DoNotOptimize(grow(kind, 1)); });
}

void make_table(benchmark::State& state, std::size_t size, unsigned threads) {
    const mesh& m = bench::leaves(size).mesh;
    bench::repeat(state, bench::ns_per_face(size),
                  [&] { benchmark::DoNotOptimize(make_face_table(m, {threads})); });
}

const bool mesh_rows = [] {
    for (const std::size_t size : {1'000u, 20'000u}) {
        bench::add_row("plants.species/broadleaf", size, "scalar", 1,
                       [=](benchmark::State& state) { grow_plant(state, size); });
    }
    for (const std::size_t size : {1'000u, 113'016u}) {
        for (const unsigned threads : {1u, 2u}) {
            bench::add_row("mesh.face_table/leaf_soup", size, "scalar", threads,
                           [=](benchmark::State& state) { make_table(state, size, threads); });
        }
    }
    return true;
}();

}  // namespace
