#include <billow/metrics/draw_cost.hpp>

#include <doctest/doctest.h>

using namespace billow;

namespace {

struct counts {
    double drawn = 0;
    [[nodiscard]] double overdraw() const noexcept { return drawn; }
};

}  // namespace

TEST_SUITE("metrics/draw_cost") {
    TEST_CASE("bytes are those of all pixels and channels, mips halve sides down to a pixel") {
        CHECK(texture_bytes_of(image::filled(4, 4, 4, 0)) ==
              texture_bytes{4 * (16), 4 * (16 + 4 + 1)});
        CHECK(texture_bytes_of(image::filled(5, 2, 3, 0)) ==
              texture_bytes{3 * (10), 3 * (10 + 2 + 1)});
        CHECK(texture_bytes_of(image::filled(1, 1, 1, 0)) == texture_bytes{1, 1});
        CHECK(texture_bytes_of(image{}) == texture_bytes{});
    }
    TEST_CASE("of large squares mips add a third") {
        const texture_bytes bytes = texture_bytes_of(image::filled(1024, 1024, 4, 0));
        CHECK(static_cast<double>(bytes.with_mips) / static_cast<double>(bytes.level_0) ==
              doctest::Approx(4.0 / 3).epsilon(1e-5));
    }
    TEST_CASE("all channels of all atlases count, missing ones nothing") {
        baked_cloud baked;
        baked.atlases.resize(2);
        baked.atlases[0].base_color = image::filled(8, 8, 4, 0);
        baked.atlases[0].normal = image::filled(8, 8, 3, 0);
        baked.atlases[1].base_color = image::filled(8, 8, 4, 0);
        baked.atlases[1].occlusion_roughness_metallic = image::filled(8, 8, 3, 0);
        baked.atlases[1].emissive = image::filled(8, 8, 3, 0);
        baked.atlases[1].horizon = image::filled(8, 8, 4, 0);
        CHECK(texture_bytes_of(baked).level_0 == 64 * (4 + 3 + 4 + 3 + 3 + 4));
    }
    TEST_CASE("a mesh costs its triangles and its images") {
        mesh m;
        m.triangles = {{0, 1, 2}, {0, 2, 3}};
        m.images = {image::filled(2, 2, 4, 0), image::filled(2, 1, 3, 0)};
        const draw_cost cost = draw_cost_of(m);
        CHECK(cost.triangles == 2);
        CHECK(cost.textures == texture_bytes{16 + 6, 16 + 4 + 6 + 3});
    }
    TEST_CASE("overdraw is taken over views") {
        const std::vector<counts> views{{1.5}, {4.0}, {2.0}};
        const statistic s = overdraw_over(std::span<const counts>(views));
        CHECK(s.mean == doctest::Approx(2.5));
        CHECK(s.worst == 4);
        CHECK(s.worst_view == 1);
    }
}
