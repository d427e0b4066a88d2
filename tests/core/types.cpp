#include <billow/core/types.hpp>

#include <doctest/doctest.h>

TEST_SUITE("core/types") {
    TEST_CASE("no id is beyond every row that 32 bits can count") {
        CHECK(billow::no_id == 0xffffffffu);
        CHECK(sizeof(billow::face_id) == 4);
        CHECK(sizeof(billow::vec3) == 12);  // columns of vec3 are what files deliver
    }
}
