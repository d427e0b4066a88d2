// Sets of faces that a search works with: those a plane takes, those a bin may take.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/policy/contribution.hpp>
#include <billow/policy/falloff.hpp>
#include <billow/policy/validity.hpp>

namespace billow::inline BILLOW_ABI {

/// Rows of a face table, ascending.
using face_rows = std::vector<std::uint32_t>;

/// The rows for which `predicate(face_lanes<wide>)` gives a positive number, in parallel.
template <class Predicate>
[[nodiscard]] face_rows filter_rows(const face_table& faces, const Predicate& predicate,
                                    parallel threads = {}) {
    using V = simd::wide;
    static constexpr std::size_t chunk = 8192;
    std::vector<float> keeps(faces.padded_size());
    std::vector<std::size_t> counts((faces.padded_size() + chunk - 1) / chunk + 1);
    threads.for_chunks(faces.padded_size(), chunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; row += simd::lanes<V>::count) {
            simd::lanes<V>::store(keeps.data() + row, predicate(load_faces<V>(faces, row)));
        }
        std::size_t count = 0;
        for (std::size_t row = begin; row < std::min(end, faces.size); ++row) {
            if (keeps[row] > 0) ++count;
        }
        counts[begin / chunk + 1] = count;
    });
    for (std::size_t i = 1; i < counts.size(); ++i) counts[i] += counts[i - 1];
    face_rows rows(counts.back());
    threads.for_chunks(faces.padded_size(), chunk, [&](std::size_t begin, std::size_t end) {
        std::size_t at = counts[begin / chunk];
        for (std::size_t row = begin; row < std::min(end, faces.size); ++row) {
            if (keeps[row] > 0) rows[at++] = static_cast<std::uint32_t>(row);
        }
    });
    return rows;
}

namespace detail {

/// The faces whose three corners lie within epsilon of `p` and whose normal's |cosine| with that of
/// `p` is at least `least_cosine`.
[[nodiscard]] inline face_rows valid_rows(const face_table& faces, const plane& p, double epsilon,
                                          float least_cosine, parallel threads) {
    using V = simd::wide;
    const auto fill = [](double value) { return simd::lanes<V>::fill(static_cast<float>(value)); };
    const vec3_lanes<V> normal = fill_lanes<V>(vec3(p.normal));
    const V rho = fill(p.rho);
    const V eps = fill(epsilon);
    const V least = simd::lanes<V>::fill(least_cosine);
    const V yes = fill(1);
    const V no = fill(0);
    return filter_rows(
        faces,
        [&](const face_lanes<V>& face) {
            const offset_interval<V> valid = valid_offsets(face, normal, eps);
            const V near =
                simd::select(valid.low <= rho, simd::select(rho <= valid.high, yes, no), no);
            return simd::select(simd::abs(dot(face.normal, normal)) >= least, near, no);
        },
        threads);
}

}  // namespace detail

/// The faces whose three corners lie within epsilon of `p`. Source: Luksch 2009, section 2.1.
[[nodiscard]] inline face_rows faces_valid_for(const face_table& faces, const plane& p,
                                               double epsilon, parallel threads = {}) {
    return detail::valid_rows(faces, p, epsilon, 0, threads);
}

/// Those of them that the contribution policy allows on a plane with that normal: `least_cosine_of`.
template <contribution<float> Contribution>
[[nodiscard]] face_rows faces_valid_for(const face_table& faces, const plane& p, double epsilon,
                                        const Contribution& worth, parallel threads = {}) {
    return detail::valid_rows(faces, p, epsilon, least_cosine_of(worth), threads);
}

/// The faces that `estimate` finds valid for some plane of a cell with an offset in [low, high], and
/// that `worth` may allow on one: "simple validity". Source: Luksch 2009, section 2.1.
template <validity<simd::wide> Validity, contribution<float> Contribution>
[[nodiscard]] face_rows faces_valid_for_bin(const face_table& faces, const orientation_cell& cell,
                                            double low, double high, double epsilon,
                                            const Validity& estimate, const Contribution& worth,
                                            parallel threads = {}) {
    using V = simd::wide;
    const auto fill = [](double value) { return simd::lanes<V>::fill(static_cast<float>(value)); };
    const cell_lanes<V> lanes(cell);
    const V eps = fill(epsilon);
    const V bin_low = fill(low);
    const V bin_high = fill(high);
    // |n·f - n_c·f| ≤ |n - n_c|, the chord.
    const V least = simd::lanes<V>::fill(least_cosine_of(worth) - cell.chord);
    const V yes = fill(1);
    const V no = fill(0);
    return filter_rows(
        faces,
        [&](const face_lanes<V>& face) {
            const offset_interval<V> valid = estimate(face, lanes, eps);
            const V from = simd::max(valid.low, bin_low);
            const V to = simd::min(valid.high, bin_high);
            const V near =
                simd::select(from <= to, simd::select(valid.low <= valid.high, yes, no), no);
            return simd::select(simd::abs(dot(face.normal, lanes.centre)) >= least, near, no);
        },
        threads);
}
template <validity<simd::wide> Validity>
[[nodiscard]] face_rows faces_valid_for_bin(const face_table& faces, const orientation_cell& cell,
                                            double low, double high, double epsilon,
                                            const Validity& estimate, parallel threads = {}) {
    return faces_valid_for_bin(faces, cell, low, high, epsilon, estimate, projected_area{},
                               threads);
}

/// Contribution of the given rows to a plane with `normal`, summed in their order in double.
template <contribution<float> Contribution>
[[nodiscard]] double contribution_of(const face_table& faces, const face_rows& rows,
                                     const dvec3& normal, const Contribution& worth) {
    const vec3_lanes<float> n = fill_lanes<float>(vec3(normal));
    double sum = 0;
    for (const std::uint32_t row : rows) {
        sum += static_cast<double>(worth(load_faces<float>(faces, row), n));
    }
    return sum;
}

/// The same for the plane `p`, each row weighted by the falloff of `p`'s distance from the middle of
/// its valid offsets, of which half of `spacing` is free. Needs rows that are valid for `p`.
template <contribution<float> Contribution, falloff<float> Falloff>
[[nodiscard]] double contribution_of(const face_table& faces, const face_rows& rows, const plane& p,
                                     const Contribution& worth, const Falloff& weigh,
                                     double epsilon, double spacing) {
    const vec3_lanes<float> n = fill_lanes<float>(vec3(p.normal));
    const auto eps = static_cast<float>(epsilon);
    double sum = 0;
    for (const std::uint32_t row : rows) {
        const face_lanes<float> face = load_faces<float>(faces, row);
        const offset_interval<float> valid = valid_offsets(face, n, eps);
        const double middle =
            (static_cast<double>(valid.low) + static_cast<double>(valid.high)) / 2;
        const double distance = std::max(0.0, std::abs(p.rho - middle) - spacing / 2);
        sum += static_cast<double>(worth(face, n) * weigh(static_cast<float>(distance), eps));
    }
    return sum;
}

/// The plane that the face of `row` lies in.
[[nodiscard]] inline plane supporting_plane(const face_table& faces, std::size_t row) {
    const dvec3 normal = glm::normalize(faces.normal.get(row));
    return {normal, glm::dot(normal, faces.centroid(row))};
}

}  // namespace billow::inline BILLOW_ABI
