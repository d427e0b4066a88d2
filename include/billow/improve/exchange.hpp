// Exchanges: planes go, others move or come to take their faces, and one plane fewer is left.
//
// Local search for the set cover problem: k sets are exchanged for fewer. Here sets are not given:
// every plane may be moved, as long as it keeps the faces that nobody else can take.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <tuple>
#include <utility>
#include <vector>

#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/core/types.hpp>
#include <billow/improve/joint_plane.hpp>
#include <billow/improve/merge_planes.hpp>
#include <billow/improve/plane_cover.hpp>
#include <billow/improve/serve_most.hpp>
#include <billow/search/leftovers.hpp>

namespace billow::inline BILLOW_ABI {

/// What exchanging did.
struct exchange_statistics {
    std::size_t tried = 0;
    std::size_t made = 0;
};

namespace detail {

/// Planes that an exchange removes, and how others change.
struct exchange_plan {
    struct change {
        plane_id id;
        billow::plane plane;
        face_rows rows;
    };
    bool works = false;
    std::vector<change> changes{};
};

/// One call of exchange_planes.
class plane_exchanger {
public:
    plane_exchanger(plane_cover& cover, parallel threads) : cover_(cover), threads_(threads) {}

    [[nodiscard]] exchange_statistics run(std::size_t effort, const progress_function& progress) {
        exchange_statistics told;
        if (effort == 0) return told;
        std::vector<trial> trials = all_trials();
        for (std::size_t next = 0; next < trials.size() && told.tried < effort;) {
            if (cover_.plane_count() < 2) break;
            const std::size_t some = std::min({batch, trials.size() - next, effort - told.tried});
            std::vector<exchange_plan> plans(some);
            std::vector<std::vector<std::uint32_t>> scratches(
                std::min<std::size_t>(threads_.count(), some));
            for_jobs(threads_, some, scratches, [&](std::size_t i, auto& counts) {
                plans[i] = plan(trials[next + i], counts);
            });
            const auto good = std::ranges::find_if(plans, &exchange_plan::works);
            const auto failed = static_cast<std::size_t>(good - plans.begin());
            told.tried += failed;
            next += failed;
            if (good != plans.end()) {
                ++told.tried, ++told.made;
                make(trials[next], *good);
                merge_planes(cover_, threads_);
                trials = all_trials();
                next = 0;
            }
            report(progress, "exchange",
                   static_cast<double>(told.tried) / static_cast<double>(effort));
        }
        return told;
    }

private:
    /// The plane that goes; with a second one, that may become any other.
    struct trial {
        plane_id removed = no_id;
        plane_id freed = no_id;
    };

    static constexpr std::size_t batch = 8;      // fixed, so that threads do not matter
    static constexpr std::size_t receivers = 8;  // planes that may move in one trial
    static constexpr double reach = 4;           // epsilons that a pair may be wide, to be tried
    static constexpr double far = 3;  // epsilons to a plane that will hardly be moved so much
    static constexpr std::size_t most_wanted = 128;  // faces that steer the search for a plane

    /// Single planes, those of least area first, and by turns with them near pairs, narrowest first.
    [[nodiscard]] std::vector<trial> all_trials() {
        std::vector<std::pair<double, plane_id>> singles;
        for (plane_id id = 0; id < cover_.plane_count(); ++id) {
            double area = 0;
            for (const std::uint32_t row : cover_.essential(id)) {
                area += static_cast<double>(cover_.faces().area[row]);
            }
            singles.emplace_back(area, id);
        }
        std::ranges::sort(singles);
        const auto pairs = plane_merger(cover_, threads_).near_pairs(reach);
        std::vector<trial> trials;
        for (std::size_t i = 0; i < std::max(singles.size(), pairs.size()); ++i) {
            if (i < singles.size()) trials.push_back({singles[i].second, no_id});
            if (i < pairs.size()) trials.push_back({pairs[i].first, pairs[i].second});
        }
        return trials;
    }

    void make(const trial& t, exchange_plan& plan) {
        for (auto& change : plan.changes) {
            cover_.move(change.id, change.plane, std::move(change.rows));
        }
        cover_.remove(t.removed);
    }

    [[nodiscard]] exchange_plan plan(const trial& t, std::vector<std::uint32_t>& counts) const {
        exchange_plan result;
        counts = cover_.counts();
        plane_cover::subtract(counts, cover_.valid(t.removed));
        face_rows touched = cover_.valid(t.removed);
        if (t.freed != no_id) {
            plane_cover::subtract(counts, cover_.valid(t.freed));
            touched = united(touched, cover_.valid(t.freed));
        }
        face_rows orphans;
        for (const std::uint32_t row : touched) {
            if (counts[row] == 0) orphans.push_back(row);
        }
        if (t.freed != no_id) serve(t, t.freed, {}, counts, orphans, result);
        for (const plane_id id : nearest_receivers(t, orphans)) {
            if (orphans.empty()) break;
            serve(t, id, cover_.essential(id, counts), counts, orphans, result);
        }
        result.works = orphans.empty();
        return result;
    }

