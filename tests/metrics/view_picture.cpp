#include <billow/metrics/view_picture.hpp>

#include <doctest/doctest.h>

TEST_SUITE("metrics/view_picture") {
    using namespace billow;

    TEST_CASE("pixels lie row by row") {
        view_picture picture{3, 2, std::vector<vec4>(6, vec4(0))};
        picture.at(1, 1) = vec4(1, 2, 3, 4);
        CHECK(picture.pixels[4] == vec4(1, 2, 3, 4));
        const view_picture copy = picture;
        CHECK(copy == picture);
        CHECK(copy.at(1, 1).w == 4);
    }
}
