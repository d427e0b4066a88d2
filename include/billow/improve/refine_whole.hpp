// Refinement of the whole: what a greedy search cannot see, for it never looks back.
//
// Planes are merged, eliminated and exchanged, then faces go to the planes they are most tangent to.
// It works on the result of any search.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/config.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/core/types.hpp>
#include <billow/fit/average.hpp>
#include <billow/improve/exchange.hpp>
#include <billow/improve/merge_planes.hpp>
#include <billow/improve/plane_cover.hpp>
#include <billow/improve/reassign.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/search/leftovers.hpp>

namespace billow::inline BILLOW_ABI {

struct whole_refinement_options {
    bool merge = true;  ///< two planes whose faces fit on one become one, those nobody needs go
    std::size_t effort = 24;  ///< exchanges to try, a part: more may find fewer planes; 0: none
    bool reassign = true;     ///< faces go to the plane they are most tangent to, planes follow
    std::size_t rounds = 8;   ///< of reassigning, at most; 0: faces move, planes do not
    float least_cosine = 0;   ///< between the normals of a face and its plane, as the search's
                              ///< contribution has it (least_cosine_of): 0 allows all
};

/// What refinement of the whole did.
struct whole_refinement_report {
    std::size_t planes_before = 0;
    std::size_t planes_after = 0;
    std::size_t merged_planes = 0;    ///< fewer by merging and elimination
    exchange_statistics exchanges{};  ///< each made is one plane fewer at least
    reassign_statistics reassigned{};
    std::size_t moved_faces = 0;  ///< that changed to another plane, but for those whose plane went
    double projected_area_share_before = 0;  ///< as in cloud_errors, of the faces of the table
    double projected_area_share_after = 0;
};

namespace detail {

/// Area-weighted mean |cosine| between the mapped faces and their planes.
[[nodiscard]] inline double projected_area_share(const face_table& faces,
                                                 const billboard_cloud& cloud) noexcept {
    double shown = 0;
    double all = 0;
    for (std::uint32_t row = 0; row < faces.size; ++row) {
        const plane_id id = cloud.plane_of_face[faces.source[row]];
        if (id == no_id) continue;
        const auto area = static_cast<double>(faces.area[row]);
        shown += area * std::abs(glm::dot(cloud.planes[id].normal, faces.normal.get(row)));
        all += area;
    }
    return all > 0 ? shown / all : 0;
}

/// One call of refine_whole.
template <class Fitter>
class whole_refiner {
public:
    whole_refiner(const face_table& faces, billboard_cloud& cloud,
                  const whole_refinement_options& options, const Fitter& fit, parallel threads,
                  const progress_function& progress)
        : faces_(faces),
          cloud_(cloud),
          options_(options),
          fit_(fit),
          threads_(threads),
          progress_(progress) {}

    [[nodiscard]] whole_refinement_report run() {
        told_.planes_before = cloud_.plane_count();
        told_.projected_area_share_before = projected_area_share(faces_, cloud_);
        result_.plane_of_face.assign(cloud_.plane_of_face.size(), no_id);
        new_id_.assign(cloud_.plane_count(), no_id);
        const auto parts = static_cast<part_id>(std::max<std::size_t>(1, cloud_.parts.size()));
        for (part_id part = 0; part < parts; ++part) refine_part(part);
        keep_drawn();
        cloud_.planes = std::move(result_.planes);
        cloud_.plane_of_face = std::move(result_.plane_of_face);
        cloud_.part_of_plane = std::move(result_.part_of_plane);
        cloud_.also_drawn = std::move(result_.also_drawn);
        cloud_.billboards.clear();
        told_.planes_after = cloud_.plane_count();
        told_.projected_area_share_after = projected_area_share(faces_, cloud_);
        report(progress_, "refine", 1);
        return told_;
    }

private:
    void refine_part(part_id part) {
        std::vector<plane_id> ids;
        std::vector<plane> planes;
        std::vector<plane_id> place(cloud_.plane_count(), no_id);
        for (plane_id id = 0; id < cloud_.plane_count(); ++id) {
            if (cloud_.part_of(id) != part) continue;
            place[id] = static_cast<plane_id>(ids.size());
            ids.push_back(id);
            planes.push_back(cloud_.planes[id]);
        }
        if (ids.empty()) return;
        face_rows rows;
        std::vector<plane_id> before;
        for (std::uint32_t row = 0; row < faces_.size; ++row) {
            const plane_id id = cloud_.plane_of_face[faces_.source[row]];
            if (id == no_id || place[id] == no_id) continue;
            rows.push_back(row);
            before.push_back(place[id]);
        }
        const face_table faces = select_rows(faces_, rows, threads_);
        plane_cover cover(faces, std::move(planes), cloud_.epsilon_of(ids.front()),
                          options_.least_cosine, threads_);
        refine(cover);

        const std::vector<plane_id> home = homes(cover, before);
        std::vector<char> is_used(cover.plane_count(), 0);
        for (const plane_id id : home) is_used[id] = 1;
        std::vector<plane_id> next(cover.plane_count(), no_id);
        for (plane_id id = 0; id < cover.plane_count(); ++id) {
            if (!is_used[id]) continue;
            next[id] = static_cast<plane_id>(result_.planes.size());
            new_id_[ids[cover.origin(id)]] = next[id];
            result_.planes.push_back(cover.planes()[id]);
            if (!cloud_.part_of_plane.empty()) result_.part_of_plane.push_back(part);
        }
        for (std::uint32_t row = 0; row < faces.size; ++row) {
            result_.plane_of_face[faces.source[row]] = next[home[row]];
            if (cover.origin(home[row]) != before[row]) ++told_.moved_faces;
        }
    }

