// Which face is foremost at every sample of a tile of a view, in perspective or not.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <billow/bake/surface.hpp>
#include <billow/bake/visibility.hpp>
#include <billow/core/random.hpp>
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
        for (std::uint32_t i = 0; i < 2 * count_; ++i) {
            threshold_[i] = (static_cast<float>(i % count_) + 0.5f) / count;
        }
    }

    /// Forgets all and looks at `window`: of at most tile_samples a side, starting at a pixel.
    void start(const sample_window& window) noexcept {
        window_ = window;
        constexpr float nothing = -std::numeric_limits<float>::infinity();
        for (int y = 0; y < window.y_end - window.y_begin; ++y) {
            std::fill_n(nearness_.begin() + y * stride, window.x_end - window.x_begin, nothing);
            std::fill_n(faces_.begin() + y * stride, window.x_end - window.x_begin, no_id);
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
        std::array<float, stride> values;
        if (cover.decides == face_cover::rule::always) {
            triangle.for_each_row(window_, [&](int y, int begin, int end) {
                if constexpr (Counts) count.opaque += static_cast<std::uint64_t>(end - begin);
                if (find_nearness(face, y, begin, end, values))
                    merge(y, begin, end, values, shape.face);
            });
            return;
        }
        const alpha_gradients alpha(face, cover);
        const auto shift = static_cast<std::uint32_t>(mix_bits(shape.face) % count_);
        const int piece = face.is_foreshortened() ? 16 : stride;
        triangle.for_each_row(window_, [&](int y, int row_begin, int row_end) {
            for (int begin = row_begin; begin < row_end; begin += piece) {
                const int end = std::min(begin + piece, row_end);
                if (!find_nearness(face, y, begin, end, values) && !Counts) continue;
                if (face.is_foreshortened()) {
                    const double inverse = face.inverse_w.at(0.5 * (begin + end), y);
                    cover = look.cover_of(shape.face, face.area_at(inverse));
                }
                const int opaque = discard(cover, alpha, shift, y, begin, end, values);
                if constexpr (Counts) {
                    count.opaque += static_cast<std::uint64_t>(opaque);
                    count.transparent += static_cast<std::uint64_t>(end - begin - opaque);
                }
                if (opaque > 0) merge(y, begin, end, values, shape.face);
            }
        });
    }

    [[nodiscard]] const sample_window& window() const noexcept { return window_; }
    [[nodiscard]] face_id face_at(int x, int y) const noexcept { return faces_[index_of(x, y)]; }
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
            const face_id* row = faces_.data() + index_of(x * s, j);
            for (int i = 0; i < s; ++i) {
                if (row[i] == no_id) continue;
                std::size_t part = 0;
                while (part < count && parts[part].face != row[i]) ++part;
                if (part == count) parts[count++] = {row[i], 0, dvec2(0)};
                ++parts[part].samples;
                parts[part].centre += dvec2(x * s + i + 0.5, j + 0.5);
            }
        }
        for (std::size_t i = 0; i < count; ++i) parts[i].centre /= parts[i].samples;
        return count;
    }

