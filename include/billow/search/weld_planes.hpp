// Where a vertex goes that faces on several planes share: vertex welding.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
// section 3.3; A. Fuhrmann, E. Umlauf, S. Mantler: Extreme model simplification for forest rendering.
// Eurographics Workshop on Natural Phenomena 2005, section 3.3.4.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include <billow/core/types.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/geometry/plane_intersection.hpp>

namespace billow::inline BILLOW_ABI {

enum class weld_kind {
    none,         ///< vertices stay
    first,        ///< onto the first plane of the vertex
    intersection  ///< onto the common intersection of up to three of its planes
};

struct weld_options {
    weld_kind kind = weld_kind::none;
    double min_angle = 15 * std::numbers::pi / 180;  ///< radians; a plane that is turned by less
        ///< from an earlier one of the vertex is left out; Luksch 2009 gives no number
    double tolerance = 0;  ///< vertices this close are one, scene units; 0: equal positions only
};

/// The planes that a vertex is welded to: the first ones of those it is told of.
class weld_planes {
public:
    [[nodiscard]] bool empty() const noexcept { return ids_[0] == no_id; }
    [[nodiscard]] plane_id first() const noexcept { return ids_[0]; }

    /// Takes plane `id` of `planes`, where there is room for it. Needs options.kind not none.
    /// Source: Luksch 2009, section 3.3.
    bool add(std::span<const plane> planes, plane_id id, const weld_options& options) noexcept {
        const std::size_t most = options.kind == weld_kind::first ? 1 : ids_.size();
        const double max_cosine = std::cos(options.min_angle);
        std::size_t count = 0;
        for (; count < most && ids_[count] != no_id; ++count) {
            const dvec3& normal = planes[ids_[count]].normal;
            if (std::abs(glm::dot(normal, planes[id].normal)) > max_cosine) return false;
        }
        if (count == most) return false;
        ids_[count] = id;
        return true;
    }

    /// Where the vertex goes: to the nearest point on as many of the planes as it reaches within
    /// `max_displacement`, of equally many the earliest ones.
    ///
    /// Source  Luksch 2009, section 3.3. Differs: where no two planes meet within reach, it goes
    ///         toward the nearest place where two do. Their projections of a point are apart by its
    ///         distance to their line times a sine, so no other step closes more of the crack.
    [[nodiscard]] dvec3 nearest(std::span<const plane> planes, const dvec3& vertex,
                                double max_displacement) const noexcept {
        static constexpr std::array<std::array<std::size_t, 3>, 4> tries{
            {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}};  // 3 is nobody
        if (empty() || !(max_displacement >= 0)) return vertex;
        double least = std::numeric_limits<double>::infinity();
        dvec3 step{0};
        for (const auto& some : tries) {
            std::array<plane, 3> chosen;
            std::size_t count = 0;
            bool is_known = true;
            for (const std::size_t i : some) {
                if (i == ids_.size()) continue;
                is_known = is_known && ids_[i] != no_id;
                if (is_known) chosen[count++] = planes[ids_[i]];
            }
            if (!is_known) continue;
            const auto at = nearest_common_point(std::span(chosen).first(count), vertex);
            if (!at) continue;
            const double distance = glm::distance(*at, vertex);
            if (distance <= max_displacement) return *at;
            if (count == 2 && distance < least) least = distance, step = (*at - vertex) / distance;
        }
        // Rounding up would break the promise.
        if (step != dvec3(0)) return vertex + step * (max_displacement * (1 - 1e-12));
        const plane& on = planes[first()];
        const double off = signed_distance(on, vertex);
        return std::abs(off) <= max_displacement ? vertex - on.normal * off : vertex;
    }

private:
    std::array<plane_id, 3> ids_{no_id, no_id, no_id};
};

}  // namespace billow::inline BILLOW_ABI
