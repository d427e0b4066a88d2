// Which of the faces that a plane may take it does take: the concept of a grouping.
#pragma once

#include <concepts>
#include <numeric>

#include <billow/core/parallel.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/search/face_sets.hpp>

namespace billow::inline BILLOW_ABI {

/// Chooses among `valid`, the faces that are valid for a plane. The others stay for later planes.
/// Gives rows of `valid`, ascending, at least one where there is one. Pure.
template <class G>
concept face_grouping = std::copyable<G> &&
    requires(const G& choose, const face_table& valid, const plane& p, double epsilon,
             parallel threads) {
    { choose(valid, p, epsilon, threads) } -> std::same_as<face_rows>;
    { G::takes_all } -> std::convertible_to<bool>;
};

/// A plane takes every face that is valid for it.
struct whole_set {
    static constexpr bool takes_all = true;

    [[nodiscard]] face_rows operator()(const face_table& valid, const plane&, double,
                                       parallel) const {
        face_rows all(valid.size);
        std::iota(all.begin(), all.end(), 0u);
        return all;
    }
};
static_assert(face_grouping<whole_set>);

}  // namespace billow::inline BILLOW_ABI
