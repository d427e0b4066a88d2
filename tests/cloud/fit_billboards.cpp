#include <billow/cloud/fit_billboards.hpp>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

/// Some faces near each of a few planes.
struct scene {
    mesh shape;
    billboard_cloud cloud;
};

scene random_scene(std::uint64_t seed, std::size_t planes, std::size_t faces) {
    random_stream random(seed);
    scene s;
    for (std::size_t i = 0; i < planes; ++i) {
        const dvec3 normal = glm::normalize(
            dvec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)));
        s.cloud.planes.push_back(canonical({normal, random.between(-1, 1)}));
        const frame f = frame_around(s.cloud.planes[i].normal);
        for (std::size_t k = 0; k < faces; ++k) {
            uvec3 triangle;
            for (int c = 0; c < 3; ++c) {
                triangle[c] = static_cast<std::uint32_t>(s.shape.positions.size());
                const dvec3 local(random.between(-1, 1), random.between(-0.3, 0.2),
                                  s.cloud.planes[i].rho + random.between(-0.05, 0.1));
                s.shape.positions.push_back(vec3(f.to_scene(local) + dvec3(3, 2, 1)));
            }
            s.shape.triangles.push_back(triangle);
            s.cloud.plane_of_face.push_back(static_cast<plane_id>(i));
        }
    }
    s.cloud.bounds = {dvec3(3, 2, 1), 2};
    return s;
}

scene one_quad(bool is_flipped, double rho, dvec3 normal = {0, 0, 1}) {
    scene s;
    s.cloud.planes = {canonical({normal, rho})};
    const frame f = frame_around(normal);
    for (const dvec2 c : {dvec2(0, 0), dvec2(2, 0), dvec2(2, 1), dvec2(0, 1)}) {
        s.shape.positions.push_back(vec3(f.to_scene({c.x, c.y, rho})));
    }
    s.shape.triangles = {{0, 1, 2}, {0, 2, 3}};
    if (is_flipped) s.shape.triangles = {{0, 2, 1}, {0, 3, 2}};
    s.cloud.plane_of_face = {0, 0};
    s.cloud.bounds = {dvec3(0), 3};
    return s;
}

}  // namespace

