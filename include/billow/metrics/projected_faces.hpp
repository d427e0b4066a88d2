// Where the faces of a scene lie in a view, by tiles of its samples.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <billow/core/simd.hpp>
#include <billow/core/types.hpp>
#include <billow/image/raster.hpp>
#include <billow/metrics/render_scene.hpp>
#include <billow/metrics/sample_view.hpp>

namespace billow::inline BILLOW_ABI {

/// A face in a view, or a piece of one that the near plane cuts.
struct projected_face {
    face_id face = no_id;
    std::array<float, 3> x{};  ///< in samples
    std::array<float, 3> y{};
    float distance = 0;                    ///< of the nearest corner, along the view
    std::array<std::uint16_t, 4> tiles{};  ///< columns [0] to [1] and rows [2] to [3] of tiles
};

/// The faces that may cover a sample of a view, listed for each tile of the picture. Built anew for every view in the same memory.
///
/// Cost   O(faces), in lanes.
class projected_faces {
public:
    /// A tile has at most this many samples a side: its depths and faces stay in the cache.
    static constexpr int tile_samples = 128;

    void project(const render_scene& scene, const sample_view& view) {
        view_ = view;
        tile_px_ = tile_samples / view.supersample;
        const int side = tile_px_ * view.supersample;
        tile_columns_ = (view.columns + side - 1) / side;
        tile_rows_ = (view.rows + side - 1) / side;
        faces_.clear();
        begin_.assign(tile_count() + 1, 0);
        project_all(scene);
        fill_tiles();
    }

    [[nodiscard]] std::size_t tile_count() const noexcept {
        return static_cast<std::size_t>(tile_columns_) * static_cast<std::size_t>(tile_rows_);
    }
    [[nodiscard]] int tile_px() const noexcept { return tile_px_; }
    /// The pixels of a tile.
    [[nodiscard]] sample_window pixels_of(std::size_t tile) const noexcept {
        const int x = static_cast<int>(tile) % tile_columns_ * tile_px_;
        const int y = static_cast<int>(tile) / tile_columns_ * tile_px_;
        return {x, y, std::min(x + tile_px_, view_.columns / view_.supersample),
                std::min(y + tile_px_, view_.rows / view_.supersample)};
    }
    /// Calls `visit(projected_face)` front to back: by the nearest corner, by id among equals. Tiles
    /// may be visited side by side, each once.
    template <class Visit>
    void for_faces_of(std::size_t tile, const Visit& visit) {
        const auto begin = listed_.begin() + begin_[tile];
        const auto end = listed_.begin() + begin_[tile + 1];
        std::sort(begin, end);
        std::for_each(begin, end,
                      [&](std::uint64_t listed) { visit(faces_[listed & 0xffffffffu]); });
    }

private:
    using V = simd::wide;
    using lanes = simd::lanes<V>;
    /// Faces that reach farther are cut: raster_triangle takes coordinates below 2²¹.
    static constexpr float farthest = 1048576.0f;
    /// Rounding may move corners by 1/256 sample.
    static constexpr float to_centre = 0.5f - 1.0f / 64;

    struct lane_form {
        V x, y, z, offset;

        lane_form(const linear_form& form, const dvec3& origin)
            : x(lanes::fill(static_cast<float>(form.slope.x))),
              y(lanes::fill(static_cast<float>(form.slope.y))),
              z(lanes::fill(static_cast<float>(form.slope.z))),
              offset(lanes::fill(static_cast<float>(form.at(origin)))) {}
        [[nodiscard]] V at(const V& px, const V& py, const V& pz) const noexcept {
            return x * px + y * py + z * pz + offset;
        }
    };

