// The Utah teapot: Martin Newell, University of Utah, 1975.
//
// The control points are Newell's, in the common form whose height Blinn divided by 1.3. They are
// kept in a shorter spelling: rim, body, bottom, knob and lid turn around the axis with the handle
// length 0.56 r, so their profiles say it all (the knob is written with 0.45 for 0.8); handle and
// spout are mirrored, so one half says it all. Written out they are the 32 patches. The lid is as
// published, too: 0.1 narrower than the rim that it lies in.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

/// Bicubic Bézier patches side by side: (3 rows + 1) x (3 columns + 1) control points, z up.
struct bezier_sheet {
    int rows = 0;
    int columns = 0;
    std::vector<dvec3> points{};

    [[nodiscard]] const dvec3& point(int row, int column) const noexcept {
        return points[static_cast<std::size_t>(row * (3 * columns + 1) + column)];
    }
};

/// The four Bernstein polynomials of degree 3 at `t`, and their derivatives.
struct bernstein {
    explicit bernstein(double t)
        : value{(1 - t) * (1 - t) * (1 - t), 3 * t * (1 - t) * (1 - t), 3 * t * t * (1 - t),
                t * t * t},
          slope{-3 * (1 - t) * (1 - t), 3 * (1 - t) * (1 - 3 * t), 3 * t * (2 - 3 * t), 3 * t * t} {
    }
    std::array<double, 4> value, slope;
};

struct surface_point {
    dvec3 position, normal;
};

/// The point of grid line (i, j) when every patch is cut into `segments` x `segments`.
[[nodiscard]] inline surface_point evaluate(const bezier_sheet& sheet, int i, int j, int segments) {
    const int row = std::min(i / segments, sheet.rows - 1);
    const int column = std::min(j / segments, sheet.columns - 1);
    const bernstein s(double(i - row * segments) / segments);
    const bernstein t(double(j - column * segments) / segments);
    dvec3 position{0}, along{0}, around{0}, twist{0};
    for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
            const dvec3& p = sheet.point(3 * row + int(a), 3 * column + int(b));
            position += s.value[a] * t.value[b] * p;
            along += s.slope[a] * t.value[b] * p;
            around += s.value[a] * t.slope[b] * p;
            twist += s.slope[a] * t.slope[b] * p;
        }
    }
    dvec3 normal = glm::cross(around, along);
    if (glm::dot(normal, normal) < 1e-18) {  // a pole: `around` vanishes, its change does not
        normal = glm::cross(i == 0 ? twist : -twist, along);
    }
    return {position, glm::normalize(normal)};
}

/// Adds the sheet, turned to y up. Faces with two corners in a pole are left out.
inline void tessellate(const bezier_sheet& sheet, int segments, mesh& out) {
    const auto first = static_cast<std::uint32_t>(out.vertex_count());
    const int height = sheet.rows * segments, width = sheet.columns * segments;
    for (int i = 0; i <= height; ++i) {
        for (int j = 0; j <= width; ++j) {
            // The last column repeats the first one bit for bit; only its u differs.
            const auto [p, n] = evaluate(sheet, i, j == width ? 0 : j, segments);
            out.positions.emplace_back(p.x, p.z, -p.y);
            out.normals.emplace_back(n.x, n.z, -n.y);
            out.uv_sets[0].emplace_back(1 - float(j) / float(width), float(i) / float(height));
        }
    }
    const auto is_pole = [&](int row) { return sheet.point(row, 0) == sheet.point(row, 1); };
    for (int i = 0; i < height; ++i) {
        for (int j = 0; j < width; ++j) {
            const auto a = first + static_cast<std::uint32_t>(i * (width + 1) + j);
            const auto c = a + static_cast<std::uint32_t>(width + 1);
            if (i > 0 || !is_pole(0)) out.triangles.emplace_back(a, a + 1, c);
            if (i + 1 < height || !is_pole(3 * sheet.rows)) {
                out.triangles.emplace_back(a + 1, c + 1, c);
            }
        }
    }
}

