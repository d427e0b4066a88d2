#include <billow/mesh/select_faces.hpp>

#include <algorithm>
#include <numeric>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include <billow/mesh/validate.hpp>
#include <billow/plants/species.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("mesh/select_faces") {
    TEST_CASE("selected faces have the corners, attributes and looks that they had, bit by bit") {
        const mesh tree = *tree_of_about(2000);
        std::vector<face_id> faces;
        for (face_id face = 5; face < tree.face_count(); face += 7) faces.push_back(face);
        std::reverse(faces.begin(), faces.end());
        const mesh some = select_faces(tree, faces);
        REQUIRE(validate(some));
        REQUIRE(some.face_count() == faces.size());
        for (face_id i = 0; i < faces.size(); ++i) {
            CHECK(some.corners(i) == tree.corners(faces[i]));
            const material& was = tree.material_of(faces[i]);
            const material& is = some.material_of(i);
            CHECK(is.name == was.name);
            CHECK(some.images[is.base_color_texture.image] ==
                  tree.images[was.base_color_texture.image]);
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t from = tree.triangles[faces[i]][k];
                const std::uint32_t to = some.triangles[i][k];
                CHECK(some.normals[to] == tree.normals[from]);
                CHECK(some.uv_sets[0][to] == tree.uv_sets[0][from]);
            }
        }
    }
    TEST_CASE("nothing comes along that the faces do not use") {
        const mesh tree = *tree_of_about(2000);
        const material_id leaf = tree.face_materials.back();
        std::vector<face_id> faces;
        for (face_id face = 0; face < tree.face_count(); ++face) {
            if (tree.face_materials[face] == leaf) faces.push_back(face);
        }
        const mesh leaves = select_faces(tree, faces);
        CHECK(leaves.materials.size() == 1);
        CHECK(leaves.images.size() == 1);
        std::set<std::uint32_t> used;
        for (const uvec3& t : leaves.triangles) used.insert({t.x, t.y, t.z});
        CHECK(used.size() == leaves.vertex_count());
        CHECK(leaves.vertex_count() < tree.vertex_count());
    }
    TEST_CASE("a mesh without attributes and materials stays without") {
        const mesh m = support::random_triangles(5, 0.2, 1);
        const std::vector<face_id> faces{3, 1};
        const mesh some = select_faces(m, faces);
        CHECK(some.vertex_count() == 6);
        CHECK(some.normals.empty());
        CHECK(some.materials.empty());
        CHECK(some.material_of(0).roughness == m.material_of(3).roughness);
        CHECK(select_faces(m, {}).vertex_count() == 0);
    }
}
