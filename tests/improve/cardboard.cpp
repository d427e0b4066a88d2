#include <billow/improve/cardboard.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <billow/bake/bake_cloud.hpp>
#include <billow/bake/cloud_mesh.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/metrics/picture.hpp>
#include <billow/shapes/box.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

constexpr double cloud_epsilon = 0.1;

/// A cloud in which all faces are mapped to one upright plane through the origin.
billboard_cloud on_one_plane(const mesh& m) {
    billboard_cloud cloud;
    cloud.bounds = {dvec3(0), 1.1};
    cloud.epsilon = cloud_epsilon;
    cloud.planes = {{{0, 0, 1}, 0}};
    cloud.plane_of_face.assign(m.face_count(), 0);
    return cloud;
}

/// A round stem, 2 high and 0.16 wide, of upright quads without caps.
mesh round_stem() {
    mesh m;
    constexpr int sides = 12;
    for (int i = 0; i < sides; ++i) {
        const auto at = [](int k) {
            const double angle = (k + 0.5) * 2 * std::numbers::pi / sides;
            return vec3(dvec3(std::cos(angle), 0, std::sin(angle)) * 0.08);
        };
        for (int row = 0; row < 8; ++row) {
            support::add_square(
                m, (at(i) + at(i + 1)) * 0.5f + vec3(0, (static_cast<float>(row) - 3.5f) / 4, 0),
                (at(i) - at(i + 1)) * 0.5f, vec3(0, 0.125f, 0));
        }
    }
    return m;
}

/// How many pixels the cloud of `m` covers, seen along +x: across its primary plane.
int side_pixels(const mesh& m, billboard_cloud cloud) {
    const face_table faces = support::table_of(m);
    fit_billboards(m, cloud);
    const baked_cloud baked = bake_cloud(m, faces, cloud, {.texels = 128});
    const image picture = draw_picture(cloud_mesh(cloud, baked), view_of(cloud.bounds, {1, 0, 0}),
                                       {.background = vec3(0, 0, 1)});
    int count = 0;
    for (std::size_t i = 0; i < picture.bytes.size(); i += 3) {
        count += picture.bytes[i] > 0 || picture.bytes[i + 2] < 255 ? 1 : 0;
    }
    return count;
}

/// Small squares all over a rectangle of the plane z = 0, turned in all directions.
mesh foliage(double width, double height, std::uint64_t seed) {
    random_stream random(seed);
    mesh m;
    for (int i = 0; i < 400; ++i) {
        const dvec3 normal = support::random_direction(random);
        const frame f = frame_around(normal);
        support::add_square(
            m,
            vec3(dvec3(random.between(-width, width) / 2, random.between(-height, height) / 2,
                       random.between(-0.05, 0.05))),
            vec3(f.u * 0.02), vec3(f.v * 0.02));
    }
    return m;
}

}  // namespace

