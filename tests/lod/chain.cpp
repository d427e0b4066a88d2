#include <billow/lod/chain.hpp>

#include <numbers>
#include <set>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <billow/plants/species.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

lod_options small(std::vector<std::size_t> levels, lod_source made_of = lod_source::level_above) {
    lod_options options{.levels = std::move(levels), .made_of = made_of};
    options.build.bake.texels = 64;
    options.build.bake.draw.supersample = 2;
    return options;
}

const pipeline coarse{cube_map(10)};

}  // namespace

TEST_SUITE("lod/chain") {
    TEST_CASE("levels have no more planes than asked for, and about as many") {
        for (const mesh& m : {leaf_soup(400, {.edge = 0.15f}), teapot(3)}) {
            for (const lod_source made_of : {lod_source::level_above, lod_source::mesh}) {
                const auto chain = build_lod_chain(m, small({20, 11, 4}, made_of), coarse);
                REQUIRE(chain);
                REQUIRE(chain->levels.size() == 3);
                for (const lod_level& level : chain->levels) {
                    CHECK(level.built.cloud.plane_count() <= level.most_planes);
                    CHECK(level.built.cloud.plane_count() * 10 >= level.most_planes * 7);
                    CHECK(level.built.baked.tiles.size() == level.built.cloud.plane_count());
                }
            }
        }
    }
    TEST_CASE("no corner is drawn farther away than the bound says") {
        for (const mesh& m : {leaf_soup(400, {.edge = 0.15f}), teapot(3)}) {
            for (const lod_source made_of : {lod_source::level_above, lod_source::mesh}) {
                const auto chain = build_lod_chain(m, small({20, 14, 4}, made_of), coarse);
                REQUIRE(chain);
                for (const lod_level& level : chain->levels) {
                    CHECK(level.error.faces == m.face_count());
                    CHECK(level.error.max > 0);
                    CHECK(level.error.max <= level.error_bound + 1e-6 * chain->bounds.radius);
                    CHECK(level.error.mean <= level.error.max);
                }
            }
        }
    }
    TEST_CASE("errors add along levels that are made of each other") {
        const auto chain =
            build_lod_chain(leaf_soup(400, {.edge = 0.15f}), small({20, 14, 11}), coarse);
        REQUIRE(chain);
        double sum = 0;
        for (const lod_level& level : chain->levels) {
            sum += level.built.cloud.epsilon;
            CHECK(level.error_bound == doctest::Approx(sum));
            CHECK(level.jump.max <= level.built.cloud.epsilon + 1e-6 * chain->bounds.radius);
        }
    }
    TEST_CASE("corners that welding moves stay within the bound") {
        lod_options options = small({20, 12});
        options.build.weld.kind = weld_kind::intersection;
        const auto chain = build_lod_chain(teapot(3), options, coarse);
        REQUIRE(chain);
        CHECK_FALSE(chain->levels[0].built.moved.empty());
        CHECK(chain->levels[1].built.moved.empty());
        for (const lod_level& level : chain->levels) {
            CHECK(level.error.max <= level.error_bound + 1e-6 * chain->bounds.radius);
        }
    }
    TEST_CASE("a level of few planes is made of the mesh") {
        lod_options options = small({20, 12, 6});
        const mesh m = leaf_soup(400, {.edge = 0.15f});
        auto chain = build_lod_chain(m, options, coarse);
        REQUIRE(chain);
        CHECK(chain->levels[0].made_of == lod_source::mesh);
        CHECK(chain->levels[1].made_of == lod_source::level_above);
        CHECK(chain->levels[1].built.cloud.plane_of_face.size() ==
              2 * chain->levels[0].built.cloud.plane_count());
        CHECK(chain->levels[2].made_of == lod_source::mesh);
        CHECK(chain->levels[2].built.cloud.plane_of_face.size() == m.face_count());
        options.least_incremental = 0;
        chain = build_lod_chain(m, options, coarse);
        REQUIRE(chain);
        CHECK(chain->levels[2].made_of == lod_source::level_above);
    }
    TEST_CASE("both triangles of a billboard go to the same plane of the next level") {
        const auto chain =
            build_lod_chain(leaf_soup(400, {.edge = 0.15f}), small({24, 12}), coarse);
        REQUIRE(chain);
        const auto& planes = chain->levels[1].built.cloud.plane_of_face;
        for (std::size_t i = 0; i + 1 < planes.size(); i += 2) CHECK(planes[i] == planes[i + 1]);
    }
    TEST_CASE("a level made of the one above keeps more of its planes than one made of the mesh") {
        const auto kept = [](lod_source made_of) {
            double sum = 0;
            for (const std::uint64_t seed : {1u, 2u}) {
                const auto chain =
                    build_lod_chain(*tree_of_about(600, seed), small({24, 12}, made_of), coarse);
                REQUIRE(chain);
                sum +=
                    share_of_kept_planes(chain->levels[1].built.cloud, chain->levels[0].built.cloud,
                                         10 * std::numbers::pi / 180, 0.05 * chain->bounds.radius);
            }
            return sum / 2;
        };
        const double incremental = kept(lod_source::level_above);
        const double independent = kept(lod_source::mesh);
        MESSAGE("kept: incremental " << incremental << ", independent " << independent);
        CHECK(incremental >= independent + 0.15);
    }
    TEST_CASE("a box that is exact at six planes stays exact") {
        const auto chain = build_lod_chain(textured_cube(), small({24, 11, 6}), coarse);
        REQUIRE(chain);
        for (const lod_level& level : chain->levels) {
            CHECK(level.built.cloud.plane_count() == 6);
            CHECK(level.error.max < 1e-3 * chain->bounds.radius);
        }
    }
    TEST_CASE("textures have half the texels of the level above") {
        const auto chain =
            build_lod_chain(textured_cube(), small({8, 7, 6}, lod_source::mesh), coarse);
        REQUIRE(chain);
        const auto size = [&](std::size_t i) { return chain->levels[i].built.baked.texel_size; };
        CHECK(size(1) == doctest::Approx(2 * size(0)));
        CHECK(size(2) == doctest::Approx(4 * size(0)));
    }
    TEST_CASE("any number of threads gives the same chain") {
        lod_options options = small({16, 10});
        options.build.threads.threads = 1;
        const mesh m = leaf_soup(400, {.edge = 0.15f});
        const auto one = build_lod_chain(m, options, coarse);
        REQUIRE(one);
        for (const unsigned threads : {2u, 3u, 8u}) {
            options.build.threads.threads = threads;
            const auto many = build_lod_chain(m, options, coarse);
            REQUIRE(many);
            for (std::size_t i = 0; i < 2; ++i) {
                const lod_level& a = one->levels[i];
                const lod_level& b = many->levels[i];
                CHECK(a.built.cloud.planes == b.built.cloud.planes);
                CHECK(a.built.cloud.plane_of_face == b.built.cloud.plane_of_face);
                CHECK(a.error.max == b.error.max);
                CHECK(a.error.mean == b.error.mean);
                CHECK(a.jump.mean == b.jump.mean);
                REQUIRE(a.built.baked.atlases.size() == b.built.baked.atlases.size());
                for (std::size_t k = 0; k < a.built.baked.atlases.size(); ++k) {
                    CHECK(a.built.baked.atlases[k].base_color ==
                          b.built.baked.atlases[k].base_color);
                }
            }
        }
    }
    TEST_CASE("progress names the levels") {
        std::set<std::string> stages;
        const auto listen = [&](std::string_view stage, double) { stages.emplace(stage); };
        REQUIRE(build_lod_chain(leaf_soup(100), small({8, 4}), coarse, listen));
        CHECK(stages.contains("level 0: bake"));
        CHECK(stages.contains("level 1: search"));
    }
    TEST_CASE("a mesh without area gives levels without planes") {
        for (const mesh& m : {mesh{}, support::triangles({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}})}) {
            const auto chain = build_lod_chain(m, small({20, 12}), coarse);
            REQUIRE(chain);
            for (const lod_level& level : chain->levels) {
                CHECK(level.built.cloud.plane_count() == 0);
                CHECK(level.error.faces == 0);
                CHECK(level.error.max == 0);
            }
        }
    }
    TEST_CASE("what makes no sense is refused by name") {
        const mesh m = leaf_soup(10);
        const auto refuses = [&](const lod_options& options) {
            const auto chain = build_lod_chain(m, options, coarse);
            return !chain && chain.error().code == error_code::invalid_options &&
                   !chain.error().message.empty();
        };
        for (const std::vector<std::size_t>& levels :
             {std::vector<std::size_t>{}, {0}, {5, 0}, {4, 11}, {4, 4}, {10001}}) {
            CHECK(refuses(small(levels)));
        }
        for (const double share : {0.0, -1.0, 1.5, double(std::nanf(""))}) {
            lod_options options = small({4});
            options.texel_share = share;
            CHECK(refuses(options));
        }
        mesh broken = m;
        broken.positions[0].x = std::nanf("");
        const auto chain = build_lod_chain(broken, small({4}), coarse);
        REQUIRE_FALSE(chain);
        CHECK(chain.error().code == error_code::not_finite);
    }
}
