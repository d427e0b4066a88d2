#include <billow/pipeline/choose.hpp>

#include <numbers>

#include <doctest/doctest.h>

#include <billow/metrics/geometric_error.hpp>
#include <billow/pipeline.hpp>
#include <billow/shapes/leaf_soup.hpp>

using namespace billow;

TEST_SUITE("pipeline/choose") {
    const bounding_sphere sphere{{1, 2, 3}, 2};
    const lod_screen right_angle{.fov_y = std::numbers::pi / 2, .width_px = 1600, .height_px = 800};

    TEST_CASE("at 90 degrees a screen of 800 shows a length of twice the distance") {
        const auto choice =
            choose_for(sphere, {.distance = 42, .screen = right_angle, .texel_error = 3});
        CHECK(choice.pixel == doctest::Approx(80.0 / 800));
        CHECK(choice.epsilon == doctest::Approx(0.1));
        CHECK(choice.texel_size == doctest::Approx(4.0 / 16));  // not more
        CHECK(choice.wanted_texel_size == doctest::Approx(0.3));
        CHECK(choice.object_px == doctest::Approx(4.0 / 84 * 800));
    }
    TEST_CASE("what is chosen is seen as large as asked for, and sharp from there on") {
        for (const double distance : {5.0, 40.0, 300.0}) {
            for (const double pixels : {0.5, 1.0, 4.0}) {
                const viewing_options seen{.distance = distance,
                                           .pixel_error = pixels,
                                           .texel_error = 2 * pixels,
                                           .least_epsilon = 1e-9,
                                           .most_epsilon = 1e9,
                                           .least_texels = 1e-9,
                                           .most_texels = 1e9};
                const auto choice = choose_for(sphere, seen);
                CHECK(pixels_of_error(choice.epsilon, 2, distance, {}) == doctest::Approx(pixels));
                CHECK(distance_for_pixels(choice.epsilon, 2, pixels, {}) ==
                      doctest::Approx(distance));
                CHECK(distance_for_pixels(choice.texel_size, 2, 2 * pixels, {}) ==
                      doctest::Approx(distance));
                CHECK(choice.error_px == doctest::Approx(pixels));
                CHECK(choice.texel_px == doctest::Approx(2 * pixels));
                CHECK(choice.epsilon == choice.wanted_epsilon);
            }
        }
    }
    TEST_CASE("near by epsilon and texels stay coarse enough to build") {
        for (const double distance : {0.001, 1.0, 2.0, 2.1}) {
            const auto choice = choose_for(sphere, {.distance = distance});
            CHECK(choice.epsilon == doctest::Approx(0.005 * 2));
            CHECK(choice.wanted_epsilon < choice.epsilon);
            CHECK(choice.error_px > 1);
            CHECK(choice.texel_size == doctest::Approx(4.0 / 2048));
            CHECK(choice.texel_px > 1);
        }
    }
    TEST_CASE("far away epsilon and texels stay fine enough to show something") {
        const auto choice = choose_for(sphere, {.distance = 1e6});
        CHECK(choice.epsilon == doctest::Approx(1));
        CHECK(choice.error_px < 1);
        CHECK(choice.texel_size == doctest::Approx(4.0 / 16));
        CHECK(choice.texel_px < 1);
        CHECK(choice.object_px < 1);
    }
    TEST_CASE("finer for taller screens and narrower views, coarser for larger errors") {
        const auto usual = choose_for(sphere, {.distance = 40});
        CHECK(choose_for(sphere, {.distance = 40, .screen = {.height_px = 2160}}).epsilon ==
              doctest::Approx(usual.epsilon / 2));
        CHECK(choose_for(sphere, {.distance = 40, .screen = {.fov_y = 0.5}}).epsilon <
              usual.epsilon);
        CHECK(choose_for(sphere, {.distance = 40, .pixel_error = 2}).epsilon ==
              doctest::Approx(usual.epsilon * 2));
        CHECK(choose_for(sphere, {.distance = 40, .pixel_error = 2}).texel_size ==
              usual.texel_size);
    }
    TEST_CASE("a point has no radius, and no bounds") {
        const auto choice = choose_for({{0, 0, 0}, 0}, {.distance = 10});
        CHECK(choice.epsilon == choice.wanted_epsilon);
        CHECK(choice.epsilon > 0);
        CHECK(choice.texel_size == choice.wanted_texel_size);
        CHECK(choice.object_px == 0);
    }
    TEST_CASE("a cloud is off by no more pixels than asked for, and its texels are no larger") {
        const mesh soup = leaf_soup(300, {.edge = 0.1f});
        build_options options;
        const bounding_sphere bounds = make_face_table(soup)->bounds;
        for (const double distance : {12.0, 30.0}) {
            const viewing_options seen{.distance = distance * bounds.radius, .pixel_error = 3};
            const auto choice = choose_for(bounds, seen);
            apply(choice, options);
            const auto built = build_cloud(soup, options);
            REQUIRE(built);
            CHECK(built->baked.texel_size == doctest::Approx(choice.texel_size));
            const auto errors =
                geometric_error(soup, built->cloud, built->moved, {seen.distance, seen.screen});
            CHECK(errors.max_px <= 3 * (1 + 1e-5));
            CHECK(errors.max_px > 1);
        }
    }
}
