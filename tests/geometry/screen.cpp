#include <billow/geometry/screen.hpp>

#include <numbers>

#include <doctest/doctest.h>

using namespace billow;

TEST_SUITE("geometry/screen") {
    TEST_CASE("a length as high as the view has the height of the screen") {
        for (const double fov : {0.3, 1.0, 2.5}) {
            const lod_screen screen{.fov_y = fov, .height_px = 720};
            for (const double distance : {1.0, 7.0}) {
                const double high = 2 * distance * std::tan(fov / 2);
                CHECK(high / distance * screen.pixels_at_one() == doctest::Approx(720));
            }
        }
    }
    TEST_CASE("an error counts at the surface that is nearest, at most at the near distance") {
        const lod_screen screen{
            .fov_y = std::numbers::pi / 2, .width_px = 1600, .height_px = 800, .near = 0.5};
        CHECK(pixels_of_error(1, 5, 15, screen) == doctest::Approx(40));
        CHECK(pixels_of_error(1, 0, 10, screen) == doctest::Approx(40));
        CHECK(pixels_of_error(1, 5, 5, screen) == doctest::Approx(800));
        CHECK(pixels_of_error(1, 5, 1, screen) == pixels_of_error(1, 5, 5, screen));
    }
    TEST_CASE("error, distance and pixels give each other") {
        const lod_screen screen{.fov_y = 0.8, .height_px = 900};
        for (const double distance : {3.5, 10.0, 400.0}) {
            for (const double pixels : {0.3, 1.0, 7.0}) {
                const double error = error_for_pixels(pixels, 3, distance, screen);
                CHECK(pixels_of_error(error, 3, distance, screen) == doctest::Approx(pixels));
                CHECK(distance_for_pixels(error, 3, pixels, screen) == doctest::Approx(distance));
            }
        }
        CHECK(error_for_pixels(1, 3, 2, screen) == error_for_pixels(1, 3, 3, screen));
    }
}
