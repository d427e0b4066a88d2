#include <billow/search/offset_block.hpp>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("search/offset_block") {
    TEST_CASE("the bucket never falls when the offset grows, and stays within the row") {
        const offset_buckets buckets(-0.7, 1.3, 37);
        std::int32_t before = 0;
        for (float at = -3; at < 3; at += 0.0007f) {
            const std::int32_t bucket = buckets.bucket_of(at);
            CHECK(bucket >= before);
            CHECK(bucket < 37);
            before = bucket;
        }
        CHECK(before == 36);
        CHECK(buckets.bucket_of(0) == 12);
    }
    TEST_CASE("lanes measure what one face measures") {
        const face_table faces = support::table_of(support::random_triangles(100, 0.2, 7));
        const projected_area worth;
        const inner_side_penalty penalty;
        const detail::offset_rules<projected_area, inner_side_penalty> rules{
            worth, penalty, offset_buckets(-1, 1, 64), 0.1f, 1e6f, true};
        const vec3 normal = glm::normalize(vec3(1, 2, -3));
        detail::offset_block wide, one;
        rules.measure<simd::wide>(faces, 0, faces.padded_size(), normal, wide);
        rules.measure<float>(faces, 0, faces.padded_size(), normal, one);
        std::size_t valid = 0;
        for (std::size_t i = 0; i < faces.padded_size(); ++i) {
            CHECK(wide.weight[i] == one.weight[i]);
            CHECK(wide.valid.low[i] == doctest::Approx(one.valid.low[i]));
            CHECK(wide.valid.high[i] == doctest::Approx(one.valid.high[i]));
            CHECK(wide.above.low[i] == doctest::Approx(one.above.low[i]));
            CHECK(wide.below.high[i] == doctest::Approx(one.below.high[i]));
            valid += one.weight[i] > 0 ? 1u : 0u;
        }
        CHECK(valid > 10);
        CHECK(valid < 100);
    }
    TEST_CASE("penalties lie on the side of the origin, on either side of it") {
        mesh m;
        support::add_square(m, {0, 0, 0.8f}, {0.1f, 0, 0}, {0, 0.1f, 0});
        support::add_square(m, {0, 0, -0.8f}, {0.1f, 0, 0}, {0, 0.1f, 0});
        const face_table faces = support::table_of(m);
        const projected_area worth;
        const inner_side_penalty penalty;
        const detail::offset_rules<projected_area, inner_side_penalty> rules{
            worth, penalty, offset_buckets(-1, 1, 64), 0.1f, 1e6f, true};
        detail::offset_block block;
        rules.measure(faces, 0, faces.padded_size(), {0, 0, 1}, block);
        CHECK(block.above.low[0] == doctest::Approx(0.6));
        CHECK(block.above.high[0] == doctest::Approx(0.7));
        CHECK(block.below.low[0] >= block.below.high[0]);  // none
        CHECK(block.below.low[2] == doctest::Approx(-0.7));
        CHECK(block.below.high[2] == doctest::Approx(-0.6));
        CHECK(block.above.low[2] >= block.above.high[2]);
    }
}