    void project_all(const render_scene& scene) {
        const lane_form form_x(view_.x, scene.bounds.centre);
        const lane_form form_y(view_.y, scene.bounds.centre);
        const lane_form form_w(view_.w, scene.bounds.centre);
        const lane_form form_height(view_.height, scene.bounds.centre);
        const auto near_distance = static_cast<float>(view_.near_distance);
        const V zero = lanes::fill(0);
        const V one = lanes::fill(1);
        for (std::size_t row = 0; row < scene.face_count(); row += lanes::count) {
            std::array<V, 3> x;
            std::array<V, 3> y;
            std::array<V, 3> w;
            std::array<V, 3> distance;
            for (std::size_t k = 0; k < 3; ++k) {
                const V px = lanes::load(scene.corner[k].x.data() + row);
                const V py = lanes::load(scene.corner[k].y.data() + row);
                const V pz = lanes::load(scene.corner[k].z.data() + row);
                w[k] = form_w.at(px, py, pz);
                const V inverse = one / w[k];
                x[k] = form_x.at(px, py, pz) * inverse;
                y[k] = form_y.at(px, py, pz) * inverse;
                distance[k] = zero - form_height.at(px, py, pz);
            }
            const V w_low = least(w);
            V x_low = least(x);
            V x_high = greatest(x);
            V y_low = least(y);
            V y_high = greatest(y);
            const V reach =
                simd::max(simd::max(x_high, zero - x_low), simd::max(y_high, zero - y_low));
            V is_whole = simd::select(w_low >= lanes::fill(near_distance), one, zero);
            is_whole = simd::select(reach <= lanes::fill(farthest), is_whole, zero);
            std::array<block, 8> kept;
            for (std::size_t k = 0; k < 3; ++k) {
                lanes::store(kept[k].data(), x[k]);
                lanes::store(kept[k + 3].data(), y[k]);
            }
            lanes::store(kept[6].data(), is_whole);
            lanes::store(kept[7].data(), least(distance));
            std::array<int_block, 4> sample;  // first and last columns and rows
            const auto first = [&](V low) {
                low = simd::select(is_whole > zero, low, zero);
                return simd::truncate(simd::max(low, zero) + lanes::fill(to_centre));
            };
            const auto last = [&](V high, int count) {
                high = simd::select(is_whole > zero, high, zero) - lanes::fill(to_centre);
                return simd::truncate(simd::min(simd::max(high, lanes::fill(-1)),
                                                lanes::fill(static_cast<float>(count - 1))));
            };
            lanes::store(sample[0].data(), first(x_low));
            lanes::store(sample[1].data(), last(x_high, view_.columns));
            lanes::store(sample[2].data(), first(y_low));
            lanes::store(sample[3].data(), last(y_high, view_.rows));
            const std::size_t end = std::min(lanes::count, scene.face_count() - row);
            for (std::size_t lane = 0; lane < end; ++lane) {
                const auto face = static_cast<face_id>(row + lane);
                if (!(kept[6][lane] > 0)) {
                    cut(scene, face);
                    continue;
                }
                add(scene,
                    {face,
                     {kept[0][lane], kept[1][lane], kept[2][lane]},
                     {kept[3][lane], kept[4][lane], kept[5][lane]},
                     kept[7][lane]},
                    {sample[0][lane], sample[2][lane], sample[1][lane], sample[3][lane]});
            }
        }
    }

    /// Adds a face that may cover the samples of `window`, the last ones included.
    void add(const render_scene& scene, projected_face face, const sample_window& window) {
        if (window.x_begin > window.x_end || window.y_begin > window.y_end) return;
        if (scene.is_culled && is_back(face) &&
            !scene.look.material_of(face.face).is_double_sided) {
            return;
        }
        const int side = tile_px_ * view_.supersample;
        const auto tile_of = [&](int sample) { return static_cast<std::uint16_t>(sample / side); };
        face.tiles = {tile_of(window.x_begin), tile_of(window.x_end), tile_of(window.y_begin),
                      tile_of(window.y_end)};
        for_tiles(face, [&](std::size_t tile) { ++begin_[tile + 1]; });
        faces_.push_back(face);
    }

    /// Samples run down: what is counter-clockwise to the viewer has a negative area.
    [[nodiscard]] static bool is_back(const projected_face& f) noexcept {
        return (f.x[1] - f.x[0]) * (f.y[2] - f.y[0]) > (f.x[2] - f.x[0]) * (f.y[1] - f.y[0]);
    }

    template <class Visit>
    void for_tiles(const projected_face& face, const Visit& visit) const {
        for (std::size_t row = face.tiles[2]; row <= face.tiles[3]; ++row) {
            for (std::size_t column = face.tiles[0]; column <= face.tiles[1]; ++column) {
                visit(row * static_cast<std::size_t>(tile_columns_) + column);
            }
        }
    }

