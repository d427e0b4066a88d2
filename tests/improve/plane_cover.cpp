#include <billow/improve/plane_cover.hpp>

#include <doctest/doctest.h>

#include "support/covers.hpp"

using namespace billow;

namespace {

/// Plates at heights 0, 0.1 and 0.2.
mesh three_plates() {
    mesh m;
    for (const float z : {0.0f, 0.1f, 0.2f}) support::add_level_plate(m, {0, 0, z}, 1);
    return m;
}

}  // namespace

TEST_SUITE("improve/plane_cover") {
    TEST_CASE("counts are those of a walk over all planes and faces") {
        const face_table faces = support::table_of(support::random_triangles(300, 0.1, 4));
        random_stream random(9);
        std::vector<plane> planes;
        for (int i = 0; i < 12; ++i) {
            planes.push_back({support::random_direction(random), random.between(-0.5, 0.5)});
        }
        plane_cover cover(faces, planes, 0.2, 0, {});
        cover.move(3, planes[5], cover.rows_for(planes[5]));
        cover.remove(7);
        planes[3] = planes[5];
        planes.erase(planes.begin() + 7);
        CHECK(cover.planes() == planes);
        CHECK(cover.origin(6) == 6);
        CHECK(cover.origin(7) == 8);
        for (std::uint32_t row = 0; row < faces.size; ++row) {
            std::uint32_t count = 0;
            for (plane_id id = 0; id < planes.size(); ++id) {
                const bool is_valid = std::ranges::binary_search(cover.valid(id), row);
                CHECK(is_valid ==
                      (distances_to(planes[id], faces, row).largest <= cover.epsilon()));
                if (is_valid) ++count;
            }
            CHECK(cover.counts()[row] == count);
        }
    }
    TEST_CASE("essential faces are those of one plane, those of a pair of two") {
        const mesh m = three_plates();
        const face_table faces = support::table_of(m);
        const plane_cover cover = support::level_cover(faces, {0.04, 0.12, 0.2}, 0.07);
        CHECK(cover.essential(0).size() == 128);
        CHECK(cover.essential(1).empty());
        CHECK(cover.essential(2).size() == 128);
        CHECK(cover.essential_pairs().size() == 1);
        const plane_pair pair = cover.essential_pairs()[0];
        CHECK(pair.first == 0);
        CHECK(pair.second == 1);
        CHECK(pair.rows.size() == 128);
        for (const std::uint32_t row : pair.rows) {
            CHECK(faces.centroid(row).z == doctest::Approx(0));  // the middle one
        }
    }
    TEST_CASE("planes that a face is too steep for may not take it") {
        mesh m;
        support::add_square(m, {0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0});
        support::add_square(m, {1, 0, 0}, {0.05f, 0, 0.05f}, {0, 0.1f, 0});
        const face_table faces = support::table_of(m);
        const plane level{{0, 0, 1}, 0};
        CHECK(plane_cover(faces, {level}, 0.2, 0, {}).valid(0).size() == 4);
        CHECK(plane_cover(faces, {level}, 0.2, 0.8f, {}).valid(0).size() == 2);
    }
    TEST_CASE("the bound holds for the mesh's own vertices") {
        const mesh m = three_plates();
        const face_table faces = support::table_of(m);
        CHECK(support::level_cover(faces, {0.05}, 0.05).valid(0).empty());
        CHECK(support::level_cover(faces, {0.05}, 0.0501).valid(0).size() == 256);
    }
}
