#include <billow/search/search_planes.hpp>

#include <doctest/doctest.h>

#include <billow/search/plane_budget.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("search/search_planes") {
    TEST_CASE("the pipeline's search is the one that runs") {
        const mesh m = leaf_soup(600);
        const face_table faces = support::table_of(m);
        const greedy_options options{.epsilon = 0.15, .skip_area = 0.05};
        const cube_map space(8);
        const exact_method method{.tangency = 1, .starts = 2};
        const pipeline dense{space};
        const pipeline exact{space,       density_policies<>{}, least_squares_fit{},
                             whole_set{}, fixed_vertices{},     method};
        const auto by_grid = search_planes(faces, m.face_count(), options, dense);
        CHECK(by_grid.cloud.planes ==
              greedy_search(faces, m.face_count(), options, dense).cloud.planes);
        const auto by_sweep = search_planes(faces, m.face_count(), options, exact);
        CHECK(by_sweep.cloud.planes ==
              exact_search(faces, m.face_count(), exact_options(options, method), exact)
                  .cloud.planes);
        CHECK(by_sweep.cloud.planes != by_grid.cloud.planes);
        CHECK(by_sweep.covered_area.back() >= 0.95);
    }
    TEST_CASE("a number of planes is searched for by either") {
        const mesh m = leaf_soup(400);
        const pipeline exact{cube_map(6), density_policies<>{}, least_squares_fit{},
                             whole_set{}, fixed_vertices{},     exact_method{}};
        const auto found =
            greedy_search_for_planes(support::table_of(m), m.face_count(), 12, {}, exact);
        CHECK(found.planes >= 10);
        CHECK(found.planes <= 14);
    }
}
