// The original greedy density search.
//
// X. Décoret, F. Durand, F. X. Sillion, J. Dorsey: Billboard clouds for extreme model
// simplification. SIGGRAPH 2003; with the corrections and extensions of C. Luksch: Implementation of
// an improved billboard cloud algorithm. Thesis, TU Wien 2009, and of Fuhrmann et al. 2005.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <billow/search/fail_safe.hpp>
#include <billow/search/parts.hpp>
#include <billow/search/plane_distribution.hpp>
#include <billow/search/plane_sequence.hpp>
#include <billow/search/refine.hpp>

namespace billow::inline BILLOW_ABI {

struct greedy_options {
    double epsilon = 0;          ///< largest distance of a vertex to its plane, scene units, > 0
    double rho_rate = 1.5;       ///< offset bins per epsilon, > 0; Luksch 2009: stable from 0.75 on
    std::size_t max_planes = 0;  ///< 0: as many as it takes; else faces that are left join the
                                 ///< plane of least error, which breaks epsilon for them
    double skip_area = 0;  ///< share of the faces' area, [0, 1): the search ends when less is left;
                           ///< those faces join a plane within `skipped`, or none
    double min_contribution = 0;  ///< share of the faces' area, [0, 1): the search ends before a
                                  ///< plane that would collect less; its faces are skipped too
    skip_limits skipped{};        ///< where skipped faces may go
    plane_distribution distribution{};  ///< restrains planes that are parallel to earlier ones
    refinement refine = refinement::fail_safe;
    int max_levels = 12;                 ///< of refinement, > 0
    double sufficient_share = 1;         ///< refine_options::sufficient_share
    bool penalty_in_refinement = false;  ///< refine_options::penalty_counts
    falloff_use falloff = falloff_use::everywhere;
};

namespace detail {

/// Finds the plane of most density: the densest bin of a grid, refined.
template <class Pipeline>
class density_chooser {
public:
    density_chooser(const face_table& faces, const Pipeline& parts, const greedy_options& options,
                    parallel threads)
        : space_(parts.space),
          policies_(parts.policies),
          options_(options),
          threads_(threads),
          radius_(faces.bounds.radius),
          epsilon_(inner_epsilon(faces, options.epsilon)),
          rows_(make_rows(space_)),
          cells_(make_cells()),
          weights_(cells_, policies_.bias, options.distribution),
          grid_(with_grid_policies([&](const auto& used) {
              return make_density_grid(used, rows_.size(), make_axis(), density_scale(faces));
          })) {}

    void change(const face_table& faces, density_change change) {
        with_grid_policies([&](const auto& used) {
            rasterize_density(faces, cells(), used, epsilon_, grid_, change, threads_);
        });
    }
    void faces_taken(const face_table& leaving, const face_table&) {
        change(leaving, density_change::remove);
    }
    void plane_found(const plane& found) noexcept { weights_.plane_found(found.normal); }

    [[nodiscard]] plane find_plane(const face_table& remaining,
                                   greedy_statistics& statistics) const {
        const std::optional<plane_bin> bin = find_bin();
        if (!bin) return plane_of_largest_face(remaining);
        if (options_.refine == refinement::none) return centre_plane(space_, *bin);

        const face_table candidates =
            select_rows(remaining,
                        faces_valid_for_bin(remaining, cell_of_patch(space_, bin->patch),
                                            bin->rho_low, bin->rho_high, epsilon_, widened_centre{},
                                            policies_.contribution, threads_),
                        threads_);
        const bool is_original = options_.refine == refinement::original;
        const auto refined = candidates.size == 0
                                 ? std::nullopt
                                 : refine(space_, *bin, candidates, policies_, epsilon_,
                                          {.children_per_axis = is_original ? 6 : 4,
                                           .max_levels = options_.max_levels,
                                           .sufficient_share = options_.sufficient_share,
                                           .falls = options_.falloff != falloff_use::nowhere,
                                           .penalty_counts = options_.penalty_in_refinement},
                                          threads_);
        if (refined) {
            ++statistics.refined_planes;
            statistics.refinement_levels += static_cast<std::size_t>(refined->level);
            return refined->plane;
        }
        ++statistics.fail_safes;
        if (candidates.size == 0) return plane_of_largest_face(remaining);
        if (is_original) return plane_of_largest_face(candidates);
        return fail_safe_plane(remaining, candidates, centre_plane(space_, *bin), epsilon_,
                               policies_.contribution, threads_);
    }

private:
    using space_type = decltype(Pipeline::space);

