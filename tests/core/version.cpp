#include <billow/core/version.hpp>

#include <string>

#include <doctest/doctest.h>

TEST_SUITE("core/version") {
    TEST_CASE("the text is made of the three numbers") {
        CHECK(std::string(BILLOW_VERSION) == std::to_string(BILLOW_VERSION_MAJOR) + "." +
                                                 std::to_string(BILLOW_VERSION_MINOR) + "." +
                                                 std::to_string(BILLOW_VERSION_PATCH));
    }
}
