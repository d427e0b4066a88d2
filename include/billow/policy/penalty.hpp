// What a plane is charged for the faces that it just misses: penalty.
#pragma once

#include <concepts>

#include <billow/core/simd.hpp>
#include <billow/policy/validity.hpp>

namespace billow::inline BILLOW_ABI {

/// The offsets at which a plane is charged for a face, given those where the face is valid, for the
/// side rho ≥ 0 of a normal. The charge is `weight` times the face's contribution. Pure.
template <class P, class V = float>
concept penalty = std::copyable<P> &&
    requires(const P& charge, const offset_interval<V>& valid, V epsilon) {
    { charge(valid, epsilon) }
    noexcept->std::same_as<offset_interval<V>>;
    { charge.weight } -> std::convertible_to<double>;
};

/// Charges planes that lie up to epsilon further in than a face allows, which draws planes to the
/// outline. One-sided: charges on both sides would cancel out.
///
/// Source: Décoret et al. 2003 with weight 10; Luksch 2009, eq 2.3 and section 5.2, advises 2 to 5.
struct inner_side_penalty {
    double weight = 3;  ///< ≥ 0; more keeps planes closer to the outline, too much finds none

    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const offset_interval<V>& valid,
                                                V epsilon) const noexcept {
        return {valid.low - epsilon, valid.low};
    }
};

/// Charges nothing.
struct no_penalty {
    static constexpr double weight = 0;

    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const offset_interval<V>& valid, V) const noexcept {
        return {valid.low, valid.low};
    }
};

static_assert(penalty<inner_side_penalty> && penalty<inner_side_penalty, simd::wide>);
static_assert(penalty<no_penalty> && penalty<no_penalty, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