    /// Moves plane `id`, which must keep some faces, to where it takes the most of the orphans.
    void serve(const trial& t, plane_id id, const face_rows& kept,
               std::vector<std::uint32_t>& counts, face_rows& orphans,
               exchange_plan& result) const {
        const face_table& faces = cover_.faces();
        const double epsilon = cover_.exact_epsilon();
        face_rows core = extreme_rows(faces, kept);
        const face_rows wanted = thinned(orphans);
        const dvec3 from = cover_.planes()[id].normal;
        dvec3 apart{0};
        for (const std::uint32_t row : core) apart -= faces.centroid(row) / double(core.size());
        for (const std::uint32_t row : wanted) apart += faces.centroid(row) / double(wanted.size());
        const std::vector<dvec3> normals =
            joint_normals(from, cover_.planes()[t.removed].normal, apart);
        served_faces found;
        for (int round = 0; round < 6; ++round) {
            found = most_served(faces, core, wanted, epsilon).near(normals);
            if (!(found.area > 0)) return;
            const face_extent_along all = extent_along(faces, kept, found.plane.normal);
            const double rho = found.plane.rho;
            const bool keeps_low = kept.empty() || rho - all.low <= epsilon;
            const bool keeps_high = kept.empty() || all.high - rho <= epsilon;
            if (keeps_low && keeps_high) break;
            if (!keeps_low) core.push_back(all.low_row);
            if (!keeps_high) core.push_back(all.high_row);
        }
        face_rows rows = cover_.rows_for(found.plane, parallel{1});
        if (!std::ranges::includes(rows, kept)) return;
        face_rows left;
        std::ranges::set_difference(orphans, rows, std::back_inserter(left));
        if (left.size() == orphans.size()) return;
        if (id != t.freed) plane_cover::subtract(counts, cover_.valid(id));
        plane_cover::add(counts, rows);
        orphans = std::move(left);
        result.changes.push_back({id, canonical(found.plane), std::move(rows)});
    }

    /// The planes that the orphans are nearest to; none when one of them is far from all.
    [[nodiscard]] std::vector<plane_id> nearest_receivers(const trial& t,
                                                          const face_rows& orphans) const {
        const face_rows some = thinned(orphans);
        std::vector<double> nearest(some.size(), far);
        std::vector<std::pair<double, plane_id>> order;
        for (plane_id id = 0; id < cover_.plane_count(); ++id) {
            if (id == t.removed || id == t.freed) continue;
            double sum = 0;
            for (std::size_t i = 0; i < some.size(); ++i) {
                const double farthest =
                    distances_to(cover_.planes()[id], cover_.faces(), some[i]).largest;
                const double d = std::min(farthest / cover_.epsilon(), far);
                nearest[i] = std::min(nearest[i], d);
                sum += d;
            }
            if (sum < far * double(some.size())) order.emplace_back(sum, id);
        }
        std::vector<plane_id> ids;
        if (std::ranges::find(nearest, far) != nearest.end()) return ids;
        std::ranges::sort(order);
        for (const auto& [sum, id] : order) {
            if (ids.size() < receivers) ids.push_back(id);
        }
        return ids;
    }

    /// Few of many rows, evenly.
    [[nodiscard]] static face_rows thinned(const face_rows& rows) {
        if (rows.size() <= most_wanted) return rows;
        face_rows some;
        for (std::size_t i = 0; i < most_wanted; ++i) {
            some.push_back(rows[i * rows.size() / most_wanted]);
        }
        return some;
    }

    plane_cover& cover_;
    parallel threads_;
};

}  // namespace detail

/// Tries to do with one plane fewer, again and again: removes a plane and moves others, one after
/// the other, to where they take the most of its faces and keep their own; or removes two that are
/// near and puts one anywhere, then moves others for what is left.
///
/// Gives   what was done. Every face that had a valid plane still has one.
/// Cost    `effort` trials at most, by number, not by time: the same result on any machine. A trial
///         is about a thousand passes over a few faces and a few over all; parallel.
inline exchange_statistics exchange_planes(plane_cover& cover, std::size_t effort,
                                           parallel threads = {},
                                           const progress_function& progress = {}) {
    return detail::plane_exchanger(cover, threads).run(effort, progress);
}

}  // namespace billow::inline BILLOW_ABI
