// Planes one after the other, each with the faces that it takes: what all greedy searches share.
//
// X. Décoret, F. Durand, F. X. Sillion, J. Dorsey: Billboard clouds for extreme model
// simplification. SIGGRAPH 2003; Fuhrmann et al. 2005, section 3.3.3; Luksch 2009, section 3.2.
#pragma once

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/progress.hpp>
#include <billow/search/fail_safe.hpp>
#include <billow/search/leftovers.hpp>
#include <billow/search/parts.hpp>

namespace billow::inline BILLOW_ABI {

/// What the search did.
struct greedy_statistics {
    std::size_t refined_planes = 0;     ///< planes that refinement found
    std::size_t refinement_levels = 0;  ///< sum over those planes
    std::size_t fail_safes = 0;         ///< planes that refinement, or the sweep, did not find
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
    std::vector<double> covered_area{};  ///< share of the faces' area on the planes up to each
    std::vector<moved_face> moved{};     ///< what the motion moved, around cloud.bounds.centre
};

namespace detail {

/// When a sequence of planes ends, and what becomes of the faces that are left: as greedy_options say.
struct sequence_options {
    double epsilon = 0;
    std::size_t max_planes = 0;
    double skip_area = 0;
    double min_contribution = 0;
    skip_limits skipped{};
};

/// Columns hold floats: within this margin the bound holds for the mesh's own vertices.
[[nodiscard]] inline double inner_epsilon(const face_table& faces, double epsilon) noexcept {
    return std::max(epsilon - 1e-6 * faces.bounds.radius, epsilon / 2);
}

/// The state of one search but for what finds the planes: a chooser.
///
/// A chooser is told of the faces that it has to serve by `change(faces, density_change)` and
/// `faces_taken(leaving, remaining)`, is asked for a plane by `find_plane(remaining, statistics)`,
/// and hears by `plane_found(plane)` what came of it.
template <class Pipeline>
class plane_sequence {
public:
    plane_sequence(face_table faces, const Pipeline& parts, const sequence_options& options,
                   parallel threads)
        : remaining_(std::move(faces)),
          policies_(parts.policies),
          fitter_(parts.fitter),
          grouping_(parts.grouping),
          motion_(parts.motion),
          options_(options),
          threads_(threads),
          epsilon_(inner_epsilon(remaining_, options.epsilon)) {}

    [[nodiscard]] const face_table& remaining() const noexcept { return remaining_; }

    template <class Chooser>
    greedy_result run(std::size_t face_count, Chooser& chooser, const progress_function& progress) {
        result_.cloud.bounds = remaining_.bounds;
        result_.cloud.epsilon = options_.epsilon;
        result_.cloud.plane_of_face.assign(face_count, no_id);
        result_.statistics.degenerate_faces = remaining_.degenerate.size();
        const double total_area = area_of(remaining_);

        motion_.start(remaining_, epsilon_);
        chooser.change(remaining_, density_change::add);
        double left = 1;
        while (remaining_.size > 0 && !is_budget_spent() && !(left < options_.skip_area)) {
            plane found = chooser.find_plane(remaining_, result_.statistics);
            face_rows taken = faces_taken_by(found);
            tweak(found, taken);
            if (collects_too_little(found, taken, total_area)) break;
            emit(found, taken, chooser);
            left = area_of(remaining_) / total_area;
            result_.covered_area.push_back(1 - left);
            report(progress, "search", 1 - left);
        }
        assign_leftovers(total_area);
        if (left > 0) report(progress, "search", 1);
        result_.moved = motion_.moved_faces();
        return std::move(result_);
    }

private:
    using motion_type = decltype(Pipeline::motion);

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

    template <class Chooser>
    void emit(const plane& found, const face_rows& taken, Chooser& chooser) {
        const auto id = static_cast<plane_id>(result_.cloud.planes.size());
        result_.cloud.planes.push_back(canonical(found));
        chooser.plane_found(found);
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
        remaining_ = select_rows(remaining_, kept, threads_);
        if (!kept.empty()) chooser.faces_taken(leaving, remaining_);
        if constexpr (!motion_type::is_still) {
            const face_rows moving = motion_.plane_found(leaving, found, remaining_);
            chooser.change(select_rows(remaining_, moving, threads_), density_change::remove);
            motion_.move(remaining_, moving);
            chooser.change(select_rows(remaining_, moving, threads_), density_change::add);
        }
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
    const decltype(Pipeline::policies)& policies_;
    const decltype(Pipeline::fitter)& fitter_;
    const decltype(Pipeline::grouping)& grouping_;
    motion_type motion_;
    sequence_options options_;
    parallel threads_;
    double epsilon_;
    greedy_result result_{};
};

}  // namespace detail

}  // namespace billow::inline BILLOW_ABI
