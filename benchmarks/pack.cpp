// Packing: time by tile, and how full the atlas is.
#include <billow/bake/pack.hpp>

#include <string>
#include <vector>

#include <billow/core/random.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

/// Sides up to 200 texels, small ones more often, as billboards have them.
std::vector<ivec2> tiles_of(std::size_t count, double largest) {
    random_stream random(1);
    std::vector<ivec2> tiles;
    for (std::size_t i = 0; i < count; ++i) {
        const double scale = random.unit() * largest;
        tiles.emplace_back(4 + random.unit() * scale, 4 + random.unit() * scale);
    }
    return tiles;
}

void pack(benchmark::State& state, const std::vector<ivec2>& tiles, const pack_options& options) {
    packing result;
    bench::repeat(state, {"us_per_tile", 1e6, static_cast<double>(tiles.size())},
                  [&] { result = pack_rectangles(tiles, options); });
    state.counters["atlases"] = static_cast<double>(result.atlas_sizes.size());
    state.counters["fill"] = result.fill;
    state.counters["padded_fill"] = result.padded_fill;
}

const bool pack_rows = [] {
    for (const std::size_t size : {20u, 200u, 1'000u, 3'000u, 10'000u}) {
        bench::add_row("bake.pack/one_atlas", size, "scalar", 1, [=](benchmark::State& state) {
            pack(state, tiles_of(size, size < 3'000 ? 200 : size < 10'000 ? 100 : 32), {});
        });
    }
    for (const std::size_t size : {200u, 1'000u}) {
        bench::add_row("bake.pack/power_of_two", size, "scalar", 1, [=](benchmark::State& state) {
            pack(state, tiles_of(size, 200), {.power_of_two = true});
        });
        bench::add_row("bake.pack/atlases_of_512", size, "scalar", 1, [=](benchmark::State& state) {
            pack(state, tiles_of(size, 200), {.max_size = 512});
        });
    }
    return true;
}();

}  // namespace