    /// What is drawn on planes that are left, where it is still near.
    void keep_drawn() {
        if (cloud_.also_drawn.empty()) return;
        std::vector<std::uint32_t> row_of(cloud_.plane_of_face.size(), no_id);
        for (std::uint32_t row = 0; row < faces_.size; ++row) row_of[faces_.source[row]] = row;
        for (const drawn_too& drawn : cloud_.also_drawn) {
            const plane_id on = new_id_[drawn.plane];
            const std::uint32_t row = row_of[drawn.face];
            if (on == no_id || row == no_id || result_.plane_of_face[drawn.face] == on) continue;
            const double distance = distances_to(result_.planes[on], faces_, row).largest;
            if (distance <= cloud_.epsilon_of(drawn.plane)) {
                result_.also_drawn.push_back({on, drawn.face});
            }
        }
        std::ranges::sort(result_.also_drawn);
    }

    /// Merging comes again after reassigning, which has moved planes.
    void refine(plane_cover& cover) {
        std::size_t tried = 0;
        for (bool is_first = true;; is_first = false) {
            const std::size_t before = cover.plane_count();
            if (options_.merge) told_.merged_planes += merge_planes(cover, threads_);
            const exchange_statistics done =
                exchange_planes(cover, options_.effort - tried, threads_, progress_);
            tried += done.tried;
            told_.exchanges.tried += done.tried;
            told_.exchanges.made += done.made;
            if (!is_first && cover.plane_count() == before) return;
            if (!options_.reassign) return;
            const reassign_statistics moved =
                reassign_faces(cover, options_.rounds, fit_, threads_);
            told_.reassigned.rounds += moved.rounds;
            told_.reassigned.refits += moved.refits;
        }
    }

    /// The plane of each row: as before where that may be and reassigning is not asked for. Rows that
    /// are valid for none, since the search left them so, go to the plane of least error.
    [[nodiscard]] std::vector<plane_id> homes(const plane_cover& cover,
                                              const std::vector<plane_id>& before) const {
        std::vector<plane_id> home = most_tangent_planes(cover);
        if (!options_.reassign) {
            for (plane_id id = 0; id < cover.plane_count(); ++id) {
                for (const std::uint32_t row : cover.valid(id)) {
                    if (before[row] == cover.origin(id)) home[row] = id;
                }
            }
        }
        face_rows astray;
        for (std::uint32_t row = 0; row < home.size(); ++row) {
            if (home[row] == no_id) astray.push_back(row);
        }
        const std::vector<plane_id> nearest = planes_of_least_error(
            select_rows(cover.faces(), astray, threads_), cover.planes(), threads_);
        for (std::size_t i = 0; i < astray.size(); ++i) home[astray[i]] = nearest[i];
        return home;
    }

    const face_table& faces_;
    billboard_cloud& cloud_;
    const whole_refinement_options& options_;
    const Fitter& fit_;
    parallel threads_;
    const progress_function& progress_;
    billboard_cloud result_{};        ///< its planes, its faces on them
    std::vector<plane_id> new_id_{};  ///< of each plane; no_id: gone
    whole_refinement_report told_{};
};

}  // namespace detail

/// Refines a cloud as a whole, part for part: merges planes whose faces fit on one and eliminates
/// those that nobody needs (merge_planes), exchanges planes for fewer (exchange_planes), and gives
/// each face to the plane that it is most tangent to (reassign_faces).
///
/// Needs   a row of `faces` for every mapped face of `cloud`; no faces moved yet by welding, no
///         cardboard planes.
/// Gives   in `cloud` never more planes, in their order, without billboards: fit_billboards comes
///         afterwards. A face that was within epsilon of its plane is so of its new one; one that
///         was not, since the search was cut short, goes to a valid plane or that of least error.
///         No face joins a plane of another part; faces without a plane stay so. Of also_drawn what
///         still lies within epsilon of a plane that is left.
/// Fails   never.
/// Cost    see the parts; little against a search. Same result for any number of threads.
template <plane_fitter Fitter = average_fit>
whole_refinement_report refine_whole(const face_table& faces, billboard_cloud& cloud,
                                     const whole_refinement_options& options = {},
                                     const Fitter& fit = {}, parallel threads = {},
                                     const progress_function& progress = {}) {
    return detail::whole_refiner<Fitter>(faces, cloud, options, fit, threads, progress).run();
}

}  // namespace billow::inline BILLOW_ABI
