// Which faces are drawn on each billboard: its own, and every other one that lies close enough to
// its plane or reaches into its envelope. The latter close cracks between planes.
//
// Décoret et al. 2003 and Fuhrmann et al. 2005 draw all faces valid for the plane, Huang et al. 2004
// those in its envelope.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <billow/bake/visibility.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/jobs.hpp>
#include <billow/core/simd.hpp>
#include <billow/core/types.hpp>
#include <billow/improve/envelope.hpp>
#include <billow/mesh/face_table.hpp>

namespace billow::inline BILLOW_ABI {

/// A face of a draw set, and the bands of texel rows that it may touch.
struct drawn_face {
    face_id face = no_id;
    std::uint16_t first_band = 0;
    std::uint16_t last_band = 0;
    float height = 0;  ///< greatest distance of a corner along the normal

    /// Front to back, and by id among equals.
    friend bool operator<(const drawn_face& a, const drawn_face& b) noexcept {
        return a.height != b.height ? a.height > b.height : a.face < b.face;
    }
};

/// What is drawn, and where, on one billboard.
struct draw_target {
    orthographic_view view{};
    int columns = 0;    ///< in samples
    int rows = 0;       ///< in samples
    int band_rows = 1;  ///< sample rows a band
};

/// Whether a face with these corners reaches into the grid of `target`, and into which bands.
[[nodiscard]] inline std::optional<drawn_face> clipped_to(
    const draw_target& target, face_id face, const std::array<dvec3, 3>& corners) noexcept {
    dvec2 low{std::numeric_limits<double>::infinity()};
    dvec2 high = -low;
    double height = -low.x;
    for (const dvec3& corner : corners) {
        const dvec3 p = target.view.project(corner);
        low = glm::min(low, dvec2(p) - 1.0);  // a sample more each way, as corners may be rounded
        high = glm::max(high, dvec2(p) + 1.0);
        height = std::max(height, p.z);
    }
    if (!(high.x >= 0 && low.x <= target.columns && high.y >= 0 && low.y <= target.rows)) {
        return std::nullopt;
    }
    const auto band_of = [&](double y) {
        const int row = static_cast<int>(std::clamp(y, 0.0, target.rows - 1.0));
        return static_cast<std::uint16_t>(row / target.band_rows);
    };
    return drawn_face{face, band_of(low.y), band_of(high.y), static_cast<float>(height)};
}

/// Which faces besides a plane's own are drawn on it.
struct draw_set_options {
    double least_cosine = 0;  ///< |cos| of the angle to the plane, of merely valid faces; 2: none
    crack_reduction cracks = crack_reduction::none;
    double envelope_scale = 1;  ///< of the box that a corner must be in, about its centre
};

/// The faces of each billboard, front to back.
class draw_sets {
public:
    /// Faces that reach into the rectangle of a target and are mapped to its plane, or in
    /// cloud.also_drawn for it, or valid for it (all corners within its epsilon, not too steep), or
    /// with crack_reduction::envelope have a corner in its envelope. The last two kinds must be
    /// mapped to a plane of the same part, or to none in a cloud without parts.
    ///
    /// Needs  `faces` of the mesh that `cloud` was searched in; one target a plane.
    /// Cost   O(faces × planes) vector operations at worst, fewer where neighbours in the mesh are
    ///        neighbours in space; parallel over planes.
    draw_sets(const face_table& faces, const billboard_cloud& cloud,
              std::span<const draw_target> targets, const draw_set_options& options,
              parallel threads)
        : faces_(faces), cloud_(cloud), targets_(targets), options_(options) {
        bound_blocks();
        const std::size_t planes = targets.size();
        std::vector<std::size_t> counts(planes, 0);
        threads.for_chunks(planes, 1, [&](std::size_t plane, std::size_t) {
            sweep(static_cast<plane_id>(plane), [&](const drawn_face&) { ++counts[plane]; });
        });
        begin_.assign(planes + 1, 0);
        for (std::size_t i = 0; i < planes; ++i) begin_[i + 1] = begin_[i] + counts[i];
        drawn_.resize(begin_.back());
        threads.for_chunks(planes, 1, [&](std::size_t plane, std::size_t) {
            std::size_t at = begin_[plane];
            sweep(static_cast<plane_id>(plane), [&](const drawn_face& f) { drawn_[at++] = f; });
            std::sort(drawn_.begin() + static_cast<std::ptrdiff_t>(begin_[plane]),
                      drawn_.begin() + static_cast<std::ptrdiff_t>(begin_[plane + 1]));
        });
    }

