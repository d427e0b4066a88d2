#include <billow/bake/texel.hpp>

#include <cmath>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("bake/texel") {
    TEST_CASE("bytes are sRGB for colours, linear for the rest, and normals never point behind") {
        tile_picture tile = empty_tile({1, 1}, 4, false);
        texel value;
        value.samples = 5;
        value.cut_out = 2;
        value.look = {.base_color = {0.2122308f, 1, 0},
                      .normal = glm::normalize(vec3(0.6f, 0, -0.8f)),
                      .occlusion = 0.5f,
                      .roughness = 1,
                      .metallic = 0,
                      .emissive = vec3(1)};
        write_texel(tile, {}, 0, 0, value);
        const atlas& a = tile.channels;
        CHECK(tile.covered[0] == 5);
        CHECK(tile.cut_out[0] == 2);
        CHECK(a.base_color.pixel(0, 0)[0] == 127);
        CHECK(a.base_color.pixel(0, 0)[3] == 0);  // until alpha is chosen
        CHECK(a.normal.pixel(0, 0)[0] == 255);
        CHECK(a.normal.pixel(0, 0)[2] == 128);
        CHECK(a.occlusion_roughness_metallic.pixel(0, 0)[0] == 128);
        CHECK(a.emissive.pixel(0, 0)[2] == 255);
        write_texel(tile, {.axes = {}, .is_scene_space = true}, 0, 0, value);
        CHECK(a.normal.pixel(0, 0)[0] == 204);
        CHECK(std::abs(a.normal.pixel(0, 0)[2] - 26) <= 1);  // behind the billboard, as it is
    }
    TEST_CASE("a tilted face shows more surface than it covers, up to four times") {
        mesh m;
        m.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        m.triangles = {{0, 1, 2}};
        const auto toward = [](double degrees) {
            const double angle = degrees * 3.14159265358979 / 180;
            return vec3(std::sin(angle), 0, std::cos(angle));
        };
        CHECK(detail::tilt_of(m, 0, toward(0)) == doctest::Approx(1));
        CHECK(detail::tilt_of(m, 0, toward(60)) == doctest::Approx(2));
        CHECK(detail::tilt_of(m, 0, toward(120)) == doctest::Approx(2));
        CHECK(detail::tilt_of(m, 0, toward(85)) == 4);
        CHECK(detail::tilt_of(m, 0, toward(90)) == 4);
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
