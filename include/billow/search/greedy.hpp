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
#include <billow/fit/average.hpp>
#include <billow/search/parts.hpp>
#include <billow/search/refine.hpp>

namespace billow::inline BILLOW_ABI {

struct greedy_options {
    double epsilon = 0;          ///< largest distance of a vertex to its plane, scene units, > 0
    double rho_rate = 1.5;       ///< offset bins per epsilon, > 0; Luksch 2009: stable from 0.75 on
    std::size_t max_planes = 0;  ///< 0: as many as it takes; else faces that are left join the
                                 ///< plane of least error, which breaks epsilon for them
    refinement refine = refinement::fail_safe;
    int max_levels = 12;          ///< of refinement, > 0
    double sufficient_share = 1;  ///< refine_options::sufficient_share
};

/// What the search did.
struct greedy_statistics {
    std::size_t refinement_levels = 0;  ///< sum over the planes
    std::size_t fail_safes = 0;         ///< planes that refinement did not find
    std::size_t tweaks = 0;             ///< planes that the fitter moved
    std::size_t degenerate_faces = 0;   ///< set aside: they have no area
    std::size_t leftover_faces = 0;     ///< joined the plane of least error, see max_planes
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
          grid_(rows_.size(), make_axis(), density_scale(remaining_)) {
        for (const orientation_id id : rows_) cells_.push_back(space_.cell(id));
    }

    greedy_result run(std::size_t face_count, const progress_function& progress) {
        result_.cloud.bounds = remaining_.bounds;
        result_.cloud.epsilon = options_.epsilon;
        result_.cloud.plane_of_face.assign(face_count, no_id);
        result_.statistics.degenerate_faces = remaining_.degenerate.size();
        const double total_area = area_sum();

        motion_.start(remaining_, epsilon_);
        change_density(remaining_, density_change::add);
        while (remaining_.size > 0 && !is_budget_spent()) {
            plane found = find_plane();
            face_rows taken = faces_taken_by(found);
            tweak(found, taken);
            group(found, taken);
            emit(found, taken);
            report(progress, "search", 1 - area_sum() / total_area);
        }
        assign_leftovers();
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

    /// Bins over [-R, R] with a border at 0. Very small epsilons get bins of R / 2048.
    [[nodiscard]] offset_axis make_axis() const {
        constexpr double max_bins = 2048;
        const double radius = remaining_.bounds.radius;
        const double spacing = std::max(options_.epsilon / options_.rho_rate, radius / max_bins);
        const int half = std::max(1, static_cast<int>(std::ceil(radius / spacing)));
        return {-half * spacing, spacing, 2 * half};
    }

    [[nodiscard]] std::span<const orientation_cell> cells() const noexcept { return cells_; }
    [[nodiscard]] double area_sum() const noexcept {
        return std::accumulate(remaining_.area.begin(), remaining_.area.end(), 0.0);
    }
    [[nodiscard]] bool is_budget_spent() const noexcept {
        return options_.max_planes != 0 && result_.cloud.planes.size() >= options_.max_planes;
    }

    [[nodiscard]] plane find_plane() {
        const std::optional<plane_bin> bin = find_bin();
        if (!bin) return plane_of_largest_face(remaining_);
        if (options_.refine == refinement::none) return centre_plane(space_, *bin);

        const face_table candidates = select_rows(
            remaining_,
            faces_valid_for_bin(remaining_, cell_of_patch(space_, bin->patch), bin->rho_low,
                                bin->rho_high, epsilon_, widened_centre{}, threads_),
            threads_);
        const bool is_original = options_.refine == refinement::original;
        const auto refined = candidates.size == 0
                                 ? std::nullopt
                                 : refine(space_, *bin, candidates, policies_, epsilon_,
                                          {.children_per_axis = is_original ? 6 : 4,
                                           .max_levels = options_.max_levels,
                                           .sufficient_share = options_.sufficient_share},
                                          threads_);
        if (refined) {
            result_.statistics.refinement_levels += static_cast<std::size_t>(refined->level);
            return refined->plane;
        }
        ++result_.statistics.fail_safes;
        if (candidates.size == 0) return plane_of_largest_face(remaining_);
        if (is_original) return plane_of_largest_face(candidates);
        return fail_safe(*bin, candidates);
    }

    /// The densest bin; where penalties leave none above 0, that of most contribution; nothing when
    /// no face is simple-valid anywhere.
    [[nodiscard]] std::optional<plane_bin> find_bin() const {
        const double weight = policies_.penalty.weight;
        dense_bin best = densest_bin(
            grid_,
            [weight](std::size_t, double c, double p) {
                return c > 0 ? c - weight * p : -std::numeric_limits<double>::max();
            },
            threads_);
        if (best.density <= 0) {
            best = densest_bin(
                grid_, [](std::size_t, double c, double) { return c; }, threads_);
        }
        if (best.contribution <= 0) return std::nullopt;
        const double low = grid_.axis().origin + best.bin * grid_.axis().spacing;
        return plane_bin{space_.patch(rows_[best.row]), low, low + grid_.axis().spacing};
    }

    /// Of the bin's centre plane, the average plane of its faces and the planes of its largest
    /// faces, the one of most contribution. Source: Fuhrmann et al. 2005, section 3.3.2; Luksch
    /// 2009, section 3.2. Differs: at most 32 faces are tried, the largest, instead of all.
    [[nodiscard]] plane fail_safe(const plane_bin& bin, const face_table& candidates) const {
        const plane centre = centre_plane(space_, bin);
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
            const double contribution =
                contribution_of(remaining_, faces_valid_for(remaining_, p, epsilon_, threads_),
                                p.normal, policies_.contribution);
            if (contribution > most) most = contribution, best = p;
        }
        return best;
    }

