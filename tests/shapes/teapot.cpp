#include <billow/shapes/teapot.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

using namespace billow;

namespace {

struct position_less {
    bool operator()(const vec3& a, const vec3& b) const {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    }
};

/// Edges with one face only, after vertices of equal position were joined; -1 if an edge has more
/// than two faces, or two that run along it in the same direction.
int boundary_edges(const mesh& m) {
    std::map<vec3, std::uint32_t, position_less> ids;
    const auto id = [&](std::uint32_t v) {
        return ids.try_emplace(m.positions[v], static_cast<std::uint32_t>(ids.size()))
            .first->second;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
    for (const uvec3& t : m.triangles) {
        const uvec3 w(id(t.x), id(t.y), id(t.z));
        for (const auto& edge : {std::pair{w.x, w.y}, std::pair{w.y, w.z}, std::pair{w.z, w.x}}) {
            if (++directed[edge] > 1) return -1;
        }
    }
    return static_cast<int>(std::ranges::count_if(directed, [&](const auto& entry) {
        return !directed.contains({entry.first.second, entry.first.first});
    }));
}

double volume_under(const mesh& m, double rim_height) {
    double sum = 0;
    for (face_id f = 0; f < m.face_count(); ++f) {
        const auto [a, b, c] = m.corners(f);
        const dvec3 rim(0, rim_height, 0);
        sum += glm::dot(dvec3(a) - rim, glm::cross(dvec3(b) - rim, dvec3(c) - rim)) / 6;
    }
    return sum;
}

/// The first `count` faces: rim, body and bottom come first.
mesh head(mesh m, std::size_t count) {
    m.triangles.resize(count);
    return m;
}

}  // namespace

TEST_SUITE("shapes/teapot") {
    TEST_CASE("ten segments give the classic 6,320 faces") {
        CHECK(teapot(10).face_count() == 6320);
        CHECK(teapot(1).face_count() == 56);
        CHECK(teapot(4).face_count() == 992);
    }

    TEST_CASE("the bounding box is Newell's") {
        const mesh pot = teapot(16);
        vec3 low(1e9f), high(-1e9f);
        for (const vec3& p : pot.positions) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
        CHECK(low.y == 0);
        CHECK(high.y == doctest::Approx(3.15));
        CHECK(high.z == doctest::Approx(2).epsilon(1e-3));
        CHECK(low.z == -high.z);
        CHECK(low.x == doctest::Approx(-3).epsilon(1e-3));
        CHECK(high.x == doctest::Approx(3.434).epsilon(1e-3));
    }

    TEST_CASE("normals have unit length and agree with the winding") {
        const mesh pot = teapot(12);
        for (face_id f = 0; f < pot.face_count(); ++f) {
            const auto [a, b, c] = pot.corners(f);
            const vec3 n = glm::cross(b - a, c - a);
            REQUIRE(glm::length(n) > 1e-6f);
            for (int k = 0; k < 3; ++k) {
                const vec3 normal = pot.normals[pot.triangles[f][k]];
                REQUIRE(glm::length(normal) == doctest::Approx(1));
                REQUIRE(glm::dot(glm::normalize(n), normal) > 0.5f);
            }
        }
    }

    TEST_CASE("body, knob with lid, handle and spout are open at their ends only") {
        const int n = 6;
        const mesh pot = teapot(n);
        // Rim: 4n edges. Lid: 4n. Handle and spout: two ends of 2n each.
        CHECK(boundary_edges(pot) == 4 * n + 4 * n + 8 * n);
        CHECK(boundary_edges(head(pot, std::size_t(32 * n * n - 4 * n))) == 4 * n);
    }

    TEST_CASE("the body holds the volume of its profile") {
        // The integral of c r² dh over the profile, c = 3.15584 for four arcs of handle length 0.56.
        // The error of flat faces falls with the square of their size.
        const auto volume = [](int n) {
            return volume_under(head(teapot(n), std::size_t(32 * n * n - 4 * n)), 2.4);
        };
        const double coarse = volume(8), fine = volume(16), finest = volume(32);
        CHECK(fine > coarse);
        CHECK((finest - fine) / (fine - coarse) == doctest::Approx(0.25).epsilon(0.03));
        CHECK(finest + (finest - fine) / 3 == doctest::Approx(24.401341).epsilon(1e-6));
    }

    TEST_CASE("the poles point straight up and down") {
        const mesh pot = teapot(5);
        for (std::size_t v = 0; v < pot.vertex_count(); ++v) {
            if (pot.positions[v] == vec3(0)) CHECK(pot.normals[v].y == -1);
            if (pot.positions[v] == vec3(0, 3.15f, 0)) CHECK(pot.normals[v].y == 1);
        }
    }

    TEST_CASE("texture coordinates are upright and not mirrored") {
        const mesh pot = teapot(6);
        const auto& uv = pot.uv_sets[0];
        for (const uvec3& t : pot.triangles) {
            const vec2 e = uv[t.y] - uv[t.x], f = uv[t.z] - uv[t.x];
            REQUIRE(e.x * f.y - e.y * f.x < 0);  // v runs down, so a seen face turns clockwise
        }
    }
}