private:
    /// A value along a row, in floats from its first sample on.
    struct row_value {
        float first;
        float across;

        row_value(const affine_value& of, int x, int y) noexcept
            : first(static_cast<float>(of.at(x, y))), across(static_cast<float>(of.dx)) {}
        [[nodiscard]] float at(int step) const noexcept {
            return first + across * static_cast<float>(step);
        }
    };

    [[nodiscard]] std::size_t index_of(int x, int y) const noexcept {
        return static_cast<std::size_t>((y - window_.y_begin) * stride + x - window_.x_begin);
    }

    /// What alpha depends on; each divided by w.
    struct alpha_gradients {
        affine_value u, v, alpha, inverse_w;

        alpha_gradients(const face_gradients& face, const face_cover& cover) noexcept
            : inverse_w(face.inverse_w) {
            const auto combined = [&](auto&& value) {
                return face.combined(dvec3(value(0), value(1), value(2)));
            };
            u = combined([&](std::size_t i) { return cover.uvs[i].x; });
            v = combined([&](std::size_t i) { return cover.uvs[i].y; });
            alpha = combined([&](std::size_t i) { return cover.vertex_alpha[i]; });
        }
    };

    /// Whether any of the samples may be seen.
    bool find_nearness(const face_gradients& face, int y, int begin, int end,
                       std::array<float, stride>& values) const noexcept {
        const float* nearness = nearness_.data() + index_of(begin, y);
        const row_value row(face.nearness, begin, y);
        const float low = face.nearness_low;
        const float high = face.nearness_high;
        bool is_any = false;
        for (int step = 0; step < end - begin; ++step) {
            const float value = std::min(std::max(row.at(step), low), high);
            values[static_cast<std::size_t>(step)] = value;
            is_any |= value > nearness[step];
        }
        return is_any;
    }

    /// Moves samples that alpha discards to where they are not seen. Gives how many are left.
    int discard(const face_cover& cover, const alpha_gradients& face, std::uint32_t shift, int y,
                int begin, int end, std::array<float, stride>& values) const noexcept {
        const row_value row_u(face.u, begin, y);
        const row_value row_v(face.v, begin, y);
        const row_value row_a(face.alpha, begin, y);
        const row_value row_w(face.inverse_w, begin, y);
        const std::uint8_t* rank = rank_.data() + (y % side_) * stride + (begin - window_.x_begin);
        const float* threshold = threshold_.data() + shift;
        const bool is_dithered = cover.decides == face_cover::rule::share;
        const float cutoff = cover.cutoff;
        const float factor = cover.factor;
        int left = 0;
        const auto keep_if = [&](int step, float alpha) {
            const bool is_there = alpha >= (is_dithered ? threshold[rank[step]] : cutoff);
            float& value = values[static_cast<std::size_t>(step)];
            value = is_there ? value : -std::numeric_limits<float>::infinity();
            left += is_there ? 1 : 0;
        };
        const auto uv_at = [&](int step) {
            return vec2(row_u.at(step), row_v.at(step)) * (1 / row_w.at(step));
        };
        const int count = end - begin;
        if (cover.alpha != nullptr && cover.is_nearest && !cover.has_vertex_alpha) {
            const vec2 low = glm::min(uv_at(0), uv_at(count - 1));
            const vec2 high = glm::max(uv_at(0), uv_at(count - 1));
            if (low.x >= 0 && low.y >= 0 && high.x <= 1 && high.y <= 1) {
                const std::uint8_t* bytes = cover.alpha->bytes.data();
                const int width = cover.alpha->width;
                const int height = cover.alpha->height;
                const vec2 size(static_cast<float>(width), static_cast<float>(height));
                for (int step = 0; step < count; ++step) {
                    const vec2 at = uv_at(step) * size;
                    const int x = std::clamp(static_cast<int>(at.x), 0, width - 1);
                    const int row = std::clamp(static_cast<int>(at.y), 0, height - 1);
                    keep_if(step,
                            factor * static_cast<float>(bytes[row * width + x]) * (1.0f / 255.0f));
                }
                return left;
            }
        }
        for (int step = 0; step < count; ++step) {
            float alpha = factor;
            if (cover.has_vertex_alpha) alpha *= row_a.at(step) / row_w.at(step);
            if (cover.alpha != nullptr) {
                alpha *= sample_alpha(*cover.alpha, *cover.map, uv_at(step), cover.is_nearest);
            }
            keep_if(step, alpha);
        }
        return left;
    }

    void merge(int y, int begin, int end, const std::array<float, stride>& values,
               face_id face) noexcept {
        float* nearness = nearness_.data() + index_of(begin, y);
        face_id* faces = faces_.data() + index_of(begin, y);
        for (int step = 0; step < end - begin; ++step) {
            const float value = values[static_cast<std::size_t>(step)];
            const bool is_nearer = value > nearness[step];
            nearness[step] = is_nearer ? value : nearness[step];
            faces[step] = is_nearer ? face : faces[step];
        }
    }

    int side_;
    std::uint32_t count_;
    std::array<std::uint8_t, max_supersample * stride> rank_{};
    std::array<float, 2 * max_supersample * max_supersample> threshold_{};
    sample_window window_{};
    std::vector<float> nearness_ = std::vector<float>(std::size_t{stride} * stride);
    std::vector<face_id> faces_ = std::vector<face_id>(std::size_t{stride} * stride);
};

}  // namespace billow::inline BILLOW_ABI
