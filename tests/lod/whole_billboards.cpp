#include <billow/lod/whole_billboards.hpp>

#include <map>
#include <set>

#include <doctest/doctest.h>

#include <billow/pipeline.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// Squares of all directions, as a cloud's mesh lays them.
mesh squares(std::size_t count, std::uint64_t seed) {
    random_stream random(seed);
    mesh m;
    for (std::size_t i = 0; i < count; ++i) {
        const frame axes = frame_around(support::random_direction(random));
        const dvec3 centre = support::random_direction(random) * random.between(0, 0.7);
        support::add_square(m, vec3(centre), vec3(axes.u * 0.3), vec3(axes.v * 0.3));
        m.feature_ids.insert(m.feature_ids.end(), 4, static_cast<std::uint32_t>(i));
    }
    return m;
}

}  // namespace

TEST_SUITE("lod/whole_billboards") {
    TEST_CASE("rows of a part of a billboard are dropped") {
        const mesh m = squares(4, 1);
        const face_table faces = support::table_of(m);
        const whole_billboards motion(billboards_of_faces(m));
        face_rows rows{0, 1, 2, 5, 6, 7};
        motion.keep_allowed(faces, {}, rows);
        CHECK(rows == face_rows{0, 1, 6, 7});
        rows = {3, 4};
        motion.keep_allowed(faces, {}, rows);
        CHECK(rows.empty());
        rows = {};
        motion.keep_allowed(faces, {}, rows);
        CHECK(rows.empty());
    }
    TEST_CASE("what is left of a billboard counts as the whole of it") {
        const mesh m = squares(3, 1);
        const face_rows remaining{0, 3, 4, 5};
        const face_table faces = select_rows(support::table_of(m), remaining);
        const whole_billboards motion(billboards_of_faces(m));
        face_rows rows{0, 1, 2};
        motion.keep_allowed(faces, {}, rows);
        CHECK(rows == face_rows{0, 1});
    }
    TEST_CASE("billboards of other shapes are kept whole too") {
        mesh m = squares(3, 2);
        m.triangles.push_back({8, 9, 11});  // a third triangle of the last one
        const face_table faces = support::table_of(m);
        const whole_billboards motion(billboards_of_faces(m));
        face_rows rows{2, 3, 4, 5};
        motion.keep_allowed(faces, {}, rows);
        CHECK(rows == face_rows{2, 3});
        rows = {4, 5, 6};
        motion.keep_allowed(faces, {}, rows);
        CHECK(rows == face_rows{4, 5, 6});
        rows = {4, 6};
        motion.keep_allowed(faces, {}, rows);
        CHECK(rows.empty());
    }
    TEST_CASE("a search leaves every square on one plane, within epsilon") {
        std::size_t parted_without = 0;
        for (const std::uint64_t seed : {3u, 4u, 5u}) {
            const mesh m = squares(60, seed);
            const auto count_parted = [&](const billboard_cloud& cloud) {
                std::size_t parted = 0;
                for (face_id face = 0; face < m.face_count(); face += 2) {
                    parted += cloud.plane_of_face[face] != cloud.plane_of_face[face + 1] ? 1u : 0u;
                }
                return parted;
            };
            const greedy_options options{.epsilon = 0.12};
            const auto whole =
                greedy_search(support::table_of(m), m.face_count(), options,
                              pipeline{cube_map(), density_policies{}, least_squares_fit{},
                                       whole_set{}, whole_billboards(billboards_of_faces(m))});
            CHECK(count_parted(whole.cloud) == 0);
            CHECK(measure_errors(m, whole.cloud).max_error <= 0.12 * (1 + 1e-9));
            CHECK(measure_errors(m, whole.cloud).mapped_faces == m.face_count());
            parted_without +=
                count_parted(greedy_search(support::table_of(m), m.face_count(), options).cloud);
        }
        CHECK(parted_without > 0);  // else this shows nothing
    }
}
