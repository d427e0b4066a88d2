#include <billow/improve/weld.hpp>

#include <algorithm>
#include <array>

#include <doctest/doctest.h>

#include <billow/bake/bake_cloud.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/search/greedy.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

const weld_options to_first{.kind = weld_kind::first};
const weld_options to_intersection{.kind = weld_kind::intersection};

billboard_cloud cloud_of(const mesh& m, double share) {
    face_table faces = support::table_of(m);
    const double epsilon = share * faces.bounds.radius;
    return greedy_search(std::move(faces), m.face_count(), {.epsilon = epsilon}).cloud;
}

/// The farthest that a face is drawn on its plane from where its corners were drawn before.
double farthest_drawn(const mesh& source, const mesh& drawn, const billboard_cloud& cloud) {
    double farthest = 0;
    for (face_id face = 0; face < source.face_count(); ++face) {
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec3 moved = dvec3(drawn.corners(face)[k]) - dvec3(source.corners(face)[k]);
            farthest = std::max(farthest, glm::length(moved));
            if (cloud.plane_of_face[face] == no_id) {
                CHECK(moved == dvec3(0));
            } else {  // the distance to the plane is kept
                const dvec3 normal = cloud.planes[cloud.plane_of_face[face]].normal;
                CHECK(std::abs(glm::dot(normal, moved)) < 1e-6 * cloud.bounds.radius);
            }
        }
    }
    return farthest;
}

/// A box around the origin and its six planes, each moved by up to 0.04.
billboard_cloud planes_of_box(const mesh& m) {
    billboard_cloud cloud;
    cloud.bounds = support::table_of(m).bounds;
    cloud.epsilon = 0.1;
    for (int side = 0; side < 6; ++side) {
        dvec3 normal{0};
        normal[side / 2] = side % 2 == 0 ? 1 : -1;
        cloud.planes.push_back({normal, 0.5 + 0.01 * (side - 2)});
    }
    for (face_id face = 0; face < m.face_count(); ++face) {
        cloud.plane_of_face.push_back(face / (static_cast<face_id>(m.face_count()) / 6));
    }
    return cloud;
}

}  // namespace

