#include <billow/metrics/channel.hpp>

#include <cmath>
#include <limits>
#include <numeric>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

using namespace billow;

namespace {

channel random_channel(int width, int height, std::uint64_t seed) {
    random_stream random(seed);
    channel c(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) c.row(y)[x] = static_cast<float>(random.unit());
        // The padding must not matter.
        for (auto x = static_cast<std::size_t>(width); x < c.stride; ++x) {
            c.row(y)[x] = std::numeric_limits<float>::infinity();
        }
    }
    return c;
}

const float uneven[] = {0.1f, -0.4f, 2.0f, 0.3f, 1.0f, 0.0f, -0.7f};

template <class Value>
void check_each(const channel& c, const Value& value) {
    for (int y = 0; y < c.height; ++y) {
        for (int x = 0; x < c.width; ++x) {
            CHECK(c.at(x, y) == doctest::Approx(value(x, y)).epsilon(1e-5));
        }
    }
}

}  // namespace

TEST_SUITE("metrics/channel") {
    TEST_CASE("filters are sums over neighbours, the outermost ones again beyond the edge") {
        for (const auto& [width, height] : {std::pair(1, 1), {2, 9}, {16, 3}, {37, 18}}) {
            const channel c = random_channel(width, height, 3);
            check_each(filter_rows(c, uneven), [&, w = width](int x, int y) {
                double sum = 0;
                for (int k = -3; k <= 3; ++k) {
                    sum +=
                        static_cast<double>(uneven[k + 3]) * c.at(std::clamp(x + k, 0, w - 1), y);
                }
                return sum;
            });
            check_each(filter_columns(c, uneven), [&, h = height](int x, int y) {
                double sum = 0;
                for (int k = -3; k <= 3; ++k) {
                    sum +=
                        static_cast<double>(uneven[k + 3]) * c.at(x, std::clamp(y + k, 0, h - 1));
                }
                return sum;
            });
        }
    }
    TEST_CASE("lanes give what floats give") {
        const channel c = random_channel(37, 18, 5);
        const channel rows = filter_rows<float>(c, uneven);
        const channel columns = filter_columns<float>(c, uneven);
        check_each(filter_rows(c, uneven), [&](int x, int y) { return rows.at(x, y); });
        check_each(filter_columns(c, uneven), [&](int x, int y) { return columns.at(x, y); });
    }
    TEST_CASE("a Gaussian sums to 1, has the deviation asked for and leaves a constant alone") {
        for (const double sigma : {0.05, 0.6, 2.0, 7.5}) {
            const auto weights = gaussian_weights(sigma, static_cast<int>(std::ceil(6 * sigma)));
            CHECK(weights.size() % 2 == 1);
            CHECK(std::accumulate(weights.begin(), weights.end(), 0.0) == doctest::Approx(1));
            double variance = 0;
            const auto middle = static_cast<double>(weights.size() / 2);
            for (std::size_t i = 0; i < weights.size(); ++i) {
                const double x = static_cast<double>(i) - middle;
                variance += weights[i] * x * x;
            }
            if (sigma > 0.5) CHECK(std::sqrt(variance) == doctest::Approx(sigma).epsilon(0.01));
        }
        channel c(21, 5);
        std::fill(c.values.begin(), c.values.end(), 0.75f);
        check_each(blurred(c, gaussian_weights(2, 6)), [](int, int) { return 0.75; });
    }
    TEST_CASE("erosion takes the least of a square, of what is within the edges") {
        const channel c = random_channel(37, 18, 7);
        for (const int radius : {0, 1, 4, 40}) {
            check_each(eroded(c, radius), [&](int x, int y) {
                float least = 2;
                for (int j = std::max(0, y - radius); j <= std::min(17, y + radius); ++j) {
                    for (int i = std::max(0, x - radius); i <= std::min(36, x + radius); ++i) {
                        least = std::min(least, c.at(i, j));
                    }
                }
                return least;
            });
        }
    }
}
