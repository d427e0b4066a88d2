#include <billow/core/random.hpp>
#include <billow/io/gltf_parse.hpp>

#include <doctest/doctest.h>

#include "scratch.hpp"

using namespace billow;
using scratch::failed;
using scratch::gltf;
using scratch::json;

namespace {

gltf plain() {
    gltf file;
    const int positions = file.triangle();
    file.primitive({{"POSITION", positions}})["indices"] = file.indices({0, 1, 2});
    return file;
}

/// What becomes of the plain file after a change.
template <class Change>
expected<loaded_mesh> read_changed(const Change& change) {
    gltf file = plain();
    change(file);
    return file.read();
}

expected<loaded_mesh> read_text(std::string_view text, std::string_view name = "made.glb") {
    const scratch::folder at;
    return read_gltf(at.put(name, text));
}

}  // namespace

TEST_SUITE("io/gltf_parse") {
    TEST_CASE("a GLB is read, whatever is cut off is not") {
        gltf file = plain();
        file.root["buffers"] = {{{"byteLength", file.binary.size()}}};
        const std::string whole =
            scratch::glb(file.text(), std::string(file.binary.begin(), file.binary.end()));
        REQUIRE(read_text(whole));
        for (std::size_t size = 1; size < whole.size(); size += 1 + size / 7) {
            const auto read = read_text(std::string_view(whole).substr(0, size));
            REQUIRE_FALSE(read);
            CHECK(read.error().message.find("made.glb: ") != std::string::npos);
        }
        std::string changed = whole;
        changed[4] = 1;
        CHECK(failed(read_text(changed), error_code::unsupported, "version 1", "made.glb"));
        changed = whole;
        changed[11] = 0x7f;  // length
        CHECK(failed(read_text(changed), error_code::truncated, "announces", "made.glb"));
        changed = whole;
        changed[15] = 0x7f;  // length of the JSON chunk
        CHECK(failed(read_text(changed), error_code::truncated, "chunk", "made.glb"));
        changed = whole;
        changed[16] = 'B';
        CHECK(failed(read_text(changed), error_code::malformed, "JSON chunk", "made.glb"));
    }

    TEST_CASE("no random damage to a GLB does worse than fail") {
        gltf file = plain();
        file.root["buffers"] = {{{"byteLength", file.binary.size()}}};
        const std::string whole =
            scratch::glb(file.text(), std::string(file.binary.begin(), file.binary.end()));
        for (std::uint64_t i = 0; i < 400; ++i) {
            std::vector<std::uint8_t> bytes(whole.begin(), whole.end());
            for (std::uint64_t k = 0; k < 3; ++k) {
                const std::uint64_t random = mix_bits(i * 3 + k);
                bytes[random % bytes.size()] = static_cast<std::uint8_t>(random >> 32);
            }
            const auto read = detail::read_gltf_bytes("made.glb", std::move(bytes), {});
            if (!read) CHECK(read.error().message.starts_with("made.glb: "));
        }
    }

    TEST_CASE("what is not glTF 2 is refused") {
        CHECK(failed(read_text("nothing"), error_code::malformed, "JSON", "made.glb"));
        CHECK(failed(read_text("[1]"), error_code::malformed, "object", "made.glb"));
        CHECK(failed(read_text("{}"), error_code::malformed, "asset", "made.glb"));
        CHECK(failed(read_text(R"({"asset":{"version":"1.0"}})"), error_code::unsupported, "1.0",
                     "made.glb"));
        CHECK(failed(read_text(std::string(1'000'000, '[')), error_code::malformed, "nested",
                     "made.glb"));
        CHECK(failed(read_changed([](gltf& f) { f.root["nodes"] = 3; }), error_code::malformed));
        CHECK(failed(read_changed([](gltf& f) {
                         f.root["meshes"] = {1, 2};
                     }),
                     error_code::malformed));
        CHECK(read_text(R"({"asset":{"version":"2.0"}})")->mesh.face_count() == 0);
    }

    TEST_CASE("ids written as 1.0 are ids") {
        CHECK(read_changed([](gltf& f) { f.root["nodes"][0]["mesh"] = 0.0; })->mesh.face_count() ==
              1);
    }

    TEST_CASE("ids that lead nowhere are refused") {
        const auto refuses = [](const auto& change) { CHECK_FALSE(read_changed(change)); };
        refuses([](gltf& f) { f.root["scene"] = 9; });
        refuses([](gltf& f) { f.root["scenes"][0]["nodes"] = {9}; });
        refuses([](gltf& f) { f.root["nodes"][0]["mesh"] = 9; });
        refuses([](gltf& f) { f.root["nodes"][0]["children"] = {-7}; });
        refuses([](gltf& f) { f.root["meshes"][0]["primitives"][0]["indices"] = 9; });
        refuses([](gltf& f) { f.root["meshes"][0]["primitives"][0]["material"] = 9; });
        refuses([](gltf& f) { f.root["meshes"][0]["primitives"][0]["mode"] = 7; });
        refuses(
            [](gltf& f) { f.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9; });
        refuses([](gltf& f) { f.root["accessors"][0]["bufferView"] = 9; });
        refuses([](gltf& f) { f.root["bufferViews"][0]["buffer"] = 9; });
    }

    TEST_CASE("nodes in a circle, or under two parents, are refused") {
        CHECK(failed(read_changed([](gltf& f) { f.root["nodes"][0]["children"] = {0}; }),
                     error_code::malformed, "twice"));
        CHECK(failed(read_changed([](gltf& f) {
                         f.root["scenes"][0]["nodes"] = {0, 0};
                     }),
                     error_code::malformed, "twice"));
        CHECK(failed(read_changed([](gltf& f) {
                         f.root.erase("scenes");
                         f.root.erase("scene");
                         f.root["nodes"][0]["children"] = {0};
                     }),
                     error_code::malformed, "circle"));
    }

    TEST_CASE("sizes are checked against the bytes that are there") {
        const auto accessor = [](const char* key, json value) {
            return read_changed([&](gltf& f) { f.root["accessors"][0][key] = value; });
        };
        CHECK(failed(accessor("count", 4'000'000'000u), error_code::out_of_range));
        CHECK(failed(accessor("count", 9'000'000'000'000'000'000u), error_code::malformed));
        CHECK(failed(accessor("count", -1), error_code::malformed));
        CHECK(failed(accessor("count", 4), error_code::out_of_range));
        CHECK(failed(accessor("byteOffset", 4), error_code::out_of_range));
        CHECK(failed(accessor("byteOffset", 9'000'000'000'000'000u), error_code::out_of_range));
        CHECK(failed(accessor("componentType", 5130), error_code::malformed));
        CHECK(failed(accessor("componentType", 1), error_code::malformed));
        CHECK(failed(accessor("type", "MAT3"), error_code::malformed));
        CHECK(failed(accessor("type", "VEC2"), error_code::malformed));
        const auto view = [](const char* key, json value) {
            return read_changed([&](gltf& f) { f.root["bufferViews"][0][key] = value; });
        };
        CHECK(failed(view("byteLength", 5000), error_code::out_of_range));
        CHECK(failed(view("byteLength", -1), error_code::malformed));
        CHECK(failed(view("byteOffset", 9'000'000'000'000'000u), error_code::out_of_range));
        CHECK(failed(view("byteStride", 252), error_code::out_of_range));
        CHECK(failed(read_changed([](gltf& f) {
                         f.root["accessors"][0].erase("bufferView");
                         f.root["accessors"][0]["count"] = 3'000'000'000u;
                     }),
                     error_code::too_large));
        CHECK(failed(read_changed([](gltf& f) {
                         f.root["accessors"][0]["sparse"] = {
                             {"count", 2'000'000'000},
                             {"indices", {{"bufferView", 1}, {"componentType", 5123}}},
                             {"values", {{"bufferView", 0}}}};
                     }),
                     error_code::out_of_range, "sparse"));
    }

    TEST_CASE("indices beyond the vertices and primitive restart are refused") {
        const auto with_index = [](std::uint16_t index) {
            gltf file;
            file.primitive({{"POSITION", file.triangle()}})["indices"] =
                file.indices({0, 1, index});
            return file.read();
        };
        CHECK(failed(with_index(3), error_code::out_of_range, "index 3"));
        CHECK(failed(with_index(65535), error_code::malformed, "restart"));
    }

    TEST_CASE("columns of different length are refused") {
        CHECK(failed(read_changed([](gltf& f) {
                         f.root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
                             f.floats({0, 0, 1, 1}, "VEC2", 2);
                     }),
                     error_code::malformed, "TEXCOORD_0"));
    }

    TEST_CASE("buffers are read beside the file only, and must hold what they announce") {
        const scratch::folder at;
        gltf file = plain();
        const auto read_with = [&](const std::string& uri, std::size_t length) {
            file.root["buffers"] = {{{"uri", uri}, {"byteLength", length}}};
            return read_gltf(at.put("made.gltf", file.text()));
        };
        const std::size_t size = file.binary.size();
        at.put("a b.bin", std::string(file.binary.begin(), file.binary.end()) + "more");
        CHECK(read_with("a%20b.bin", size));
        CHECK(read_with("./a b.bin", size));
        CHECK(failed(read_with("a b.bin", size + 5), error_code::truncated, "announces"));
        CHECK(failed(read_with("none.bin", size), error_code::not_found, "none.bin"));
        CHECK(failed(read_with("../a.bin", size), error_code::unsupported, "outside"));
        CHECK(failed(read_with("%2e%2e/a.bin", size), error_code::unsupported, "outside"));
        CHECK(failed(read_with("https://a.example/b.bin", size), error_code::unsupported));
        CHECK(failed(read_with("data:application/octet-stream;base64,AAAA", size),
                     error_code::truncated));
        CHECK(failed(read_with("data:,AAAA", size), error_code::malformed, "base64"));
    }

    TEST_CASE("compression and unknown needs are named with what to do") {
        const auto needing = [](const char* name) {
            return read_changed([&](gltf& f) { f.root["extensionsRequired"] = {name}; });
        };
        CHECK(needing("KHR_materials_unlit"));
        CHECK(failed(needing("KHR_draco_mesh_compression"), error_code::unsupported,
                     "gltf-transform"));
        CHECK(
            failed(needing("EXT_meshopt_compression"), error_code::unsupported, "gltf-transform"));
        CHECK(
            failed(needing("KHR_meshopt_compression"), error_code::unsupported, "gltf-transform"));
        CHECK(failed(needing("ACME_shape"), error_code::unsupported, "ACME_shape"));
        CHECK(failed(read_changed([](gltf& f) {
                         f.root["buffers"] = {
                             {{"byteLength", f.binary.size()},
                              {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
                     }),
                     error_code::unsupported, "meshopt"));
    }
}
