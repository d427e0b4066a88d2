#include <billow/bake/texture_sampler.hpp>

#include <limits>

#include <doctest/doctest.h>

namespace {

using namespace billow;

/// Grey ramp of four texels: 0, 80, 160, 240.
const std::vector<image>& ramp() {
    static const auto chain = make_mip_chain({4, 1, 1, {0, 80, 160, 240}}, texel_kind::linear);
    return chain;
}

float grey(float u, texture_wrap wrap, bool is_nearest = false) {
    texture t;
    t.wrap_u = wrap;
    t.is_nearest = is_nearest;
    return sample_texture(ramp(), texel_kind::linear, t, {u, 0.5f}, 0).x * 255.0f;
}

}  // namespace

TEST_SUITE("bake/texture_sampler") {
    TEST_CASE("texel centres give the texel, points between their mean") {
        for (const auto wrap :
             {texture_wrap::repeat, texture_wrap::mirrored_repeat, texture_wrap::clamp_to_edge}) {
            CHECK(grey(0.125f, wrap) == doctest::Approx(0));
            CHECK(grey(0.625f, wrap) == doctest::Approx(160));
            CHECK(grey(0.5f, wrap) == doctest::Approx(120));
            CHECK(grey(0.55f, wrap, true) == doctest::Approx(160));
        }
    }

    TEST_CASE("beyond the edge the wrap mode decides") {
        CHECK(grey(1.125f, texture_wrap::repeat) == doctest::Approx(0));
        CHECK(grey(1.125f, texture_wrap::mirrored_repeat) == doctest::Approx(240));
        CHECK(grey(1.375f, texture_wrap::mirrored_repeat) == doctest::Approx(160));
        CHECK(grey(-0.375f, texture_wrap::mirrored_repeat) == doctest::Approx(80));
        CHECK(grey(1.9f, texture_wrap::clamp_to_edge) == doctest::Approx(240));
        CHECK(grey(-3.0f, texture_wrap::clamp_to_edge) == doctest::Approx(0));
        CHECK(grey(0.0f, texture_wrap::repeat) == doctest::Approx(120));
        CHECK(grey(0.0f, texture_wrap::clamp_to_edge) == doctest::Approx(0));
        CHECK(grey(-0.875f, texture_wrap::repeat) == doctest::Approx(0));
    }

    TEST_CASE("huge and missing coordinates stay inside") {
        for (const float u : {1e30f, -1e30f, std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::quiet_NaN()}) {
            for (const auto wrap : {texture_wrap::repeat, texture_wrap::mirrored_repeat,
                                    texture_wrap::clamp_to_edge}) {
                const float value = grey(u, wrap);
                CHECK(value >= 0);
                CHECK(value <= 240.01f);
            }
        }
    }

    TEST_CASE("a level is chosen half way between its neighbours' sizes") {
        CHECK(level_of_footprint(0.01, 5) == 0);
        CHECK(level_of_footprint(1.9, 5) == 0);
        CHECK(level_of_footprint(2.1, 5) == 1);
        CHECK(level_of_footprint(7.9, 5) == 1);
        CHECK(level_of_footprint(8.1, 5) == 2);
        CHECK(level_of_footprint(31, 5) == 2);
        CHECK(level_of_footprint(33, 5) == 3);
        CHECK(level_of_footprint(1e9, 5) == 4);
    }

    TEST_CASE("the transform is applied as a matrix") {
        texture t;
        t.transform = mat3(2, 0, 0, 0, 3, 0, 0.25f, 0.5f, 1);
        CHECK(transformed(t, {0.5f, 0.5f}) == vec2(1.25f, 2.0f));
    }
}
