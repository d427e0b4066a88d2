#include <billow/policy/validity.hpp>

#include <array>

#include <doctest/doctest.h>

#include <billow/plane_space/cube_map.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

constexpr float eps = 0.05f;

offset_interval<float> exact(const face_table& faces, std::size_t row, const dvec3& normal) {
    return valid_offsets(load_faces<float>(faces, row), fill_lanes<float>(vec3(normal)), eps);
}

/// Calls visit(face, cell, row, patch) for random faces and cells of a cube map.
template <class Visit>
void for_random_pairs(const Visit& visit) {
    const cube_map space(18);
    const face_table faces = support::table_of(support::random_triangles(400, 0.12, 5));
    random_stream random(11);
    for (std::size_t row = 0; row < faces.size; ++row) {
        const orientation_id id = space.orientation_of(support::random_direction(random));
        // Patches are squares in chart coordinates, so their inside can be sampled.
        const orientation_patch patch = space.patch(id);
        const orientation_cell cell = cell_of_patch(space, patch);
        visit(faces, row, space, patch, cell);
    }
}

}  // namespace

TEST_SUITE("policy/validity") {
    TEST_CASE("a plane is valid for a face when its three vertices are within epsilon") {
        const face_table faces = support::table_of(support::random_triangles(200, 0.1, 6));
        random_stream random(2);
        for (std::size_t row = 0; row < faces.size; ++row) {
            const dvec3 n = support::random_direction(random);
            const double rho = glm::dot(n, faces.centroid(row)) + random.between(-0.07, 0.07);
            bool all_near = true;
            for (const columns3& corner : faces.corner) {
                all_near &= std::abs(glm::dot(n, corner.get(row)) - rho) <= double(eps);
            }
            const auto valid = exact(faces, row, n);
            CHECK((double(valid.low) <= rho && rho <= double(valid.high)) == all_near);
        }
    }
    TEST_CASE("one near vertex does not make a face valid, and sides of the origin differ") {
        // Public code takes the smallest distance of the vertices, and |n·v| for n·v.
        const face_table faces = support::table_of(support::triangles({{0, 0, 0.5f},
                                                                       {0.1f, 0, 0.9f},
                                                                       {0, 0.1f, 0.9f},
                                                                       {0, 0, -0.5f},
                                                                       {1, 0, -0.5f},
                                                                       {0, 1, -0.5f}}));
        CHECK(exact(faces, 0, {0, 0, 1}).low > exact(faces, 0, {0, 0, 1}).high);
        const double centre = faces.bounds.centre.z;
        const auto below = exact(faces, 1, {0, 0, 1});
        CHECK(double(below.low) == doctest::Approx(-0.5 - centre - 0.05).epsilon(1e-5));
        CHECK(double(below.high) == doctest::Approx(-0.5 - centre + 0.05).epsilon(1e-5));
    }
    TEST_CASE("A lies within B, and the true interval within C") {
        int valid_count = 0;
        for_random_pairs([&](const face_table& faces, std::size_t row, const cube_map& space,
                             const orientation_patch& patch, const orientation_cell& cell) {
            const auto face = load_faces<float>(faces, row);
            const cell_lanes<float> lanes(cell);
            const auto a = hull_of_samples{}(face, lanes, eps);
            const auto b = intersection_of_vertices{}(face, lanes, eps);
            const auto c = widened_centre{}(face, lanes, eps);
            if (a.low <= a.high) {
                CHECK(b.low <= a.low + 1e-6f);
                CHECK(b.high >= a.high - 1e-6f);
            }
            for (int i = -8; i <= 8; ++i) {
                for (int j = -8; j <= 8; ++j) {
                    const dvec3 n = space.direction_at(
                        patch.chart, patch.centre + patch.half_size * dvec2(i, j) / 8.0);
                    const auto truth = exact(faces, row, n);
                    if (truth.low > truth.high) continue;
                    ++valid_count;
                    REQUIRE(c.low <= truth.low + 1e-6f);
                    REQUIRE(c.high >= truth.high - 1e-6f);
                }
            }
        });
        CHECK(valid_count > 1000);
    }
    TEST_CASE("A has no false positives: it is reached by planes at the cell's corners") {
        for_random_pairs([&](const face_table& faces, std::size_t row, const cube_map&,
                             const orientation_patch&, const orientation_cell& cell) {
            const auto a =
                hull_of_samples{}(load_faces<float>(faces, row), cell_lanes<float>(cell), eps);
            bool is_valid_somewhere = false;
            for (const vec3& corner : cell.corner) {
                const auto at = exact(faces, row, dvec3(corner));
                is_valid_somewhere |= at.low <= at.high;
            }
            CHECK((a.low <= a.high) == is_valid_somewhere);
        });
    }
    TEST_CASE("a larger epsilon never takes validity away") {
        const face_table faces = support::table_of(support::random_triangles(100, 0.2, 7));
        random_stream random(4);
        for (std::size_t row = 0; row < faces.size; ++row) {
            const auto face = load_faces<float>(faces, row);
            const auto n = fill_lanes<float>(vec3(support::random_direction(random)));
            const auto small = valid_offsets(face, n, 0.03f);
            const auto large = valid_offsets(face, n, 0.06f);
            CHECK(large.low <= small.low);
            CHECK(large.high >= small.high);
        }
    }
}
