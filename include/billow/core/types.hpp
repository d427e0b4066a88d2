// The words that every layer shares: vectors and ids.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <billow/core/config.hpp>

namespace billow::inline BILLOW_ABI {

using vec2 = glm::vec2;
using vec3 = glm::vec3;
using vec4 = glm::vec4;
using dvec2 = glm::dvec2;
using dvec3 = glm::dvec3;
using uvec3 = glm::uvec3;
using ivec2 = glm::ivec2;
using mat3 = glm::mat3;

using face_id = std::uint32_t;         ///< row of mesh::triangles
using plane_id = std::uint32_t;        ///< row of billboard_cloud::planes, in the order of discovery
using orientation_id = std::uint32_t;  ///< one normal of a plane space
using material_id = std::uint32_t;     ///< row of mesh::materials
using image_id = std::uint32_t;        ///< row of mesh::images
using atlas_id = std::uint32_t;        ///< row of baked_cloud::atlases
using part_id = std::uint32_t;         ///< row of billboard_cloud::parts

/// Says "none" for every kind of id.
inline constexpr std::uint32_t no_id = std::numeric_limits<std::uint32_t>::max();

}  // namespace billow::inline BILLOW_ABI
