// Which faces each plane of a cloud may take, and which of them no other plane would.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/policy/contribution.hpp>
#include <billow/search/face_sets.hpp>

namespace billow::inline BILLOW_ABI {

/// Two planes, and the faces that these two alone can take.
struct plane_pair {
    plane_id first = no_id;
    plane_id second = no_id;
    face_rows rows{};
};

/// Planes, and the faces that lie within epsilon of each: a cover of the faces, in the words of the
/// set cover problem that a billboard cloud is.
///
/// Shape   P planes; `valid`: for each the rows of the table that it may take, ascending; `count`:
///         for each row the number of planes that may take it.
/// Unit    planes and epsilon as in the table.
class plane_cover {
public:
    /// The bound holds for the mesh's own vertices, as in greedy_search: columns hold floats.
    /// `least_cosine` as a contribution's, see least_cosine_of. `faces` must outlive the cover.
    plane_cover(const face_table& faces, std::vector<plane> planes, double epsilon,
                float least_cosine, parallel threads)
        : faces_(faces),
          threads_(threads),
          epsilon_(std::max(epsilon - 1e-6 * faces.bounds.radius, epsilon / 2)),
          planes_(std::move(planes)),
          counts_(faces.size, 0),
          origins_(planes_.size()) {
        worth_.least_cosine = least_cosine;
        std::iota(origins_.begin(), origins_.end(), 0u);
        for (const plane& p : planes_) {
            valid_.push_back(rows_for(p));
            add(counts_, valid_.back());
        }
    }

    [[nodiscard]] const face_table& faces() const noexcept { return faces_; }
    [[nodiscard]] double epsilon() const noexcept { return epsilon_; }
    /// The bound for who computes in double: the columns' floats then find the same faces valid.
    [[nodiscard]] double exact_epsilon() const noexcept {
        return std::max(epsilon_ - 1e-6 * faces_.bounds.radius, epsilon_ / 2);
    }
    [[nodiscard]] std::size_t plane_count() const noexcept { return planes_.size(); }
    [[nodiscard]] const std::vector<plane>& planes() const noexcept { return planes_; }
    /// Which of the first planes this one was, however it has moved.
    [[nodiscard]] plane_id origin(plane_id id) const noexcept { return origins_[id]; }
    [[nodiscard]] const face_rows& valid(plane_id id) const noexcept { return valid_[id]; }
    [[nodiscard]] const std::vector<std::uint32_t>& counts() const noexcept { return counts_; }

    /// The rows that any plane may take.
    [[nodiscard]] face_rows rows_for(const plane& p) const { return rows_for(p, threads_); }
    [[nodiscard]] face_rows rows_for(const plane& p, parallel threads) const {
        return faces_valid_for(faces_, p, epsilon_, worth_, threads);
    }

    /// The rows that only this plane can take.
    [[nodiscard]] face_rows essential(plane_id id) const { return essential(id, counts_); }
    /// The same where the planes are counted otherwise.
    [[nodiscard]] face_rows essential(plane_id id, std::span<const std::uint32_t> counts) const {
        face_rows rows;
        for (const std::uint32_t row : valid_[id]) {
            if (counts[row] == 1) rows.push_back(row);
        }
        return rows;
    }
    /// The pairs of planes that alone can take some faces, with these, ascending.
    [[nodiscard]] std::vector<plane_pair> essential_pairs() const;

    /// Puts another plane in the place of one. Needs `rows` as rows_for(p).
    void move(plane_id id, const plane& p, face_rows rows) {
        subtract(counts_, valid_[id]);
        planes_[id] = p;
        valid_[id] = std::move(rows);
        add(counts_, valid_[id]);
    }
    /// Later planes move up by one.
    void remove(plane_id id) {
        subtract(counts_, valid_[id]);
        planes_.erase(planes_.begin() + static_cast<std::ptrdiff_t>(id));
        valid_.erase(valid_.begin() + static_cast<std::ptrdiff_t>(id));
        origins_.erase(origins_.begin() + static_cast<std::ptrdiff_t>(id));
    }

    static void add(std::span<std::uint32_t> counts, const face_rows& rows) noexcept {
        for (const std::uint32_t row : rows) ++counts[row];
    }
    static void subtract(std::span<std::uint32_t> counts, const face_rows& rows) noexcept {
        for (const std::uint32_t row : rows) --counts[row];
    }

private:
    const face_table& faces_;
    parallel threads_;
    double epsilon_;
    within_angle<> worth_{projected_area{}, 90};
    std::vector<plane> planes_;
    std::vector<face_rows> valid_{};
    std::vector<std::uint32_t> counts_;
    std::vector<plane_id> origins_;
};

inline std::vector<plane_pair> plane_cover::essential_pairs() const {
    struct shared_row {
        plane_id first, second;
        std::uint32_t row;
        // NOLINTNEXTLINE(modernize-use-nullptr): the 0 is of the comparison that the compiler writes
        auto operator<=>(const shared_row&) const = default;
    };
    std::vector<plane_id> first(faces_.size, no_id);
    std::vector<shared_row> shared;
    for (plane_id id = 0; id < planes_.size(); ++id) {
        for (const std::uint32_t row : valid_[id]) {
            if (counts_[row] != 2) continue;
            if (first[row] == no_id) {
                first[row] = id;
            } else {
                shared.push_back({first[row], id, row});
            }
        }
    }
    std::sort(shared.begin(), shared.end());
    std::vector<plane_pair> pairs;
    for (const shared_row& s : shared) {
        if (pairs.empty() || pairs.back().first != s.first || pairs.back().second != s.second) {
            pairs.push_back({s.first, s.second, {}});
        }
        pairs.back().rows.push_back(s.row);
    }
    return pairs;
}

/// Area of the given rows as a plane with `normal` shows it.
[[nodiscard]] inline double projected_area_of(const face_table& faces,
                                              std::span<const std::uint32_t> rows,
                                              const dvec3& normal) noexcept {
    double sum = 0;
    for (const std::uint32_t row : rows) {
        sum += static_cast<double>(faces.area[row]) *
               std::abs(glm::dot(normal, faces.normal.get(row)));
    }
    return sum;
}

/// All rows of both, ascending. Needs ascending rows.
[[nodiscard]] inline face_rows united(const face_rows& a, const face_rows& b) {
    face_rows both;
    both.reserve(a.size() + b.size());
    std::ranges::set_union(a, b, std::back_inserter(both));
    return both;
}

}  // namespace billow::inline BILLOW_ABI
