#include <billow/plants/branch_mesh.hpp>

#include <doctest/doctest.h>

#include <billow/plants/turtle.hpp>

#include <map>
#include <tuple>
#include <utility>

using namespace billow;

namespace {

skeleton bones_of(std::string_view word, const turtle_options& options = {},
                  const radius_options& radii = {}) {
    auto bones = interpret(word, options);
    REQUIRE(bones);
    assign_radii(*bones, radii);
    return *std::move(bones);
}

skeleton paper_bones() {
    return bones_of(*expand(forest_paper_grammar(), {.generations = 3}),
                    {.angle_jitter = 0.2, .wander_deg = 8});
}

mesh bark_of(const skeleton& bones, const branch_options& options = {}) {
    mesh out;
    add_branches(out, bones, options);
    return out;
}

/// Edges without a partner that runs the other way, vertices of equal position being joined.
std::size_t open_edges(const mesh& m) {
    const auto less = [](const vec3& a, const vec3& b) {
        return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::map<vec3, std::uint32_t, decltype(less)> ids(less);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    const auto id = [&](std::uint32_t v) {
        return ids.try_emplace(m.positions[v], static_cast<std::uint32_t>(ids.size()))
            .first->second;
    };
    for (const uvec3& t : m.triangles) {
        for (int k = 0; k < 3; ++k) {
            const auto a = id(t[k]), b = id(t[(k + 1) % 3]);
            a < b ? ++edges[{a, b}] : --edges[{b, a}];
        }
    }
    std::size_t open = 0;
    for (const auto& [edge, balance] : edges) open += balance != 0;
    return open;
}

}  // namespace

TEST_SUITE("plants/branch_mesh") {
    TEST_CASE("a bent stem of changing radii is closed: rings are shared, ends are capped") {
        CHECK(open_edges(bark_of(bones_of("FF&F/&FF\"F"))) == 0);
        // Only side branches are open, at their first ring, which lies inside the bark.
        const branch_options six{.sides = 6, .min_sides = 6};
        CHECK(open_edges(bark_of(bones_of("FF[+F]&F/&FF[-F[&F]F]\"F"), six)) == 3 * 6);
    }

    TEST_CASE("side branches start inside their parent's bark") {
        const skeleton bones = paper_bones();
        for (std::size_t i = 0; i < bones.segment_count(); ++i) {
            if (bones.parents[i] == no_id) continue;
            REQUIRE(glm::distance(bones.starts[i], bones.ends[bones.parents[i]]) < 1e-6);
            REQUIRE(bones.start_radii[i] <= bones.end_radii[bones.parents[i]]);
        }
    }

    TEST_CASE("the rings have the radii of the segments") {
        const skeleton bones = bones_of("FF[+F]F", {}, {.trunk = 0.3, .flare = 2});
        const mesh stem = bark_of(bones, {.sides = 8});
        // First path: F F F along the axis, 9 vertices a ring.
        const float radii[] = {bones.start_radii[0], bones.end_radii[0], bones.end_radii[1],
                               bones.end_radii[3]};
        CHECK(bones.start_radii[0] == doctest::Approx(0.6));
        for (std::size_t v = 0; v < 36; ++v) {
            const vec3& p = stem.positions[v];
            REQUIRE(std::hypot(p.x, p.z) == doctest::Approx(radii[v / 9]).epsilon(1e-6));
            REQUIRE(p.y == doctest::Approx(double(v / 9)));
        }
    }

    TEST_CASE("u goes around in whole images and v along in their proportion") {
        const double r = 0.25, width = 0.5;  // three images around
        const mesh stem =
            bark_of(bones_of("FF", {.step = 2}, {.trunk = r, .flare = 1}), {.bark_width = width});
        const auto& uv = stem.uv_sets[0];
        CHECK(uv[0].x == 0);
        CHECK(uv[10].x == 3);
        CHECK(uv[0].y == 0);
        CHECK(uv[22].y == doctest::Approx(-4 * 3 / (2 * 3.14159265 * r)));
        for (const uvec3& t : stem.triangles) {
            REQUIRE(std::isfinite(uv[t.x].x + uv[t.x].y));
        }
    }

    TEST_CASE("the seam of every ring closes on a whole number of images") {
        const mesh tree = bark_of(paper_bones(), {.sides = 6, .min_sides = 6, .bark_width = 0.05});
        // A ring is 7 vertices whose last repeats the first one's place.
        std::size_t v = 0, rings = 0;
        while (v + 6 < tree.vertex_count()) {
            if (tree.positions[v] != tree.positions[v + 6]) {
                v += 6;  // a cap has six
                continue;
            }
            const float turns = tree.uv_sets[0][v + 6].x - tree.uv_sets[0][v].x;
            REQUIRE(turns >= 1);
            REQUIRE(turns == std::round(turns));
            v += 7;
            ++rings;
        }
        CHECK(rings >= 64);
    }

    TEST_CASE("rings do not twist around a bend") {
        // A planar bend keeps the axis across the plane where it is.
        const mesh arc = bark_of(bones_of("F&(20)F&(20)F&(20)F"), {.sides = 8});
        for (std::size_t ring = 0; ring < 5; ++ring) {
            const vec3 across = arc.positions[9 * ring] - arc.positions[9 * ring + 4];
            CHECK(std::abs(glm::normalize(across).x) == doctest::Approx(1).epsilon(1e-5));
        }
    }

    TEST_CASE("no face is degenerate, normals have unit length and look out of the winding") {
        const mesh tree = bark_of(paper_bones());
        CHECK(tree.face_materials.size() == tree.face_count());
        for (face_id f = 0; f < tree.face_count(); ++f) {
            const auto [a, b, c] = tree.corners(f);
            const vec3 n = glm::cross(b - a, c - a);
            REQUIRE(glm::length(n) > 1e-9f);
            for (int k = 0; k < 3; ++k) {
                const vec3 normal = tree.normals[tree.triangles[f][k]];
                REQUIRE(glm::length(normal) == doctest::Approx(1));
                REQUIRE(glm::dot(glm::normalize(n), normal) > 0);
            }
        }
    }

    TEST_CASE("an empty skeleton adds nothing") { CHECK(bark_of(bones_of("")).face_count() == 0); }
}
