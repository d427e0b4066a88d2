// Leaves: textured quads around the leaf sites of a skeleton.
//
// The quad stands for a leaf, or for a small twig with several; see leaf_image.
#pragma once

#include <cmath>

#include <billow/core/random.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/plants/skeleton.hpp>

namespace billow::inline BILLOW_ABI {

struct leaf_options {
    double per_site = 4;        ///< mean number of quads at a leaf site, whole or not
    double length = 0.3;        ///< of a quad, in scene units
    double aspect = 1;          ///< width of a quad over its length
    double size_jitter = 0.2;   ///< quads differ by up to this share of their size
    double spread_deg = 55;     ///< angle between the twig and its leaves, but the one at the end
    double turn_deg = 137.508;  ///< from one leaf to the next around the twig: the golden angle
    double along = 0.7;         ///< share of the last segment that carries leaves
    double tilt = 0.5;          ///< 0: quads look at the sky, as far as they can; 1: anywhere
    double lift = 0.15;         ///< how far leaves rise towards the light; below 0 they hang
    unsigned variants = 2;      ///< the image holds variants x variants pictures
};

/// How many quads the k-th of all sites gets, so that after n sites there are floor(n · per_site).
[[nodiscard]] inline std::size_t leaves_at_site(std::size_t k, double per_site) noexcept {
    return static_cast<std::size_t>(std::floor(double(k + 1) * per_site) -
                                    std::floor(double(k) * per_site));
}

/// Adds the leaves of every site. The middle of a quad's lower edge lies on the axis of the site's
/// segment, so no leaf floats.
///
/// Shape   floor(leaf_count · per_site) quads of two faces and four vertices; adds to positions,
///         normals, uv set 0, triangles and face_materials.
/// Needs   length, aspect > 0; size_jitter < 1; variants ≥ 1.
inline void add_leaves(mesh& out, const skeleton& bones, const leaf_options& options = {},
                       material_id material = 0, std::uint64_t seed = 1) {
    BILLOW_ASSERT(options.length > 0 && options.aspect > 0 && options.variants >= 1);
    constexpr double radian = 3.14159265358979323846 / 180;
    for (std::size_t site = 0; site < bones.leaf_count(); ++site) {
        const std::uint32_t segment = bones.leaf_segments[site];
        const frame& axes = bones.leaf_frames[site];
        const std::size_t count = leaves_at_site(site, options.per_site);
        random_stream random(mix_bits(seed) + site);
        const double first_turn = random.between(0, 360);
        for (std::size_t k = 0; k < count; ++k) {
            const double share = (double(k) + (k == 0 ? 0 : random.between(-0.4, 0.4))) /
                                 double(count) * options.along;
            const dvec3 base = glm::mix(bones.ends[segment], bones.starts[segment], share);
            const double turn = radian * (first_turn + double(k) * options.turn_deg);
            const double spread = radian * options.spread_deg *
                                  (k == 0 ? random.between(0, 0.4) : random.between(0.75, 1.25));
            const dvec3 sideways = axes.u * std::cos(turn) + axes.v * std::sin(turn);
            const dvec3 up =
                glm::normalize(axes.normal * std::cos(spread) + sideways * std::sin(spread) +
                               dvec3(0, options.lift, 0));
            // What the quad looks at: the sky and something random, across its own direction.
            const dvec3 random_look(random.between(-1, 1), random.between(-1, 1),
                                    random.between(-1, 1));
            dvec3 look = glm::mix(dvec3(0, 1, 0), random_look, options.tilt);
            look -= up * glm::dot(up, look);
            const double look_length = glm::length(look);
            const dvec3 normal = look_length > 1e-3 ? look / look_length : frame_around(up).u;
            const double length = options.length * double(bones.leaf_scales[site]) *
                                  (1 + options.size_jitter * random.between(-1, 1));
            const dvec3 across = glm::cross(up, normal) * (0.5 * options.aspect * length);

            const auto cells = options.variants;
            const auto cell = static_cast<unsigned>(random.between(0, double(cells * cells)));
            const unsigned column = cell % cells;
            const unsigned row = cell / cells;
            const vec2 corner{float(column), float(row)};
            const auto first = static_cast<std::uint32_t>(out.vertex_count());
            for (const vec2& q : {vec2(0, 1), vec2(1, 1), vec2(1, 0), vec2(0, 0)}) {
                out.positions.emplace_back(base + across * double(2 * q.x - 1) +
                                           up * (length * double(1 - q.y)));
                out.normals.emplace_back(normal);
                out.uv_sets[0].push_back((corner + q) / float(cells));
            }
            out.triangles.emplace_back(first, first + 1, first + 2);
            out.triangles.emplace_back(first, first + 2, first + 3);
            out.face_materials.insert(out.face_materials.end(), 2, material);
        }
    }
}

}  // namespace billow::inline BILLOW_ABI
