// Refinement of the whole, step by step, on what a greedy search finds: to be held against search.greedy.
#include <billow/improve/refine_whole.hpp>
#include <billow/search/greedy.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

/// What a search finds, made once: the search would take most of the time.
const billboard_cloud& found(std::size_t size) {
    static std::map<std::size_t, billboard_cloud> made;
    const auto known = made.find(size);
    if (known != made.end()) return known->second;
    const bench::scene& scene = bench::leaves(size);
    const double epsilon = bench::epsilon_share * scene.faces.bounds.radius;
    return made
        .emplace(size,
                 greedy_search(scene.faces, scene.mesh.face_count(), {.epsilon = epsilon}).cloud)
        .first->second;
}

void refine(const char* name, const whole_refinement_options& options) {
    for (const std::size_t size : {1'000u, 20'000u, 113'016u}) {
        for (const unsigned threads : {1u, 2u}) {
            const std::string family = std::string("improve.refine_whole/") + name;
            bench::add_row(family, size, bench::isa, threads, [=](benchmark::State& state) {
                const bench::scene& scene = bench::leaves(size);
                whole_refinement_report told;
                bench::repeat(state, bench::ns_per_face(size), [&] {
                    billboard_cloud cloud = found(size);
                    told = refine_whole(scene.faces, cloud, options, average_fit{}, {threads});
                });
                state.counters["planes"] = static_cast<double>(told.planes_after);
                state.counters["planes_before"] = static_cast<double>(told.planes_before);
            });
        }
    }
}

const bool refine_whole_rows = [] {
    refine("merge", {.effort = 0, .reassign = false});
    refine("exchange", {.reassign = false});
    refine("reassign", {.merge = false, .effort = 0});
    refine("all", {});
    return true;
}();

}  // namespace