    /// One row for n and -n, which share their planes.
    [[nodiscard]] static std::vector<orientation_id> make_rows(const space_type& space) {
        std::vector<orientation_id> rows;
        for (orientation_id id = 0; id < space.orientation_count(); ++id) {
            if (id <= space.antipode(id)) rows.push_back(id);
        }
        return rows;
    }

    [[nodiscard]] std::vector<orientation_cell> make_cells() const {
        std::vector<orientation_cell> cells;
        for (const orientation_id id : rows_) cells.push_back(space_.cell(id));
        return cells;
    }

    /// Bins over [-R, R] with a border at 0. Very small epsilons get bins of R / 2048.
    [[nodiscard]] offset_axis make_axis() const {
        constexpr double max_bins = 2048;
        const double spacing = std::max(options_.epsilon / options_.rho_rate, radius_ / max_bins);
        const int half = std::max(1, static_cast<int>(std::ceil(radius_ / spacing)));
        return {-half * spacing, spacing, 2 * half};
    }

    [[nodiscard]] std::span<const orientation_cell> cells() const noexcept { return cells_; }
    /// The densest bin; where penalties leave none above 0, that of most contribution; nothing when
    /// no face is simple-valid anywhere. Biases weigh both (Fuhrmann et al. 2005, section 3.3.5).
    [[nodiscard]] std::optional<plane_bin> find_bin() const {
        const double charge = policies_.penalty.weight;
        dense_bin best = densest_bin(
            grid_,
            [&](std::size_t row, double c, double p) {
                return c > 0 ? biased(c - charge * p, weights_[row])
                             : -std::numeric_limits<double>::max();
            },
            threads_);
        if (best.density <= 0) {
            best = densest_bin(
                grid_, [&](std::size_t row, double c, double) { return biased(c, weights_[row]); },
                threads_);
        }
        if (best.contribution <= 0) return std::nullopt;
        const double low = grid_.axis().origin + best.bin * grid_.axis().spacing;
        return plane_bin{space_.patch(rows_[best.row]), low, low + grid_.axis().spacing};
    }

    /// Calls `use` with the policies of the grid: falloff_use may leave the falloff to refinement.
    template <class Use>
    auto with_grid_policies(const Use& use) const {
        if constexpr (std::remove_cvref_t<decltype(policies_)>::falls) {
            if (options_.falloff != falloff_use::everywhere) return use(without_falloff(policies_));
        }
        return use(policies_);
    }

    const space_type& space_;
    const decltype(Pipeline::policies)& policies_;
    greedy_options options_;
    parallel threads_;
    double radius_;
    double epsilon_;
    std::vector<orientation_id> rows_;
    std::vector<orientation_cell> cells_;
    orientation_weights weights_;
    density_grid grid_;
};

}  // namespace detail

/// Finds planes that lie within epsilon of every vertex of every face: again and again the plane of
/// most density, until no face is left.
///
/// Shape   plane_of_face: one row a face of the mesh that `faces` was made of, `face_count` of them.
/// Unit    epsilon in scene units.
/// Needs   options.epsilon > 0, options.rho_rate > 0.
/// Gives   a cloud without billboards, in which every face that has an area lies on exactly one
///         plane; within epsilon unless max_planes cut the search short. The bound holds for the
///         mesh's own vertices down to epsilons of 2e-6 radii, where floats end.
/// Fails   never.
/// Cost    O(faces · orientations) twice, for the first density and for all removals together, and
///         O(faces · planes); 130 bytes a face beyond the input. Same result for any thread count.
/// Source  Décoret et al. 2003; Luksch 2009, sections 2.1, 3.2 and 4.3. Differs where the sources
///         err: see density/grid.hpp, policy/validity.hpp, search/refine.hpp.
template <class... Parts>
[[nodiscard]] greedy_result greedy_search(face_table faces, std::size_t face_count,
                                          const greedy_options& options,
                                          const pipeline<Parts...>& parts, parallel threads = {},
                                          const progress_function& progress = {}) {
    BILLOW_ASSERT(options.epsilon > 0 && options.rho_rate > 0);
    detail::density_chooser chooser(faces, parts, options, threads);
    return detail::plane_sequence(std::move(faces), parts,
                                  {.epsilon = options.epsilon,
                                   .max_planes = options.max_planes,
                                   .skip_area = options.skip_area,
                                   .min_contribution = options.min_contribution,
                                   .skipped = options.skipped},
                                  threads)
        .run(face_count, chooser, progress);
}
[[nodiscard]] inline greedy_result greedy_search(face_table faces, std::size_t face_count,
                                                 const greedy_options& options) {
    return greedy_search(std::move(faces), face_count, options, pipeline{});
}

}  // namespace billow::inline BILLOW_ABI
