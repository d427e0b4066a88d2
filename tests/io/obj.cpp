#include <billow/io/obj.hpp>

#include <doctest/doctest.h>

#include <billow/io/mesh_file.hpp>

#include "scratch.hpp"

using namespace billow;
using scratch::failed;

namespace {

constexpr std::string_view square_corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

expected<loaded_mesh> read_obj_text(std::string_view text) {
    const scratch::folder at;
    return read_obj(at.put("made.obj", text));
}

std::string with_square(std::string_view text) {
    return std::string(square_corners) + std::string(text);
}

}  // namespace

TEST_SUITE("io/obj") {
    TEST_CASE("polygons become triangles that share their vertices") {
        const auto read = read_obj_text(with_square("f 1 2 3 4\n"));
        REQUIRE(read);
        CHECK(read->mesh.face_count() == 2);
        CHECK(read->mesh.vertex_count() == 4);
        CHECK(read->mesh.normals.empty());
        CHECK(read->mesh.material_of(0).metallic == 0);
    }

    TEST_CASE("negative indices, carriage returns and blanks mean what they should") {
        const auto read = read_obj_text("v  0 0 0 \r\nv\t1 0 0\r\nv 1 1 0\r\n f  -3  -2 -1 \r\n");
        REQUIRE(read);
        CHECK(read->mesh.corners(0) == std::array{vec3(0), vec3(1, 0, 0), vec3(1, 1, 0)});
    }

    TEST_CASE("corners of the same indices are one vertex, of others two") {
        const auto read =
            read_obj_text(with_square("vt 0 0\nvt 0.25 1\nf 1/1 2/1 3/1\nf 1/1 3/2 4/1\n"));
        REQUIRE(read);
        CHECK(read->mesh.vertex_count() == 5);
        CHECK(read->mesh.uv_sets[0][0] == vec2(0, 1));  // v from the top
        CHECK(read->mesh.uv_sets[0][3] == vec2(0.25f, 0));
    }

    TEST_CASE("faces without normals are flat beside others that have them") {
        const auto read = read_obj_text(with_square("vn 0 0.6 0.8\nf 1//1 2//1 3//1\nf 1 3 4\n"));
        REQUIRE(read);
        CHECK(read->mesh.vertex_count() == 6);
        CHECK(read->mesh.normals[0] == vec3(0, 0.6f, 0.8f));
        CHECK(read->mesh.normals[5] == vec3(0, 0, 1));
    }

    TEST_CASE("vertex colours are read, points and lines counted") {
        const auto read =
            read_obj_text("v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 0 1 1\nf 1 2 3\nl 1 2\np 1\n");
        REQUIRE(read);
        CHECK(read->mesh.colors[2] == vec4(0, 1, 1, 1));
        CHECK(read->skipped_primitives > 0);
        CHECK(read_obj_text(square_corners)->mesh.face_count() == 0);
    }

    TEST_CASE("bad files fail in one line") {
        const auto fails = [](std::string_view text, error_code code) {
            CHECK(failed(read_obj_text(text), code, "", "made.obj"));
        };
        fails(with_square("f 1 2 5\n"), error_code::out_of_range);
        fails(with_square("f 1 2 -9\n"), error_code::out_of_range);
        fails(with_square("f 1/1 2/1 3/1\n"), error_code::out_of_range);
        fails(with_square("f 1//4 2//4 3//4\n"), error_code::out_of_range);
        fails(with_square("f 0 1 2\n"), error_code::malformed);
        fails("v 0 0 nan\n", error_code::not_finite);
        fails("v 0 -inf 0\n", error_code::not_finite);
        fails("v 1e999 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n", error_code::not_finite);
        fails("v 0 0\n", error_code::malformed);
        fails("v 0 0 x\n", error_code::malformed);
        fails("hello\n", error_code::malformed);
        fails(std::string_view("v 0 0 0\0", 8), error_code::malformed);
        std::string polygon = with_square("f");
        for (int i = 0; i < 300; ++i) polygon += " 1";
        fails(polygon + "\n", error_code::unsupported);
    }

    TEST_CASE("MTL materials are mapped, what is missing is noted") {
        const scratch::folder at;
        image rgba = image::filled(2, 2, 4, 255);
        rgba.pixel(1, 1)[3] = 0;
        REQUIRE(write_png(at / "rgba.png", rgba));
        REQUIRE(write_png(at / "rgb.png", image::filled(2, 2, 3, 100)));
        REQUIRE(write_png(at / "grey.png", image::filled(4, 1, 1, 30)));
        at.put("a.mtl",
               "newmtl glass\nKd 1 0.5 0\nd 0.25\n"
               "newmtl leaf\nmap_Kd -clamp on rgba.png\nnorm rgb.png\n"
               "newmtl cut\nKd 1 1 1\nmap_Kd rgb.png\nmap_d grey.png\nmap_Bump rgb.png\n"
               "newmtl lost\nKd 1 1 1\nTr 0\nmap_Kd none.png\n");
        const auto read = read_obj(
            at.put("a.obj",
                   "mtllib a.mtl\n" + with_square("usemtl glass\nf 1 2 3\nusemtl leaf\nf 1 2 4\n"
                                                  "usemtl cut\nf 1 2 3\nusemtl lost\nf 1 2 3\n")));
        REQUIRE(read);
        const mesh& m = read->mesh;
        CHECK(m.material_of(0).alpha == alpha_mode::blend);
        CHECK(m.material_of(0).base_color.a == 0.25f);
        CHECK(m.material_of(0).base_color.g == doctest::Approx(0.2140411));  // linear of 0.5
        const material& leaf = m.material_of(1);
        CHECK(leaf.base_color == vec4(1));
        CHECK(leaf.alpha == alpha_mode::mask);
        CHECK(leaf.base_color_texture.wrap_u == texture_wrap::clamp_to_edge);
        CHECK(m.images[leaf.base_color_texture.image] == rgba);
        CHECK(leaf.base_color_texture.transform == mat3(1));
        CHECK(leaf.normal_texture.is_present());
        const material& cut = m.material_of(2);
        CHECK(cut.alpha == alpha_mode::mask);
        const image& joined = m.images[cut.base_color_texture.image];
        CHECK(joined.width == 4);
        CHECK(joined.height == 2);
        CHECK(joined.pixel(3, 1)[0] == 100);
        CHECK(joined.pixel(3, 1)[3] == 30);
        CHECK_FALSE(cut.normal_texture.is_present());
        CHECK_FALSE(m.material_of(3).base_color_texture.is_present());
        CHECK(m.material_of(3).alpha == alpha_mode::opaque);
        CHECK(read->notes.size() == 2);

        const auto lost = read_obj(at.put("b.obj", "mtllib none.mtl\n" + with_square("f 1 2 3\n")));
        REQUIRE(lost);
        CHECK(lost->notes.size() == 1);
    }
}

TEST_SUITE("io/mesh_file") {
    TEST_CASE("the reader is chosen by content, then by name") {
        const scratch::folder at;
        const std::string json_text = R"({"asset":{"version":"2.0"}})";
        CHECK(read_mesh(at.put("a.bin", scratch::glb(json_text))));
        CHECK(read_mesh(at.put("b.txt", " \n" + json_text)));
        CHECK(read_mesh(at.put("c.OBJ", with_square("f 1 2 3\n")))->mesh.face_count() == 1);
        CHECK(failed(read_mesh(at.put("d.fbx", "Kaydara")), error_code::unsupported, ".obj",
                     "d.fbx"));
        CHECK(failed(read_mesh(at.put("e.glb", "x")), error_code::malformed, "", "e.glb"));
        CHECK(failed(read_mesh(at / "none.obj"), error_code::not_found, "", "none.obj"));
    }
}
