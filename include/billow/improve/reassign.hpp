// Each face to the plane it is most tangent to, each plane to its faces: Lloyd's iteration, within
// epsilon.
//
// S. P. Lloyd: Least squares quantization in PCM. IEEE Transactions on Information Theory 28, 1982;
// for planes: D. Cohen-Steiner, P. Alliez, M. Desbrun: Variational shape approximation. SIGGRAPH 2004.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/fit/average.hpp>
#include <billow/improve/joint_plane.hpp>
#include <billow/improve/plane_cover.hpp>
#include <billow/search/leftovers.hpp>

namespace billow::inline BILLOW_ABI {

/// For each row the plane that it is most tangent to, of those that may take it: by |cosine|, then
/// by the farthest corner's distance, then by id; no_id where none may. Cost O(sum of valid rows).
[[nodiscard]] inline std::vector<plane_id> most_tangent_planes(const plane_cover& cover) {
    const face_table& faces = cover.faces();
    std::vector<plane_id> best(faces.size, no_id);
    std::vector<double> cosine(faces.size, -1);
    for (plane_id id = 0; id < cover.plane_count(); ++id) {
        const plane& p = cover.planes()[id];
        for (const std::uint32_t row : cover.valid(id)) {
            const double c = std::abs(glm::dot(p.normal, faces.normal.get(row)));
            const bool is_better =
                c > cosine[row] ||
                (c == cosine[row] &&
                 distances_to(p, faces, row).largest <
                     distances_to(cover.planes()[best[row]], faces, row).largest);
            if (is_better) cosine[row] = c, best[row] = id;
        }
    }
    return best;
}

/// What the rows look like on their planes: the sum of area · |cosine|, and of area · distance to
/// the farthest corner. The first counts; where it is equal, the second.
struct tangency {
    double projected_area = 0;
    double distance_area = 0;
};

[[nodiscard]] inline tangency tangency_of(const face_table& faces,
                                          std::span<const std::uint32_t> rows,
                                          const plane& p) noexcept {
    tangency sum{.projected_area = projected_area_of(faces, rows, p.normal)};
    for (const std::uint32_t row : rows) {
        sum.distance_area +=
            static_cast<double>(faces.area[row]) * distances_to(p, faces, row).largest;
    }
    return sum;
}

namespace detail {

/// A plane for `rows` that shows them better than `p` and is within epsilon of all: what `fit`
/// proposes, or as near to it as epsilon and tangency allow; else `p`.
template <plane_fitter Fitter>
[[nodiscard]] plane refitted(const face_table& faces, const face_rows& rows, const plane& p,
                             const Fitter& fit, double epsilon) {
    static constexpr double least_gain = 1e-4;
    const face_table own = select_rows(faces, rows, parallel{1});
    plane goal = fit(own, p);
    if (glm::dot(goal.normal, p.normal) < 0) goal = {-goal.normal, -goal.rho};
    dvec3 through{0};  // where the proposed plane passes the middle of the faces
    double area = 0;
    for (std::size_t row = 0; row < own.size; ++row) {
        through += own.centroid(row) * double(own.area[row]);
        area += double(own.area[row]);
    }
    if (!(area > 0)) return p;
    through /= area;
    through -= goal.normal * signed_distance(goal, through);

    const tangency before = tangency_of(faces, rows, p);
    for (const double step : {1.0, 0.5, 0.25, 0.125, 0.0}) {
        const dvec3 normal = glm::normalize(p.normal + (goal.normal - p.normal) * step);
        const face_extent_along extent = extent_along(faces, rows, normal);
        const double low = extent.high - epsilon;
        const double high = extent.low + epsilon;
        if (low > high) continue;
        const plane moved = canonical({normal, std::clamp(glm::dot(normal, through), low, high)});
        const tangency after = tangency_of(faces, rows, moved);
        const double gain = after.projected_area - before.projected_area;
        const double nearer = before.distance_area - after.distance_area;
        if (gain > least_gain * before.projected_area ||
            (gain >= 0 && nearer > least_gain * area * epsilon)) {
            return moved;
        }
    }
    return p;
}

}  // namespace detail

/// What reassigning did.
struct reassign_statistics {
    std::size_t rounds = 0;
    std::size_t refits = 0;  ///< planes that moved, counted once a round
};

/// Assigns each face to the valid plane that it is most tangent to, then moves each plane to its
/// faces, until nothing changes or for `rounds` rounds.
///
/// Every step raises the projected area, the sum over the faces of area · |cosine|, or leaves it
/// and lowers their distance; a refit must gain a ten-thousandth of its plane's at least, so it ends.
///
/// Gives   planes, on which most_tangent_planes then sees the faces. None is beyond epsilon.
/// Cost    O(faces) for the fits and O(faces · planes that move), each round; parallel.
/// Source  Lloyd 1982, Cohen-Steiner et al. 2004. Differs: only valid planes are asked, and a fit
///         that would leave epsilon is followed as far as it does not.
template <plane_fitter Fitter = average_fit>
reassign_statistics reassign_faces(plane_cover& cover, std::size_t rounds, const Fitter& fit = {},
                                   parallel threads = {}) {
    const face_table& faces = cover.faces();
    reassign_statistics told;
    while (told.rounds < rounds) {
        ++told.rounds;
        const std::vector<plane_id> home = most_tangent_planes(cover);
        const auto count = cover.plane_count();
        std::vector<face_rows> own(count);
        for (std::uint32_t row = 0; row < home.size(); ++row) {
            if (home[row] != no_id) own[home[row]].push_back(row);
        }
        std::vector<plane> moved = cover.planes();
        threads.for_chunks(count, 1, [&](std::size_t id, std::size_t) {
            if (!own[id].empty()) {
                moved[id] = detail::refitted(faces, own[id], moved[id], fit, cover.exact_epsilon());
            }
        });
        std::size_t refits = 0;
        for (plane_id id = 0; id < count; ++id) {
            if (moved[id] == cover.planes()[id]) continue;
            face_rows rows = cover.rows_for(moved[id]);
            if (!std::ranges::includes(rows, own[id])) continue;  // by the rounding of floats
            cover.move(id, moved[id], std::move(rows));
            ++refits;
        }
        told.refits += refits;
        if (refits == 0) break;
    }
    return told;
}

}  // namespace billow::inline BILLOW_ABI
