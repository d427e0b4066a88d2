#include <billow/pipeline.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <billow/fit/svd.hpp>
#include <billow/metrics/picture.hpp>
#include <billow/plane_space/spherical.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

build_options small_atlas(double epsilon) {
    build_options options;
    options.epsilon = tolerance::of_radius(epsilon);
    options.bake.texels = 96;
    return options;
}

/// Share of the pixels whose bytes differ by more than `threshold`.
double different_pixels(const image& a, const image& b, int threshold) {
    std::size_t count = 0;
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            int most = 0;
            for (int c = 0; c < 3; ++c) {
                most = std::max(most, std::abs(a.pixel(x, y)[c] - b.pixel(x, y)[c]));
            }
            count += most > threshold ? 1u : 0u;
        }
    }
    return static_cast<double>(count) / (a.width * a.height);
}

}  // namespace

TEST_SUITE("pipeline") {
    TEST_CASE(
        "the cloud of a textured cube has six planes and looks like the cube from all sides") {
        const mesh cube = textured_cube();
        const auto built = build_cloud(cube, small_atlas(0.02));
        REQUIRE(built);
        CHECK(built->cloud.plane_count() == 6);
        CHECK(built->errors.projected_area_share == doctest::Approx(1).epsilon(1e-4));
        const mesh cloud = built->to_mesh();
        CHECK(cloud.face_count() == 12);
        for (const dvec3& from : {dvec3(1, 0.7, 1.3), dvec3(-1, -0.6, 0.8), dvec3(0.3, 1, -0.9)}) {
            const camera view = view_of(built->cloud.bounds, from, 128, 128);
            const double different =
                different_pixels(draw_picture(cube, view), draw_picture(cloud, view), 24);
            CHECK(different < 0.05);
        }
    }
    TEST_CASE("quads are as large as their planes' faces, and lie on their planes") {
        const auto built = build_cloud(leaf_soup(1000, {.edge = 0.15f}), small_atlas(0.1));
        REQUIRE(built);
        const mesh cloud = built->to_mesh();
        std::set<std::uint32_t> planes(cloud.feature_ids.begin(), cloud.feature_ids.end());
        CHECK(planes.size() == built->cloud.plane_count());
        for (std::size_t v = 0; v < cloud.vertex_count(); ++v) {
            const plane& p = built->cloud.planes[cloud.feature_ids[v]];
            const dvec3 at = dvec3(cloud.positions[v]) - built->cloud.bounds.centre;
            CHECK(std::abs(signed_distance(p, at)) < 1e-5);
            CHECK(std::abs(glm::dot(dvec3(cloud.normals[v]), p.normal)) ==
                  doctest::Approx(1).epsilon(1e-5));
        }
    }
    TEST_CASE("any number of threads gives the same cloud and the same texels") {
        const mesh m = leaf_soup(3000, {.edge = 0.1f});
        build_options options = small_atlas(0.1);
        options.threads.threads = 1;
        const auto one = build_cloud(m, options);
        REQUIRE(one);
        for (const unsigned threads : {2u, 3u, 8u}) {
            options.threads.threads = threads;
            const auto many = build_cloud(m, options);
            REQUIRE(many);
            CHECK(many->cloud.planes == one->cloud.planes);
            REQUIRE(many->baked.atlases.size() == one->baked.atlases.size());
            for (std::size_t i = 0; i < one->baked.atlases.size(); ++i) {
                CHECK(many->baked.atlases[i].base_color == one->baked.atlases[i].base_color);
                CHECK(many->baked.atlases[i].normal == one->baked.atlases[i].normal);
            }
        }
    }
    TEST_CASE("other parts compose") {
        const mesh m = leaf_soup(500, {.edge = 0.2f});
        const auto built = build_cloud(
            m, small_atlas(0.1),
            pipeline{spherical(10),
                     density_policies{intersection_of_vertices{}, projected_area{}, no_penalty{}},
                     svd_fit{}});
        REQUIRE(built);
        CHECK(built->errors.max_error <= built->cloud.epsilon * (1 + 1e-9));
    }
    TEST_CASE("an epsilon in scene units is taken as it is") {
        build_options options = small_atlas(0.1);
        options.epsilon = tolerance::scene_units(0.125);
        const auto built = build_cloud(leaf_soup(200), options);
        REQUIRE(built);
        CHECK(built->cloud.epsilon == 0.125);
    }
    TEST_CASE("about as many planes as asked for, and the epsilon that they keep") {
        const mesh m = leaf_soup(400, {.edge = 0.2f});
        for (const std::size_t planes : {12u, 30u}) {
            build_options options = small_atlas(0.1);
            options.planes = planes;
            const auto built = build_cloud(m, options);
            REQUIRE(built);
            const auto found = static_cast<double>(built->cloud.plane_count());
            CHECK(std::abs(found - static_cast<double>(planes)) <= 2);
            CHECK(built->parts[0].epsilon == built->cloud.epsilon);
            CHECK(built->errors.max_error <= built->cloud.epsilon * (1 + 1e-9));
        }
    }
    TEST_CASE("a mesh without area gives a cloud without planes") {
        for (const mesh& m : {mesh{}, support::triangles({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}})}) {
            const auto built = build_cloud(m);
            REQUIRE(built);
            CHECK(built->cloud.plane_count() == 0);
            CHECK(built->to_mesh().face_count() == 0);
            CHECK(built->statistics.degenerate_faces == m.face_count());
        }
    }
    TEST_CASE("what makes no sense is refused by name") {
        for (const double epsilon :
             {0.0, -0.1, double(std::nanf("")), std::numeric_limits<double>::infinity()}) {
            const auto built = build_cloud(leaf_soup(10), small_atlas(epsilon));
            REQUIRE_FALSE(built);
            CHECK(built.error().code == error_code::invalid_options);
        }
        mesh broken = leaf_soup(10);
        broken.positions[0].x = std::nanf("");
        const auto built = build_cloud(broken);
        REQUIRE_FALSE(built);
        CHECK(built.error().code == error_code::not_finite);
    }
}
