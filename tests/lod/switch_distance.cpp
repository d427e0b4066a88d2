#include <billow/lod/switch_distance.hpp>

#include <array>
#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("lod/switch_distance") {
    const lod_screen right_angle{.fov_y = std::numbers::pi / 2, .width_px = 1600, .height_px = 800};

    TEST_CASE("at 90 degrees a length as far away as half the screen is high covers half of it") {
        CHECK(pixels_of_error(10, 5, 15, right_angle) == doctest::Approx(400));
        CHECK(pixels_of_error(1, 5, 15, right_angle) == doctest::Approx(40));
    }
    TEST_CASE("the near distance bounds the pixels within the sphere") {
        const double at_surface = pixels_of_error(0.1, 5, 5, right_angle);
        CHECK(std::isfinite(at_surface));
        CHECK(pixels_of_error(0.1, 5, 1, right_angle) == at_surface);
        CHECK(at_surface == doctest::Approx(0.1 / right_angle.near * 400));
    }
    TEST_CASE("the distance is the inverse of the pixels") {
        for (const double error : {0.01, 0.3, 2.0}) {
            for (const double pixels : {0.5, 1.0, 8.0}) {
                const double distance = distance_for_pixels(error, 3, pixels, {});
                CHECK(pixels_of_error(error, 3, distance, {}) == doctest::Approx(pixels));
                CHECK(pixels_of_error(error, 3, distance * 1.01, {}) < pixels);
            }
        }
    }
    TEST_CASE("an error that is small even at the near distance asks for no distance") {
        CHECK(distance_for_pixels(0, 3, 1, {}) == 0);
        const double least = 0.01 / lod_screen{}.pixels_at_one();
        CHECK(distance_for_pixels(least * 0.99, 3, 1, {}) == 0);
        CHECK(distance_for_pixels(least * 1.01, 3, 1, {}) > 3);
    }
    TEST_CASE("distances grow with the error and the screen, and shrink with pixels and angle") {
        const lod_screen usual;
        lod_screen tall = usual;
        tall.height_px *= 2;
        lod_screen wide = usual;
        wide.fov_y *= 1.2;
        const double distance = distance_for_pixels(0.1, 2, 1, usual);
        CHECK(distance_for_pixels(0.2, 2, 1, usual) > distance);
        CHECK(distance_for_pixels(0.1, 2, 1, tall) > distance);
        CHECK(distance_for_pixels(0.1, 2, 2, usual) < distance);
        CHECK(distance_for_pixels(0.1, 2, 1, wide) < distance);
    }
    TEST_CASE("a coarser level with a smaller error does not come before a finer one") {
        const std::array errors{0.1, 0.3, 0.2, 0.4};
        const auto distances = switch_distances(errors, 2, 1, {});
        REQUIRE(distances.size() == 4);
        CHECK(distances[0] == distance_for_pixels(0.1, 2, 1, {}));
        CHECK(distances[2] == distances[1]);
        CHECK(distances[3] > distances[2]);
    }
    TEST_CASE("an object as high as the view fills the screen") {
        CHECK(relative_screen_height(20, 10, right_angle) == doctest::Approx(1));
        CHECK(relative_screen_height(5, 10, right_angle) == doctest::Approx(0.25));
        CHECK(std::isinf(relative_screen_height(5, 0, right_angle)));
        const double distance = distance_for_screen_height(5, 0.1, right_angle);
        CHECK(relative_screen_height(5, distance, right_angle) == doctest::Approx(0.1));
    }
    TEST_CASE("coverage is a share of the screen's area") {
        // A disc of half the height on a screen twice as wide as high.
        CHECK(screen_coverage(5, 10, right_angle) ==
              doctest::Approx(std::numbers::pi * 0.25 * 0.25 / 2));
        CHECK(screen_coverage(5, 1, right_angle) == 1);
        CHECK(screen_coverage(5, 0, right_angle) == 1);
    }
}
