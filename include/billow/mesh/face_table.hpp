// The faces of a mesh as the plane search reads them: columns of floats around the origin.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include <billow/core/expected.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/simd.hpp>
#include <billow/core/types.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/validate.hpp>

namespace billow::inline BILLOW_ABI {

/// Three columns: the coordinates of one point or vector a face.
struct columns3 {
    std::vector<float> x{}, y{}, z{};

    void resize(std::size_t size) { x.resize(size), y.resize(size), z.resize(size); }
    void set(std::size_t row, const dvec3& value) noexcept {
        x[row] = static_cast<float>(value.x);
        y[row] = static_cast<float>(value.y);
        z[row] = static_cast<float>(value.z);
    }
    [[nodiscard]] dvec3 get(std::size_t row) const noexcept { return {x[row], y[row], z[row]}; }
};

/// The faces of a mesh that have an area.
///
/// Shape  `size` rows, padded to the widest lane with faces of area 0, so that kernels have no tail
///        and padding adds nothing to a sum.
/// Unit   scene units, relative to bounds.centre; a coordinate is off by at most 6e-8 radii.
struct face_table {
    bounding_sphere bounds{};
    std::size_t size = 0;
    std::array<columns3, 3> corner{};
    columns3 normal{};  ///< unit length, by the right-hand rule
    std::vector<float> area{};
    std::vector<float> reach{};         ///< distance of the farthest corner to the origin
    std::vector<face_id> source{};      ///< the face of the mesh, `size` rows
    std::vector<face_id> degenerate{};  ///< faces of the mesh that were set aside

    [[nodiscard]] std::size_t padded_size() const noexcept { return area.size(); }
    [[nodiscard]] dvec3 centroid(std::size_t row) const noexcept {
        return (corner[0].get(row) + corner[1].get(row) + corner[2].get(row)) / 3.0;
    }
    /// Sets a row's corners and all that follows from them but its area and normal, which are given:
    /// a face of area 0 has none of its own.
    void set(std::size_t row, const std::array<dvec3, 3>& corners, const dvec3& unit_normal,
             double face_area) noexcept {
        double farthest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            corner[k].set(row, corners[k]);
            farthest = std::max(farthest, glm::length(corners[k]));
        }
        normal.set(row, unit_normal);
        area[row] = static_cast<float>(face_area);
        reach[row] = static_cast<float>(farthest);
    }
    /// Makes room for `rows` faces and their padding.
    void resize(std::size_t rows) {
        size = rows;
        const std::size_t all = simd::padded(rows);
        for (columns3& column : corner) column.resize(all);
        normal.resize(all);
        area.resize(all);
        reach.resize(all);
        source.resize(rows);
    }
};

namespace detail {

/// Calls `visit(column)` for each column of floats of each table, side by side.
template <class Visit>
void for_each_column(const face_table& from, face_table& to, const Visit& visit) {
    const auto visit3 = [&](const columns3& a, columns3& b) {
        visit(a.x, b.x), visit(a.y, b.y), visit(a.z, b.z);
    };
    for (std::size_t i = 0; i < 3; ++i) visit3(from.corner[i], to.corner[i]);
    visit3(from.normal, to.normal);
    visit(from.area, to.area);
    visit(from.reach, to.reach);
}

}  // namespace detail

/// A face is degenerate when its area is at most this times the squared radius: it has no normal.
inline constexpr double degenerate_area_share = 1e-12;