TEST_SUITE("improve/cardboard") {
    TEST_CASE("from the side a stem is seen with a cardboard plane, and not without") {
        for (const mesh& stem : {box(vec3(0.16f, 2, 0.16f), 4), round_stem()}) {
            const billboard_cloud flat = on_one_plane(stem);
            billboard_cloud full = flat;
            REQUIRE(add_cardboard_planes(stem, full) == 1);
            CHECK(side_pixels(stem, flat) < 50);
            // 2 by 0.16 of a picture 2.244 high with 512 pixels.
            const double whole = 2 * 0.16 * 512 * 512 / (2.244 * 2.244);
            CHECK(side_pixels(stem, full) == doctest::Approx(whole).epsilon(0.15));
        }
    }

    TEST_CASE("it stands across its primary plane, through the middle, along the stem") {
        mesh stem = round_stem();
        for (vec3& p : stem.positions) p += vec3(0.3f, 0, 0.02f);
        billboard_cloud cloud = on_one_plane(stem);
        REQUIRE(add_cardboard_planes(stem, cloud) == 1);
        CHECK(std::abs(cloud.planes[1].normal.x) == doctest::Approx(1));
        CHECK(cloud.planes[1].rho == doctest::Approx(0.3));
        fit_billboards(stem, cloud);
        const billboard& b = cloud.billboards[1];
        CHECK(std::min(b.width, b.height) <= 2 * cloud_epsilon);
        CHECK(std::max(b.width, b.height) == doctest::Approx(2));
        CHECK(std::max(-b.depth_low, b.depth_high) <= cloud_epsilon);
        const billboard& primary = cloud.billboards[0];
        CHECK(primary.height == doctest::Approx(2));
    }

    TEST_CASE("no face is mapped to it: only also_drawn grows, and in order") {
        const mesh stem = round_stem();
        billboard_cloud cloud = on_one_plane(stem);
        const auto mapped = cloud.plane_of_face;
        add_cardboard_planes(stem, cloud);
        CHECK(cloud.plane_of_face == mapped);
        REQUIRE(cloud.also_drawn.size() == stem.face_count());
        CHECK(std::is_sorted(cloud.also_drawn.begin(), cloud.also_drawn.end()));
        for (const drawn_too& d : cloud.also_drawn) CHECK(d.plane == 1);
        CHECK(cloud.part_of_plane.empty());
    }

    TEST_CASE("foliage wider than 2 epsilon gets none, a narrow strip of it does") {
        const mesh wide = foliage(1, 1.6, 1);
        billboard_cloud cloud = on_one_plane(wide);
        CHECK(add_cardboard_planes(wide, cloud) == 0);
        const mesh long_and_wide = foliage(0.5, 1.6, 2);
        cloud = on_one_plane(long_and_wide);
        CHECK(add_cardboard_planes(long_and_wide, cloud) == 0);
        CHECK(add_cardboard_planes(long_and_wide, cloud, {.min_coverage = 0.1}) == 1);
        const mesh narrow = foliage(0.1, 1.6, 3);
        cloud = on_one_plane(narrow);
        CHECK(add_cardboard_planes(narrow, cloud) == 1);
    }

    TEST_CASE("a lump gets one only where elongation is not asked for") {
        const mesh lump = box(vec3(0.15f));
        billboard_cloud cloud = on_one_plane(lump);
        CHECK(add_cardboard_planes(lump, cloud) == 0);
        CHECK(add_cardboard_planes(lump, cloud, {.min_elongation = 1}) == 1);
    }

    TEST_CASE("the threshold is the area on the cardboard plane over that on the primary one") {
        // A bar of 0.2 by 2 by 0.1: without caps 0.8 lie on the primary plane, 0.4 across.
        mesh bar;
        for (const float side : {-1.0f, 1.0f}) {
            support::add_square(bar, {0, 0, side * 0.05f}, {0.1f, 0, 0}, {0, 1, 0});
            support::add_square(bar, {side * 0.1f, 0, 0}, {0, 0, 0.05f}, {0, 1, 0});
        }
        billboard_cloud cloud = on_one_plane(bar);
        cloud.epsilon = 0.11;
        CHECK(add_cardboard_planes(bar, cloud, {.min_coverage = 0.51}) == 0);
        CHECK(add_cardboard_planes(bar, cloud, {.min_coverage = 0.49}) == 1);
        CHECK(add_cardboard_planes(bar, cloud, {.min_coverage = 0}) == 0);
    }

    TEST_CASE("cardboard planes are of their primary's part and use its epsilon") {
        mesh two = round_stem();
        const std::size_t first = two.face_count();
        const mesh other = round_stem();
        const auto offset = static_cast<std::uint32_t>(two.vertex_count());
        for (const vec3& p : other.positions) two.positions.push_back(p + vec3(0.5f, 0, 0));
        for (const uvec3& t : other.triangles) two.triangles.push_back(t + offset);
        billboard_cloud cloud = on_one_plane(two);
        cloud.planes.push_back(cloud.planes[0]);
        for (std::size_t f = first; f < two.face_count(); ++f) cloud.plane_of_face[f] = 1;
        cloud.part_of_plane = {0, 1};
        cloud.parts = {{0.01}, {0.1}};  // the first is narrower than its stem
        const billboard_cloud bare = cloud;
        REQUIRE(add_cardboard_planes(two, cloud) == 1);
        CHECK(cloud.part_of_plane == std::vector<part_id>{0, 1, 1});
        cloud = bare;
        CHECK(add_cardboard_planes(two, cloud, {.only_part = 0}) == 0);
        CHECK(add_cardboard_planes(two, cloud, {.only_part = 1}) == 1);
    }

    TEST_CASE("a cardboard plane gets none itself") {
        const mesh stem = round_stem();
        billboard_cloud cloud = on_one_plane(stem);
        CHECK(add_cardboard_planes(stem, cloud) == 1);
        CHECK(add_cardboard_planes(stem, cloud) == 1);  // of the primary plane alone, again
        CHECK(std::is_sorted(cloud.also_drawn.begin(), cloud.also_drawn.end()));
    }

    TEST_CASE("any number of threads gives the same planes") {
        const mesh m = foliage(1, 1.6, 5);
        billboard_cloud start = on_one_plane(m);
        start.planes.clear();
        for (int i = 0; i < 40; ++i) {  // strips, each a plane of its own
            start.planes.push_back({{0, 0, 1}, 0.0});
        }
        for (face_id f = 0; f < m.face_count(); ++f) {
            const double x = m.corners(f)[0].x;
            start.plane_of_face[f] =
                static_cast<plane_id>(std::clamp((x + 0.6) / 1.2 * 40, 0.0, 39.0));
        }
        billboard_cloud one = start;
        const std::size_t added = add_cardboard_planes(m, one, {}, {1});
        CHECK(added > 10);
        for (const unsigned threads : {2u, 3u}) {
            billboard_cloud many = start;
            CHECK(add_cardboard_planes(m, many, {}, {threads}) == added);
            CHECK(many.planes == one.planes);
            CHECK(many.also_drawn == one.also_drawn);
        }
    }

    TEST_CASE("nothing comes of no planes, faces without area, planes without faces") {
        billboard_cloud none;
        CHECK(add_cardboard_planes(mesh{}, none) == 0);
        mesh flat = support::triangles({{0, 0, 0}, {0, 1, 0}, {0, 2, 0}});
        billboard_cloud cloud = on_one_plane(flat);
        CHECK(add_cardboard_planes(flat, cloud) == 0);
        cloud.plane_of_face = {no_id};
        CHECK(add_cardboard_planes(flat, cloud) == 0);
        // Edge-on to its plane: nothing to compare with.
        mesh card;
        support::add_square(card, vec3(0), {0, 0, 0.05f}, {0, 1, 0});
        cloud = on_one_plane(card);
        CHECK(add_cardboard_planes(card, cloud) == 0);
        // Flat on its plane: nothing to see across it.
        mesh strip;
        support::add_square(strip, vec3(0), {0.05f, 0, 0}, {0, 1, 0});
        cloud = on_one_plane(strip);
        CHECK(add_cardboard_planes(strip, cloud) == 0);
    }
}
