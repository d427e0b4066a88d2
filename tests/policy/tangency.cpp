#include <billow/policy/tangency.hpp>

#include <cmath>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// What one face of area 1/2 with normal z is worth to a plane whose normal has that cosine.
template <class Contribution>
float worth_at(const Contribution& worth, double cosine) {
    face_lanes<float> face{};
    face.normal = {0, 0, 1};
    face.area = 0.5f;
    const auto c = static_cast<float>(cosine);
    return worth(face, vec3_lanes<float>{std::sqrt(1 - c * c), 0, c});
}

}  // namespace

TEST_SUITE("policy/tangency") {
    TEST_CASE("whole exponents multiply by powers of the cosine") {
        for (const double cosine : {-1.0, -0.5, 0.0, 0.25, 0.8, 1.0}) {
            const double c = std::abs(cosine);
            for (const int k : {0, 1, 2, 3}) {
                CHECK(worth_at(tangent_share(projected_area{}, k), cosine) ==
                      doctest::Approx(0.5 * std::pow(c, k + 1)));
            }
        }
    }
    TEST_CASE("between whole exponents the worth is between theirs") {
        for (const double cosine : {0.2, 0.7}) {
            const float less = worth_at(tangent_share(projected_area{}, 2), cosine);
            const float more = worth_at(tangent_share(projected_area{}, 1), cosine);
            const float half = worth_at(tangent_share(projected_area{}, 1.5), cosine);
            CHECK(half == doctest::Approx((less + more) / 2));
        }
    }
    TEST_CASE("the base keeps its angle") {
        const tangent_share share(within_angle(projected_area{}, 30), 1);
        CHECK(least_cosine_of(share) == doctest::Approx(std::cos(0.523598776)));
        CHECK(worth_at(share, 0.5) == 0);
        CHECK(worth_at(share, 0.9) > 0);
    }
    TEST_CASE("lanes give what one face gives") {
        const face_table faces = support::table_of(support::random_triangles(32, 0.4, 3));
        const tangent_share share(angular_area{}, 1.3);
        const vec3 normal = glm::normalize(vec3(0.3f, -0.5f, 0.7f));
        for (std::size_t row = 0; row < faces.padded_size(); row += simd::lane_count) {
            const simd::wide many =
                share(load_faces<simd::wide>(faces, row), fill_lanes<simd::wide>(normal));
            std::array<float, simd::max_lane_count> each{};
            simd::lanes<simd::wide>::store(each.data(), many);
            for (std::size_t i = 0; i < simd::lane_count; ++i) {
                const float one =
                    share(load_faces<float>(faces, row + i), fill_lanes<float>(normal));
                CHECK(each[i] == doctest::Approx(one).epsilon(1e-6));
            }
        }
    }
}
