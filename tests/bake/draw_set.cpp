#include <billow/bake/draw_set.hpp>

#include <algorithm>
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
