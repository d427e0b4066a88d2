// The exact search, on what search.cpp gives to the density grid: against faces and threads, with
// penalties, and each of its parts.
#include <billow/search/exact_search.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

using free_policies = density_policies<hull_of_samples, projected_area, no_penalty>;

template <class... Parts>
void row(const std::string& family, std::size_t size, unsigned threads,
         const exact_search_options& options, const pipeline<Parts...>& parts) {
    bench::add_row(family, size, bench::isa, threads, [=](benchmark::State& state) {
        const bench::scene& scene = bench::leaves(size);
        exact_search_options chosen = options;
        chosen.epsilon = bench::epsilon_share * scene.faces.bounds.radius;
        std::size_t planes = 0;
        bench::repeat(state, bench::ns_per_face(size), [&] {
            planes = exact_search(scene.faces, scene.mesh.face_count(), chosen, parts, {threads})
                         .cloud.plane_count();
        });
        state.counters["planes"] = static_cast<double>(planes);
    });
}

const bool exact_search_rows = [] {
    const pipeline plain{cube_map{}, free_policies{}};
    for (const std::size_t size : {1'000u, 10'000u, 113'016u, 200'000u, 1'000'000u}) {
        for (const unsigned threads : {1u, 2u}) {
            row("search.exact/leaf_soup", size, threads, {}, plain);
        }
    }
    for (const std::size_t size : {1'000u, 113'016u}) {
        row("search.exact/penalty", size, 1, {}, pipeline{});
        row("search.exact/raster_10", size, 1, {}, pipeline{cube_map(10), free_policies{}});
        row("search.exact/no_local_search", size, 1, {.method = {.starts = 0}}, plain);
        row("search.exact/coverage_98", size, 1, {.coverage = 0.98}, plain);
        row("search.exact/tangency_2", size, 1, {.method = {.tangency = 2}}, plain);
    }
    return true;
}();

}  // namespace
