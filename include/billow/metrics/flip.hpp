// ꟻLIP: the difference that an observer sees who flips between two pictures.
//
// Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for
// Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020: the one for pictures of
// low dynamic range. Its filters are separable and run along rows, then columns.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include <billow/geometry/screen.hpp>
#include <billow/metrics/channel.hpp>
#include <billow/metrics/lab.hpp>
#include <billow/metrics/view_picture.hpp>

namespace billow::inline BILLOW_ABI {

/// Pixels a degree of a screen seen from 0.7 m that shows 3840 pixels on 0.7 m: the paper's.
inline constexpr double usual_pixels_per_degree = 0.7 * 3840 / 0.7 * std::numbers::pi / 180;

struct flip_options {
    /// Pixels of the picture in a degree of the observer's eye, ≥ 1. The more, the smaller a pixel
    /// looks, and the less of its detail is seen.
    double pixels_per_degree = usual_pixels_per_degree;
    vec3 background{0.85f, 0.87f, 0.9f};  ///< linear light, where nothing is
};

/// Pixels a degree of a picture of an object that an observer has before him at `distance`, on a
/// `screen` of `screen_pixels_per_degree`. A picture drawn as large as the object is on the screen
/// has those of the screen; one k times as large has k times as many.
///
/// Unit   picture_scale: pixels that the picture has for a scene unit at the object's centre.
/// Needs  distance > 0.
[[nodiscard]] inline double pixels_per_degree_at(
    double distance, const lod_screen& screen, double picture_scale,
    double screen_pixels_per_degree = usual_pixels_per_degree) noexcept {
    return screen_pixels_per_degree * picture_scale * distance / screen.pixels_at_one();
}

/// What an observer sees of one picture. Made once, it serves comparisons with several.
struct flip_percept {
    channel lightness{};  ///< L* of what contrast sensitivity leaves
    channel a{};          ///< a*, Hunt-adjusted
    channel b{};
    channel edge{};   ///< size of the gradient of luminance
    channel point{};  ///< size of its second derivatives
};

namespace detail {

/// Standard deviation, in degrees, of the Gaussian whose Fourier transform the paper's table 1 gives
/// by b: σ = sqrt(b / 2)/π.
[[nodiscard]] inline double flip_sigma_deg(double b) noexcept {
    return std::sqrt(b / 2) / std::numbers::pi;
}

/// Adjusts positive weights to a sum of 1, negative ones to -1.
[[nodiscard]] inline filter_weights balanced(const std::vector<double>& raw) {
    double positive = 0;
    double negative = 0;
    for (const double w : raw) (w > 0 ? positive : negative) += std::abs(w);
    filter_weights weights;
    for (const double w : raw)
        weights.push_back(static_cast<float>(w / (w > 0 ? positive : negative)));
    return weights;
}

/// The filters of section 4.1.1 and 4.2 for a picture of so many pixels a degree.
struct flip_filters {
    filter_weights achromatic{};
    filter_weights red_green{};
    filter_weights blue_yellow[2]{};  ///< a sum of two Gaussians, the wider one first
    float wider_share = 0;            ///< of that sum
    filter_weights smooth{};          ///< across an edge
    filter_weights edge{};            ///< first derivative of a Gaussian
    filter_weights point{};           ///< second derivative

