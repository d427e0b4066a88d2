#include <billow/improve/joint_plane.hpp>

#include <numeric>

#include <doctest/doctest.h>

#include "support/clouds.hpp"

using namespace billow;

namespace {

face_rows all_rows(const face_table& faces) {
    face_rows rows(faces.size);
    std::iota(rows.begin(), rows.end(), 0u);
    return rows;
}

double width_along(const face_table& faces, const dvec3& normal) {
    return extent_along(faces, all_rows(faces), normal).width();
}

std::optional<plane> joint(const face_table& faces, const dvec3& start, double epsilon) {
    const face_rows rows = all_rows(faces);
    return joint_plane(faces, rows, extreme_rows(faces, rows), std::span(&start, 1), epsilon);
}

}  // namespace

TEST_SUITE("improve/joint_plane") {
    TEST_CASE("an extent names the rows at its ends") {
        const face_table faces = support::table_of(support::random_triangles(50, 0.1, 2));
        const dvec3 n = glm::normalize(dvec3(1, -2, 0.5));
        const face_extent_along e = extent_along(faces, all_rows(faces), n);
        double low = 1e9, high = -1e9;
        for_each_corner(faces, [&](const dvec3& corner) {
            low = std::min(low, glm::dot(n, corner));
            high = std::max(high, glm::dot(n, corner));
        });
        CHECK(e.low == low);
        CHECK(e.high == high);
        CHECK(extent_along(faces, face_rows{e.low_row}, n).low == low);
        CHECK(extent_along(faces, face_rows{e.high_row}, n).high == high);
    }
    TEST_CASE("the width of a tetrahedron is the least of any direction") {
        random_stream random(3);
        for (int i = 0; i < 20; ++i) {
            std::array<dvec3, 4> corners;
            for (dvec3& c : corners) {
                c = {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
            }
            const double width = detail::tetrahedron_width(corners);
            double least = 1e9;
            for (int k = 0; k < 4000; ++k) {
                const dvec3 n = support::random_direction(random);
                double low = 1e9, high = -1e9;
                for (const dvec3& c : corners) {
                    low = std::min(low, glm::dot(n, c));
                    high = std::max(high, glm::dot(n, c));
                }
                least = std::min(least, high - low);
            }
            CHECK(width <= least + 1e-12);
            CHECK(width > least - 0.1);
        }
        const dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
        CHECK(detail::tetrahedron_width({dvec3(0), x, y, x + y}) == 0);
        CHECK(detail::tetrahedron_width({dvec3(0), x, y, z}) ==
              doctest::Approx(1 / std::sqrt(3.0)));
    }
    TEST_CASE("the bound of a width is never above it") {
        random_stream random(8);
        for (std::uint64_t seed = 1; seed < 12; ++seed) {
            const face_table faces = support::table_of(support::random_triangles(30, 0.2, seed));
            const face_rows rows = all_rows(faces);
            const double bound =
                detail::least_width(faces, rows, detail::wide_triangle(faces, rows));
            CHECK(bound > 0.1);
            for (int k = 0; k < 500; ++k) {
                CHECK(bound <= width_along(faces, support::random_direction(random)) + 1e-9);
            }
        }
    }
    TEST_CASE("finds the plane of faces just narrow enough, from a start far off, and no other") {
        random_stream random(1);
        const plane truth{glm::normalize(dvec3(0.3, 0.2, 0.9)), 0.1};
        const frame axes = frame_around(truth.normal);
        std::vector<vec3> corners;
        for (int i = 0; i < 900; ++i) {
            corners.emplace_back(axes.to_scene(
                {random.between(-1, 1), random.between(-1, 1), 0.1 + random.between(-0.05, 0.05)}));
        }
        const face_table faces = support::table_of(support::triangles(corners));
        const double half = width_along(faces, truth.normal) / 2;
        for (const double off : {0.0, 0.2, 0.5}) {
            const dvec3 start = glm::normalize(truth.normal + off * axes.u - off * axes.v);
            const auto found = joint(faces, start, half * 1.03);
            REQUIRE(found);
            for_each_corner(faces, [&](const dvec3& corner) {
                CHECK(std::abs(signed_distance(*found, corner)) <= half * 1.03 + 1e-12);
            });
            CHECK(!joint(faces, start, half * 0.9));
        }
    }
    TEST_CASE("two small groups far apart have a plane through both") {
        mesh m;
        support::add_square(m, {0, 0, 0}, {0.05f, 0, 0}, {0, 0.05f, 0});
        support::add_square(m, {1, 1, 1}, {0, 0.05f, 0}, {0, 0, 0.05f});
        const face_table faces = support::table_of(m);
        const face_rows rows = all_rows(faces);
        const auto normals = detail::joint_normals({0, 0, 1}, {1, 0, 0}, dvec3(1, 1, 1));
        CHECK(joint_plane(faces, rows, rows, normals, 0.06));
        CHECK(!joint_plane(faces, rows, rows, normals, 0.01));
    }
}
