// Bark and leaves, drawn by formula: the same bytes for the same seed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <billow/core/random.hpp>
#include <billow/image/image.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Gradient noise in about [-0.7, 0.7] that repeats after `period` lattice cells.
///
/// Source  Perlin, "An image synthesizer", 1985; the smoothstep of 2002.
[[nodiscard]] inline double tiling_noise(double x, double y, int period_x, int period_y,
                                         std::uint64_t seed) noexcept {
    static constexpr double d = 0.70710678118654752;
    static constexpr double directions[8][2] = {{1, 0},  {d, d},   {0, 1},  {-d, d},
                                                {-1, 0}, {-d, -d}, {0, -1}, {d, -d}};
    const double cell_x = std::floor(x), cell_y = std::floor(y);
    const auto corner = [&](int dx, int dy) {
        const auto wrap = [](int i, int period) { return (i % period + period) % period; };
        const int i = wrap(int(cell_x) + dx, period_x), j = wrap(int(cell_y) + dy, period_y);
        const auto bits = mix_bits(mix_bits(seed) ^ static_cast<std::uint64_t>(j * period_x + i));
        const auto& direction = directions[bits >> 61];
        return direction[0] * (x - cell_x - dx) + direction[1] * (y - cell_y - dy);
    };
    const auto smooth = [](double t) { return t * t * t * (t * (6 * t - 15) + 10); };
    const double s = smooth(x - cell_x), t = smooth(y - cell_y);
    return std::lerp(std::lerp(corner(0, 0), corner(1, 0), s),
                     std::lerp(corner(0, 1), corner(1, 1), s), t);
}

/// Blends two colours of bytes.
[[nodiscard]] inline vec3 blend(const vec3& a, const vec3& b, double share) noexcept {
    return glm::mix(a, b, static_cast<float>(std::clamp(share, 0.0, 1.0)));
}

}  // namespace detail

struct bark_image_options {
    int size = 256;                    ///< width and height, in texels
    vec3 ridge{0.52f, 0.45f, 0.37f};   ///< sRGB of the ridges
    vec3 furrow{0.16f, 0.12f, 0.09f};  ///< sRGB between them
    int ridges = 7;                    ///< from left to right
    int plates = 3;                    ///< from top to bottom: long ridges for few, plates for many
    std::uint64_t seed = 1;
};

/// Bark: ridges of folded noise, stretched along the stem. It tiles both ways.
[[nodiscard]] inline image bark_image(const bark_image_options& options = {}) {
    image bark = image::filled(options.size, options.size, 4, 255);
    for (int y = 0; y < options.size; ++y) {
        for (int x = 0; x < options.size; ++x) {
            const double u = (x + 0.5) / options.size, v = (y + 0.5) / options.size;
            // Furrows wind: the noise is read at a place moved by a slower noise.
            const double bend = 0.09 * detail::tiling_noise(3 * u, 3 * v, 3, 3, options.seed);
            double height = 0, weight = 0.62, total = 0;
            for (int octave = 0; octave < 4; ++octave) {
                const int nx = options.ridges << octave, ny = options.plates << octave;
                const double n =
                    detail::tiling_noise((u + bend) * nx, (v + bend) * ny, nx, ny,
                                         options.seed + 1 + static_cast<std::uint64_t>(octave));
                // Folded noise: its zeros are the furrows.
                height += weight * std::min(1.0, 2.6 * std::abs(n));
                total += weight;
                weight *= 0.45;
            }
            const double stain = detail::tiling_noise(4 * u, 2 * v, 4, 2, options.seed + 9);
            const vec3 color = detail::blend(options.furrow, options.ridge, height / total) *
                               static_cast<float>(1 + 0.35 * stain);
            for (int c = 0; c < 3; ++c) {
                bark.pixel(x, y)[c] = byte_from_unit(color[c]);
            }
        }
    }
    return bark;
}

struct leaf_image_options {
    int size = 512;                   ///< width and height, in texels
    unsigned variants = 2;            ///< variants x variants pictures with other leaves and hues
    unsigned leaves = 9;              ///< on the twig of a picture; 1: a single leaf
    double slenderness = 2.1;         ///< length of a leaf over its width
    vec3 young{0.46f, 0.60f, 0.20f};  ///< sRGB of the brightest leaf
    vec3 old{0.20f, 0.36f, 0.10f};    ///< sRGB of the darkest one
    vec3 twig{0.33f, 0.25f, 0.16f};   ///< sRGB
    std::uint64_t seed = 1;
};