    explicit flip_filters(double pixels_per_degree) {
        // Table 1 of the paper. Its blue-yellow row has two terms; a is the height of one, b says
        // how wide it is. The other rows' second terms are 0.
        constexpr double b_achromatic = 0.0047;
        constexpr double b_red_green = 0.0053;
        constexpr double a_blue_yellow[2] = {34.1, 13.5};
        constexpr double b_blue_yellow[2] = {0.04, 0.025};
        const auto sigma = [=](double b) { return flip_sigma_deg(b) * pixels_per_degree; };
        const int radius = static_cast<int>(std::ceil(3 * sigma(b_blue_yellow[0])));
        achromatic = gaussian_weights(sigma(b_achromatic), radius);
        red_green = gaussian_weights(sigma(b_red_green), radius);
        double mass[2];
        for (std::size_t i = 0; i < 2; ++i) {
            blue_yellow[i] = gaussian_weights(sigma(b_blue_yellow[i]), radius);
            // The term's sum over the square: height over the weight in the middle, squared.
            const double middle = blue_yellow[i][blue_yellow[i].size() / 2];
            const double height = a_blue_yellow[i] * std::sqrt(std::numbers::pi / b_blue_yellow[i]);
            mass[i] = height / (middle * middle);
        }
        wider_share = static_cast<float>(mass[0] / (mass[0] + mass[1]));

        constexpr double feature_width_deg = 0.082;
        const double s = 0.5 * feature_width_deg * pixels_per_degree;
        const int reach = static_cast<int>(std::ceil(3 * s));
        std::vector<double> slope;
        std::vector<double> bend;
        std::vector<double> bell;
        for (int x = -reach; x <= reach; ++x) {
            const double g = std::exp(-0.5 * x * x / (s * s));
            bell.push_back(g);
            slope.push_back(-x * g);
            bend.push_back((x * x / (s * s) - 1) * g);
        }
        smooth = balanced(bell);
        edge = balanced(slope);
        point = balanced(bend);
    }
};

/// x · share + y · (1 - share) of each pixel.
[[nodiscard]] inline channel mixed(channel x, const channel& y, float share) {
    using lanes = simd::lanes<simd::wide>;
    for (std::size_t i = 0; i < x.values.size(); i += lanes::count) {
        const auto u = lanes::load(x.values.data() + i);
        const auto v = lanes::load(y.values.data() + i);
        lanes::store(x.values.data() + i, v + (u - v) * share);
    }
    return x;
}

/// sqrt(x² + y²) of each pixel.
[[nodiscard]] inline channel lengths(channel x, const channel& y) {
    using lanes = simd::lanes<simd::wide>;
    for (std::size_t i = 0; i < x.values.size(); i += lanes::count) {
        const auto u = lanes::load(x.values.data() + i);
        const auto v = lanes::load(y.values.data() + i);
        lanes::store(x.values.data() + i, simd::sqrt(u * u + v * v));
    }
    return x;
}

/// L*, and a* and b* that matter less in the dark (the paper's equation for Hunt's effect).
template <class V>
[[nodiscard]] color_lanes<V> hunt_adjusted(const color_lanes<V>& relative_xyz) noexcept {
    const auto lab = lab_of_relative_xyz(relative_xyz);
    const V scale = lab.x * 0.01f;
    return {lab.x, scale * lab.y, scale * lab.z};
}

/// HyAB of adjusted colours, to the power of 0.7.
[[nodiscard]] inline float color_distance(const color_lanes<float>& p,
                                          const color_lanes<float>& q) noexcept {
    const float da = p.y - q.y;
    const float db = p.z - q.z;
    return std::pow(std::abs(p.x - q.x) + std::sqrt(da * da + db * db), 0.7f);
}

/// The largest color_distance in sRGB: between green and blue.
[[nodiscard]] inline float largest_color_distance() noexcept {
    return color_distance(hunt_adjusted(relative_xyz(color_lanes<float>{0, 1, 0})),
                          hunt_adjusted(relative_xyz(color_lanes<float>{0, 0, 1})));
}

template <class V>
[[nodiscard]] V clamped_to_unit(V value) noexcept {
    return simd::min(simd::max(value, simd::lanes<V>::fill(0)), simd::lanes<V>::fill(1));
}

/// Turns filtered opponent axes in place into Hunt-adjusted L*, a*, b*.
template <class V>
void adjust(channel& l, channel& a, channel& b) noexcept {
    using lanes = simd::lanes<V>;
    for (std::size_t i = 0; i < l.values.size(); i += lanes::count) {
        const V y = lanes::load(l.values.data() + i);
        const V red_green = lanes::load(a.values.data() + i);
        const V blue_yellow = lanes::load(b.values.data() + i);
        auto light = linear_of_relative_xyz(color_lanes<V>{y + red_green, y, y - blue_yellow});
        light = {clamped_to_unit(light.x), clamped_to_unit(light.y), clamped_to_unit(light.z)};
        const auto lab = hunt_adjusted(relative_xyz(light));
        lanes::store(l.values.data() + i, lab.x);
        lanes::store(a.values.data() + i, lab.y);
        lanes::store(b.values.data() + i, lab.z);
    }
}

/// Distances up to 0.4 of the largest one take 0.95 of [0, 1], those above the rest.
[[nodiscard]] inline float spread(float distance, float largest) noexcept {
    constexpr float knee = 0.4f;
    constexpr float knee_value = 0.95f;
    const float at = distance / (knee * largest);
    if (at < 1) return at * knee_value;
    return knee_value + (distance - knee * largest) / ((1 - knee) * largest) * (1 - knee_value);
}

}  // namespace detail

/// Sections 4.1 and 4.2 of the paper for one picture: its colours, blurred by how fine a contrast the
/// eye resolves, and the edges and points of its luminance.
///
/// Needs  a picture of at least one pixel.
/// Cost   O(pixels · pixels a degree), 7 filters of a third of a degree along each side.
[[nodiscard]] inline flip_percept seen_in(const view_picture& picture,
                                          const flip_options& options = {}) {
    BILLOW_ASSERT(options.pixels_per_degree >= 1 && !picture.pixels.empty());
    const detail::flip_filters filters(options.pixels_per_degree);
    // The opponent space's axes up to offset and scale, which filters of sum 1 leave alone.
    channel y(picture.width, picture.height);
    channel red_green(picture.width, picture.height);
    channel blue_yellow(picture.width, picture.height);
    for (int row = 0; row < picture.height; ++row) {
        for (int x = 0; x < picture.width; ++x) {
            const vec4& p = picture.at(x, row);
            const vec3 over = vec3(p) + (1 - p.a) * options.background;
            const auto xyz = relative_xyz(color_lanes<float>{std::clamp(over.x, 0.0f, 1.0f),
                                                             std::clamp(over.y, 0.0f, 1.0f),
                                                             std::clamp(over.z, 0.0f, 1.0f)});
            y.row(row)[x] = xyz.y;
            red_green.row(row)[x] = xyz.x - xyz.y;
            blue_yellow.row(row)[x] = xyz.y - xyz.z;
        }
    }
    flip_percept seen;
    const channel smooth = filter_rows(y, filters.smooth);
    seen.edge = detail::lengths(filter_columns(filter_rows(y, filters.edge), filters.smooth),
                                filter_columns(smooth, filters.edge));
    seen.point = detail::lengths(filter_columns(filter_rows(y, filters.point), filters.smooth),
                                 filter_columns(smooth, filters.point));
    seen.lightness = blurred(y, filters.achromatic);
    seen.a = blurred(red_green, filters.red_green);
    seen.b = detail::mixed(blurred(blue_yellow, filters.blue_yellow[0]),
                           blurred(blue_yellow, filters.blue_yellow[1]), filters.wider_share);
    detail::adjust<simd::wide>(seen.lightness, seen.a, seen.b);
    return seen;
}

/// The difference of two pictures at each pixel: 0 where none is seen, at most 1.
///
/// Needs   percepts of the same size.          Cost  O(pixels).
/// Gives   the same whichever comes first.
/// Source  Andersson et al. 2020, ΔE = ΔE_color ^ (1 - ΔE_feature).
[[nodiscard]] inline channel flip_map(const flip_percept& first, const flip_percept& second) {
    BILLOW_ASSERT(first.edge.width == second.edge.width && first.edge.height == second.edge.height);
    const float largest = detail::largest_color_distance();
    channel map(first.edge.width, first.edge.height);
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            const auto seen = [&](const flip_percept& p) {
                return color_lanes<float>{p.lightness.at(x, y), p.a.at(x, y), p.b.at(x, y)};
            };
            const auto p = seen(first);
            const auto q = seen(second);
            if (p.x == q.x && p.y == q.y && p.z == q.z) continue;
            const float edge = std::abs(first.edge.at(x, y) - second.edge.at(x, y));
            const float point = std::abs(first.point.at(x, y) - second.point.at(x, y));
            const float feature = std::sqrt(std::max(edge, point) / std::numbers::sqrt2_v<float>);
            const float color = detail::spread(detail::color_distance(p, q), largest);
            map.row(y)[x] = std::pow(std::min(color, 1.0f), 1 - std::min(feature, 1.0f));
        }
    }
    return map;
}

