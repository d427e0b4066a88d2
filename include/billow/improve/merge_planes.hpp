// Two planes become one: merging, and the elimination of planes that nobody needs.
//
// The density search repairs none of its early choices (Décoret et al. 2003 choose greedily). Here
// pairs of its planes are tried again, knowing all the others.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/improve/joint_plane.hpp>
#include <billow/improve/plane_cover.hpp>

namespace billow::inline BILLOW_ABI {

/// Two planes, and one that can replace them.
struct merge_candidate {
    plane_id first = no_id;
    plane_id second = no_id;
    billow::plane plane{};
    double loss = 0;  ///< of projected area, scene units squared: how much worse it shows the faces
};

namespace detail {

/// One call of merge_planes.
class plane_merger {
public:
    plane_merger(plane_cover& cover, parallel threads) : cover_(cover), threads_(threads) {}

    std::size_t run() {
        const std::size_t before = cover_.plane_count();
        eliminate();
        while (merge_once()) eliminate();
        return before - cover_.plane_count();
    }

    /// Pairs whose joint width may be at most `reach` epsilons, by what bounds it from below.
    [[nodiscard]] std::vector<std::pair<plane_id, plane_id>> near_pairs(double reach) const {
        const std::vector<plane_faces> of = faces_of_all();
        std::vector<std::vector<std::tuple<double, plane_id, plane_id>>> near(of.size());
        for_each_near_pair(of, reach, [&](plane_id a, plane_id b, const face_rows&, double bound) {
            near[a].emplace_back(bound, a, b);
        });
        std::vector<std::tuple<double, plane_id, plane_id>> all;
        for (const auto& some : near) all.insert(all.end(), some.begin(), some.end());
        std::ranges::sort(all);
        std::vector<std::pair<plane_id, plane_id>> pairs;
        pairs.reserve(all.size());
        for (const auto& [bound, a, b] : all) pairs.emplace_back(a, b);
        return pairs;
    }

private:
    /// Removes planes all of whose faces are valid for others, those of least area first. One stays,
    /// for faces that are valid for none.
    void eliminate() {
        for (bool again = true; again && cover_.plane_count() > 1;) {
            again = false;
            double least = std::numeric_limits<double>::infinity();
            plane_id worst = no_id;
            for (plane_id id = 0; id < cover_.plane_count(); ++id) {
                if (!cover_.essential(id).empty()) continue;
                const double area =
                    projected_area_of(cover_.faces(), cover_.valid(id), cover_.planes()[id].normal);
                if (area < least) least = area, worst = id;
            }
            if (worst != no_id) cover_.remove(worst), again = true;
        }
    }

    /// Merges what can be merged now, by least loss, each plane once.
    bool merge_once() {
        std::vector<merge_candidate> found = candidates();
        std::ranges::sort(found, {}, [](const merge_candidate& c) {
            return std::tuple(c.loss, c.first, c.second);
        });
        std::vector<char> is_touched(cover_.plane_count(), 0);
        std::vector<plane_id> gone;
        for (const merge_candidate& c : found) {
            if (is_touched[c.first] || is_touched[c.second]) continue;
            const plane merged = canonical(c.plane);
            face_rows rows = cover_.rows_for(merged);
            // Earlier merges may have left these two more faces to care for.
            if (!std::ranges::includes(rows, needed_of(c.first, c.second))) continue;
            cover_.move(c.first, merged, std::move(rows));
            cover_.move(c.second, merged, {});
            is_touched[c.first] = is_touched[c.second] = 1;
            gone.push_back(c.second);
        }
        std::ranges::sort(gone, std::greater{});
        for (const plane_id id : gone) cover_.remove(id);
        return !gone.empty();
    }

    /// The faces that no plane but these two can take.
    [[nodiscard]] face_rows needed_of(plane_id a, plane_id b) const {
        const face_rows both = united(cover_.valid(a), cover_.valid(b));
        face_rows needed;
        std::size_t in_a = 0, in_b = 0;
        const auto holds = [](const face_rows& rows, std::size_t& at, std::uint32_t row) {
            while (at < rows.size() && rows[at] < row) ++at;
            return at < rows.size() && rows[at] == row ? 1u : 0u;
        };
        for (const std::uint32_t row : both) {
            const std::uint32_t here =
                holds(cover_.valid(a), in_a, row) + holds(cover_.valid(b), in_b, row);
            if (cover_.counts()[row] == here) needed.push_back(row);
        }
        return needed;
    }

