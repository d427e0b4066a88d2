#include <billow/search/lazy_directions.hpp>

#include <limits>
#include <numeric>

#include <doctest/doctest.h>

#include <billow/plane_space/cube_map.hpp>
#include <billow/search/face_sets.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

std::vector<vec3> half_sphere(int resolution) {
    const cube_map space(resolution);
    std::vector<vec3> normals;
    for (orientation_id id = 0; id < space.orientation_count(); ++id) {
        if (id <= space.antipode(id)) normals.push_back(space.cell(id).centre);
    }
    return normals;
}

/// The best plane when every normal is swept anew: of equals the first normal's.
template <class Sweep>
swept_direction eager(const Sweep& sweep, const face_table& faces, const std::vector<vec3>& normals,
                      const std::vector<double>& weights, double charge) {
    swept_direction best;
    sweep_scratch scratch;
    std::vector<std::int64_t> buckets;
    for (std::size_t row = 0; row < normals.size(); ++row) {
        const swept_offset at =
            sweep.best(faces, normals[row], {weights[row], charge},
                       -std::numeric_limits<double>::infinity(), buckets, scratch);
        if (at.is_found && at.density > best.at.density) best = {row, at};
    }
    return best;
}

/// Takes the best plane's faces again and again, lazily and eagerly, while weights fall.
template <class Contribution, class Penalty>
void check_lazy_is_eager(const mesh& m, const Contribution& worth, const Penalty& penalty) {
    face_table remaining = support::table_of(m);
    const double epsilon = 0.1 * remaining.bounds.radius;
    const offset_sweep sweep(worth, penalty, epsilon, remaining.bounds.radius,
                             density_scale(remaining));
    const std::vector<vec3> normals = half_sphere(8);
    std::vector<double> weights(normals.size(), 1.0);
    lazy_directions lazy(sweep, normals, parallel{2});
    lazy.change(remaining, density_change::add);
    for (int planes = 0; planes < 12 && remaining.size > 0; ++planes) {
        const swept_direction found = lazy.best(remaining, weights, sweep.charge());
        const swept_direction wanted = eager(sweep, remaining, normals, weights, sweep.charge());
        REQUIRE(found.at.is_found == wanted.at.is_found);
        if (!found.at.is_found) break;
        CHECK(found.row == wanted.row);
        CHECK(found.at.rho == wanted.at.rho);
        CHECK(found.at.density == wanted.at.density);
        CHECK(found.at.contribution == wanted.at.contribution);

        const plane p{dvec3(normals[found.row]), static_cast<double>(found.at.rho)};
        const face_rows taken = faces_valid_for(remaining, p, epsilon);
        REQUIRE(!taken.empty());
        lazy.change(select_rows(remaining, taken), density_change::remove);
        face_rows all(remaining.size), kept;
        std::iota(all.begin(), all.end(), 0u);
        std::ranges::set_difference(all, taken, std::back_inserter(kept));
        remaining = select_rows(remaining, kept);
        weights[found.row] *= 0.5;
    }
}

}  // namespace

TEST_SUITE("search/lazy_directions") {
    TEST_CASE("the lazy choice is the eager one while faces leave and weights fall") {
        check_lazy_is_eager(leaf_soup(1500), projected_area{}, no_penalty{});
        check_lazy_is_eager(support::random_triangles(600, 0.2, 3), angular_area{}, no_penalty{});
    }
    TEST_CASE("the same where penalties are charged") {
        check_lazy_is_eager(leaf_soup(1000), projected_area{}, inner_side_penalty{3});
        check_lazy_is_eager(leaf_soup(600), projected_area{}, inner_side_penalty{0});
    }
    TEST_CASE("of equal planes the first normal's is taken") {
        mesh m;  // a cube of six equal sides: all three axes are worth the same
        for (int axis = 0; axis < 3; ++axis) {
            vec3 n(0), u(0), v(0);
            n[axis] = 1, u[(axis + 1) % 3] = 0.3f, v[(axis + 2) % 3] = 0.3f;
            support::add_square(m, n, u, v);
            support::add_square(m, -n, u, v);
        }
        check_lazy_is_eager(m, projected_area{}, no_penalty{});
    }
    TEST_CASE("runners-up are apart, swept, and no better than the best") {
        const face_table faces = support::table_of(leaf_soup(800));
        const projected_area worth;
        const no_penalty none;
        const offset_sweep sweep(worth, none, 0.1, faces.bounds.radius, density_scale(faces));
        const std::vector<vec3> normals = half_sphere(8);
        const std::vector<double> weights(normals.size(), 1.0);
        lazy_directions lazy(sweep, normals, parallel{1});
        lazy.change(faces, density_change::add);
        const swept_direction best = lazy.best(faces, weights, 0);
        const auto others = lazy.runners_up(faces, weights, 0, best.row, 5, 0.3);
        CHECK(others.size() == 5);
        std::vector<std::size_t> rows{best.row};
        for (const swept_direction& d : others) {
            CHECK(d.at.is_found);
            CHECK(d.at.density <= best.at.density);
            for (const std::size_t row : rows) {
                const double cosine =
                    std::abs(glm::dot(dvec3(normals[row]), dvec3(normals[d.row])));
                CHECK(2 - 2 * cosine > 0.09);
            }
            rows.push_back(d.row);
        }
    }
    TEST_CASE("a cleared set of rows finds nothing") {
        const face_table faces = support::table_of(leaf_soup(100));
        const projected_area worth;
        const no_penalty none;
        const offset_sweep sweep(worth, none, 0.1, faces.bounds.radius, density_scale(faces));
        const std::vector<double> weights(1000, 1.0);
        lazy_directions lazy(sweep, half_sphere(4), parallel{1});
        lazy.change(faces, density_change::add);
        lazy.clear();
        lazy.forget_bounds();
        CHECK_FALSE(lazy.best(face_table{.bounds = faces.bounds}, weights, 0).at.is_found);
    }
}
