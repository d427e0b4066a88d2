// A camera as a map from the scene to a grid of samples.
//
// Interpolation in homogeneous coordinates after Olano and Greer, "Triangle Scan Conversion using 2D
// Homogeneous Coordinates", Graphics Hardware 1997: it needs no clipped corners.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <billow/core/types.hpp>
#include <billow/image/raster.hpp>
#include <billow/metrics/camera.hpp>

namespace billow::inline BILLOW_ABI {

/// dot(slope, point) + offset.
struct linear_form {
    dvec3 slope{0};
    double offset = 0;

    [[nodiscard]] double at(const dvec3& point) const noexcept {
        return glm::dot(slope, point) + offset;
    }
};

/// The grid of samples of a camera: `supersample` a pixel side, columns to the right, rows down. A
/// point is seen at (x / w, y / w) samples. Of two points on a ray the one of greater `nearness` is
/// seen: of a perspective camera that is 1 / w, of an orthographic one the height along the normal.
struct sample_view {
    linear_form x{};
    linear_form y{};
    linear_form w{};  ///< perspective: the distance along -axes.normal; orthographic: 1
    linear_form height{};
    double near_distance = 0;
    bool is_orthographic = false;
    int supersample = 1;
    int columns = 0;
    int rows = 0;

    sample_view() = default;
    sample_view(const camera& from, int samples_a_side)
        : near_distance(from.is_orthographic ? 0 : from.near_distance),
          is_orthographic(from.is_orthographic),
          supersample(samples_a_side),
          columns(from.width_px * samples_a_side),
          rows(from.height_px * samples_a_side) {
        const double scale = rows / from.height;
        const auto form = [&](const dvec3& axis, double factor) {
            return linear_form{axis * factor, -factor * glm::dot(axis, from.eye)};
        };
        height = form(from.axes.normal, 1);
        w = is_orthographic ? linear_form{dvec3(0), 1} : form(from.axes.normal, -1);
        x = form(from.axes.u, scale);
        y = form(from.axes.v, -scale);
        x = {x.slope + w.slope * (0.5 * columns), x.offset + w.offset * (0.5 * columns)};
        y = {y.slope + w.slope * (0.5 * rows), y.offset + w.offset * (0.5 * rows)};
        const frame& axes = from.axes;
        eye_ray_ = axes.normal;
        if (!is_orthographic) {
            ray_x_ = -axes.u / scale;
            ray_y_ = axes.v / scale;
            eye_ray_ += axes.u * (0.5 * columns / scale) - axes.v * (0.5 * rows / scale);
        }
    }

    [[nodiscard]] dvec3 project(const dvec3& point) const noexcept {
        return {x.at(point), y.at(point), w.at(point)};
    }
    /// The unit vector to the viewer from what is seen at a place, in samples.
    [[nodiscard]] vec3 toward_viewer(const dvec2& at) const noexcept {
        return vec3(glm::normalize(eye_ray_ + ray_x_ * at.x + ray_y_ * at.y));
    }
    /// The distance from the eye along -axes.normal. Of an orthographic camera it may be negative.
    [[nodiscard]] double distance_of(double nearness) const noexcept {
        return is_orthographic ? -nearness : 1 / nearness;
    }

private:
    dvec3 eye_ray_{0, 0, 1};
    dvec3 ray_x_{0};
    dvec3 ray_y_{0};
};

/// How the values of a face change over the grid: value / w is linear in columns and rows. With
/// `share` being the three barycentric weights divided by w, 1 / w is their sum.
struct face_gradients {
    std::array<affine_value, 3> share{};
    affine_value inverse_w{};
    affine_value nearness{};
    float nearness_low = 0;   ///< over the seen part
    float nearness_high = 0;  ///< slivers must not shoot out
    double w_least = 1;       ///< over the seen part
    double w_greatest = 1;
    double doubled_volume = 0;  ///< of the homogeneous corners: doubled area in samples · w³

    face_gradients() = default;
    face_gradients(const sample_view& view, const std::array<vec3, 3>& corners) noexcept {
        std::array<dvec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = view.project(dvec3(corners[k]));
        const dvec3 edges = glm::cross(p[1] - p[0], p[2] - p[0]);
        const double volume = glm::dot(p[0], edges);
        doubled_volume = std::abs(volume);
        if (volume == 0) return;
        const double scale = 1 / volume;
        const auto affine = [&](const dvec3& normal) {
            const dvec3 n = normal * scale;
            return affine_value{n.z + 0.5 * (n.x + n.y), n.x, n.y};
        };
        for (std::size_t k = 0; k < 3; ++k) {
            share[k] = affine(glm::cross(p[(k + 1) % 3], p[(k + 2) % 3]));
        }
        inverse_w = affine(edges);
        const auto [low, high] = std::minmax({p[0].z, p[1].z, p[2].z});
        w_least = std::max(low, view.near_distance);
        w_greatest = high;
        nearness = inverse_w;
        nearness_low = static_cast<float>(1 / w_greatest);
        nearness_high = static_cast<float>(1 / w_least);
        if (!view.is_orthographic) return;
        const dvec3 heights(view.height.at(dvec3(corners[0])), view.height.at(dvec3(corners[1])),
                            view.height.at(dvec3(corners[2])));
        nearness = combined(heights);
        nearness_low = static_cast<float>(std::min({heights.x, heights.y, heights.z}));
        nearness_high = static_cast<float>(std::max({heights.x, heights.y, heights.z}));
    }

    /// Of values at the corners, divided by w.
    [[nodiscard]] affine_value combined(const dvec3& at_corners) const noexcept {
        affine_value sum;
        for (std::size_t k = 0; k < 3; ++k) {
            const double value = at_corners[static_cast<int>(k)];
            sum.base += share[k].base * value;
            sum.dx += share[k].dx * value;
            sum.dy += share[k].dy * value;
        }
        return sum;
    }
    /// The area in samples that the whole face would cover if it were as large everywhere as where
    /// 1 / w is this: what mip levels follow from.
    [[nodiscard]] double area_at(double inverse) const noexcept {
        return 0.5 * doubled_volume * inverse * inverse * inverse;
    }
    /// Whether one mip level cannot do for the whole face: sizes differ by more than 2 in area.
    [[nodiscard]] bool is_foreshortened() const noexcept {
        return w_greatest > 1.26 * w_least;  // 2^(1/3)
    }
    /// 1 / w in its middle.
    [[nodiscard]] double middle() const noexcept { return 2 / (w_least + w_greatest); }
};

}  // namespace billow::inline BILLOW_ABI
