#include <billow/policy/contribution.hpp>

#include <cmath>

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
}
