// Average plane: the post-plane tweak.
//
// A. Fuhrmann, E. Umlauf, S. Mantler: Extreme model simplification for forest rendering.
// Eurographics Workshop on Natural Phenomena 2005, section 3.3.3.
#pragma once

#include <billow/fit/fit.hpp>

namespace billow::inline BILLOW_ABI {

/// The area-weighted mean of the faces' normals, through the mean of their centroids. Normals are
/// first turned to the side of the start plane's, else the two sides of a leaf would cancel out.
struct average_fit {
    static constexpr bool allows_less_contribution = false;
    [[nodiscard]] plane operator()(const face_table& faces, const plane& start) const {
        dvec3 normal{0};
        dvec3 centroid{0};
        double total = 0;
        for (std::size_t row = 0; row < faces.size; ++row) {
            const double area = static_cast<double>(faces.area[row]);
            const dvec3 n = faces.normal.get(row);
            normal += (glm::dot(n, start.normal) < 0 ? -n : n) * area;
            centroid += faces.centroid(row) * area;
            total += area;
        }
        const double length = glm::length(normal);
        if (!(total > 0) || length < 1e-6 * total) return start;
        normal /= length;
        return {normal, glm::dot(normal, centroid / total)};
    }
};
static_assert(plane_fitter<average_fit>);

}  // namespace billow::inline BILLOW_ABI
