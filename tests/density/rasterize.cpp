#include <billow/density/rasterize.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <billow/plane_space/cube_map.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

constexpr double epsilon = 0.15;

std::vector<orientation_cell> cells_of(const cube_map& space) {
    std::vector<orientation_cell> cells;
    for (orientation_id id = 0; id < space.orientation_count(); ++id)
        cells.push_back(space.cell(id));
    return cells;
}

offset_axis axis_of(double radius) {
    const double spacing = epsilon / 1.5;
    const int half = static_cast<int>(std::ceil(radius / spacing));
    return {-half * spacing, spacing, 2 * half};
}

using row_values = std::vector<std::pair<std::int64_t, std::int64_t>>;

row_values values(const density_grid& grid, std::size_t row) {
    row_values all;
    grid.for_each_bin(row, [&](int, std::int64_t c, std::int64_t p) { all.emplace_back(c, p); });
    return all;
}

using falling =
    density_policies<hull_of_samples, angular_area, inner_side_penalty, distance_falloff>;

/// Covered share of a bin, as a picture would be drawn: the overlap of two intervals.
double coverage(const offset_axis& axis, int bin, double low, double high) {
    const double from = axis.origin + bin * axis.spacing;
    return std::max(0.0, std::min(high, from + axis.spacing) - std::max(low, from)) / axis.spacing;
}

}  // namespace

