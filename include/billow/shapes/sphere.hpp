// Spheres.
#pragma once

#include <algorithm>
#include <map>
#include <utility>

#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// The unit sphere as an icosahedron whose faces were cut in four `levels` times: nearly equal
/// triangles, closed, no seam, normals but no uvs.
///
/// Shape   20 · 4^levels faces, 10 · 4^levels + 2 vertices.
[[nodiscard]] inline mesh icosphere(unsigned levels) {
    constexpr float g = 1.618033989f;  // the golden ratio
    mesh ball;
    ball.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                      {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (vec3& p : ball.positions) p = glm::normalize(p);
    ball.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                      {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                      {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                      {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (unsigned level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [place, is_new] = middles.try_emplace(
                std::minmax(a, b), static_cast<std::uint32_t>(ball.vertex_count()));
            if (is_new) {
                ball.positions.push_back(glm::normalize(ball.positions[a] + ball.positions[b]));
            }
            return place->second;
        };
        std::vector<uvec3> finer;
        finer.reserve(4 * ball.face_count());
        for (const uvec3& t : ball.triangles) {
            const uvec3 m(middle(t.y, t.z), middle(t.z, t.x), middle(t.x, t.y));
            finer.insert(finer.end(), {{t.x, m.z, m.y}, {m.z, t.y, m.x}, {m.y, m.x, t.z}, m});
        }
        ball.triangles = std::move(finer);
    }
    ball.normals = ball.positions;
    return ball;
}

}  // namespace billow::inline BILLOW_ABI
