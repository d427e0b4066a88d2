#include <billow/shapes/leaf_soup.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("shapes/leaf_soup") {
    TEST_CASE("as many faces as asked, even or odd") {
        for (const std::size_t count : {0u, 1u, 2u, 7u, 1000u}) {
            CHECK(leaf_soup(count).face_count() == count);
        }
        CHECK(leaf_soup(113016).face_count() == 113016);
    }

    TEST_CASE("leaves are squares of the given edge") {
        const mesh soup = leaf_soup(200, {.edge = 0.1f});
        for (face_id f = 0; f < soup.face_count(); ++f) {
            const auto [a, b, c] = soup.corners(f);
            const vec3 n = glm::cross(b - a, c - a);
            CHECK(glm::length(n) == doctest::Approx(0.01).epsilon(1e-4));
            CHECK(glm::dot(n, soup.normals[soup.triangles[f].x]) > 0);
        }
    }

    TEST_CASE("centres fill the ball evenly and normals every direction") {
        const mesh soup = leaf_soup(40000, {.edge = 0.001f});
        int inner = 0, up = 0;
        for (face_id f = 0; f < soup.face_count(); ++f) {
            const float r = glm::length(soup.corners(f)[0]);
            CHECK(r < 1.001f);
            inner += r < 0.5f;
            up += soup.normals[soup.triangles[f].x].y > 0.5f;
        }
        CHECK(inner / 40000.0 == doctest::Approx(1 / 8.0).epsilon(0.05));
        CHECK(up / 40000.0 == doctest::Approx(1 / 4.0).epsilon(0.05));
    }

    TEST_CASE("the seed alone decides") {
        CHECK(leaf_soup(100).positions == leaf_soup(100).positions);
        CHECK(leaf_soup(100).positions != leaf_soup(100, {.seed = 2}).positions);
    }
}
