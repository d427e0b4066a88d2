#include <billow/shapes/box.hpp>

#include <doctest/doctest.h>

#include <set>

using namespace billow;

TEST_SUITE("shapes/box") {
    TEST_CASE("the sides face outwards and enclose the volume") {
        const mesh b = box({2, 3, 4}, 3);
        CHECK(b.face_count() == 6 * 2 * 9);
        double volume = 0;
        for (face_id f = 0; f < b.face_count(); ++f) {
            const auto [p, q, r] = b.corners(f);
            volume += double(glm::dot(p, glm::cross(q, r))) / 6;
            const vec3 n = glm::normalize(glm::cross(q - p, r - p));
            CHECK(glm::dot(n, b.normals[b.triangles[f].x]) == doctest::Approx(1));
        }
        CHECK(volume == doctest::Approx(24));
    }

    TEST_CASE("every side shows its picture upright") {
        const mesh b = box();
        for (face_id f = 0; f < b.face_count(); ++f) {
            const uvec3 t = b.triangles[f];
            const auto& uv = b.uv_sets[0];
            const vec2 e = uv[t.y] - uv[t.x], g = uv[t.z] - uv[t.x];
            CHECK(e.x * g.y - e.y * g.x < 0);
        }
        for (std::size_t v = 0; v < b.vertex_count(); ++v) {
            if (b.normals[v].y == 0) CHECK(b.positions[v].y == 0.5f - b.uv_sets[0][v].y);
        }
    }

    TEST_CASE("the textured cube has six different pictures") {
        const mesh cube = textured_cube(8);
        std::set<std::vector<std::uint8_t>> pictures;
        for (const image& picture : cube.images) pictures.insert(picture.bytes);
        CHECK(pictures.size() == 6);
        for (face_id f = 0; f < 12; ++f) {
            CHECK(cube.material_of(f).base_color_texture.image == f / 2);
        }
    }
}
