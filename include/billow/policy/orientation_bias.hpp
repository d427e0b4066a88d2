// Which orientations a search prefers: a weight on densities when they are read.
//
// Fuhrmann, Umlauf, Mantler: Extreme model simplification for forest rendering. 2005, section 3.3.5.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>
#include <tuple>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Weight in (0, 1] of the planes with a given unit normal, the same for n and -n. Stored densities
/// stay as they are: the weight is applied when the densest bin is looked for. Pure.
template <class P>
concept orientation_bias = std::copyable<P> && requires(const P& weigh, const dvec3& normal) {
    { weigh(normal) }
    noexcept->std::same_as<double>;
};

/// A density as a search with that weight, > 0, reads it. Below 0 the density is divided: multiplied,
/// a small weight would be a reward.
[[nodiscard]] inline double biased(double density, double weight) noexcept {
    return density > 0 ? density * weight : density / weight;
}

/// All orientations count the same.
struct no_bias {
    [[nodiscard]] double operator()(const dvec3&) const noexcept { return 1; }
};

namespace detail {

/// 1 up to the cutoff, then falling with the angle to 1 - share at 90°.
[[nodiscard]] inline double slope_weight(double angle_deg, double share,
                                         double cutoff_deg) noexcept {
    // A share of 1 would forbid planes that some faces need.
    constexpr double most = 0.999;
    const double beyond = std::clamp((angle_deg - cutoff_deg) / (90 - cutoff_deg), 0.0, 1.0);
    return 1 - std::min(share, most) * beyond;
}

/// Angle between a plane's unit normal and the ground, in degrees: 90 for a horizontal plane.
[[nodiscard]] inline double elevation_deg(const dvec3& normal, const dvec3& up) noexcept {
    return std::asin(std::min(std::abs(glm::dot(normal, up)), 1.0)) * 180 / std::numbers::pi;
}

}  // namespace detail

/// Makes horizontal planes rare, for viewers near the ground: layers of foliage that one flat plane
/// could hold would be invisible from the side.
///
/// Source: Fuhrmann et al. 2005, section 3.3.5, with its 60 % and 50°.
struct horizontal_penalty {
    double share = 0.60;     ///< of the density that horizontal planes lose, [0, 1]; 0: off
    double cutoff_deg = 50;  ///< elevation of the normal from which the loss grows, [0, 90)
    dvec3 up{0, 1, 0};       ///< unit length

    [[nodiscard]] double operator()(const dvec3& normal) const noexcept {
        return detail::slope_weight(detail::elevation_deg(normal, up), share, cutoff_deg);
    }
};

/// The mirror of horizontal_penalty: makes vertical planes rare, for viewers who fly over.
struct vertical_penalty {
    double share = 0.60;     ///< of the density that vertical planes lose, [0, 1]; 0: off
    double cutoff_deg = 50;  ///< angle of the normal to `up` from which the loss grows, [0, 90)
    dvec3 up{0, 1, 0};       ///< unit length

    [[nodiscard]] double operator()(const dvec3& normal) const noexcept {
        return detail::slope_weight(90 - detail::elevation_deg(normal, up), share, cutoff_deg);
    }
};

/// Both penalties around one axis, each of them off at a share of 0.
struct viewpoint_bias {
    double horizontal_share = 0;  ///< see horizontal_penalty
    double vertical_share = 0;    ///< see vertical_penalty
    double cutoff_deg = 50;       ///< of both, [0, 90)
    dvec3 up{0, 1, 0};            ///< unit length

    [[nodiscard]] double operator()(const dvec3& normal) const noexcept {
        const horizontal_penalty horizontal{horizontal_share, cutoff_deg, up};
        const vertical_penalty vertical{vertical_share, cutoff_deg, up};
        return horizontal(normal) * vertical(normal);
    }
};

/// The product of several biases.
template <orientation_bias... Biases>
struct combined_bias {
    std::tuple<Biases...> biases{};

    combined_bias() = default;
    explicit combined_bias(const Biases&... all) requires(sizeof...(Biases) > 0) : biases(all...) {}

    [[nodiscard]] double operator()(const dvec3& normal) const noexcept {
        return std::apply([&](const Biases&... all) { return (1.0 * ... * all(normal)); }, biases);
    }
};

static_assert(orientation_bias<no_bias> && orientation_bias<horizontal_penalty> &&
              orientation_bias<vertical_penalty> && orientation_bias<viewpoint_bias> &&
              orientation_bias<combined_bias<horizontal_penalty, vertical_penalty>>);

}  // namespace billow::inline BILLOW_ABI
