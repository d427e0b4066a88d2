// Pictures of where a cloud's view differs from its original's.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <billow/core/types.hpp>
#include <billow/image/image.hpp>
#include <billow/image/srgb.hpp>
#include <billow/metrics/channel.hpp>
#include <billow/metrics/color_error.hpp>
#include <billow/metrics/lab.hpp>
#include <billow/metrics/view_picture.hpp>

namespace billow::inline BILLOW_ABI {

/// The colours of coverage_picture, linear light. Orange and blue are told apart by nearly all eyes.
struct coverage_colors {
    vec3 nothing{0.90f, 0.90f, 0.90f};
    vec3 both{0.45f, 0.45f, 0.45f};
    vec3 missing{0.66f, 0.11f, 0};  ///< of the original in the cloud
    vec3 extra{0, 0.17f, 0.45f};    ///< of the cloud beyond the original
};

/// Signed difference of coverage: pixels mix the colours by the share that each holds.
///
/// Needs  pictures of the same size.
/// Gives  RGB, sRGB.
[[nodiscard]] inline image coverage_picture(const view_picture& original, const view_picture& cloud,
                                            const coverage_colors& colors = {}) {
    BILLOW_ASSERT(original.width == cloud.width && original.height == cloud.height);
    image result = image::filled(original.width, original.height, 3, 0);
    for (int y = 0; y < original.height; ++y) {
        for (int x = 0; x < original.width; ++x) {
            const float a = original.at(x, y).a;
            const float b = cloud.at(x, y).a;
            const vec3 light =
                colors.nothing * (1 - std::max(a, b)) + colors.both * std::min(a, b) +
                colors.missing * std::max(a - b, 0.0f) + colors.extra * std::max(b - a, 0.0f);
            std::uint8_t* pixel = result.pixel(x, y);
            for (int c = 0; c < 3; ++c) pixel[c] = srgb_byte_from_linear(light[c]);
        }
    }
    return result;
}

/// sRGB of a share from 0, dark blue, over red to 1, light yellow; lightness grows all along.
[[nodiscard]] inline vec3 heat_color(float share) noexcept {
    static constexpr std::array<std::array<float, 3>, 5> steps{{{0.05f, 0.05f, 0.25f},
                                                                {0.40f, 0.08f, 0.42f},
                                                                {0.80f, 0.24f, 0.28f},
                                                                {0.97f, 0.58f, 0.16f},
                                                                {0.99f, 0.96f, 0.64f}}};
    const float at = std::clamp(share, 0.0f, 1.0f) * static_cast<float>(steps.size() - 1);
    const std::size_t below = std::min(static_cast<std::size_t>(at), steps.size() - 2);
    const float rest = at - static_cast<float>(below);
    vec3 color;
    for (std::size_t c = 0; c < 3; ++c) {
        color[static_cast<int>(c)] =
            steps[below][c] + (steps[below + 1][c] - steps[below][c]) * rest;
    }
    return color;
}

/// ΔE*76 after a blur, square by square: what local_color_error is the mean of. Colours are those of
/// heat_color, from 0 to `most`, faded to grey where little is covered.
///
/// Needs  pictures of the same size, blurred by the same options; most > 0.
/// Gives  RGB, sRGB; a pixel for each square of the blurred pictures.
[[nodiscard]] inline image color_difference_picture(const blurred_picture& original,
                                                    const blurred_picture& cloud,
                                                    double most = 40) {
    const channel& a = original.channels[3];
    const channel& b = cloud.channels[3];
    BILLOW_ASSERT(a.width == b.width && a.height == b.height);
    const vec3 nothing(0.95f);
    image result = image::filled(a.width, a.height, 3, 0);
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            const float weight = std::min(a.at(x, y), b.at(x, y));
            vec3 color = nothing;
            if (weight > 1e-4f) {  // as local_color_error
                const vec4 p = original.at(x, y);
                const vec4 q = cloud.at(x, y);
                const double error =
                    delta_e76(lab_from_linear(vec3(p) / p.a), lab_from_linear(vec3(q) / q.a));
                color = glm::mix(nothing, heat_color(static_cast<float>(error / most)),
                                 std::min(1.0f, 4 * weight));
            }
            std::uint8_t* pixel = result.pixel(x, y);
            for (int c = 0; c < 3; ++c) {
                pixel[c] = static_cast<std::uint8_t>(std::lround(255 * color[c]));
            }
        }
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI
