#include <billow/mesh/material.hpp>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("mesh/material") {
    TEST_CASE("defaults are those of glTF 2.0") {
        const material m;
        CHECK(m.base_color == vec4(1));
        CHECK(m.metallic == 1);
        CHECK(m.roughness == 1);
        CHECK(m.alpha == alpha_mode::opaque);
        CHECK(m.alpha_cutoff == 0.5f);
        CHECK_FALSE(m.is_double_sided);
        CHECK_FALSE(m.base_color_texture.is_present());
        CHECK(m.base_color_texture.wrap_u == texture_wrap::repeat);
    }
}
