#include <billow/pipeline/shared_atlas.hpp>

#include <doctest/doctest.h>

#include <billow/metrics/picture.hpp>
#include <billow/pipeline.hpp>
#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

using namespace billow;

namespace {

build_options options_with(bool packs) {
    build_options options;
    options.bake.texels = 96;
    options.bake.draw.supersample = 2;
    options.bake.sides = tile_sides::automatic;
    options.packs_tiles = packs;
    return options;
}

}  // namespace

TEST_SUITE("pipeline/shared_atlas") {
    TEST_CASE("clouds look in a common atlas as they do in their own") {
        const std::vector<mesh> sources{teapot(4), textured_cube(16),
                                        leaf_soup(60, {.edge = 0.3f})};
        std::vector<build_result> apart;
        std::vector<build_result> together;
        for (const mesh& source : sources) {
            apart.push_back(*build_cloud(source, options_with(true)));
            together.push_back(*build_cloud(source, options_with(false)));
            CHECK(together.back().baked.atlases.empty());
        }
        const shared_atlas shared = share_atlas(together, options_with(true).bake);
        CHECK(shared.baked.atlases.size() == 1);
        REQUIRE(shared.members.size() == 3);
        CHECK(shared.members[2].billboards.end == shared.drawn.face_count());
        for (std::size_t i = 0; i < 3; ++i) {
            mesh part = shared.drawn;
            const face_range range = shared.members[i].billboards;
            const auto slice = [&](auto& column) {
                column = {column.begin() + static_cast<std::ptrdiff_t>(range.begin),
                          column.begin() + static_cast<std::ptrdiff_t>(range.end)};
            };
            slice(part.triangles);
            slice(part.face_materials);
            const mesh own = apart[i].to_mesh();
            CHECK(part.face_count() == own.face_count());
            CHECK(part.feature_ids[part.triangles[0].x] == 0);
            const auto view = view_of(apart[i].cloud.bounds, dvec3(1, 0.7, 0.4), 96, 96);
            const image a = draw_picture(own, view);
            const image b = draw_picture(part, view);
            double off = 0;
            for (std::size_t k = 0; k < a.bytes.size(); ++k)
                off += std::abs(a.bytes[k] - b.bytes[k]);
            CHECK(off / static_cast<double>(a.bytes.size()) < 0.2);
        }
    }
    TEST_CASE("clouds without planes, and no clouds, share nothing") {
        std::vector<build_result> none;
        CHECK(share_atlas(none, {}).drawn.face_count() == 0);
        none.push_back(*build_cloud(mesh{}, options_with(false)));
        none.push_back(*build_cloud(textured_cube(4), options_with(false)));
        const shared_atlas shared = share_atlas(none, options_with(false).bake);
        CHECK(shared.members[0].billboards.size() == 0);
        CHECK(shared.members[1].billboards.size() == shared.drawn.face_count());
        CHECK(shared.drawn.face_count() >= 12);
    }
}