/// Centres the faces of `m` and computes what the search needs of each.
///
/// Fails  as validate does, naming the face; too_large where areas would leave the range of floats.
/// Cost   O(faces); 60 bytes a face.
/// Source Luksch 2009, section 4.1. Differs: faces without a normal are set aside.
[[nodiscard]] inline expected<face_table> make_face_table(const mesh& m, parallel threads = {}) {
    if (const expected<done> valid = validate(m, threads); !valid) return valid.error();
    face_table faces;
    faces.bounds = bounding_sphere_of(m.face_count() * 3, [&](std::size_t i) {
        return m.positions[m.triangles[i / 3][static_cast<glm::length_t>(i % 3)]];
    });
    const double radius = faces.bounds.radius;
    if (radius != 0 && !(radius > 1e-15 && radius < 1e15)) {
        return error{error_code::too_large,
                     "its radius is beyond single precision; scale it to between 1e-15 and 1e15"};
    }
    faces.resize(m.face_count());
    std::size_t row = 0;
    for (face_id face = 0; face < m.face_count(); ++face) {
        const auto [a, b, c] = m.corners(face);
        const std::array corners{dvec3(a) - faces.bounds.centre, dvec3(b) - faces.bounds.centre,
                                 dvec3(c) - faces.bounds.centre};
        const dvec3 cross = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
        const double doubled_area = glm::length(cross);
        if (!(doubled_area > 2 * degenerate_area_share * radius * radius)) {
            faces.degenerate.push_back(face);
            continue;
        }
        faces.set(row, corners, cross / doubled_area, doubled_area / 2);
        faces.source[row++] = face;
    }
    faces.resize(row);
    detail::for_each_column(
        faces, faces, [&](const std::vector<float>&, std::vector<float>& column) {
            std::fill(column.begin() + static_cast<std::ptrdiff_t>(row), column.end(), 0.0f);
        });
    return faces;
}

/// The given rows of `faces`, in the given order, as a table of its own (without `degenerate`).
[[nodiscard]] inline face_table select_rows(const face_table& faces,
                                            std::span<const std::uint32_t> rows,
                                            parallel threads = {}) {
    face_table selected;
    selected.bounds = faces.bounds;
    selected.resize(rows.size());
    threads.for_chunks(rows.size(), 16384, [&](std::size_t begin, std::size_t end) {
        detail::for_each_column(faces, selected, [&](const auto& from, auto& to) {
            for (std::size_t i = begin; i < end; ++i) to[i] = from[rows[i]];
        });
        for (std::size_t i = begin; i < end; ++i) selected.source[i] = faces.source[rows[i]];
    });
    return selected;
}

/// Calls `visit(corner)` for the first corners of all faces, then the second and the third ones.
template <class Visit>
void for_each_corner(const face_table& faces, const Visit& visit) {
    for (const columns3& corner : faces.corner) {
        for (std::size_t row = 0; row < faces.size; ++row) visit(corner.get(row));
    }
}

/// A point or vector in each lane.
template <class V>
struct vec3_lanes {
    V x, y, z;
};

template <class V>
[[nodiscard]] inline V dot(const vec3_lanes<V>& a, const vec3_lanes<V>& b) noexcept {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// The same vector in every lane.
template <class V>
[[nodiscard]] inline vec3_lanes<V> fill_lanes(const vec3& v) noexcept {
    using lanes = simd::lanes<V>;
    return {lanes::fill(v.x), lanes::fill(v.y), lanes::fill(v.z)};
}

/// A face in each lane.
template <class V>
struct face_lanes {
    std::array<vec3_lanes<V>, 3> corner;
    vec3_lanes<V> normal;
    V area;
    V reach;
};

/// The faces of the rows [row, row + lanes). Needs row + lanes ≤ padded_size().
template <class V>
[[nodiscard]] inline face_lanes<V> load_faces(const face_table& faces, std::size_t row) noexcept {
    const auto load = [row](const std::vector<float>& column) {
        return simd::lanes<V>::load(column.data() + row);
    };
    const auto load3 = [&](const columns3& columns) -> vec3_lanes<V> {
        return {load(columns.x), load(columns.y), load(columns.z)};
    };
    return {{load3(faces.corner[0]), load3(faces.corner[1]), load3(faces.corner[2])},
            load3(faces.normal),
            load(faces.area),
            load(faces.reach)};
}

}  // namespace billow::inline BILLOW_ABI
