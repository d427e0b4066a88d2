#include <billow/metrics/baselines.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include <doctest/doctest.h>

#include <billow/mesh/validate.hpp>
#include <billow/metrics/compare.hpp>
#include <billow/plants/species.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

const bake_options coarse{.texels = 64, .padding = 2, .draw = {.supersample = 2}};

mesh quads_of(const mesh& m, int count, const bake_options& options = coarse,
              parallel threads = {}) {
    return crossed_quads(m, support::table_of(m), count, options, threads);
}

/// Every k-th face: what a reducer may do at worst.
mesh thinned(const mesh& m, double share) {
    const auto wanted = static_cast<std::size_t>(
        std::max(1.0, std::round(share * static_cast<double>(m.face_count()))));
    std::vector<face_id> faces;
    for (std::size_t i = 0; i < wanted; ++i) {
        faces.push_back(static_cast<face_id>(i * m.face_count() / wanted));
    }
    return select_faces(m, faces);
}

/// A wide wall: 4 by 2 by 0.2.
mesh wall() { return box({4, 2, 0.2f}, 2); }

}  // namespace

TEST_SUITE("metrics/baselines") {
    TEST_CASE("quads are upright, stand in the middle and are turned evenly") {
        const mesh tree = leaf_soup(300, {.edge = 0.1f});
        const dvec3 centre = bounding_sphere_of(tree).centre;
        for (const int count : {1, 2, 3, 8}) {
            const mesh quads = quads_of(tree, count);
            REQUIRE(validate(quads));
            REQUIRE(quads.face_count() == static_cast<std::size_t>(2 * count));
            std::vector<double> angles;
            for (face_id face = 0; face < quads.face_count(); face += 2) {
                const auto [a, b, c] = quads.corners(face);
                const dvec3 n = glm::normalize(glm::cross(dvec3(b - a), dvec3(c - a)));
                CHECK(std::abs(n.y) < 1e-6);
                CHECK(std::abs(glm::dot(n, dvec3(a) - centre)) < 1e-5);
                angles.push_back(
                    std::fmod(std::atan2(n.x, n.z) + 2 * std::numbers::pi, std::numbers::pi));
            }
            std::sort(angles.begin(), angles.end());
            for (std::size_t i = 1; i < angles.size(); ++i) {
                CHECK(angles[i] - angles[i - 1] == doctest::Approx(std::numbers::pi / count));
            }
        }
    }
    TEST_CASE("one quad shows a wall from its broad side, as wide and high as it is") {
        const mesh quad = quads_of(wall(), 1, {.texels = 256, .padding = 2});
        vec3 low{9};
        vec3 high{-9};
        for (const vec3& p : quad.positions) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
        CHECK((high - low).x == doctest::Approx(4).epsilon(0.02));
        CHECK((high - low).y == doctest::Approx(2).epsilon(0.02));
        CHECK((high - low).z < 1e-5);
    }
    TEST_CASE("seen from the front a quad covers what the mesh covers, from its edge nothing") {
        const mesh tree = leaf_soup(400, {.edge = 0.1f});
        const mesh quad = quads_of(tree, 1, {.texels = 256, .padding = 2});
        const auto [a, b, c] = quad.corners(0);
        const dvec3 front = glm::normalize(glm::cross(dvec3(b - a), dvec3(c - a)));
        const render_scene scene(quad);
        const render_scene original(tree);
        const auto error_from = [&](const dvec3& direction) {
            const camera from = orbit_camera(original.bounds, direction, 40, 96);
            return coverage_error(render_view(original, from), render_view(scene, from));
        };
        CHECK(error_from(front).error < 0.2);
        CHECK(error_from(-front).error < 0.2);
        CHECK(error_from(glm::cross(front, dvec3(0, 1, 0))).missing > 0.95);
    }
    TEST_CASE("every quad shows the whole mesh, not only its own share of the faces") {
        const mesh m = wall();
        const mesh quads = quads_of(m, 2, {.texels = 128, .padding = 2});
        // Across the wall stands a quad that is as wide as the wall is thick.
        float widest = 0;
        float narrowest = 9;
        for (face_id face = 0; face < 4; face += 2) {
            const auto [a, b, c] = quads.corners(face);
            const float length = std::max(glm::length(b - a), glm::length(c - b));
            const float breadth = std::min(glm::length(b - a), glm::length(c - b));
            widest = std::max(widest, length);
            narrowest = std::min(narrowest, breadth);
        }
        CHECK(widest == doctest::Approx(4).epsilon(0.03));
        CHECK(narrowest == doctest::Approx(0.2).epsilon(0.2));
    }
    TEST_CASE("textures follow the bytes") {
        const mesh pot = teapot(3);
        const face_table faces = support::table_of(pot);
        for (const std::uint64_t bytes : {40'000u, 400'000u}) {
            const mesh quads = crossed_quads_of_bytes(pot, faces, 3, bytes, coarse);
            CHECK(static_cast<double>(stored_bytes_of(quads)) ==
                  doctest::Approx(static_cast<double>(bytes)).epsilon(0.15));
        }
    }
    TEST_CASE("bytes are those of columns, indices and images") {
        mesh m = box({1, 1, 1});
        const std::uint64_t plain = stored_bytes_of(m);
        CHECK(plain >= 12 * (m.vertex_count() + m.face_count()));
        m.images.push_back(image::filled(8, 4, 3, 0));
        CHECK(stored_bytes_of(m) == plain + 96);
        CHECK(stored_bytes_of(mesh{}) == 0);
    }
    TEST_CASE("reduced meshes have the triangles, and the bytes, that they may have") {
        mesh tree = *tree_of_about(2000);
        const std::uint64_t bytes = stored_bytes_of(tree) / 6;
        const auto made = make_baselines(tree, {.triangles = 50,
                                                .bytes = bytes,
                                                .quads = {1},
                                                .reducers = {{"thin", thinned}},
                                                .bake = coarse});
        REQUIRE(made.size() == 3);
        CHECK(made[0].name == "1 quad");
        CHECK(made[1].name == "thin, equal triangles");
        CHECK(made[1].mesh.face_count() == 50);
        CHECK(made[1].mesh.images == tree.images);
        CHECK(made[2].name == "thin, equal bytes");
        CHECK(stored_bytes_of(made[2].mesh) <= bytes);
        CHECK(stored_bytes_of(made[2].mesh) > bytes / 3);
        for (const baseline& b : made) CHECK(validate(b.mesh));
    }
    TEST_CASE("bytes enough leave a mesh as it is") {
        const mesh pot = teapot(2);
        const auto made = make_baselines(pot, {.triangles = 10 * pot.face_count(),
                                               .bytes = 10 * stored_bytes_of(pot),
                                               .quads = {},
                                               .reducers = {{"thin", thinned}}});
        REQUIRE(made.size() == 2);
        for (const baseline& b : made) CHECK(b.mesh.triangles.size() == pot.triangles.size());
    }
    TEST_CASE("images are halved in the light that they hold") {
        mesh m = box({1, 1, 1});
        m.images = {image::filled(64, 64, 4, 255), image::filled(64, 64, 3, 128)};
        m.materials = {{.base_color_texture = {.image = 0}}};
        detail::shrink_textures(m, 5000);
        CHECK(texture_bytes_of(m).level_0 <= 5000);
        CHECK(m.images[0].width == 16);
        CHECK(m.images[0].bytes[0] == 255);
        CHECK(m.images[1].bytes[0] == 128);
        detail::shrink_textures(m, 0);  // ends at a texel each
        CHECK(m.images[0].width == 1);
    }
    TEST_CASE("the same bytes for any number of threads") {
        const mesh tree = leaf_soup(200, {.edge = 0.1f});
        const mesh one = quads_of(tree, 3, coarse, {1});
        const mesh three = quads_of(tree, 3, coarse, {3});
        CHECK(one.positions == three.positions);
        CHECK(one.images == three.images);
    }
    TEST_CASE("a mesh without area gives no quads") {
        const mesh flat = support::triangles({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
        CHECK(quads_of(flat, 2).face_count() == 0);
    }
}
