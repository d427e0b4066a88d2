#include <billow/bake/horizon.hpp>

#include <cmath>

#include <doctest/doctest.h>

#include <billow/bake/occlusion.hpp>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("bake/horizon") {
    TEST_CASE("a wall sees the half space before it") {
        mesh m;
        support::add_square(m, {0, 0, 0}, {0, 1, 0}, {0, 0, 1});  // looks along +x
        const surface look(m);
        const sky_table sky = see_sky(look, support::table_of(m), {.rays = 256});
        const horizon_cone cone = cone_of(sky.at(0, vec3(1.0f / 3)).visible);
        CHECK(cone.axis.x > 0.995f);
        CHECK(cone.cosine == doctest::Approx(0));
        CHECK(cone.is_lit({1, 0, 0}));
        CHECK(cone.is_lit(glm::normalize(vec3(0.3f, 1, 0))));
        CHECK_FALSE(cone.is_lit(glm::normalize(vec3(-0.3f, 1, 0))));
    }
    TEST_CASE("light comes past a wall from the other side") {
        mesh m;
        support::add_square(m, {0, 0, 0}, {0.01f, 0, 0}, {0, 0.01f, 0});
        support::add_square(m, {0.05f, 0, 2}, {0, 9, 0}, {0, 0, 2});  // hides what has x > 0
        const surface look(m);
        const sky_table sky = see_sky(look, support::table_of(m), {.rays = 1024});
        const horizon_cone cone = cone_of(sky.at(0, vec3(1.0f / 3)).visible);
        CHECK(cone.axis.x < -0.4f);
        CHECK(cone.axis.z > 0.4f);
        CHECK(cone.cosine == doctest::Approx(0.5).epsilon(0.1));  // a quarter of the sphere
        CHECK(cone.is_lit(glm::normalize(vec3(-1, 0, 1))));
        CHECK_FALSE(cone.is_lit(glm::normalize(vec3(1, 0, 1))));
    }
    TEST_CASE("the whole sky is lit from everywhere, none from nowhere") {
        random_stream random(1);
        const horizon_cone all = cone_of({0, 0, 0, 1});
        const horizon_cone none = cone_of({0, 0, 0, 0});
        for (int i = 0; i < 50; ++i) {
            const vec3 l(support::random_direction(random));
            CHECK(all.is_lit(l));
            CHECK_FALSE(none.is_lit(l));
        }
        CHECK(decode_horizon(encode_horizon(all).data()).cosine == -1);
        CHECK(decode_horizon(encode_horizon(none).data()).cosine == 1);
        CHECK(decode_horizon(encode_horizon(all).data()).axis == vec3(0));
    }
    TEST_CASE("as much of the sphere is lit as was visible") {
        random_stream random(2);
        for (const float share : {0.1f, 0.35f, 0.8f}) {
            const horizon_cone cone = cone_of({0.02f, -0.03f, 0.01f, share});
            int lit = 0;
            for (int i = 0; i < 4000; ++i) {
                lit += cone.is_lit(vec3(support::random_direction(random))) ? 1 : 0;
            }
            CHECK(lit / 4000.0 == doctest::Approx(share).epsilon(0.1));
        }
    }
    TEST_CASE("bytes keep the axis to within a degree, the cosine to within a byte") {
        random_stream random(3);
        for (int i = 0; i < 500; ++i) {
            const horizon_cone cone{vec3(support::random_direction(random)),
                                    static_cast<float>(random.between(-1, 1))};
            const horizon_cone read = decode_horizon(encode_horizon(cone).data());
            CHECK(glm::dot(read.axis, cone.axis) > std::cos(0.0175f));
            CHECK(std::abs(read.cosine - cone.cosine) < 0.0045f);
        }
    }
}
