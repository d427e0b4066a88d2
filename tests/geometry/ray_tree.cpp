#include <billow/geometry/ray_tree.hpp>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

namespace {

using triangle = std::array<vec3, 3>;

std::vector<triangle> triangles_of(const mesh& m) {
    std::vector<triangle> all;
    for (face_id face = 0; face < m.face_count(); ++face) all.push_back(m.corners(face));
    return all;
}
ray_tree tree_of(const std::vector<triangle>& all) {
    return ray_tree(all.size(), [&](std::uint32_t i) { return all[i]; });
}
constexpr auto always = [](std::uint32_t, float, float) { return true; };

/// How deep inside a triangle the line of a ray passes: the least barycentric weight, and where.
struct passage {
    double inside;
    double distance;
};
passage pass(const ray& r, const triangle& t) {
    const dvec3 origin(r.origin), direction(r.direction), a(t[0]), b(t[1]), c(t[2]);
    const dvec3 n = glm::cross(b - a, c - a);
    const double distance = glm::dot(n, a - origin) / glm::dot(n, direction);
    const dvec3 p = origin + direction * distance;
    const auto weight = [&](const dvec3& q, const dvec3& s) {
        return glm::dot(n, glm::cross(q - p, s - p)) / glm::dot(n, n);
    };
    return {std::min({weight(b, c), weight(c, a), weight(a, b)}), distance};
}

ray random_ray(random_stream& random) {
    const dvec3 origin = support::random_direction(random) * random.between(0, 1.5);
    return {vec3(origin), vec3(support::random_direction(random)) * 0.5f, 0.01f,
            static_cast<float>(random.between(0.1, 4))};
}

}  // namespace

