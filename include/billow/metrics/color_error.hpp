// How far a cloud's colours are from its original's, as the eye counts it.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 3.4, Color Error.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <billow/metrics/channel.hpp>
#include <billow/metrics/lab.hpp>
#include <billow/metrics/view_picture.hpp>

namespace billow::inline BILLOW_ABI {

struct color_options {
    /// Standard deviation of the blur that the local error is taken after, pixels, > 0. Detail that is
    /// displaced by less is not punished.
    double sigma_px = 8;
};

/// ΔE*76, 0 for the same colours; black and white are 100 apart. 0 where a picture covers nothing.
struct color_errors {
    double mean = 0;    ///< between the mean colours of all that each picture covers: the thesis's
    double common = 0;  ///< between the mean colours of the pixels that both cover
    double local = 0;   ///< mean over what both cover, of the difference after a blur
};

/// A picture, blurred and in squares of `square_px` pixels. Colour times coverage, and coverage.
struct blurred_picture {
    int square_px = 1;
    std::array<channel, 4> channels{};

    [[nodiscard]] vec4 at(int x, int y) const noexcept {
        return {channels[0].at(x, y), channels[1].at(x, y), channels[2].at(x, y),
                channels[3].at(x, y)};
    }
};

/// Blurs colour and coverage alike: means of squares of half a sigma (at least a pixel), then a
/// Gaussian of sigma, cut off at three of them. Finer squares would show the same after such a blur.
/// Beyond the edge the outermost squares are read again.
///
/// Cost  O(pixels).
[[nodiscard]] inline blurred_picture blur(const view_picture& picture,
                                          const color_options& options = {}) {
    BILLOW_ASSERT(options.sigma_px > 0);
    blurred_picture result;
    const int side = std::max(1, static_cast<int>(options.sigma_px / 2));
    result.square_px = side;
    if (picture.pixels.empty()) return result;
    for (channel& c : result.channels) {
        c = channel((picture.width + side - 1) / side, (picture.height + side - 1) / side);
    }
    for (int y = 0; y < result.channels[0].height; ++y) {
        const int last_row = std::min((y + 1) * side, picture.height);
        for (int x = 0; x < result.channels[0].width; ++x) {
            const int last_column = std::min((x + 1) * side, picture.width);
            vec4 sum{0};
            for (int j = y * side; j < last_row; ++j) {
                for (int i = x * side; i < last_column; ++i) sum += picture.at(i, j);
            }
            sum /= static_cast<float>((last_row - y * side) * (last_column - x * side));
            for (int c = 0; c < 4; ++c) {
                result.channels[static_cast<std::size_t>(c)].row(y)[x] = sum[c];
            }
        }
    }
    const auto weights = gaussian_weights(options.sigma_px / side,
                                          static_cast<int>(std::ceil(3 * options.sigma_px / side)));
    for (channel& c : result.channels) c = blurred(c, weights);
    return result;
}

/// ΔE*76 between the mean colours, in linear light, of all that each picture covers. Not pixel by
/// pixel, since textures show detail a little displaced.
///
/// Source  Luksch 2009, section 3.4; whether means are of linear light is left open there.
[[nodiscard]] inline double mean_color_error(const view_picture& original,
                                             const view_picture& cloud) noexcept {
    const auto mean_of = [](const view_picture& picture) {
        std::array<double, 4> sum{};
        for (const vec4& p : picture.pixels) {
            for (std::size_t c = 0; c < 4; ++c) sum[c] += p[static_cast<int>(c)];
        }
        return sum;
    };
    const auto a = mean_of(original);
    const auto b = mean_of(cloud);
    if (!(a[3] > 0 && b[3] > 0)) return 0;
    return delta_e76(lab_from_linear(vec3(dvec3(a[0], a[1], a[2]) / a[3])),
                     lab_from_linear(vec3(dvec3(b[0], b[1], b[2]) / b[3])));
}

/// The same over the pixels that both cover, each weighted by the lesser of its coverages: shading
/// and textures alone, whatever the silhouettes are.
///
/// Needs  pictures of the same size.
[[nodiscard]] inline double common_color_error(const view_picture& original,
                                               const view_picture& cloud) noexcept {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    dvec3 a{0};
    dvec3 b{0};
    double weights = 0;
    for (std::size_t i = 0; i < original.pixels.size(); ++i) {
        const vec4& p = original.pixels[i];
        const vec4& q = cloud.pixels[i];
        if (!(p.a > 0 && q.a > 0)) continue;
        const double weight = std::min(p.a, q.a);
        a += dvec3(p) * (weight / p.a);
        b += dvec3(q) * (weight / q.a);
        weights += weight;
    }
    if (!(weights > 0)) return 0;
    return delta_e76(lab_from_linear(vec3(a / weights)), lab_from_linear(vec3(b / weights)));
}

/// Σw·ΔE*76 / Σw over all squares, between the colours (colour times coverage over coverage) of the
/// blurred pictures; w is the lesser of the blurred coverages. Finds wrong colours in the right
/// amount at the wrong place, which means over a picture do not.
///
/// Needs  pictures of the same size.          Cost  O(pixels).
[[nodiscard]] inline double local_color_error(const blurred_picture& original,
                                              const blurred_picture& cloud) noexcept {
    const channel& a = original.channels[3];
    const channel& b = cloud.channels[3];
    BILLOW_ASSERT(a.width == b.width && a.height == b.height);
    double sum = 0;
    double weights = 0;
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            // Where next to nothing is covered, floats hold no colour.
            const float weight = std::min(a.at(x, y), b.at(x, y));
            if (!(weight > 1e-4f)) continue;
            weights += weight;
            const vec4 p = original.at(x, y);
            const vec4 q = cloud.at(x, y);
            if (p == q) continue;
            sum +=
                weight * delta_e76(lab_from_linear(vec3(p) / p.a), lab_from_linear(vec3(q) / q.a));
        }
    }
    return weights > 0 ? sum / weights : 0;
}

[[nodiscard]] inline color_errors color_error(const view_picture& original,
                                              const view_picture& cloud,
                                              const color_options& options = {}) {
    return {mean_color_error(original, cloud), common_color_error(original, cloud),
            local_color_error(blur(original, options), blur(cloud, options))};
}

}  // namespace billow::inline BILLOW_ABI
