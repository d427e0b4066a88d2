#include <billow/search/fail_safe.hpp>

#include <doctest/doctest.h>

#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("search/fail_safe") {
    TEST_CASE("the plane of the largest face serves it") {
        const face_table faces = support::table_of(support::random_triangles(200, 0.5, 6));
        const std::uint32_t row = largest_face(faces);
        for (std::size_t i = 0; i < faces.size; ++i) CHECK(faces.area[i] <= faces.area[row]);
        const face_rows served = faces_valid_for(faces, plane_of_largest_face(faces), 1e-5);
        CHECK(std::ranges::count(served, row) == 1);
    }
    TEST_CASE("the plane collects at least what the centre and the largest face's plane collect") {
        const face_table faces = support::table_of(leaf_soup(400, {.edge = 0.2f}));
        const double epsilon = 0.05;
        const auto collected = [&](const plane& p) {
            return contribution_of(faces, faces_valid_for(faces, p, epsilon), p.normal,
                                   projected_area{});
        };
        random_stream random(8);
        for (int i = 0; i < 10; ++i) {
            const plane centre{support::random_direction(random), random.between(-0.5, 0.5)};
            const plane best = fail_safe_plane(faces, faces, centre, epsilon, projected_area{});
            CHECK(collected(best) >= collected(centre));
            CHECK(collected(best) >= collected(plane_of_largest_face(faces)));
            CHECK(collected(best) > 0);
        }
    }
}
