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
static_assert(falloff<no_falloff> && falloff<no_falloff, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
