#include <billow/io/mip_files.hpp>

#include <doctest/doctest.h>

#include "scratch.hpp"

using namespace billow;
using scratch::failed;

namespace {

baked_cloud two_atlases() {
    baked_cloud baked;
    for (const int width : {16, 10}) {
        atlas& a = baked.atlases.emplace_back();
        a.base_color = image::filled(width, 8, 4, 200);
        a.normal = image::filled(width, 8, 3, 128);
    }
    baked.atlases[1].horizon = image::filled(10, 8, 4, 100);
    baked.tiles = {{.atlas = 0, .x = 4, .y = 4, .width = 8, .height = 1},
                   {.atlas = 1, .x = 2, .y = 2, .width = 6, .height = 4}};
    return baked;
}

std::vector<std::string> names_of(const mip_files& files) {
    std::vector<std::string> names;
    for (const auto& name : files.names) names.push_back(name.filename().string());
    return names;
}

}  // namespace

TEST_SUITE("io/mip_files") {
    TEST_CASE("DDS: one file a channel that there is, with all levels, and no other file") {
        const scratch::folder at;
        const auto files = write_mips(at / "tree", two_atlases(), mip_format::dds, {.padding = 4});
        REQUIRE(files);
        CHECK(names_of(*files) == std::vector<std::string>{"tree_basecolor.dds", "tree_normal.dds",
                                                           "tree_1_basecolor.dds",
                                                           "tree_1_normal.dds",
                                                           "tree_1_horizon.dds"});
        CHECK(at.file_count() == 5);
        const auto mips = make_mips(two_atlases(), {.padding = 4});
        CHECK(*read_file(at / "tree_basecolor.dds") == encode_dds(mips[0].base_color, true));
        CHECK(*read_file(at / "tree_normal.dds") == encode_dds(mips[0].normal, false));
        CHECK(*read_file(at / "tree_1_horizon.dds") == encode_dds(mips[1].horizon, false));
        CHECK(files->safe_levels == 2);  // of the second: 10, 5, 2, 1 texels wide
        CHECK(mips[0].base_color.size() == 5);
    }
    TEST_CASE("PNG: one file a level, read back as it was made") {
        const scratch::folder at;
        const auto files = write_mips(at / "a.b", two_atlases(), mip_format::png, {.padding = 4});
        REQUIRE(files);
        CHECK(files->names.size() == at.file_count());
        CHECK(files->names.size() == 2 * 5 + 3 * 4);
        const auto mips = make_mips(two_atlases(), {.padding = 4});
        CHECK(*read_image(at / "a.b_basecolor_mip0.png") == two_atlases().atlases[0].base_color);
        CHECK(*read_image(at / "a.b_normal_mip3.png") == mips[0].normal[3]);
        CHECK(*read_image(at / "a.b_1_horizon_mip2.png") == mips[1].horizon[2]);
    }
    TEST_CASE("nothing is written where nothing is wanted or there is no folder") {
        const scratch::folder at;
        const auto none = write_mips(at / "tree", two_atlases(), mip_format::none);
        REQUIRE(none);
        CHECK(none->names.empty());
        CHECK(write_mips(at / "tree", {}, mip_format::dds)->names.empty());
        CHECK(at.file_count() == 0);
        CHECK(failed(write_mips(at / "no folder/tree", two_atlases(), mip_format::dds),
                     error_code::unwritable, "folder does not exist", "tree_basecolor.dds"));
    }
}
