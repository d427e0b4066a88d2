// Which face is foremost at every sample of an orthographic view.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <billow/bake/surface.hpp>
#include <billow/core/random.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/image/raster.hpp>

namespace billow::inline BILLOW_ABI {

/// Samples per texel side are at most this many.
inline constexpr int max_supersample = 8;

/// A view along -axes.normal onto a grid of samples.
struct orthographic_view {
    frame axes{};            ///< u to the right, v up in the picture, the normal to the viewer
    dvec3 origin{0};         ///< the upper left corner of the grid, where depth is 0
    double sample_size = 1;  ///< scene units a sample side

    /// Column and row in samples, rows running down; height above the origin along the normal.
    [[nodiscard]] dvec3 project(const dvec3& point) const noexcept {
        const dvec3 local = axes.to_local(point - origin);
        return {local.x / sample_size, -local.y / sample_size, local.z};
    }
    [[nodiscard]] std::array<dvec3, 3> project(const std::array<vec3, 3>& corners) const noexcept {
        return {project(dvec3(corners[0])), project(dvec3(corners[1])), project(dvec3(corners[2]))};
    }
};

/// Heights along the normal between which fragments are drawn.
struct depth_range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
};

namespace detail {

/// Thresholds (k + 0.5) / S² for k < S² in the order of Bayer's dither matrix, so that any share of
/// the S × S samples of a texel is spread over it. Source: Bayer 1973.
class dither_matrix {
public:
    explicit dither_matrix(int side) : side_(static_cast<std::uint32_t>(side)) {
        BILLOW_ASSERT(side >= 1 && side <= max_supersample);
        const std::uint32_t count = side_ * side_;
        for (std::uint32_t i = 0; i < count; ++i) {
            std::uint32_t rank = 0;
            for (std::uint32_t k = 0; k < count; ++k) rank += bayer_of(k) < bayer_of(i) ? 1u : 0u;
            rank_[i] = static_cast<std::uint8_t>(rank);
        }
    }

    /// Threshold of the sample (x, y) for a face. Faces take the thresholds in another order each:
    /// of two half-transparent leaves one above the other, the lower must show through.
    [[nodiscard]] float threshold(int x, int y, std::uint32_t shift) const noexcept {
        const std::uint32_t count = side_ * side_;
        const std::uint32_t cell =
            static_cast<std::uint32_t>(y) % side_ * side_ + static_cast<std::uint32_t>(x) % side_;
        return (static_cast<float>((rank_[cell] + shift) % count) + 0.5f) /
               static_cast<float>(count);
    }

private:
    [[nodiscard]] std::uint32_t bayer_of(std::uint32_t cell) const noexcept {
        const std::uint32_t x = cell % side_;
        const std::uint32_t y = cell / side_;
        std::uint32_t value = 0;
        for (std::uint32_t bit = 0; bit < 3; ++bit) {
            const std::uint32_t x_bit = x >> bit & 1;
            const std::uint32_t y_bit = y >> bit & 1;
            value = value << 2 | (x_bit ^ y_bit) << 1 | y_bit;
        }
        return value;
    }

    std::uint32_t side_;
    std::array<std::uint8_t, max_supersample * max_supersample> rank_{};
};

}  // namespace detail

/// Nearest face and its depth for a window of samples. Of two faces at the same depth the one of
/// lower id is seen, so the order of drawing does not matter; front to back is fastest.
class visibility_buffer {
public:
    /// Sample columns and rows of the dither pattern: the samples per texel side.
    explicit visibility_buffer(int supersample = 1) : dither_(supersample) {}

    /// Makes room, so that start() does not allocate.
    void reserve(std::size_t samples) {
        depths_.reserve(samples);
        faces_.reserve(samples);
    }

    /// Forgets all and looks at `window`.
    void start(const sample_window& window) {
        window_ = window;
        width_ = static_cast<std::size_t>(window.x_end - window.x_begin);
        const std::size_t size = width_ * static_cast<std::size_t>(window.y_end - window.y_begin);
        depths_.assign(size, -std::numeric_limits<float>::infinity());
        faces_.assign(size, no_id);
    }

