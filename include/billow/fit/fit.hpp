// Moving a plane to the faces that it has taken: the concept of a plane fitter.
#pragma once

#include <concepts>

#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>

namespace billow::inline BILLOW_ABI {

/// Proposes a plane for all rows of `faces`, starting from `start`, whose normal has length 1. Gives
/// `start` where the faces determine none. Need not respect epsilon: the caller
/// checks.
template <class F>
concept plane_fitter = std::copyable<F> &&
    requires(const F& fit, const face_table& faces, const plane& start) {
    { fit(faces, start) } -> std::same_as<plane>;
};

/// Keeps the plane.
struct no_fit {
    [[nodiscard]] plane operator()(const face_table&, const plane& start) const { return start; }
};
static_assert(plane_fitter<no_fit>);

}  // namespace billow::inline BILLOW_ABI
