#include <billow/plane_space/cube_map.hpp>

#include <set>
#include <tuple>

#include <doctest/doctest.h>


using namespace billow;

TEST_SUITE("plane_space/cube_map") {
    TEST_CASE("there are 6N²+2 different orientations") {
        for (const int n : {2, 12, 16, 18, 20, 24}) {
            const cube_map space(n);
            CHECK(space.orientation_count() == static_cast<std::size_t>(6 * n * n + 2));
            std::set<std::tuple<double, double, double>> seen;
            for (orientation_id id = 0; id < space.orientation_count(); ++id) {
                const dvec3 d = space.direction(id);
                seen.insert({d.x + 0.0, d.y + 0.0, d.z + 0.0});
            }
            CHECK(seen.size() == space.orientation_count());
        }
    }
    TEST_CASE(
        "a point has eight neighbours, at the cube's corners six; sides come before edges before "
        "corners") {
        const cube_map space(18);
        const std::size_t corners = space.orientation_count() - 8;
        for (orientation_id id = 0; id < space.orientation_count(); ++id) {
            CHECK(space.neighbours(id).size() == (id >= corners ? 6u : 8u));
        }
        const dvec3 d = glm::abs(space.direction(static_cast<orientation_id>(corners)));
        CHECK(d.x == doctest::Approx(d.y));
        CHECK(d.y == doctest::Approx(d.z));
    }
    TEST_CASE("the axes are orientations, exactly") {
        const cube_map space(18);
        for (const dvec3& axis : {dvec3(1, 0, 0), dvec3(0, -1, 0), dvec3(0, 0, 1)}) {
            CHECK(space.direction(space.orientation_of(axis)) == axis);
        }
    }
    TEST_CASE("at N = 18 the warp keeps half diagonals below 4.1 degrees") {
        const cube_map space(18);
        float chord = 0;
        for (orientation_id id = 0; id < space.orientation_count(); ++id) {
            chord = std::max(chord, space.cell(id).chord);
        }
        CHECK(2 * std::asin(chord / 2) * 180 / std::numbers::pi ==
              doctest::Approx(4.0).epsilon(0.025));
    }
    TEST_CASE("chart coordinates go on smoothly beyond the rim") {
        const cube_map space(18);
        const dvec3 inside = space.direction_at(0, {0.99, 0.2});
        const dvec3 outside = space.direction_at(0, {1.01, 0.2});
        CHECK(glm::distance(inside, outside) < 0.02);
        CHECK(space.orientation_of(outside) !=
              space.orientation_of(space.direction_at(0, {0.9, 0.2})));
    }
}
