// Clouds as the search finds them, and which planes of some could take which faces.
#pragma once

#include <initializer_list>
#include <vector>

#include <billow/improve/plane_cover.hpp>
#include <billow/search/greedy.hpp>

#include "support/clouds.hpp"

namespace support {

/// The level planes at these heights and the faces within epsilon of them.
inline billow::plane_cover level_cover(const billow::face_table& faces,
                                       std::initializer_list<double> heights, double epsilon) {
    std::vector<billow::plane> planes;
    for (const double z : heights) planes.push_back(level_plane(faces, z));
    return {faces, planes, epsilon, 0, {}};
}

/// The cloud of the greedy search, epsilon being a share of the radius.
inline billow::billboard_cloud greedy_cloud(const billow::face_table& faces, double share) {
    return billow::greedy_search(faces, faces.size, {.epsilon = share * faces.bounds.radius}).cloud;
}

}  // namespace support
