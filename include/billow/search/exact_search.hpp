// Greedy search without a grid: the best plane over all normals of a plane space, by exact offsets.
//
// The greedy rule is that of Décoret et al. 2003; the sweep, its lazy evaluation and the search over
// normals between the samples take the place of their bins and refinement.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include <billow/policy/tangency.hpp>
#include <billow/search/direction_search.hpp>
#include <billow/search/lazy_directions.hpp>
#include <billow/search/parts.hpp>
#include <billow/search/plane_distribution.hpp>
#include <billow/search/plane_sequence.hpp>

namespace billow::inline BILLOW_ABI {

struct exact_search_options {
    double epsilon = 0;          ///< largest distance of a vertex to its plane, scene units, > 0
    std::size_t max_planes = 0;  ///< 0: as many as it takes; else faces that are left join the
                                 ///< plane of least error, which breaks epsilon for them
    double coverage = 1;  ///< share of the faces' area, (0, 1]: the search ends when planes hold as
                          ///< much; faces that are left join a plane within `skipped`, or none
    double min_contribution = 0;        ///< as in greedy_options
    skip_limits skipped{};              ///< where faces that are left may go
    plane_distribution distribution{};  ///< restrains planes that are parallel to earlier ones
    exact_method method{};              ///< how planes are looked for
};

namespace detail {

/// A contribution, until the tail of a search begins: there the face's whole area.
template <class Contribution>
struct tail_worth {
    Contribution base;
    float least_cosine;
    bool is_tail = false;

    explicit tail_worth(const Contribution& worth) noexcept
        : base(worth), least_cosine(least_cosine_of(worth)) {}

    template <class V>
    [[nodiscard]] V operator()(const face_lanes<V>& face,
                               const vec3_lanes<V>& normal) const noexcept {
        if (!is_tail) return base(face, normal);
        return simd::select(
            simd::abs(dot(face.normal, normal)) >= simd::lanes<V>::fill(least_cosine), face.area,
            simd::lanes<V>::fill(0));
    }
};

/// Finds the plane of most density: exactly over the normals of the space, then between them.
template <class Pipeline>
class exact_chooser {
public:
    exact_chooser(const face_table& faces, const Pipeline& parts,
                  const exact_search_options& options, parallel threads)
        : space_(parts.space),
          worth_(tangent_share(parts.policies.contribution, options.method.tangency)),
          method_(options.method),
          threads_(threads),
          epsilon_(inner_epsilon(faces, options.epsilon)),
          sweep_(worth_, parts.policies.penalty, epsilon_, faces.bounds.radius,
                 density_scale(faces)),
          area_(area_of(faces)),
          row_of_(space_.orientation_count()),
          cells_(make_cells()),
          weights_(cells_, parts.policies.bias, options.distribution),
          directions_(sweep_, floats(normals_), threads),
          scratches_(threads.count()) {}

    void change(const face_table& faces, density_change change) {
        directions_.change(faces, change);
    }
    void faces_taken(const face_table& leaving, const face_table& remaining) {
        if (!worth_.is_tail && area_of(remaining) < method_.tail * area_) {
            worth_.is_tail = true;
            directions_.clear();
            directions_.change(remaining, density_change::add);
        } else if (leaving.size <= remaining.size) {
            directions_.change(leaving, density_change::remove);
        } else {
            directions_.clear();
            directions_.change(remaining, density_change::add);
        }
    }
    void plane_found(const plane& found) noexcept { weights_.plane_found(found.normal); }

    [[nodiscard]] plane find_plane(const face_table& remaining, greedy_statistics& statistics) {
        double charge = sweep_.charge();
        swept_direction best = directions_.best(remaining, weights_, charge);
        if (charge != 0 && !(best.at.density > 0)) {
            charge = 0;
            directions_.forget_bounds();
            best = directions_.best(remaining, weights_, charge);
        }
        if (!best.at.is_found) {
            ++statistics.fail_safes;
            return plane_of_largest_face(remaining);
        }
        ++statistics.refined_planes;
        const directed_plane found = searched(remaining, best, charge);
        if (charge != sweep_.charge()) directions_.forget_bounds();
        const double rho = sweep_.nearest(remaining, vec3(found.normal), found.at.rho, scratch_);
        return {found.normal, rho};
    }

private:
    using space_type = decltype(Pipeline::space);
    using contribution_type =
        tail_worth<tangent_share<decltype(decltype(Pipeline::policies)::contribution)>>;
    using penalty_type = decltype(decltype(Pipeline::policies)::penalty);
    using sweep_type = offset_sweep<contribution_type, penalty_type>;

    [[nodiscard]] static double area_of(const face_table& faces) noexcept {
        return std::accumulate(faces.area.begin(), faces.area.end(), 0.0);
    }
    /// One row for n and -n, which share their planes.
    [[nodiscard]] std::vector<orientation_cell> make_cells() {
        std::vector<orientation_cell> cells;
        for (orientation_id id = 0; id < space_.orientation_count(); ++id) {
            const orientation_id opposite = space_.antipode(id);
            if (id <= opposite) {
                cells.push_back(space_.cell(id));
                normals_.push_back(space_.direction(id));
            }
            row_of_[id] =
                id <= opposite ? static_cast<std::uint32_t>(cells.size() - 1) : row_of_[opposite];
        }
        return cells;
    }
    [[nodiscard]] static std::vector<vec3> floats(const std::vector<dvec3>& normals) {
        return {normals.begin(), normals.end()};
    }

