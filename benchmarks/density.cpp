// Adding faces to the density and removing them, by face and orientation cell.
#include <billow/density/rasterize.hpp>

#include <cmath>
#include <vector>

#include <billow/plane_space/cube_map.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

/// The orientation cells of a search, one for a normal and its opposite.
std::vector<orientation_cell> search_cells() {
    const cube_map space;
    std::vector<orientation_cell> cells;
    for (orientation_id id = 0; id < space.orientation_count(); ++id) {
        if (id <= space.antipode(id)) cells.push_back(space.cell(id));
    }
    return cells;
}

template <class V, class Policies>
void rasterize(benchmark::State& state, const Policies& policies, std::size_t size,
               unsigned threads, density_change change) {
    const face_table& faces = bench::leaves(size).faces;
    const std::vector<orientation_cell> cells = search_cells();
    const double epsilon = bench::epsilon_share * faces.bounds.radius;
    const double spacing = epsilon / 1.5;
    const int half = static_cast<int>(std::ceil(faces.bounds.radius / spacing));
    density_grid grid = make_density_grid(
        policies, cells.size(), {-half * spacing, spacing, 2 * half}, density_scale(faces));
    const bench::unit_time unit{"ns_per_face_cell", 1e9,
                                static_cast<double>(faces.size * cells.size())};
    bench::repeat(state, unit, [&] {
        rasterize_density<V>(faces, std::span<const orientation_cell>(cells), policies, epsilon,
                             grid, change, {threads});
    });
}

/// What a contribution and a falloff cost beside projected area without falloff.
template <class Contribution, class Falloff>
void add_policy_rows(const std::string& name, const Contribution& worth, const Falloff& weigh) {
    const density_policies policies{hull_of_samples{}, worth, inner_side_penalty{}, weigh};
    for (const std::size_t size : {1'000u, 113'016u}) {
        bench::add_row("density.rasterize." + name + "/leaf_soup", size, bench::isa, 1,
                       [=](benchmark::State& state) {
                           rasterize<simd::wide>(state, policies, size, 1, density_change::add);
                       });
    }
}

const bool density_rows = [] {
    add_policy_rows("projected", projected_area{}, no_falloff{});
    add_policy_rows("angular", angular_area{}, no_falloff{});
    add_policy_rows("within_angle", within_angle{projected_area{}, 60}, no_falloff{});
    add_policy_rows("projected_falloff", projected_area{}, distance_falloff{});
    add_policy_rows("angular_falloff", angular_area{}, distance_falloff{});
    for (const auto& [family, change] :
         {std::pair{"density.rasterize.add/leaf_soup", density_change::add},
          std::pair{"density.rasterize.remove/leaf_soup", density_change::remove}}) {
        for (const std::size_t size : {1'000u, 16'000u}) {
            const auto row = [&, family = family, change = change]<class V>(
                                 V, const std::string& isa, unsigned threads) {
                bench::add_row(family, size, isa, threads, [=](benchmark::State& state) {
                    rasterize<V>(state, density_policies<>{}, size, threads, change);
                });
            };
            row(float{}, "scalar", 1);
            row(simd::wide{}, bench::isa, 1);
            row(simd::wide{}, bench::isa, 2);
        }
    }
    return true;
}();

}  // namespace
