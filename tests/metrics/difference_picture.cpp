#include <billow/metrics/difference_picture.hpp>

#include <doctest/doctest.h>

#include "support/pictures.hpp"

namespace {

using namespace billow;

view_picture one_pixel(const vec3& light, float coverage) {
    return {1, 1, {vec4(light * coverage, coverage)}};
}
vec3 byte_color(const image& picture, int x = 0, int y = 0) {
    const std::uint8_t* p = picture.pixel(x, y);
    return {p[0], p[1], p[2]};
}
vec3 srgb_bytes(const vec3& light) {
    return {srgb_byte_from_linear(light.x), srgb_byte_from_linear(light.y),
            srgb_byte_from_linear(light.z)};
}

}  // namespace

TEST_SUITE("metrics/difference_picture") {
    TEST_CASE("a pixel shows what it holds: nothing, both, missing, extra, or a mixture") {
        const coverage_colors colors;
        const auto seen = [](float original, float cloud) {
            return byte_color(
                coverage_picture(one_pixel(vec3(1), original), one_pixel(vec3(0), cloud)));
        };
        CHECK(seen(0, 0) == srgb_bytes(colors.nothing));
        CHECK(seen(1, 1) == srgb_bytes(colors.both));
        CHECK(seen(1, 0) == srgb_bytes(colors.missing));
        CHECK(seen(0, 1) == srgb_bytes(colors.extra));
        CHECK(seen(0.5f, 0) == srgb_bytes((colors.nothing + colors.missing) * 0.5f));
        CHECK(seen(0.5f, 1) == srgb_bytes((colors.both + colors.extra) * 0.5f));
    }

    TEST_CASE("heat gets lighter all along") {
        double last = -1;
        for (int i = 0; i <= 100; ++i) {
            const vec3 srgb = heat_color(static_cast<float>(i) / 100);
            const vec3 light(linear_from_srgb(srgb.x), linear_from_srgb(srgb.y),
                             linear_from_srgb(srgb.z));
            const double lightness = static_cast<double>(lab_from_linear(light).x);
            CHECK(lightness > last);
            last = lightness;
        }
        CHECK(heat_color(-1) == heat_color(0));
        CHECK(heat_color(7) == heat_color(1));
    }

    TEST_CASE(
        "colours that differ are hot, those that do not are cold, what is not there is grey") {
        const auto seen = [](const vec3& original, const vec3& cloud, float coverage) {
            return byte_color(color_difference_picture(blur(one_pixel(original, 1)),
                                                       blur(one_pixel(cloud, coverage))));
        };
        const auto bytes = [](const vec3& srgb) { return glm::round(srgb * 255.0f); };
        CHECK(seen(vec3(0.5f), vec3(0.5f), 1) == bytes(heat_color(0)));
        CHECK(seen(vec3(0), vec3(1), 1) == bytes(heat_color(1)));
        CHECK(seen(vec3(0), vec3(1), 0) == bytes(vec3(0.95f)));
    }

    TEST_CASE("a pixel of the map is a square of the blurred pictures") {
        const auto a = blur(support::random_picture(31, 22, 1), {.sigma_px = 8});
        const auto b = blur(support::random_picture(31, 22, 2), {.sigma_px = 8});
        const image map = color_difference_picture(a, b);
        CHECK(map.width == 8);
        CHECK(map.height == 6);
    }
}
