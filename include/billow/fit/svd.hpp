// Orthogonal regression: the plane of least squared distances.
//
// C. Luksch: Implementation of an improved billboard cloud algorithm. Thesis, TU Wien 2009, eq 3.10.
#pragma once

#include <Eigen/Eigenvalues>

#include <billow/fit/fit.hpp>

namespace billow::inline BILLOW_ABI {

/// Minimises the sum of squared distances of the faces' corners, each counted once a face: the plane
/// through their mean whose normal is the eigenvector of the least eigenvalue of their covariance,
/// which is the last singular vector of the centred corners. Corners weigh the same, since weights
/// by area raise the largest error (Luksch 2009, section 3.3). Keeps the normal when the corners lie
/// on a line or show no direction.
struct svd_fit {
    static constexpr bool allows_less_contribution = true;
    [[nodiscard]] plane operator()(const face_table& faces, const plane& start) const {
        if (faces.size == 0) return start;
        dvec3 mean{0};
        for_each_corner(faces, [&](const dvec3& p) { mean += p; });
        mean /= 3 * static_cast<double>(faces.size);
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        for_each_corner(faces, [&](const dvec3& p) {
            const Eigen::Vector3d d(p.x - mean.x, p.y - mean.y, p.z - mean.z);
            covariance += d * d.transpose();
        });
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
        const Eigen::Vector3d& spread = solver.eigenvalues();  // ascending
        dvec3 normal = start.normal;
        if (spread(1) - spread(0) > 1e-9 * spread(2)) {
            const Eigen::Vector3d n = solver.eigenvectors().col(0);
            normal = glm::normalize(dvec3(n.x(), n.y(), n.z()));
            if (glm::dot(normal, start.normal) < 0) normal = -normal;
        }
        return {normal, glm::dot(normal, mean)};
    }
};
static_assert(plane_fitter<svd_fit>);

}  // namespace billow::inline BILLOW_ABI
