// The greedy search as the tests of its options call it.
#pragma once

#include <utility>

#include <billow/plane_space/cube_map.hpp>
#include <billow/search/greedy.hpp>

#include "support/meshes.hpp"

namespace support {

/// Searches coarsely, with epsilon as a share of the radius.
inline billow::greedy_result coarse_search(const billow::mesh& m, double share,
                                           billow::greedy_options options) {
    billow::face_table faces = table_of(m);
    options.epsilon = share * faces.bounds.radius;
    return billow::greedy_search(std::move(faces), m.face_count(), options,
                                 billow::pipeline{billow::cube_map{10}});
}

}  // namespace support
