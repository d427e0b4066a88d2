#include <billow/image/distance_field.hpp>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

namespace {

using namespace billow;

/// The covered shares of a disc, by 16 × 16 samples a texel.
std::vector<float> disc(int size, const dvec2& centre, double radius) {
    std::vector<float> covered;
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            int inside = 0;
            for (int s = 0; s < 256; ++s) {
                const dvec2 p(x - 0.5 + (s % 16 + 0.5) / 16, y - 0.5 + (s / 16 + 0.5) / 16);
                if (glm::distance(p, centre) < radius) ++inside;
            }
            covered.push_back(static_cast<float>(inside) / 256);
        }
    }
    return covered;
}

}  // namespace

TEST_SUITE("image/distance_field") {
    TEST_CASE("distances to a disc are right to a sixth of a texel") {
        const dvec2 centre(9.7, 10.2);
        for (const double radius : {2.5, 4.0, 6.3}) {
            const auto d = signed_distances(disc(20, centre, radius), 20, 20, 0.5, 4);
            for (int y = 0; y < 20; ++y) {
                for (int x = 0; x < 20; ++x) {
                    const double exact = radius - glm::distance(dvec2(x, y), centre);
                    CHECK(std::abs(static_cast<double>(d[static_cast<std::size_t>(20 * y + x)]) -
                                   std::clamp(exact, -4.0, 4.0)) < 1.0 / 6);
                }
            }
        }
    }
    TEST_CASE("the sign says which side of the threshold a texel is on") {
        random_stream random(4);
        std::vector<float> covered;
        for (int i = 0; i < 17 * 9; ++i) covered.push_back(static_cast<float>(random.unit()));
        for (const double level : {0.2, 0.5, 0.8}) {
            const auto d = signed_distances(covered, 17, 9, level, 2);
            for (std::size_t i = 0; i < d.size(); ++i) {
                CHECK((d[i] >= 0) == (static_cast<double>(covered[i]) >= level));
                CHECK(std::abs(d[i]) <= 2);
                CHECK((byte_from_distance(d[i], 2) >= 128) == (d[i] >= 0));
            }
        }
    }
    TEST_CASE("nothing covered is all outside, everything ends at the rim of the grid") {
        const std::vector<float> none(30, 0.0f);
        for (const float d : signed_distances(none, 6, 5, 0.5, 3)) CHECK(d == -3);
        const std::vector<float> all(30, 1.0f);
        const auto d = signed_distances(all, 6, 5, 0.5, 3);
        CHECK(d[0] == doctest::Approx(0.5 * std::sqrt(0.5)));  // the rim cuts corners
        CHECK(d[2 * 6 + 3] == doctest::Approx(2.5));
        CHECK(signed_distances({}, 0, 0, 0.5, 3).empty());
    }
}
