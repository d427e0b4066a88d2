#include <billow/bake/occlusion.hpp>

#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <billow/bake/horizon.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

constexpr vec3 middle(1.0f / 3);

sky_table sky_of(const mesh& m, const occlusion_options& options = {.rays = 256},
                 unsigned threads = 1) {
    const surface look(m);
    return see_sky(look, support::table_of(m), options, {threads});
}
float open_of(const mesh& m, face_id face = 0, const occlusion_options& options = {.rays = 256}) {
    return sky_of(m, options).at(face, middle).open;
}
mesh square(const vec3& centre = vec3(0), float half = 1) {
    mesh m;
    support::add_square(m, centre, {half, 0, 0}, {0, half, 0});
    return m;
}
/// A disc around (0, 0, height) that looks down, in `count` triangles.
void add_disc(mesh& m, float height, float radius, int count = 64) {
    const auto first = static_cast<std::uint32_t>(m.vertex_count());
    m.positions.emplace_back(0, 0, height);
    for (int i = 0; i <= count; ++i) {
        const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i % count) /
                            static_cast<float>(count);
        m.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
        const auto at = first + static_cast<std::uint32_t>(i);
        if (i > 0) m.triangles.push_back({first, at + 1, at});
    }
}
void use_material(mesh& m, alpha_mode alpha, bool is_double_sided) {
    m.materials = {{.alpha = alpha, .is_double_sided = is_double_sided}};
}

}  // namespace

