// Boxes: the plain one, and one with a picture on every side.
#pragma once

#include <string>
#include <utility>

#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// An axis-aligned box around the origin, every side cut into `segments` x `segments` squares.
///
/// Shape   6 sides in the order +x -x +y -y +z -z with 2 segments² faces each; the sides share no
///         vertices, so normals and uvs are exact. Every side covers uv [0, 1]², seen upright.
/// Needs   segments ≥ 1.
[[nodiscard]] inline mesh box(const vec3& size = vec3(1), int segments = 1) {
    BILLOW_ASSERT(segments >= 1);
    struct side {
        vec3 normal, right, up;
    };
    static constexpr side sides[] = {
        {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
        {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}}, {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
        {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}}};
    mesh out;
    for (const auto& [normal, right, up] : sides) {
        const auto first = static_cast<std::uint32_t>(out.vertex_count());
        const auto width = static_cast<std::uint32_t>(segments + 1);
        for (int i = 0; i <= segments; ++i) {
            for (int j = 0; j <= segments; ++j) {
                const vec2 uv(float(j) / float(segments), float(i) / float(segments));
                out.positions.push_back(
                    size * (0.5f * normal + (uv.x - 0.5f) * right + (0.5f - uv.y) * up));
                out.normals.push_back(normal);
                out.uv_sets[0].push_back(uv);
            }
        }
        for (std::uint32_t i = 0; i + 1 < width; ++i) {
            for (std::uint32_t j = 0; j + 1 < width; ++j) {
                const std::uint32_t a = first + i * width + j, c = a + width;
                out.triangles.emplace_back(a, c, c + 1);
                out.triangles.emplace_back(a, c + 1, a + 1);
            }
        }
    }
    return out;
}

/// A cube of edge 1 whose six sides carry six pictures of `size` x `size` texels, each in its own
/// image: quarters of the side's colour at four brightnesses, so a turned or mirrored side shows.
[[nodiscard]] inline mesh textured_cube(int size = 64) {
    static constexpr int colors[6][3] = {{230, 60, 50},  {60, 200, 220}, {80, 200, 70},
                                         {200, 70, 210}, {60, 90, 230},  {230, 200, 60}};
    mesh cube = box();
    for (material_id side = 0; side < 6; ++side) {
        image picture = image::filled(size, size, 4, 255);
        for (int y = 0; y < size; ++y) {
            for (int x = 0; x < size; ++x) {
                const int quarter = (2 * y >= size ? 2 : 0) + (2 * x >= size ? 1 : 0);
                for (std::size_t c = 0; c < 3; ++c) {
                    picture.pixel(x, y)[c] =
                        static_cast<std::uint8_t>(colors[side][c] * (4 - quarter) / 4);
                }
            }
        }
        cube.images.push_back(std::move(picture));
        cube.materials.push_back({.name = "side " + std::to_string(side),
                                  .base_color_texture = {.image = side,
                                                         .wrap_u = texture_wrap::clamp_to_edge,
                                                         .wrap_v = texture_wrap::clamp_to_edge},
                                  .metallic = 0});
        cube.face_materials.insert(cube.face_materials.end(), 2, side);
    }
    return cube;
}

}  // namespace billow::inline BILLOW_ABI
