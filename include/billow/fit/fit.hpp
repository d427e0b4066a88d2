// Moving a plane to the faces that it has taken: the concept of a plane fitter.
#pragma once

#include <concepts>

#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>

namespace billow::inline BILLOW_ABI {

/// Proposes a plane for all rows of `faces`, starting from `start`, whose normal has length 1. Gives
/// `start` where the faces determine none. Need not respect epsilon: the caller checks, and where
/// allows_less_contribution is false also that the faces' contribution does not fall.
template <class F>
concept plane_fitter = std::copyable<F> &&
    requires(const F& fit, const face_table& faces, const plane& start) {
    { fit(faces, start) } -> std::same_as<plane>;
    { fit.allows_less_contribution } -> std::convertible_to<bool>;
};

/// Keeps the plane.
struct no_fit {
    static constexpr bool allows_less_contribution = false;
    [[nodiscard]] plane operator()(const face_table&, const plane& start) const { return start; }
};
static_assert(plane_fitter<no_fit>);

}  // namespace billow::inline BILLOW_ABI
