#include <billow/metrics/statistic.hpp>

#include <algorithm>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

using namespace billow;

TEST_SUITE("metrics/statistic") {
    TEST_CASE("of nothing all is 0, of one value all is that value") {
        CHECK(statistic_of({}) == statistic{});
        CHECK(statistic_of(std::vector{-2.0}) == statistic{-2, -2, -2, 0});
    }
    TEST_CASE("of 1 to 20 in any order 19 is not exceeded by 95 %") {
        std::vector<double> values;
        for (int i = 0; i < 20; ++i) values.push_back((i * 7) % 20 + 1);
        const statistic s = statistic_of(values);
        CHECK(s.mean == doctest::Approx(10.5));
        CHECK(s.p95 == 19);
        CHECK(s.worst == 20);
        CHECK(values[s.worst_view] == 20);
        values.push_back(21);
        CHECK(statistic_of(values).p95 == 20);  // 20 of 21 are 95.2 %
    }
    TEST_CASE("the first of equally bad views is named") {
        CHECK(statistic_of(std::vector{1.0, 5.0, 2.0, 5.0}).worst_view == 1);
    }
    TEST_CASE("p95 is the least value that 95 % do not exceed") {
        for (std::size_t count = 1; count < 130; ++count) {
            std::vector<double> values;
            for (std::size_t i = 0; i < count; ++i) {
                values.push_back(random_unit(count, i));
            }
            const double p95 = statistic_of(values).p95;
            const auto up_to = [&](double limit) {
                return std::count_if(values.begin(), values.end(),
                                     [=](double v) { return v <= limit; });
            };
            CHECK(std::find(values.begin(), values.end(), p95) != values.end());
            CHECK(100 * up_to(p95) >= 95 * static_cast<std::ptrdiff_t>(count));
            CHECK(100 * (up_to(p95) - 1) < 95 * static_cast<std::ptrdiff_t>(count));
        }
    }
}