    [[nodiscard]] static std::uint32_t largest_face(const face_table& faces) {
        const auto largest = std::max_element(faces.area.begin(), faces.area.end());
        return static_cast<std::uint32_t>(largest - faces.area.begin());
    }
    [[nodiscard]] static plane plane_of_largest_face(const face_table& faces) {
        return supporting_plane(faces, largest_face(faces));
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
        return taken;
    }

    [[nodiscard]] face_rows faces_allowed_on(const plane& p) const {
        face_rows rows = faces_valid_for(remaining_, p, epsilon_, threads_);
        motion_.keep_allowed(remaining_, p, rows);
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
        if (faces_valid_for(faces, moved, epsilon_, threads_).size() != faces.size) return;
        const auto contribution = [&](const plane& p) {
            return contribution_of(faces, all, p.normal, policies_.contribution);
        };
        if (!fitter_.allows_less_contribution && contribution(moved) < contribution(found)) return;
        face_rows moved_taken = faces_allowed_on(moved);
        if (!std::ranges::includes(moved_taken, taken)) return;
        found = moved;
        taken = std::move(moved_taken);
        ++result_.statistics.tweaks;
    }

    /// Leaves to later planes what the grouping does not want on this one.
    void group(const plane& found, face_rows& taken) const {
        if constexpr (!std::remove_cvref_t<decltype(grouping_)>::takes_all) {
            const face_rows kept =
                grouping_(select_rows(remaining_, taken, threads_), found, epsilon_, threads_);
            BILLOW_ASSERT(!kept.empty());
            face_rows rows;
            for (const std::uint32_t row : kept) rows.push_back(taken[row]);
            taken = std::move(rows);
        }
    }

    void emit(const plane& found, const face_rows& taken) {
        const auto id = static_cast<plane_id>(result_.cloud.planes.size());
        result_.cloud.planes.push_back(canonical(found));
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

    void change_density(const face_table& faces, density_change change) {
        rasterize_density(faces, cells(), policies_, epsilon_, grid_, change, threads_);
    }

    /// Gives every face that is left to the plane whose farthest corner of the face is nearest.
    void assign_leftovers() {
        result_.statistics.leftover_faces = remaining_.size;
        const std::vector<plane>& planes = result_.cloud.planes;
        threads_.for_chunks(remaining_.size, 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) {
                plane_id nearest = no_id;
                double least = std::numeric_limits<double>::infinity();
                for (plane_id id = 0; id < planes.size(); ++id) {
                    double error = 0;
                    for (const columns3& corner : remaining_.corner) {
                        error =
                            std::max(error, std::abs(signed_distance(planes[id], corner.get(row))));
                    }
                    if (error < least) least = error, nearest = id;
                }
                result_.cloud.plane_of_face[remaining_.source[row]] = nearest;
            }
        });
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