    /// The best plane near the best few normals; of equals the first.
    [[nodiscard]] directed_plane searched(const face_table& remaining, const swept_direction& best,
                                          double charge) {
        const auto directed = [&](const swept_direction& d) {
            return directed_plane{normals_[d.row], d.at};
        };
        std::vector<directed_plane> tries{directed(best)};
        if (method_.starts <= 0) return tries.front();
        const double spacing = 2 * static_cast<double>(cells_[best.row].chord);
        const auto others =
            directions_.runners_up(remaining, weights_, charge, best.row,
                                   static_cast<std::size_t>(method_.starts) - 1, spacing);
        for (const swept_direction& d : others) tries.push_back(directed(d));
        const auto weigh = [&](const dvec3& normal) {
            return weights_[row_of_[space_.orientation_of(normal)]];
        };
        const direction_search_options steps{.first_step = spacing / 4,
                                             .last_step = method_.last_step};
        for_jobs(threads_, tries.size(), scratches_,
                 [&](std::size_t i, direction_scratch& scratch) {
                     tries[i] = search_directions(sweep_, remaining, tries[i], epsilon_, worth_,
                                                  weigh, charge, steps, scratch);
                 });
        return *std::ranges::max_element(tries, {},
                                         [](const directed_plane& d) { return d.at.density; });
    }

    const space_type& space_;
    contribution_type worth_;
    exact_method method_;
    parallel threads_;
    double epsilon_;
    sweep_type sweep_;
    double area_;
    std::vector<std::uint32_t> row_of_;
    std::vector<dvec3> normals_{};
    std::vector<orientation_cell> cells_;
    orientation_weights weights_;
    lazy_directions<sweep_type> directions_;
    std::vector<direction_scratch> scratches_;
    sweep_scratch scratch_{};
};

}  // namespace detail

/// Finds planes that lie within epsilon of every vertex of every face: again and again the plane that
/// collects most, until no face is left or enough is covered.
///
/// For every normal of `parts.space` the best offset is found exactly, and with it the best plane over
/// all of these normals; pattern searches from the best few of them turn the plane to where it
/// collects more still. Of the equal offsets it takes the one nearest to the faces, and the fitter may
/// move it within epsilon. Then it takes all faces that are valid for it.
///
/// Policies: any contribution; penalties count exactly, too, but bounds are loose for them and all
/// normals are summed up for each plane; a bias and plane_distribution weigh normals, those between
/// the samples as the nearest one. Validity policies estimate what is exact here and are not asked; a
/// falloff has no say.
///
/// Guarantee. Where a face counts the same on all planes that it is valid for, as with method.tail 1,
/// what planes hold is a monotone submodular function of their set. Then the first k greedy planes
/// hold at least 1 - 1/e of what the best k hold (Nemhauser, Wolsey, Fisher 1978), and all of them are
/// at most 1 + ln(most area that a plane collects / least area of a face) times as many as are needed
/// (Wolsey 1982), the best being those among all offsets and the normals of the space; planes between
/// these normals, and the fitter's, only collect more. A contribution that depends on the normal is
/// greedy by the same rule but has no such proof, since a face that a plane shows askew is gone for
/// those that would show it better; nor have penalties, weights of normals, and groupings.
///
/// Shape, Unit, Gives: as greedy_search, whose result this is; covered_area is the curve of planes
/// against area. With coverage < 1 the faces that are left join a plane within `skipped`, which may
/// be farther than epsilon, or none: statistics tell their number and area.
/// Needs   options.epsilon > 0.
/// Fails   never.
/// Cost    O(faces · normals), twice at most, and O(remaining faces) for each normal that is swept;
///         130 bytes a face beyond the input, 10 to 32 MB for the rows of a raster of 18. Same
///         result for any thread count.
/// Source  The greedy rule: Décoret et al. 2003. G. L. Nemhauser, L. A. Wolsey, M. L. Fisher: An
///         analysis of approximations for maximizing submodular set functions I. Mathematical
///         Programming 14, 1978. L. A. Wolsey: An analysis of the greedy algorithm for the submodular
///         set covering problem. Combinatorica 2, 1982. Lazy evaluation: Minoux 1978.
template <class... Parts>
[[nodiscard]] greedy_result exact_search(face_table faces, std::size_t face_count,
                                         const exact_search_options& options,
                                         const pipeline<Parts...>& parts, parallel threads = {},
                                         const progress_function& progress = {}) {
    BILLOW_ASSERT(options.epsilon > 0 && options.coverage > 0 && options.coverage <= 1);
    detail::exact_chooser chooser(faces, parts, options, threads);
    return detail::plane_sequence(std::move(faces), parts,
                                  {.epsilon = options.epsilon,
                                   .max_planes = options.max_planes,
                                   .skip_area = 1 - options.coverage,
                                   .min_contribution = options.min_contribution,
                                   .skipped = options.skipped},
                                  threads)
        .run(face_count, chooser, progress);
}
[[nodiscard]] inline greedy_result exact_search(face_table faces, std::size_t face_count,
                                                const exact_search_options& options) {
    return exact_search(std::move(faces), face_count, options, pipeline{});
}

}  // namespace billow::inline BILLOW_ABI
