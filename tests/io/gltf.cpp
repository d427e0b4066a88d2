#include <billow/io/gltf.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "scratch.hpp"

using namespace billow;
using scratch::failed;
using scratch::gltf;
using scratch::json;

namespace {

dvec3 normal_of(const mesh& m, face_id face) {
    const auto [a, b, c] = m.corners(face);
    return glm::normalize(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)));
}

bool is_near(const dvec3& a, const dvec3& b) { return glm::length(a - b) < 1e-5; }

/// Four corners of the unit square and the indices of a mode.
loaded_mesh square(int mode, const std::vector<std::uint16_t>& indices) {
    gltf file;
    auto& p = file.primitive(
        {{"POSITION", file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, "VEC3", 3)}});
    p["mode"] = mode;
    if (!indices.empty()) p["indices"] = file.indices(indices);
    auto read = file.read();
    REQUIRE(read);
    return std::move(*read);
}

}  // namespace

TEST_SUITE("io/gltf") {
    TEST_CASE("lists, strips and fans turn the same way, with indices or without") {
        const auto check = [](const loaded_mesh& loaded, std::size_t faces) {
            REQUIRE(loaded.mesh.face_count() == faces);
            for (face_id face = 0; face < faces; ++face) {
                CHECK(is_near(normal_of(loaded.mesh, face), {0, 0, 1}));
            }
        };
        check(square(4, {0, 1, 2, 2, 1, 3}), 2);
        check(square(4, {}), 1);  // the fourth vertex is left over
        check(square(5, {}), 2);
        check(square(5, {0, 1, 2, 3}), 2);
        check(square(6, {0, 1, 3, 2}), 2);
    }

    TEST_CASE("points and lines are skipped and counted, with what lacks positions") {
        gltf file;
        const int positions = file.triangle();
        for (const int mode : {0, 1, 2, 3, 4})
            file.primitive({{"POSITION", positions}})["mode"] = mode;
        file.primitive({{"NORMAL", positions}});
        const auto read = file.read();
        REQUIRE(read);
        CHECK(read->mesh.face_count() == 1);
        CHECK(read->skipped_primitives == 5);
        CHECK(read->primitives == 1);
    }

    TEST_CASE("indices of 8, 16 and 32 bits mean the same") {
        for (const int component : {5121, 5123, 5125}) {
            gltf file;
            auto& p = file.primitive({{"POSITION", file.triangle()}});
            const int view = component == 5121   ? file.view(std::vector<std::uint8_t>{2, 0, 1})
                             : component == 5123 ? file.view(std::vector<std::uint16_t>{2, 0, 1})
                                                 : file.view(std::vector<std::uint32_t>{2, 0, 1});
            p["indices"] = file.accessor(view, component, "SCALAR", 3);
            const auto read = file.read();
            REQUIRE(read);
            CHECK(read->mesh.corners(0) == std::array{vec3(0, 1, 0), vec3(0, 0, 0), vec3(1, 0, 0)});
        }
    }

    TEST_CASE("interleaved, sparse and quantized accessors are read") {
        gltf file;
        const int view =
            file.view<float>({0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1}, 24);
        const int positions = file.accessor(view, 5126, "VEC3", 3);
        const int normals = file.accessor(view, 5126, "VEC3", 3);
        file.root["accessors"][static_cast<std::size_t>(normals)]["byteOffset"] = 12;
        json& sparse = file.root["accessors"][static_cast<std::size_t>(positions)]["sparse"];
        sparse = {
            {"count", 1},
            {"indices", {{"bufferView", file.view<std::uint8_t>({2})}, {"componentType", 5121}}},
            {"values", {{"bufferView", file.view<float>({0, 7, 0})}}}};
        const int uvs =
            file.accessor(file.view<std::uint16_t>({0, 65535, 65535, 0, 0, 0}), 5123, "VEC2", 3);
        file.root["accessors"][static_cast<std::size_t>(uvs)]["normalized"] = true;
        const int colors =
            file.accessor(file.view<std::uint8_t>({255, 0, 0, 0, 255, 255, 255, 0, 0, 0, 51, 0}, 4),
                          5121, "VEC3", 3);
        file.root["accessors"][static_cast<std::size_t>(colors)]["normalized"] = true;
        file.primitive({{"POSITION", positions},
                        {"NORMAL", normals},
                        {"TEXCOORD_0", uvs},
                        {"COLOR_0", colors}});
        auto read = file.read();
        REQUIRE(read);
        const mesh& m = read->mesh;
        CHECK(m.positions[1] == vec3(1, 0, 0));
        CHECK(m.positions[2] == vec3(0, 7, 0));
        CHECK(m.normals[2] == vec3(0, 0, 1));
        CHECK(m.uv_sets[0][0] == vec2(0, 1));
        CHECK(m.colors[2].b == doctest::Approx(0.2));
        CHECK(m.colors[2].a == 1);

        gltf bytes;  // KHR_mesh_quantization: -1 to 1 in signed bytes, scaled by the node
        const int packed = bytes.accessor(
            bytes.view<std::int8_t>({0, 0, 0, 0, 127, 0, 0, 0, 0, -128, 0, 0}, 4), 5120, "VEC3", 3);
        bytes.root["accessors"][0]["normalized"] = true;
        bytes.root["extensionsRequired"] = {"KHR_mesh_quantization"};
        bytes.root["nodes"][0]["scale"] = {2, 2, 2};
        bytes.primitive({{"POSITION", packed}});
        read = bytes.read();
        REQUIRE(read);
        CHECK(read->mesh.positions[1] == vec3(2, 0, 0));
        CHECK(read->mesh.positions[2] == vec3(0, -2, 0));
    }

    TEST_CASE("transforms move faces, and mirrored ones keep their front side") {
        gltf file;
        const std::vector<float> up{0, 0.6f, 0.8f, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f};
        const std::vector<float> along{1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
        file.primitive({{"POSITION", file.triangle()},
                        {"NORMAL", file.floats(up, "VEC3", 3)},
                        {"TANGENT", file.floats(along, "VEC4", 4)}});
        file.root["nodes"] = {
            {{"children", {1, 2}}, {"translation", {10, 0, 0}}},
            {{"mesh", 0}, {"scale", {-1, 2, 1}}},
            {{"mesh", 0}, {"matrix", {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1}}}};
        const auto read = file.read();
        REQUIRE(read);
        const mesh& m = read->mesh;
        REQUIRE(m.face_count() == 2);
        CHECK(read->instances == 2);
        CHECK(m.positions[1] == vec3(9, 0, 0));
        CHECK(m.positions[2] == vec3(10, 2, 0));
        CHECK(is_near(normal_of(m, 0), {0, 0, 1}));  // as of the unmirrored triangle
        CHECK(is_near(m.normals[0], glm::normalize(dvec3(0, 0.3, 0.8))));
        CHECK(m.tangents[0] == vec4(-1, 0, 0, -1));
        CHECK(m.positions[4] == vec3(10, 1, 5));
        CHECK(is_near(normal_of(m, 1), {0, 0, 1}));
        CHECK(is_near(m.normals[3], {-0.6, 0, 0.8}));
    }

    TEST_CASE("a node that is flat along an axis gives finite unit normals") {
        gltf file;
        file.primitive({{"POSITION", file.triangle()},
                        {"NORMAL", file.floats({0, 0, 1, 1, 0, 0, 0, 0, 0}, "VEC3", 3)}});
        file.root["nodes"][0]["scale"] = {1, 1, 0};
        const auto read = file.read();
        REQUIRE(read);
        for (const vec3& n : read->mesh.normals) CHECK(is_near(n, {0, 0, 1}));
    }

    TEST_CASE("the default scene is read, else the first, else all roots, else all meshes") {
        gltf file;
        file.primitive({{"POSITION", file.triangle()}});
        file.root["nodes"] = {{{"mesh", 0}}, {{"children", {0}}}, {{"mesh", 0}}, {{"mesh", 0}}};
        file.root["scenes"] = {{{"nodes", {2, 3}}}, {{"nodes", {2}}}};
        const auto faces = [&] { return file.read()->mesh.face_count(); };
        file.root["scene"] = 1;
        CHECK(faces() == 1);
        file.root.erase("scene");
        CHECK(faces() == 2);
        file.root.erase("scenes");
        CHECK(faces() == 3);
        file.root.erase("nodes");
        CHECK(faces() == 1);
    }

    TEST_CASE("EXT_mesh_gpu_instancing places a mesh many times") {
        gltf file;
        file.primitive({{"POSITION", file.triangle()}});
        const int moves = file.floats({0, 0, 0, 0, 0, 5}, "VEC3", 3);
        const int turns = file.floats({0, 0, 0, 1, 0, 0, 1, 0}, "VEC4", 4);
        file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
            {"TRANSLATION", moves}, {"ROTATION", turns}};
        const auto read = file.read();
        REQUIRE(read);
        REQUIRE(read->mesh.face_count() == 2);
        CHECK(is_near(read->mesh.positions[4], {-1, 0, 5}));
    }

    TEST_CASE("primitives without normals become flat beside others that have them") {
        gltf file;
        const int positions = file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", 3);
        file.primitive({{"POSITION", positions}})["indices"] = file.indices({0, 1, 2, 0, 3, 1});
        CHECK(file.read()->mesh.normals.empty());
        CHECK(file.read()->mesh.vertex_count() == 4);
        const int normals = file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3);
        file.primitive({{"POSITION", positions}, {"NORMAL", normals}})["indices"] =
            file.indices({0, 1, 2});
        const auto read = file.read();
        REQUIRE(read);
        CHECK(read->mesh.vertex_count() == 9);
        for (face_id face = 0; face < 3; ++face) {
            CHECK(is_near(read->mesh.normals[read->mesh.triangles[face].y],
                          normal_of(read->mesh, face)));
        }
    }

    TEST_CASE("vertices that no face uses are left out") {
        gltf file;
        file.primitive(
            {{"POSITION", file.floats(std::vector<float>(300, 1.0f), "VEC3", 3)}})["indices"] =
            file.indices({90, 7, 90});
        CHECK(file.read()->mesh.vertex_count() == 2);
    }

    TEST_CASE("positions that are not finite are refused with the face, other values repaired") {
        const float nan = std::numeric_limits<float>::quiet_NaN();
        gltf file;
        file.primitive({{"POSITION", file.triangle()}});
        file.primitive({{"POSITION", file.floats({0, 0, 0, 1, nan, 0, 0, 1, 0}, "VEC3", 3)}});
        CHECK(failed(file.read(), error_code::not_finite, "face 1 "));

        gltf repaired;
        repaired.primitive({{"POSITION", repaired.triangle()},
                            {"NORMAL", repaired.floats({nan, 0, 1, 0, 0, 1, 0, 0, 0}, "VEC3", 3)},
                            {"TEXCOORD_0", repaired.floats({0, nan, 1, 1, 0, 1}, "VEC2", 2)}});
        const auto read = repaired.read();
        REQUIRE(read);
        CHECK(read->mesh.normals[0] == vec3(0, 0, 1));
        CHECK(read->mesh.uv_sets[0][0] == vec2(0));
        CHECK(read->notes.size() == 2);
    }

    TEST_CASE("skins, animation and morph targets are noted, not read") {
        gltf file;
        const int positions = file.triangle();
        file.primitive({{"POSITION", positions}})["targets"] = {{{"POSITION", positions}}};
        file.root["animations"] = json::array({json::object()});
        const auto read = file.read();
        REQUIRE(read);
        CHECK(read->notes.size() == 2);
    }

    TEST_CASE("more faces than wanted are refused before they are unfolded") {
        gltf file;
        file.primitive({{"POSITION", file.triangle()}});
        file.root["nodes"] = json::array({{{"children", json::array()}}});
        for (int i = 1; i <= 50; ++i) {
            file.add("nodes", {{"mesh", 0}});
            file.root["nodes"][0]["children"].push_back(i);
        }
        CHECK(file.read({.max_faces = 50}));
        CHECK(failed(file.read({.max_faces = 49}), error_code::too_large, "49"));
    }
}
