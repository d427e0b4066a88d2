// The presets: what their papers say, what they promise, and that they differ.
#include <billow/presets.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <type_traits>
#include <vector>

#include <doctest/doctest.h>

#include <billow/plants/species.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/sphere.hpp>
#include <billow/shapes/teapot.hpp>

using namespace billow;

namespace {

template <class Part, class T>
constexpr bool is_a = std::is_same_v<std::remove_cvref_t<T>, Part>;

build_options small(build_options options) {
    options.bake.texels = 64;
    options.bake.draw.supersample = 1;
    return options;
}

template <class Preset>
build_result built_with(const Preset& how, const mesh& m) {
    expected<build_result> built = build_cloud(m, small(how.options), how.method);
    REQUIRE(built);
    return *std::move(built);
}

build_result tree_built_with(const mesh& tree, const face_roles& roles, const auto& how) {
    expected<build_result> built = build_tree(tree, roles, how, small({}));
    REQUIRE(built);
    return *std::move(built);
}

const mesh& solid_model() {
    static const mesh m = teapot(4);
    return m;
}
const mesh& tree_model() {
    static const mesh m = *tree_of_about(3000, 1);
    return m;
}
const face_roles& tree_roles() {
    static const face_roles roles = find_roles(tree_model());
    return roles;
}

/// Share of the area of a part's faces whose plane is within 30° of horizontal.
double horizontal_area_share(const mesh& m, const billboard_cloud& cloud, part_id part) {
    const double least = std::cos(std::numbers::pi / 6);
    double flat = 0;
    double all = 0;
    for (face_id face = 0; face < m.face_count(); ++face) {
        const plane_id on = cloud.plane_of_face[face];
        if (on == no_id || cloud.part_of(on) != part) continue;
        const auto [a, b, c] = m.corners(face);
        const double area = glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a))) / 2;
        all += area;
        if (std::abs(cloud.planes[on].normal.y) > least) flat += area;
    }
    return flat / all;
}

double largest_distance(const mesh& m, const billboard_cloud& cloud, face_id face) {
    const plane& on = cloud.planes[cloud.plane_of_face[face]];
    double largest = 0;
    for (const vec3& corner : m.corners(face)) {
        largest =
            std::max(largest, std::abs(signed_distance(on, dvec3(corner) - cloud.bounds.centre)));
    }
    return largest;
}

}  // namespace

