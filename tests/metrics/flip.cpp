#include <billow/metrics/flip.hpp>

#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include "support/pictures.hpp"

using namespace billow;

namespace {

/// The paper's formulas in doubles, each filter as one sum over a square: slow and plain.
class plain_flip {
public:
    plain_flip(const view_picture& picture, double pixels_per_degree, const vec3& background)
        : picture_(picture), ppd_(pixels_per_degree), background_(background) {}

    struct seen {
        double l = 0, a = 0, b = 0, edge = 0, point = 0;
    };

    [[nodiscard]] seen at(int x, int y) const {
        constexpr double pi = std::numbers::pi;
        const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd_));
        const auto contrast = [&](double a1, double b1, double a2, double b2, int channel) {
            return filtered(x, y, radius, channel, [=, this](int i, int j) {
                const double d = std::hypot(i, j) / ppd_;
                return a1 * std::sqrt(pi / b1) * std::exp(-pi * pi * d * d / b1) +
                       a2 * std::sqrt(pi / b2) * std::exp(-pi * pi * d * d / b2);
            });
        };
        const double luminance = contrast(1, 0.0047, 0, 1e-5, 0);
        const double red_green = contrast(1, 0.0053, 0, 1e-5, 1);
        const double blue_yellow = contrast(34.1, 0.04, 13.5, 0.025, 2);
        const double ry = (luminance + 16) / 116;
        const double rx = red_green / 500 + ry;
        const double rz = ry - blue_yellow / 200;
        const auto light = linear_of_relative_xyz(color_lanes<float>{
            static_cast<float>(rx), static_cast<float>(ry), static_cast<float>(rz)});
        const vec3 lab =
            lab_from_linear(glm::clamp(vec3(light.x, light.y, light.z), vec3(0), vec3(1)));

        const double s = 0.5 * 0.082 * ppd_;
        const int reach = static_cast<int>(std::ceil(3 * s));
        const auto bell = [=](int i, int j) { return std::exp(-(i * i + j * j) / (2 * s * s)); };
        const auto feature = [&](const auto& weight) {
            return filtered(x, y, reach, 0, weight, 16) / 116;
        };
        const double edge_x = feature([=](int i, int j) { return -i * bell(i, j); });
        const double edge_y = feature([=](int i, int j) { return -j * bell(i, j); });
        const double point_x =
            feature([=](int i, int j) { return (i * i / (s * s) - 1) * bell(i, j); });
        const double point_y =
            feature([=](int i, int j) { return (j * j / (s * s) - 1) * bell(i, j); });
        return {lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z, std::hypot(edge_x, edge_y),
                std::hypot(point_x, point_y)};
    }

private:
    /// Y', Cx or Cz of a pixel, the nearest one within the picture.
    [[nodiscard]] double opponent(int x, int y, int channel) const {
        const vec4& p = picture_.at(std::clamp(x, 0, picture_.width - 1),
                                    std::clamp(y, 0, picture_.height - 1));
        const vec3 over = vec3(p) + (1 - p.a) * background_;
        const auto xyz = relative_xyz(color_lanes<float>{over.x, over.y, over.z});
        if (channel == 0) return 116.0 * xyz.y - 16;
        return channel == 1 ? 500.0 * (xyz.x - xyz.y) : 200.0 * (xyz.y - xyz.z);
    }

    /// Positive weights sum to 1, negative ones to -1.
    template <class Weight>
    [[nodiscard]] double filtered(int x, int y, int radius, int channel, const Weight& weight,
                                  double offset = 0) const {
        double positive = 0;
        double negative = 0;
        double with_positive = 0;
        double with_negative = 0;
        for (int j = -radius; j <= radius; ++j) {
            for (int i = -radius; i <= radius; ++i) {
                const double w = weight(i, j);
                const double value = opponent(x + i, y + j, channel) + offset;
                (w > 0 ? positive : negative) += std::abs(w);
                (w > 0 ? with_positive : with_negative) += w * value;
            }
        }
        return with_positive / positive + (negative > 0 ? with_negative / negative : 0);
    }

    const view_picture& picture_;
    double ppd_;
    vec3 background_;
};

