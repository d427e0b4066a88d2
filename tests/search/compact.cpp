#include <billow/search/compact.hpp>

#include <algorithm>

#include <doctest/doctest.h>

#include <billow/cloud/fit_billboards.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/search/greedy.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// Adds a square plate of n × n squares in the plane z = 0.
void add_plate(mesh& m, const vec3& centre, float half, int n) {
    const float step = half / static_cast<float>(n);
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const vec3 at(static_cast<float>(2 * x + 1 - n) * step,
                          static_cast<float>(2 * y + 1 - n) * step, 0);
            support::add_square(m, centre + at, {step, 0, 0}, {0, step, 0});
        }
    }
}

/// Two plates on one plane, in opposite corners of it; the second is smaller.
mesh far_plates() {
    mesh m;
    add_plate(m, {-0.7f, -0.7f, 0}, 0.3f, 6);
    add_plate(m, {0.7f, 0.7f, 0}, 0.25f, 5);
    return m;
}

template <face_grouping Grouping>
billboard_cloud search_grouped(const mesh& m, double share, const Grouping& group,
                               unsigned threads = 0) {
    face_table faces = support::table_of(m);
    const double epsilon = share * faces.bounds.radius;
    billboard_cloud cloud =
        greedy_search(std::move(faces), m.face_count(), {.epsilon = epsilon},
                      pipeline{cube_map{10}, density_policies<>{}, least_squares_fit{}, group},
                      {threads})
            .cloud;
    fit_billboards(m, cloud);
    return cloud;
}

const plane ground{{0, 0, 1}, 0};

}  // namespace

TEST_SUITE("search/compact") {
    TEST_CASE("of two far-apart plates the heavier is taken") {
        const mesh m = far_plates();
        const face_table faces = support::table_of(m);
        const face_rows taken = heaviest_group<>{}(faces, ground, 0.1);
        CHECK(taken.size() == 72);
        for (const std::uint32_t row : taken) CHECK(faces.centroid(row).x < 0);
        CHECK(std::ranges::is_sorted(taken));
    }
    TEST_CASE("plates take one plane when texels cost less than it") {
        const face_table faces = support::table_of(far_plates());
        // Along the diagonal the rectangle around both is 0.6 √2 wide at the larger plate.
        CHECK(heaviest_group<>{.texel_cost = 0}(faces, ground, 0.1).size() == faces.size);
        CHECK(heaviest_group<>{.texel_cost = 0.1}(faces, ground, 0.1).size() == faces.size);
        CHECK(heaviest_group<>{.texel_cost = 100}(faces, ground, 0.1).size() == 72);
    }
    TEST_CASE("plates a cell apart are one, gaps of a few cells part them") {
        for (const float gap : {0.02f, 0.6f}) {
            mesh m;
            add_plate(m, {-0.25f - gap / 2, 0, 0}, 0.25f, 8);
            add_plate(m, {0.25f + gap / 2, 0, 0}, 0.25f, 8);
            const face_table faces = support::table_of(m);
            const face_rows taken = heaviest_group<>{.texel_cost = 1e6}(faces, ground, 0.1);
            CHECK(taken.size() == (gap < 0.1f ? faces.size : faces.size / 2));
        }
    }
    TEST_CASE("an island between two that are taken comes along: its texels are paid for") {
        mesh m;
        add_plate(m, {-0.8f, 0, 0}, 0.2f, 5);
        add_plate(m, {0, 0, 0}, 0.1f, 3);
        add_plate(m, {0.8f, 0, 0}, 0.2f, 5);
        const face_table faces = support::table_of(m);
        const double worth = 0.6 * faces.bounds.radius * faces.bounds.radius;
        CHECK(heaviest_group<>{.texel_cost = 1 / worth}(faces, ground, 0.1).size() == faces.size);
    }
    TEST_CASE("two plates on one plane become two billboards, with less empty texture") {
        const mesh m = far_plates();
        const billboard_cloud one = search_grouped(m, 0.05, whole_set{});
        const billboard_cloud two = search_grouped(m, 0.05, heaviest_group<>{});
        CHECK(one.plane_count() == 1);
        CHECK(two.plane_count() == 2);
        CHECK(measure_errors(m, one).rectangle_use < 0.45);
        CHECK(measure_errors(m, two).rectangle_use == doctest::Approx(1).epsilon(1e-4));
    }
    TEST_CASE("every face still ends on exactly one plane, within epsilon") {
        const mesh soup = leaf_soup(1200, {.edge = 0.05f});
        const mesh pot = teapot(4);
        for (const mesh* m : {&soup, &pot}) {
            for (const double cost : {4.0, 50.0}) {
                const billboard_cloud cloud = search_grouped(*m, 0.08, heaviest_group<>{cost});
                const cloud_errors e = measure_errors(*m, cloud);
                CHECK(e.mapped_faces == m->face_count());
                CHECK(e.faces_beyond_epsilon == 0);
                const faces_of_planes faces(cloud.plane_of_face, cloud.plane_count());
                for (plane_id id = 0; id < cloud.plane_count(); ++id) CHECK(!faces[id].empty());
            }
        }
    }
    TEST_CASE("costlier texels never make the rectangles of one plane larger") {
        const face_table faces = support::table_of(support::random_triangles(60, 0.03, 12));
        std::size_t last = faces.size;
        for (const double cost : {0.0, 0.5, 2.0, 8.0, 32.0, 1e6}) {
            const face_rows taken = heaviest_group<>{cost}(faces, ground, 2);
            CHECK(!taken.empty());
            CHECK(taken.size() <= last);
            last = taken.size();
        }
    }
    TEST_CASE("the result does not depend on threads; no face and one face work") {
        const mesh m = leaf_soup(2000, {.edge = 0.04f});
        const billboard_cloud one = search_grouped(m, 0.06, heaviest_group<>{20}, 1);
        const billboard_cloud three = search_grouped(m, 0.06, heaviest_group<>{20}, 3);
        CHECK(one.planes == three.planes);
        CHECK(one.plane_of_face == three.plane_of_face);
        CHECK(heaviest_group<>{}(face_table{}, ground, 0.1).empty());
        const face_table single =
            support::table_of(support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
        CHECK(heaviest_group<>{}(single, ground, 0.1) == face_rows{0});
    }
}