TEST_SUITE("cloud/fit_billboards") {
    TEST_CASE("a billboard lies on its plane and holds the mapped vertices") {
        auto s = random_scene(1, 20, 15);
        fit_billboards(s.shape, s.cloud);
        REQUIRE(s.cloud.billboards.size() == 20);
        for (std::size_t f = 0; f < s.shape.face_count(); ++f) {
            const billboard& b = s.cloud.billboards[s.cloud.plane_of_face[f]];
            const plane& p = s.cloud.planes[s.cloud.plane_of_face[f]];
            CHECK(signed_distance(p, b.origin - s.cloud.bounds.centre) == doctest::Approx(0));
            CHECK(glm::length(glm::cross(b.axes.u, b.axes.v) - b.axes.normal) < 1e-12);
            CHECK(std::abs(glm::dot(b.axes.normal, p.normal)) == doctest::Approx(1));
            for (const vec3& corner : s.shape.corners(static_cast<face_id>(f))) {
                const dvec3 local = b.axes.to_local(dvec3(corner) - b.origin);
                CHECK(local.x >= -1e-9);
                CHECK(local.x <= b.width + 1e-9);
                CHECK(local.y >= -1e-9);
                CHECK(local.y <= b.height + 1e-9);
                CHECK(local.z >= b.depth_low - 1e-9);
                CHECK(local.z <= b.depth_high + 1e-9);
            }
        }
    }

    TEST_CASE("most of the mapped area faces the front") {
        auto s = random_scene(2, 20, 5);
        fit_billboards(s.shape, s.cloud);
        std::vector<double> facing(20, 0);
        for (std::size_t f = 0; f < s.shape.face_count(); ++f) {
            const auto c = s.shape.corners(static_cast<face_id>(f));
            const plane_id p = s.cloud.plane_of_face[f];
            facing[p] += glm::dot(glm::cross(dvec3(c[1] - c[0]), dvec3(c[2] - c[0])),
                                  s.cloud.billboards[p].axes.normal);
        }
        for (const double value : facing) CHECK(value >= 0);
    }

    TEST_CASE("the front follows the winding, and is the outer side of even halves") {
        for (const double rho : {0.5, -0.5}) {
            for (const bool flip : {false, true}) {
                auto s = one_quad(flip, rho);
                fit_billboards(s.shape, s.cloud);
                CHECK(s.cloud.billboards[0].axes.normal.z == doctest::Approx(flip ? -1 : 1));
            }
            auto both = one_quad(false, rho);
            both.shape.triangles = {{0, 1, 2}, {0, 2, 1}};
            fit_billboards(both.shape, both.cloud);
            CHECK(both.cloud.billboards[0].axes.normal.z == doctest::Approx(rho > 0 ? 1 : -1));
        }
    }

    TEST_CASE("v points up as far as the rectangle allows") {
        auto wall = one_quad(false, 0.5, {0, 0, 1});
        fit_billboards(wall.shape, wall.cloud);
        CHECK(wall.cloud.billboards[0].axes.v.y == doctest::Approx(1));
        CHECK(wall.cloud.billboards[0].width == doctest::Approx(2));
        CHECK(wall.cloud.billboards[0].height == doctest::Approx(1));
        auto floor = one_quad(false, 0.5, {0, 1, 0});
        fit_billboards(floor.shape, floor.cloud);
        CHECK(floor.cloud.billboards[0].axes.v.z == doctest::Approx(-1));
        auto many = random_scene(3, 40, 8);
        fit_billboards(many.shape, many.cloud);
        for (const billboard& b : many.cloud.billboards) {
            if (std::abs(b.axes.normal.y) > 0.999) continue;
            CHECK(b.axes.v.y >= std::abs(b.axes.u.y) - 1e-9);
        }
    }

    TEST_CASE("planes without faces and collinear faces have zero extents") {
        auto s = one_quad(false, 0.5);
        s.cloud.planes.push_back({{1, 0, 0}, 0.25});
        s.shape.positions[2] = s.shape.positions[1] * 2.0f - s.shape.positions[0];
        s.shape.triangles = {{0, 1, 2}, {0, 1, 2}};
        fit_billboards(s.shape, s.cloud);
        CHECK(std::min(s.cloud.billboards[0].width, s.cloud.billboards[0].height) < 1e-12);
        CHECK(s.cloud.billboards[1].width == 0);
        CHECK(s.cloud.billboards[1].origin.x == doctest::Approx(0.25));
        billboard_cloud none;
        fit_billboards(mesh{}, none);
        CHECK(none.billboards.empty());
    }

    TEST_CASE("one, two and three threads give the same billboards") {
        auto a = random_scene(4, 50, 10);
        auto b = a;
        fit_billboards(a.shape, a.cloud, {1});
        for (const unsigned threads : {2u, 3u}) {
            fit_billboards(b.shape, b.cloud, {threads});
            for (std::size_t i = 0; i < 50; ++i) {
                CHECK(a.cloud.billboards[i].origin == b.cloud.billboards[i].origin);
                CHECK(a.cloud.billboards[i].axes.u == b.cloud.billboards[i].axes.u);
            }
        }
    }

    TEST_CASE("also-drawn faces count like mapped ones") {
        const auto all = random_scene(7, 1, 30);
        auto split = all;
        for (face_id f = 10; f < 30; ++f) {
            split.cloud.plane_of_face[f] = no_id;
            split.cloud.also_drawn.push_back({0, f});
        }
        auto only = all;
        only.cloud.plane_of_face.assign(30, no_id);
        for (face_id f = 0; f < 30; ++f) only.cloud.also_drawn.push_back({0, f});
        auto mapped = all;
        fit_billboards(mapped.shape, mapped.cloud);
        for (scene* s : {&split, &only}) {
            fit_billboards(s->shape, s->cloud);
            const billboard& a = mapped.cloud.billboards[0];
            const billboard& b = s->cloud.billboards[0];
            CHECK(a.origin == b.origin);
            CHECK(a.axes.normal == b.axes.normal);
            CHECK(a.width == b.width);
            CHECK(a.height == b.height);
            CHECK(a.depth_low == b.depth_low);
            CHECK(a.depth_high == b.depth_high);
        }
    }
}
