// Which face is foremost at every sample of a tile of a view, in perspective or not.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <billow/bake/surface.hpp>
#include <billow/bake/visibility.hpp>
#include <billow/core/random.hpp>
#include <billow/core/simd.hpp>
#include <billow/core/types.hpp>
#include <billow/image/raster.hpp>
#include <billow/metrics/projected_faces.hpp>
#include <billow/metrics/sample_view.hpp>

namespace billow::inline BILLOW_ABI {

/// Fragments drawn: samples of faces, seen or hidden.
struct fragment_count {
    std::uint64_t opaque = 0;       ///< that alpha lets be seen
    std::uint64_t transparent = 0;  ///< discarded by alpha
};

/// Nearest face and its nearness for the samples of a tile. Of two faces equally near the one that
/// is drawn first is seen; front to back is fastest.
class sample_tile {
    static constexpr int stride = projected_faces::tile_samples;

public:
    explicit sample_tile(int supersample = 1)
        : side_(supersample), count_(static_cast<std::uint32_t>(supersample * supersample)) {
        const detail::dither_matrix dither(supersample);
        const auto count = static_cast<float>(count_);
        for (int y = 0; y < side_; ++y) {
            for (int x = 0; x < stride; ++x) {
                const float rank = dither.threshold(x, y, 0) * count;
                rank_[static_cast<std::size_t>(y * stride + x)] = static_cast<std::uint8_t>(rank);
            }
        }
        for (std::size_t i = 0; i < steps_.size(); ++i) steps_[i] = static_cast<float>(i);
        for (std::uint32_t i = 0; i < 2 * count_; ++i) {
            threshold_[i] = (static_cast<float>(i % count_) + 0.5f) / count;
        }
    }

    /// Forgets all and looks at `window`: of at most tile_samples a side, starting at a pixel.
    void start(const sample_window& window) noexcept {
        window_ = window;
        for (int y = 0; y < window.y_end - window.y_begin; ++y) {
            std::fill_n(nearness_.begin() + y * stride, window.x_end - window.x_begin, nothing);
            std::fill_n(faces_.begin() + y * stride, window.x_end - window.x_begin,
                        std::bit_cast<float>(no_id));
        }
    }

    /// Draws a face where its alpha lets it be seen. With Counts adds its fragments to `count`.
    template <bool Counts>
    void draw(const surface& look, const sample_view& view, const projected_face& shape,
              fragment_count& count) noexcept {
        const raster_triangle triangle({dvec2(shape.x[0], shape.y[0]),
                                        dvec2(shape.x[1], shape.y[1]),
                                        dvec2(shape.x[2], shape.y[2])});
        if (triangle.is_empty()) return;
        const face_gradients face(view, look.source().corners(shape.face));
        face_cover cover = look.cover_of(shape.face, face.area_at(face.middle()));
        const tile_value nearness(face.nearness, window_);
        if (cover.decides == face_cover::rule::always) {
            triangle.for_each_row(window_, [&](int y, int begin, int end) {
                if constexpr (Counts) count.opaque += static_cast<std::uint64_t>(end - begin);
                const std::size_t at = index_of(begin, y);
                if (find_nearness(face, nearness.row(at), at, end - begin)) {
                    merge(at, end - begin, shape.face);
                }
            });
            return;
        }
        const alpha_values alpha(face, cover, window_);
        const auto shift = static_cast<std::uint32_t>(mix_bits(shape.face) % count_);
        const int piece = face.is_foreshortened() ? 16 : stride;
        triangle.for_each_row(window_, [&](int y, int row_begin, int row_end) {
            for (int begin = row_begin; begin < row_end; begin += piece) {
                const int size = std::min(piece, row_end - begin);
                const std::size_t at = index_of(begin, y);
                if (!find_nearness(face, nearness.row(at), at, size) && !Counts) continue;
                if (face.is_foreshortened()) {
                    const double inverse = face.inverse_w.at(begin + 0.5 * size, y);
                    cover = look.cover_of(shape.face, face.area_at(inverse));
                }
                const int opaque = discard(cover, alpha, shift, at, size);
                if constexpr (Counts) {
                    count.opaque += static_cast<std::uint64_t>(opaque);
                    count.transparent += static_cast<std::uint64_t>(size - opaque);
                }
                if (opaque > 0) merge(at, size, shape.face);
            }
        });
    }

