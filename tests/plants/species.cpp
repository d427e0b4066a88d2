#include <billow/plants/species.hpp>

#include <doctest/doctest.h>

using namespace billow;

namespace {

/// The species with small images, so that trials are quick.
species quick(species kind) {
    kind.bark.size = 16;
    kind.foliage.size = 32;
    return kind;
}

std::size_t bark_faces(const mesh& plant) {
    return static_cast<std::size_t>(std::ranges::count(plant.face_materials, 0u));
}

}  // namespace

TEST_SUITE("plants/species") {
    TEST_CASE("the broadleaf tree has about 20,000 faces, stands on the ground and is 8 m high") {
        for (std::uint64_t seed = 1; seed <= 8; ++seed) {
            CAPTURE(seed);
            const auto tree = grow(quick(broadleaf()), seed);
            REQUIRE(tree);
            CHECK(tree->face_count() > 14000);
            CHECK(tree->face_count() < 24000);
            vec3 low(1e9f), high(-1e9f);
            for (const vec3& p : tree->positions) {
                low = glm::min(low, p);
                high = glm::max(high, p);
            }
            CHECK(low.y == doctest::Approx(0).epsilon(1e-6));
            CHECK(high.y > 7.99f);
            CHECK(high.y < 8.6f);          // leaves reach over the highest twig
            CHECK(high.x - low.x > 3.5f);  // a crown, not a pole
            CHECK(high.z - low.z > 3.5f);
        }
    }

    TEST_CASE("columns are complete, no face is degenerate, every number is finite") {
        for (const species& kind : {quick(broadleaf()), quick(forest_paper_tree()),
                                    quick(forest_paper_tree(third_branch::as_printed))}) {
            const auto tree = grow(kind);
            REQUIRE(tree);
            CHECK(tree->normals.size() == tree->vertex_count());
            CHECK(tree->uv_sets[0].size() == tree->vertex_count());
            CHECK(tree->face_materials.size() == tree->face_count());
            for (face_id f = 0; f < tree->face_count(); ++f) {
                for (int k = 0; k < 3; ++k) REQUIRE(tree->triangles[f][k] < tree->vertex_count());
                const auto [a, b, c] = tree->corners(f);
                REQUIRE(glm::length(glm::cross(b - a, c - a)) > 1e-9f);
            }
            for (const vec3& n : tree->normals) REQUIRE(glm::length(n) == doctest::Approx(1));
        }
    }

    TEST_CASE("bark is opaque, leaves are masked and seen from both sides") {
        const auto tree = grow(quick(broadleaf()));
        REQUIRE(tree->materials.size() == 2);
        const material &bark = tree->materials[0], &leaf = tree->materials[1];
        CHECK(bark.name == "bark");
        CHECK(bark.alpha == alpha_mode::opaque);
        CHECK(leaf.name == "leaf");
        CHECK(leaf.alpha == alpha_mode::mask);
        CHECK(leaf.is_double_sided);
        CHECK(tree->images[leaf.base_color_texture.image].channels == 4);
        CHECK(bark_faces(*tree) > 5000);
    }

    TEST_CASE("the same seed gives the same tree, another seed another one") {
        const auto a = grow(quick(broadleaf()), 3), b = grow(quick(broadleaf()), 3),
                   c = grow(quick(broadleaf()), 4);
        CHECK(a->positions == b->positions);
        CHECK(a->triangles == b->triangles);
        CHECK(a->uv_sets == b->uv_sets);
        CHECK(a->images == b->images);
        CHECK(a->positions != c->positions);
    }

    TEST_CASE("a tree of any number of faces") {
        for (const std::size_t faces : {500u, 1000u, 4999u, 20000u, 100000u}) {
            CAPTURE(faces);
            const auto kind = with_face_count(quick(broadleaf()), faces, 2);
            REQUIRE(kind);
            const auto tree = grow(*kind, 2);
            REQUIRE(tree);
            CHECK(tree->face_count() <= faces);
            CHECK(tree->face_count() + 1 >= faces);
            CHECK(bark_faces(*tree) <= faces * 3 / 5);
        }
        const auto paper = with_face_count(quick(forest_paper_tree()), 3000);
        REQUIRE(paper);
        CHECK(grow(*paper)->face_count() + 1 >= 3000);
        CHECK(2000 - tree_of_about(2000)->face_count() <= 1);
    }

    TEST_CASE("impossible wishes are refused") {
        CHECK(tree_of_about(10).error().code == error_code::invalid_options);
        species kind = quick(broadleaf());
        kind.height = 0;
        CHECK(grow(kind).error().code == error_code::invalid_options);
        kind = quick(broadleaf());
        kind.rules.axiom = "F[A";
        CHECK(grow(kind).error().code == error_code::malformed);
        CHECK(with_face_count(kind, 1000).error().code == error_code::malformed);
        kind.rules = {.axiom = "A"};
        CHECK(grow(kind).error().code == error_code::malformed);
        kind = quick(broadleaf());
        kind.generations = 10000;
        CHECK(grow(kind).error().code == error_code::too_large);
    }
}
