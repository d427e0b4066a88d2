// How much of the sky each leaf and vertex sees, and where: rays against the mesh itself.
//
// Fuhrmann et al.: Extreme model simplification for forest rendering. Eurographics Workshop on
// Natural Phenomena 2005, section 3.3.9; after Landis: Production-ready global illumination.
// SIGGRAPH course notes 2002.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <billow/bake/sky_sites.hpp>
#include <billow/bake/sky_table.hpp>
#include <billow/bake/surface.hpp>
#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/random.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/geometry/ray_tree.hpp>
#include <billow/mesh/face_table.hpp>

namespace billow::inline BILLOW_ABI {

struct occlusion_options {
    int rays = 64;             ///< a leaf or vertex; noise is about 0.4 / √rays
    double reach = 0;          ///< what is farther away hides nothing, in radii; 0: everything does
    double strength = 1;       ///< 0: nothing is darkened, 1: as measured
    double leaf_extent = 0.2;  ///< largest diameter of a leaf, in radii; 0: no leaves
    /// Where the sky is: within 90° of it. 0: all around, since an occlusion map tells what the model
    /// itself hides, and the renderer's light what the ground does.
    vec3 sky_up{0};
    std::uint64_t seed = 1;
};

namespace detail {

/// Sums over rays.
struct sky_sum {
    double weight = 0;   ///< of cosines
    double open = 0;     ///< of cosines of rays that see the sky
    double visible = 0;  ///< rays that see the sky
    double sphere = 0;   ///< rays that the whole sphere would have got
    dvec3 sum{0};        ///< of the directions that see the sky

    void add(const sky_sum& other) noexcept {
        weight += other.weight;
        open += other.open;
        visible += other.visible;
        sphere += other.sphere;
        sum += other.sum;
    }
    [[nodiscard]] sky_view view() const noexcept {
        if (!(weight > 0)) return {};
        return {.open = static_cast<float>(open / weight),
                .visible = vec4(vec3(sum / sphere), static_cast<float>(visible / sphere))};
    }
};

/// One call of see_sky.
class sky_measurer {
public:
    sky_measurer(const surface& look, const face_table& faces, const occlusion_options& options,
                 parallel threads)
        : look_(look),
          faces_(faces),
          options_(options),
          threads_(threads),
          sites_(find_sky_sites(look.source(), faces, options.leaf_extent * faces.bounds.radius,
                                options.rays)),
          tree_(faces.size, [&](std::uint32_t row) {
              return std::array{vec3(faces.corner[0].get(row)), vec3(faces.corner[1].get(row)),
                                vec3(faces.corner[2].get(row))};
          }) {
        near_ = static_cast<float>(1e-5 * faces.bounds.radius);
        if (options.reach > 0) far_ = static_cast<float>(options.reach * faces.bounds.radius);
        for (int i = 0; i < options.rays; ++i) {
            const double angle = 2 * std::numbers::pi * fraction(i * golden);
            turns_.emplace_back(std::cos(angle), std::sin(angle));
        }
    }

    [[nodiscard]] sky_table run() {
        std::vector<std::array<sky_sum, 3>> sums(sites_.patches.size());
        threads_.for_chunks(sums.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) sums[i] = measure(i);
        });
        std::vector<sky_sum> of_site(sites_.count);
        for (std::size_t i = 0; i < sums.size(); ++i) {
            const sky_patch& patch = sites_.patches[i];
            const uvec3 at = sites_.of_face[faces_.source[sites_.rows[patch.first]]];
            for (int k = 0; k < (patch.is_leaf ? 1 : 3); ++k) {
                of_site[at[k]].add(sums[i][static_cast<std::size_t>(k)]);
            }
        }
        sky_table table;
        for (const sky_sum& sum : of_site) {
            sky_view view = sum.view();
            view.open = static_cast<float>(1 - options_.strength * (1 - view.open));
            table.views.push_back(view);
        }
        table.of_face = std::move(sites_.of_face);
        return table;
    }

private:
    // Steps of sequences that fill an interval and a square evenly. The latter is Roberts' R2.
    static constexpr double golden = 0.6180339887498949;
    static constexpr dvec2 plastic{0.7548776662466927, 0.5698402909980532};

    [[nodiscard]] static double fraction(double x) noexcept { return x - std::floor(x); }

    /// The sums of the patch's corners; a leaf has only the first.
    [[nodiscard]] std::array<sky_sum, 3> measure(std::size_t id) const noexcept {
        const sky_patch& patch = sites_.patches[id];
        const face_id face = faces_.source[sites_.rows[patch.first]];
        const material& look = look_.material_of(face);
        if (is_foliage(look)) return cast(patch, 0);
        std::array<sky_sum, 3> front = cast(patch, 1);
        if (!look.is_double_sided) return front;
        // The side that the light reaches: of a body the outside, whichever way its faces turn.
        const std::array<sky_sum, 3> back = cast(patch, -1);
        const auto visible = [](const std::array<sky_sum, 3>& of) {
            return of[0].visible + of[1].visible + of[2].visible;
        };
        return visible(back) > visible(front) ? back : front;
    }

