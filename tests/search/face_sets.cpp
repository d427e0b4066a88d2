#include <billow/search/face_sets.hpp>

#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

#include <billow/plane_space/cube_map.hpp>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("search/face_sets") {
    TEST_CASE("the valid faces are those of brute force, for any thread count") {
        const face_table faces = support::table_of(support::random_triangles(30000, 0.1, 1));
        const plane p{glm::normalize(dvec3(1, -2, 0.5)), 0.2};
        face_rows expected;
        for (std::uint32_t row = 0; row < faces.size; ++row) {
            bool is_valid = true;
            for (const columns3& corner : faces.corner) {
                is_valid &= std::abs(signed_distance(p, corner.get(row))) <= 0.1;
            }
            if (is_valid) expected.push_back(row);
        }
        REQUIRE(expected.size() > 1000);
        for (const unsigned threads : {1u, 2u, 3u, 8u}) {
            CHECK(faces_valid_for(faces, p, 0.1, {threads}) == expected);
        }
    }
    TEST_CASE("padding is never valid") {
        const face_table faces = support::table_of(support::random_triangles(17, 0.1, 1));
        CHECK(faces_valid_for(faces, {{0, 0, 1}, 0}, 100).size() == 17);
    }
    TEST_CASE("a bin's candidates hold every face with a valid plane in it") {
        const cube_map space(18);
        const face_table faces = support::table_of(support::random_triangles(2000, 0.1, 2));
        const orientation_patch patch = space.patch(100);
        const face_rows candidates = faces_valid_for_bin(faces, cell_of_patch(space, patch), 0.2,
                                                         0.27, 0.1, widened_centre{});
        CHECK(candidates.size() < faces.size);
        random_stream random(3);
        for (int i = 0; i < 50; ++i) {
            const dvec2 at(random.between(-1, 1), random.between(-1, 1));
            const plane p{space.direction_at(patch.chart, patch.centre + patch.half_size * at),
                          random.between(0.2, 0.27)};
            for (const std::uint32_t row : faces_valid_for(faces, p, 0.1)) {
                REQUIRE(std::binary_search(candidates.begin(), candidates.end(), row));
            }
        }
    }
    TEST_CASE("contribution is the sum of the projected areas") {
        mesh m;
        support::add_square(m, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
        support::add_square(m, {0, 0, 0}, {1, 0, 0}, {0, 0, 1});
        const face_table faces = support::table_of(m);
        CHECK(contribution_of(faces, {0, 1, 2, 3}, {0, 0, 1}, projected_area{}) ==
              doctest::Approx(4));
        CHECK(contribution_of(faces, {0}, {0, 0, 1}, projected_area{}) == doctest::Approx(2));
    }
    TEST_CASE("a supporting plane holds its face") {
        const face_table faces = support::table_of(support::random_triangles(50, 0.3, 4));
        for (std::size_t row = 0; row < faces.size; ++row) {
            const plane p = supporting_plane(faces, row);
            for (const columns3& corner : faces.corner) {
                CHECK(std::abs(signed_distance(p, corner.get(row))) < 1e-6);
            }
        }
    }
    TEST_CASE("a normal threshold takes away exactly the faces that deviate more") {
        const face_table faces = support::table_of(support::random_triangles(5000, 0.1, 6));
        const plane p{glm::normalize(dvec3(1, -2, 0.5)), 0.1};
        const within_angle worth{projected_area{}, 25};
        face_rows expected;
        for (const std::uint32_t row : faces_valid_for(faces, p, 0.1)) {
            const double cosine = std::abs(glm::dot(faces.normal.get(row), p.normal));
            if (cosine >= double(worth.least_cosine)) expected.push_back(row);
        }
        REQUIRE(expected.size() > 10);
        CHECK(faces_valid_for(faces, p, 0.1, worth) == expected);
        CHECK(faces_valid_for(faces, p, 0.1, projected_area{}) == faces_valid_for(faces, p, 0.1));

        const cube_map space(18);
        const orientation_cell cell = space.cell(space.orientation_of(p.normal));
        const face_rows candidates =
            faces_valid_for_bin(faces, cell, 0.05, 0.15, 0.1, widened_centre{}, worth);
        CHECK(std::ranges::includes(candidates, expected));
        CHECK(candidates.size() <
              faces_valid_for_bin(faces, cell, 0.05, 0.15, 0.1, widened_centre{}).size());
    }
    TEST_CASE("any threshold lets a face's own plane take it") {
        const face_table faces = support::table_of(support::random_triangles(500, 0.2, 5));
        for (std::uint32_t row = 0; row < faces.size; ++row) {
            const face_rows rows = faces_valid_for(faces, supporting_plane(faces, row), 0.01,
                                                   within_angle{angular_area{}, 0});
            CHECK(std::ranges::binary_search(rows, row));
        }
    }
}