TEST_SUITE("improve/weld") {
    TEST_CASE("three planes of a box meet in each of its corners, across seams") {
        const mesh m = box(vec3(1), 2);
        const billboard_cloud cloud = planes_of_box(m);
        const welded_mesh welded = weld_vertices(m, cloud, to_intersection);
        CHECK(welded.before.edges == 24);
        CHECK(welded.before.torn_edges == 24);
        CHECK(welded.before.edge_length == doctest::Approx(12));
        CHECK(welded.before.torn_length == doctest::Approx(12));
        CHECK(welded.after.edges == 24);
        CHECK(welded.after.torn_length == 0);
        CHECK(welded.after.width < 1e-6);
        CHECK(welded.statistics.torn_vertices == 8 + 12);
        CHECK(welded.statistics.welded_vertices == 8 + 12);
        CHECK(welded.statistics.largest_displacement ==
              doctest::Approx(std::sqrt(0.03 * 0.03 + 0.01 * 0.01 + 0.02 * 0.02)).epsilon(0.2));
        CHECK(farthest_drawn(m, welded.drawn, cloud) < cloud.epsilon);
    }
    TEST_CASE("welded points lie on all of their planes, within epsilon of the vertex") {
        const mesh m = teapot(6);
        const billboard_cloud cloud = cloud_of(m, 0.06);
        const welded_faces welded = weld_faces(m, cloud, std::span(&to_intersection, 1));
        REQUIRE(welded.statistics.welded_vertices > 20);
        const vertex_identity vertices = position_ids(m);
        std::vector<dvec3> place(vertices.count, dvec3(0));
        std::vector<char> has_moved(vertices.count, 0);
        for (const moved_face& moved : welded.moved) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t vertex = m.triangles[moved.face][static_cast<int>(k)];
                const dvec3 was = dvec3(m.positions[vertex]) - cloud.bounds.centre;
                CHECK(glm::distance(was, moved.corners[k]) <= cloud.epsilon);
                if (was == moved.corners[k]) continue;
                // Vertices that are one stay one.
                const std::uint32_t id = vertices.id[vertex];
                if (has_moved[id] != 0) CHECK(place[id] == moved.corners[k]);
                place[id] = moved.corners[k];
                has_moved[id] = 1;
            }
        }
    }
    TEST_CASE("the cracks of a teapot close") {
        const mesh m = teapot(6);
        const billboard_cloud cloud = cloud_of(m, 0.06);
        const welded_mesh first = weld_vertices(m, cloud, to_first);
        const welded_mesh meeting = weld_vertices(m, cloud, to_intersection);
        CHECK(first.after.area < 0.85 * first.before.area);
        CHECK(meeting.after.area < 0.55 * meeting.before.area);
        CHECK(meeting.after.torn_length < 0.7 * meeting.before.torn_length);
        for (const welded_mesh* w : {&first, &meeting}) {
            CHECK(w->statistics.largest_displacement <= cloud.epsilon);
            CHECK(farthest_drawn(m, w->drawn, cloud) <= cloud.epsilon * (1 + 1e-6));
            CHECK(w->after.edge_length == w->before.edge_length);
            // The planes still hold what is drawn.
            CHECK(measure_errors(w->drawn, cloud).max_error <= cloud.epsilon * (1 + 1e-5));
        }
    }
    TEST_CASE("attributes stay those of the source") {
        const mesh m = teapot(4);
        const mesh drawn = weld_vertices(m, cloud_of(m, 0.06), to_intersection).drawn;
        REQUIRE(drawn.face_count() == m.face_count());
        CHECK(drawn.materials.size() == m.materials.size());
        CHECK(drawn.face_materials == m.face_materials);
        CHECK(drawn.positions != m.positions);
        REQUIRE(validate(drawn));
        for (face_id face = 0; face < m.face_count(); ++face) {
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t was = m.triangles[face][k];
                const std::uint32_t is = drawn.triangles[face][k];
                CHECK(drawn.normals[is] == m.normals[was]);
                CHECK(drawn.uv_sets[0][is] == m.uv_sets[0][was]);
            }
        }
    }
    TEST_CASE("flat faces keep the normals that they had") {
        mesh m = teapot(4);
        m.normals.clear();
        const mesh drawn = weld_vertices(m, cloud_of(m, 0.06), to_intersection).drawn;
        REQUIRE(drawn.normals.size() == 3 * m.face_count());
        for (face_id face = 0; face < m.face_count(); ++face) {
            const auto [a, b, c] = m.corners(face);
            const vec3 normal = glm::normalize(glm::cross(b - a, c - a));
            CHECK(glm::distance(drawn.normals[drawn.triangles[face].y], normal) < 1e-3f);
        }
    }
    TEST_CASE("nothing moves without a kind, nor where nothing is torn") {
        const mesh m = teapot(3);
        const billboard_cloud cloud = cloud_of(m, 0.06);
        const welded_mesh none = weld_vertices(m, cloud, {});
        CHECK(none.drawn.positions == m.positions);
        CHECK(none.drawn.triangles == m.triangles);
        CHECK(none.statistics.torn_vertices == 0);
        CHECK(none.after.area == none.before.area);
        const mesh loose = support::random_triangles(50, 0.2, 3);
        const welded_mesh still = weld_vertices(loose, cloud_of(loose, 0.1), to_intersection);
        CHECK(still.drawn.positions == loose.positions);
        CHECK(still.before.edges == 0);
        CHECK(weld_vertices({}, {}, to_intersection).drawn.face_count() == 0);
    }
    TEST_CASE("corners of faces without a plane stay") {
        const mesh m = box(vec3(1), 2);
        billboard_cloud cloud = planes_of_box(m);
        for (face_id face = 0; face < 8; ++face) cloud.plane_of_face[face] = no_id;
        const mesh drawn = weld_vertices(m, cloud, to_intersection).drawn;
        for (face_id face = 0; face < 8; ++face) CHECK(drawn.corners(face) == m.corners(face));
        CHECK(farthest_drawn(m, drawn, cloud) > 0.01);
    }
    TEST_CASE("parts are welded apart, each in its own way") {
        const mesh m = box(vec3(1), 1);
        billboard_cloud cloud = planes_of_box(m);
        cloud.parts = {{0.1}, {0.05}};
        cloud.part_of_plane = {0, 0, 0, 0, 1, 1};
        const std::array options{to_intersection, weld_options{}};
        const welded_faces welded = weld_faces(m, cloud, options);
        CHECK(welded.moved.size() == 8);
        for (const moved_face& moved : welded.moved) {
            CHECK(cloud.plane_of_face[moved.face] < 4);
            // The planes of the first part leave z alone.
            for (const dvec3& corner : moved.corners) CHECK(std::abs(corner.z) == 0.5);
        }
    }
    TEST_CASE("a tolerance welds what exporters left apart") {
        mesh m = box(vec3(1), 1);
        random_stream random(4);
        for (vec3& p : m.positions) p += vec3(support::random_direction(random)) * 1e-4f;
        const billboard_cloud cloud = planes_of_box(m);
        CHECK(weld_vertices(m, cloud, to_intersection).before.edges == 0);
        weld_options options = to_intersection;
        options.tolerance = 1e-3;
        const welded_mesh welded = weld_vertices(m, cloud, options);
        CHECK(welded.before.torn_edges == 12);
        CHECK(welded.after.torn_edges == 0);
        CHECK(farthest_drawn(m, welded.drawn, cloud) <= cloud.epsilon);
    }
    TEST_CASE("faces that lose their area do no harm") {
        // One triangle on a plane of its own among faces of another: its corners meet on a line.
        mesh m = support::triangles({{0, 0, 0}, {1, 0, 0.02f}, {0, 1, 0.02f}});
        m.positions.insert(m.positions.end(), {{-3, -3, 0}, {4, 0, 0}, {0, 4, 0}});
        m.triangles.insert(m.triangles.end(), {{0, 3, 1}, {1, 4, 5}, {1, 5, 2}, {2, 3, 0}});
        billboard_cloud cloud;
        cloud.bounds = support::table_of(m).bounds;
        cloud.epsilon = 3;
        const dvec3 shift = cloud.bounds.centre;
        cloud.planes = {{{0, 0, 1}, -shift.z}, {{1, 0, 0}, -shift.x}};
        cloud.plane_of_face = {1, 0, 0, 0, 0};
        const welded_mesh welded = weld_vertices(m, cloud, to_intersection);
        CHECK(welded.after.torn_length == 0);
        const expected<face_table> faces = make_face_table(welded.drawn);
        REQUIRE(faces);
        fit_billboards(welded.drawn, cloud);
        const baked_cloud baked = bake_cloud(welded.drawn, *faces, cloud, {.texels = 32});
        CHECK(baked.tiles.size() == 2);
    }
}
