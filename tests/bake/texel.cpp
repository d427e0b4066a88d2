#include <billow/bake/texel.hpp>

#include <set>
#include <utility>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("bake/texel") {
    TEST_CASE("a turned tile holds every texel once, a quarter turn clockwise") {
        const tile turned{
            .atlas = 0, .x = 10, .y = 20, .width = 3, .height = 5, .is_rotated = true};
        std::set<std::pair<int, int>> seen;
        for (int y = 0; y < 3; ++y) {
            for (int x = 0; x < 5; ++x) {
                const ivec2 at = texel_position(turned, x, y);
                CHECK((at.x >= 10 && at.x < 13 && at.y >= 20 && at.y < 25));
                seen.insert({at.x, at.y});
            }
        }
        CHECK(seen.size() == 15);
        CHECK(texel_position(turned, 0, 0) == ivec2(12, 20));  // upper left goes to the upper right
        CHECK(texel_position(turned, 4, 0) == ivec2(12, 24));
    }
    TEST_CASE("an upright tile is only moved") {
        const tile upright{.atlas = 0, .x = 10, .y = 20, .width = 3, .height = 5};
        CHECK(texel_position(upright, 2, 4) == ivec2(12, 24));
    }
    TEST_CASE("bytes are sRGB for colours, linear for the rest, and normals never point behind") {
        atlas a;
        a.base_color = image::filled(1, 1, 4, 0);
        a.normal = image::filled(1, 1, 3, 0);
        a.occlusion_roughness_metallic = image::filled(1, 1, 3, 0);
        a.emissive = image::filled(1, 1, 3, 0);
        const tile t{.atlas = 0, .width = 1, .height = 1};
        texel value;
        value.is_opaque = true;
        value.look = {.base_color = {0.2122308f, 1, 0},
                      .normal = glm::normalize(vec3(0.6f, 0, -0.8f)),
                      .occlusion = 0.5f,
                      .roughness = 1,
                      .metallic = 0,
                      .emissive = vec3(1)};
        write_texel(a, t, frame{}, 0, 0, value);
        CHECK(a.base_color.pixel(0, 0)[0] == 127);
        CHECK(a.base_color.pixel(0, 0)[3] == 255);
        CHECK(a.normal.pixel(0, 0)[0] == 255);
        CHECK(a.normal.pixel(0, 0)[2] == 128);
        CHECK(a.occlusion_roughness_metallic.pixel(0, 0)[0] == 128);
        CHECK(a.emissive.pixel(0, 0)[2] == 255);
    }
    TEST_CASE("looks are averaged by samples, and normals that cancel out give the front") {
        detail::look_mean mean;
        mean.add({.base_color = vec3(1), .normal = {1, 0, 0}}, 1);
        mean.add({.base_color = vec3(0), .normal = {-1, 0, 0}}, 1);
        const surface_sample look = mean.mean({0, 1, 0});
        CHECK(look.base_color.x == 0.5f);
        CHECK(look.normal == vec3(0, 1, 0));
        detail::look_mean uneven;
        uneven.add({.base_color = vec3(1)}, 3);
        uneven.add({.base_color = vec3(0)}, 1);
        CHECK(uneven.mean({0, 0, 1}).base_color.x == 0.75f);
    }
}
