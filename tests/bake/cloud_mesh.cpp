#include <billow/bake/cloud_mesh.hpp>

#include <doctest/doctest.h>

namespace {

using namespace billow;

/// A cloud of two billboards whose tiles lie upright and turned.
struct two_cards {
    billboard_cloud cloud;
    baked_cloud baked;

    two_cards() {
        const frame axes{{0, 0, -1}, {0, 1, 0}, {1, 0, 0}};
        cloud.billboards = {{{1, 2, 3}, axes, 4, 2}, {{5, 0, 0}, {}, 4, 2}};
        cloud.planes.resize(2);
        baked.atlases = {{image::filled(64, 32, 4, 255), image::filled(64, 32, 3, 128), {}, {}}};
        baked.tiles = {{0, 8, 4, 20, 10, false}, {0, 40, 4, 10, 20, true}};
    }
};

}  // namespace

TEST_SUITE("bake/cloud_mesh") {
    TEST_CASE("quads lie where the billboards are, facing their fronts") {
        const two_cards cards;
        const mesh m = cloud_mesh(cards.cloud, cards.baked);
        REQUIRE(m.vertex_count() == 8);
        REQUIRE(m.face_count() == 4);
        CHECK(m.positions[0] == vec3(1, 2, 3));
        CHECK(m.positions[2] == vec3(1, 4, -1));
        for (face_id f = 0; f < 4; ++f) {
            const auto [a, b, c] = m.corners(f);
            CHECK(glm::dot(glm::cross(b - a, c - a), m.normals[m.triangles[f].x]) ==
                  doctest::Approx(8));
        }
        CHECK(m.feature_ids == std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1, 1});
    }

    TEST_CASE("tangents and bitangents follow the texture, turned or not") {
        const two_cards cards;
        const mesh m = cloud_mesh(cards.cloud, cards.baked);
        for (std::uint32_t first : {0u, 4u}) {
            const auto edge = [&](std::uint32_t i) {
                return m.positions[first + i] - m.positions[first];
            };
            const auto d = [&](std::uint32_t i) {
                return m.uv_sets[0][first + i] - m.uv_sets[0][first];
            };
            const float det = d(1).x * d(3).y - d(1).y * d(3).x;
            const vec3 along_u = (edge(1) * d(3).y - edge(3) * d(1).y) / det;
            const vec3 along_v = (edge(3) * d(1).x - edge(1) * d(3).x) / det;
            const vec4 t = m.tangents[first];
            const vec3 up = glm::cross(m.normals[first], vec3(t)) * t.w;
            CHECK(glm::dot(glm::normalize(along_u), vec3(t)) == doctest::Approx(1));
            CHECK(glm::dot(glm::normalize(along_v), up) == doctest::Approx(-1));
        }
    }

    TEST_CASE("texture corners are the tile's corners") {
        const two_cards cards;
        const mesh m = cloud_mesh(cards.cloud, cards.baked);
        const auto pixels = [&](std::size_t i) { return m.uv_sets[0][i] * vec2(64, 32); };
        CHECK(pixels(0) == vec2(8, 14));   // lower left of an upright tile
        CHECK(pixels(2) == vec2(28, 4));   // upper right
        CHECK(pixels(4) == vec2(40, 4));   // lower left, turned clockwise: upper left
        CHECK(pixels(5) == vec2(40, 24));  // u runs down
        CHECK(pixels(7) == vec2(50, 4));   // v runs to the right
    }

    TEST_CASE("a billboard with a back has a second polygon that faces the other way") {
        two_cards cards;
        cards.baked.tiles.push_back({0, 8, 20, 20, 10, false});
        cards.baked.back_of = {2, no_id};
        const mesh m = cloud_mesh(cards.cloud, cards.baked);
        REQUIRE(m.face_count() == 6);
        CHECK(m.feature_ids == std::vector<std::uint32_t>{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1});
        const auto [a, b, c] = m.corners(2);
        CHECK(glm::dot(glm::cross(b - a, c - a), m.normals[4]) == doctest::Approx(8));
        CHECK(m.normals[4] == -m.normals[0]);
        CHECK(m.positions[4] == m.positions[0]);
        // Seen from behind, the corner (0, 0) is on the right.
        CHECK(m.uv_sets[0][4] * vec2(64, 32) == vec2(28, 30));
        REQUIRE(m.materials.size() == 2);
        CHECK_FALSE(m.materials[m.face_materials[0]].is_double_sided);
        CHECK(m.materials[m.face_materials[4]].is_double_sided);
        CHECK(m.images.size() == 2);  // shared
        // The tangent frame of the back follows its texture, too.
        const vec3 along_u = m.positions[4] - m.positions[5];
        CHECK(glm::dot(glm::normalize(along_u), vec3(m.tangents[4])) == doctest::Approx(1));
    }

    TEST_CASE("outlines become fans") {
        two_cards cards;
        cards.baked.outlines = {{{.5, 0}, {1, .5}, {.5, 1}, {.25, 1}, {0, .5}},
                                {{0, 0}, {1, 0}, {0, 1}}};
        const mesh m = cloud_mesh(cards.cloud, cards.baked);
        CHECK(m.vertex_count() == 8);
        REQUIRE(m.face_count() == 4);
        CHECK(m.positions[0] == vec3(1, 2, 1));
        CHECK(m.uv_sets[0][0] * vec2(64, 32) == vec2(18, 14));
        for (face_id f = 0; f < 4; ++f) {
            const auto [a, b, c] = m.corners(f);
            CHECK(glm::dot(glm::cross(b - a, c - a), m.normals[m.triangles[f].x]) > 0);
        }
    }

    TEST_CASE("materials are masked, double sided and not metal") {
        const two_cards cards;
        const mesh m = cloud_mesh(cards.cloud, cards.baked);
        REQUIRE(m.materials.size() == 1);
        CHECK(m.images.size() == 2);
        const material& look = m.materials[0];
        CHECK(look.alpha == alpha_mode::mask);
        CHECK(look.alpha_cutoff == 0.5f);
        CHECK(look.is_double_sided);
        CHECK(look.metallic == 0);
        CHECK(look.normal_texture.is_present());
        CHECK_FALSE(look.emissive_texture.is_present());
        CHECK_FALSE(look.occlusion_texture.is_present());
    }
}
