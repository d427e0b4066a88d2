#include <billow/mesh/roles.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <billow/mesh/append_mesh.hpp>
#include <billow/plants/species.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/sphere.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// A ball and a soup of leaves around it, all opaque and without materials.
mesh ball_with_leaves() {
    mesh m = icosphere(3);
    m.materials.clear();
    mesh leaves = leaf_soup(4000, {.edge = 0.1f});
    leaves.materials.clear();
    leaves.images.clear();
    append_mesh(m, leaves);
    return m;
}

}  // namespace

TEST_SUITE("mesh/roles") {
    TEST_CASE("globs match as people expect") {
        for (const char* text : {"leaf", "Leaf", "LEAVES", "leaf_01", "le"}) {
            CHECK(matches_glob(text, "le*"));
        }
        CHECK(matches_glob("oak_leaf_01", "*leaf*"));
        CHECK(matches_glob("leaf", "l??f"));
        CHECK(matches_glob("aXbXc", "a*b*c"));
        CHECK(matches_glob("abab", "*ab"));  // the first "ab" is not the last
        CHECK(matches_glob("", ""));
        CHECK(matches_glob("", "**"));
        CHECK_FALSE(matches_glob("leaf", "l?f"));
        CHECK_FALSE(matches_glob("bark", "leaf*"));
        CHECK_FALSE(matches_glob("leaf_01", "leaf"));
        CHECK_FALSE(matches_glob("", "?"));
        CHECK_FALSE(matches_glob("leaf", ""));
    }
    TEST_CASE("a tree is split by the alpha of its leaves") {
        const mesh tree = *tree_of_about(2000);
        const model_description what = describe(tree);
        CHECK(what.kind == model_kind::split);
        CHECK(what.roles.rule == role_rule::alpha);
        CHECK(what.reason.find("leaf") != std::string::npos);
        for (face_id face = 0; face < tree.face_count(); ++face) {
            const bool is_leaf = tree.material_of(face).alpha == alpha_mode::mask;
            CHECK((what.roles.of_face[face] == face_role::foliage) == is_leaf);
        }
    }
    TEST_CASE("loose opaque leaves are foliage by their size") {
        const model_description what = describe(leaf_soup(2000));
        CHECK(what.kind == model_kind::foliage);
        CHECK(what.roles.rule == role_rule::component_size);
    }
    TEST_CASE("what is built of few pieces is solid") {
        for (const mesh& m : {teapot(6), box(), textured_cube(), icosphere(3), mesh{}}) {
            const model_description what = describe(m);
            CHECK(what.kind == model_kind::solid);
            CHECK(what.roles.rule == role_rule::none);
            CHECK(what.roles.foliage_area_share == 0);
        }
    }
    TEST_CASE("without alpha small components are leaves, the large one is solid") {
        const mesh m = ball_with_leaves();
        const model_description what = describe(m);
        CHECK(what.kind == model_kind::split);
        CHECK(what.roles.rule == role_rule::component_size);
        CHECK(what.roles.faces_of(face_role::foliage).size() == 4000);
        CHECK(what.roles.faces_of(face_role::solid).size() == m.face_count() - 4000);
    }
    TEST_CASE("every threshold of a leaf's size counts") {
        const mesh m = ball_with_leaves();
        const auto leaves = [&](const leaf_size& size) {
            return find_roles(m, {.leaf = size}).faces_of(face_role::foliage).size();
        };
        CHECK(leaves({}) == 4000);
        CHECK(leaves({.triangles = 1}) == 0);
        CHECK(leaves({.triangle_share = 1e-6}) == 0);
        CHECK(leaves({.area_share = 1e-6}) == 0);
        CHECK(leaves({.diameter_share = 1e-3}) == 0);
        CHECK(
            leaves(
                {.triangles = 100000, .triangle_share = 1, .area_share = 1, .diameter_share = 1}) ==
            m.face_count());
    }
    TEST_CASE("names decide alone, where some are given") {
        const mesh tree = *tree_of_about(2000);
        const std::string wood = tree.material_of(0).name;
        const auto named = find_roles(tree, {.foliage_materials = {"nothing", wood}});
        CHECK(named.rule == role_rule::material_names);
        CHECK(named.of_face[0] == face_role::foliage);
        CHECK(named.of_face[tree.face_count() - 1] == face_role::solid);
        const auto none = find_roles(tree, {.foliage_materials = {"nothing"}});
        CHECK(none.rule == role_rule::none);
        CHECK(none.faces_of(face_role::foliage).empty());
        CHECK(describe(tree, {.foliage_materials = {"*"}}).kind == model_kind::foliage);
    }
    TEST_CASE("alpha counts only where it cuts holes") {
        mesh soup = leaf_soup(40, {.edge = 0.5f});
        const auto rule = [&] { return find_roles(soup, {.leaf = {.triangles = 0}}).rule; };
        soup.materials[0].alpha = alpha_mode::blend;
        soup.materials[0].base_color.w = 0.4f;
        CHECK(rule() == role_rule::none);  // glass

        soup.images = {image::filled(8, 8, 4, 255)};
        soup.materials[0].alpha = alpha_mode::mask;
        soup.materials[0].base_color.w = 1;
        soup.materials[0].base_color_texture.image = 0;
        CHECK(rule() == role_rule::none);  // a mask that leaves nothing out
        soup.images[0].pixel(3, 3)[3] = 0;
        CHECK(rule() == role_rule::none);  // hardly anything
        for (int x = 0; x < 8; ++x) soup.images[0].pixel(x, 0)[3] = 0;
        CHECK(rule() == role_rule::alpha);
        soup.materials[0].alpha = alpha_mode::opaque;
        CHECK(rule() == role_rule::none);  // whatever its texture holds

        soup.images.clear();
        soup.materials[0].alpha = alpha_mode::mask;
        soup.materials[0].is_double_sided = true;
        CHECK(rule() == role_rule::alpha);  // said to be a mask, of thin things
        soup.materials[0].is_double_sided = false;
        CHECK(rule() == role_rule::none);
    }
}
