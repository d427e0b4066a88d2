#include <billow/search/weld_online.hpp>

#include <algorithm>

#include <doctest/doctest.h>

#include <billow/cloud/cracks.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/improve/drawn_mesh.hpp>
#include <billow/search/greedy.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/sphere.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

greedy_result search_welded(const mesh& m, double share, weld_kind kind, unsigned threads = 0) {
    face_table faces = support::table_of(m);
    const double epsilon = share * faces.bounds.radius;
    return greedy_search(std::move(faces), m.face_count(), {.epsilon = epsilon},
                         pipeline{cube_map{}, density_policies<>{}, least_squares_fit{},
                                  whole_set{}, weld_online({.kind = kind})},
                         {threads});
}

void check_welded_promises(const mesh& m, const greedy_result& r) {
    const cloud_errors errors = measure_errors(m, r.cloud);
    CHECK(errors.max_error <= r.cloud.epsilon * (1 + 1e-9));
    CHECK(errors.mapped_faces + r.statistics.degenerate_faces == m.face_count());
    CHECK(std::is_sorted(r.moved.begin(), r.moved.end(),
                         [](const auto& a, const auto& b) { return a.face < b.face; }));
    for (const moved_face& moved : r.moved) {
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec3 was = dvec3(m.corners(moved.face)[k]) - r.cloud.bounds.centre;
            CHECK(glm::distance(was, moved.corners[k]) <= r.cloud.epsilon);
        }
    }
}

}  // namespace

TEST_SUITE("search/weld_online") {
    TEST_CASE("every face ends on one plane, its own corners and the moved ones within epsilon") {
        for (const weld_kind kind : {weld_kind::first, weld_kind::intersection}) {
            for (const double share : {0.15, 0.05}) {
                for (const mesh& m : {teapot(3), icosphere(2), leaf_soup(400, {.edge = 0.1f})}) {
                    check_welded_promises(m, search_welded(m, share, kind));
                }
            }
        }
    }
    TEST_CASE("the cracks of a teapot close more than without") {
        const mesh m = teapot(6);
        face_table faces = support::table_of(m);
        const double epsilon = 0.06 * faces.bounds.radius;
        const billboard_cloud plain =
            greedy_search(std::move(faces), m.face_count(), {.epsilon = epsilon}).cloud;
        const double before = measure_cracks(m, plain, m).area;
        double last = before;
        for (const weld_kind kind : {weld_kind::first, weld_kind::intersection}) {
            const greedy_result r = search_welded(m, 0.06, kind);
            const double after = measure_cracks(m, r.cloud, drawn_mesh(m, r.cloud, r.moved)).area;
            CHECK(after < 0.8 * last);
            last = after;
        }
    }
    TEST_CASE("threads do not matter") {
        const mesh m = teapot(4);
        const greedy_result one = search_welded(m, 0.06, weld_kind::intersection, 1);
        const greedy_result three = search_welded(m, 0.06, weld_kind::intersection, 3);
        CHECK(one.cloud.planes == three.cloud.planes);
        CHECK(one.cloud.plane_of_face == three.cloud.plane_of_face);
        REQUIRE(one.moved.size() == three.moved.size());
        for (std::size_t i = 0; i < one.moved.size(); ++i) {
            CHECK(one.moved[i].corners == three.moved[i].corners);
        }
    }
    TEST_CASE("faces that share nothing are searched as they are") {
        const mesh m = support::random_triangles(200, 0.2, 6);
        const greedy_result r = search_welded(m, 0.1, weld_kind::intersection);
        face_table faces = support::table_of(m);
        const greedy_result plain =
            greedy_search(std::move(faces), m.face_count(), {.epsilon = r.cloud.epsilon});
        CHECK(r.moved.empty());
        CHECK(r.cloud.planes == plain.cloud.planes);
        CHECK(r.cloud.plane_of_face == plain.cloud.plane_of_face);
    }
    TEST_CASE("a face that loses its area keeps a plane that holds it") {
        mesh m = support::triangles({{0, 0, 0}, {1, 0, 0.1f}, {0, 1, 0.1f}});
        m.positions.insert(m.positions.end(), {{0, 0, 2}, {1, 0, 2}});
        m.triangles.push_back({0, 3, 1});
        face_table faces = support::table_of(m);
        weld_online motion;
        motion.start(faces, 2);
        const std::vector<std::uint32_t> taken{1};
        const std::vector<std::uint32_t> left{0};
        face_table remaining = select_rows(faces, left);
        // Both shared corners go to one point.
        const dvec3 along = glm::normalize(faces.corner[1].get(0) - faces.corner[0].get(0));
        const plane across{along, glm::dot(along, faces.corner[0].get(0))};
        const face_rows moving = motion.plane_found(select_rows(faces, taken), across, remaining);
        REQUIRE(moving == face_rows{0});
        motion.move(remaining, moving);
        CHECK(remaining.area[0] == 0);
        const plane held = supporting_plane(remaining, 0);
        for (const columns3& corner : remaining.corner) {
            CHECK(std::abs(signed_distance(held, corner.get(0))) < 1e-6);
        }
    }
}
