// Which face is foremost at every sample of an orthographic view.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <billow/bake/row_alpha.hpp>
#include <billow/bake/surface.hpp>
#include <billow/core/random.hpp>
#include <billow/core/simd.hpp>
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
        std::vector<std::uint32_t> ranks(count, 0);
        for (std::uint32_t i = 0; i < count; ++i) {
            for (std::uint32_t k = 0; k < count; ++k)
                ranks[i] += bayer_of(k) < bayer_of(i) ? 1u : 0u;
        }
        for (std::uint32_t shift = 0; shift < count; ++shift) {
            for (std::uint32_t y = 0; y < side_; ++y) {
                for (std::uint32_t x = 0; x < side_ + simd::max_lane_count; ++x) {
                    const std::uint32_t rank = (ranks[y * side_ + x % side_] + shift) % count;
                    thresholds_.push_back((static_cast<float>(rank) + 0.5f) /
                                          static_cast<float>(count));
                }
            }
        }
    }

    [[nodiscard]] std::uint32_t column(int x) const noexcept {
        const auto at = static_cast<std::uint32_t>(x);
        return (side_ & (side_ - 1)) == 0 ? at & (side_ - 1) : at % side_;
    }
    /// Thresholds of row y for a face: a pack of them can be read from every column on. Faces take them in another order each: of two half-transparent leaves one
    /// above the other, the lower must show through.
    [[nodiscard]] const float* row(int y, std::uint32_t shift) const noexcept {
        const std::size_t at = shift % (side_ * side_) * side_ + column(y);
        return thresholds_.data() + at * (side_ + simd::max_lane_count);
    }
    [[nodiscard]] float threshold(int x, int y, std::uint32_t shift) const noexcept {
        return row(y, shift)[column(x)];
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
    std::vector<float> thresholds_{};
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
        depths_.reserve(samples + simd::max_lane_count);
        faces_.reserve(samples + simd::max_lane_count);
    }

    /// Forgets all and looks at `window`.
    void start(const sample_window& window) {
        window_ = window;
        width_ = static_cast<std::size_t>(window.x_end - window.x_begin);
        // Packs may read beyond the last row.
        const std::size_t size =
            width_ * static_cast<std::size_t>(window.y_end - window.y_begin) + simd::max_lane_count;
        depths_.assign(size, -std::numeric_limits<float>::infinity());
        faces_.assign(size, no_id);
    }

    /// Draws a face, clipped to `range`, where its alpha lets it be seen. V = float is the scalar
    /// reference.
    template <class V = simd::wide>
    void draw(const surface& look, const orthographic_view& view, face_id face,
              const depth_range& range) noexcept {
        const std::array<dvec3, 3> p = view.project(look.source().corners(face));
        const raster_triangle triangle({dvec2(p[0]), dvec2(p[1]), dvec2(p[2])});
        if (triangle.is_empty()) return;
        const fragment_depth depth(triangle, p, range);
        if (depth.is_outside()) return;
        const face_cover cover = look.cover_of(face, triangle.area());
        if (cover.decides == face_cover::rule::always) {
            for_each_span(triangle, face, [&](int y, int begin, int end, const dvec2& at) {
                draw_row<V>(y, begin, end, face, depth, at,
                            [](int, V, simd::mask_lanes<V> wanted) { return wanted; });
            });
            return;
        }
        if (cover.is_nearest) {
            draw_alpha<V, true>(triangle, cover, face, depth);
        } else {
            draw_alpha<V, false>(triangle, cover, face, depth);
        }
    }

    [[nodiscard]] const sample_window& window() const noexcept { return window_; }
    /// The faces of row y, from window().x_begin on; no_id where nothing was drawn.
    [[nodiscard]] const face_id* faces_of_row(int y) const noexcept {
        return faces_.data() + row_offset(y);
    }

