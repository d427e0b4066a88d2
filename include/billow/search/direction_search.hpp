// Turning a plane to where it collects more: a pattern search over normals.
//
// Pattern search is R. Hooke, T. A. Jeeves: "Direct search" solution of numerical and statistical
// problems. Journal of the ACM, 1961. Its use here is ours: with the offset swept exactly, two
// dimensions are left, and a coarse raster of normals is enough to start from.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <billow/geometry/frame.hpp>
#include <billow/search/face_sets.hpp>
#include <billow/search/offset_sweep.hpp>

namespace billow::inline BILLOW_ABI {

struct direction_search_options {
    double first_step = 2.5 * std::numbers::pi / 180;  ///< radians; half of the raster's spacing
    double last_step = 0.15 * std::numbers::pi / 180;  ///< radians; the normal is as good as this
};

/// A normal with its best offset.
struct directed_plane {
    dvec3 normal{0, 0, 1};
    swept_offset at{};
};

/// Buffers of a search, to be used again.
struct direction_scratch {
    sweep_scratch sweep{};
    std::vector<std::int64_t> buckets{};
};

namespace detail {

/// The faces that may be valid for a plane whose normal is within a chord of that of `around`, and
/// whose offset is no farther from that of `around` than the plane's points inside the bounds move.
template <contribution<float> Contribution>
[[nodiscard]] face_table faces_within_reach(const face_table& faces, const directed_plane& around,
                                            double chord, double epsilon,
                                            const Contribution& worth) {
    const orientation_cell cell{.centre = vec3(around.normal), .chord = static_cast<float>(chord)};
    const double rho = static_cast<double>(around.at.rho);
    const double shift = chord * faces.bounds.radius;
    const parallel here{1};
    return select_rows(faces,
                       faces_valid_for_bin(faces, cell, rho - shift, rho + shift, epsilon,
                                           widened_centre{}, worth, here),
                       here);
}

}  // namespace detail

/// Tries six normals around the best one, closer and closer together, each with its best offset.
///
/// `weigh(normal)` is the weight of a normal, as in density_reading.
/// Needs   a start that has been swept.
/// Gives   a plane of at least the start's density. Of faces that come within reach by several long
///         moves in one direction some may go uncounted, so that it may be better than it says.
/// Cost    about 40 sweeps, of the faces within reach of the step at hand only.
template <class Sweep, contribution<float> Contribution, class Weigh>
[[nodiscard]] directed_plane search_directions(const Sweep& sweep, const face_table& faces,
                                               directed_plane best, double epsilon,
                                               const Contribution& worth, const Weigh& weigh,
                                               double charge,
                                               const direction_search_options& options,
                                               direction_scratch& scratch) {
    constexpr int most_moves = 2;  // a step; more come with the next one
    // What is charged lies up to an epsilon beyond what is valid.
    const double margin = charge != 0 ? 2 * epsilon : epsilon;
    face_table near;
    double turn = 0;
    for (double step = options.first_step; step >= options.last_step; step /= 2) {
        const double chord = 2 * std::sin((most_moves + 1) * step / 2);
        const bool is_first = step == options.first_step;
        near = detail::faces_within_reach(is_first ? faces : near, best, chord, margin, worth);
        const double rho = static_cast<double>(best.at.rho);
        const double reach = chord * faces.bounds.radius + epsilon / 16;
        const Sweep close = sweep.focused(rho - reach, rho + reach);
        for (int move = 0; move < most_moves; ++move) {
            const frame axes = frame_around(best.normal);
            directed_plane found = best;
            for (int k = 0; k < 6; ++k) {
                const double angle = turn + k * std::numbers::pi / 3;
                const dvec3 aside = axes.u * std::cos(angle) + axes.v * std::sin(angle);
                const dvec3 normal = glm::normalize(best.normal + aside * std::tan(step));
                const swept_offset at =
                    close.best(near, vec3(normal), {weigh(normal), charge}, found.at.density,
                               scratch.buckets, scratch.sweep);
                if (at.is_found) found = {normal, at};
            }
            if (found.normal == best.normal) break;
            best = found;
        }
        turn += std::numbers::pi / 6;
    }
    return best;
}

}  // namespace billow::inline BILLOW_ABI
