// The plane that keeps its faces and takes the most of others: exact offsets, a local search for the
// normal.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>
#include <vector>

#include <billow/core/types.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/search/face_sets.hpp>

namespace billow::inline BILLOW_ABI {

/// A plane, and what it serves.
struct served_faces {
    billow::plane plane{};
    double area = -1;  ///< of the wanted faces within epsilon; < 0: some kept face is not
    double miss = 0;   ///< how far the nearest wanted face that is not served is from being so

    friend bool operator<(const served_faces& a, const served_faces& b) noexcept {
        return std::tuple(a.area, -a.miss) < std::tuple(b.area, -b.miss);
    }
};

/// Looks for a plane within epsilon of all `kept` faces that is so of `wanted` faces of most area.
///
/// For one normal the offset is exact: every face allows an interval, and the place that most of
/// them share is at the end of one. The normal is improved by a pattern search.
class most_served {
public:
    most_served(const face_table& faces, std::span<const std::uint32_t> kept,
                std::span<const std::uint32_t> wanted, double epsilon)
        : faces_(faces), kept_(kept), wanted_(wanted), epsilon_(epsilon) {}

    /// The best plane near the best of `normals`. Needs a normal. Cost about 100 times at().
    [[nodiscard]] served_faces near(std::span<const dvec3> normals) {
        static constexpr double degree = std::numbers::pi / 180;
        served_faces best = at(normals[0]);
        for (const dvec3& normal : normals.subspan(1)) best = std::max(best, at(normal));
        const double last_step = std::min(0.5 * degree, 0.2 * epsilon_ / faces_.bounds.radius);
        for (double step = 8 * degree; step >= last_step;) {
            const frame axes = frame_around(best.plane.normal);
            served_faces better = best;
            for (int k = 0; k < 8; ++k) {
                const double angle = k * std::numbers::pi / 4;
                const dvec3 aside = axes.u * std::cos(angle) + axes.v * std::sin(angle);
                better = std::max(
                    better, at(glm::normalize(axes.normal + aside * std::tan(step)), better.area));
            }
            if (best < better) {
                best = better;
            } else {
                step /= 2;
            }
        }
        return best;
    }

    /// The best plane with a normal; less than the best where it surely serves less than `beaten`.
    /// Cost O(kept + wanted · log wanted).
    [[nodiscard]] served_faces at(const dvec3& normal, double beaten = 0) {
        interval kept{-std::numeric_limits<double>::infinity(),
                      std::numeric_limits<double>::infinity()};
        for (const std::uint32_t row : kept_) {
            const interval of = offsets_of(row, normal);
            kept = {std::max(kept.low, of.low), std::min(kept.high, of.high)};
        }
        served_faces found{.plane = {normal, (kept.low + kept.high) / 2}, .area = 0};
        if (kept.low > kept.high) {
            found.area = kept.high - kept.low;
            return found;
        }
        ends_.clear();
        found.miss = std::numeric_limits<double>::infinity();
        double all = 0;
        interval shared = kept;
        for (const std::uint32_t row : wanted_) {
            const interval of = offsets_of(row, normal);
            const double low = std::max(of.low, kept.low);
            const double high = std::min(of.high, kept.high);
            if (low <= high) {
                const auto area = static_cast<double>(faces_.area[row]);
                ends_.push_back({low, area}), ends_.push_back({high, -area});
                all += area;
                shared = {std::max(shared.low, low), std::min(shared.high, high)};
            } else {
                found.miss = std::min(found.miss, low - high);
            }
        }
        if (ends_.empty()) {
            if (kept_.empty()) found.plane.rho = 0;
            return found;
        }
        if (shared.low <= shared.high) {
            found.area = all;
            found.plane.rho = (shared.low + shared.high) / 2;
            return found;
        }
        if (all < beaten) return found;
        // Intervals begin before others end at the same place: they share it.
        std::ranges::sort(ends_, [](const end& a, const end& b) {
            return std::tuple(a.rho, -a.area) < std::tuple(b.rho, -b.area);
        });
        double area = 0;
        for (std::size_t i = 0; i + 1 < ends_.size(); ++i) {
            area += ends_[i].area;
            if (area > found.area * (1 + 1e-12)) {
                found.area = area;
                found.plane.rho = (ends_[i].rho + ends_[i + 1].rho) / 2;
            }
        }
        return found;
    }

private:
    struct interval {
        double low, high;
    };
    struct end {
        double rho, area;
    };

    [[nodiscard]] interval offsets_of(std::uint32_t row, const dvec3& normal) const noexcept {
        const double a = glm::dot(normal, faces_.corner[0].get(row));
        const double b = glm::dot(normal, faces_.corner[1].get(row));
        const double c = glm::dot(normal, faces_.corner[2].get(row));
        return {std::max({a, b, c}) - epsilon_, std::min({a, b, c}) + epsilon_};
    }

    const face_table& faces_;
    std::span<const std::uint32_t> kept_;
    std::span<const std::uint32_t> wanted_;
    double epsilon_;
    std::vector<end> ends_{};
};

}  // namespace billow::inline BILLOW_ABI
