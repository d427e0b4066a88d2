#include <billow/improve/serve_most.hpp>

#include <numeric>

#include <doctest/doctest.h>

#include "support/clouds.hpp"

using namespace billow;

namespace {

/// Area of the wanted rows at an offset, or < 0 where a kept one is beyond epsilon.
double area_at(const face_table& faces, const face_rows& kept, const face_rows& wanted,
               const plane& p, double epsilon) {
    for (const std::uint32_t row : kept) {
        if (distances_to(p, faces, row).largest > epsilon) return -1;
    }
    double area = 0;
    for (const std::uint32_t row : wanted) {
        if (distances_to(p, faces, row).largest <= epsilon) area += double(faces.area[row]);
    }
    return area;
}

}  // namespace

TEST_SUITE("improve/serve_most") {
    TEST_CASE("the offset is that of a walk over many offsets, or better") {
        const face_table faces = support::table_of(support::random_triangles(120, 0.08, 5));
        random_stream random(4);
        const double epsilon = 0.15;
        for (int i = 0; i < 30; ++i) {
            const dvec3 n = support::random_direction(random);
            const face_rows kept = i % 2 == 0 ? face_rows{} : face_rows{1};
            face_rows wanted;
            for (std::uint32_t row = 2; row < faces.size; ++row) wanted.push_back(row);
            const served_faces found = most_served(faces, kept, wanted, epsilon).at(n);
            double best = -1;
            for (double rho = -1; rho <= 1; rho += 0.001) {
                best = std::max(best, area_at(faces, kept, wanted, {n, rho}, epsilon));
            }
            CHECK(found.area >= best * (1 - 1e-9));
            CHECK(area_at(faces, kept, wanted, found.plane, epsilon * (1 + 1e-9)) ==
                  doctest::Approx(found.area));
        }
    }
    TEST_CASE("a normal that no offset suits for the kept faces says by how much") {
        mesh m;
        support::add_level_plate(m, {0, 0, 0}, 1);
        const face_table faces = support::table_of(m);
        face_rows kept(faces.size);
        std::iota(kept.begin(), kept.end(), 0u);
        const served_faces found = most_served(faces, kept, {}, 0.1).at({1, 0, 0});
        CHECK(found.area == doctest::Approx(0.2 - 2));
    }
    TEST_CASE("the plane turns to what it can serve and keeps what it must") {
        mesh m;
        support::add_level_plate(m, {0, 0, 0}, 0.3f);
        support::add_level_plate(m, {1.5f, 0, 0.3f}, 0.1f);
        support::add_level_plate(m, {0, 0, 1.5f}, 0.1f);
        const face_table faces = support::table_of(m);
        face_rows kept(128), wanted(256);
        std::iota(kept.begin(), kept.end(), 0u);
        std::iota(wanted.begin(), wanted.end(), 128u);
        const std::vector<dvec3> start{{0, 0, 1}};
        const served_faces found = most_served(faces, kept, wanted, 0.1).near(start);
        CHECK(found.area == doctest::Approx(0.04));
        CHECK(area_at(faces, kept, wanted, found.plane, 0.1 + 1e-9) == doctest::Approx(0.04));
    }
    TEST_CASE("nothing wanted, nothing kept") {
        const face_table faces = support::table_of(support::random_triangles(3, 0.1, 1));
        const served_faces found = most_served(faces, {}, {}, 0.1).at({0, 0, 1});
        CHECK(found.area == 0);
        CHECK(std::isfinite(found.plane.rho));
    }
}
