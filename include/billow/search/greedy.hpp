// The original greedy density search.
//
// X. Décoret, F. Durand, F. X. Sillion, J. Dorsey: Billboard clouds for extreme model
// simplification. SIGGRAPH 2003; with the corrections and extensions of C. Luksch: Implementation of
// an improved billboard cloud algorithm. Thesis, TU Wien 2009, and of Fuhrmann et al. 2005.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/progress.hpp>
#include <billow/search/fail_safe.hpp>
#include <billow/search/leftovers.hpp>
#include <billow/search/parts.hpp>
#include <billow/search/plane_distribution.hpp>
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

/// What the search did.
struct greedy_statistics {
    std::size_t refined_planes = 0;     ///< planes that refinement found
    std::size_t refinement_levels = 0;  ///< sum over those planes
    std::size_t fail_safes = 0;         ///< planes that refinement did not find
    std::size_t tweaks = 0;             ///< planes that the fitter moved
    std::size_t degenerate_faces = 0;   ///< set aside: they have no area
    /// Faces without a plane when max_planes, skip_area or min_contribution ended the search, and
    /// those of them that found none afterwards: far or edge-on to all planes.
    std::size_t leftover_faces = 0;
    std::size_t dropped_faces = 0;
    /// Shares of the faces' area: of the leftover and the dropped faces, and of the leftover faces
    /// that joined a plane although a corner is beyond epsilon.
    double leftover_area_share = 0;
    double dropped_area_share = 0;
    double beyond_epsilon_area_share = 0;

    [[nodiscard]] double mean_refinement_level() const noexcept {
        return refined_planes == 0
                   ? 0
                   : static_cast<double>(refinement_levels) / static_cast<double>(refined_planes);
    }
};

struct greedy_result {
    billboard_cloud cloud{};  ///< without billboards: fit_billboards adds them
    greedy_statistics statistics{};
    std::vector<moved_face> moved{};  ///< what the motion moved, around cloud.bounds.centre
};

namespace detail {

/// The state of one search. Its methods are the steps of the method, in their order.
template <class Pipeline>
class greedy_searcher {
public:
    greedy_searcher(face_table faces, const Pipeline& parts, const greedy_options& options,
                    parallel threads)
        : remaining_(std::move(faces)),
          space_(parts.space),
          policies_(parts.policies),
          fitter_(parts.fitter),
          grouping_(parts.grouping),
          motion_(parts.motion),
          options_(options),
          threads_(threads),
          // Columns hold floats: within this margin the bound holds for the mesh's own vertices.
          epsilon_(
              std::max(options.epsilon - 1e-6 * remaining_.bounds.radius, options.epsilon / 2)),
          rows_(make_rows(space_)),
          cells_(make_cells()),
          weights_(cells_, policies_.bias, options.distribution),
          grid_(with_grid_policies([&](const auto& used) {
              return make_density_grid(used, rows_.size(), make_axis(), density_scale(remaining_));
          })) {}

    greedy_result run(std::size_t face_count, const progress_function& progress) {
        result_.cloud.bounds = remaining_.bounds;
        result_.cloud.epsilon = options_.epsilon;
        result_.cloud.plane_of_face.assign(face_count, no_id);
        result_.statistics.degenerate_faces = remaining_.degenerate.size();
        const double total_area = area_of(remaining_);

        motion_.start(remaining_, epsilon_);
        change_density(remaining_, density_change::add);
        double left = 1;
        while (remaining_.size > 0 && !is_budget_spent() && !(left < options_.skip_area)) {
            plane found = find_plane();
            face_rows taken = faces_taken_by(found);
            tweak(found, taken);
            if (collects_too_little(found, taken, total_area)) break;
            emit(found, taken);
            left = area_of(remaining_) / total_area;
            report(progress, "search", 1 - left);
        }
        assign_leftovers(total_area);
        if (left > 0) report(progress, "search", 1);
        result_.moved = motion_.moved_faces();
        return std::move(result_);
    }

private:
    using space_type = decltype(Pipeline::space);
    using motion_type = decltype(Pipeline::motion);

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
        const double radius = remaining_.bounds.radius;
        const double spacing = std::max(options_.epsilon / options_.rho_rate, radius / max_bins);
        const int half = std::max(1, static_cast<int>(std::ceil(radius / spacing)));
        return {-half * spacing, spacing, 2 * half};
    }