    struct plane_faces {
        face_rows essential{};
        face_rows core{};
        dvec3 middle{0};
        std::array<dvec3, 3> triangle{};
    };

    [[nodiscard]] std::vector<plane_faces> faces_of_all() const {
        std::vector<plane_faces> of(cover_.plane_count());
        threads_.for_chunks(of.size(), 1, [&](std::size_t id, std::size_t) {
            of[id].essential = cover_.essential(static_cast<plane_id>(id));
            of[id].core = extreme_rows(cover_.faces(), of[id].essential);
            for (const std::uint32_t row : of[id].core) {
                of[id].middle += cover_.faces().centroid(row) / double(of[id].core.size());
            }
            if (!of[id].core.empty()) of[id].triangle = wide_triangle(cover_.faces(), of[id].core);
        });
        return of;
    }

    /// Calls `use(a, b, core, bound)` for a < b that are not surely wider than `reach` epsilons; in
    /// parallel, but for one a after the other.
    template <class Use>
    void for_each_near_pair(const std::vector<plane_faces>& of, double reach,
                            const Use& use) const {
        threads_.for_chunks(of.size(), 1, [&](std::size_t a, std::size_t) {
            for (std::size_t b = a + 1; b < of.size(); ++b) {
                if (of[a].core.empty() || of[b].core.empty()) continue;
                double bound = std::max(least_width(cover_.faces(), of[b].core, of[a].triangle),
                                        least_width(cover_.faces(), of[a].core, of[b].triangle));
                if (bound > reach * cover_.epsilon()) continue;
                const face_rows core = united(of[a].core, of[b].core);
                const auto triangle = wide_triangle(cover_.faces(), core);
                bound = std::max(bound, least_width(cover_.faces(), core, triangle));
                if (bound > reach * cover_.epsilon()) continue;
                use(static_cast<plane_id>(a), static_cast<plane_id>(b), core, bound);
            }
        });
    }

    /// All pairs that one plane can replace.
    [[nodiscard]] std::vector<merge_candidate> candidates() const {
        const face_table& faces = cover_.faces();
        const std::vector<plane_faces> of = faces_of_all();
        const std::vector<plane_pair> shared = cover_.essential_pairs();
        std::vector<std::vector<merge_candidate>> found(of.size());
        for_each_near_pair(of, 2, [&](plane_id a, plane_id b, face_rows core, double) {
            face_rows rows = united(of[a].essential, of[b].essential);
            const auto key = [](const plane_pair& p) { return std::pair(p.first, p.second); };
            const auto both = std::ranges::lower_bound(shared, std::pair(a, b), {}, key);
            if (both != shared.end() && both->first == a && both->second == b) {
                rows = united(rows, both->rows);
                core = united(core, extreme_rows(faces, both->rows));
            }
            const dvec3& n = cover_.planes()[a].normal;
            const dvec3& m = cover_.planes()[b].normal;
            const std::optional<plane> joint = joint_plane(
                faces, rows, std::move(core), joint_normals(n, m, of[b].middle - of[a].middle),
                cover_.exact_epsilon());
            if (!joint) return;
            const dvec3& merged = joint->normal;
            const auto loss = [&](const face_rows& some, const dvec3& normal) {
                return projected_area_of(faces, some, normal) -
                       projected_area_of(faces, some, merged);
            };
            found[a].push_back({a, b, *joint, loss(of[a].essential, n) + loss(of[b].essential, m)});
        });
        std::vector<merge_candidate> all;
        for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
        return all;
    }

    plane_cover& cover_;
    parallel threads_;
};

}  // namespace detail

/// Merges pairs of planes until none is left whose faces fit on one: those that no third plane can
/// take must have a joint width of at most 2 epsilon. Of the pairs that do, those that lose least
/// projected area come first. Planes that nobody needs go before.
///
/// Gives   how many planes are fewer. Every face that had a valid plane still has one.
/// Cost    O(planes² · 100) for the pairs that a bound rules out, joint_plane for the others, a few
///         rounds; parallel.
inline std::size_t merge_planes(plane_cover& cover, parallel threads = {}) {
    return detail::plane_merger(cover, threads).run();
}

}  // namespace billow::inline BILLOW_ABI
