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
}
