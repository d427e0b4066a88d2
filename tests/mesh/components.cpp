#include <billow/mesh/components.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/sphere.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// Components by walking from face to face, as the definition says.
std::vector<std::uint32_t> walked_components(const mesh& m) {
    std::vector<std::uint32_t> of_face(m.face_count(), no_id);
    std::uint32_t count = 0;
    for (face_id seed = 0; seed < m.face_count(); ++seed) {
        if (of_face[seed] != no_id) continue;
        std::queue<face_id> open;
        open.push(seed);
        of_face[seed] = count;
        while (!open.empty()) {
            const face_id from = open.front();
            open.pop();
            for (face_id to = 0; to < m.face_count(); ++to) {
                if (of_face[to] != no_id) continue;
                for (const vec3& a : m.corners(from)) {
                    for (const vec3& b : m.corners(to)) {
                        if (a == b && of_face[to] == no_id) of_face[to] = count, open.push(to);
                    }
                }
            }
        }
        ++count;
    }
    return of_face;
}

}  // namespace

TEST_SUITE("mesh/components") {
    TEST_CASE("a box with seams at its edges is one piece by position, six by index") {
        mesh cube = textured_cube();
        CHECK(find_components(cube).components.size() == 1);
        CHECK(find_components(cube, connection::index).components.size() == 6);
    }
    TEST_CASE("every leaf of a soup is a piece of two faces, with its area and diameter") {
        const mesh soup = leaf_soup(200, {.edge = 0.1f});
        const mesh_components pieces = find_components(soup);
        REQUIRE(pieces.components.size() == 100);
        for (const mesh_component& piece : pieces.components) {
            CHECK(piece.face_count == 2);
            CHECK(piece.area == doctest::Approx(0.01).epsilon(1e-4));
            CHECK(piece.diameter == doctest::Approx(0.1 * std::numbers::sqrt2).epsilon(1e-4));
        }
    }
    TEST_CASE("components are those that a walk over shared corners finds, in the same order") {
        // Corners on a small lattice: many faces share some.
        random_stream random(3);
        for (int round = 0; round < 5; ++round) {
            std::vector<vec3> corners;
            for (int i = 0; i < 3 * 60; ++i) {
                corners.emplace_back(std::floor(random.between(0, 5)),
                                     std::floor(random.between(0, 5)),
                                     std::floor(random.between(0, 5)));
            }
            const mesh m = support::triangles(corners);
            CHECK(find_components(m).of_face == walked_components(m));
        }
    }
    TEST_CASE("face counts and areas add up to those of the mesh") {
        mesh m = icosphere(2);
        support::add_square(m, {5, 0, 0}, {1, 0, 0}, {0, 1, 0});
        const mesh_components pieces = find_components(m);
        REQUIRE(pieces.components.size() == 2);
        CHECK(pieces.components[0].face_count + 2 == m.face_count());
        CHECK(pieces.components[0].diameter == doctest::Approx(2).epsilon(0.05));
        CHECK(pieces.components[1].area == doctest::Approx(4));
    }
    TEST_CASE("no faces, and faces of no area") {
        CHECK(find_components(mesh{}).components.empty());
        const mesh point = support::triangles({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
        const mesh_components pieces = find_components(point);
        REQUIRE(pieces.components.size() == 1);
        CHECK(pieces.components[0].area == 0);
        CHECK(pieces.components[0].diameter == 0);
    }
}
