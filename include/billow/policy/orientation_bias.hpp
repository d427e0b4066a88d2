// Which orientations a search prefers: a weight on densities when they are read.
#pragma once

#include <concepts>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Weight in (0, 1] of the planes with a given unit normal, the same for n and -n. Stored densities
/// stay as they are: the weight is applied when the densest bin is looked for. Pure.
template <class P>
concept orientation_bias = std::copyable<P> && requires(const P& weigh, const dvec3& normal) {
    { weigh(normal) }
    noexcept->std::same_as<double>;
};

/// All orientations count the same.
struct no_bias {
    [[nodiscard]] double operator()(const dvec3&) const noexcept { return 1; }
};
static_assert(orientation_bias<no_bias>);

}  // namespace billow::inline BILLOW_ABI