double plain_difference(const plain_flip::seen& p, const plain_flip::seen& q) {
    const auto hunt = [](const vec3& linear) {
        const vec3 lab = lab_from_linear(linear);
        return plain_flip::seen{lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z};
    };
    const auto hyab = [](const plain_flip::seen& u, const plain_flip::seen& v) {
        return std::abs(u.l - v.l) + std::hypot(u.a - v.a, u.b - v.b);
    };
    const double most = std::pow(hyab(hunt({0, 1, 0}), hunt({0, 0, 1})), 0.7);
    const double distance = std::pow(hyab(p, q), 0.7);
    const double color = distance < 0.4 * most
                             ? distance * 0.95 / (0.4 * most)
                             : 0.95 + (distance - 0.4 * most) / (0.6 * most) * 0.05;
    const double feature = std::max(std::abs(p.edge - q.edge), std::abs(p.point - q.point));
    return std::pow(color, 1 - std::sqrt(feature / std::numbers::sqrt2));
}

view_picture flat(const vec3& color, int width = 24, int height = 24) {
    view_picture picture = support::empty_picture(width, height);
    support::fill(picture, 0, 0, width, height, vec4(color, 1));
    return picture;
}

/// A picture of 64 x 48 with gradients, fine and coarse edges and a disc; and one that differs from
/// it in brightness, in points and in hue.
view_picture gradients(bool is_changed) {
    view_picture picture = support::empty_picture(64, 48);
    for (int y = 0; y < 48; ++y) {
        for (int x = 0; x < 64; ++x) {
            const bool is_disc = (x - 32) * (x - 32) + (y - 24) * (y - 24) < 64 * 48 / 9;
            vec3 c = is_disc ? vec3(0.1f, 0.5f, 0.2f)
                             : vec3(static_cast<float>(x) / 64, 0.4f, static_cast<float>(y) / 48);
            if ((x / 5 + y / 7) % 2 != 0) c *= 0.5f;
            if (is_changed) {
                if (x > 32) c = glm::min(vec3(1), c * 1.3f);
                if ((x + 3 * y) % 29 == 0) c = vec3(1, 1, 0);
                if (is_disc && y > 24) c = vec3(c.z, c.y, c.x);
            }
            picture.at(x, y) = vec4(c, 1);
        }
    }
    return picture;
}

}  // namespace

