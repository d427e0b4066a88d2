#include <billow/improve/refine_whole.hpp>

#include <doctest/doctest.h>

#include <billow/search/greedy.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/covers.hpp"

using namespace billow;

TEST_SUITE("improve/refine_whole") {
    TEST_CASE(
        "after every kind of step each face is on one plane, within epsilon, on fewer planes") {
        const mesh soup = leaf_soup(1500, {.edge = 0.05f});
        const mesh pot = teapot(4);
        for (const mesh* m : {&soup, &pot}) {
            const face_table faces = support::table_of(*m);
            const billboard_cloud found = support::greedy_cloud(faces, 0.1);
            const double share = measure_errors(*m, found).projected_area_share;
            for (const whole_refinement_options& options :
                 {whole_refinement_options{.merge = true, .effort = 0, .reassign = false},
                  whole_refinement_options{.merge = false, .effort = 8, .reassign = false},
                  whole_refinement_options{.merge = false, .effort = 0, .reassign = true},
                  whole_refinement_options{.effort = 0, .rounds = 0}, whole_refinement_options{}}) {
                billboard_cloud cloud = found;
                const whole_refinement_report told = refine_whole(faces, cloud, options);
                support::check_whole(*m, cloud);
                CHECK(told.planes_before == found.plane_count());
                CHECK(told.planes_after == cloud.plane_count());
                CHECK(cloud.plane_count() <= found.plane_count());
                CHECK(told.projected_area_share_before == doctest::Approx(share).epsilon(1e-5));
                CHECK(
                    told.projected_area_share_after ==
                    doctest::Approx(measure_errors(*m, cloud).projected_area_share).epsilon(1e-5));
                CHECK(told.exchanges.tried <= options.effort);
                if (!options.merge && options.effort == 0) {
                    CHECK(told.projected_area_share_after >= told.projected_area_share_before);
                }
            }
        }
    }
    TEST_CASE("fewer planes, and more tangent, than the search alone finds") {
        const face_table faces = support::table_of(leaf_soup(4000, {.edge = 0.05f}));
        billboard_cloud cloud = support::greedy_cloud(faces, 0.1);
        const whole_refinement_report told = refine_whole(faces, cloud);
        CHECK(told.planes_after + 2 <= told.planes_before);
        CHECK(told.projected_area_share_after > told.projected_area_share_before + 0.05);
        CHECK(told.moved_faces > 0);
    }
    TEST_CASE("a second time changes nothing") {
        const face_table faces = support::table_of(teapot(3));
        billboard_cloud cloud = support::greedy_cloud(faces, 0.15);
        const whole_refinement_options thorough{.effort = 500, .rounds = 500};
        refine_whole(faces, cloud, thorough);
        const billboard_cloud once = cloud;
        const whole_refinement_report told = refine_whole(faces, cloud, thorough);
        CHECK(told.moved_faces == 0);
        CHECK(cloud.planes == once.planes);
        CHECK(cloud.plane_of_face == once.plane_of_face);
    }
    TEST_CASE("faces stay with the planes of their part, within its epsilon") {
        mesh m;
        support::add_level_plate(m, {-1, 0, 0}, 1);
        support::add_level_plate(m, {1, 0, 0.02f}, 1);
        support::add_level_plate(m, {-1, 0, 0.04f}, 1);
        support::add_level_plate(m, {1, 0, 0.08f}, 1);
        const face_table faces = support::table_of(m);
        billboard_cloud cloud = support::cloud_of(
            faces,
            {support::level_plane(faces, 0), support::level_plane(faces, 0.02),
             support::level_plane(faces, 0.04), support::level_plane(faces, 0.08)},
            0.1);
        cloud.part_of_plane = {0, 1, 0, 1};
        cloud.parts = {{0.1}, {0.01}};
        const std::vector<plane_id> before = cloud.plane_of_face;
        const whole_refinement_report told = refine_whole(faces, cloud);
        CHECK(told.planes_after == 3);
        CHECK(cloud.part_of_plane == std::vector<part_id>{0, 1, 1});
        CHECK(cloud.parts.size() == 2);
        support::check_whole(m, cloud);
        for (face_id face = 0; face < m.face_count(); ++face) {
            CHECK(cloud.part_of(cloud.plane_of_face[face]) == before[face] % 2);
        }
    }
    TEST_CASE("what is drawn too stays on planes that stay, where it is near") {
        mesh m;
        support::add_level_plate(m, {0, 0, 0}, 1);
        support::add_level_plate(m, {0, 0, 0.15f}, 1);
        support::add_level_plate(m, {0, 0, 0.5f}, 1);
        const face_table faces = support::table_of(m);
        billboard_cloud cloud =
            support::cloud_of(faces,
                              {support::level_plane(faces, 0.07), support::level_plane(faces, 0.15),
                               support::level_plane(faces, 0.5)},
                              0.1);
        cloud.also_drawn = {{0, 130}, {0, 300}, {1, 5}, {2, 5}};
        cloud.billboards.resize(3);
        CHECK(refine_whole(faces, cloud, {.reassign = false}).planes_after == 2);
        CHECK(cloud.billboards.empty());
        for (const drawn_too& drawn : cloud.also_drawn) {
            CHECK(drawn.plane < cloud.plane_count());
            CHECK(cloud.plane_of_face[drawn.face] != drawn.plane);
            CHECK(distances_to(cloud.planes[drawn.plane], faces, drawn.face).largest <= 0.1);
        }
        CHECK(std::ranges::is_sorted(cloud.also_drawn));
    }
    TEST_CASE("faces that the search left beyond epsilon are no worse off than need be") {
        const mesh m = leaf_soup(800, {.edge = 0.05f});
        const face_table faces = support::table_of(m);
        billboard_cloud cloud =
            greedy_search(faces, faces.size,
                          {.epsilon = 0.1 * faces.bounds.radius, .max_planes = 6})
                .cloud;
        cloud.plane_of_face[3] = no_id;
        const cloud_errors before = measure_errors(m, cloud);
        CHECK(before.faces_beyond_epsilon > 0);
        refine_whole(faces, cloud);
        const cloud_errors after = measure_errors(m, cloud);
        CHECK(after.faces_beyond_epsilon <= before.faces_beyond_epsilon);
        CHECK(after.mapped_faces == before.mapped_faces);
        CHECK(cloud.plane_of_face[3] == no_id);
        CHECK(cloud.plane_count() <= 6);
    }
    TEST_CASE("faces that are valid for no plane at all keep one") {
        const mesh m = support::random_triangles(20, 0.1, 3);
        const face_table faces = support::table_of(m);
        billboard_cloud cloud =
            support::cloud_of(faces, {{{0, 0, 1}, 0.7}, {{1, 0, 0}, 0.7}}, 1e-9);
        refine_whole(faces, cloud);
        CHECK(cloud.plane_count() == 1);
        CHECK(measure_errors(m, cloud).mapped_faces == 20);
    }
    TEST_CASE("the same bytes for any number of threads") {
        const face_table faces = support::table_of(leaf_soup(2000, {.edge = 0.05f}));
        const billboard_cloud found = support::greedy_cloud(faces, 0.1);
        billboard_cloud one = found, three = found;
        refine_whole(faces, one, {}, average_fit{}, {1});
        refine_whole(faces, three, {}, average_fit{}, {3});
        CHECK(one.planes == three.planes);
        CHECK(one.plane_of_face == three.plane_of_face);
    }
    TEST_CASE("clouds without planes or faces stay so; progress is told") {
        face_table none;
        billboard_cloud empty;
        CHECK(refine_whole(none, empty).planes_after == 0);
        mesh m;
        support::add_level_plate(m, {0, 0, 0}, 1);
        const face_table faces = support::table_of(m);
        billboard_cloud cloud =
            support::cloud_of(faces, {support::level_plane(faces, 0), {{1, 0, 0}, 0}}, 0.1);
        double last = 0;
        refine_whole(faces, cloud, {}, average_fit{}, {}, [&](std::string_view, double share) {
            CHECK(share >= 0);
            CHECK(share <= 1);
            last = share;
        });
        CHECK(last == 1);
        CHECK(cloud.plane_count() == 1);
    }
}
