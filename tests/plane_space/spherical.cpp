#include <billow/plane_space/spherical.hpp>

#include <doctest/doctest.h>


using namespace billow;

TEST_SUITE("plane_space/spherical") {
    TEST_CASE("there are 4N longitudes times 2N latitudes") {
        CHECK(spherical(18).orientation_count() == 72 * 36);
        CHECK(spherical(1).orientation_count() == 8);
    }
    TEST_CASE("a pole's neighbours lie across it, half a turn away") {
        const spherical space(18);
        const orientation_id id = 5;  // the row that touches the pole
        bool crosses = false;
        for (const orientation_id near : space.neighbours(id)) crosses |= near == 5 + 36;
        CHECK(crosses);
        CHECK(space.neighbours(id).size() == 8);
    }
    TEST_CASE("directions follow the spherical coordinates of their cell") {
        const spherical space(18);
        const double step = std::numbers::pi / 36;
        const dvec3 d = space.direction(72 * 10 + 3);
        CHECK(d.z == doctest::Approx(std::cos(10.5 * step)));
        CHECK(std::atan2(d.y, d.x) == doctest::Approx(3.5 * step));
    }
}
