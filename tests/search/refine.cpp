#include <billow/search/refine.hpp>

#include <cmath>

#include <doctest/doctest.h>

#include <billow/geometry/frame.hpp>

#include <billow/plane_space/cube_map.hpp>
#include <billow/plane_space/spherical.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// A patch of small triangles on the plane p, and the bin of `space` that the plane is in.
mesh tiles_on(const plane& p) {
    random_stream random(4);
    const frame axes = frame_around(p.normal);
    mesh m;
    for (int i = 0; i < 100; ++i) {
        support::add_square(
            m, vec3(axes.to_scene({random.between(-0.6, 0.6), random.between(-0.6, 0.6), p.rho})),
            vec3(axes.u * 0.02), vec3(axes.v * 0.02));
    }
    // Far corners fix the centre at 0 and the radius near 1.
    for (const float s : {-1.0f, 1.0f})
        support::add_square(m, vec3(s * 0.7f), vec3(0.01f, 0, 0), vec3(0, 0.01f, 0));
    return m;
}

template <plane_space Space>
void check_finds(const Space& space, const plane& target, int children) {
    const double epsilon = 0.02;
    const face_table all = support::table_of(tiles_on(target));
    std::vector<std::uint32_t> rows(200);
    for (std::uint32_t i = 0; i < 200; ++i) rows[i] = i;
    const face_table faces = select_rows(all, rows);
    const double rho = target.rho - glm::dot(target.normal, faces.bounds.centre);
    const orientation_patch patch = space.patch(space.orientation_of(target.normal));
    const double spacing = epsilon / 1.5;
    const double low = std::floor(rho / spacing) * spacing;
    const auto refined = refine(space, plane_bin{patch, low, low + spacing}, faces,
                                density_policies<>{}, epsilon, {.children_per_axis = children});
    REQUIRE(refined);
    CHECK(faces_valid_for(faces, refined->plane, epsilon).size() == faces.size);
    CHECK(refined->level <= 12);
}

}  // namespace

TEST_SUITE("search/refine") {
    TEST_CASE("a plane that serves all faces is found within its bin, in either plane space") {
        for (const int children : {4, 6}) {
            check_finds(cube_map(18), {glm::normalize(dvec3(0.31, 0.2, 0.93)), 0.3}, children);
            check_finds(spherical(18), {glm::normalize(dvec3(0.31, 0.2, 0.93)), 0.3}, children);
        }
    }
    TEST_CASE("at poles, cube corners, cube edges and across rho = 0 as well") {
        for (const dvec3& direction : {dvec3(0.02, 0.01, 1), dvec3(0, 0, -1), dvec3(1, 1, 1),
                                       dvec3(1, 0.97, 1), dvec3(-1, 1, 0.3), dvec3(0.4, -1, 1)}) {
            for (const double rho : {0.001, -0.003, 0.25}) {
                const plane target{glm::normalize(direction), rho};
                check_finds(cube_map(18), target, 4);
                check_finds(spherical(18), target, 4);
            }
        }
    }
    TEST_CASE("the centre plane is in the middle of its bin") {
        const cube_map space(8);
        const plane p = centre_plane(space, {space.patch(3), 0.25, 0.5});
        CHECK(p.rho == 0.375);
        CHECK(glm::distance(p.normal, space.direction(3)) < 1e-12);
    }
    TEST_CASE("a bin that no face has a plane in gives nothing") {
        const cube_map space(8);
        const face_table faces = support::table_of(support::random_triangles(20, 0.05, 1));
        CHECK_FALSE(refine(space, plane_bin{space.patch(3), 5, 5.1}, faces, density_policies<>{},
                           0.01, {}));
    }
}
