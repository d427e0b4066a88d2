#include <billow/metrics/plane_colors.hpp>

#include <doctest/doctest.h>

#include <billow/metrics/lab.hpp>
#include <billow/metrics/render.hpp>
#include <billow/shapes/box.hpp>

#include "support/meshes.hpp"

namespace {

using namespace billow;

}  // namespace

TEST_SUITE("metrics/plane_colors") {
    TEST_CASE("planes found one after the other have colours that differ well") {
        for (std::uint32_t id = 0; id < 200; ++id) {
            const vec3 color = color_of_plane(id);
            for (int c = 0; c < 3; ++c) CHECK((color[c] >= 0 && color[c] <= 1));
            for (std::uint32_t next = id + 1; next < id + 5; ++next) {
                CHECK(delta_e76(lab_from_linear(color), lab_from_linear(color_of_plane(next))) >
                      15);
            }
        }
    }

    TEST_CASE("faces keep their place and alpha, and lose all else") {
        mesh source;
        support::add_square(source, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
        source.uv_sets[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
        source.feature_ids = {4, 4, 4, 4};
        source.images = {image::filled(2, 2, 4, 60), image::filled(2, 2, 3, 9)};
        source.materials.resize(1);
        source.materials[0].alpha = alpha_mode::mask;
        source.materials[0].alpha_cutoff = 0.2f;
        source.materials[0].is_double_sided = true;
        source.materials[0].base_color_texture.image = 0;
        source.materials[0].normal_texture.image = 1;
        source.materials[0].emissive = vec3(1);
        CHECK(features_of_faces(source) == std::vector<std::uint32_t>{4, 4});
        const std::vector<std::uint32_t> ids{4, no_id};
        const mesh colored = colored_by(source, ids);
        REQUIRE(colored.vertex_count() == 6);
        for (face_id face = 0; face < 2; ++face) {
            CHECK(colored.corners(face) == source.corners(face));
        }
        CHECK(vec3(colored.colors[0]) == color_of_plane(4));
        CHECK(vec3(colored.colors[3]) == color_of_plane(no_id));
        const image& white = colored.images[0];
        CHECK((white.pixel(1, 1)[0] == 255 && white.pixel(1, 1)[3] == 60));
        CHECK(colored.images[1].empty());
        CHECK(colored.materials[0].emissive == vec3(0));
        CHECK(!colored.materials[0].normal_texture.is_present());
        CHECK(colored.materials[0].alpha_cutoff == 0.2f);
        // It covers what it did.
        const camera from = orbit_camera({dvec3(0), 1.5}, {0.3, 0.2, 1}, 4, 40);
        const view_picture a = render_view(render_scene(source), from);
        const view_picture b = render_view(render_scene(colored), from);
        for (std::size_t i = 0; i < a.pixels.size(); ++i) CHECK(a.pixels[i].a == b.pixels[i].a);
    }

    TEST_CASE("a mesh without materials, uvs or feature ids is coloured, too") {
        const mesh cube = box({1, 1, 1});
        const std::vector<std::uint32_t> ids = features_of_faces(cube);
        CHECK(ids == std::vector<std::uint32_t>(cube.face_count(), no_id));
        CHECK(colored_by(cube, ids).colors.size() == 3 * cube.face_count());
        CHECK(colored_by(mesh{}, {}).face_count() == 0);
    }
}
