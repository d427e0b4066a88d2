#include <billow/metrics/color_error.hpp>

#include <doctest/doctest.h>

#include "support/pictures.hpp"

using namespace billow;

namespace {

constexpr vec3 red{0.6f, 0.1f, 0.05f};
constexpr vec3 blue{0.1f, 0.15f, 0.6f};

double between(const vec3& a, const vec3& b) {
    return delta_e76(lab_from_linear(a), lab_from_linear(b));
}

/// A square of 16 x 16 in stripes of two pixels, which begin with one or the other colour.
view_picture striped(const vec3& first, const vec3& second) {
    view_picture picture = support::empty_picture(32, 32);
    for (int y = 8; y < 24; ++y) {
        for (int x = 8; x < 24; ++x) picture.at(x, y) = vec4(x / 2 % 2 == 0 ? first : second, 1);
    }
    return picture;
}

}  // namespace

TEST_SUITE("metrics/color_error") {
    TEST_CASE("a picture has the colours of itself") {
        for (const view_picture& p : {support::square_at(5, 5), support::random_picture(13, 7, 1),
                                      support::empty_picture(4, 4), view_picture{}}) {
            const color_errors e = color_error(p, p);
            CHECK(e.mean == 0);
            CHECK(e.common == 0);
            CHECK(e.local == 0);
        }
    }
    TEST_CASE("another colour throughout is as far by every measure") {
        const auto e = color_error(support::square_at(5, 5, vec4(red, 1)),
                                   support::square_at(5, 5, vec4(blue, 1)));
        CHECK(e.mean == doctest::Approx(between(red, blue)).epsilon(1e-4));
        CHECK(e.common == doctest::Approx(between(red, blue)).epsilon(1e-4));
        CHECK(e.local == doctest::Approx(between(red, blue)).epsilon(1e-4));
    }
    TEST_CASE("neither a shift nor half the coverage changes a colour") {
        const auto original = support::square_at(5, 5, vec4(red, 1));
        for (const auto& other : {support::square_at(8, 6, vec4(red, 1)),
                                  support::square_at(5, 5, vec4(red * 0.5f, 0.5f))}) {
            const auto e = color_error(original, other);
            CHECK(e.mean < 1e-3);
            CHECK(e.common < 1e-3);
            CHECK(e.local < 1e-3);
        }
    }
    TEST_CASE("displaced detail is not punished, displaced colour only by the local error") {
        const auto fine = color_error(striped(red, blue), striped(blue, red), {.sigma_px = 4});
        CHECK(fine.mean < 1e-3);
        CHECK(fine.common < 1e-3);
        CHECK(fine.local < 0.15 * between(red, blue));

        view_picture left = support::square_at(5, 5, vec4(red, 1));
        view_picture right = support::square_at(5, 5, vec4(blue, 1));
        support::fill(left, 15, 5, 10, 20, vec4(blue, 1));
        support::fill(right, 15, 5, 10, 20, vec4(red, 1));
        const auto coarse = color_error(left, right, {.sigma_px = 2});
        CHECK(coarse.mean < 1e-3);
        CHECK(coarse.common < 1e-3);
        CHECK(coarse.local > 0.5 * between(red, blue));
    }
    TEST_CASE("a narrower blur punishes displaced detail more") {
        double before = 0;
        for (const double sigma : {8.0, 4.0, 2.0, 1.0, 0.3}) {
            const auto e = color_error(striped(red, blue), striped(blue, red), {.sigma_px = sigma});
            CHECK(e.local > before);
            before = e.local;
        }
        CHECK(before == doctest::Approx(between(red, blue)).epsilon(0.02));
    }
    TEST_CASE("what one picture alone covers counts for the mean, not for what both cover") {
        const auto original = support::square_at(5, 5, vec4(red, 1));
        view_picture more = original;
        support::fill(more, 5, 25, 20, 5, vec4(blue, 1));
        const auto e = color_error(original, more);
        CHECK(e.common == 0);
        CHECK(e.mean == doctest::Approx(between(red, red * 0.8f + blue * 0.2f)).epsilon(1e-4));
    }
    TEST_CASE("without a cloud there is no colour to compare") {
        const auto e = color_error(support::square_at(5, 5), support::empty_picture(32, 32));
        CHECK(e.mean == 0);
        CHECK(e.common == 0);
        CHECK(e.local == 0);
    }
    TEST_CASE("means and blurs are those of the formulas in doubles") {
        const auto a = support::random_picture(21, 14, 1);
        const auto b = support::random_picture(21, 14, 2);
        const double sigma = 1.5;  // squares of one pixel
        const auto color = [&](const view_picture& p, int x, int y) {
            double sum[4] = {0, 0, 0, 0};
            double weights = 0;
            for (int j = -5; j <= 5; ++j) {
                for (int i = -5; i <= 5; ++i) {
                    const double w = std::exp(-(i * i + j * j) / (2 * sigma * sigma));
                    const vec4& q = p.at(std::clamp(x + i, 0, 20), std::clamp(y + j, 0, 13));
                    for (int c = 0; c < 4; ++c) sum[c] += w * q[c];
                    weights += w;
                }
            }
            for (double& s : sum) s /= weights;
            return std::pair(vec3(dvec3(sum[0], sum[1], sum[2]) / sum[3]), sum[3]);
        };
        double local = 0;
        double weights = 0;
        dvec3 common[2] = {dvec3(0), dvec3(0)};
        double common_weights = 0;
        for (int y = 0; y < 14; ++y) {
            for (int x = 0; x < 21; ++x) {
                const auto [p, p_cover] = color(a, x, y);
                const auto [q, q_cover] = color(b, x, y);
                local += std::min(p_cover, q_cover) * between(p, q);
                weights += std::min(p_cover, q_cover);
                const vec4& u = a.at(x, y);
                const vec4& v = b.at(x, y);
                const double w = std::min(u.a, v.a);
                if (w > 0) {
                    common[0] += w / u.a * dvec3(u);
                    common[1] += w / v.a * dvec3(v);
                    common_weights += w;
                }
            }
        }
        const auto e = color_error(a, b, {.sigma_px = sigma});
        CHECK(e.local == doctest::Approx(local / weights).epsilon(1e-4));
        CHECK(e.common == doctest::Approx(between(vec3(common[0] / common_weights),
                                                  vec3(common[1] / common_weights))));
    }
    TEST_CASE("squares that the blur reads hardly change it") {
        const auto a = support::random_picture(70, 61, 5);
        const auto b = support::random_picture(70, 61, 6);
        const double squares = color_error(a, b, {.sigma_px = 6}).local;      // of 3 pixels
        const double nearly = color_error(a, b, {.sigma_px = 5.9999}).local;  // of 2
        CHECK(squares == doctest::Approx(nearly).epsilon(0.05));
    }
}