private:
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

    /// Calls `visit(y, begin, end, at)` for the samples of a face: those that it takes by the rule,
    /// whose first lies at `at`, and those that a sliver owes, one by one.
    template <class Visit>
    void for_each_span(const raster_triangle& triangle, face_id face, const Visit& visit) noexcept {
        triangle.for_each_row(
            window_, [&](int y, int begin, int end) { visit(y, begin, end, dvec2(begin, y)); });
        if (!triangle.is_sliver()) return;
        triangle.for_each_missing(window_, random_unit(0, face),
                                  [&](int y, int x, const dvec2& at) { visit(y, x, x + 1, at); });
    }

    template <class V, bool IsNearest>
    void draw_alpha(const raster_triangle& triangle, const face_cover& cover, face_id face,
                    const fragment_depth& depth) noexcept {
        const detail::face_alpha alpha(cover, triangle);
        if (cover.decides == face_cover::rule::cutoff) {
            const V cutoff = simd::lanes<V>::fill(cover.cutoff);
            for_each_span(triangle, face, [&](int y, int begin, int end, const dvec2& at) {
                const auto row = alpha.from<V, IsNearest>(at);
                const auto passes = [&](int, V step, simd::mask_lanes<V> wanted) {
                    return simd::mask_lanes<V>(wanted & (row.at(step, wanted) >= cutoff));
                };
                draw_row<V>(y, begin, end, face, depth, at, passes);
            });
            return;
        }
        const auto shift = static_cast<std::uint32_t>(mix_bits(face));
        for_each_span(triangle, face, [&](int y, int begin, int end, const dvec2& at) {
            const auto row = alpha.from<V, IsNearest>(at);
            const float* thresholds = dither_.row(y, shift);
            const auto passes = [&](int x, V step, simd::mask_lanes<V> wanted) {
                const V threshold = simd::lanes<V>::load(thresholds + dither_.column(x));
                return simd::mask_lanes<V>(wanted & (row.at(step, wanted) >= threshold));
            };
            draw_row<V>(y, begin, end, face, depth, at, passes);
        });
    }

    [[nodiscard]] std::size_t row_offset(int y) const noexcept {
        return static_cast<std::size_t>(y - window_.y_begin) * width_;
    }

    /// Draws samples begin to end of row y, of which the first shows the point `at`, where `is_there(step, wanted)` says so: it is given some
    /// samples, counted from `begin`, and which of them would be seen.
    template <class V, class IsThere>
    void draw_row(int y, int begin, int end, face_id face, const fragment_depth& depth,
                  const dvec2& at, const IsThere& is_there) noexcept {
        using lanes = simd::lanes<V>;
        using mask = simd::mask_lanes<V>;
        const std::size_t offset =
            row_offset(y) + static_cast<std::size_t>(begin - window_.x_begin);
        float* depths = depths_.data() + offset;
        face_id* faces = faces_.data() + offset;
        const detail::row_value<V> height(depth.plane, at);
        const V low = lanes::fill(depth.low);
        const V high = lanes::fill(depth.high);
        const V count = lanes::fill(static_cast<float>(end - begin));
        const V last = lanes::fill(static_cast<float>(lanes::count));
        const simd::int_lanes<V> id = simd::int_lanes<V>{} + static_cast<std::int32_t>(face);
        V step = simd::lane_numbers<V>();
        for (int i = 0; i < end - begin; i += static_cast<int>(lanes::count), step += last) {
            const V value = simd::min(simd::max(height.at(step), low), high);
            const V drawn = lanes::load(depths + i);
            mask is_seen = (value >= drawn) & (step < count);
            if (!simd::any(is_seen)) continue;
            if (depth.is_clipped) {
                is_seen &= value >= lanes::fill(depth.kept_low);
                is_seen &= value <= lanes::fill(depth.kept_high);
            }
            is_seen = is_there(begin + i, step, is_seen);
            if (!simd::any(is_seen)) continue;
            auto* const ids = reinterpret_cast<std::int32_t*>(faces + i);
            const auto previous = lanes::load(ids);
            // Ids count from 0, so less than 2³¹ of them are as good as signed.
            const mask is_behind = (value == drawn) & (previous < id);
            is_seen &= is_behind == mask{};
            lanes::store(depths + i, simd::select(is_seen, value, drawn));
            lanes::store(ids, simd::select(is_seen, id, previous));
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

    /// The look at the point of a face nearest to `point` (in samples), with its normal turned to the
    /// viewer.
    [[nodiscard]] surface_sample at(face_id face, const dvec2& point) noexcept {
        entry& e = entries_[face % entries_.size()];
        if (e.look.face != face) e = entry_of(face);
        const dvec2 w = e.weights_near(point - e.corner);
        surface_sample sample = look_->at(e.look, vec3(1 - w.x - w.y, w.x, w.y));
        sample.normal = normal_toward(sample, e.look, vec3(view_.axes.normal));
        return sample;
    }

private:
    struct entry {
        face_look look{};
        dvec2 corner{0};
        dvec2 u{0};     ///< from the first corner to the second
        dvec2 v{0};     ///< and to the third
        dvec2 to_b{0};  ///< barycentric weight of the second corner = dot(to_b, point - corner)
        dvec2 to_c{0};

        /// Weights of the second and third corner at the point nearest to corner + offset.
        [[nodiscard]] dvec2 weights_near(const dvec2& offset) const noexcept {
            const dvec2 weights(glm::dot(to_b, offset), glm::dot(to_c, offset));
            if (weights.x >= 0 && weights.y >= 0 && weights.x + weights.y <= 1) return weights;
            dvec2 nearest{0};
            double least = std::numeric_limits<double>::infinity();
            const auto consider = [&](const dvec2& from, const dvec2& to) {
                const dvec2 start = u * from.x + v * from.y;
                const dvec2 along = u * to.x + v * to.y - start;
                const double length_sq = glm::dot(along, along);
                if (!(length_sq > 0)) return;
                const double t = std::clamp(glm::dot(offset - start, along) / length_sq, 0.0, 1.0);
                const dvec2 aside = offset - start - along * t;
                if (glm::dot(aside, aside) >= least) return;
                least = glm::dot(aside, aside);
                nearest = from + (to - from) * t;
            };
            consider({0, 0}, {1, 0});
            consider({0, 0}, {0, 1});
            consider({1, 0}, {0, 1});
            return nearest;
        }
    };

    [[nodiscard]] entry entry_of(face_id face) const noexcept {
        const std::array<dvec3, 3> p = view_.project(look_->source().corners(face));
        entry e;
        e.corner = dvec2(p[0]);
        e.u = dvec2(p[1]) - e.corner;
        e.v = dvec2(p[2]) - e.corner;
        const double det = e.u.x * e.v.y - e.u.y * e.v.x;
        if (det != 0) {
            e.to_b = dvec2(e.v.y, -e.v.x) / det;
            e.to_c = dvec2(-e.u.y, e.u.x) / det;
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