    /// Draws a face, clipped to `range`, where its alpha lets it be seen.
    void draw(const surface& look, const orthographic_view& view, face_id face,
              const depth_range& range) noexcept {
        const std::array<dvec3, 3> p = view.project(look.source().corners(face));
        const raster_triangle triangle({dvec2(p[0]), dvec2(p[1]), dvec2(p[2])});
        if (triangle.is_empty()) return;
        const fragment_depth depth(triangle, p, range);
        if (depth.is_outside()) return;
        const face_cover cover = look.cover_of(face, triangle.area());
        if (cover.decides == face_cover::rule::always) {
            triangle.for_each_row(window_, [&](int y, int begin, int end) {
                draw_row(y, begin, end, face, depth, [](int) { return true; });
            });
            return;
        }
        const auto interpolated = [&](auto&& value) {
            return triangle.interpolate(value(0), value(1), value(2));
        };
        const affine_value u = interpolated([&](std::size_t i) { return cover.uvs[i].x; });
        const affine_value v = interpolated([&](std::size_t i) { return cover.uvs[i].y; });
        const affine_value a = interpolated([&](std::size_t i) { return cover.vertex_alpha[i]; });
        const auto shift = static_cast<std::uint32_t>(mix_bits(face));
        triangle.for_each_row(window_, [&](int y, int begin, int end) {
            const row_value row_u(u, begin, y);
            const row_value row_v(v, begin, y);
            const row_value row_a(a, begin, y);
            draw_row(y, begin, end, face, depth, [&](int step) {
                float alpha = cover.factor;
                if (cover.has_vertex_alpha) alpha *= row_a.at(step);
                if (cover.alpha != nullptr) {
                    const vec2 uv(row_u.at(step), row_v.at(step));
                    alpha *= sample_alpha(*cover.alpha, *cover.map, uv, cover.is_nearest);
                }
                return alpha >= (cover.decides == face_cover::rule::cutoff
                                     ? cover.cutoff
                                     : dither_.threshold(begin + step, y, shift));
            });
        });
    }

