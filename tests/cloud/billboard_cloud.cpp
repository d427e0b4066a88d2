#include <billow/cloud/billboard_cloud.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("cloud/billboard_cloud") {
    TEST_CASE("faces are listed by plane, ascending, those without a plane nowhere") {
        const std::vector<plane_id> plane_of_face{2, 0, no_id, 2, 0, 2};
        const faces_of_planes faces(plane_of_face, 4);
        const auto list = [&](plane_id id) {
            return std::vector<face_id>(faces[id].begin(), faces[id].end());
        };
        CHECK(list(0) == std::vector<face_id>{1, 4});
        CHECK(list(1).empty());
        CHECK(list(2) == std::vector<face_id>{0, 3, 5});
        CHECK(list(3).empty());
    }
    TEST_CASE("no faces and no planes are fine") {
        const faces_of_planes faces({}, 0);
        CHECK(billboard_cloud{}.plane_count() == 0);
    }

    TEST_CASE("the also-drawn faces of a plane are found") {
        billow::billboard_cloud cloud;
        CHECK(cloud.also_drawn_on(0).empty());
        cloud.also_drawn = {{1, 5}, {1, 7}, {3, 0}};
        CHECK(cloud.also_drawn_on(0).empty());
        REQUIRE(cloud.also_drawn_on(1).size() == 2);
        CHECK(cloud.also_drawn_on(1)[1].face == 7);
        CHECK(cloud.also_drawn_on(2).empty());
        CHECK(cloud.also_drawn_on(3).size() == 1);
        CHECK(cloud.also_drawn_on(4).empty());
    }
}