    [[nodiscard]] const sample_window& window() const noexcept { return window_; }
    [[nodiscard]] face_id face_at(int x, int y) const noexcept {
        return std::bit_cast<face_id>(faces_[index_of(x, y)]);
    }
    [[nodiscard]] float nearness_at(int x, int y) const noexcept {
        return nearness_[index_of(x, y)];
    }

    /// Groups the samples of a pixel by face, so that each group is shaded once.
    ///
    /// Gives  the number of groups at the front of `parts`.
    std::size_t parts_of(
        int x, int y, int s,
        std::array<texel_part, max_supersample * max_supersample>& parts) const noexcept {
        std::size_t count = 0;
        for (int j = y * s; j < (y + 1) * s; ++j) {
            for (int i = 0; i < s; ++i) {
                const face_id face = face_at(x * s + i, j);
                if (face == no_id) continue;
                std::size_t part = 0;
                while (part < count && parts[part].face != face) ++part;
                if (part == count) parts[count++] = {face, 0, dvec2(0)};
                ++parts[part].samples;
                parts[part].centre += dvec2(x * s + i + 0.5, j + 0.5);
            }
        }
        for (std::size_t i = 0; i < count; ++i) parts[i].centre /= parts[i].samples;
        return count;
    }

private:
    using V = simd::wide;
    using lanes = simd::lanes<V>;

    /// A value along a row from some sample on.
    struct row_value {
        float first;
        float across;

        [[nodiscard]] float at(int step) const noexcept {
            return first + across * static_cast<float>(step);
        }
        [[nodiscard]] V at(V step) const noexcept {
            return lanes::fill(first) + lanes::fill(across) * step;
        }
    };

    /// A value over a tile, in floats.
    struct tile_value {
        float base = 0;
        float dx = 0;
        float dy = 0;

        tile_value(const affine_value& of, const sample_window& window) noexcept
            : base(static_cast<float>(of.at(window.x_begin, window.y_begin))),
              dx(static_cast<float>(of.dx)),
              dy(static_cast<float>(of.dy)) {}
        [[nodiscard]] row_value row(std::size_t at) const noexcept {
            const std::size_t y = at / stride;
            const std::size_t x = at % stride;
            return {base + dy * static_cast<float>(y) + dx * static_cast<float>(x), dx};
        }
    };

    /// What alpha depends on; each divided by w.
    struct alpha_values {
        tile_value inverse_w, u, v, alpha;
        bool is_unwrapped = true;  ///< no wrap mode matters

        alpha_values(const face_gradients& face, const face_cover& cover,
                     const sample_window& window) noexcept
            : inverse_w(face.inverse_w, window),
              u(combined(face, window, [&](std::size_t i) { return cover.uvs[i].x; })),
              v(combined(face, window, [&](std::size_t i) { return cover.uvs[i].y; })),
              alpha(combined(face, window, [&](std::size_t i) { return cover.vertex_alpha[i]; })) {
            for (const vec2& uv : cover.uvs) {
                is_unwrapped &= uv.x >= 0 && uv.x <= 1 && uv.y >= 0 && uv.y <= 1;
            }
        }
        template <class Value>
        [[nodiscard]] static tile_value combined(const face_gradients& face,
                                                 const sample_window& window,
                                                 const Value& value) noexcept {
            return {face.combined(dvec3(value(0), value(1), value(2))), window};
        }
    };

    [[nodiscard]] std::size_t index_of(int x, int y) const noexcept {
        return static_cast<std::size_t>((y - window_.y_begin) * stride + x - window_.x_begin);
    }

    /// Sets values_ to the nearness of the samples, to -inf after them to the end of the lane. Gives
    /// whether any of them may be seen.
    bool find_nearness(const face_gradients& face, const row_value& row, std::size_t at,
                       int size) noexcept {
        const V low = lanes::fill(face.nearness_low);
        const V high = lanes::fill(face.nearness_high);
        V nearer = lanes::fill(-1);
        const auto count = static_cast<std::size_t>(size);
        for (std::size_t step = 0; step < count; step += lanes::count) {
            const V value = simd::min(simd::max(row.at(lanes::load(&steps_[step])), low), high);
            lanes::store(&values_[step], value);
            nearer = simd::max(nearer, value - lanes::load(&nearness_[at + step]));
        }
        for (std::size_t i = count; i % lanes::count != 0; ++i) values_[i] = nothing;
        std::array<float, lanes::count> greatest;
        lanes::store(greatest.data(), nearer);
        bool is_any = false;
        for (const float value : greatest) is_any |= value > 0;
        return is_any;
    }

