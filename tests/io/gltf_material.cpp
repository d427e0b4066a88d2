#include <billow/io/gltf_material.hpp>

#include <doctest/doctest.h>

#include <cmath>

#include "scratch.hpp"

using namespace billow;
using scratch::failed;
using scratch::gltf;
using scratch::json;

namespace {

std::string png_uri(const image& picture) {
    return "data:image/png;base64," + scratch::base64(encode_png(picture));
}

/// A triangle with texture coordinates, one image, one texture and the given material.
gltf textured(json material) {
    gltf file;
    const int positions = file.triangle();
    const int uvs = file.floats({0, 0, 1, 0, 0, 1}, "VEC2", 2);
    file.primitive(
        {{"POSITION", positions}, {"TEXCOORD_0", uvs}, {"TEXCOORD_1", uvs}})["material"] = 0;
    file.root["materials"] = json::array({std::move(material)});
    file.root["textures"] = {{{"source", 0}}};
    file.root["images"] = {{{"uri", png_uri(image::filled(2, 1, 3, 200))}}};
    return file;
}

json with_base_texture(json info = {{"index", 0}}) {
    return {{"pbrMetallicRoughness", {{"baseColorTexture", std::move(info)}}}};
}

}  // namespace

TEST_SUITE("io/gltf_material") {
    TEST_CASE("factors, textures and alpha are read") {
        gltf file = textured({{"name", "leaf"},
                              {"alphaMode", "MASK"},
                              {"alphaCutoff", 0.25},
                              {"doubleSided", true},
                              {"emissiveFactor", {0.1, 0.2, 0.3}},
                              {"normalTexture", {{"index", 0}, {"scale", 0.5}, {"texCoord", 1}}},
                              {"occlusionTexture", {{"index", 0}, {"strength", 0.75}}},
                              {"emissiveTexture", {{"index", 0}}},
                              {"pbrMetallicRoughness",
                               {{"baseColorFactor", {0.5, 0.25, 0.125, 1}},
                                {"baseColorTexture", {{"index", 0}}},
                                {"metallicRoughnessTexture", {{"index", 0}}},
                                {"metallicFactor", 0},
                                {"roughnessFactor", 0.5}}}});
        file.root["textures"][0]["sampler"] = 0;
        file.root["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
        const auto read = file.read();
        REQUIRE(read);
        const material& m = read->mesh.material_of(0);
        CHECK(m.name == "leaf");
        CHECK(m.alpha == alpha_mode::mask);
        CHECK(m.alpha_cutoff == 0.25f);
        CHECK(m.is_double_sided);
        CHECK(m.base_color == vec4(0.5f, 0.25f, 0.125f, 1));
        CHECK(m.emissive == vec3(0.1f, 0.2f, 0.3f));
        CHECK(m.metallic == 0);
        CHECK(m.roughness == 0.5f);
        CHECK(m.normal_scale == 0.5f);
        CHECK(m.normal_texture.uv_set == 1);
        CHECK(m.occlusion_strength == 0.75f);
        CHECK(m.metallic_roughness_texture.is_present());
        CHECK(m.emissive_texture.is_present());
        CHECK(m.base_color_texture.wrap_u == texture_wrap::clamp_to_edge);
        CHECK(m.base_color_texture.wrap_v == texture_wrap::mirrored_repeat);
        CHECK(m.base_color_texture.is_nearest);
        REQUIRE(read->mesh.images.size() == 1);  // decoded once for all
        CHECK(read->mesh.images[0] == image::filled(2, 1, 3, 200));
    }

    TEST_CASE("what nothing uses costs nothing, even when it is broken") {
        gltf file = textured(json::object());
        file.root["images"] = {{{"uri", "none.png"}}, {{"bufferView", 99}}};
        file.add("materials", with_base_texture());
        const auto read = file.read();
        REQUIRE(read);
        CHECK(read->mesh.images.empty());
        CHECK(read->mesh.materials.size() == 1);
    }

    TEST_CASE("KHR_texture_transform turns, scales, moves and picks the coordinates") {
        const double angle = 0.39269908169872414;
        const auto read =
            textured(with_base_texture(
                         {{"index", 0},
                          {"extensions",
                           {{"KHR_texture_transform", {{"rotation", angle}, {"texCoord", 1}}}}}}))
                .read();
        REQUIRE(read);
        const texture& t = read->mesh.materials[0].base_color_texture;
        CHECK(t.uv_set == 1);
        // Where Khronos' TextureTransformTest puts the mark of a right rotation.
        const vec3 uv = t.transform * vec3(0.4209518f, 1.0162675f, 1);
        CHECK(uv.x == doctest::Approx(0.7778175));
        CHECK(uv.y == doctest::Approx(0.7778175));

        const mat3 all = detail::texture_transform({0.5, 0.25}, 0, {2, 3});
        CHECK(all * vec3(1, 1, 1) == vec3(2.5f, 3.25f, 1));
    }

    TEST_CASE("material extensions are mapped to the base model") {
        const auto convert = [](json material) { return textured(std::move(material)).read(); };
        auto read = convert(
            {{"emissiveFactor", {0.5, 0.1, 0}},
             {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}}}}});
        REQUIRE(read);
        CHECK(read->mesh.materials[0].emissive == vec3(1, 0.4f, 0));
        CHECK(read->notes.size() == 1);

        read = convert({{"extensions",
                         {{"KHR_materials_pbrSpecularGlossiness",
                           {{"diffuseFactor", {0.2, 0.4, 0.6, 1}},
                            {"glossinessFactor", 0.25},
                            {"diffuseTexture", {{"index", 0}, {"texCoord", 1}}}}}}}});
        REQUIRE(read);
        CHECK(read->mesh.materials[0].base_color == vec4(0.2f, 0.4f, 0.6f, 1));
        CHECK(read->mesh.materials[0].metallic == 0);
        CHECK(read->mesh.materials[0].roughness == 0.75f);
        CHECK(read->mesh.materials[0].base_color_texture.uv_set == 1);

        read = convert({{"extensions", {{"KHR_materials_unlit", json::object()}}}});
        REQUIRE(read);
        CHECK(read->mesh.materials[0].metallic == 0);
    }

    TEST_CASE("a primitive without material has glTF's default one") {
        gltf file;
        file.primitive({{"POSITION", file.triangle()}});
        const auto read = file.read();
        REQUIRE(read->mesh.materials.size() == 1);
        CHECK(read->mesh.materials[0].metallic == 1);
    }

    TEST_CASE("textures that cannot be addressed are left out with a note") {
        auto read = textured(with_base_texture({{"index", 0}, {"texCoord", 2}})).read();
        REQUIRE(read);
        CHECK_FALSE(read->mesh.materials[0].base_color_texture.is_present());
        REQUIRE(read->notes.size() == 1);
        CHECK(read->notes[0].find("TEXCOORD_2") != std::string::npos);

        gltf bare = textured(with_base_texture());
        bare.root["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
        read = bare.read();
        REQUIRE(read);
        CHECK_FALSE(read->mesh.materials[0].base_color_texture.is_present());
        CHECK(read->notes.size() == 1);
    }

    TEST_CASE("images lie in the buffer, beside the file or in the text") {
        const scratch::folder at;
        const image picture = image::filled(3, 2, 4, 77);
        gltf file = textured(with_base_texture());
        file.root["images"][0] = {{"bufferView", file.view(encode_png(picture))},
                                  {"mimeType", "image/png"}};
        CHECK(file.read()->mesh.images[0] == picture);

        REQUIRE(write_png(at / "beside it.png", picture));
        file.root["images"][0] = {{"uri", "beside%20it.png"}};
        CHECK(read_gltf(at.put("made.gltf", file.text()))->mesh.images[0] == picture);
        CHECK(failed(file.read(), error_code::not_found, "beside it.png"));
    }

    TEST_CASE("images that are not read are refused with what to do") {
        gltf file = textured(with_base_texture());
        file.root["images"][0]["uri"] = "data:image/webp;base64,UklGRgAAAABXRUJQVlA4IA==";
        CHECK(failed(file.read(), error_code::unsupported, "WebP"));
        file.root["images"][0]["uri"] = "data:image/png;base64,AAAA";
        CHECK(failed(file.read(), error_code::malformed, "image 0"));
        for (const char* name : {"KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif"}) {
            file.root["textures"][0] = {{"extensions", {{name, {{"source", 0}}}}}};
            CHECK(failed(file.read(), error_code::unsupported, name));
        }
        file.root["images"][0] = json::object();
        file.root["textures"][0] = {{"source", 0}};
        CHECK(failed(file.read(), error_code::malformed, "image 0"));
        file.root["textures"][0] = {{"source", 5}};
        CHECK(failed(file.read(), error_code::out_of_range, "image 5"));
        file.root["textures"] = json::array();
        CHECK(failed(file.read(), error_code::out_of_range, "texture 0"));
    }
}
