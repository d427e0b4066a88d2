#include <billow/mesh/mesh.hpp>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("mesh/mesh") {
    TEST_CASE("a face knows its corners and its material") {
        mesh m =
            support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {3, 0, 0}, {2, 1, 0}});
        m.materials = {{.name = "bark"}, {.name = "leaf"}};
        m.face_materials = {1, 0};
        CHECK(m.face_count() == 2);
        CHECK(m.corners(1)[1] == vec3(3, 0, 0));
        CHECK(m.material_of(0).name == "leaf");
        CHECK(m.material_of(1).name == "bark");
    }
    TEST_CASE("a face without a material is white, rough, opaque and no metal") {
        mesh m = support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
        CHECK(m.material_of(0).base_color == vec4(1));
        CHECK(m.material_of(0).metallic == 0);
        m.face_materials = {7};
        CHECK(m.material_of(0).metallic == 0);
    }
}
