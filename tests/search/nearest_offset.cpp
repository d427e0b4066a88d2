#include <billow/search/nearest_offset.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

using namespace billow;

namespace {

using middles = std::vector<weighted_middle>;

double found(middles of, double low, double high, double epsilon) {
    return nearest_offset(of, low, high, epsilon, distance_falloff{});
}

double worth(const middles& of, double offset, double epsilon) {
    double sum = 0;
    for (const weighted_middle& m : of) {
        const double distance = std::abs(offset - double(m.middle));
        sum += double(m.weight) * epsilon / (distance + epsilon);
    }
    return sum;
}

/// Of all middles and both ends, between which the sum is convex.
double most_worth(const middles& of, double low, double high, double epsilon) {
    double most = std::max(worth(of, low, epsilon), worth(of, high, epsilon));
    for (const weighted_middle& m : of) {
        if (m.middle >= low && m.middle <= high) {
            most = std::max(most, worth(of, double(m.middle), epsilon));
        }
    }
    return most;
}

}  // namespace

TEST_SUITE("search/nearest_offset") {
    TEST_CASE("a plane lies in its largest wall, not between two") {
        const middles walls{{1.0f, 3}, {1.25f, 4}, {1.5f, 2}};
        CHECK(found(walls, 0.8, 1.6, 0.5) == 1.25);
        CHECK(found({{1.0f, 3}, {1.5f, 4}}, 0.8, 1.6, 0.5) == 1.5);
        CHECK(found({{1.0f, 4}, {1.5f, 4}}, 0.8, 1.6, 0.5) == 1.0);  // of equals the least
    }
    TEST_CASE("where no middle is in the range the nearest end is best") {
        CHECK(found({{1.0f, 1}, {1.1f, 1}}, 1.5, 2, 0.5) == 1.5);
        CHECK(found({{1.0f, 1}, {1.1f, 1}}, 0.5, 0.75, 0.5) == 0.75);
    }
    TEST_CASE("what weighs nothing has no say") {
        CHECK(found({{1.0f, 0}, {1.2f, 1}}, 0, 2, 0.5) == doctest::Approx(1.2));
        CHECK(found({{1.0f, 0}}, 0, 3, 0.5) == 1.5);
        CHECK(found({}, 0, 3, 0.5) == 1.5);
    }
    TEST_CASE("it is as good as the best of all middles and ends, up to a cell") {
        random_stream random(7);
        for (int round = 0; round < 200; ++round) {
            const double epsilon = 0.05 + random.unit();
            const auto count = static_cast<std::size_t>(1 + 300 * random.unit());
            const bool is_clustered = round % 2 == 1;
            middles of;
            for (std::size_t i = 0; i < count; ++i) {
                const double at = is_clustered ? std::floor(6 * random.unit()) / 6 +
                                                     0.01 * random.unit()
                                               : random.unit();
                of.push_back({static_cast<float>(2 * epsilon * at),
                              static_cast<float>(std::pow(random.unit(), 4))});
            }
            const double low = 2 * epsilon * 0.5 * random.unit();
            const double high = low + 2 * epsilon * 0.5 * random.unit();
            const double at = found(of, low, high, epsilon);
            CHECK(at >= low);
            CHECK(at <= high);
            // A cell is a 64th of epsilon wide here, which is what a weight can fall within it.
            CHECK(worth(of, at, epsilon) >= (1 - 1.0 / 64) * most_worth(of, low, high, epsilon));
            middles shuffled = of;
            std::reverse(shuffled.begin(), shuffled.end());
            CHECK(found(shuffled, low, high, epsilon) == doctest::Approx(at).epsilon(1e-9));
        }
    }
}
