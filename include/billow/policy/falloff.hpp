// How much less a face counts on planes that lie off the middle of its valid offsets: falloff.
#pragma once

#include <concepts>

#include <billow/core/simd.hpp>

namespace billow::inline BILLOW_ABI {

/// Weight in (0, 1] of a face on a plane whose offset is `distance` ≥ 0 from the middle of the
/// face's valid offsets; 1 at 0, falling. Pure.
template <class P, class V = float>
concept falloff = std::copyable<P> && requires(const P& weigh, V distance, V epsilon) {
    { P::falls } -> std::convertible_to<bool>;
    { weigh(distance, epsilon) }
    noexcept->std::same_as<V>;
};

/// A face counts the same on all planes that it is valid for.
struct no_falloff {
    static constexpr bool falls = false;

    template <class V>
    [[nodiscard]] V operator()(V, V) const noexcept {
        return simd::lanes<V>::fill(1);
    }
};

/// A face counts less the farther the plane is from it: half at epsilon with strength 1. It draws
/// planes to the faces that they stand for; a bound on the distance alone is content with any.
///
/// Source  Luksch 2009, section 3.2, eq 3.6, and with strength 0.25 the weaker fall to 0.8 that he
///         mentions. The whole middle bin counts fully, which eq 3.7 intends but, adding a length to
///         1, does not do: who samples the weight in bins takes half a bin off the distance.
struct distance_falloff {
    static constexpr bool falls = true;
    double strength = 1;  ///< ≥ 0; the weight at epsilon is 1 / (strength + 1); 0: always 1

    template <class V>
    [[nodiscard]] V operator()(V distance, V epsilon) const noexcept {
        const V k = simd::lanes<V>::fill(static_cast<float>(strength));
        return epsilon / (k * distance + epsilon);
    }
};

/// Where a search lets its falloff count.
enum class falloff_use {
    everywhere,  ///< in the density grid and in refinement
    refinement,  ///< in refinement only, whose bins are finer (Luksch 2009, section 3.2)
    nowhere,     ///< as if it were no_falloff
};

static_assert(falloff<no_falloff> && falloff<no_falloff, simd::wide>);
static_assert(falloff<distance_falloff> && falloff<distance_falloff, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
