// Weights of orientations that fall with every plane found, so that planes spread over directions.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 3.3, which gives
// the idea; the formula and its numbers are ours.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/plane_space/plane_space.hpp>
#include <billow/policy/orientation_bias.hpp>

namespace billow::inline BILLOW_ABI {

/// How much a plane restrains later planes of similar orientation.
struct plane_distribution {
    double strength = 0;  ///< share of the weight that the plane's own orientation loses, [0, 1];
                          ///< 0: off, 0.3 spreads planes without a need of many more
    double cutoff_deg = 25;  ///< angle to the plane from which nothing is lost, > 0
    double floor = 0.2;  ///< no weight falls below this, (0, 1]: parallel walls still get theirs
};

/// The weight of each row of a density grid: that of a bias, times what the planes so far have left.
class orientation_weights {
public:
    /// One row a cell; a row stands for the cell's centre and its opposite.
    template <orientation_bias Bias>
    orientation_weights(std::span<const orientation_cell> cells, const Bias& bias,
                        const plane_distribution& distribution)
        : distribution_(distribution), left_(cells.size(), 1.0) {
        for (const orientation_cell& cell : cells) {
            normals_.emplace_back(cell.centre);
            bias_.push_back(bias(normals_.back()));
        }
        weights_ = bias_;
    }

    [[nodiscard]] double operator[](std::size_t row) const noexcept { return weights_[row]; }

    /// Lowers the weights around the plane's normal and its opposite. Cost O(rows).
    void plane_found(const dvec3& normal) noexcept {
        if (!(distribution_.strength > 0)) return;
        for (std::size_t row = 0; row < weights_.size(); ++row) {
            const double cosine = std::min(std::abs(glm::dot(normals_[row], normal)), 1.0);
            const double angle_deg = std::acos(cosine) * 180 / std::numbers::pi;
            const double nearness = std::max(0.0, 1 - angle_deg / distribution_.cutoff_deg);
            left_[row] =
                std::max(distribution_.floor, left_[row] * (1 - distribution_.strength * nearness));
            weights_[row] = bias_[row] * left_[row];
        }
    }

private:
    plane_distribution distribution_;
    std::vector<dvec3> normals_{};
    std::vector<double> bias_{};
    std::vector<double> left_;
    std::vector<double> weights_{};
};

}  // namespace billow::inline BILLOW_ABI