    [[nodiscard]] std::span<const drawn_face> operator[](plane_id plane) const noexcept {
        return std::span(drawn_).subspan(begin_[plane], begin_[plane + 1] - begin_[plane]);
    }

private:
    static constexpr std::size_t block_size = 64;

    /// A sphere around every block of rows, relative to faces_.bounds.centre.
    void bound_blocks() {
        for (std::size_t row = 0; row < faces_.size; row += block_size) {
            const std::size_t end = std::min(row + block_size, faces_.size);
            std::array<dvec3, 3 * block_size> points;
            std::size_t count = 0;
            for (std::size_t i = row; i < end; ++i) {
                for (const columns3& corner : faces_.corner) points[count++] = corner.get(i);
            }
            blocks_.push_back(bounding_sphere_of(count, [&](std::size_t i) { return points[i]; }));
        }
    }

    /// Whether a face may be drawn on a plane that nobody named for it.
    [[nodiscard]] bool may_share(face_id face, plane_id id) const noexcept {
        const plane_id home = cloud_.plane_of_face[face];
        if (home == no_id) return cloud_.parts.empty();
        return cloud_.part_of(home) == cloud_.part_of(id);
    }

    template <class Visit>
    void sweep(plane_id id, const Visit& visit) const noexcept {
        using V = simd::wide;
        using lanes = simd::lanes<V>;
        const plane& of = cloud_.planes[id];
        const double rho =
            of.rho + glm::dot(of.normal, cloud_.bounds.centre - faces_.bounds.centre);
        const billboard& board = cloud_.billboards[id];
        const double slack = 1e-5 * faces_.bounds.radius;
        const double epsilon_of_plane = cloud_.epsilon_of(id);
        const double reach =
            std::max({epsilon_of_plane, std::abs(board.depth_low), std::abs(board.depth_high)}) +
            slack;
        const bool has_envelope = options_.cracks == crack_reduction::envelope;
        const billboard_envelope envelope(board, faces_.bounds.centre, options_.envelope_scale,
                                          slack);
        const std::span<const drawn_too> also_drawn = cloud_.also_drawn_on(id);
        const vec3_lanes<V> normal = fill_lanes<V>(vec3(of.normal));
        const V offset = lanes::fill(static_cast<float>(rho));
        const V epsilon = lanes::fill(static_cast<float>(epsilon_of_plane));
        const V least_cosine = lanes::fill(static_cast<float>(options_.least_cosine));
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
            if (std::abs(glm::dot(of.normal, blocks_[b].centre) - rho) >
                reach + blocks_[b].radius) {
                continue;
            }
            const std::size_t begin = b * block_size;
            const std::size_t end = std::min(begin + block_size, faces_.size);
            const bool meets_envelope = has_envelope && envelope.may_meet(blocks_[b]);
            std::array<float, block_size> is_extra{};
            for (std::size_t row = begin; row < end; row += lanes::count) {
                const face_lanes<V> f = load_faces<V>(faces_, row);
                V distance = simd::abs(dot(f.corner[0], normal) - offset);
                distance = simd::max(distance, simd::abs(dot(f.corner[1], normal) - offset));
                distance = simd::max(distance, simd::abs(dot(f.corner[2], normal) - offset));
                const V cosine = simd::abs(dot(f.normal, normal));
                const V one = simd::select(distance <= epsilon, lanes::fill(1), lanes::fill(0));
                V extra = simd::select(cosine >= least_cosine, one, lanes::fill(0));
                if (meets_envelope) extra = simd::max(extra, envelope.reached_by(f));
                lanes::store(is_extra.data() + (row - begin), extra);
            }
            for (std::size_t row = begin; row < end; ++row) {
                const face_id face = faces_.source[row];
                if (cloud_.plane_of_face[face] == id ||
                    (is_extra[row - begin] != 0 && may_share(face, id)) ||
                    std::binary_search(also_drawn.begin(), also_drawn.end(), drawn_too{id, face})) {
                    std::array<dvec3, 3> corners;
                    for (std::size_t k = 0; k < 3; ++k) {
                        corners[k] = faces_.corner[k].get(row) + faces_.bounds.centre;
                    }
                    if (const auto drawn = clipped_to(targets_[id], face, corners)) visit(*drawn);
                }
            }
        }
    }

    const face_table& faces_;
    const billboard_cloud& cloud_;
    std::span<const draw_target> targets_;
    draw_set_options options_;
    std::vector<bounding_sphere> blocks_{};
    std::vector<std::size_t> begin_{};
    std::vector<drawn_face> drawn_{};
};

}  // namespace billow::inline BILLOW_ABI
