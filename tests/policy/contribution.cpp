#include <billow/policy/contribution.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

TEST_SUITE("policy/contribution") {
    TEST_CASE("the projected area of 100 falls with the cosine and is the same from behind") {
        face_lanes<float> face{};
        face.area = 100;
        face.normal = {0, 0, 1};
        for (const double degrees : {0.0, 10.0, 30.0, 90.0, 150.0, 180.0}) {
            const double angle = degrees * std::acos(-1.0) / 180;
            const vec3_lanes<float> n{float(std::sin(angle)), 0, float(std::cos(angle))};
            CHECK(double(projected_area{}(face, n)) ==
                  doctest::Approx(100 * std::abs(std::cos(angle))).epsilon(1e-5));
        }
    }
    TEST_CASE("it never exceeds the area, whatever rounding did to the normals") {
        face_lanes<float> face{};
        face.area = 1;
        face.normal = {0, 0, 1.0000001f};
        CHECK(projected_area{}(face, vec3_lanes<float>{0, 0, 1.0000001f}) <= 1);
    }
    TEST_CASE("the angular area of 100 is 100, 88.9 and 66.7 at 0, 10 and 30 degrees") {
        face_lanes<float> face{};
        face.area = 100;
        face.normal = {0, 0, 1};
        const std::array<std::pair<double, double>, 5> table{
            {{0, 100}, {10, 88.889}, {30, 66.667}, {90, 0}, {150, 66.667}}};
        for (const auto& [degrees, expected] : table) {
            const double angle = degrees * std::acos(-1.0) / 180;
            const vec3_lanes<float> n{float(std::sin(angle)), 0, float(std::cos(angle))};
            CHECK(std::abs(double(angular_area{}(face, n)) - expected) < 0.001);
        }
    }
    TEST_CASE("the angular area is that of std::atan2 within 2e-6, even, and at most the area") {
        random_stream random(3);
        double worst = 0;
        for (int i = 0; i < 20000; ++i) {
            face_lanes<float> face{};
            face.area = 1;
            const vec3 f(support::random_direction(random));
            // Half of the normals lie close to the face's own.
            const double spread = i % 2 == 0 ? 1e-3 : 2;
            const vec3 n(glm::normalize(dvec3(f) + support::random_direction(random) * spread));
            face.normal = fill_lanes<float>(f);
            const float worth = angular_area{}(face, fill_lanes<float>(n));
            CHECK(worth <= 1);
            CHECK(worth >= 0);
            REQUIRE(worth == angular_area{}(face, fill_lanes<float>(-n)));
            const double angle = std::atan2(glm::length(glm::cross(dvec3(f), dvec3(n))),
                                            std::abs(glm::dot(dvec3(f), dvec3(n))));
            worst = std::max(worst, std::abs(double(worth) - (1 - angle / std::acos(0.0))));
        }
        CHECK(worst < 2e-6);
    }
    TEST_CASE("lanes give the bits of one face") {
        const face_table faces = support::table_of(support::random_triangles(64, 0.3, 9));
        const vec3 n = glm::normalize(vec3(0.3f, -0.5f, 0.8f));
        const auto check = [&](const auto& worth) {
            using V = simd::wide;
            std::array<float, 64> wide{};
            for (std::size_t row = 0; row < 64; row += simd::lanes<V>::count) {
                simd::lanes<V>::store(wide.data() + row,
                                      worth(load_faces<V>(faces, row), fill_lanes<V>(n)));
            }
            for (std::size_t row = 0; row < 64; ++row) {
                CHECK(wide[row] == worth(load_faces<float>(faces, row), fill_lanes<float>(n)));
            }
        };
        check(projected_area{});
        check(angular_area{});
        check(within_angle{angular_area{}, 30});
    }
    TEST_CASE("a face without a normal, which padding is, is worth 0") {
        CHECK(angular_area{}(face_lanes<float>{}, vec3_lanes<float>{0, 0, 1}) == 0);
    }
    TEST_CASE("within an angle a contribution stays, beyond it is 0; 90 degrees allow all") {
        face_lanes<float> face{};
        face.area = 1;
        face.normal = {0, 0, 1};
        for (const double degrees : {0.0, 19.9, 20.1, 60.0, 90.0, 160.5}) {
            const double angle = degrees * std::acos(-1.0) / 180;
            const vec3_lanes<float> n{float(std::sin(angle)), 0, float(std::cos(angle))};
            const bool is_within = std::min(degrees, 180 - degrees) <= 20;
            CHECK(within_angle{angular_area{}, 20}(face, n) ==
                  (is_within ? angular_area{}(face, n) : 0));
            CHECK(within_angle{projected_area{}, 90}(face, n) == projected_area{}(face, n));
        }
        CHECK(least_cosine_of(projected_area{}) == 0);
        CHECK(least_cosine_of(within_angle{projected_area{}, 90}) == 0);
        CHECK(double(least_cosine_of(within_angle{projected_area{}, 60})) == doctest::Approx(0.5));
        CHECK(double(least_cosine_of(within_angle{within_angle{projected_area{}, 60}, 80})) ==
              doctest::Approx(0.5));
        CHECK(least_cosine_of(within_angle{projected_area{}, 0}) < 1);
    }
}
