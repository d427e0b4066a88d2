#include <billow/search/plane_distribution.hpp>

#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <billow/cloud/measure.hpp>
#include <billow/plane_space/cube_map.hpp>
#include <billow/search/greedy.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/searches.hpp"

using namespace billow;

namespace {

std::vector<orientation_cell> all_cells() {
    const cube_map space{10};
    std::vector<orientation_cell> cells;
    for (orientation_id id = 0; id < space.orientation_count(); ++id) {
        cells.push_back(space.cell(id));
    }
    return cells;
}

}  // namespace

TEST_SUITE("search/plane_distribution") {
    TEST_CASE("a plane lowers the weights around its normal and its opposite, and no others") {
        const auto cells = all_cells();
        orientation_weights weights(cells, no_bias{}, {.strength = 0.3, .cutoff_deg = 25});
        for (std::size_t row = 0; row < cells.size(); ++row) CHECK(weights[row] == 1);
        weights.plane_found({0, 0, 1});
        for (std::size_t row = 0; row < cells.size(); ++row) {
            const double angle =
                std::acos(std::min(1.0f, std::abs(cells[row].centre.z))) * 180 / std::numbers::pi;
            CHECK(weights[row] ==
                  doctest::Approx(1 - 0.3 * std::max(0.0, 1 - angle / 25)).epsilon(1e-5));
        }
    }
    TEST_CASE("weights fall to the floor and stay there, times the bias") {
        const auto cells = all_cells();
        const horizontal_penalty bias{};
        orientation_weights weights(cells, bias, {.strength = 0.5, .cutoff_deg = 90, .floor = 0.2});
        for (int i = 0; i < 40; ++i) weights.plane_found({0, 1, 0});
        for (std::size_t row = 0; row < cells.size(); ++row) {
            const dvec3 normal(cells[row].centre);
            CHECK(weights[row] >= 0.2 * bias(normal) * (1 - 1e-12));
            if (std::abs(normal.y) > 0.9) {
                CHECK(weights[row] == doctest::Approx(0.2 * bias(normal)));
            }
        }
    }
    TEST_CASE("without strength nothing changes") {
        const auto cells = all_cells();
        orientation_weights weights(cells, vertical_penalty{}, {});
        weights.plane_found({1, 0, 0});
        for (std::size_t row = 0; row < cells.size(); ++row) {
            CHECK(weights[row] == vertical_penalty{}(dvec3(cells[row].centre)));
        }
    }
    TEST_CASE("distribution weights leave a flat model both of its walls") {
        mesh m;
        for (const float z : {-0.3f, 0.3f}) {
            support::add_square(m, {0, 0, z}, {0.5f, 0, 0}, {0, 0.5f, 0});
        }
        for (const double strength : {0.3, 1.0}) {
            const auto r =
                support::coarse_search(m, 0.05, {.distribution = {.strength = strength}});
            CHECK(measure_errors(m, r.cloud).mapped_faces == 4);
            CHECK(measure_errors(m, r.cloud).faces_beyond_epsilon == 0);
            CHECK(r.cloud.plane_count() == 2);
            for (const plane& p : r.cloud.planes) CHECK(std::abs(p.normal.z) > 0.999);
        }
    }
    TEST_CASE("distribution weights spread the first planes over directions") {
        const mesh m = leaf_soup(4000, {.edge = 0.02f});
        const auto nearest_pair = [&](double strength) {
            const auto r = support::coarse_search(m, 0.1, {.distribution = {.strength = strength}});
            CHECK(measure_errors(m, r.cloud).faces_beyond_epsilon == 0);
            CHECK(measure_errors(m, r.cloud).mapped_faces == m.face_count());
            double sum = 0;
            for (std::size_t i = 1; i < 8; ++i) {
                double most = 0;
                for (std::size_t j = 0; j < i; ++j) {
                    most = std::max(most, std::abs(glm::dot(r.cloud.planes[i].normal,
                                                            r.cloud.planes[j].normal)));
                }
                sum += most;
            }
            return sum;
        };
        CHECK(nearest_pair(0.9) < nearest_pair(0));
    }
}
