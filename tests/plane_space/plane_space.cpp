#include <billow/plane_space/plane_space.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <billow/geometry/frame.hpp>
#include <billow/plane_space/cube_map.hpp>
#include <billow/plane_space/spherical.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// What every plane space promises.
template <plane_space Space>
void check_promises(const Space& space) {
    const auto count = static_cast<orientation_id>(space.orientation_count());
    for (orientation_id id = 0; id < count; ++id) {
        const dvec3 n = space.direction(id);
        REQUIRE(glm::length(n) == doctest::Approx(1).epsilon(1e-12));
        REQUIRE(space.antipode(space.antipode(id)) == id);
        REQUIRE(space.direction(space.antipode(id)) == -n);  // exact
        REQUIRE(space.orientation_of(n) == id);
        const orientation_cell cell = space.cell(id);
        REQUIRE(glm::distance(dvec3(cell.centre), n) < 1e-6);
        for (const vec3& corner : cell.corner) {
            REQUIRE(glm::distance(dvec3(corner), n) <= double(cell.chord) + 1e-6);
        }
        const orientation_patch patch = space.patch(id);
        REQUIRE(glm::distance(space.direction_at(patch.chart, patch.centre), n) < 1e-12);
        for (const orientation_id near : space.neighbours(id)) {
            REQUIRE(near != id);
            const auto back = space.neighbours(near);
            REQUIRE(std::find(back.begin(), back.end(), id) != back.end());
            REQUIRE(glm::dot(space.direction(near), n) > 0.4);
        }
    }
    random_stream random(8);
    for (int i = 0; i < 500; ++i) {  // any direction lies in its orientation's cell
        const dvec3 n = support::random_direction(random);
        const orientation_cell cell = space.cell(space.orientation_of(n));
        REQUIRE(glm::distance(dvec3(cell.centre), n) <= double(cell.chord) + 1e-6);
    }
}

/// Area of the spherical polygon of a cell: the sum of two triangles (Van Oosterom, Strackee 1983).
double solid_angle(const orientation_cell& cell) {
    const auto triangle = [](const dvec3& a, const dvec3& b, const dvec3& c) {
        return 2 * std::atan2(std::abs(glm::dot(a, glm::cross(b, c))),
                              1 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
    };
    const dvec3 a(cell.corner[0]), b(cell.corner[1]), c(cell.corner[2]), d(cell.corner[3]);
    const dvec3 m(cell.centre);
    // Corners come in any order around the centre: sort them by angle.
    std::vector<dvec3> ring{a, b, c};
    if (d != c) ring.push_back(d);
    const frame axes = frame_around(m);
    std::sort(ring.begin(), ring.end(), [&](const dvec3& p, const dvec3& q) {
        return std::atan2(glm::dot(axes.v, p), glm::dot(axes.u, p)) <
               std::atan2(glm::dot(axes.v, q), glm::dot(axes.u, q));
    });
    double sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i)
        sum += triangle(m, ring[i], ring[(i + 1) % ring.size()]);
    return sum;
}

template <plane_space Space>
double solid_angle_sum(const Space& space) {
    double sum = 0;
    for (orientation_id id = 0; id < space.orientation_count(); ++id)
        sum += solid_angle(space.cell(id));
    return sum;
}

}  // namespace

TEST_SUITE("plane_space/plane_space") {
    TEST_CASE("orientations, antipodes, cells, patches and neighbours agree with each other") {
        check_promises(cube_map(2));
        check_promises(cube_map(18));
        check_promises(spherical(2));
        check_promises(spherical(9));
    }
    TEST_CASE(
        "the cube's cells tile the sphere; the spherical ones do but for their straight sides") {
        CHECK(solid_angle_sum(cube_map(18)) == doctest::Approx(4 * std::numbers::pi).epsilon(1e-5));
        CHECK(solid_angle_sum(spherical(18)) ==
              doctest::Approx(4 * std::numbers::pi).epsilon(5e-3));
    }
    TEST_CASE("a patch's cell is the orientation's own inside a chart") {
        const cube_map space(18);
        const orientation_id id = space.orientation_of(glm::normalize(dvec3(1, 0.3, -0.2)));
        const orientation_cell of_patch = cell_of_patch(space, space.patch(id));
        const orientation_cell own = space.cell(id);
        CHECK(of_patch.chord == doctest::Approx(own.chord).epsilon(1e-5));
        for (const vec3& corner : of_patch.corner) {
            double nearest = 9;
            for (const vec3& c : own.corner)
                nearest = std::min(nearest, double(glm::distance(c, corner)));
            CHECK(nearest < 1e-6);
        }
    }
}
