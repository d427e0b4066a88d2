// Which offsets a face allows for an orientation: validity.
//
// A vertex is valid for a plane when it lies within epsilon of it, a face when its three vertices
// are. For one normal n these are the offsets [max n·v - eps, min n·v + eps]. Over a cell of normals
// the interval can only be estimated; Luksch 2009 (sections 2.1, 3.2) and Fuhrmann et al. 2005
// (section 3.2.1) describe different estimates of this "simple validity".
#pragma once

#include <algorithm>
#include <concepts>
#include <limits>

#include <billow/core/simd.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/plane_space/plane_space.hpp>

namespace billow::inline BILLOW_ABI {

/// Offsets from low to high; empty when low > high.
template <class V>
struct offset_interval {
    V low, high;
};

/// An orientation cell in every lane.
template <class V>
struct cell_lanes {
    vec3_lanes<V> centre;
    std::array<vec3_lanes<V>, 4> corner;
    V chord;

    explicit cell_lanes(const orientation_cell& cell) noexcept
        : centre(fill_lanes<V>(cell.centre)),
          corner{fill_lanes<V>(cell.corner[0]), fill_lanes<V>(cell.corner[1]),
                 fill_lanes<V>(cell.corner[2]), fill_lanes<V>(cell.corner[3])},
          chord(simd::lanes<V>::fill(cell.chord)) {}
};

/// Estimates the offsets that a face allows within a cell of normals. Pure.
template <class P, class V = float>
concept validity = std::copyable<P> &&
    requires(const P& estimate, const face_lanes<V>& face, const cell_lanes<V>& cell, V epsilon) {
    { estimate(face, cell, epsilon) }
    noexcept->std::same_as<offset_interval<V>>;
};

/// The exact offsets for one normal. Source: Luksch 2009, section 2.1.
template <class V>
[[nodiscard]] inline offset_interval<V> valid_offsets(const face_lanes<V>& face,
                                                      const vec3_lanes<V>& normal,
                                                      V epsilon) noexcept {
    const V a = dot(normal, face.corner[0]);
    const V b = dot(normal, face.corner[1]);
    const V c = dot(normal, face.corner[2]);
    return {simd::max(simd::max(a, b), c) - epsilon, simd::min(simd::min(a, b), c) + epsilon};
}

/// Estimate A: the hull of the exact intervals at the cell's corners and centre. Never too wide, may
/// miss. The right estimate of a density.
///
/// Source: Luksch 2009, section 2.1. Differs by the centre, without which a plane that the space
/// samples exactly can go unseen: two walls 1.9 epsilon apart share only planes so close to their own
/// normal that no corner has one (the "diamond" of the thesis's Figure 3.6).
struct hull_of_samples {
    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const face_lanes<V>& face,
                                                const cell_lanes<V>& cell,
                                                V epsilon) const noexcept {
        const V far = simd::lanes<V>::fill(std::numeric_limits<float>::max());
        offset_interval<V> hull{far, -far};
        const auto widen = [&](const vec3_lanes<V>& normal) {
            const offset_interval<V> at = valid_offsets(face, normal, epsilon);
            // An empty interval is moved out of the way: cheaper than to choose both ends.
            const V aside = simd::select(at.low <= at.high, simd::lanes<V>::fill(0), far);
            hull.low = simd::min(hull.low, at.low + aside);
            hull.high = simd::max(hull.high, at.high - aside);
        };
        widen(cell.centre);
        widen(cell.corner[0]);
        widen(cell.corner[1]);
        widen(cell.corner[2]);
        widen(cell.corner[3]);
        return hull;
    }
};

/// Estimate B: each vertex takes the hull of its intervals at the corners, the face their
/// intersection. Holds A; a third of the invalid faces pass. Source: Fuhrmann et al. 2005, 3.2.1.
struct intersection_of_vertices {
    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const face_lanes<V>& face,
                                                const cell_lanes<V>& cell,
                                                V epsilon) const noexcept {
        const V far = simd::lanes<V>::fill(std::numeric_limits<float>::max());
        offset_interval<V> meet{-far, far};
        for (const vec3_lanes<V>& vertex : face.corner) {
            const V a = dot(cell.corner[0], vertex);
            const V b = dot(cell.corner[1], vertex);
            const V c = dot(cell.corner[2], vertex);
            const V d = dot(cell.corner[3], vertex);
            const V least = simd::min(simd::min(a, b), simd::min(c, d));
            const V most = simd::max(simd::max(a, b), simd::max(c, d));
            meet.low = simd::max(meet.low, least - epsilon);
            meet.high = simd::min(meet.high, most + epsilon);
        }
        return meet;
    }
};

/// Estimate C: the interval of the cell's centre, widened by how far a vertex can move against the
/// plane when the normal goes to the rim of the cell. Never misses a valid plane; the right filter
/// for candidates, the wrong density.
///
/// Derived: |n·v - n_c·v| ≤ |n - n_c| |v| ≤ 2 sin(delta/2) |v| for the half diagonal delta. We take
/// the face's farthest vertex for all three, which is one column instead of three square roots.
struct widened_centre {
    template <class V>
    [[nodiscard]] offset_interval<V> operator()(const face_lanes<V>& face,
                                                const cell_lanes<V>& cell,
                                                V epsilon) const noexcept {
        return valid_offsets(face, cell.centre, epsilon + cell.chord * face.reach);
    }
};

static_assert(validity<hull_of_samples> && validity<hull_of_samples, simd::wide>);
static_assert(validity<intersection_of_vertices> && validity<intersection_of_vertices, simd::wide>);
static_assert(validity<widened_centre> && validity<widened_centre, simd::wide>);

}  // namespace billow::inline BILLOW_ABI