TEST_SUITE("geometry/ray_tree") {
    TEST_CASE("rays meet what testing every triangle finds") {
        for (const double extent : {0.08, 0.4}) {
            const auto all = triangles_of(support::random_triangles(700, extent, 5));
            const ray_tree tree = tree_of(all);
            random_stream random(3);
            int hits = 0;
            for (int i = 0; i < 3000; ++i) {
                const ray r = random_ray(random);
                double nearest = 1e9;   // of those met for certain
                bool is_close = false;  // an edge, or an end of the ray: rounding decides
                for (const triangle& t : all) {
                    const passage p = pass(r, t);
                    if (!(std::abs(p.inside) > 1e-4) || std::abs(p.distance - r.near) < 1e-4 ||
                        std::abs(p.distance - r.far) < 1e-4) {
                        is_close |= !(p.inside < -1e-4);
                    } else if (p.inside > 0 && p.distance > r.near && p.distance < r.far) {
                        nearest = std::min(nearest, p.distance);
                    }
                }
                if (is_close) continue;
                const ray_hit hit = tree.closest(r);
                REQUIRE(bool(hit) == (nearest < 1e9));
                CHECK(tree.is_blocked(r, always) == bool(hit));
                if (!hit) continue;
                ++hits;
                REQUIRE(hit.distance == doctest::Approx(nearest).epsilon(1e-4));
                const auto& [a, b, c] = all[hit.triangle];
                const vec3 met = a * (1 - hit.b - hit.c) + b * hit.b + c * hit.c;
                CHECK(glm::distance(met, r.origin + r.direction * hit.distance) < 1e-4f);
            }
            CHECK(hits > 200);
        }
    }
    TEST_CASE("one lane finds what many find") {
        const auto all = triangles_of(support::random_triangles(500, 0.1, 7));
        const ray_tree tree = tree_of(all);
        random_stream random(8);
        for (int i = 0; i < 2000; ++i) {
            const ray r = random_ray(random);
            const ray_hit wide = tree.closest(r);
            const ray_hit one = tree.closest<float>(r, always);
            CHECK(wide.triangle == one.triangle);
            if (wide) CHECK(wide.distance == doctest::Approx(one.distance).epsilon(1e-5));
            CHECK(tree.is_blocked<float>(r, always) == bool(one));
        }
    }
    TEST_CASE("what is not there lets rays through") {
        mesh m;
        for (const float z : {0.0f, 1.0f, 2.0f}) {
            support::add_square(m, {0, 0, z}, {1, 0, 0}, {0, 1, 0});
        }
        const ray_tree tree = tree_of(triangles_of(m));
        const ray up{{0.25f, -0.5f, -1}, {0, 0, 1}};
        CHECK(tree.closest(up).distance == doctest::Approx(1));
        CHECK(tree.closest(up, [](std::uint32_t t, float, float) { return t >= 2; }).distance ==
              doctest::Approx(2));
        CHECK(tree.is_blocked(up, [](std::uint32_t t, float, float) { return t >= 4; }));
        CHECK_FALSE(tree.is_blocked(up, [](std::uint32_t, float, float) { return false; }));
    }
    TEST_CASE("of triangles at the same distance the lowest is met") {
        mesh m;
        for (int i = 0; i < 40; ++i) support::add_square(m, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
        const ray_hit hit = tree_of(triangles_of(m)).closest({{0.5f, -0.25f, -1}, {0, 0, 1}});
        CHECK(hit.triangle == 0);
    }
    TEST_CASE(
        "no ray slips through edges and corners of a grid, nor where it lies in a box's side") {
        mesh m;
        for (int x = -4; x <= 4; ++x) {
            for (int y = -4; y <= 4; ++y) {
                support::add_square(m, {2 * x, 2 * y, 0}, {1, 0, 0}, {0, 1, 0});
            }
        }
        const ray_tree tree = tree_of(triangles_of(m));
        for (int x = -8; x <= 8; ++x) {
            for (int y = -8; y <= 8; ++y) {
                CHECK(tree.is_blocked({{x, y, 1}, {0, 0, -1}}, always));
                CHECK(tree.is_blocked({{x, y, 1}, {-0.0f, 0, -1}}, always));
                CHECK_FALSE(tree.is_blocked({{x, y, 1}, {1, 0, 0}}, always));
            }
        }
    }
    TEST_CASE("rays end at near and far") {
        mesh m;
        support::add_square(m, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
        const ray_tree tree = tree_of(triangles_of(m));
        CHECK(tree.is_blocked({{0, 0, 1}, {0, 0, -1}, 0, 1}, always));
        CHECK_FALSE(tree.is_blocked({{0, 0, 1}, {0, 0, -1}, 0, 0.99f}, always));
        CHECK_FALSE(tree.is_blocked({{0, 0, 1}, {0, 0, -1}, 1.01f, 9}, always));
        CHECK_FALSE(tree.is_blocked({{0, 0, 1}, {0, 0, 1}}, always));
    }
    TEST_CASE("nothing, points, needles and a pile in one place are no trouble") {
        const ray r{{0, 0, 1}, {0, 0, -1}};
        CHECK_FALSE(ray_tree().is_blocked(r, always));
        CHECK_FALSE(bool(tree_of({}).closest(r)));
        std::vector<triangle> all(5000, triangle{vec3(0), vec3(0), vec3(0)});
        all.push_back({vec3(-1, 0, 0), vec3(0, 0, 0), vec3(1, 0, 0)});
        CHECK_FALSE(tree_of(all).is_blocked(r, always));
        // Spread over so many scales that splitting in space hardly ever halves them.
        for (int i = 0; i < 120; ++i) {
            const float x = std::exp2(static_cast<float>(i - 100));
            all.push_back({vec3(x, -1, 0), vec3(1.5f * x, -1, 0), vec3(x, 1, 0)});
        }
        const ray_tree tree = tree_of(all);
        for (int i = -10; i < 20; ++i) {
            const float x = std::exp2(static_cast<float>(i)) * 1.1f;
            CHECK(tree.is_blocked({{x, -0.5f, 1}, {0, 0, -1}}, always));
        }
    }
}