namespace detail {

/// A leaf of a picture: its foot, its direction, its length and a shade. Plane (x, y) with y up,
/// the picture being [0, 1]².
struct drawn_leaf {
    dvec2 foot, axis;
    double length = 0;
    double shade = 0;  ///< 0 old to 1 young
};

/// A twig from the middle of the lower edge, its leaves alternating to both sides and one in front.
[[nodiscard]] inline std::vector<drawn_leaf> arrange_leaves(const leaf_image_options& options,
                                                            std::uint64_t seed) {
    if (options.leaves <= 1) return {{{0.5, 0.06}, {0, 1}, 0.9, random_unit(seed, 0)}};
    std::vector<drawn_leaf> leaves;
    random_stream random(seed);
    const unsigned side_count = options.leaves - 1;
    for (unsigned k = 0; k < side_count; ++k) {
        const double up = (k + 0.5) / side_count;
        const double angle = (1.15 - 0.55 * up) * random.between(0.85, 1.15);
        const double side = k % 2 == 0 ? 1 : -1;
        leaves.push_back({.foot = {0.5, 0.1 + 0.5 * up},
                          .axis = {side * std::sin(angle), std::cos(angle)},
                          .length = random.between(0.36, 0.44) * (1.05 - 0.25 * up),
                          .shade = random.between(0.1, 0.7) + 0.3 * up});
    }
    leaves.push_back({.foot = {0.5, 0.6},
                      .axis = {0, 1},
                      .length = random.between(0.34, 0.38),
                      .shade = random.between(0.5, 1)});
    return leaves;
}

/// Whether `point` lies on the leaf, and then its colour: midrib, side veins, a darker rim.
[[nodiscard]] inline bool shade_leaf(const drawn_leaf& leaf, const leaf_image_options& options,
                                     const dvec2& point, vec3& color) noexcept {
    const dvec2 offset = (point - leaf.foot) / leaf.length;
    const double along = glm::dot(offset, leaf.axis);
    const double across = leaf.axis.x * offset.y - leaf.axis.y * offset.x;
    const double side = std::abs(across);
    if (along < 0 || along > 1 || side > 0.6 / options.slenderness) return false;
    const double stalk = 0.12;
    const double t = (along - stalk) / (1 - stalk);  // 0 at the blade's foot, 1 at its tip
    const double teeth = 1 + 0.06 * (std::abs(std::fmod(along * 14, 1.0) - 0.5) - 0.25);
    // Widest below the middle, rounded at the foot, drawn out at the tip.
    const double half_width =
        t <= 0 ? 0 : std::sqrt(t) * (1 - t) * (1.3 + 0.9 * t) * teeth / (1.2 * options.slenderness);
    const double rib = 0.016 * (1.3 - along);
    if (side > std::max(half_width, rib)) return false;
    const vec3 blade = blend(options.old, options.young, leaf.shade);
    if (side < rib) {
        color = blend(blade, options.young * 1.25f, 0.7);
        return true;
    }
    const double edge = side / half_width;
    const double vein = std::abs(std::fmod(along * 9 - side * 6 + 9, 1.0) - 0.5);  // 0.5: on it
    color = blade * static_cast<float>((across > 0 ? 1.06 : 0.94) * (1.05 - 0.2 * edge * edge));
    if (vein > 0.42) color = blend(color, options.young * 1.15f, 0.45 * (1 - edge));
    return true;
}

}  // namespace detail

/// Pictures of leaves on their twigs, or of single leaves, side by side; all stand on the middle
/// of their lower edge. Alpha is the covered share of a texel; texels without a leaf carry the mean
/// leaf colour, so that filters find no foreign colour at the rims.
[[nodiscard]] inline image leaf_image(const leaf_image_options& options = {}) {
    constexpr int grid = 4;  // samples along a texel's side
    image leaves = image::filled(options.size, options.size, 4, 0);
    const int cell_size = options.size / static_cast<int>(options.variants);
    dvec3 sum{0};
    double covered = 0;
    for (unsigned cell = 0; cell < options.variants * options.variants; ++cell) {
        const auto twig = detail::arrange_leaves(options, mix_bits(options.seed) + cell);
        const int left = static_cast<int>(cell % options.variants) * cell_size;
        const int top = static_cast<int>(cell / options.variants) * cell_size;
        for (int y = 0; y < cell_size; ++y) {
            for (int x = 0; x < cell_size; ++x) {
                vec3 total{0};
                int hits = 0;
                for (int s = 0; s < grid * grid; ++s) {
                    const int column = s % grid;
                    const int row = s / grid;
                    const dvec2 point((x + (column + 0.5) / grid) / cell_size,
                                      1 - (y + (row + 0.5) / grid) / cell_size);
                    vec3 color{0};
                    bool is_hit = false;
                    for (std::size_t k = twig.size(); k-- > 0 && !is_hit;) {  // the last is on top
                        is_hit = detail::shade_leaf(twig[k], options, point, color);
                    }
                    if (!is_hit && options.leaves > 1 && point.y < 0.62 &&
                        std::abs(point.x - 0.5) < 0.011 * (1.2 - point.y)) {
                        color = options.twig;
                        is_hit = true;
                    }
                    if (!is_hit) continue;
                    total += color;
                    ++hits;
                }
                if (hits == 0) continue;
                total /= float(hits);
                sum += dvec3(total) * double(hits);
                covered += hits;
                std::uint8_t* texel = leaves.pixel(left + x, top + y);
                for (int c = 0; c < 3; ++c) texel[c] = byte_from_unit(total[c]);
                texel[3] = byte_from_unit(float(hits) / float(grid * grid));
            }
        }
    }
    const vec3 mean = covered > 0 ? vec3(sum / covered) : options.old;
    for (int y = 0; y < options.size; ++y) {
        for (int x = 0; x < options.size; ++x) {
            std::uint8_t* texel = leaves.pixel(x, y);
            if (texel[3] != 0) continue;
            for (int c = 0; c < 3; ++c) texel[c] = byte_from_unit(mean[c]);
        }
    }
    return leaves;
}

}  // namespace billow::inline BILLOW_ABI
