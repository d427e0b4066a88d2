#include <billow/cloud/merge.hpp>

#include <algorithm>

#include <doctest/doctest.h>

using namespace billow;

namespace {

/// A cloud of six faces whose planes have these offsets; `faces[i]` is the plane of face i.
billboard_cloud cloud_of(double epsilon, std::initializer_list<double> offsets,
                         std::vector<plane_id> faces) {
    billboard_cloud cloud;
    cloud.bounds = {{1, 2, 3}, 4};
    cloud.epsilon = epsilon;
    for (const double rho : offsets) cloud.planes.push_back({{0, 1, 0}, rho});
    cloud.plane_of_face = std::move(faces);
    return cloud;
}

}  // namespace

TEST_SUITE("cloud/merge") {
    TEST_CASE("one cloud comes out as it went in") {
        const billboard_cloud one = cloud_of(0.1, {1, 2}, {0, 1, 0, no_id, 1, 1});
        const billboard_cloud merged = merge_clouds({one});
        CHECK(merged.planes == one.planes);
        CHECK(merged.plane_of_face == one.plane_of_face);
        CHECK(merged.parts.empty());
        CHECK(merged.part_of_plane.empty());
    }
    TEST_CASE("planes, faces and epsilons of each cloud are found again behind its offset") {
        billboard_cloud a = cloud_of(0.1, {1, 2}, {0, 1, no_id, no_id, no_id, no_id});
        billboard_cloud b = cloud_of(0.3, {3}, {no_id, no_id, 0, 0, no_id, no_id});
        billboard_cloud c = cloud_of(0.2, {4, 5}, {no_id, no_id, no_id, no_id, 1, no_id});
        a.also_drawn = {{1, 0}};
        b.also_drawn = {{0, 4}};
        c.also_drawn = {{0, 4}, {1, 5}};
        const billboard_cloud merged = merge_clouds({a, b, c});
        CHECK(merged.plane_of_face == std::vector<plane_id>{0, 1, 2, 2, 4, no_id});
        CHECK(merged.part_of_plane == std::vector<part_id>{0, 0, 1, 2, 2});
        CHECK(merged.epsilon == 0.3);
        CHECK(merged.bounds.radius == 4);
        REQUIRE(merged.parts.size() == 3);
        for (plane_id id = 0; id < 5; ++id) {
            CHECK(merged.planes[id].rho == id + 1);
            CHECK(merged.epsilon_of(id) == std::vector{0.1, 0.1, 0.3, 0.2, 0.2}[id]);
        }
        CHECK(merged.also_drawn == std::vector<drawn_too>{{1, 0}, {2, 4}, {3, 4}, {4, 5}});
        CHECK(std::ranges::is_sorted(merged.also_drawn));
    }
    TEST_CASE("a cloud of several parts keeps them, a cloud of none leaves no trace but its part") {
        const billboard_cloud a = cloud_of(0.1, {1}, {0, no_id, no_id, no_id, no_id, no_id});
        const billboard_cloud empty = cloud_of(0.5, {}, std::vector<plane_id>(6, no_id));
        const billboard_cloud b = cloud_of(0.2, {2}, {no_id, 0, no_id, no_id, no_id, no_id});
        const billboard_cloud merged = merge_clouds({merge_clouds({a, empty}), b});
        CHECK(merged.part_of_plane == std::vector<part_id>{0, 2});
        REQUIRE(merged.parts.size() == 3);
        CHECK(merged.parts[1].epsilon == 0.5);
        const billboard_cloud turned = merge_clouds({b, merge_clouds({empty, a})});
        CHECK(turned.part_of_plane == std::vector<part_id>{0, 2});
        CHECK(turned.plane_of_face[0] == 1);
    }
}
