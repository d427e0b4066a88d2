// Vertex welding after the search and during it, against the search without.
#include <billow/improve/weld.hpp>
#include <billow/plants/species.hpp>
#include <billow/search/greedy.hpp>
#include <billow/search/weld_online.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

/// A tree: its trunk is one surface, its leaves are loose.
const bench::scene& tree(std::size_t size) {
    static std::map<std::size_t, bench::scene> made;
    const auto found = made.find(size);
    if (found != made.end()) return found->second;
    return made.emplace(size, bench::scene(*grow(*with_face_count(broadleaf(), size, 1), 1)))
        .first->second;
}

template <class Motion>
[[nodiscard]] greedy_result search(const bench::scene& scene, const Motion& motion) {
    return greedy_search(
        scene.faces, scene.mesh.face_count(),
        {.epsilon = bench::epsilon_share * scene.faces.bounds.radius},
        pipeline{cube_map{}, density_policies<>{}, least_squares_fit{}, whole_set{}, motion}, {1});
}

const bool weld_rows = [] {
    for (const std::size_t size : {1'000u, 113'016u}) {
        bench::add_row("search.greedy/tree", size, bench::isa, 1, [=](benchmark::State& state) {
            const bench::scene& scene = tree(size);
            bench::repeat(state, bench::ns_per_face(size),
                          [&] { benchmark::DoNotOptimize(search(scene, fixed_vertices{})); });
        });
        bench::add_row(
            "search.weld_online/tree", size, bench::isa, 1, [=](benchmark::State& state) {
                const bench::scene& scene = tree(size);
                bench::repeat(state, bench::ns_per_face(size),
                              [&] { benchmark::DoNotOptimize(search(scene, weld_online())); });
            });
        bench::add_row("improve.weld/tree", size, "scalar", 1, [=](benchmark::State& state) {
            const bench::scene& scene = tree(size);
            const billboard_cloud cloud = search(scene, fixed_vertices{}).cloud;
            const weld_options options{.kind = weld_kind::intersection};
            bench::repeat(state, bench::ns_per_face(size), [&] {
                benchmark::DoNotOptimize(weld_faces(scene.mesh, cloud, std::span(&options, 1)));
            });
        });
    }
    return true;
}();

}  // namespace
