// How fine a cloud has to be for the distance from which it is seen: epsilon and the texel's size.
//
// Luksch, "Implementation of an improved billboard cloud algorithm", 2009, section 6.2, leaves the
// choice of both for a given distance to future work. The formula is that of switch distances.
#pragma once

#include <algorithm>

#include <billow/geometry/bounds.hpp>
#include <billow/geometry/screen.hpp>
#include <billow/pipeline/build_result.hpp>

namespace billow::inline BILLOW_ABI {

/// From where a cloud is seen, and how far it may be off there.
///
/// Needs  all above 0; no least above its most.
struct viewing_options {
    double distance = 0;  ///< from the eye to the centre of the bounding sphere, scene units
    lod_screen screen{};
    double pixel_error = 1;        ///< pixels by which a vertex may be off
    double texel_error = 1;        ///< pixels that the side of a texel may cover
    double least_epsilon = 0.005;  ///< radii; finer, a cloud has nearly as many planes as faces
    double most_epsilon = 0.5;     ///< radii; coarser, little but a single plane is left
    double least_texels = 16;      ///< along the diameter; with fewer, tiles have no outlines
    double most_texels = 2048;     ///< along the diameter; with more, atlases fill gigabytes
};

/// What was chosen. Lengths are in scene units.
struct viewing_choice {
    double pixel = 0;           ///< length that a pixel shows, at the nearest point of the sphere
    double epsilon = 0;         ///< within the bounds of the options
    double wanted_epsilon = 0;  ///< what pixel_error asks for
    double texel_size = 0;      ///< within the bounds of the options
    double wanted_texel_size = 0;  ///< what texel_error asks for
    double error_px = 0;           ///< pixels that epsilon covers: pixel_error, but for the bounds
    double texel_px = 0;           ///< pixels that a texel covers: texel_error, but for the bounds
    double object_px = 0;          ///< pixels that the diameter covers, at the centre's distance
};

/// The largest epsilon and texel that show no larger than asked for. Both are seen at the point of
/// the bounding sphere that is nearest to the eye, or at the screen's near distance where the eye is
/// closer: pixel = max(distance - radius, near) / pixels_at_one.
///
/// Gives   wanted lengths, and the same within the bounds, which do not count for a sphere without
///         a radius.
/// Source  The inverse of pixels_of_error.
[[nodiscard]] inline viewing_choice choose_for(const bounding_sphere& bounds,
                                               const viewing_options& seen) noexcept {
    BILLOW_ASSERT(seen.distance > 0 && seen.pixel_error > 0 && seen.texel_error > 0);
    const auto shown = [&](double pixels) {
        return error_for_pixels(pixels, bounds.radius, seen.distance, seen.screen);
    };
    viewing_choice choice{.pixel = shown(1),
                          .wanted_epsilon = shown(seen.pixel_error),
                          .wanted_texel_size = shown(seen.texel_error)};
    choice.epsilon = choice.wanted_epsilon;
    choice.texel_size = choice.wanted_texel_size;
    if (bounds.radius > 0) {
        const double diameter = 2 * bounds.radius;
        choice.epsilon = std::clamp(choice.epsilon, seen.least_epsilon * bounds.radius,
                                    seen.most_epsilon * bounds.radius);
        choice.texel_size = std::clamp(choice.texel_size, diameter / seen.most_texels,
                                       diameter / seen.least_texels);
    }
    choice.error_px = choice.epsilon / choice.pixel;
    choice.texel_px = choice.texel_size / choice.pixel;
    choice.object_px = pixels_of_error(2 * bounds.radius, 0, seen.distance, seen.screen);
    return choice;
}

/// Sets epsilon and the size of texels; the rest stays.
inline void apply(const viewing_choice& choice, build_options& to) noexcept {
    to.epsilon = tolerance::scene_units(choice.epsilon);
    to.bake.texels_per_unit = 1 / choice.texel_size;
}

}  // namespace billow::inline BILLOW_ABI
