#include <billow/metrics/compare.hpp>

#include <set>

#include <doctest/doctest.h>

#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

namespace {

using namespace billow;

const compare_options small{.views = 6, .size_px = 48, .supersample = 2};

/// The mesh as a cloud of one plane a face.
mesh as_cloud(const mesh& m) {
    std::vector<vec3> corners;
    for (face_id face = 0; face < m.face_count(); ++face) {
        for (const vec3& p : m.corners(face)) corners.push_back(p);
    }
    mesh cloud = support::triangles(corners);
    for (std::uint32_t i = 0; i < corners.size(); ++i) cloud.feature_ids.push_back(i / 3);
    return cloud;
}

}  // namespace

TEST_SUITE("metrics/compare") {
    TEST_CASE("a mesh differs from itself by nothing, and so does a cloud") {
        const mesh leaves = leaf_soup(200, {.edge = 0.2f});
        const comparison same = compare(leaves, leaves, small);
        CHECK(same.clouds[0].errors == errors_over_views{});
        CHECK(same.clouds[0].view_overdraw == same.original_view_overdraw);
        CHECK(same.clouds[0].cost.triangles == same.original.triangles);
        CHECK(!same.clouds[0].geometric);
        const mesh cloud = as_cloud(leaves);
        const comparison clouds = compare(cloud, cloud, small);
        CHECK(clouds.clouds[0].errors == errors_over_views{});
        REQUIRE(clouds.clouds[0].geometric);
        CHECK(clouds.clouds[0].geometric->max < 1e-6);
        CHECK(clouds.clouds[0].geometric->undrawn == 0);
    }

    TEST_CASE(
        "all sides of a box move as far as their planes, and the pixels follow the distance") {
        const mesh original = box({1, 1, 1});
        mesh cloud = as_cloud(original);
        for (vec3& p : cloud.positions) p *= 1.1f;
        const comparison near = compare(original, cloud, small);
        REQUIRE(near.clouds[0].geometric);
        const geometric_errors& moved = *near.clouds[0].geometric;
        const double side = std::abs(static_cast<double>(original.positions[0].x));
        CHECK(moved.max == doctest::Approx(0.1 * side));
        CHECK(moved.mean == doctest::Approx(0.1 * side));
        CHECK(moved.max_of_radius == doctest::Approx(moved.max / near.bounds.radius));
        CHECK(near.clouds[0].errors.extra.mean > 0.1);
        CHECK(near.clouds[0].errors.missing.worst < 0.01);
        compare_options far = small;
        far.distance = 40;
        const comparison seen = compare(original, cloud, far);
        CHECK(seen.clouds[0].geometric->mean_px == doctest::Approx(moved.mean_px / 10));
        CHECK(seen.clouds[0].errors.flip != near.clouds[0].errors.flip);
        CHECK(seen.pixels_per_degree == doctest::Approx(10 * near.pixels_per_degree).epsilon(0.1));
    }

    TEST_CASE("a picture as large as on the screen has the screen's pixels a degree") {
        const mesh original = box({1, 1, 1});
        compare_options options = small;
        options.distance = 8;
        const double diameter_px = 2 * options.screen.pixels_at_one() / 8;
        options.size_px = static_cast<int>(diameter_px * 1.02);
        const comparison seen = compare(original, original, options);
        CHECK(seen.pixels_per_degree == doctest::Approx(usual_pixels_per_degree).epsilon(0.02));
        options.size_px = 1;
        CHECK(compare(original, original, options).pixels_per_degree >= 1);
    }

    TEST_CASE("backs of a cloud's single-sided polygons are not seen, an original's are") {
        mesh card;
        support::add_square(card, {0, 0, 0}, {1, 0, -0.5f}, {0, 1, 0});
        mesh cloud = card;
        cloud.feature_ids.assign(4, 0);
        const comparison one_sided = compare(card, cloud, small);
        for (std::size_t i = 0; i < one_sided.cameras.size(); ++i) {
            const bool is_front = glm::dot(one_sided.cameras[i].axes.normal, dvec3(1, 0, 2)) > 0;
            CHECK(one_sided.clouds[0].views[i].missing == (is_front ? 0 : 1));
        }
        cloud.materials.resize(1);
        cloud.materials[0].metallic = 0;
        cloud.materials[0].is_double_sided = true;
        CHECK(compare(card, cloud, small).clouds[0].errors.missing.worst == 0);
    }

    TEST_CASE("clouds beside each other read as they do alone, for any number of threads") {
        const mesh leaves = leaf_soup(300, {.edge = 0.2f});
        mesh half = as_cloud(leaves);
        half.triangles.resize(150);
        const mesh cube = box({1, 1, 1});
        const std::array<const mesh*, 2> clouds{&half, &cube};
        double last = -1;
        int reports = 0;
        const comparison both = compare(leaves, clouds, small, {1}, [&](auto, double share) {
            CHECK(share >= last);
            last = share;
            ++reports;
        });
        CHECK(last == 1);
        CHECK(reports == 8);
        CHECK(both.clouds[0].errors.missing.mean > 0.2);
        CHECK(both.clouds[0].geometric->undrawn <= 150);
        CHECK(!both.clouds[1].geometric);
        for (std::size_t i = 0; i < 2; ++i) {
            for (const unsigned threads : {2u, 3u, 8u}) {
                const comparison alone = compare(leaves, *clouds[i], small, {threads});
                CHECK(alone.clouds[0].views == both.clouds[i].views);
                CHECK(alone.clouds[0].view_overdraw == both.clouds[i].view_overdraw);
                CHECK(alone.clouds[0].planes.planes.plane_of_face ==
                      both.clouds[i].planes.planes.plane_of_face);
            }
        }
    }

    TEST_CASE("nothing can be compared") {
        const mesh nothing;
        const mesh cube = box({1, 1, 1});
        CHECK(compare(nothing, nothing, small).clouds[0].errors == errors_over_views{});
        CHECK(compare(cube, nothing, small).clouds[0].errors.missing.mean == 1);
        CHECK(compare(nothing, cube, small).clouds[0].errors.extra.mean == 1);
        CHECK(compare(cube, std::span<const mesh* const>(), small).clouds.empty());
    }

    TEST_CASE("telling views hold the worst and the best, each once and no more than asked for") {
        comparison of;
        of.cameras.resize(12);
        of.clouds.resize(2);
        for (std::size_t c = 0; c < 2; ++c) {
            of.clouds[c].views.resize(12);
            for (std::size_t i = 0; i < 12; ++i) {
                of.clouds[c].views[i].coverage = static_cast<double>((5 * i + 3 * c) % 12);
                of.clouds[c].views[i].object_flip = static_cast<double>((7 * i + c) % 12);
            }
            of.clouds[c].errors = over_views(of.clouds[c].views);
        }
        for (const std::size_t count : {0u, 1u, 4u, 8u, 12u, 40u}) {
            const auto chosen = telling_views(of, count);
            CHECK(chosen.size() == std::min<std::size_t>(count, 12));
            CHECK(std::set<std::size_t>(chosen.begin(), chosen.end()).size() == chosen.size());
            CHECK(std::is_sorted(chosen.begin(), chosen.end()));
        }
        const auto chosen = telling_views(of, 8);
        for (const cloud_comparison& cloud : of.clouds) {
            for (const std::size_t view :
                 {cloud.errors.coverage.worst_view, cloud.errors.object_flip.worst_view}) {
                CHECK(std::count(chosen.begin(), chosen.end(), view) == 1);
            }
        }
        CHECK(std::count(chosen.begin(), chosen.end(), 0u) == 1);  // the best of the first
        of.clouds.clear();
        CHECK(telling_views(of, 5).size() == 5);
    }
}
