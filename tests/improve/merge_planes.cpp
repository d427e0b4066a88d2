#include <billow/improve/merge_planes.hpp>

#include <doctest/doctest.h>

#include "support/covers.hpp"

using namespace billow;

TEST_SUITE("improve/merge_planes") {
    TEST_CASE("the planes of two halves of a plate become one") {
        mesh m;
        support::add_level_plate(m, {-1, 0, 0}, 1);
        support::add_level_plate(m, {1, 0, 0.05f}, 1);
        const face_table faces = support::table_of(m);
        plane_cover cover = support::level_cover(faces, {-0.09, 0.14}, 0.1);
        CHECK(cover.essential(0).size() == 128);
        CHECK(cover.essential(1).size() == 128);
        CHECK(merge_planes(cover) == 1);
        CHECK(cover.plane_count() == 1);
        CHECK(cover.valid(0).size() == faces.size);
    }
    TEST_CASE("plates too far apart stay two") {
        mesh m;
        support::add_level_plate(m, {0, 0, 0}, 1);
        support::add_level_plate(m, {0, 0, 0.21f}, 1);
        const face_table faces = support::table_of(m);
        plane_cover cover = support::level_cover(faces, {0, 0.21}, 0.1);
        CHECK(merge_planes(cover) == 0);
        CHECK(cover.plane_count() == 2);
    }
    TEST_CASE("a plane whose faces are valid for others goes") {
        mesh m;
        for (const float z : {0.0f, 0.2f, 0.4f, 0.6f}) support::add_level_plate(m, {0, 0, z}, 1);
        const face_table faces = support::table_of(m);
        plane_cover cover = support::level_cover(faces, {0.1, 0.3, 0.5}, 0.11);
        CHECK(merge_planes(cover) == 1);
        CHECK(cover.origin(0) == 0);
        CHECK(cover.origin(1) == 2);
        for (const std::uint32_t count : cover.counts()) CHECK(count == 1);
    }
    TEST_CASE("faces of two planes that a third can take do not keep them apart") {
        mesh m;
        for (const float z : {0.0f, 0.15f, 0.3f, 0.45f}) support::add_level_plate(m, {0, 0, z}, 1);
        const face_table faces = support::table_of(m);
        // 0.3 is on the second and the third plane; without it the first two are 0.15 wide.
        plane_cover cover = support::level_cover(faces, {-0.05, 0.225, 0.375}, 0.09);
        CHECK(merge_planes(cover) == 1);
        for (const std::uint32_t count : cover.counts()) CHECK(count >= 1);
    }
    TEST_CASE("every face keeps a plane, and merging again changes nothing") {
        const face_table faces = support::table_of(support::random_triangles(200, 0.05, 6));
        std::vector<plane> planes;
        for (std::uint32_t row = 0; row < faces.size; row += 2) {
            planes.push_back(supporting_plane(faces, row));
        }
        plane_cover cover(faces, planes, 0.15, 0, {});
        const std::vector<std::uint32_t> before = cover.counts();
        const std::size_t fewer = merge_planes(cover);
        CHECK(fewer > planes.size() / 2);
        CHECK(cover.plane_count() == planes.size() - fewer);
        for (std::size_t row = 0; row < faces.size; ++row) {
            CHECK((cover.counts()[row] > 0) == (before[row] > 0));
        }
        CHECK(merge_planes(cover) == 0);
    }
    TEST_CASE("planes do not depend on threads; none and one work") {
        const face_table faces = support::table_of(support::random_triangles(300, 0.05, 7));
        std::vector<plane> planes;
        for (std::uint32_t row = 0; row < faces.size; row += 3) {
            planes.push_back(supporting_plane(faces, row));
        }
        plane_cover one(faces, planes, 0.15, 0, {1});
        plane_cover three(faces, planes, 0.15, 0, {3});
        CHECK(merge_planes(one, {1}) == merge_planes(three, {3}));
        CHECK(one.planes() == three.planes());
        plane_cover none(faces, {}, 0.1, 0, {});
        CHECK(merge_planes(none) == 0);
        plane_cover single(faces, {planes[0]}, 0.1, 0, {});
        CHECK(merge_planes(single) == 0);
    }
}
