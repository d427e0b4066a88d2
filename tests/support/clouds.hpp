// Clouds put together by hand, and what every cloud promises.
#pragma once

#include <vector>

#include <doctest/doctest.h>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/search/leftovers.hpp>

#include "support/meshes.hpp"

namespace support {

/// A level square plate of 2 · 8² faces with the given middle.
inline void add_level_plate(billow::mesh& m, const billow::vec3& middle, float half) {
    const float cell = half / 8;
    for (int i = 0; i < 8; ++i) {
        for (int j = 0; j < 8; ++j) {
            const billow::vec3 at(float(2 * i - 7) * cell, float(2 * j - 7) * cell, 0);
            add_square(m, middle + at, {cell, 0, 0}, {0, cell, 0});
        }
    }
}

/// The level plane at height z, as `faces` has it.
inline billow::plane level_plane(const billow::face_table& faces, double z) {
    return {{0, 0, 1}, z - faces.bounds.centre.z};
}

/// A cloud of these planes, each face on the nearest.
inline billow::billboard_cloud cloud_of(const billow::face_table& faces,
                                        std::vector<billow::plane> planes, double epsilon) {
    billow::billboard_cloud cloud;
    cloud.bounds = faces.bounds;
    cloud.epsilon = epsilon;
    cloud.plane_of_face.assign(faces.size + faces.degenerate.size(), billow::no_id);
    const auto nearest = billow::planes_of_least_error(faces, planes);
    for (std::size_t row = 0; row < faces.size; ++row) {
        cloud.plane_of_face[faces.source[row]] = nearest[row];
    }
    cloud.planes = std::move(planes);
    return cloud;
}

/// Every face that has an area is on one plane, no vertex is beyond epsilon, every plane has a face.
inline void check_whole(const billow::mesh& m, const billow::billboard_cloud& cloud) {
    const billow::cloud_errors e = billow::measure_errors(m, cloud);
    CHECK(e.mapped_faces == m.face_count());
    CHECK(e.faces_beyond_epsilon == 0);
    const billow::faces_of_planes faces(cloud.plane_of_face, cloud.plane_count());
    for (billow::plane_id id = 0; id < cloud.plane_count(); ++id) CHECK(!faces[id].empty());
}

}  // namespace support
