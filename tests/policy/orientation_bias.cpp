#include <billow/policy/orientation_bias.hpp>

#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// A normal whose angle to the ground is `elevation_deg`.
dvec3 at_elevation(double elevation_deg, double turn = 0.7) {
    const double a = elevation_deg * std::numbers::pi / 180;
    return {std::cos(a) * std::cos(turn), std::sin(a), std::cos(a) * std::sin(turn)};
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
}
