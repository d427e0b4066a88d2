#include <billow/policy/orientation_bias.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <billow/cloud/measure.hpp>
#include <billow/plants/species.hpp>
#include <billow/search/greedy.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// A normal whose angle to the ground is `elevation_deg`.
dvec3 at_elevation(double elevation_deg, double turn = 0.7) {
    const double a = elevation_deg * std::numbers::pi / 180;
    return {std::cos(a) * std::cos(turn), std::sin(a), std::cos(a) * std::sin(turn)};
}

template <orientation_bias Bias>
billboard_cloud search(const mesh& m, const Bias& bias) {
    face_table faces = support::table_of(m);
    const density_policies policies{hull_of_samples{}, projected_area{}, inner_side_penalty{},
                                    no_falloff{}, bias};
    const double epsilon = 0.1 * faces.bounds.radius;
    return greedy_search(std::move(faces), m.face_count(), {.epsilon = epsilon},
                         pipeline{cube_map{10}, policies})
        .cloud;
}

}  // namespace

TEST_SUITE("policy/orientation_bias") {
    TEST_CASE("the horizontal penalty falls from 1 at the cutoff to 1 - share at the pole") {
        const horizontal_penalty h;
        CHECK(h(at_elevation(0)) == 1);
        CHECK(h(at_elevation(49.9)) == 1);
        CHECK(h(at_elevation(70)) == doctest::Approx(1 - 0.60 * 20 / 40));
        CHECK(h(at_elevation(90)) == doctest::Approx(0.4));
        CHECK(h({0, -1, 0}) == doctest::Approx(0.4));
    }
    TEST_CASE("the vertical penalty is its mirror") {
        const horizontal_penalty h{0.7, 30};
        const vertical_penalty v{0.7, 30};
        for (double angle = 0; angle <= 90; angle += 7.5) {
            CHECK(v(at_elevation(angle)) == doctest::Approx(h(at_elevation(90 - angle))));
        }
        CHECK(v(at_elevation(90)) == 1);
        CHECK(v(at_elevation(0)) == doctest::Approx(0.3));
    }
    TEST_CASE("weights lie in (0, 1], are the same for n and -n, and follow the up axis") {
        random_stream random(3);
        for (int i = 0; i < 500; ++i) {
            const dvec3 n = support::random_direction(random);
            const dvec3 up = support::random_direction(random);
            for (const double share : {0.0, 0.5, 1.0}) {
                const double h = horizontal_penalty{share, 50, up}(n);
                const double v = vertical_penalty{share, 50, up}(n);
                CHECK(h > 0);
                CHECK(v > 0);
                CHECK(h <= 1);
                CHECK(v <= 1);
                CHECK(h == horizontal_penalty{share, 50, up}(-n));
                CHECK(v == vertical_penalty{share, 50, -up}(n));
            }
        }
        CHECK(horizontal_penalty{.up = {0, 0, 1}}({0, 0, 1}) == doctest::Approx(0.4));
        CHECK(horizontal_penalty{.up = {0, 0, 1}}({0, 1, 0}) == 1);
    }
    TEST_CASE("biases compose as a product, and a share of 0 is no bias") {
        random_stream random(4);
        for (int i = 0; i < 100; ++i) {
            const dvec3 n = support::random_direction(random);
            const horizontal_penalty h{0.5, 20};
            const vertical_penalty v{0.3, 40};
            CHECK(combined_bias(h, v)(n) == doctest::Approx(h(n) * v(n)));
            CHECK(combined_bias(h, v, h)(n) == doctest::Approx(h(n) * v(n) * h(n)));
            CHECK(viewpoint_bias{0.5, 0.3, 20}(n) ==
                  doctest::Approx(h(n) * vertical_penalty{0.3, 20}(n)));
            CHECK(viewpoint_bias{}(n) == 1);
            CHECK(combined_bias<>{}(n) == no_bias{}(n));
        }
    }
    TEST_CASE("a negative density is never rewarded") {
        CHECK(biased(10, 0.5) == 5);
        CHECK(biased(-10, 0.5) == -20);
        CHECK(biased(0, 0.5) == 0);
        for (const double density : {-3.0, 0.0, 3.0}) {
            CHECK(biased(density, 1) == density);
            CHECK(biased(density, 0.2) <= density);
        }
    }
    TEST_CASE("a bias of 1 changes nothing") {
        const mesh m = leaf_soup(800, {.edge = 0.1f});
        const billboard_cloud plain = search(m, no_bias{});
        const auto is_plain = [&](const billboard_cloud& cloud) {
            return cloud.planes == plain.planes && cloud.plane_of_face == plain.plane_of_face;
        };
        CHECK(is_plain(search(m, viewpoint_bias{})));
        CHECK(is_plain(search(m, horizontal_penalty{.share = 0})));
        CHECK(!is_plain(search(m, horizontal_penalty{})));
    }
    TEST_CASE(
        "horizontal planes become rare on a tree with their penalty, vertical ones with its "
        "mirror") {
        const mesh tree = *tree_of_about(8000);
        struct counts {
            std::ptrdiff_t horizontal, vertical;
        };
        const auto count = [&](const viewpoint_bias& bias) -> counts {
            const billboard_cloud cloud = search(tree, bias);
            CHECK(measure_errors(tree, cloud).faces_beyond_epsilon == 0);
            CHECK(measure_errors(tree, cloud).mapped_faces == tree.face_count());
            const auto rising = [&](double from, double to) {
                return std::ranges::count_if(cloud.planes, [&](const plane& p) {
                    const double rise = std::abs(p.normal.y);
                    return rise >= from && rise < to;
                });
            };
            const double forty = 40 * std::numbers::pi / 180;
            return {rising(std::cos(forty), 1.1), rising(0, std::sin(forty))};
        };
        const counts plain = count({});
        const counts seen_from_ground = count({.horizontal_share = 0.6, .cutoff_deg = 30});
        const counts seen_from_above = count({.vertical_share = 0.95, .cutoff_deg = 30});
        CHECK(plain.horizontal >= 3);
        CHECK(2 * seen_from_ground.horizontal <= plain.horizontal);
        CHECK(seen_from_ground.vertical > plain.vertical);
        CHECK(2 * seen_from_above.vertical <= plain.vertical);
        CHECK(seen_from_above.horizontal > plain.horizontal);
    }
}
