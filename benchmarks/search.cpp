// The whole search, against faces, threads and kinds of refinement.
#include <billow/search/greedy.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

void search(benchmark::State& state, std::size_t size, unsigned threads, refinement refine) {
    const bench::scene& scene = bench::leaves(size);
    const double epsilon = bench::epsilon_share * scene.faces.bounds.radius;
    std::size_t planes = 0;
    bench::repeat(state, bench::ns_per_face(size), [&] {
        const greedy_result result =
            greedy_search(scene.faces, scene.mesh.face_count(),
                          {.epsilon = epsilon, .refine = refine}, pipeline{}, {threads});
        planes = result.cloud.plane_count();
    });
    state.counters["planes"] = static_cast<double>(planes);
}

const bool rows = [] {
    const auto row = [](const char* family, std::size_t size, unsigned threads, refinement kind) {
        bench::add_row(family, size, bench::isa, threads,
                       [=](benchmark::State& state) { search(state, size, threads, kind); });
    };
    for (const std::size_t size : {1'000u, 10'000u, 113'016u, 1'000'000u}) {
        for (const unsigned threads : {1u, 2u}) {
            row("search.greedy/leaf_soup", size, threads, refinement::fail_safe);
        }
    }
    for (const std::size_t size : {1'000u, 10'000u}) {
        row("search.refine/original", size, 1, refinement::original);
        row("search.refine/fail_safe", size, 1, refinement::fail_safe);
        row("search.refine/none", size, 1, refinement::none);
    }
    return true;
}();

}  // namespace
