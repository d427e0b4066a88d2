#include <billow/mesh/face_table.hpp>

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("mesh/face_table") {
    TEST_CASE("a face has corners around the centre, a unit normal, its area and its reach") {
        const face_table faces =
            support::table_of(support::triangles({{10, 0, 0}, {12, 0, 0}, {10, 4, 0}}));
        REQUIRE(faces.size == 1);
        CHECK(faces.bounds.centre == dvec3(11, 2, 0));
        CHECK(faces.corner[0].get(0) == dvec3(-1, -2, 0));
        CHECK(faces.corner[2].get(0) == dvec3(-1, 2, 0));
        CHECK(faces.normal.get(0) == dvec3(0, 0, 1));
        CHECK(faces.area[0] == 4);
        CHECK(faces.reach[0] == doctest::Approx(std::sqrt(5.0)));
        CHECK(faces.centroid(0).x == doctest::Approx(-1.0 / 3));
        CHECK(faces.source[0] == 0);
    }
    TEST_CASE("columns are padded with faces of area zero") {
        const face_table faces = support::table_of(support::random_triangles(21, 0.2, 1));
        CHECK(faces.size == 21);
        CHECK(faces.padded_size() == simd::padded(21));
        for (std::size_t row = 21; row < faces.padded_size(); ++row) {
            CHECK(faces.area[row] == 0);
            CHECK(faces.corner[1].y[row] == 0);
        }
    }
    TEST_CASE("degenerate faces are set aside and counted") {
        mesh m = support::random_triangles(3, 0.2, 2);
        const auto n = static_cast<std::uint32_t>(m.vertex_count());
        m.positions.insert(m.positions.end(), {{0, 0, 0}, {0.1f, 0.1f, 0.1f}, {0.2f, 0.2f, 0.2f}});
        m.triangles.insert(m.triangles.begin() + 1, {{n, n + 1, n + 2}, {0, 0, 1}});
        const face_table faces = support::table_of(m);
        CHECK(faces.size == 3);
        CHECK(faces.degenerate == std::vector<face_id>{1, 2});
        CHECK(faces.source == std::vector<face_id>{0, 3, 4});
    }
    TEST_CASE("a mesh of nothing but degenerate faces gives an empty table") {
        const face_table faces =
            support::table_of(support::triangles({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}));
        CHECK(faces.size == 0);
        CHECK(faces.degenerate.size() == 1);
        CHECK(support::table_of(mesh{}).size == 0);
    }
    TEST_CASE("the first face that is not finite is named") {
        for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
            mesh m = support::random_triangles(50, 0.2, 3);
            m.positions[3 * 17 + 1].y = bad;
            m.positions[3 * 30].x = bad;
            const auto faces = make_face_table(m);
            REQUIRE_FALSE(faces);
            CHECK(faces.error().code == error_code::not_finite);
            CHECK(faces.error().message.find("face 17 ") != std::string::npos);
        }
    }
    TEST_CASE("an index past the last vertex is refused") {
        mesh m = support::random_triangles(5, 0.2, 3);
        m.triangles[4].z = 15;
        const auto faces = make_face_table(m);
        REQUIRE_FALSE(faces);
        CHECK(faces.error().code == error_code::out_of_range);
        CHECK(faces.error().message.find("face 4 ") != std::string::npos);
    }
    TEST_CASE("a size whose areas leave the range of floats is refused") {
        CHECK_FALSE(make_face_table(support::triangles({{0, 0, 0}, {1e20f, 0, 0}, {0, 1e20f, 0}})));
        CHECK_FALSE(
            make_face_table(support::triangles({{0, 0, 0}, {1e-20f, 0, 0}, {0, 1e-20f, 0}})));
        CHECK(make_face_table(support::triangles({{0, 0, 0}, {1e-6f, 0, 0}, {0, 1e-6f, 0}})));
    }
    TEST_CASE("select_rows keeps the rows that it is given, in their order") {
        const face_table faces = support::table_of(support::random_triangles(40, 0.2, 4));
        const std::vector<std::uint32_t> rows{30, 2, 39};
        const face_table selected = select_rows(faces, rows);
        REQUIRE(selected.size == 3);
        for (std::size_t i = 0; i < 3; ++i) {
            CHECK(selected.source[i] == faces.source[rows[i]]);
            CHECK(selected.corner[2].get(i) == faces.corner[2].get(rows[i]));
            CHECK(selected.area[i] == faces.area[rows[i]]);
        }
        CHECK(selected.area[3] == 0);
    }
}
