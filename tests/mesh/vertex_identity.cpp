#include <billow/mesh/vertex_identity.hpp>

#include <algorithm>
#include <limits>

#include <doctest/doctest.h>

#include <billow/shapes/box.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("mesh/vertex_identity") {
    TEST_CASE("a box has eight vertices, whatever its normals and uvs say") {
        const mesh m = box();
        const vertex_identity identity = position_ids(m);
        CHECK(m.vertex_count() == 24);
        CHECK(identity.count == 8);
        for (std::size_t i = 0; i < 24; ++i) {
            for (std::size_t j = 0; j < 24; ++j) {
                CHECK((identity.id[i] == identity.id[j]) == (m.positions[i] == m.positions[j]));
            }
        }
    }
    TEST_CASE("ids come in the order of first occurrence") {
        const mesh m = support::triangles({{1, 0, 0},
                                           {0, 0, 0},
                                           {1, 0, 0},  //
                                           {2, 0, 0},
                                           {-0.0f, 0, -0.0f},
                                           {1, 0, 0}});
        CHECK(position_ids(m).id == std::vector<std::uint32_t>{0, 1, 0, 2, 1, 0});
        CHECK(position_ids(m).count == 3);
    }
    TEST_CASE("without tolerance the next number is another place") {
        const float next = std::nextafter(1.0f, 2.0f);
        const mesh m = support::triangles({{1, 0, 0}, {next, 0, 0}, {0, 1, 0}});
        CHECK(position_ids(m).count == 3);
        CHECK(position_ids(m, 1e-6).count == 2);
    }
    TEST_CASE("with a tolerance points join as comparing all pairs would") {
        const mesh m = support::random_triangles(150, 0.3, 4);
        for (const double tolerance : {0.01, 0.05, 0.1, 0.4}) {
            const auto size = static_cast<std::uint32_t>(m.vertex_count());
            disjoint_sets sets(size);
            for (std::uint32_t i = 0; i < size; ++i) {
                for (std::uint32_t j = 0; j < i; ++j) {
                    const dvec3 apart = dvec3(m.positions[i]) - dvec3(m.positions[j]);
                    if (glm::length(apart) <= tolerance) sets.join(i, j);
                }
            }
            const vertex_identity identity = position_ids(m, tolerance);
            std::size_t count = 0;
            CHECK(identity.id == sets.numbers(count));
            CHECK(identity.count == count);
        }
    }
    TEST_CASE("points join over the borders of cells, and far from the origin") {
        for (const float far : {0.0f, 1e4f, -1e4f}) {
            const mesh m = support::triangles(
                {{far - 0.01f, 0.01f, 0}, {far + 0.01f, -0.01f, 0}, {far, 1, 0}});
            CHECK(position_ids(m, 0.05).count == 2);
        }
    }
    TEST_CASE("unused vertices that are not numbers are nobody else") {
        mesh m = support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
        m.positions.resize(20, vec3(std::numeric_limits<float>::quiet_NaN()));
        m.positions.push_back(vec3(std::numeric_limits<float>::infinity()));
        for (const double tolerance : {0.0, 0.1}) CHECK(position_ids(m, tolerance).count == 21);
    }
    TEST_CASE("corners of a face table meet where the vertices of its mesh do") {
        const mesh m = teapot(3);
        const face_table faces = support::table_of(m);
        const vertex_identity vertices = position_ids(m);
        const vertex_identity corners = position_ids(faces);
        CHECK(vertices.count == corners.count);
        REQUIRE(corners.id.size() == 3 * faces.size);
        std::vector<std::uint32_t> vertex_of(corners.count, no_id);
        for (std::size_t row = 0; row < faces.size; ++row) {
            const uvec3 t = m.triangles[faces.source[row]];
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t vertex = vertices.id[t[static_cast<glm::length_t>(k)]];
                std::uint32_t& known = vertex_of[corners.id[k * faces.size + row]];
                if (known == no_id) known = vertex;
                CHECK(known == vertex);
            }
        }
    }
    TEST_CASE("a mesh without vertices has none") {
        CHECK(position_ids(mesh{}).count == 0);
        CHECK(position_ids(mesh{}, 1).count == 0);
        CHECK(position_ids(face_table{}).id.empty());
    }
}
