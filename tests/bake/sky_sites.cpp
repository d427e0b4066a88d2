#include <billow/bake/sky_sites.hpp>

#include <algorithm>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/sphere.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// How many patches hold each row.
std::vector<int> patches_of_rows(const sky_sites& sites) {
    std::vector<int> count(sites.rows.size(), 0);
    for (const sky_patch& patch : sites.patches) {
        for (std::uint32_t i = 0; i < patch.count; ++i) ++count[sites.rows[patch.first + i]];
    }
    return count;
}

}  // namespace

TEST_SUITE("bake/sky_sites") {
    TEST_CASE("a leaf is one site, and each face in one patch") {
        const mesh soup = leaf_soup(400);
        const sky_sites sites = find_sky_sites(soup, support::table_of(soup), 0.2, 16);
        CHECK(sites.patches.size() == 200);
        CHECK(sites.count == 201);
        for (const int count : patches_of_rows(sites)) CHECK(count == 1);
        for (face_id face = 0; face < 400; face += 2) {
            CHECK(sites.of_face[face] == sites.of_face[face + 1]);
            CHECK(sites.of_face[face] == uvec3(sites.of_face[face].x));
        }
    }
    TEST_CASE("large pieces and opaque ones with one side are measured by the corner") {
        mesh soup = leaf_soup(400);
        const face_table faces = support::table_of(soup);
        CHECK(find_sky_sites(soup, faces, 0.01, 16).patches.size() == 400);
        soup.materials[0].is_double_sided = false;
        CHECK(find_sky_sites(soup, faces, 0.2, 16).patches.size() == 400);
        soup.materials[0].alpha = alpha_mode::mask;
        CHECK(find_sky_sites(soup, faces, 0.2, 16).patches.size() == 200);
    }
    TEST_CASE("corners share a site across seams, not across edges") {
        const mesh cube = box(vec3(1), 3);
        const sky_sites sites = find_sky_sites(cube, support::table_of(cube), 0, 16);
        CHECK(sites.count == 1 + 6 * 16);  // 4 × 4 vertices a side
        mesh seams = cube;
        seams.positions.clear(), seams.normals.clear(), seams.uv_sets[0].clear();
        for (face_id face = 0; face < cube.face_count(); ++face) {
            for (const vec3& corner : cube.corners(face)) seams.positions.push_back(corner);
            seams.triangles[face] = uvec3(3 * face) + uvec3(0, 1, 2);
        }
        CHECK(find_sky_sites(seams, support::table_of(seams), 0, 16).count == 1 + 6 * 16);
    }
    TEST_CASE("a vertex gets about as many rays as a leaf") {
        const mesh cube = box(vec3(1), 8);
        const sky_sites sites = find_sky_sites(cube, support::table_of(cube), 0, 60);
        std::vector<double> rays(sites.count, 0);
        for (const sky_patch& patch : sites.patches) {
            const uvec3 at = sites.of_face[sites.rows[patch.first]];
            for (int k = 0; k < 3; ++k) rays[at[k]] += patch.rays / 3.0;
        }
        double sum = 0;
        for (std::size_t site = 1; site < sites.count; ++site) {
            CHECK(rays[site] >= 20);
            sum += rays[site];
        }
        CHECK(sum / static_cast<double>(sites.count - 1) == doctest::Approx(60).epsilon(0.25));
    }
    TEST_CASE("faces without area have the site that sees all, and nothing is no trouble") {
        mesh m =
            support::triangles({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}});
        const sky_sites sites = find_sky_sites(m, support::table_of(m), 0.1, 16);
        CHECK(sites.of_face[1] == uvec3(0));
        CHECK(sites.of_face[0].x != 0);
        CHECK(find_sky_sites({}, {}, 0.1, 16).patches.empty());
    }
}
