#include <billow/mesh/append_mesh.hpp>

#include <vector>

#include <doctest/doctest.h>

#include <billow/mesh/validate.hpp>
#include <billow/plants/species.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("mesh/append_mesh") {
    TEST_CASE("faces of both keep their corners and their looks") {
        const mesh tree = *tree_of_about(1000);
        const mesh cube = textured_cube();
        mesh both = tree;
        append_mesh(both, cube);
        REQUIRE(validate(both));
        REQUIRE(both.face_count() == tree.face_count() + cube.face_count());
        const auto check_part = [&](const mesh& part, std::size_t first) {
            for (face_id face = 0; face < part.face_count(); ++face) {
                const auto in_both = static_cast<face_id>(first + face);
                CHECK(both.corners(in_both) == part.corners(face));
                const material& was = part.material_of(face);
                const material& is = both.material_of(in_both);
                CHECK(is.name == was.name);
                REQUIRE(is.base_color_texture.is_present() == was.base_color_texture.is_present());
                if (!was.base_color_texture.is_present()) continue;
                CHECK(both.images[is.base_color_texture.image] ==
                      part.images[was.base_color_texture.image]);
            }
        };
        check_part(tree, 0);
        check_part(cube, tree.face_count());
    }
    TEST_CASE("what one of them lacks is filled so that it looks as before") {
        mesh smooth = leaf_soup(10);
        mesh plain = support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
        plain.colors.assign(3, vec4(0.5f));
        for (const bool is_plain_first : {true, false}) {
            mesh both = is_plain_first ? plain : smooth;
            append_mesh(both, is_plain_first ? smooth : plain, 7);
            REQUIRE(validate(both));
            const face_id plain_face = is_plain_first ? 0 : 10;
            const face_id leaf_face = is_plain_first ? 1 : 0;
            const std::uint32_t v = both.triangles[plain_face].x;
            CHECK(both.normals[v] == vec3(0, 0, 1));
            CHECK(both.colors[v] == vec4(0.5f));
            CHECK(both.colors[both.triangles[leaf_face].x] == vec4(1));
            CHECK(both.material_of(plain_face).name.empty());
            CHECK(both.material_of(leaf_face).name == smooth.material_of(0).name);
            CHECK(both.feature_ids.empty());
        }
    }
    TEST_CASE("feature ids of one are told apart from the other") {
        mesh with = leaf_soup(4);
        with.feature_ids.assign(with.vertex_count(), 2);
        mesh both = with;
        append_mesh(both, box(), 9);
        CHECK(both.feature_ids.front() == 2);
        CHECK(both.feature_ids.back() == 9);
    }
    TEST_CASE("tangents stay unless a normal texture would miss some") {
        mesh with = leaf_soup(4);
        with.tangents.assign(with.vertex_count(), vec4(1, 0, 0, 1));
        mesh both = with;
        append_mesh(both, leaf_soup(2));
        CHECK(both.tangents.size() == both.vertex_count());
        mesh bumpy = leaf_soup(2);
        bumpy.images = {image::filled(2, 2, 3, 128)};
        bumpy.materials[0].normal_texture.image = 0;
        both = with;
        append_mesh(both, bumpy);
        CHECK(both.tangents.empty());
    }
    TEST_CASE("an empty mesh changes nothing, from either side") {
        const mesh cube = textured_cube();
        mesh first = cube;
        append_mesh(first, {});
        mesh second;
        append_mesh(second, cube);
        for (const mesh& m : {first, second}) {
            REQUIRE(validate(m));
            CHECK(m.positions == cube.positions);
            CHECK(m.normals == cube.normals);
            CHECK(m.triangles == cube.triangles);
            CHECK(m.material_of(0).name == cube.material_of(0).name);
        }
    }
}