    [[nodiscard]] const sample_window& window() const noexcept { return window_; }
    /// The faces of row y, from window().x_begin on; no_id where nothing was drawn.
    [[nodiscard]] const face_id* faces_of_row(int y) const noexcept {
        return faces_.data() + row_offset(y);
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

    /// Depth over a face, kept within the depths of its corners: slivers must not shoot out.
    struct fragment_depth {
        affine_value plane{};
        float low = 0;  ///< of the corners
        float high = 0;
        float kept_low = 0;
        float kept_high = 0;
        bool is_clipped = false;

        fragment_depth(const raster_triangle& triangle, const std::array<dvec3, 3>& p,
                       const depth_range& range) noexcept
            : plane(triangle.interpolate(p[0].z, p[1].z, p[2].z)),
              low(static_cast<float>(std::min({p[0].z, p[1].z, p[2].z}))),
              high(static_cast<float>(std::max({p[0].z, p[1].z, p[2].z}))),
              kept_low(static_cast<float>(range.low)),
              kept_high(static_cast<float>(range.high)),
              is_clipped(low < kept_low || high > kept_high) {}

        [[nodiscard]] bool is_outside() const noexcept {
            return high < kept_low || low > kept_high;
        }
    };

    [[nodiscard]] std::size_t row_offset(int y) const noexcept {
        return static_cast<std::size_t>(y - window_.y_begin) * width_;
    }

    template <class IsThere>
    void draw_row(int y, int begin, int end, face_id face, const fragment_depth& depth,
                  const IsThere& is_there) noexcept {
        const std::size_t offset =
            row_offset(y) + static_cast<std::size_t>(begin - window_.x_begin);
        float* depths = depths_.data() + offset;
        face_id* faces = faces_.data() + offset;
        const row_value height(depth.plane, begin, y);
        for (int step = 0; step < end - begin; ++step) {
            const float value = std::clamp(height.at(step), depth.low, depth.high);
            if (!(value >= depths[step])) continue;
            if (value == depths[step] && face > faces[step]) continue;
            if (depth.is_clipped && !(value >= depth.kept_low && value <= depth.kept_high)) {
                continue;
            }
            if (!is_there(step)) continue;
            depths[step] = value;
            faces[step] = face;
        }
    }

    detail::dither_matrix dither_;
    sample_window window_{};
    std::size_t width_ = 0;
    std::vector<float> depths_{};
    std::vector<face_id> faces_{};
};

/// The samples of one texel that show the same face.
struct texel_part {
    face_id face = no_id;
    int samples = 0;
    dvec2 centre{0};  ///< their mean position, in samples
};

/// Groups the S × S samples of the texel in column x and row y by face, so that each group is shaded
/// once: sharper than the mean of filtered samples, and cheaper.
///
/// Gives  the number of groups at the front of `parts`.
inline std::size_t parts_of_texel(
    const visibility_buffer& buffer, int x, int y, int supersample,
    std::array<texel_part, max_supersample * max_supersample>& parts) noexcept {
    std::size_t count = 0;
    for (int j = y * supersample; j < (y + 1) * supersample; ++j) {
        const face_id* row = buffer.faces_of_row(j) - buffer.window().x_begin;
        for (int i = x * supersample; i < (x + 1) * supersample; ++i) {
            if (row[i] == no_id) continue;
            std::size_t part = 0;
            while (part < count && parts[part].face != row[i]) ++part;
            if (part == count) parts[count++] = {row[i], 0, dvec2(0)};
            ++parts[part].samples;
            parts[part].centre += dvec2(i + 0.5, j + 0.5);
        }
    }
    for (std::size_t i = 0; i < count; ++i) parts[i].centre /= parts[i].samples;
    return count;
}

/// Shades points of faces in a view; remembers what is constant over the faces met last.
class view_shader {
public:
    view_shader(const surface& look, int supersample) : look_(&look), supersample_(supersample) {}

    /// Forgets the faces of another view.
    void start(const orthographic_view& view) noexcept {
        view_ = view;
        for (entry& e : entries_) e.look.face = no_id;
    }

    /// The look at the point of a face nearest to `point` (in samples, roughly where outside), with its normal turned to the viewer.
    [[nodiscard]] surface_sample at(face_id face, const dvec2& point) noexcept {
        entry& e = entries_[face % entries_.size()];
        if (e.look.face != face) e = entry_of(face);
        const dvec2 offset = point - e.corner;
        const double b = std::clamp(glm::dot(e.to_b, offset), 0.0, 1.0);
        const double c = std::clamp(glm::dot(e.to_c, offset), 0.0, 1.0 - b);
        surface_sample sample = look_->at(e.look, vec3(1 - b - c, b, c));
        sample.normal = normal_toward(sample, e.look, vec3(view_.axes.normal));
        return sample;
    }

private:
    struct entry {
        face_look look{};
        dvec2 corner{0};
        dvec2 to_b{0};  ///< barycentric weight of the second corner = dot(to_b, point - corner)
        dvec2 to_c{0};
    };

    [[nodiscard]] entry entry_of(face_id face) const noexcept {
        const std::array<dvec3, 3> p = view_.project(look_->source().corners(face));
        entry e;
        e.corner = dvec2(p[0]);
        const dvec2 u = dvec2(p[1]) - e.corner;
        const dvec2 v = dvec2(p[2]) - e.corner;
        const double det = u.x * v.y - u.y * v.x;
        if (det != 0) {
            e.to_b = dvec2(v.y, -v.x) / det;
            e.to_c = dvec2(-u.y, u.x) / det;
        }
        e.look = look_->look_at(face, 0.5 * std::abs(det) / (supersample_ * supersample_));
        return e;
    }

    const surface* look_;
    int supersample_;
    orthographic_view view_{};
    std::array<entry, 256> entries_{};
};

}  // namespace billow::inline BILLOW_ABI
