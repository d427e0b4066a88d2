#include <billow/bake/surface.hpp>

#include <cmath>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// A triangle in the plane z = 0 with uvs along x and y.
mesh textured_triangle() {
    mesh m = support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    m.uv_sets[0] = {{0, 1}, {1, 1}, {0, 0}};
    m.materials = {{.name = "card", .metallic = 0}};
    m.images = {image::filled(2, 2, 4, 255)};
    return m;
}

constexpr vec3 face_middle(1.0f / 3, 1.0f / 3, 1.0f / 3);

surface_sample sample_of(const mesh& m) {
    const surface look(m);
    return look.at(look.look_at(0, 1e6), face_middle);
}

}  // namespace

TEST_SUITE("bake/surface") {
    TEST_CASE("colours of factor, texture and vertices are multiplied in linear light") {
        mesh m = textured_triangle();
        m.materials[0].base_color = {0.5f, 1, 1, 1};
        m.materials[0].base_color_texture.image = 0;
        for (int y = 0; y < 2; ++y) {
            for (int x = 0; x < 2; ++x) m.images[0].pixel(x, y)[1] = 128;
        }
        m.colors.assign(3, vec4(1, 1, 0.25f, 1));
        const surface_sample sample = sample_of(m);
        CHECK(sample.base_color.x == doctest::Approx(0.5));
        CHECK(sample.base_color.y == doctest::Approx(linear_of_srgb_byte()[128]));
        CHECK(sample.base_color.z == doctest::Approx(0.25));
    }
    TEST_CASE("roughness is green, metal blue, occlusion red and weighed by its strength") {
        mesh m = textured_triangle();
        material& look = m.materials[0];
        look.metallic = 0.5f;
        look.roughness = 0.5f;
        look.metallic_roughness_texture.image = 0;
        look.occlusion_texture.image = 0;
        look.occlusion_strength = 0.5f;
        for (int y = 0; y < 2; ++y) {
            for (int x = 0; x < 2; ++x) {
                m.images[0].pixel(x, y)[0] = 0;
                m.images[0].pixel(x, y)[1] = 51;
            }
        }
        const surface_sample sample = sample_of(m);
        CHECK(sample.roughness == doctest::Approx(0.5 * 0.2).epsilon(1e-3));
        CHECK(sample.metallic == doctest::Approx(0.5));
        CHECK(sample.occlusion == doctest::Approx(0.5));
    }
    TEST_CASE("without vertex normals a face is flat, with a normal map it is bent along its uvs") {
        mesh m = textured_triangle();
        CHECK(sample_of(m).normal == vec3(0, 0, 1));
        m.materials[0].normal_texture.image = 0;
        for (int y = 0; y < 2; ++y) {
            for (int x = 0; x < 2; ++x) {
                std::uint8_t* n = m.images[0].pixel(x, y);
                n[0] = 218;  // 0.71 along u
                n[1] = 128;
                n[2] = 218;
            }
        }
        const vec3 normal = sample_of(m).normal;
        CHECK(normal.x == doctest::Approx(std::sqrt(0.5)).epsilon(0.02));
        CHECK(normal.y == doctest::Approx(0).epsilon(0.02));
        CHECK(normal.z == doctest::Approx(std::sqrt(0.5)).epsilon(0.02));
    }
    TEST_CASE("alpha decides by mode") {
        mesh m = textured_triangle();
        CHECK(surface(m).cover_of(0, 1).decides == face_cover::rule::always);
        m.materials[0].alpha = alpha_mode::mask;
        m.materials[0].alpha_cutoff = 0.25f;
        CHECK(surface(m).cover_of(0, 1).decides == face_cover::rule::cutoff);
        CHECK(surface(m).cover_of(0, 1).cutoff == 0.25f);
        m.materials[0].alpha = alpha_mode::blend;
        CHECK(surface(m).cover_of(0, 1).decides == face_cover::rule::share);
    }
    TEST_CASE("materials, images and uvs that are missing say nothing") {
        mesh m = textured_triangle();
        m.materials[0].base_color_texture.image = 9;
        m.materials[0].emissive_texture = {.image = 0, .uv_set = 1};
        CHECK(sample_of(m).base_color == vec3(1));
        m.materials.clear();
        m.face_materials = {4};
        CHECK(sample_of(m).base_color == vec3(1));
        CHECK(sample_of(m).metallic == 0);
    }
    TEST_CASE("a surface seen from behind shows its other side") {
        const mesh m = textured_triangle();
        const surface look(m);
        const face_look face = look.look_at(0, 1);
        const surface_sample sample = look.at(face, face_middle);
        CHECK(normal_toward(sample, face, {0, 0, 1}) == vec3(0, 0, 1));
        CHECK(normal_toward(sample, face, {0, 0, -1}) == vec3(0, 0, -1));
    }
}
