// Regression plane: the height field of least squares over the start plane.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009,
// eq 3.11 to 3.14.
#pragma once

#include <Eigen/Cholesky>

#include <cmath>

#include <billow/fit/fit.hpp>
#include <billow/geometry/frame.hpp>

namespace billow::inline BILLOW_ABI {

/// Heights of the faces' corners over the start plane, explained by z = s x + t y + h. Good while
/// the tilt is small, which the faces of one plane ensure. Keeps the plane when the corners lie on a
/// line. Differs from eq 3.13 and 3.14 by the normalisation of (-s, -t, 1), which they omit, and by
/// centring x and y, since the condition of the normal equations is squared.
struct least_squares_fit {
    static constexpr bool allows_less_contribution = true;
    [[nodiscard]] plane operator()(const face_table& faces, const plane& start) const {
        if (faces.size == 0) return start;
        const frame axes = frame_around(start.normal);
        dvec3 mean{0};
        for_each_corner(faces, [&](const dvec3& corner) { mean += axes.to_local(corner); });
        mean /= 3 * static_cast<double>(faces.size);
        Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
        Eigen::Vector2d right = Eigen::Vector2d::Zero();
        for_each_corner(faces, [&](const dvec3& corner) {
            const dvec3 p = axes.to_local(corner);
            const Eigen::Vector2d xy(p.x - mean.x, p.y - mean.y);
            matrix += xy * xy.transpose();
            right += xy * (p.z - mean.z);
        });
        const double trace = matrix.trace();
        const double determinant = matrix(0, 0) * matrix(1, 1) - matrix(0, 1) * matrix(1, 0);
        if (!(determinant > 1e-12 * trace * trace)) return start;
        const Eigen::Vector2d slope = matrix.ldlt().solve(right);
        const dvec3 normal = axes.to_scene(glm::normalize(dvec3(-slope.x(), -slope.y(), 1)));
        return {normal, glm::dot(normal, axes.to_scene(mean))};
    }
};
static_assert(plane_fitter<least_squares_fit>);

}  // namespace billow::inline BILLOW_ABI
