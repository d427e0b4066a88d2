#include <billow/metrics/nearest_planes.hpp>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

#include "support/meshes.hpp"

namespace {

using namespace billow;

/// Adds a level square of feature `id` at height z.
void add_level(mesh& cloud, std::uint32_t id, float z, float half) {
    support::add_square(cloud, {0, 0, z}, {half, 0, 0}, {0, half, 0});
    cloud.feature_ids.insert(cloud.feature_ids.end(), 4, id);
}

/// All of it by the definition: a face counts for a plane when points spread over it fall into a
/// triangle of the plane.
plane_id nearest_by_points(const nearest_planes& found, const mesh& cloud, const mesh& original,
                           face_id face) {
    const auto corners = original.corners(face);
    plane_id best = no_id;
    double least = 1e30;
    for (plane_id id = 0; id < found.planes.plane_count(); ++id) {
        const plane& p = found.planes.planes[id];
        const dvec3 centre = found.planes.bounds.centre;
        double distance = 0;
        for (const vec3& c : corners) {
            distance = std::max(distance, std::abs(signed_distance(p, dvec3(c) - centre)));
        }
        bool is_over = false;
        for (int i = 0; i <= 40 && !is_over; ++i) {
            for (int j = 0; i + j <= 40 && !is_over; ++j) {
                const double b = i / 40.0;
                const double c = j / 40.0;
                const dvec3 at =
                    dvec3(corners[0]) * (1 - b - c) + dvec3(corners[1]) * b + dvec3(corners[2]) * c;
                for (face_id t = 0; t < cloud.face_count(); ++t) {
                    if (cloud.feature_ids[cloud.triangles[t].x] != found.feature_of_plane[id]) {
                        continue;
                    }
                    const auto q = cloud.corners(t);
                    bool is_left = true;
                    bool is_right = true;
                    for (std::size_t k = 0; k < 3; ++k) {
                        const dvec3 edge = dvec3(q[(k + 1) % 3]) - dvec3(q[k]);
                        const double side = glm::dot(p.normal, glm::cross(edge, at - dvec3(q[k])));
                        is_left &= side >= 0;
                        is_right &= side <= 0;
                    }
                    is_over |= is_left || is_right;
                }
            }
        }
        if (is_over && distance < least) {
            least = distance;
            best = id;
        }
    }
    return best;
}

}  // namespace

TEST_SUITE("metrics/nearest_planes") {
    TEST_CASE("a face is on the nearest plane that has a polygon over or under it") {
        mesh cloud;
        add_level(cloud, 7, 0, 1);
        add_level(cloud, 3, 0.4f, 1);
        add_level(cloud, 5, 0.1f, 0.2f);
        const mesh original = support::triangles({{0.5f, 0.5f, 0.1f},
                                                  {0.6f, 0.5f, 0.1f},
                                                  {0.5f, 0.6f, 0.1f},
                                                  {0.5f, 0.5f, 0.3f},
                                                  {0.6f, 0.5f, 0.3f},
                                                  {0.5f, 0.6f, 0.4f},
                                                  {0, 0, 0.1f},
                                                  {0.1f, 0, 0.1f},
                                                  {0, 0.1f, 0.1f},
                                                  {2, 2, 0},
                                                  {3, 2, 0},
                                                  {2, 3, 0}});
        const nearest_planes found = find_nearest_planes(original, cloud);
        REQUIRE(found.feature_of_plane == std::vector<std::uint32_t>{3, 5, 7});
        CHECK(found.planes.plane_of_face == std::vector<plane_id>{2, 0, 1, no_id});
        CHECK(found.kept == 0);
        // Squares that only just reach over a corner count, those that end before it do not.
        const mesh at_edge = support::triangles({{0.9f, 0, 0},
                                                 {1.5f, 0, 0},
                                                 {1.5f, 0.3f, 0},
                                                 {1.1f, 0, 0},
                                                 {1.5f, 0, 0},
                                                 {1.5f, 0.3f, 0}});
        CHECK(find_nearest_planes(at_edge, cloud).planes.plane_of_face ==
              std::vector<plane_id>{2, no_id});
    }

    TEST_CASE("the planes are those that points spread over each face tell") {
        random_stream random(3);
        mesh cloud;
        for (std::uint32_t id = 0; id < 6; ++id) {
            const frame axes = frame_around(support::random_direction(random));
            const dvec3 centre(random.between(-0.3, 0.3), random.between(-0.3, 0.3),
                               random.between(-0.3, 0.3));
            support::add_square(cloud, vec3(centre), vec3(axes.u * 0.5), vec3(axes.v * 0.3));
            cloud.feature_ids.insert(cloud.feature_ids.end(), 4, id);
        }
        const mesh original = support::random_triangles(150, 0.2, 11);
        const nearest_planes found = find_nearest_planes(original, cloud, {1});
        std::size_t undrawn = 0;
        std::size_t different = 0;
        for (face_id face = 0; face < original.face_count(); ++face) {
            const plane_id expected = nearest_by_points(found, cloud, original, face);
            undrawn += expected == no_id ? 1u : 0u;
            different += found.planes.plane_of_face[face] == expected ? 0u : 1u;
        }
        CHECK(different <= 3);  // points miss the smallest overlaps
        CHECK(undrawn > 5);
        for (const unsigned threads : {2u, 3u, 8u}) {
            CHECK(find_nearest_planes(original, cloud, {threads}).planes.plane_of_face ==
                  found.planes.plane_of_face);
        }
    }

    TEST_CASE("a part that is not flat holds the faces whose corners it has") {
        const mesh trunk = support::random_triangles(20, 0.3, 5);
        mesh cloud = trunk;
        cloud.feature_ids.assign(cloud.vertex_count(), 1);
        add_level(cloud, 0, 0, 1);
        mesh original = trunk;
        support::add_square(original, {0, 0, 0.1f}, {0.3f, 0, 0}, {0, 0.3f, 0});
        const nearest_planes found = find_nearest_planes(original, cloud);
        CHECK(found.kept == 20);
        CHECK(found.feature_of_plane == std::vector<std::uint32_t>{0});
        for (face_id face = 0; face < 20; ++face) {
            CHECK(found.planes.plane_of_face[face] == no_id);
        }
        CHECK(found.planes.plane_of_face[20] == 0);
    }

    TEST_CASE("far from the origin, where floats are coarse, polygons still are flat") {
        mesh cloud;
        const frame axes = frame_around(glm::normalize(dvec3(1, 2, 3)));
        support::add_square(cloud, {5000, -3000, 800}, vec3(axes.u), vec3(axes.v));
        cloud.feature_ids.assign(4, 0);
        mesh original = cloud;
        original.feature_ids.clear();
        const nearest_planes found = find_nearest_planes(original, cloud);
        CHECK(found.planes.plane_of_face == std::vector<plane_id>{0, 0});
    }

    TEST_CASE("nothing has no plane, and on nothing is no face") {
        const mesh nothing;
        const mesh faces = support::random_triangles(3, 0.2, 1);
        CHECK(find_nearest_planes(nothing, nothing).planes.plane_of_face.empty());
        CHECK(find_nearest_planes(faces, nothing).planes.plane_of_face ==
              std::vector<plane_id>(3, no_id));
    }
}