TEST_SUITE("density/rasterize") {
    TEST_CASE("contribution and penalty of every bin are those of brute force") {
        const cube_map space(6);
        const auto cells = cells_of(space);
        const face_table faces = support::table_of(support::random_triangles(50, 0.2, 1));
        density_grid grid(cells.size(), axis_of(faces.bounds.radius), density_scale(faces));
        rasterize_density(faces, std::span<const orientation_cell>(cells), density_policies<>{},
                          epsilon, grid);
        double largest_difference = 0;
        for (std::size_t row = 0; row < cells.size(); ++row) {
            std::vector<double> contribution(static_cast<std::size_t>(grid.axis().bin_count));
            std::vector<double> penalty(contribution.size());
            for (std::size_t f = 0; f < faces.size; ++f) {
                const auto face = load_faces<float>(faces, f);
                const auto valid =
                    hull_of_samples{}(face, cell_lanes<float>(cells[row]), float(epsilon));
                if (valid.low > valid.high) continue;
                const double worth =
                    double(projected_area{}(face, fill_lanes<float>(cells[row].centre)));
                const double low = double(valid.low), high = double(valid.high);
                for (int bin = 0; bin < grid.axis().bin_count; ++bin) {
                    const auto b = static_cast<std::size_t>(bin);
                    contribution[b] += worth * coverage(grid.axis(), bin, low, high);
                    // The inner side: towards 0, on either side of it, but not across.
                    if (low > 0) {
                        penalty[b] +=
                            worth * coverage(grid.axis(), bin, std::max(0.0, low - epsilon), low);
                    } else if (high < 0) {
                        penalty[b] +=
                            worth * coverage(grid.axis(), bin, high, std::min(0.0, high + epsilon));
                    }
                }
            }
            grid.for_each_bin(row, [&](int bin, std::int64_t c, std::int64_t p) {
                const auto b = static_cast<std::size_t>(bin);
                largest_difference = std::max({largest_difference,
                                               std::abs(double(c) / grid.scale() - contribution[b]),
                                               std::abs(double(p) / grid.scale() - penalty[b])});
            });
        }
        CHECK(largest_difference < 1e-5);
    }
    TEST_CASE("a face's contributions sum to its worth times the bins that its interval spans") {
        const cube_map space(4);
        const auto cells = cells_of(space);
        const face_table faces = support::table_of(support::triangles({{-1, -1, -1},
                                                                       {0.1f, 0.1f, 0.2f},
                                                                       {0.2f, 0.1f, 0.2f},
                                                                       {1, 1, 1},
                                                                       {0.9f, 1, 1},
                                                                       {1, 0.9f, 1}}));
        const face_table one = select_rows(faces, std::vector<std::uint32_t>{1});
        density_grid grid(cells.size(), axis_of(faces.bounds.radius), density_scale(one));
        rasterize_density(one, std::span<const orientation_cell>(cells), density_policies<>{},
                          epsilon, grid);
        int covered = 0;
        for (std::size_t row = 0; row < cells.size(); ++row) {
            const auto face = load_faces<float>(one, 0);
            const auto valid =
                hull_of_samples{}(face, cell_lanes<float>(cells[row]), float(epsilon));
            if (valid.low > valid.high) continue;
            const offset_axis axis = grid.axis();
            const double from = std::max(double(valid.low), axis.origin);
            const double to =
                std::min(double(valid.high), axis.origin + axis.bin_count * axis.spacing);
            double sum = 0;
            grid.for_each_bin(row, [&](int, std::int64_t c, std::int64_t) { sum += double(c); });
            const double worth =
                double(projected_area{}(face, fill_lanes<float>(cells[row].centre)));
            CHECK(sum / grid.scale() ==
                  doctest::Approx(worth * (to - from) / axis.spacing).epsilon(1e-4));
            covered +=
                (to - from) > 3 * axis.spacing ? 1 : 0;  // spans of more than three bins occur
        }
        CHECK(covered > 0);
    }
    TEST_CASE("lanes, scalars and any number of threads give the same integers") {
        const cube_map space(6);
        const auto cells = cells_of(space);
        const face_table faces = support::table_of(support::random_triangles(3000, 0.1, 2));
        const auto grid_with = [&](auto lane, unsigned threads) {
            density_grid grid(cells.size(), axis_of(faces.bounds.radius), density_scale(faces));
            rasterize_density<decltype(lane)>(faces, std::span<const orientation_cell>(cells),
                                              density_policies<>{}, epsilon, grid,
                                              density_change::add, {threads});
            return grid;
        };
        const density_grid scalar = grid_with(float{}, 1);
        for (const unsigned threads : {1u, 2u, 3u, 8u}) {
            const density_grid wide = grid_with(simd::wide{}, threads);
            bool is_same = true;
            for (std::size_t row = 0; row < cells.size(); ++row) {
                is_same &= values(wide, row) == values(scalar, row);
            }
            CHECK(is_same);
        }
    }
    TEST_CASE(
        "contributions stay at least 0 and removing every face in any order leaves exactly 0") {
        const cube_map space(4);
        const auto cells = cells_of(space);
        const face_table faces = support::table_of(support::random_triangles(700, 0.3, 3));
        density_grid grid(cells.size(), axis_of(faces.bounds.radius), density_scale(faces));
        rasterize_density(faces, std::span<const orientation_cell>(cells), density_policies<>{},
                          epsilon, grid);
        for (std::uint32_t part : {2u, 0u, 1u}) {
            std::vector<std::uint32_t> rows;
            for (std::uint32_t row = 0; row < faces.size; ++row) {
                if (row % 3 == part) rows.push_back(row);
            }
            rasterize_density(select_rows(faces, rows), std::span<const orientation_cell>(cells),
                              density_policies<>{}, epsilon, grid, density_change::remove);
            bool is_positive = true;
            for (std::size_t row = 0; row < cells.size(); ++row) {
                for (const auto& [c, p] : values(grid, row)) is_positive &= c >= 0 && p >= 0;
            }
            CHECK(is_positive);
        }
        for (std::size_t row = 0; row < cells.size(); ++row) {
            for (const ramp& r : grid.contribution(row)) REQUIRE(r == ramp{});
            for (const ramp& r : grid.penalty(row)) REQUIRE(r == ramp{});
        }
    }
    TEST_CASE("a row serves a normal and its opposite") {
        const cube_map space(6);
        const auto cells = cells_of(space);
        const face_table faces = support::table_of(support::random_triangles(200, 0.2, 4));
        density_grid grid(cells.size(), axis_of(faces.bounds.radius), density_scale(faces));
        rasterize_density(faces, std::span<const orientation_cell>(cells), density_policies<>{},
                          epsilon, grid);
        for (orientation_id id = 0; id < space.orientation_count(); ++id) {
            row_values mirrored = values(grid, space.antipode(id));
            std::reverse(mirrored.begin(), mirrored.end());
            const row_values own = values(grid, id);
            for (std::size_t b = 0; b < own.size(); ++b) {
                // Heights round down on either side: a unit a face at most.
                REQUIRE(std::abs(own[b].first - mirrored[b].first) <= 2000 * 2);
                REQUIRE(std::abs(own[b].second - mirrored[b].second) <= 2000 * 2);
            }
        }
    }
    TEST_CASE("under a falloff every bin is that of brute force") {
        const cube_map space(6);
        const auto cells = cells_of(space);
        const face_table faces = support::table_of(support::random_triangles(50, 0.2, 1));
        density_grid grid = make_density_grid(falling{}, cells.size(), axis_of(faces.bounds.radius),
                                              density_scale(faces));
        rasterize_density(faces, std::span<const orientation_cell>(cells), falling{}, epsilon,
                          grid);
        // The grid rounds the ends of valid offsets to quarters of a bin.
        const offset_axis axis = grid.axis();
        const auto to_quarter = [&](float offset) {
            const double quarters = 4 * (double(offset) - axis.origin) / axis.spacing;
            return axis.origin + std::floor(quarters + 0.5) * axis.spacing / 4;
        };
        double largest_difference = 0;
        for (std::size_t row = 0; row < cells.size(); ++row) {
            std::vector<double> expected(static_cast<std::size_t>(grid.axis().bin_count));
            for (std::size_t f = 0; f < faces.size; ++f) {
                const auto face = load_faces<float>(faces, f);
                const auto valid =
                    hull_of_samples{}(face, cell_lanes<float>(cells[row]), float(epsilon));
                if (valid.low > valid.high) continue;
                const double low = to_quarter(valid.low);
                const double high =
                    std::max(to_quarter(valid.high), low + axis.spacing / 4);  // at least one
                for (int bin = 0; bin < grid.axis().bin_count; ++bin) {
                    const double centre = grid.axis().centre_of(bin);
                    const double slack = 1e-6 * axis.spacing;
                    const bool has_middle =
                        std::abs(centre - (low + high) / 2 - slack) < axis.spacing / 2;
                    const bool is_valid = low - slack <= centre && centre <= high + slack;
                    if (!is_valid && !has_middle) continue;
                    const double aside = std::abs(grid.axis().centre_of(bin) - (low + high) / 2);
                    const double distance = std::max(0.0, aside - grid.axis().spacing / 2);
                    expected[static_cast<std::size_t>(bin)] +=
                        double(angular_area{}(face, fill_lanes<float>(cells[row].centre))) /
                        (distance / epsilon + 1);
                }
            }
            grid.for_each_bin(row, [&](int bin, std::int64_t c, std::int64_t) {
                const double difference =
                    double(c) / grid.contribution_scale() - expected[static_cast<std::size_t>(bin)];
                largest_difference = std::max(largest_difference, std::abs(difference));
            });
        }
        CHECK(largest_difference < 3e-5);  // weights are multiples of 2^-12
    }
    TEST_CASE(
        "under a falloff lanes and threads give the same integers, removal leaves exactly 0") {
        const cube_map space(6);
        const auto cells = cells_of(space);
        const face_table faces = support::table_of(support::random_triangles(3000, 0.1, 2));
        const auto change = [&](auto lane, density_grid& grid, density_change how,
                                unsigned threads) {
            rasterize_density<decltype(lane)>(faces, std::span<const orientation_cell>(cells),
                                              falling{}, epsilon, grid, how, {threads});
        };
        const auto make_grid = [&] {
            return make_density_grid(falling{}, cells.size(), axis_of(faces.bounds.radius),
                                     density_scale(faces));
        };
        density_grid scalar = make_grid();
        change(float{}, scalar, density_change::add, 1);
        for (const unsigned threads : {1u, 2u, 3u, 8u}) {
            density_grid wide = make_grid();
            change(simd::wide{}, wide, density_change::add, threads);
            bool is_same = true;
            for (std::size_t row = 0; row < cells.size(); ++row) {
                is_same &= values(wide, row) == values(scalar, row);
            }
            CHECK(is_same);
        }
        change(simd::wide{}, scalar, density_change::remove, 2);
        for (std::size_t row = 0; row < cells.size(); ++row) {
            for (const ramp& r : scalar.contribution(row)) REQUIRE(r == ramp{});
            for (const ramp& r : scalar.penalty(row)) REQUIRE(r == ramp{});
        }
    }
    TEST_CASE("under a falloff many faces at once are the sum of a few at a time") {
        const cube_map space(4);
        const auto cells = cells_of(space);
        const face_table faces = support::table_of(support::random_triangles(20000, 0.1, 3));
        const auto add = [&](const face_table& some, density_grid& grid) {
            rasterize_density(some, std::span<const orientation_cell>(cells), falling{}, epsilon,
                              grid);
        };
        const auto make_grid = [&] {
            return make_density_grid(falling{}, cells.size(), axis_of(faces.bounds.radius),
                                     density_scale(faces));
        };
        density_grid at_once = make_grid();
        density_grid in_parts = make_grid();
        REQUIRE(faces.size > detail::kernel_for(falling{}, at_once, cells, epsilon).key_count());
        add(faces, at_once);
        for (std::uint32_t first = 0; first < faces.size; first += 500) {
            std::vector<std::uint32_t> some;
            const auto end = std::min(first + 500, static_cast<std::uint32_t>(faces.size));
            for (std::uint32_t row = first; row < end; ++row) some.push_back(row);
            add(select_rows(faces, some), in_parts);
        }
        bool is_same = true;
        for (std::size_t row = 0; row < cells.size(); ++row) {
            is_same &= values(at_once, row) == values(in_parts, row);
        }
        CHECK(is_same);
    }
    TEST_CASE("a bin whose centre is not valid pays the penalty alone, the next one does not") {
        // As Luksch 2009, Figure 3.7, but for the share that is valid: bins of half an epsilon. The
        // unit square lies in a plane of offset 0.515 with epsilon 0.1, so its offsets begin 0.8 bins
        // up in the bin from 0.375 to 0.425.
        const double eps = 0.1;
        mesh m;
        support::add_square(m, {0, 0, 0.515f}, {0.5f, 0, 0}, {0, 0.5f, 0});
        support::add_square(m, {0, 0, -0.515f}, {0.5f, 0, 0}, {0, 0.5f, 0});
        const face_table both = support::table_of(m);
        const face_table square = select_rows(both, std::vector<std::uint32_t>{0, 1});
        const orientation_cell up =
            make_cell({0, 0, 1}, std::array{dvec3(0, 0, 1), dvec3(0, 0, 1), dvec3(0, 0, 1)});
        density_grid grid(1, {-0.025 - 20 * 0.05, 0.05, 41}, density_scale(square));
        // The next bin's middle is 1.3 bins from that of the offsets, of which half a bin is free.
        const double strength = 1.5 / (0.8 * 0.5);
        rasterize_density(square, std::span(&up, 1),
                          density_policies{hull_of_samples{}, projected_area{},
                                           inner_side_penalty{10}, distance_falloff{strength}},
                          eps, grid);
        std::array<double, 2> density{};
        grid.for_each_bin(0, [&](int bin, std::int64_t c, std::int64_t p) {
            if (bin != 28 && bin != 29) return;
            density[static_cast<std::size_t>(bin - 28)] =
                (double(c) - 10 * double(p)) / grid.scale();
        });
        CHECK(density[0] == doctest::Approx(-8).epsilon(1e-4));
        CHECK(density[1] == doctest::Approx(0.4).epsilon(1e-4));
    }
}