/// Turns a profile of (radius, height) around the z axis: four quarters.
[[nodiscard]] inline bezier_sheet turned(std::span<const dvec2> profile) {
    bezier_sheet sheet{.rows = static_cast<int>(profile.size()) / 3, .columns = 4};
    for (const dvec2& p : profile) {
        const double r = p.x, h = p.y, k = r == 0.8 ? 0.45 : 0.56 * r;
        for (const dvec2& q : {dvec2(r, 0), dvec2(r, -k), dvec2(k, -r),     //
                               dvec2(0, -r), dvec2(-k, -r), dvec2(-r, -k),  //
                               dvec2(-r, 0), dvec2(-r, k), dvec2(-k, r),    //
                               dvec2(0, r), dvec2(k, r), dvec2(r, k), dvec2(r, 0)}) {
            sheet.points.emplace_back(q, h);
        }
    }
    return sheet;
}

/// One row of a tube: the (x, z) where it crosses the plane of symmetry, and its half width.
struct tube_row {
    dvec2 from, to;
    double half_width;
};

[[nodiscard]] inline bezier_sheet mirrored(std::span<const tube_row> rows) {
    bezier_sheet sheet{.rows = static_cast<int>(rows.size()) / 3, .columns = 2};
    for (const auto& [from, to, w] : rows) {
        for (const auto& [p, y] :
             {std::pair{from, 0.0}, std::pair{from, -w}, std::pair{to, -w}, std::pair{to, 0.0},
              std::pair{to, w}, std::pair{from, w}, std::pair{from, 0.0}}) {
            sheet.points.emplace_back(p.x, y, p.y);
        }
    }
    return sheet;
}

}  // namespace detail

/// The Utah teapot, each of its 32 patches cut into `segments` x `segments` cells.
///
/// Shape   64 segments² - 8 segments faces (6,320 at 10). Vertices are shared inside rim, body and
///         bottom, knob, lid, handle and spout; along the seam of u = 0 and 1 they are doubled.
/// Unit    Newell's: 3.15 high, standing on y = 0, spout towards +x.
/// Needs   segments ≥ 1.
[[nodiscard]] inline mesh teapot(int segments) {
    BILLOW_ASSERT(segments >= 1);
    static constexpr dvec2 body[] = {
        {1.4, 2.4}, {1.3375, 2.53125}, {1.4375, 2.53125}, {1.5, 2.4},  {1.75, 1.875}, {2, 1.35},
        {2, 0.9},   {2, 0.45},         {1.5, 0.225},      {1.5, 0.15}, {1.5, 0.075},  {1.425, 0},
        {0, 0}};
    static constexpr dvec2 knob[] = {{0, 3.15}, {0.8, 3.15}, {0, 2.85}, {0.2, 2.7}};
    static constexpr dvec2 lid[] = {{0.2, 2.7}, {0.4, 2.55}, {1.3, 2.55}, {1.3, 2.4}};
    static constexpr detail::tube_row handle[] = {
        {{-1.6, 2.025}, {-1.5, 2.25}, 0.3}, {{-2.3, 2.025}, {-2.5, 2.25}, 0.3},
        {{-2.7, 2.025}, {-3, 2.25}, 0.3},   {{-2.7, 1.8}, {-3, 1.8}, 0.3},
        {{-2.7, 1.575}, {-3, 1.35}, 0.3},   {{-2.5, 1.125}, {-2.65, 0.9375}, 0.3},
        {{-2, 0.9}, {-1.9, 0.6}, 0.3}};
    static constexpr detail::tube_row spout[] = {
        {{1.7, 1.425}, {1.7, 0.6}, 0.66},       {{2.6, 1.425}, {3.1, 0.825}, 0.66},
        {{2.3, 2.1}, {2.4, 2.025}, 0.25},       {{2.7, 2.4}, {3.3, 2.4}, 0.25},
        {{2.8, 2.475}, {3.525, 2.49375}, 0.25}, {{2.9, 2.475}, {3.45, 2.5125}, 0.15},
        {{2.8, 2.4}, {3.2, 2.4}, 0.15}};

    mesh pot;
    for (const auto& sheet : {detail::turned(body), detail::turned(knob), detail::turned(lid),
                              detail::mirrored(handle), detail::mirrored(spout)}) {
        detail::tessellate(sheet, segments, pot);
    }
    pot.materials = {{.name = "porcelain",
                      .base_color = {0.85f, 0.83f, 0.78f, 1},
                      .metallic = 0,
                      .roughness = 0.3f,
                      .is_double_sided = true}};  // the inside shows between rim and lid
    return pot;
}

}  // namespace billow::inline BILLOW_ABI
