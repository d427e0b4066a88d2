#include <billow/metrics/projected_faces.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

namespace {

using namespace billow;

std::size_t listed(projected_faces& faces) {
    std::size_t count = 0;
    for (std::size_t tile = 0; tile < faces.tile_count(); ++tile) {
        faces.for_faces_of(tile, [&](const projected_face&) { ++count; });
    }
    return count;
}

}  // namespace

TEST_SUITE("metrics/projected_faces") {
    TEST_CASE("a face is listed for every tile that a corner of it reaches into, front to back") {
        const mesh m = support::random_triangles(300, 0.3, 7);
        const render_scene scene(m);
        const sample_view view(orbit_camera(scene.bounds, {1, 2, 3}, 2, 200), 4);
        projected_faces faces;
        faces.project(scene, view);
        CHECK(faces.tile_px() == 32);
        CHECK(faces.tile_count() == 49);
        std::vector<std::set<face_id>> found(faces.tile_count());
        for (std::size_t tile = 0; tile < faces.tile_count(); ++tile) {
            float last = -1;
            faces.for_faces_of(tile, [&](const projected_face& f) {
                CHECK(f.distance >= last);
                last = f.distance;
                found[tile].insert(f.face);
            });
        }
        for (face_id face = 0; face < m.face_count(); ++face) {
            for (const vec3& corner : m.corners(face)) {
                const dvec3 p = view.project(dvec3(corner));
                const dvec2 at = dvec2(p) / p.z;
                const auto column = static_cast<std::size_t>(at.x / 128);
                const auto row = static_cast<std::size_t>(at.y / 128);
                const dvec2 into(std::fmod(at.x, 128), std::fmod(at.y, 128));
                const bool is_at_border =
                    std::min(into.x, into.y) < 1 || std::max(into.x, into.y) > 127;
                if (is_at_border) continue;  // its tip may lie between two samples
                CHECK(found[row * 7 + column].count(face) == 1);
            }
        }
    }

    TEST_CASE("tiles cover the picture once") {
        const mesh m = support::random_triangles(3, 0.3, 7);
        projected_faces faces;
        for (const int supersample : {1, 3, 8}) {
            faces.project(render_scene(m),
                          sample_view(view_of({dvec3(0), 1}, {0, 0, 1}, 131, 70), supersample));
            int pixels = 0;
            for (std::size_t tile = 0; tile < faces.tile_count(); ++tile) {
                const sample_window w = faces.pixels_of(tile);
                pixels += (w.x_end - w.x_begin) * (w.y_end - w.y_begin);
            }
            CHECK(pixels == 131 * 70);
        }
    }

    TEST_CASE("what is beside, behind or too small to be met by a sample is left out") {
        const camera from = perspective_camera({0, 0, 4}, {0, 0, 0}, 0.5, 64, 64);
        projected_faces faces;
        const auto count_of = [&](const vec3& centre, float size) {
            mesh m;
            support::add_square(m, centre, {size, 0, 0}, {0, size, 0});
            faces.project(render_scene(m), sample_view(from, 2));
            return listed(faces);
        };
        CHECK(count_of({0, 0, 0}, 0.1f) == 2);
        CHECK(count_of({3, 0, 0}, 0.1f) == 0);
        CHECK(count_of({0, -3, 0}, 0.1f) == 0);
        CHECK(count_of({0, 0, 5}, 0.1f) == 0);
        CHECK(count_of({0, 0, 0}, 0.0001f) == 0);
    }

    TEST_CASE("a face through the eye's plane is cut") {
        mesh floor;
        support::add_square(floor, {0, -1, 0}, {1000, 0, 0}, {0, 0, 1000});
        const camera from = perspective_camera({0, 0, 0}, {0, 0, -1}, 1, 64, 64);
        projected_faces faces;
        faces.project(render_scene(floor), sample_view(from, 1));
        std::size_t count = 0;
        faces.for_faces_of(0, [&](const projected_face& f) {
            ++count;
            for (std::size_t k = 0; k < 3; ++k) {
                CHECK(std::abs(f.x[k]) < 2097152.0f);
                CHECK(f.y[k] > 32);
                CHECK(f.y[k] < 2097152.0f);
            }
        });
        CHECK(count >= 2);
    }
}
