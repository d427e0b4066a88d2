// Loose leaves in a ball: foliage at its hardest, with no structure that a search could use.
#pragma once

#include <cmath>

#include <billow/core/random.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

struct leaf_soup_options {
    float edge = 0.05f;      ///< edge of a leaf; the ball has radius 1
    std::uint64_t seed = 1;  ///< other seeds, other soups
};

/// Square leaves whose centres are uniform in the unit ball, each turned at random.
///
/// Shape   `face_count` faces, two a leaf; an odd count leaves the last leaf half. Every leaf owns
///         its four vertices and covers uv [0, 1]².
[[nodiscard]] inline mesh leaf_soup(std::size_t face_count, const leaf_soup_options& options = {}) {
    constexpr double tau = 6.283185307179586;
    mesh soup;
    const std::size_t leaf_count = (face_count + 1) / 2;
    soup.positions.reserve(4 * leaf_count);
    soup.triangles.reserve(2 * leaf_count);
    random_stream random(options.seed);
    const auto direction = [&] {
        const double z = random.between(-1, 1), angle = random.between(0, tau);
        const double r = std::sqrt(1 - z * z);
        return dvec3(r * std::cos(angle), r * std::sin(angle), z);
    };
    for (std::size_t leaf = 0; leaf < leaf_count; ++leaf) {
        const dvec3 towards = direction();
        const dvec3 centre = towards * std::cbrt(random.unit());
        const frame around = frame_around(direction());
        const double turn = random.between(0, tau), half = 0.5 * double(options.edge);
        const dvec3 right = (around.u * std::cos(turn) + around.v * std::sin(turn)) * half;
        const dvec3 up = (around.v * std::cos(turn) - around.u * std::sin(turn)) * half;
        const auto first = static_cast<std::uint32_t>(soup.vertex_count());
        for (const dvec2& corner : {dvec2(-1, -1), dvec2(1, -1), dvec2(1, 1), dvec2(-1, 1)}) {
            soup.positions.emplace_back(centre + corner.x * right + corner.y * up);
            soup.normals.emplace_back(around.normal);
            soup.uv_sets[0].emplace_back(0.5 + 0.5 * corner.x, 0.5 - 0.5 * corner.y);
        }
        soup.triangles.emplace_back(first, first + 1, first + 2);
        soup.triangles.emplace_back(first, first + 2, first + 3);
    }
    soup.triangles.resize(face_count);
    soup.materials = {{.name = "leaf",
                       .base_color = {0.15f, 0.35f, 0.08f, 1},
                       .metallic = 0,
                       .is_double_sided = true}};
    return soup;
}

}  // namespace billow::inline BILLOW_ABI
