#include <billow/io/glb.hpp>

#include <doctest/doctest.h>

#include <limits>

#include "scratch.hpp"

using namespace billow;
using scratch::failed;
using scratch::json;

namespace {

/// Two quads of two materials with every column and texture.
mesh rich() {
    mesh m;
    for (int quad = 0; quad < 2; ++quad) {
        for (int i = 0; i < 4; ++i) {
            const auto x = static_cast<float>(i % 2);
            const auto y = static_cast<float>(i / 2);
            m.positions.emplace_back(x + 0.1f, y, static_cast<float>(quad) * 3.3f);
            m.normals.emplace_back(0, 0, 1);
            m.tangents.emplace_back(1, 0, 0, quad == 0 ? 1 : -1);
            m.uv_sets[0].emplace_back(x, 1 - y);
            m.uv_sets[1].emplace_back(x / 2, y / 2);
            m.colors.emplace_back(1, x, y, 0.5f);
            m.feature_ids.push_back(static_cast<std::uint32_t>(quad) * 70'001u);
        }
        const auto first = static_cast<std::uint32_t>(quad) * 4;
        m.triangles.emplace_back(first, first + 1, first + 2);
        m.triangles.emplace_back(first + 2, first + 1, first + 3);
    }
    m.face_materials = {0, 0, 1, 1};
    for (int channels = 1; channels <= 4; ++channels) {
        image picture = image::filled(8, 4, channels, 9);
        picture.bytes[5] = static_cast<std::uint8_t>(channels);
        m.images.push_back(picture);
    }
    material leaf{.name = "leaf \"a\" \xff",
                  .base_color = vec4(0.5f, 1, 0.25f, 1),
                  .metallic = 0,
                  .roughness = 0.75f,
                  .normal_scale = 0.5f,
                  .occlusion_strength = 0.5f,
                  .emissive = vec3(0.5f, 0, 1),
                  .alpha = alpha_mode::mask,
                  .alpha_cutoff = 0.3f,
                  .is_double_sided = true};
    leaf.base_color_texture = {.image = 3,
                               .wrap_u = texture_wrap::clamp_to_edge,
                               .wrap_v = texture_wrap::mirrored_repeat,
                               .is_nearest = true};
    leaf.normal_texture = {.image = 2, .uv_set = 1};
    leaf.occlusion_texture = {.image = 0};
    leaf.metallic_roughness_texture = {.image = 0};
    leaf.emissive_texture = {.image = 2};
    leaf.emissive_texture.transform = detail::texture_transform({0.5, -0.25}, 0.75, {2, -3});
    m.materials = {leaf, {.name = "plain", .alpha = alpha_mode::blend}};
    return m;
}

json json_of(const std::vector<std::uint8_t>& glb) {
    const std::size_t size =
        glb[12] | static_cast<std::size_t>(glb[13]) << 8 | static_cast<std::size_t>(glb[14]) << 16;
    return json::parse(glb.begin() + 20, glb.begin() + 20 + static_cast<std::ptrdiff_t>(size));
}

loaded_mesh again(const mesh& m) {
    auto bytes = encode_glb(m);
    REQUIRE(bytes);
    auto read = detail::read_gltf_bytes("again.glb", std::move(*bytes), {});
    REQUIRE(read);
    return std::move(*read);
}

void check_equal(const texture& a, const texture& b) {
    CHECK(a.is_present() == b.is_present());
    CHECK(a.uv_set == b.uv_set);
    CHECK(a.wrap_u == b.wrap_u);
    CHECK(a.wrap_v == b.wrap_v);
    CHECK(a.is_nearest == b.is_nearest);
    for (int column = 0; column < 3; ++column) {
        CHECK(glm::length(a.transform[column] - b.transform[column]) < 1e-5f);
    }
}

}  // namespace

TEST_SUITE("io/glb") {
    TEST_CASE("nodes divide the faces, and share materials and images") {
        const mesh m = rich();
        auto bytes =
            encode_glb(m, {.nodes = {{"a", {0}}, {"b", {1, 2}}, {"none", {}}, {"c", {3}}}});
        REQUIRE(bytes);
        const json root = json_of(*bytes);
        REQUIRE(root["nodes"].size() == 3);
        CHECK(root["nodes"][2]["name"] == "c");
        CHECK(root["scenes"][0]["nodes"] == json::array({0, 1, 2}));
        CHECK(root["meshes"].size() == 3);
        CHECK(root["meshes"][1]["primitives"].size() == 2);
        CHECK(root["materials"].size() == 2);
        CHECK(root["images"].size() == json_of(*encode_glb(m))["images"].size());
        auto read = detail::read_gltf_bytes("nodes.glb", std::move(*bytes), {});
        REQUIRE(read);
        CHECK(read->mesh.face_count() == 4);
        CHECK(read->mesh.materials.size() == 2);
    }
    TEST_CASE("a mesh that was written is read back with all it had") {
        const mesh m = rich();
        const loaded_mesh read = again(m);
        CHECK(read.notes.empty());
        CHECK(read.primitives == 2);
        CHECK(read.mesh.positions == m.positions);
        CHECK(read.mesh.normals == m.normals);
        CHECK(read.mesh.tangents == m.tangents);
        CHECK(read.mesh.uv_sets == m.uv_sets);
        CHECK(read.mesh.colors == m.colors);
        CHECK(read.mesh.feature_ids == m.feature_ids);
        CHECK(read.mesh.triangles == m.triangles);
        CHECK(read.mesh.face_materials == m.face_materials);
        REQUIRE(read.mesh.materials.size() == 2);
        const material& a = read.mesh.materials[0];
        const material& b = m.materials[0];
        CHECK(a.base_color == b.base_color);
        CHECK(a.metallic == b.metallic);
        CHECK(a.roughness == b.roughness);
        CHECK(a.emissive == b.emissive);
        CHECK(a.normal_scale == b.normal_scale);
        CHECK(a.occlusion_strength == b.occlusion_strength);
        CHECK(a.alpha == b.alpha);
        CHECK(a.alpha_cutoff == b.alpha_cutoff);
        CHECK(a.is_double_sided == b.is_double_sided);
        check_equal(a.base_color_texture, b.base_color_texture);
        check_equal(a.metallic_roughness_texture, b.metallic_roughness_texture);
        check_equal(a.normal_texture, b.normal_texture);
        check_equal(a.occlusion_texture, b.occlusion_texture);
        check_equal(a.emissive_texture, b.emissive_texture);
        CHECK(read.mesh.images[a.base_color_texture.image] == m.images[3]);
        CHECK(read.mesh.images[a.occlusion_texture.image] == m.images[0]);
        CHECK(read.mesh.images.size() == 3);  // the unused one is not written
        CHECK(read.mesh.materials[1].alpha == alpha_mode::blend);
    }

    TEST_CASE("same mesh, same bytes, for any number of threads") {
        const auto one = encode_glb(rich(), {.threads = {1}});
        for (const unsigned threads : {2u, 3u, 8u}) {
            CHECK(*encode_glb(rich(), {.threads = {threads}}) == *one);
        }
        const std::string text(one->begin(), one->end());
        CHECK(text.find("billow " BILLOW_VERSION) != std::string::npos);
        CHECK(one->size() % 4 == 0);
    }

    TEST_CASE("each primitive holds the vertices that it uses, within exact bounds") {
        const json root = json_of(*encode_glb(rich()));
        REQUIRE(root["meshes"][0]["primitives"].size() == 2);
        for (const auto& primitive : root["meshes"][0]["primitives"]) {
            const auto& positions =
                root["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
            CHECK(positions["count"] == 4);
            CHECK(positions["min"][0].get<float>() == 0.1f);
            CHECK(positions["max"][0].get<float>() == 1.1f);
            const auto& indices = root["accessors"][primitive["indices"].get<std::size_t>()];
            CHECK(indices["componentType"] == 5123);
        }
        CHECK(root["extensionsUsed"] == json{"KHR_texture_transform"});
        for (const auto& view : root["bufferViews"]) CHECK(view["byteOffset"].get<int>() % 4 == 0);
    }

    TEST_CASE("indices grow to 32 bits when 65,535 vertices are passed") {
        const auto type_of = [](std::uint32_t vertices) {
            mesh m;
            m.positions.resize(vertices, vec3(1));
            for (std::uint32_t v = 0; v + 2 < vertices; v += 2)
                m.triangles.emplace_back(v, v + 1, v + 2);
            const auto bytes = encode_glb(m);
            CHECK(again(m).mesh.triangles == m.triangles);
            return json_of(*bytes)["accessors"].back()["componentType"].get<int>();
        };
        CHECK(type_of(65535) == 5123);
        CHECK(type_of(65537) == 5125);
    }

    TEST_CASE("meshes of no face, no material and a wrong material are written") {
        CHECK(again({}).mesh.face_count() == 0);
        mesh m;
        m.positions = {vec3(0), vec3(1, 0, 0), vec3(0, 1, 0)};
        m.triangles = {uvec3(0, 1, 2)};
        CHECK(again(m).mesh.materials[0].metallic == 0);
        m.face_materials = {7};
        CHECK(again(m).mesh.materials[0].metallic == 0);
    }

    TEST_CASE("the second set of coordinates stands in where the first is missing") {
        mesh m = rich();
        m.uv_sets[0].clear();
        const loaded_mesh read = again(m);
        CHECK(read.mesh.uv_sets[0] == m.uv_sets[1]);
        CHECK(read.mesh.materials[0].normal_texture.is_present());
        CHECK(read.mesh.materials[0].normal_texture.uv_set == 0);
        CHECK_FALSE(read.mesh.materials[0].base_color_texture.is_present());
    }

    TEST_CASE("extras and names are written, bad ones refused") {
        const auto bytes = encode_glb(rich(), {.name = "cloud", .extras = R"({"planes":2})"});
        const json root = json_of(*bytes);
        CHECK(root["asset"]["extras"]["planes"] == 2);
        CHECK(root["nodes"][0]["name"] == "cloud");
        CHECK(encode_glb(rich(), {.extras = "{"}).error().code == error_code::invalid_options);
    }

    TEST_CASE("a mesh that is not valid is not written") {
        const scratch::folder at;
        mesh m = rich();
        m.positions[1].x = std::numeric_limits<float>::quiet_NaN();
        CHECK(failed(write_glb(at / "bad.glb", m), error_code::not_finite, "face 0", "bad.glb"));
        CHECK(at.file_count() == 0);
        CHECK(write_glb(at / "good.glb", rich()));
        CHECK(at.file_count() == 1);
    }
}
