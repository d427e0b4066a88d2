#include <billow/metrics/gap.hpp>

#include <doctest/doctest.h>

#include <billow/metrics/render.hpp>
#include <billow/metrics/view_directions.hpp>
#include <billow/pipeline.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/pictures.hpp"

using namespace billow;

namespace {

constexpr vec4 nothing{0};

}  // namespace

TEST_SUITE("metrics/gap") {
    TEST_CASE("a picture has no gaps beside itself, whatever holes it has") {
        for (const view_picture& p : {support::square_at(5, 5), support::random_picture(13, 7, 1),
                                      support::empty_picture(4, 4), view_picture{}}) {
            CHECK(gap_error(p, p).intensity == 0);
            CHECK(gap_error(p, p).hole_share == 0);
        }
    }
    TEST_CASE("a square has four sides of border") {
        CHECK(border_pixels(support::square_at(5, 5)) == 4 * 20 - 4);
        CHECK(border_pixels(support::empty_picture(8, 8)) == 0);
    }
    TEST_CASE("the edge of the picture is no border") {
        view_picture full = support::empty_picture(8, 8);
        support::fill(full, 0, 0, 8, 8, {0, 0, 0, 1});
        CHECK(border_pixels(full) == 0);
        support::fill(full, 0, 7, 8, 1, nothing);
        CHECK(border_pixels(full) == 8);
    }
    TEST_CASE("a removed face of 5 x 4 pixels is a hole with its border and its area") {
        view_picture holed = support::square_at(5, 5);
        support::fill(holed, 12, 13, 5, 4, nothing);
        const auto e = gap_error(support::square_at(5, 5), holed);
        CHECK(e.intensity == doctest::Approx(2.0 * (5 + 4) / 76));
        CHECK(e.hole_share == doctest::Approx(20.0 / 400));
    }
    TEST_CASE("a shifted silhouette is no gap, a crack through it is") {
        const auto original = support::square_at(5, 5);
        const auto shifted = gap_error(original, support::square_at(7, 4));
        CHECK(shifted.intensity == 0);
        CHECK(shifted.hole_share == 0);
        CHECK(gap_error(original, support::square_at(8, 5)).hole_share ==
              doctest::Approx(16.0 / 400));  // farther than depth_px
        CHECK(gap_error(original, support::square_at(8, 5), {.depth_px = 3}).hole_share == 0);
        view_picture cracked = original;
        support::fill(cracked, 14, 5, 1, 20, nothing);
        const auto e = gap_error(original, cracked);
        CHECK(e.intensity == doctest::Approx(34.0 / 76));  // two rectangles, 9 and 10 wide
        CHECK(e.hole_share == doctest::Approx(16.0 / 400));
    }
    TEST_CASE("a half-transparent crack counts half for the area, and not for the border") {
        view_picture cracked = support::square_at(5, 5);
        support::fill(cracked, 14, 5, 1, 20, {0, 0, 0, 0.5f});
        const auto e = gap_error(support::square_at(5, 5), cracked);
        CHECK(e.intensity == 0);
        CHECK(e.hole_share == doctest::Approx(8.0 / 400));
    }
    TEST_CASE("lost thin structures make the intensity negative") {
        view_picture original = support::square_at(5, 5);
        support::fill(original, 0, 28, 32, 1, {0, 0, 0, 1});
        const double intensity = gap_intensity(original, support::square_at(5, 5));
        CHECK(intensity == doctest::Approx(-32.0 / (76 + 32)));
    }
    TEST_CASE("borders and holes are those of a search through each pixel's neighbours") {
        for (std::uint64_t seed = 1; seed < 6; ++seed) {
            const auto a = support::random_picture(23, 17, seed);
            const auto b = support::random_picture(23, 17, seed + 100);
            const auto borders = [](const view_picture& p) {
                std::size_t count = 0;
                for (int i = 0; i < 23 * 17; ++i) {
                    bool is_border = false;
                    for (int j = 0; j < 23 * 17; ++j) {
                        const int far = std::abs(i % 23 - j % 23) + std::abs(i / 23 - j / 23);
                        const bool differs =
                            p.at(i % 23, i / 23).a >= 0.5f && p.at(j % 23, j / 23).a < 0.5f;
                        is_border = is_border || (far == 1 && differs);
                    }
                    count += is_border ? 1u : 0u;
                }
                return count;
            };
            CHECK(border_pixels(a) == borders(a));
            double holes = 0;
            double all = 0;
            for (int i = 0; i < 23 * 17; ++i) {
                float least = 1;
                for (int j = 0; j < 23 * 17; ++j) {
                    const int far = std::max(std::abs(i % 23 - j % 23), std::abs(i / 23 - j / 23));
                    if (far <= 1) least = std::min(least, a.at(j % 23, j / 23).a);
                }
                holes += std::max(0.0f, least - b.at(i % 23, i / 23).a);
                all += a.at(i % 23, i / 23).a;
            }
            CHECK(hole_share(a, b, {.depth_px = 1}) == doctest::Approx(holes / all));
        }
    }
    TEST_CASE("welding closes gaps of a teapot, as the thesis's table 5.3 has it") {
        const mesh pot = teapot(4);
        const render_scene original(pot);
        const auto intensity_of = [&](weld_kind kind) {
            build_options options{.epsilon = tolerance::of_radius(0.06), .weld = {.kind = kind}};
            options.bake.texels = 128;
            const auto built = build_cloud(pot, options);
            REQUIRE(built);
            const mesh drawn = built->to_mesh();
            const render_scene cloud(drawn);
            double sum = 0;
            for (const dvec3& direction : spread_directions(6)) {
                const camera from = orbit_camera(original.bounds, direction, 4, 128);
                sum += gap_intensity(render_view(original, from), render_view(cloud, from));
            }
            return sum / 6;
        };
        const double torn = intensity_of(weld_kind::none);
        CHECK(torn > 0.2);
        CHECK(intensity_of(weld_kind::intersection) < 0.6 * torn);
    }
}
