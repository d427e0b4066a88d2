#include <billow/improve/exchange.hpp>

#include <doctest/doctest.h>

#include <billow/search/greedy.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/clouds.hpp"

using namespace billow;

namespace {

/// Four plates over each other, the inner two on one plane: no two of the three planes can be one.
struct stack {
    mesh m = [] {
        mesh plates;
        for (const float z : {0.0f, 0.12f, 0.24f, 0.36f}) {
            support::add_level_plate(plates, {0, 0, z}, 1);
        }
        return plates;
    }();
    face_table faces = support::table_of(m);
    plane_cover cover{faces,
                      {support::level_plane(faces, -0.05), support::level_plane(faces, 0.18),
                       support::level_plane(faces, 0.41)},
                      0.1,
                      0,
                      {}};
};

}  // namespace

TEST_SUITE("improve/exchange") {
    TEST_CASE("three planes become two where no two can be one") {
        stack plates;
        CHECK(merge_planes(plates.cover) == 0);
        const exchange_statistics told = exchange_planes(plates.cover, 20);
        CHECK(told.made == 1);
        CHECK(told.tried >= 1);
        CHECK(plates.cover.plane_count() == 2);
        for (const std::uint32_t count : plates.cover.counts()) CHECK(count == 1);
    }
    TEST_CASE("effort bounds the trials; without any nothing changes") {
        stack plates;
        CHECK(exchange_planes(plates.cover, 0).tried == 0);
        CHECK(plates.cover.plane_count() == 3);
        const mesh soup = leaf_soup(3000, {.edge = 0.05f});
        const face_table faces = support::table_of(soup);
        const billboard_cloud found =
            greedy_search(faces, faces.size, {.epsilon = 0.1 * faces.bounds.radius}).cloud;
        std::size_t fewest = found.plane_count();
        for (const std::size_t effort : {1u, 5u, 40u}) {
            plane_cover cover(faces, found.planes, found.epsilon, 0, {});
            const exchange_statistics told = exchange_planes(cover, effort);
            CHECK(told.tried <= effort);
            CHECK(cover.plane_count() + told.made <= found.plane_count());
            CHECK(std::ranges::count(cover.counts(), 0u) == 0);
            fewest = std::min(fewest, cover.plane_count());
        }
        CHECK(fewest + 2 <= found.plane_count());
    }
    TEST_CASE("planes do not depend on threads") {
        const mesh soup = leaf_soup(1500, {.edge = 0.08f});
        const face_table faces = support::table_of(soup);
        const billboard_cloud found =
            greedy_search(faces, faces.size, {.epsilon = 0.15 * faces.bounds.radius}).cloud;
        plane_cover one(faces, found.planes, found.epsilon, 0, {1});
        plane_cover three(faces, found.planes, found.epsilon, 0, {3});
        CHECK(exchange_planes(one, 30, {1}).tried == exchange_planes(three, 30, {3}).tried);
        CHECK(one.planes() == three.planes());
    }
}
