#include <billow/metrics/sample_tile.hpp>

#include <doctest/doctest.h>

#include <billow/metrics/render_scene.hpp>

#include "support/meshes.hpp"

namespace {

using namespace billow;

/// Every face of a mesh on the first tile of a view.
struct drawn_tile {
    sample_tile tile;
    fragment_count count{};

    template <bool Counts = false>
    drawn_tile(const mesh& m, const sample_view& view, int supersample) : tile(supersample) {
        draw<Counts>(m, view);
    }
    template <bool Counts>
    void draw(const mesh& m, const sample_view& view) {
        const render_scene scene(m);
        projected_faces faces;
        faces.project(scene, view);
        const sample_window p = faces.pixels_of(0);
        const int s = view.supersample;
        tile.start({p.x_begin * s, p.y_begin * s, p.x_end * s, p.y_end * s});
        faces.for_faces_of(0, [&](const projected_face& face) {
            tile.draw<Counts>(scene.look, view, face, count);
        });
    }
};

/// Faces with a random share of holes: a material that blends.
mesh half_there(std::size_t count) {
    mesh m = support::random_triangles(count, 0.5, 11);
    m.materials.resize(1);
    m.materials[0].alpha = alpha_mode::blend;
    m.materials[0].base_color.w = 0.5f;
    return m;
}

}  // namespace

TEST_SUITE("metrics/sample_tile") {
    TEST_CASE("the foremost face is the one that a ray meets first") {
        const mesh m = support::random_triangles(150, 0.4, 3);
        const camera from = perspective_camera({0.3, 0.2, 1.2}, {0, 0, 0}, 1.2, 64, 64, 0.01);
        const sample_view view(from, 1);
        const drawn_tile drawn(m, view, 1);
        int wrong = 0;
        int hits = 0;
        for (int y = 0; y < 64; ++y) {
            for (int x = 0; x < 64; ++x) {
                const dvec3 ray = -dvec3(view.toward_viewer({x + 0.5, y + 0.5}));
                face_id nearest = no_id;
                double at = 1e9;
                for (face_id face = 0; face < m.face_count(); ++face) {
                    const auto [a, b, c] = m.corners(face);
                    const dvec3 e1 = dvec3(b) - dvec3(a);
                    const dvec3 e2 = dvec3(c) - dvec3(a);
                    const dvec3 n = glm::cross(e1, e2);
                    const double t = glm::dot(n, dvec3(a) - from.eye) / glm::dot(n, ray);
                    if (!(t * -glm::dot(ray, from.axes.normal) > 0.01 && t < at)) continue;
                    const dvec3 p = from.eye + ray * t - dvec3(a);
                    const double beta = glm::dot(glm::cross(p, e2), n) / glm::dot(n, n);
                    const double gamma = glm::dot(glm::cross(e1, p), n) / glm::dot(n, n);
                    if (beta >= 0 && gamma >= 0 && beta + gamma <= 1) nearest = face, at = t;
                }
                hits += nearest != no_id ? 1 : 0;
                wrong += drawn.tile.face_at(x, y) != nearest ? 1 : 0;
                if (drawn.tile.face_at(x, y) == nearest && nearest != no_id) {
                    const double distance = at * -glm::dot(ray, from.axes.normal);
                    CHECK(view.distance_of(drawn.tile.nearness_at(x, y)) ==
                          doctest::Approx(distance).epsilon(1e-3));
                }
            }
        }
        CHECK(hits > 2500);
        CHECK(wrong <= 4);  // corners are rounded to 1/256 sample
    }

    TEST_CASE("of equal faces the first is seen") {
        mesh m;
        for (int i = 0; i < 3; ++i) support::add_square(m, vec3(0), {1, 0, 0}, {0, 1, 0});
        const drawn_tile drawn(m, sample_view(orbit_camera({dvec3(0), 1}, {0, 0, 1}, 4, 32), 2), 2);
        CHECK(drawn.tile.face_at(39, 39) == 0);
        CHECK(drawn.tile.face_at(25, 25) == 1);
    }

    TEST_CASE("counting fragments changes nothing that is seen") {
        const mesh m = half_there(60);
        const sample_view view(orbit_camera({dvec3(0), 1}, {1, 1, 1}, 3, 32), 4);
        const drawn_tile plain(m, view, 4);
        drawn_tile counted(m, view, 4);
        counted.draw<true>(m, view);
        std::uint64_t seen = 0;
        for (int y = 0; y < 128; ++y) {
            for (int x = 0; x < 128; ++x) {
                CHECK(plain.tile.face_at(x, y) == counted.tile.face_at(x, y));
                seen += plain.tile.face_at(x, y) != no_id ? 1u : 0u;
            }
        }
        CHECK(plain.count.opaque == 0);
        CHECK(counted.count.opaque > seen);
        CHECK(static_cast<double>(counted.count.transparent) ==
              doctest::Approx(static_cast<double>(counted.count.opaque)).epsilon(0.02));
    }

    TEST_CASE("parts of a pixel hold all samples that show something") {
        const mesh m = support::random_triangles(400, 0.1, 9);
        const sample_view view(orbit_camera({dvec3(0), 1}, {1, 1, 1}, 3, 16), 8);
        const drawn_tile drawn(m, view, 8);
        std::array<texel_part, max_supersample * max_supersample> parts;
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) {
                const std::size_t count = drawn.tile.parts_of(x, y, 8, parts);
                int samples = 0;
                for (std::size_t i = 0; i < count; ++i) {
                    samples += parts[i].samples;
                    CHECK(std::abs(parts[i].centre.x - (x + 0.5) * 8) < 4);
                    CHECK(std::abs(parts[i].centre.y - (y + 0.5) * 8) < 4);
                }
                for (int k = 0; k < 64; ++k) {
                    samples -= drawn.tile.face_at(x * 8 + k % 8, y * 8 + k / 8) != no_id ? 1 : 0;
                }
                CHECK(samples == 0);
            }
        }
    }
}