TEST_SUITE("bake/occlusion") {
    TEST_CASE("a square on its own sees all the sky, and half of it from the ground") {
        mesh m = square();
        CHECK(open_of(m) == 1);
        const occlusion_options ground{.rays = 1024, .sky_up = {0, 1, 0}};
        CHECK(open_of(m, 0, ground) == doctest::Approx(0.5).epsilon(0.08));
        CHECK(open_of(m, 0, {.rays = 64, .sky_up = {0, 0, 1}}) == 1);
        CHECK(open_of(m, 0, {.rays = 64, .sky_up = {0, 0, -1}}) == 0);
        CHECK(sky_of(m).at(0, middle).visible.w == 0.5f);
        use_material(m, alpha_mode::mask, true);
        CHECK(open_of(m) == 1);
        CHECK(sky_of(m).at(0, middle).visible.w == 1.0f);
        CHECK(open_of(m, 0, ground) == doctest::Approx(0.5).epsilon(0.08));
    }
    TEST_CASE("between two plates it is dark, outside light") {
        mesh m = square();
        support::add_square(m, {0, 0, 0.05f}, {1, 0, 0}, {0, 1, 0});
        CHECK(open_of(m, 0) < 0.08f);
        CHECK(open_of(m, 2) == 1);
        SUBCASE("a double-sided plate counts with its better side") {
            use_material(m, alpha_mode::opaque, true);
            CHECK(open_of(m, 0) == 1);
            CHECK(open_of(m, 2) == 1);
        }
        SUBCASE("foliage with the mean of both") {
            use_material(m, alpha_mode::mask, true);
            CHECK(open_of(m, 0) == doctest::Approx(0.52).epsilon(0.06));
        }
        SUBCASE("what is beyond reach hides nothing, strength lessens it") {
            CHECK(open_of(m, 0, {.rays = 256, .reach = 0.01}) == 1);
            const float whole = open_of(m, 0);
            CHECK(open_of(m, 0, {.rays = 256, .strength = 0.25}) ==
                  doctest::Approx(1 - 0.25 * (1 - whole)));
        }
    }
    TEST_CASE("in a closed box it is black, outside white") {
        mesh m = box(vec3(2), 4);
        for (const sky_view& view : sky_of(m).views) CHECK(view.open == 1);
        for (uvec3& t : m.triangles) std::swap(t.y, t.z);
        const sky_table inside = sky_of(m);
        for (face_id face = 0; face < m.face_count(); ++face) {
            CHECK(inside.at(face, middle).open < 0.01f);  // where a ray starts in an edge
        }
        use_material(m, alpha_mode::opaque, true);
        for (const sky_view& view : sky_of(m).views) CHECK(view.open == 1);
    }
    TEST_CASE("below a disc it is as dark as calculated") {
        for (const float radius : {0.5f, 1.0f, 2.0f}) {
            mesh m = square(vec3(0), 0.01f);
            add_disc(m, 1, radius);
            // Of a plane's light the disc takes sin² of the angle to its rim.
            const double expected = 1 - radius * radius / (1.0 + radius * radius);
            CHECK(std::abs(open_of(m, 0, {.rays = 2000}) - expected) < 0.02);
            CHECK(std::abs(open_of(m, 0, {.rays = 64}) - expected) < 0.12);
        }
    }
    TEST_CASE("light falls through holes of alpha") {
        mesh m = square(vec3(0), 0.01f);
        support::add_square(m, {0, 0, 1}, {9, 0, 0}, {0, -9, 0});
        m.uv_sets[0] = {{0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
        m.images = {image::filled(32, 32, 4, 255)};
        const float covered = open_of(m);
        CHECK(covered < 0.05f);
        m.materials = {{}, {.base_color_texture = {.image = 0}, .alpha = alpha_mode::mask}};
        m.face_materials = {0, 0, 1, 1};
        CHECK(open_of(m) == covered);
        SUBCASE("cut out") {
            for (int y = 12; y < 20; ++y) {
                for (int x = 12; x < 20; ++x) m.images[0].pixel(x, y)[3] = 0;
            }
            // A square hole, half 2.25 wide: more than a disc of this radius lets in, less than all.
            CHECK(open_of(m) > 2.25f * 2.25f / (1 + 2.25f * 2.25f) - 0.05f);
            CHECK(open_of(m) < 0.97f);
        }
        SUBCASE("half transparent") {
            for (std::size_t i = 3; i < m.images[0].bytes.size(); i += 4) {
                m.images[0].bytes[i] = 128;
            }
            m.materials[1].alpha = alpha_mode::blend;
            CHECK(open_of(m, 0, {.rays = 2000}) == doctest::Approx(0.5).epsilon(0.1));
        }
    }
    TEST_CASE("a leaf has one value, inner leaves are darker than outer ones") {
        const mesh soup = leaf_soup(6000, {.edge = 0.08f});
        const sky_table sky = sky_of(soup, {.rays = 32});
        double inner = 0, outer = 0;
        int inner_count = 0, outer_count = 0;
        for (face_id face = 0; face < soup.face_count(); ++face) {
            CHECK(sky.of_face[face] == uvec3(sky.of_face[face - face % 2].x));
            const float distance = glm::length(soup.corners(face)[0]);
            if (distance < 0.5f) inner += sky.at(face, middle).open, ++inner_count;
            if (distance > 0.9f) outer += sky.at(face, middle).open, ++outer_count;
        }
        CHECK(inner / inner_count < 0.6 * outer / outer_count);
    }
    TEST_CASE("a floor darkens towards a wall") {
        mesh m = box(vec3(4, 0.2f, 4), 8);
        m.normals.clear(), m.uv_sets[0].clear();
        support::add_square(m, {0, 2, 0}, {4, 0, 0}, {0, 2, 0});  // through the middle
        const sky_table sky = sky_of(m);
        float near = 1, far = 0;
        for (face_id face = 2 * 64 * 2; face < 3 * 64 * 2; ++face) {  // the upper side
            const auto [a, b, c] = m.corners(face);
            const vec3 centre = (a + b + c) / 3.0f;
            const float open = sky.at(face, middle).open;
            if (std::abs(centre.z) < 0.3f) near = std::min(near, open);
            if (std::abs(centre.z) > 1.7f) far = std::max(far, open);
        }
        CHECK(near < far - 0.1f);
    }
    TEST_CASE("any number of threads gives the same bytes") {
        const mesh soup = leaf_soup(2000);
        const sky_table one = sky_of(soup, {.rays = 16}, 1);
        for (const unsigned threads : {2u, 3u, 8u}) {
            const sky_table many = sky_of(soup, {.rays = 16}, threads);
            REQUIRE(many.views.size() == one.views.size());
            CHECK(std::memcmp(many.views.data(), one.views.data(),
                              one.views.size() * sizeof(sky_view)) == 0);
            CHECK(many.of_face == one.of_face);
        }
    }
    TEST_CASE("other seeds differ by noise alone, which more rays lessen") {
        const mesh soup = leaf_soup(1000, {.edge = 0.1f});
        const sky_table exact = sky_of(soup, {.rays = 1024});
        const auto noise = [&](int rays, std::uint64_t seed) {
            const sky_table sky = sky_of(soup, {.rays = rays, .seed = seed});
            double squares = 0;
            for (std::size_t i = 1; i < sky.views.size(); ++i) {
                const double off = sky.views[i].open - exact.views[i].open;
                squares += off * off;
            }
            return std::sqrt(squares / static_cast<double>(sky.views.size() - 1));
        };
        CHECK(noise(16, 1) < 0.4 / 4);
        CHECK(noise(64, 2) < 0.4 / 8);
        CHECK(noise(64, 2) < 0.7 * noise(16, 2));
        CHECK(noise(16, 1) != noise(16, 2));
    }
    TEST_CASE("nothing, and faces without area, are no trouble") {
        CHECK(sky_of({}).views.size() == 1);
        const mesh m =
            support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}});
        CHECK(open_of(m, 1) == 1);
    }
}