    void fill_tiles() {
        for (std::size_t tile = 0; tile < tile_count(); ++tile) begin_[tile + 1] += begin_[tile];
        listed_.resize(begin_.back());
        next_.assign(begin_.begin(), begin_.end() - 1);
        for (std::uint32_t i = 0; i < faces_.size(); ++i) {
            const std::uint64_t key = std::uint64_t{ascending_bits(faces_[i].distance)} << 32 | i;
            for_tiles(faces_[i], [&](std::size_t tile) { listed_[next_[tile]++] = key; });
        }
    }

    /// Bits in the order of the floats.
    [[nodiscard]] static std::uint32_t ascending_bits(float value) noexcept {
        const auto bits = std::bit_cast<std::uint32_t>(value);
        return bits >> 31 != 0 ? ~bits : bits | 0x80000000u;
    }

    /// Adds what the planes before the eye and far beside the picture leave of a face.
    void cut(const render_scene& scene, face_id face) {
        polygon shape;
        for (const vec3& corner : scene.look.source().corners(face)) {
            shape.corner[shape.size++] = view_.project(dvec3(corner));
        }
        const double aside = 0.5 * farthest;
        keep(shape, {0, 0, 1}, view_.near_distance);
        keep(shape, {1, 0, aside}, 0);
        keep(shape, {-1, 0, aside}, 0);
        keep(shape, {0, 1, aside}, 0);
        keep(shape, {0, -1, aside}, 0);
        for (std::size_t k = 2; k < shape.size; ++k) {
            projected_face piece{.face = face, .distance = static_cast<float>(view_.near_distance)};
            const std::array fan{shape.corner[0], shape.corner[k - 1], shape.corner[k]};
            for (std::size_t i = 0; i < 3; ++i) {
                piece.x[i] = static_cast<float>(fan[i].x / fan[i].z);
                piece.y[i] = static_cast<float>(fan[i].y / fan[i].z);
            }
            const auto range = [](const std::array<float, 3>& at, int count, int& low, int& high) {
                const auto limit = static_cast<float>(count);
                const auto [least_at, greatest_at] = std::minmax({at[0], at[1], at[2]});
                low = static_cast<int>(std::clamp(least_at, 0.0f, limit) + to_centre);
                high = static_cast<int>(std::clamp(greatest_at - to_centre, -1.0f, limit - 1));
            };
            sample_window window;
            range(piece.x, view_.columns, window.x_begin, window.x_end);
            range(piece.y, view_.rows, window.y_begin, window.y_end);
            add(scene, piece, window);
        }
    }

    struct polygon {
        std::array<dvec3, 8> corner{};  // each of five planes may add one to a triangle's three
        std::size_t size = 0;
    };

    /// Leaves of `shape` what is on the side dot(normal, point) ≥ offset.
    static void keep(polygon& shape, const dvec3& normal, double offset) noexcept {
        polygon rest;
        for (std::size_t i = 0; i < shape.size; ++i) {
            const dvec3& a = shape.corner[i];
            const dvec3& b = shape.corner[i + 1 == shape.size ? 0 : i + 1];
            const double at_a = glm::dot(normal, a) - offset;
            const double at_b = glm::dot(normal, b) - offset;
            if (at_a >= 0) rest.corner[rest.size++] = a;
            // From the kept end on, so that both faces at an edge are cut at the same point.
            if (at_a >= 0 && at_b < 0)
                rest.corner[rest.size++] = a + (b - a) * (at_a / (at_a - at_b));
            if (at_b >= 0 && at_a < 0)
                rest.corner[rest.size++] = b + (a - b) * (at_b / (at_b - at_a));
        }
        shape = rest;
    }

    [[nodiscard]] static V least(const std::array<V, 3>& v) noexcept {
        return simd::min(simd::min(v[0], v[1]), v[2]);
    }
    [[nodiscard]] static V greatest(const std::array<V, 3>& v) noexcept {
        return simd::max(simd::max(v[0], v[1]), v[2]);
    }

    using block = std::array<float, simd::max_lane_count>;
    using int_block = std::array<std::int32_t, simd::max_lane_count>;

    sample_view view_{};
    int tile_px_ = 1;
    int tile_columns_ = 0;
    int tile_rows_ = 0;
    std::vector<projected_face> faces_{};
    std::vector<std::uint32_t> begin_{};  // of each tile in listed_
    std::vector<std::uint32_t> next_{};
    std::vector<std::uint64_t> listed_{};  // distances, and rows of faces_ in the lower half
};

}  // namespace billow::inline BILLOW_ABI
