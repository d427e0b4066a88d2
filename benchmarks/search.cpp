// The whole search, against faces, threads, kinds of refinement, and with each improvement beside plain.
#include <billow/search/compact.hpp>
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

/// A search with something added, to be held against search.greedy of the same size.
template <class... Parts>
void improved(const char* name, const greedy_options& options, const pipeline<Parts...>& parts) {
    for (const std::size_t size : {1'000u, 113'016u}) {
        const std::string family = std::string("search.greedy/") + name;
        bench::add_row(family, size, bench::isa, 1, [=](benchmark::State& state) {
            const bench::scene& scene = bench::leaves(size);
            greedy_options chosen = options;
            chosen.epsilon = bench::epsilon_share * scene.faces.bounds.radius;
            std::size_t planes = 0;
            bench::repeat(state, bench::ns_per_face(size), [&] {
                planes = greedy_search(scene.faces, scene.mesh.face_count(), chosen, parts, {1})
                             .cloud.plane_count();
            });
            state.counters["planes"] = static_cast<double>(planes);
        });
    }
}

/// The default pipeline with other policies.
template <class Contribution, class Falloff, class Bias>
auto with_policies(const Contribution& worth, const Falloff& falls, const Bias& bias) {
    return pipeline{cube_map{},
                    density_policies{hull_of_samples{}, worth, inner_side_penalty{}, falls, bias}};
}

const bool search_rows = [] {
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
    const projected_area projected{};
    improved("angular", {}, with_policies(angular_area{}, no_falloff{}, no_bias{}));
    improved("falloff", {}, with_policies(projected, distance_falloff{}, no_bias{}));
    improved("horizontal_penalty", {},
             with_policies(projected, no_falloff{}, horizontal_penalty{}));
    improved("vertical_penalty", {}, with_policies(projected, no_falloff{}, vertical_penalty{}));
    improved("distribution", {.distribution = {.strength = 0.3}}, pipeline{});
    improved("skip_area", {.skip_area = 0.02}, pipeline{});
    improved("min_contribution", {.min_contribution = 0.002}, pipeline{});
    improved("compact", {},
             pipeline{cube_map{}, density_policies<>{}, least_squares_fit{}, heaviest_group<>{}});
    return true;
}();

}  // namespace
