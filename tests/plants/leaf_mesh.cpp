#include <billow/plants/leaf_mesh.hpp>

#include <doctest/doctest.h>

#include <billow/plants/turtle.hpp>

using namespace billow;

namespace {

skeleton bare_bones() {
    auto bones = interpret(*expand(forest_paper_grammar(), {.generations = 3}),
                           {.angle_jitter = 0.2, .wander_deg = 8});
    REQUIRE(bones);
    return *std::move(bones);
}

double distance_to_segment(const dvec3& p, const dvec3& a, const dvec3& b) {
    const double t = glm::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
    return glm::distance(p, glm::mix(a, b, t));
}

}  // namespace

TEST_SUITE("plants/leaf_mesh") {
    TEST_CASE("every leaf touches its twig") {
        const skeleton bones = bare_bones();
        mesh leaves;
        add_leaves(leaves, bones, {.per_site = 3});
        REQUIRE(leaves.face_count() == 2 * 3 * bones.leaf_count());
        for (std::size_t leaf = 0; leaf < 3 * bones.leaf_count(); ++leaf) {
            const std::uint32_t segment = bones.leaf_segments[leaf / 3];
            const dvec3 foot =
                dvec3(leaves.positions[4 * leaf] + leaves.positions[4 * leaf + 1]) * 0.5;
            REQUIRE(distance_to_segment(foot, bones.starts[segment], bones.ends[segment]) < 1e-5);
        }
    }

    TEST_CASE("any mean number of leaves comes out to the leaf") {
        for (const double per_site : {0.0, 0.3, 1.0, 2.7, 9.99}) {
            std::size_t sum = 0;
            for (std::size_t k = 0; k < 1000; ++k) sum += leaves_at_site(k, per_site);
            CHECK(sum == static_cast<std::size_t>(std::floor(1000 * per_site)));
        }
    }

    TEST_CASE("leaves are rectangles of the size asked for, their normals exact") {
        mesh leaves;
        add_leaves(leaves, bare_bones(),
                   {.per_site = 2, .length = 0.4, .aspect = 0.5, .size_jitter = 0});
        for (face_id f = 0; f < leaves.face_count(); ++f) {
            const auto [a, b, c] = leaves.corners(f);
            const vec3 n = glm::cross(b - a, c - a);
            REQUIRE(glm::length(n) == doctest::Approx(0.08).epsilon(1e-3));
            REQUIRE(glm::dot(glm::normalize(n), leaves.normals[leaves.triangles[f].x]) ==
                    doctest::Approx(1));
        }
    }

    TEST_CASE("every leaf shows one upright picture of the image") {
        mesh leaves;
        add_leaves(leaves, bare_bones(), {.variants = 3});
        std::vector<int> seen(9, 0);
        for (std::size_t v = 0; v < leaves.vertex_count(); v += 4) {
            const auto& uv = leaves.uv_sets[0];
            const vec2 corner = uv[v + 3] * 3.0f;
            CHECK(glm::distance(corner, glm::round(corner)) < 1e-5f);
            CHECK(glm::distance(uv[v + 1] - uv[v + 3], vec2(1 / 3.0f)) < 1e-5f);
            ++seen[static_cast<std::size_t>(std::lround(corner.x + 3 * corner.y))];
        }
        for (const int count : seen) CHECK(count > 0);
    }

    TEST_CASE("the seed alone decides") {
        const skeleton bones = bare_bones();
        mesh few, again;
        add_leaves(few, bones, {.per_site = 2}, 0, 7);
        add_leaves(again, bones, {.per_site = 2}, 0, 7);
        CHECK(few.positions == again.positions);
        mesh other;
        add_leaves(other, bones, {.per_site = 2}, 0, 8);
        CHECK(few.positions != other.positions);
    }
}