    /// Rays over the half of the sphere on one `side`, ±1, or over all of it, 0.
    [[nodiscard]] std::array<sky_sum, 3> cast(const sky_patch& patch, int side) const noexcept {
        std::array<sky_sum, 3> sums{};
        random_stream random(mix_bits(options_.seed) ^
                             mix_bits(patch.first * 3u + static_cast<unsigned>(side + 1)));
        const double lift = random.unit();
        const double angle = 2 * std::numbers::pi * random.unit();
        const dvec2 turn(std::cos(angle), std::sin(angle));
        const dvec2 shift(random.unit(), random.unit());
        double area = 0;
        for (std::uint32_t i = 0; i < patch.count; ++i) area += faces_.area[row_of(patch, i)];
        for (int i = 0; i < patch.rays; ++i) {
            dvec2 at(fraction(i * plastic.x + shift.x), fraction(i * plastic.y + shift.y));
            const std::uint32_t row = pick_face(patch, at.x, area);
            if (at.x + at.y > 1) at = 1.0 - at;
            const dvec3 weights(1 - at.x - at.y, at.x, at.y);
            const dvec3 point = faces_.corner[0].get(row) * weights.x +
                                faces_.corner[1].get(row) * weights.y +
                                faces_.corner[2].get(row) * weights.z;

            const double height = fraction((i + 0.5) / patch.rays + lift);
            const double z = side == 0 ? 2 * height - 1 : side * height;
            const double r = std::sqrt(std::max(0.0, 1 - z * z));
            const dvec2 t = turns_[static_cast<std::size_t>(i)];
            const frame axes = frame_around(faces_.normal.get(row));
            const dvec3 direction = axes.to_scene(
                {r * (t.x * turn.x - t.y * turn.y), r * (t.x * turn.y + t.y * turn.x), z});
            const bool is_visible = sees_sky(row, point, direction,
                                             mix_bits(patch.first) + static_cast<std::uint64_t>(i));
            for (int k = 0; k < (patch.is_leaf ? 1 : 3); ++k) {
                const double share = patch.is_leaf ? 1 : weights[k];
                sky_sum& sum = sums[static_cast<std::size_t>(k)];
                sum.weight += share * std::abs(z);
                sum.sphere += share * (side == 0 ? 1 : 2);
                if (!is_visible) continue;
                sum.open += share * std::abs(z);
                sum.visible += share;
                sum.sum += direction * share;
            }
        }
        return sums;
    }

    [[nodiscard]] std::uint32_t row_of(const sky_patch& patch, std::uint32_t i) const noexcept {
        return sites_.rows[patch.first + i];
    }

    /// The row that the share `at` of the patch's area falls on; `at` becomes the share within it.
    [[nodiscard]] std::uint32_t pick_face(const sky_patch& patch, double& at,
                                          double area) const noexcept {
        double left = at * area;
        std::uint32_t i = 0;
        while (i + 1 < patch.count && left >= faces_.area[row_of(patch, i)]) {
            left -= faces_.area[row_of(patch, i++)];
        }
        const std::uint32_t row = row_of(patch, i);
        at = std::clamp(left / faces_.area[row], 0.0, 1.0);
        return row;
    }

    [[nodiscard]] bool sees_sky(std::uint32_t row, const dvec3& point, const dvec3& direction,
                                std::uint64_t key) const noexcept {
        const vec3 toward(direction);
        if (glm::dot(toward, options_.sky_up) < 0) return false;
        return !tree_.is_blocked({vec3(point), toward, near_, far_},
                                 [&](std::uint32_t other, float b, float c) {
                                     return other != row && is_there(other, b, c, key);
                                 });
    }

    /// Whether the point of a face is there for the ray `key`: all of one ray see the same holes.
    [[nodiscard]] bool is_there(std::uint32_t row, float b, float c,
                                std::uint64_t key) const noexcept {
        constexpr double samples =
            256;  // a face's alpha as it looks from afar: its image stays near
        const face_cover cover = look_.cover_of(faces_.source[row], samples);
        if (cover.decides == face_cover::rule::always) return true;
        const auto mixed = [&](const auto& at) {
            return at[0] * (1 - b - c) + at[1] * b + at[2] * c;
        };
        float alpha = cover.factor;
        if (cover.has_vertex_alpha) alpha *= mixed(cover.vertex_alpha);
        if (cover.alpha != nullptr) {
            alpha *= sample_alpha(*cover.alpha, *cover.map, mixed(cover.uvs), cover.is_nearest);
        }
        if (cover.decides == face_cover::rule::cutoff) return alpha >= cover.cutoff;
        return static_cast<double>(alpha) > random_unit(key, row);
    }

    const surface& look_;
    const face_table& faces_;
    const occlusion_options& options_;
    parallel threads_;
    sky_sites sites_;
    ray_tree tree_;
    float near_ = 0;
    float far_ = std::numeric_limits<float>::infinity();
    std::vector<dvec2> turns_{};
};

}  // namespace detail

/// Measures which share of the sky the leaves and vertices of a mesh see past its own faces. Rays go
/// out evenly, from points spread over the faces. Alpha is looked at, so light falls through holes.
///
/// - Foliage: the mean over both sides, as light that falls on one shines through to the other.
/// - Other faces: their front; where they are double-sided the side that sees more, so that the
///   inside of a closed body does not count.
///
/// A leaf has one value, everything else one a vertex (see find_sky_sites).
///
/// Needs  `faces` is the table of look.source(); rays ≥ 1.
/// Gives  the same for any number of threads.
/// Cost   O(rays × (leaves + vertices) × log faces), parallel.
/// Source Fuhrmann et al. 2005, section 3.3.9. Differs: `open` is weighted by the cosine, as the
///        occlusion of glTF means it; sky_view::visible.w is their percentage.
[[nodiscard]] inline sky_table see_sky(const surface& look, const face_table& faces,
                                       const occlusion_options& options = {},
                                       parallel threads = {}) {
    BILLOW_ASSERT(options.rays >= 1 && options.leaf_extent >= 0 && options.reach >= 0);
    return detail::sky_measurer(look, faces, options, threads).run();
}

}  // namespace billow::inline BILLOW_ABI