TEST_SUITE("presets/presets") {
    TEST_CASE("classic is the first publication: penalty 10, 216 sub-bins, nothing moved after") {
        const auto how = presets::classic();
        const auto& [options, method] = how;
        CHECK(options.search.refine == refinement::original);
        CHECK(options.search.penalty_in_refinement);
        CHECK(options.search.skip_area == 0);
        CHECK(options.weld.kind == weld_kind::none);
        CHECK(options.cardboard.min_coverage == 0);
        CHECK(method.policies.penalty.weight == 10);
        static_assert(is_a<spherical, decltype(how.method.space)>);
        static_assert(is_a<projected_area, decltype(how.method.policies.contribution)>);
        static_assert(is_a<no_falloff, decltype(how.method.policies.falloff)>);
        static_assert(is_a<no_bias, decltype(how.method.policies.bias)>);
        static_assert(is_a<no_fit, decltype(how.method.fitter)>);
        static_assert(is_a<heaviest_group<>, decltype(how.method.grouping)>);
        static_assert(is_a<fixed_vertices, decltype(how.method.motion)>);
    }
    TEST_CASE("thesis has the parameters of table 5.7") {
        const auto how = presets::thesis();
        const auto& [options, method] = how;
        CHECK(method.space.resolution() == 18);
        CHECK(options.search.rho_rate == 1.5);
        CHECK(method.policies.penalty.weight == 3);
        CHECK(method.policies.falloff.strength == 1);
        CHECK(options.search.falloff == falloff_use::everywhere);
        CHECK(options.search.skip_area == 0.02);
        CHECK(options.search.refine == refinement::fail_safe);
        CHECK(options.weld.kind == weld_kind::intersection);
        CHECK(presets::thesis(model_kind::foliage).options.weld.kind == weld_kind::none);
        CHECK(presets::thesis(model_kind::split).options.weld.kind == weld_kind::none);
        static_assert(is_a<cube_map, decltype(how.method.space)>);
        static_assert(is_a<least_squares_fit, decltype(how.method.fitter)>);
        static_assert(is_a<projected_area, decltype(how.method.policies.contribution)>);
    }
    TEST_CASE("tree has the parameters of section 3.3") {
        const auto how = presets::tree();
        CHECK(how.foliage.method.policies.bias.share == 0.60);
        CHECK(how.foliage.method.policies.bias.cutoff_deg == 50);
        CHECK(how.foliage.options.bake.alpha.thresholds.foliage == 0.3);
        CHECK(how.foliage.options.cardboard.min_coverage == 0);
        CHECK(how.trunk.options.cardboard.min_coverage == 0.8);
        static_assert(is_a<angular_area, decltype(how.foliage.method.policies.contribution)>);
        static_assert(is_a<projected_area, decltype(how.trunk.method.policies.contribution)>);
        static_assert(is_a<average_fit, decltype(how.foliage.method.fitter)>);
        static_assert(is_a<weld_online, decltype(how.trunk.method.motion)>);
        static_assert(is_a<no_bias, decltype(how.trunk.method.policies.bias)>);
    }
    TEST_CASE(
        "exact_tree is tree by another search: no more planes, which show more of the leaves") {
        const auto how = presets::exact_tree();
        static_assert(is_a<exact_method, decltype(how.foliage.method.search)>);
        static_assert(is_a<density_method, decltype(how.trunk.method.search)>);
        CHECK(how.foliage.options.refines_whole);
        const build_result grid = tree_built_with(tree_model(), tree_roles(), presets::tree());
        const build_result exact = tree_built_with(tree_model(), tree_roles(), how);
        REQUIRE(exact.parts.size() == 2);
        CHECK(exact.parts[0].plane_count <= grid.parts[0].plane_count);
        CHECK(exact.parts[1].plane_count == grid.parts[1].plane_count);
        CHECK(exact.errors.projected_area_share > grid.errors.projected_area_share);
        CHECK(exact.errors.faces_beyond_epsilon == 0);
        CHECK(exact.faces.mapped == tree_model().face_count());
        const plane_curve& curve = exact.parts[0].curve;
        REQUIRE(curve.covered_area.size() == exact.parts[0].plane_count);
        CHECK(std::is_sorted(curve.covered_area.begin(), curve.covered_area.end()));
        CHECK(curve.covered_area.back() == doctest::Approx(1));
    }
    TEST_CASE("solid is the thesis without skipped area") {
        const auto how = presets::solid();
        const auto thesis = presets::thesis();
        CHECK(how.options.search.skip_area == 0);
        CHECK(how.options.search.rho_rate == thesis.options.search.rho_rate);
        CHECK(how.options.epsilon.value == thesis.options.epsilon.value);
        CHECK(how.options.weld.kind == thesis.options.weld.kind);
        CHECK(how.method.policies.penalty.weight == thesis.method.policies.penalty.weight);
        static_assert(std::is_same_v<decltype(how.method), decltype(thesis.method)>);
    }
    TEST_CASE("classic and solid keep epsilon for every face") {
        for (const mesh& m : {solid_model(), icosphere(2), leaf_soup(400, {.edge = 0.2f})}) {
            for (const build_result& built :
                 {built_with(presets::classic(), m), built_with(presets::solid(), m)}) {
                CHECK(built.faces.mapped == m.face_count());
                CHECK(built.errors.faces_beyond_epsilon == 0);
                CHECK(built.cloud.epsilon == doctest::Approx(0.05 * built.cloud.bounds.radius));
                for (face_id face = 0; face < m.face_count(); ++face) {
                    REQUIRE(largest_distance(m, built.cloud, face) <=
                            built.cloud.epsilon * (1 + 1e-6));
                }
            }
        }
    }
    TEST_CASE("thesis skips at most 2 % of the area; the others keep epsilon") {
        for (const mesh& m : {solid_model(), leaf_soup(400, {.edge = 0.2f})}) {
            const build_result built = built_with(presets::thesis(), m);
            const greedy_statistics& search = built.statistics;
            CHECK(search.leftover_area_share > 0);
            CHECK(search.leftover_area_share <= 0.02);
            CHECK(search.dropped_area_share <= search.leftover_area_share);
            CHECK(built.faces.dropped == search.dropped_faces);
            CHECK(built.errors.faces_beyond_epsilon <= search.leftover_faces);
            CHECK(built.cloud.plane_count() < built_with(presets::solid(), m).cloud.plane_count());
        }
    }
    TEST_CASE("no two presets give the same cloud") {
        const mesh& m = solid_model();
        const std::vector<std::vector<plane>> clouds{
            built_with(presets::classic(), m).cloud.planes,
            built_with(presets::thesis(), m).cloud.planes,
            built_with(presets::solid(), m).cloud.planes,
            built_with(presets::tree().foliage, m).cloud.planes,
            built_with(presets::tree().trunk, m).cloud.planes};
        for (std::size_t a = 0; a < clouds.size(); ++a) {
            CHECK(!clouds[a].empty());
            for (std::size_t b = 0; b < a; ++b) CHECK(clouds[a] != clouds[b]);
        }
    }
    TEST_CASE("a tree is built of two parts that share no plane and count every face once") {
        const mesh& tree = tree_model();
        const auto how = presets::tree();
        const build_result built = tree_built_with(tree, tree_roles(), how);
        REQUIRE(built.parts.size() == 2);
        CHECK(built.parts[0].plane_count > 0);
        CHECK(built.parts[1].plane_count > 0);
        CHECK(built.faces.all() == tree.face_count());
        CHECK(built.faces.mapped + built.faces.degenerate == tree.face_count());
        std::size_t mapped[2] = {};
        for (face_id face = 0; face < tree.face_count(); ++face) {
            const plane_id on = built.cloud.plane_of_face[face];
            if (on == no_id) continue;
            const part_id part = tree_roles().of_face[face] == face_role::foliage ? 0 : 1;
            REQUIRE(built.cloud.part_of(on) == part);
            ++mapped[part];
            if (part == 0) {
                REQUIRE(largest_distance(tree, built.cloud, face) <=
                        built.cloud.epsilon_of(on) * (1 + 1e-6));
            }
        }
        CHECK(mapped[0] == built.parts[0].faces.mapped);
        CHECK(mapped[1] == built.parts[1].faces.mapped);
        CHECK(built.cloud.plane_count() == built.parts[0].plane_count + built.parts[1].plane_count +
                                               built.parts[0].cardboard_planes +
                                               built.parts[1].cardboard_planes);
    }
    TEST_CASE("the penalty on horizontal planes stands foliage up") {
        const auto how = presets::tree();
        auto free = how;
        free.foliage.method.policies.bias.share = 0;
        double with = 0;
        double without = 0;
        for (const std::uint64_t seed : {2u, 3u}) {
            const mesh tree = *tree_of_about(3000, seed);
            const face_roles roles = find_roles(tree);
            const auto add = [&](double& to, const auto& preset) {
                const build_result built = tree_built_with(tree, roles, preset);
                to += horizontal_area_share(tree, built.cloud, 0);
            };
            add(with, how);
            add(without, free);
        }
        CHECK(without > 0);
        CHECK(with < 0.6 * without);
    }
    TEST_CASE("describe() tells which preset a model wants") {
        CHECK(describe(solid_model()).kind == model_kind::solid);
        CHECK(describe(icosphere(2)).kind == model_kind::solid);
        CHECK(describe(leaf_soup(400, {.edge = 0.1f})).kind == model_kind::foliage);
        CHECK(describe(tree_model()).kind == model_kind::split);
        for (const species& kind : {broadleaf(), forest_paper_tree()}) {
            const auto small_one = with_face_count(kind, 2000);
            REQUIRE(small_one);
            CHECK(describe(*grow(*small_one)).kind == model_kind::split);
        }
    }
}
