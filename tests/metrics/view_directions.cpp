#include <billow/metrics/view_directions.hpp>

#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>

TEST_SUITE("metrics/view_directions") {
    using namespace billow;

    TEST_CASE("directions have length 1, balance each other and keep apart") {
        for (const int count : {6, 42, 162, 1000}) {
            const std::vector<dvec3> directions = spread_directions(count);
            REQUIRE(directions.size() == static_cast<std::size_t>(count));
            dvec3 sum(0);
            double closest = 4;
            for (std::size_t i = 0; i < directions.size(); ++i) {
                CHECK(glm::length(directions[i]) == doctest::Approx(1));
                sum += directions[i];
                for (std::size_t k = 0; k < i; ++k) {
                    closest = std::min(closest, glm::length(directions[i] - directions[k]));
                }
            }
            CHECK(glm::length(sum) / count < 0.05);
            // Discs of this diameter around them cover more than half of what is possible.
            CHECK(closest > 0.8 * std::sqrt(4 * 3.14159 / count));
        }
    }

    TEST_CASE("every direction is near one of them") {
        const std::vector<dvec3> directions = spread_directions();
        for (const dvec3& at : spread_directions(5000)) {
            double nearest = 4;
            for (const dvec3& d : directions) nearest = std::min(nearest, glm::length(at - d));
            CHECK(nearest < 0.5);
        }
    }

    TEST_CASE("one direction, or none, is possible") {
        CHECK(spread_directions(0).empty());
        CHECK(spread_directions(-3).empty());
        REQUIRE(spread_directions(1).size() == 1);
    }
}
