#include <billow/reduce.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>

#include <billow/geometry/bounds.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/roles.hpp>
#include <billow/mesh/validate.hpp>
#include <billow/plants/species.hpp>
#include <billow/shapes/sphere.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

mesh trunk_of_a_tree() {
    const mesh tree = *tree_of_about(4000);
    return select_faces(tree, find_roles(tree).faces_of(face_role::solid));
}

/// All that a vertex is.
std::vector<float> row_of(const mesh& m, std::uint32_t v) {
    const vec3& p = m.positions[v];
    std::vector<float> row{p.x, p.y, p.z};
    if (!m.normals.empty()) row.insert(row.end(), &m.normals[v].x, &m.normals[v].x + 3);
    if (!m.uv_sets[0].empty()) row.insert(row.end(), &m.uv_sets[0][v].x, &m.uv_sets[0][v].x + 2);
    return row;
}

}  // namespace

TEST_SUITE("reduce") {
    TEST_CASE("about the asked share of the triangles is left, close to where they were") {
        const mesh ball = icosphere(5);
        for (const double share : {0.5, 0.2, 0.05}) {
            const reduced_mesh reduced = reduce_mesh(ball, share);
            const auto wanted = share * static_cast<double>(ball.face_count());
            CHECK(static_cast<double>(reduced.mesh.face_count()) ==
                  doctest::Approx(wanted).epsilon(0.05));
            CHECK(reduced.error > 0);
            CHECK(reduced.error < 0.03);
            for (face_id face = 0; face < reduced.mesh.face_count(); ++face) {
                const auto [a, b, c] = reduced.mesh.corners(face);
                CHECK(glm::length((a + b + c) / 3.0f) > 0.9f);
            }
        }
    }
    TEST_CASE("fewer triangles, larger errors, and never beyond the largest one allowed") {
        const mesh pot = teapot(6);
        const double none = reduce_mesh(pot, 0.5).error;
        CHECK(reduce_mesh(pot, 0.1).error > none);
        const reduced_mesh held = reduce_mesh(pot, 0.01, none);
        CHECK(held.error <= none * (1 + 1e-6));
        CHECK(held.mesh.face_count() > reduce_mesh(pot, 0.01).mesh.face_count());
    }
    TEST_CASE("every vertex is one of the source, with all of its attributes") {
        const mesh trunk = trunk_of_a_tree();
        const mesh reduced = reduce_mesh(trunk, 0.5).mesh;
        REQUIRE(validate(reduced));
        CHECK(reduced.face_count() < 0.6 * static_cast<double>(trunk.face_count()));
        CHECK(reduced.materials.size() == trunk.materials.size());
        CHECK(reduced.images == trunk.images);
        std::set<std::vector<float>> known;
        for (std::uint32_t v = 0; v < trunk.vertex_count(); ++v) known.insert(row_of(trunk, v));
        for (std::uint32_t v = 0; v < reduced.vertex_count(); ++v) {
            CHECK(known.count(row_of(reduced, v)) == 1);
        }
    }
    TEST_CASE("a border between materials stays closed") {
        mesh ball = icosphere(4);
        ball.materials = {{.name = "north"}, {.name = "south"}};
        for (face_id face = 0; face < ball.face_count(); ++face) {
            const auto [a, b, c] = ball.corners(face);
            ball.face_materials.push_back(a.y + b.y + c.y > 0 ? 0 : 1);
        }
        const mesh reduced = reduce_mesh(ball, 0.3).mesh;
        CHECK(reduced.materials.size() == 2);
        // A closed surface has every edge twice, once in each direction.
        std::set<std::vector<float>> edges;
        std::size_t sides = 0;
        for (face_id face = 0; face < reduced.face_count(); ++face) {
            const auto corners = reduced.corners(face);
            for (std::size_t k = 0; k < 3; ++k, ++sides) {
                const vec3& a = corners[k];
                const vec3& b = corners[(k + 1) % 3];
                edges.insert({a.x, a.y, a.z, b.x, b.y, b.z});
            }
        }
        CHECK(edges.size() == sides);
        for (const auto& e : edges) {
            CHECK(edges.count({e[3], e[4], e[5], e[0], e[1], e[2]}) == 1);
        }
        for (face_id face = 0; face < reduced.face_count(); ++face) {
            const auto [a, b, c] = reduced.corners(face);
            const float y = (a.y + b.y + c.y) / 3;
            if (std::abs(y) > 0.2f) CHECK(reduced.face_materials[face] == (y > 0 ? 0 : 1));
        }
    }
    TEST_CASE("unwelded triangles of equal corners are reduced as the surface that they are") {
        const mesh ball = icosphere(4);
        mesh loose;
        for (const uvec3& t : ball.triangles) {
            for (int k = 0; k < 3; ++k) loose.positions.push_back(ball.positions[t[k]]);
            loose.triangles.push_back(uvec3(0, 1, 2) +
                                      3u * static_cast<std::uint32_t>(loose.triangles.size()));
        }
        CHECK(reduce_mesh(loose, 0.2).mesh.face_count() < 0.25 * 5120);
    }
    TEST_CASE("nothing, and all of it, stay as they are") {
        CHECK(reduce_mesh(mesh{}, 0.5).mesh.face_count() == 0);
        const mesh pot = teapot(3);
        CHECK(reduce_mesh(pot, 1).mesh.triangles == pot.triangles);
        CHECK(reduce_mesh(support::triangles({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), 0.5)
                  .mesh.face_count() <= 1);
    }
    TEST_CASE("merged sloppily, facets with normals of their own become as few as asked for") {
        const mesh ball = icosphere(4);
        mesh facets;
        for (face_id face = 0; face < ball.face_count(); ++face) {
            const auto corners = ball.corners(face);
            const vec3 normal = glm::normalize(corners[0] + corners[1] + corners[2]);
            for (const vec3& p : corners) {
                facets.positions.push_back(p);
                facets.normals.push_back(normal);
            }
            facets.triangles.push_back(uvec3(0, 1, 2) + 3u * face);
        }
        CHECK(reduce_mesh(facets, 0.05).mesh.face_count() > 0.5 * 5120);
        const reduced_mesh merged = reduce_mesh_sloppily(facets, 0.05);
        CHECK(merged.mesh.face_count() > 50);
        CHECK(merged.mesh.face_count() <= 256);
        CHECK(merged.error > 0);
        CHECK(validate(merged.mesh));
    }
    TEST_CASE("merged sloppily, every vertex keeps its attributes and every face a material") {
        const mesh trunk = trunk_of_a_tree();
        const mesh merged = reduce_mesh_sloppily(trunk, 0.3).mesh;
        REQUIRE(validate(merged));
        CHECK(merged.face_count() <= 0.31 * static_cast<double>(trunk.face_count()));
        CHECK(merged.images == trunk.images);
        std::set<std::vector<float>> known;
        for (std::uint32_t v = 0; v < trunk.vertex_count(); ++v) known.insert(row_of(trunk, v));
        for (std::uint32_t v = 0; v < merged.vertex_count(); ++v) {
            CHECK(known.count(row_of(merged, v)) == 1);
        }
        CHECK(reduce_mesh_sloppily(mesh{}, 0.5).mesh.face_count() == 0);
        CHECK(reduce_mesh_sloppily(trunk, 1).mesh.triangles == trunk.triangles);
    }
}
