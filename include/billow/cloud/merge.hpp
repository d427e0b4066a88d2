// Clouds of parts of a mesh become one cloud.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/config.hpp>

namespace billow::inline BILLOW_ABI {

/// Puts clouds of parts of one mesh side by side: the planes of the first, then those of the second …
/// Each cloud becomes a part with its own epsilon; several parts of one cloud stay several.
///
/// Needs   at least one cloud; the same centre and as many rows of plane_of_face in all of them; a
///         face mapped by one cloud at most.
/// Gives   a single cloud as it is.
/// Cost    O(clouds · faces).
[[nodiscard]] inline billboard_cloud merge_clouds(std::vector<billboard_cloud> clouds) {
    BILLOW_ASSERT(!clouds.empty());
    billboard_cloud merged = std::move(clouds.front());
    if (clouds.size() == 1) return merged;
    if (merged.parts.empty()) {
        merged.parts = {{merged.epsilon}};
        merged.part_of_plane.assign(merged.plane_count(), 0);
    }
    for (std::size_t i = 1; i < clouds.size(); ++i) {
        const billboard_cloud& cloud = clouds[i];
        BILLOW_ASSERT(cloud.bounds.centre == merged.bounds.centre);
        BILLOW_ASSERT(cloud.plane_of_face.size() == merged.plane_of_face.size());
        const auto first_plane = static_cast<plane_id>(merged.plane_count());
        const auto first_part = static_cast<part_id>(merged.parts.size());
        merged.bounds.radius = std::max(merged.bounds.radius, cloud.bounds.radius);
        merged.epsilon = std::max(merged.epsilon, cloud.epsilon);
        merged.planes.insert(merged.planes.end(), cloud.planes.begin(), cloud.planes.end());
        merged.billboards.insert(merged.billboards.end(), cloud.billboards.begin(),
                                 cloud.billboards.end());
        for (std::size_t face = 0; face < cloud.plane_of_face.size(); ++face) {
            if (cloud.plane_of_face[face] == no_id) continue;
            BILLOW_ASSERT(merged.plane_of_face[face] == no_id);
            merged.plane_of_face[face] = first_plane + cloud.plane_of_face[face];
        }
        for (const drawn_too& drawn : cloud.also_drawn) {
            merged.also_drawn.push_back({first_plane + drawn.plane, drawn.face});
        }
        for (plane_id plane = 0; plane < cloud.plane_count(); ++plane) {
            merged.part_of_plane.push_back(first_part + cloud.part_of(plane));
        }
        if (cloud.parts.empty()) {
            merged.parts.push_back({cloud.epsilon});
        } else {
            merged.parts.insert(merged.parts.end(), cloud.parts.begin(), cloud.parts.end());
        }
    }
    return merged;
}

}  // namespace billow::inline BILLOW_ABI