[[nodiscard]] inline channel flip_map(const view_picture& first, const view_picture& second,
                                      const flip_options& options = {}) {
    return flip_map(seen_in(first, options), seen_in(second, options));
}

/// ꟻLIP of two pictures, 0 to 1.
struct flip_errors {
    double mean = 0;         ///< over the picture, as the paper's tool; empty margins lower it
    double over_object = 0;  ///< Σw·ꟻLIP / Σw, w the greater coverage: whatever the margins are
};

/// Pools a map. Needs pictures of the map's size.
[[nodiscard]] inline flip_errors flip_error(const channel& map, const view_picture& first,
                                            const view_picture& second) noexcept {
    BILLOW_ASSERT(map.width == first.width && first.width == second.width);
    BILLOW_ASSERT(map.height == first.height && first.height == second.height);
    double sum = 0;
    double over_object = 0;
    double weights = 0;
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            const double weight = std::max(first.at(x, y).a, second.at(x, y).a);
            sum += map.at(x, y);
            over_object += weight * map.at(x, y);
            weights += weight;
        }
    }
    return {sum / (static_cast<double>(map.width) * map.height),
            weights > 0 ? over_object / weights : 0};
}

[[nodiscard]] inline flip_errors flip_error(const view_picture& first, const view_picture& second,
                                            const flip_options& options = {}) {
    return flip_error(flip_map(first, second, options), first, second);
}

}  // namespace billow::inline BILLOW_ABI
