// A plane for a bin that refinement found none in.
//
// Fuhrmann et al. 2005, section 3.3.2; Luksch 2009, section 3.2.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/fit/average.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/policy/contribution.hpp>
#include <billow/search/face_sets.hpp>

namespace billow::inline BILLOW_ABI {

/// The row of most area; among equals the first. Needs a face.
[[nodiscard]] inline std::uint32_t largest_face(const face_table& faces) {
    const auto largest = std::max_element(faces.area.begin(), faces.area.end());
    return static_cast<std::uint32_t>(largest - faces.area.begin());
}

/// The plane that the largest face lies in: it serves at least that face. Needs a face.
[[nodiscard]] inline plane plane_of_largest_face(const face_table& faces) {
    return supporting_plane(faces, largest_face(faces));
}

/// Of the bin's centre plane, the average plane of its faces and the planes of its largest faces,
/// the one that `remaining` faces contribute most to; among equals the first of these.
///
/// Needs   candidates: those of the remaining faces that may be valid in the bin, at least one.
/// Cost    O(faces · 34), parallel.
/// Source  Fuhrmann et al. 2005, section 3.3.2; Luksch 2009, section 3.2. Differs: at most 32 faces
///         are tried, the largest, instead of all.
template <contribution<float> Contribution>
[[nodiscard]] plane fail_safe_plane(const face_table& remaining, const face_table& candidates,
                                    const plane& centre, double epsilon, const Contribution& worth,
                                    parallel threads = {}) {
    std::vector<plane> tries{centre, average_fit{}(candidates, centre)};
    face_rows order(candidates.size);
    std::iota(order.begin(), order.end(), 0u);
    const std::size_t count = std::min<std::size_t>(32, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                      order.end(), [&](std::uint32_t a, std::uint32_t b) {
                          const float area_a = candidates.area[a];
                          const float area_b = candidates.area[b];
                          return area_a != area_b ? area_a > area_b : a < b;
                      });
    for (std::size_t i = 0; i < count; ++i) {
        tries.push_back(supporting_plane(candidates, order[i]));
    }
    plane best = tries.front();
    double most = -1;
    for (const plane& p : tries) {
        const double sum = contribution_of(
            remaining, faces_valid_for(remaining, p, epsilon, worth, threads), p.normal, worth);
        if (sum > most) most = sum, best = p;
    }
    return best;
}

}  // namespace billow::inline BILLOW_ABI
