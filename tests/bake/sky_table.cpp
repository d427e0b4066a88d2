#include <billow/bake/sky_table.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("bake/sky_table") {
    TEST_CASE("between corners views are mixed, at a corner there is its own") {
        const sky_table sky{{uvec3(0, 2, 1)},
                            {{1, vec4(0, 0, 1, 1)}, {0, vec4(0)}, {0.5f, vec4(0.25f, 0, 0, 0.5f)}}};
        CHECK(sky.at(0, {0, 1, 0}).open == 0.5f);
        CHECK(sky.at(0, {0, 0, 1}).open == 0);
        const sky_view mixed = sky.at(0, {0.5f, 0.5f, 0});
        CHECK(mixed.open == 0.75f);
        CHECK(mixed.visible == vec4(0.125f, 0, 0.5f, 0.75f));
    }
}