TEST_SUITE("metrics/flip") {
    TEST_CASE("no difference is seen between a picture and itself") {
        for (const auto& p :
             {gradients(true), support::random_picture(19, 8, 1), support::empty_picture(1, 1)}) {
            const flip_errors e = flip_error(p, p);
            CHECK(e.mean == 0);
            CHECK(e.over_object == 0);
        }
    }
    TEST_CASE("each pixel is that of the paper's formulas, whatever the pixels a degree") {
        const auto a = support::random_picture(15, 11, 1);
        const auto b = support::random_picture(15, 11, 2);
        for (const double ppd : {1.0, 8.0, 20.0, usual_pixels_per_degree}) {
            const flip_options options{.pixels_per_degree = ppd};
            const channel map = flip_map(a, b, options);
            const plain_flip plain_a(a, ppd, options.background);
            const plain_flip plain_b(b, ppd, options.background);
            for (int y = 0; y < 11; ++y) {
                for (int x = 0; x < 15; ++x) {
                    const double plain = plain_difference(plain_a.at(x, y), plain_b.at(x, y));
                    CHECK(std::abs(map.at(x, y) - plain) < 2e-4);
                }
            }
        }
    }
    TEST_CASE("means are those that the authors' program gives") {
        // Computed once by NVlabs' C++ implementation from the same light.
        const auto a = gradients(false);
        const auto b = gradients(true);
        const auto mean = [&](double ppd) {
            return flip_error(a, b, {.pixels_per_degree = ppd}).mean;
        };
        CHECK(std::abs(mean(usual_pixels_per_degree) - 0.3297904) < 5e-5);
        CHECK(std::abs(mean(20) - 0.3261707) < 5e-5);
        CHECK(std::abs(mean(200) - 0.3407225) < 5e-5);
    }
    TEST_CASE("differences are between 0 and 1 and do not depend on which picture comes first") {
        const auto a = support::random_picture(40, 30, 1);
        const auto b = support::random_picture(40, 30, 2);
        const channel map = flip_map(a, b);
        const channel back = flip_map(b, a);
        for (int y = 0; y < 30; ++y) {
            for (int x = 0; x < 40; ++x) {
                CHECK(map.at(x, y) >= 0);
                CHECK(map.at(x, y) <= 1);
                CHECK(map.at(x, y) == back.at(x, y));
            }
        }
    }
    TEST_CASE("green and blue differ most") {
        CHECK(flip_error(flat({0, 1, 0}), flat({0, 0, 1})).mean ==
              doctest::Approx(1).epsilon(1e-4));
        CHECK(flip_error(flat({0, 0, 0}), flat({1, 1, 1})).mean < 1);
    }
    TEST_CASE("the more a square stands out, the more it differs") {
        double before = 0;
        for (const float step : {0.01f, 0.05f, 0.1f, 0.2f, 0.4f, 0.6f}) {
            view_picture with_square = flat(vec3(0.2f), 40, 40);
            support::fill(with_square, 15, 15, 10, 10, vec4(vec3(0.2f + step), 1));
            const double mean = flip_error(flat(vec3(0.2f), 40, 40), with_square).mean;
            CHECK(mean > before);
            before = mean;
        }
    }
    TEST_CASE("what is too fine to be seen makes no difference") {
        view_picture chequered = flat(vec3(0), 48, 48);
        for (int y = 0; y < 48; ++y) {
            for (int x = y % 2; x < 48; x += 2) chequered.at(x, y) = vec4(1);
        }
        const auto grey = flat(vec3(0.5f), 48, 48);
        const auto middle = [&](double ppd) {
            return flip_map(chequered, grey, {.pixels_per_degree = ppd}).at(24, 24);
        };
        CHECK(middle(5) > 0.3f);
        CHECK(middle(120) < 0.01f);
    }
    TEST_CASE("margins lower the mean over the picture, not that over the object") {
        const auto square = [](int size, const vec4& color) {
            view_picture picture = support::empty_picture(size, size);
            support::fill(picture, size / 2 - 8, size / 2 - 8, 16, 16, color);
            return picture;
        };
        const vec4 red(0.6f, 0.1f, 0.1f, 1);
        const vec4 green(0.1f, 0.6f, 0.1f, 1);
        const auto narrow = flip_error(square(40, red), square(40, green));
        const auto wide = flip_error(square(80, red), square(80, green));
        CHECK(wide.mean < 0.3 * narrow.mean);
        CHECK(wide.over_object == doctest::Approx(narrow.over_object));
        CHECK(wide.over_object > 0.5);
    }
    TEST_CASE("missing coverage differs by the background that shows") {
        const auto whole = support::square_at(5, 5);
        auto holed = whole;
        support::fill(holed, 10, 10, 6, 6, vec4(0));
        CHECK(flip_map(whole, holed).at(13, 13) > 0.3f);
        const vec3 same(0.2f, 0.5f, 0.1f);
        CHECK(flip_error(whole, holed, {.background = same}).mean < 1e-3);
    }
    TEST_CASE("a picture as large as on the screen has the screen's pixels a degree") {
        const lod_screen screen{.fov_y = std::numbers::pi / 2, .height_px = 1000};
        CHECK(usual_pixels_per_degree == doctest::Approx(67.02).epsilon(1e-4));
        // At a distance of 10 the screen gives a scene unit 50 pixels.
        CHECK(pixels_per_degree_at(10, screen, 50) == doctest::Approx(usual_pixels_per_degree));
        CHECK(pixels_per_degree_at(10, screen, 100, 60) == doctest::Approx(120));
        CHECK(pixels_per_degree_at(20, screen, 100, 60) == doctest::Approx(240));
    }
}
