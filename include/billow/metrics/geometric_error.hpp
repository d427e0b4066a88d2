// How far a cloud moves the vertices of its mesh, in units of the scene, of the object and of a screen.
//
// C. Luksch, "Implementation of an improved billboard cloud algorithm", TU Wien 2009, section
// 3.4, Geometric Error.
#pragma once

#include <cstddef>
#include <span>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/geometry/screen.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/metrics/displacement.hpp>
#include <billow/search/motion.hpp>

namespace billow::inline BILLOW_ABI {

/// From where an error is seen.
struct seen_from {
    double distance = 0;  ///< to the cloud's centre, scene units; 0: 4 radii, as the thesis
    lod_screen screen{};
};

/// Displacement of the vertices: the distance to where the cloud draws them, which is the distance to
/// their plane where nothing is welded. The mean weighs each vertex by the area of its faces.
struct geometric_errors {
    double mean = 0;  ///< scene units
    double max = 0;   ///< scene units
    double mean_of_radius = 0;
    double max_of_radius = 0;
    double mean_of_diameter = 0;
    double max_of_diameter = 0;
    double mean_px = 0;       ///< across the view, as large as it looks at the centre's distance
    double max_px = 0;        ///< as large as it can look: at the nearest point of the sphere
    std::size_t undrawn = 0;  ///< faces that are on no plane; they do not count above
};

/// Measures a cloud against the mesh that it was made of, of which some corners have `moved`.
///
/// Shape   cloud.plane_of_face has a row a face of the mesh.
/// Gives   shares of the radius and pixels of 0 where the cloud has no radius.
/// Cost    O(faces), in double.
/// Source  Luksch 2009, section 3.4. The thesis scales by the projection's size, which is mean_px;
///         max_px is a bound, as a switch distance needs it.
[[nodiscard]] inline geometric_errors geometric_error(const mesh& original,
                                                      const billboard_cloud& cloud,
                                                      std::span<const moved_face> moved = {},
                                                      const seen_from& from = {}) {
    const drawn_faces before = undisplaced(original);
    const displacement d = displacement_between(original, before, drawn_by(cloud, before, moved));
    geometric_errors errors{
        .mean = d.mean, .max = d.max, .undrawn = original.face_count() - d.faces};
    const double radius = cloud.bounds.radius;
    if (!(radius > 0)) return errors;
    errors.mean_of_radius = d.mean / radius;
    errors.max_of_radius = d.max / radius;
    errors.mean_of_diameter = errors.mean_of_radius / 2;
    errors.max_of_diameter = errors.max_of_radius / 2;
    const double distance = from.distance > 0 ? from.distance : 4 * radius;
    errors.mean_px = pixels_of_error(d.mean, 0, distance, from.screen);
    errors.max_px = pixels_of_error(d.max, radius, distance, from.screen);
    return errors;
}

}  // namespace billow::inline BILLOW_ABI
