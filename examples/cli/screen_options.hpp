// The screen on which errors are counted in pixels, as options of a verb; distances as they are given.
#pragma once

#include <cstdio>
#include <numbers>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>

#include <billow/geometry/screen.hpp>

#include "shared.hpp"

namespace cli {

struct screen_options {
    double pixel_error = 1;
    double fov_degrees = 60;
    int height_px = 1080;

    [[nodiscard]] billow::lod_screen screen() const {
        return {.fov_y = fov_degrees * std::numbers::pi / 180,
                .width_px = height_px * 16 / 9,
                .height_px = height_px};
    }
};

/// Adds --pixel-error, --screen and --fov, which fill `to`. `error_help` is the help of the first.
inline void add_screen_options(CLI::App& verb, screen_options& to, const std::string& group,
                               const std::string& error_help) {
    verb.add_option("--pixel-error", to.pixel_error, error_help)
        ->check(CLI::Range(0.01, 1000.0))
        ->capture_default_str()
        ->group(group);
    verb.add_option("--screen", to.height_px, "Height of the screen in pixels")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str()
        ->group(group);
    verb.add_option("--fov", to.fov_degrees, "Vertical field of view in degrees")
        ->check(CLI::Range(1.0, 170.0))
        ->capture_default_str()
        ->group(group);
}

/// "12R" are radii of the bounding sphere, "40" and "40m" scene units. Throws CLI::ValidationError.
inline billow::tolerance parse_distance(const char* option, const std::string& text) {
    const bool is_of_radius = text.ends_with('R') || text.ends_with('r');
    const bool has_unit = is_of_radius || text.ends_with('m');
    const auto value =
        number_of(std::string_view(text).substr(0, text.size() - (has_unit ? 1 : 0)));
    if (!value || !(*value > 0)) {
        throw CLI::ValidationError(option, "'" + text +
                                               "' is neither radii such as 12R nor a length such "
                                               "as 40 or 40m, greater than 0");
    }
    return is_of_radius ? billow::tolerance::of_radius(*value)
                        : billow::tolerance::scene_units(*value);
}

/// From where pictures may be taken, radii. Closer the eye is in the model; farther ꟻLIP's filters
/// are wider than the picture.
inline constexpr double nearest_eye = 1.1;
inline constexpr double farthest_eye = 200;

/// Empty where the eye is well placed for pictures.
inline std::string fault_of_eye(double radii) {
    if (radii >= nearest_eye && radii <= farthest_eye) return {};
    char text[120];
    std::snprintf(text, sizeof text, "%.4g radii from the centre; it may be from %.4gR to %.4gR",
                  radii, nearest_eye, farthest_eye);
    return text;
}

}  // namespace cli
