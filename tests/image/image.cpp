#include <billow/image/image.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("image/image") {
    TEST_CASE("pixels lie in rows from the top, channels together") {
        image i = image::filled(3, 2, 4, 9);
        CHECK(i.bytes.size() == 24);
        i.pixel(2, 1)[3] = 7;
        CHECK(i.bytes[23] == 7);
        CHECK(i.pixel(0, 0)[0] == 9);
    }
    TEST_CASE("a unit value becomes its nearest byte, whatever it is") {
        CHECK(byte_from_unit(0) == 0);
        CHECK(byte_from_unit(1) == 255);
        CHECK(byte_from_unit(0.5f) == 128);
        CHECK(byte_from_unit(-3) == 0);
        CHECK(byte_from_unit(9) == 255);
        CHECK(byte_from_unit(std::nanf("")) == 0);
    }
}