    [[nodiscard]] std::span<const orientation_cell> cells() const noexcept { return cells_; }
    [[nodiscard]] static double area_of(const face_table& faces) noexcept {
        return std::accumulate(faces.area.begin(), faces.area.end(), 0.0);
    }
    [[nodiscard]] bool is_budget_spent() const noexcept {
        return options_.max_planes != 0 && result_.cloud.planes.size() >= options_.max_planes;
    }
    /// Never true for the first plane, so that skipped faces have somewhere to go.
    [[nodiscard]] bool collects_too_little(const plane& found, const face_rows& taken,
                                           double total_area) const {
        return options_.min_contribution > 0 && !result_.cloud.planes.empty() &&
               contribution_of(remaining_, taken, found.normal, policies_.contribution) <
                   options_.min_contribution * total_area;
    }

    [[nodiscard]] plane find_plane() {
        const std::optional<plane_bin> bin = find_bin();
        if (!bin) return plane_of_largest_face(remaining_);
        if (options_.refine == refinement::none) return centre_plane(space_, *bin);

        const face_table candidates =
            select_rows(remaining_,
                        faces_valid_for_bin(remaining_, cell_of_patch(space_, bin->patch),
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
            ++result_.statistics.refined_planes;
            result_.statistics.refinement_levels += static_cast<std::size_t>(refined->level);
            return refined->plane;
        }
        ++result_.statistics.fail_safes;
        if (candidates.size == 0) return plane_of_largest_face(remaining_);
        if (is_original) return plane_of_largest_face(candidates);
        return fail_safe_plane(remaining_, candidates, centre_plane(space_, *bin), epsilon_,
                               policies_.contribution, threads_);
    }

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

    /// All remaining faces that are valid for the plane, not only those of the bin: re-evaluation
    /// (Luksch 2009, section 3.2). A plane that serves nobody gives way to that of the largest face,
    /// which takes at least its own face, so every round makes progress.
    [[nodiscard]] face_rows faces_taken_by(plane& found) const {
        face_rows taken = faces_allowed_on(found);
        if (taken.empty()) {
            found = plane_of_largest_face(remaining_);
            taken = faces_allowed_on(found);
        }
        if (taken.empty()) {  // epsilon is below what floats resolve
            taken.push_back(largest_face(remaining_));
        }
        return grouped(found, std::move(taken));
    }

    [[nodiscard]] face_rows faces_allowed_on(const plane& p) const {
        face_rows rows = faces_valid_for(remaining_, p, epsilon_, policies_.contribution, threads_);
        motion_.keep_allowed(remaining_, p, rows);
        return rows;
    }

    /// Those of the faces that the grouping wants on the plane. The others come again later.
    [[nodiscard]] face_rows grouped(const plane& p, face_rows rows) const {
        if constexpr (!std::remove_cvref_t<decltype(grouping_)>::takes_all) {
            const face_table faces = select_rows(remaining_, rows, threads_);
            face_rows wanted = grouping_(faces, p, epsilon_, threads_);
            BILLOW_ASSERT(!wanted.empty());
            for (std::uint32_t& row : wanted) row = rows[row];
            return wanted;
        }
        return rows;
    }

    /// Moves the plane to its faces, if all of them stay valid; then takes the faces that have become
    /// valid too. Source: Fuhrmann et al. 2005, section 3.3.3.
    void tweak(plane& found, face_rows& taken) {
        const face_table faces = select_rows(remaining_, taken, threads_);
        const plane moved = fitter_(faces, found);
        if (moved == found) return;
        face_rows all(faces.size);
        std::iota(all.begin(), all.end(), 0u);
        if (faces_valid_for(faces, moved, epsilon_, policies_.contribution, threads_).size() !=
            faces.size) {
            return;
        }
        const auto contribution = [&](const plane& p) {
            return contribution_of(faces, all, p.normal, policies_.contribution);
        };
        if (!fitter_.allows_less_contribution && contribution(moved) < contribution(found)) return;
        face_rows moved_taken = faces_allowed_on(moved);
        if (!std::ranges::includes(moved_taken, taken)) return;
        found = moved;
        taken = grouped(moved, std::move(moved_taken));
        ++result_.statistics.tweaks;
    }

    void emit(const plane& found, const face_rows& taken) {
        const auto id = static_cast<plane_id>(result_.cloud.planes.size());
        result_.cloud.planes.push_back(canonical(found));
        weights_.plane_found(found.normal);
        for (const std::uint32_t row : taken) {
            result_.cloud.plane_of_face[remaining_.source[row]] = id;
        }
        face_rows kept;
        kept.reserve(remaining_.size - taken.size());
        std::size_t next = 0;
        for (std::uint32_t row = 0; row < remaining_.size; ++row) {
            if (next < taken.size() && taken[next] == row) {
                ++next;
            } else {
                kept.push_back(row);
            }
        }
        const face_table leaving = select_rows(remaining_, taken, threads_);
        if (!kept.empty()) change_density(leaving, density_change::remove);
        remaining_ = select_rows(remaining_, kept, threads_);
        if constexpr (!motion_type::is_still) {
            const face_rows moving = motion_.plane_found(leaving, found, remaining_);
            change_density(select_rows(remaining_, moving, threads_), density_change::remove);
            motion_.move(remaining_, moving);
            change_density(select_rows(remaining_, moving, threads_), density_change::add);
        }
    }

    /// Calls `use` with the policies of the grid: falloff_use may leave the falloff to refinement.
    template <class Use>
    auto with_grid_policies(const Use& use) const {
        if constexpr (std::remove_cvref_t<decltype(policies_)>::falls) {
            if (options_.falloff != falloff_use::everywhere) return use(without_falloff(policies_));
        }
        return use(policies_);
    }

    void change_density(const face_table& faces, density_change change) {
        with_grid_policies([&](const auto& used) {
            rasterize_density(faces, cells(), used, epsilon_, grid_, change, threads_);
        });
    }

    /// After max_planes every face keeps a plane; what is skipped goes to the nearest sensible one.
    void assign_leftovers(double total_area) {
        if (remaining_.size == 0) return;
        const std::vector<plane>& planes = result_.cloud.planes;
        const std::vector<plane_id> plane_of =
            is_budget_spent() ? planes_of_least_error(remaining_, planes, threads_)
                              : nearest_planes_within(remaining_, planes, options_.epsilon,
                                                      options_.skipped, threads_);
        greedy_statistics& statistics = result_.statistics;
        statistics.leftover_faces = remaining_.size;
        for (std::size_t row = 0; row < remaining_.size; ++row) {
            const double share = static_cast<double>(remaining_.area[row]) / total_area;
            statistics.leftover_area_share += share;
            result_.cloud.plane_of_face[remaining_.source[row]] = plane_of[row];
            if (plane_of[row] == no_id) {
                ++statistics.dropped_faces;
                statistics.dropped_area_share += share;
            } else if (distances_to(planes[plane_of[row]], remaining_, row).largest >
                       options_.epsilon) {
                statistics.beyond_epsilon_area_share += share;
            }
        }
    }

    face_table remaining_;
    const space_type& space_;
    const decltype(Pipeline::policies)& policies_;
    const decltype(Pipeline::fitter)& fitter_;
    const decltype(Pipeline::grouping)& grouping_;
    motion_type motion_;
    greedy_options options_;
    parallel threads_;
    double epsilon_;
    std::vector<orientation_id> rows_;
    std::vector<orientation_cell> cells_;
    orientation_weights weights_;
    density_grid grid_;
    greedy_result result_;
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
    return detail::greedy_searcher<pipeline<Parts...>>(std::move(faces), parts, options, threads)
        .run(face_count, progress);
}
[[nodiscard]] inline greedy_result greedy_search(face_table faces, std::size_t face_count,
                                                 const greedy_options& options) {
    return greedy_search(std::move(faces), face_count, options, pipeline{});
}

}  // namespace billow::inline BILLOW_ABI
