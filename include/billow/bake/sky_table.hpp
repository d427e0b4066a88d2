// What the leaves and vertices of a mesh see of the sky.
#pragma once

#include <vector>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// The sky from one place: foliage looks to both sides, all else to one.
struct sky_view {
    float open = 1;  ///< visible share of the sky, weighted by the cosine to the normal
    /// x, y, z: the sum of the directions that see the sky, w: their number, both over the number of
    /// all directions on the sphere. Sums, so that views can be averaged.
    vec4 visible{0, 0, 0, 1};
};

/// Shape  `of_face`: the rows of `views` that the corners of each face see.
struct sky_table {
    std::vector<uvec3> of_face{};
    std::vector<sky_view> views{};

    /// The sky from the point with barycentric `weights` of a face.
    [[nodiscard]] sky_view at(face_id face, const vec3& weights) const noexcept {
        const sky_view& a = views[of_face[face].x];
        const sky_view& b = views[of_face[face].y];
        const sky_view& c = views[of_face[face].z];
        return {a.open * weights.x + b.open * weights.y + c.open * weights.z,
                a.visible * weights.x + b.visible * weights.y + c.visible * weights.z};
    }
};

}  // namespace billow::inline BILLOW_ABI
