#include <billow/io/polygon.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace billow;

namespace {

double area(std::span<const dvec3> corners, const dvec3& normal) {
    return glm::dot(detail::area_vector(corners), normal) / 2;
}

void check_cut(const std::vector<dvec3>& polygon) {
    const dvec3 normal = glm::normalize(detail::area_vector(polygon));
    const auto triangles = detail::triangulate_polygon(polygon);
    CHECK(triangles.size() == polygon.size() - 2);
    double sum = 0;
    for (const auto& [a, b, c] : triangles) {
        const std::array<dvec3, 3> t{polygon[a], polygon[b], polygon[c]};
        CHECK(area(t, normal) >= -1e-12);
        sum += area(t, normal);
    }
    CHECK(sum == doctest::Approx(area(polygon, normal)));
}

}  // namespace

TEST_SUITE("io/polygon") {
    TEST_CASE("triangles of a polygon cover it once and turn as it does") {
        check_cut({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}});
        check_cut({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
        check_cut({{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}});             // clockwise
        check_cut({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 1, 0}, {0, 4, 0}});  // notch
        check_cut({{0, 0, 5},
                   {9, 0, 5},
                   {9, 3, 5},
                   {6, 3, 5},
                   {6, 1, 5},
                   {3, 1, 5},
                   {3, 3, 5},
                   {0, 3, 5}});
        std::vector<dvec3> star;
        for (int i = 0; i < 40; ++i) {
            const double r = i % 2 == 0 ? 1 : 0.3;
            star.emplace_back(1000 + r * std::cos(i * 0.15707963), 7, r * std::sin(i * 0.15707963));
        }
        check_cut(star);
    }

    TEST_CASE("a degenerate polygon still gives its number of triangles") {
        CHECK(detail::triangulate_polygon(std::vector<dvec3>(7, dvec3(1, 2, 3))).size() == 5);
        const std::vector<dvec3> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
        CHECK(detail::triangulate_polygon(line).size() == 2);
    }
}
