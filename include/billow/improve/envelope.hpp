// Which faces of other planes reach into what a billboard holds, so that they are drawn there, too.
//
// Huang, Novins, Wünsche, "Improved Billboard Clouds for Extreme Model Simplification", 2004, as told
// by Luksch 2009, section 2.4.
#pragma once

#include <algorithm>
#include <array>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/simd.hpp>
#include <billow/mesh/face_table.hpp>

namespace billow::inline BILLOW_ABI {

/// What is done against cracks between billboards while their textures are drawn.
enum class crack_reduction {
    none,     ///< a billboard shows its own faces and others that are valid for its plane
    envelope  ///< and those that reach into its envelope
};

/// The box of a billboard: its rectangle times the depths of its mapped faces.
class billboard_envelope {
public:
    /// `scale` shrinks or grows the box about its centre, `slack` then moves its sides outwards.
    /// Faces are relative to `origin`.
    billboard_envelope(const billboard& board, const dvec3& origin, double scale, double slack)
        : axes_{vec3(board.axes.u), vec3(board.axes.v), vec3(board.axes.normal)} {
        const dvec3 low(0, 0, board.depth_low);
        const dvec3 high(board.width, board.height, board.depth_high);
        const dvec3 half = (high - low) * (0.5 * scale) + slack;
        const dvec3 centre = board.axes.to_local(board.origin - origin) + (low + high) * 0.5;
        low_ = vec3(centre - half);
        high_ = vec3(centre + half);
    }

    /// 1 in the lanes of faces with a corner inside, 0 in the others.
    template <class V>
    [[nodiscard]] V reached_by(const face_lanes<V>& face) const noexcept {
        using lanes = simd::lanes<V>;
        V reached = lanes::fill(0);
        for (const vec3_lanes<V>& corner : face.corner) {
            V outside = lanes::fill(0);  // the farthest way out along an axis
            for (glm::length_t i = 0; i < 3; ++i) {
                const V at = dot(corner, fill_lanes<V>(axes_[static_cast<std::size_t>(i)]));
                outside = simd::max(
                    outside, simd::max(lanes::fill(low_[i]) - at, at - lanes::fill(high_[i])));
            }
            reached = simd::select(outside <= lanes::fill(0), lanes::fill(1), reached);
        }
        return reached;
    }

    /// Whether a sphere around faces leaves room for a corner inside.
    [[nodiscard]] bool may_meet(const bounding_sphere& sphere) const noexcept {
        for (glm::length_t i = 0; i < 3; ++i) {
            const double at = glm::dot(dvec3(axes_[static_cast<std::size_t>(i)]), sphere.centre);
            if (at + sphere.radius < low_[i] || at - sphere.radius > high_[i]) return false;
        }
        return true;
    }

private:
    std::array<vec3, 3> axes_;
    vec3 low_{};
    vec3 high_{};
};

}  // namespace billow::inline BILLOW_ABI
