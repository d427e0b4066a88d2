#include <billow/bake/draw_set.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include <billow/cloud/fit_billboards.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// A target that looks at a billboard with `columns` samples along its width.
draw_target target_of(const billboard& b, int columns) {
    const double size = b.width / columns;
    draw_target target;
    target.view = {b.axes, b.origin + b.axes.v * b.height, size};
    target.columns = columns;
    target.rows = static_cast<int>(std::ceil(b.height / size));
    target.band_rows = 8;
    return target;
}

}  // namespace

TEST_SUITE("bake/draw_set") {
    TEST_CASE("drawn are the mapped faces and those that are valid, not too steep and inside") {
        const mesh m = support::random_triangles(2000, 0.15, 3);
        const face_table faces = support::table_of(m);
        billboard_cloud cloud;
        cloud.bounds = faces.bounds;
        cloud.epsilon = 0.2;
        cloud.planes = {{glm::normalize(dvec3(1, 2, 3)), 0.1}};
        cloud.plane_of_face.assign(m.face_count(), no_id);
        for (face_id f = 0; f < 100; ++f) cloud.plane_of_face[f] = 0;  // wherever they are
        fit_billboards(m, cloud);
        const std::vector<draw_target> targets{target_of(cloud.billboards[0], 64)};
        const double least_cosine = std::cos(75 * std::numbers::pi / 180);
        const draw_sets sets(faces, cloud, targets, {least_cosine}, {});

        std::vector<face_id> drawn;
        for (const drawn_face& f : sets[0]) drawn.push_back(f.face);
        CHECK(std::is_sorted(sets[0].begin(), sets[0].end()));
        std::sort(drawn.begin(), drawn.end());
        const plane& p = cloud.planes[0];
        int extra = 0;
        for (face_id f = 0; f < m.face_count(); ++f) {
            const bool is_drawn = std::binary_search(drawn.begin(), drawn.end(), f);
            if (f < 100) {
                CHECK(is_drawn);
                continue;
            }
            double distance = 0;
            for (const vec3& c : m.corners(f)) {
                distance = std::max(distance,
                                    std::abs(signed_distance(p, dvec3(c) - cloud.bounds.centre)));
            }
            const double cosine = std::abs(glm::dot(p.normal, faces.normal.get(f)));
            if (distance > cloud.epsilon + 1e-5 || cosine < least_cosine - 1e-5)
                CHECK_FALSE(is_drawn);
            extra += is_drawn ? 1 : 0;
        }
        CHECK(extra > 50);
    }
    TEST_CASE(
        "faces of another part are never extras, nor are unmapped ones of a cloud with parts") {
        const mesh m = support::random_triangles(1000, 0.15, 4);
        const face_table faces = support::table_of(m);
        billboard_cloud cloud;
        cloud.bounds = faces.bounds;
        cloud.epsilon = 0.3;
        cloud.planes = {{{0, 0, 1}, 0}, {{0, 0, 1}, 0.05}, {{0, 0, 1}, 0.1}};
        for (face_id f = 0; f < m.face_count(); ++f) {
            cloud.plane_of_face.push_back(f % 4 == 3 ? no_id : f % 4);
        }
        fit_billboards(m, cloud);
        const auto drawn_by_home = [&](crack_reduction cracks) {
            std::vector<draw_target> targets;
            for (const billboard& b : cloud.billboards) targets.push_back(target_of(b, 64));
            const draw_sets sets(faces, cloud, targets, {0.2, cracks}, {});
            std::vector<std::array<int, 4>> count(3);
            for (plane_id id = 0; id < 3; ++id) {
                for (const drawn_face& f : sets[id]) ++count[id][f.face % 4];
            }
            return count;
        };
        for (const auto cracks : {crack_reduction::none, crack_reduction::envelope}) {
            cloud.part_of_plane.clear();
            cloud.parts.clear();
            auto count = drawn_by_home(cracks);
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t home = 0; home < 4; ++home) CHECK(count[i][home] > 10);
            }
            const int whole = count[0][1];
            cloud.part_of_plane = {0, 0, 1};
            cloud.parts = {{0.3}, {0.3}};
            count = drawn_by_home(cracks);
            CHECK(count[0][1] == whole);
            CHECK(count[1][0] > 10);
            for (const std::size_t i : {0u, 1u}) CHECK(count[i][2] == 0);
            CHECK(count[2][0] + count[2][1] == 0);
            CHECK(count[2][2] == 250);
            for (std::size_t i = 0; i < 3; ++i) CHECK(count[i][3] == 0);
            cloud.also_drawn = {{2, 0}, {2, 3}};
            count = drawn_by_home(cracks);
            CHECK(count[2][0] == 1);
            CHECK(count[2][3] == 1);
            cloud.also_drawn.clear();
        }
        cloud.parts = {{0.3}, {0.0}};
        cloud.part_of_plane = {0, 1, 1};
        CHECK(drawn_by_home(crack_reduction::none)[1][2] == 0);  // within no epsilon at all
    }
    TEST_CASE("in the envelope's set are the faces with a corner in the box, and no others") {
        const mesh m = support::random_triangles(3000, 0.2, 5);
        const face_table faces = support::table_of(m);
        billboard_cloud cloud;
        cloud.bounds = faces.bounds;
        cloud.epsilon = 0.1;
        cloud.planes = {{glm::normalize(dvec3(2, -1, 1)), 0.2}};
        cloud.plane_of_face.assign(m.face_count(), no_id);
        cloud.billboards = {{.origin = cloud.bounds.centre + cloud.planes[0].normal * 0.2,
                             .axes = frame_around(cloud.planes[0].normal),
                             .width = 0.5,
                             .height = 0.4,
                             .depth_low = -0.1,
                             .depth_high = 0.05}};
        const std::vector<draw_target> targets{target_of(cloud.billboards[0], 50)};
        const billboard& b = cloud.billboards[0];
        std::size_t last = 0;
        for (const double scale : {0.5, 1.0}) {
            const draw_sets sets(faces, cloud, targets, {2, crack_reduction::envelope, scale}, {2});
            std::vector<face_id> drawn;
            for (const drawn_face& f : sets[0]) drawn.push_back(f.face);
            std::sort(drawn.begin(), drawn.end());
            CHECK(drawn.size() > last);
            last = drawn.size();
            const dvec3 half = dvec3(0.5, 0.4, 0.15) * 0.5 * scale;
            for (face_id f = 0; f < m.face_count(); ++f) {
                double out = 1;  // of the corner that is farthest inside
                for (const vec3& c : m.corners(f)) {
                    const dvec3 off = b.axes.to_local(dvec3(c) - b.origin);
                    const dvec3 past = glm::abs(off - dvec3(0.25, 0.2, -0.025)) - half;
                    out = std::min(out, std::max({past.x, past.y, past.z}));
                }
                if (out < 0) CHECK(std::binary_search(drawn.begin(), drawn.end(), f));
                if (out > 1e-4) CHECK_FALSE(std::binary_search(drawn.begin(), drawn.end(), f));
            }
        }
        CHECK(last > 20);
        const draw_sets none(faces, cloud, targets, {2}, {});
        CHECK(none[0].empty());
    }
    TEST_CASE("a face is listed for every band that it may touch") {
        draw_target target;
        target.view = {frame{}, dvec3(0, 4, 0), 0.1};
        target.columns = 40;
        target.rows = 40;
        target.band_rows = 10;
        const auto face =
            clipped_to(target, 7, {dvec3(1, 3.5, 2), dvec3(2, 3.5, 1), dvec3(1, 1.5, 0)});
        REQUIRE(face);
        CHECK(face->face == 7);
        CHECK(face->first_band == 0);
        CHECK(face->last_band == 2);
        CHECK(face->height == 2);
        CHECK_FALSE(clipped_to(target, 7, {dvec3(9, 9, 0), dvec3(9, 8, 0), dvec3(8, 9, 0)}));
    }
}