    /// Moves samples that alpha discards to where they are not seen. Gives how many are left.
    int discard(const face_cover& cover, const alpha_values& face, std::uint32_t shift,
                std::size_t at, int size) noexcept {
        const row_value row_u = face.u.row(at);
        const row_value row_v = face.v.row(at);
        const row_value row_w = face.inverse_w.row(at);
        const auto y = static_cast<int>(at / stride);  // windows start at pixels
        const std::uint8_t* rank =
            &rank_[static_cast<std::size_t>(y % side_) * stride + at % stride];
        const float* threshold = &threshold_[shift];
        const bool is_dithered = cover.decides == face_cover::rule::share;
        const float cutoff = cover.cutoff;
        const auto count = static_cast<std::size_t>(size);
        int left = 0;
        const auto keep_if = [&](std::size_t step, float alpha) {
            const bool is_there = alpha >= (is_dithered ? threshold[rank[step]] : cutoff);
            values_[step] = is_there ? values_[step] : nothing;
            left += is_there ? 1 : 0;
        };
        if (cover.alpha != nullptr && cover.is_nearest && !cover.has_vertex_alpha &&
            face.is_unwrapped) {
            const image& level = *cover.alpha;
            const V width = lanes::fill(static_cast<float>(level.width));
            const V last_x = lanes::fill(static_cast<float>(level.width - 1));
            const V height = lanes::fill(static_cast<float>(level.height));
            const V last_y = lanes::fill(static_cast<float>(level.height - 1));
            for (std::size_t step = 0; step < count; step += lanes::count) {
                const V i = lanes::load(&steps_[step]);
                const V w = lanes::fill(1) / row_w.at(i);
                const V zero = lanes::fill(0);
                const V texel_x = simd::min(simd::max(row_u.at(i) * w * width, zero), last_x);
                const V texel_y = simd::min(simd::max(row_v.at(i) * w * height, zero), last_y);
                lanes::store(&texel_x_[step], simd::truncate(texel_x));
                lanes::store(&texel_y_[step], simd::truncate(texel_y));
            }
            const std::uint8_t* bytes = level.bytes.data();
            const std::int32_t stride_of_level = level.width;
            const float factor = cover.factor * (1.0f / 255.0f);
            for (std::size_t step = 0; step < count; ++step) {
                const std::int32_t texel = texel_y_[step] * stride_of_level + texel_x_[step];
                keep_if(step, factor * static_cast<float>(bytes[texel]));
            }
            return left;
        }
        const row_value row_a = face.alpha.row(at);
        for (std::size_t step = 0; step < count; ++step) {
            const auto i = static_cast<int>(step);
            const float w = 1 / row_w.at(i);
            float alpha = cover.factor;
            if (cover.has_vertex_alpha) alpha *= row_a.at(i) * w;
            if (cover.alpha != nullptr) {
                const vec2 uv = vec2(row_u.at(i), row_v.at(i)) * w;
                alpha *= sample_alpha(*cover.alpha, *cover.map, uv, cover.is_nearest);
            }
            keep_if(step, alpha);
        }
        return left;
    }

    /// Lets values_ be seen where they are nearer than what is there.
    void merge(std::size_t at, int size, face_id id) noexcept {
        const V face = lanes::fill(std::bit_cast<float>(id));
        for (std::size_t step = 0; step < static_cast<std::size_t>(size); step += lanes::count) {
            const V value = lanes::load(&values_[step]);
            const V before = lanes::load(&nearness_[at + step]);
            const V face_before = lanes::load(&faces_[at + step]);
            lanes::store(&nearness_[at + step], simd::max(value, before));
            lanes::store(&faces_[at + step], simd::select(value > before, face, face_before));
        }
    }

    static constexpr float nothing = -std::numeric_limits<float>::infinity();
    static constexpr std::size_t all_samples =
        std::size_t{stride} * stride + simd::max_lane_count;  // lanes may reach over the end
    template <class T>
    using row_of = std::array<T, stride + simd::max_lane_count>;

    int side_;
    std::uint32_t count_;
    std::array<std::uint8_t, max_supersample * stride> rank_{};
    std::array<float, 2 * max_supersample * max_supersample> threshold_{};
    sample_window window_{};
    row_of<float> steps_{};  ///< 0, 1, 2, …
    row_of<float> values_{};
    row_of<std::int32_t> texel_x_{};
    row_of<std::int32_t> texel_y_{};
    std::vector<float> nearness_ = std::vector<float>(all_samples);
    std::vector<float> faces_ = std::vector<float>(all_samples);  ///< bits of ids, for the lanes
};

}  // namespace billow::inline BILLOW_ABI
