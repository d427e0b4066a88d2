#include <billow/metrics/sample_view.hpp>

#include <doctest/doctest.h>

#include <billow/core/random.hpp>

#include "support/meshes.hpp"

namespace {

using namespace billow;

std::array<vec3, 3> random_corners(random_stream& random) {
    std::array<vec3, 3> corners;
    for (vec3& corner : corners) corner = vec3(support::random_direction(random));
    return corners;
}

}  // namespace

TEST_SUITE("metrics/sample_view") {
    TEST_CASE("the middle of the view is the middle of the grid, up is towards row 0") {
        const camera from = perspective_camera({1, 2, 8}, {1, 2, 3}, 0.7, 30, 20);
        const sample_view view(from, 2);
        const dvec3 middle = view.project({1, 2, 3});
        CHECK(middle.x / middle.z == doctest::Approx(30));
        CHECK(middle.y / middle.z == doctest::Approx(20));
        CHECK(middle.z == doctest::Approx(5));
        const dvec3 top = view.project(dvec3(1, 2 + 5 * std::tan(0.35), 3));
        CHECK(top.y / top.z == doctest::Approx(0));
        CHECK(glm::length(view.toward_viewer({30, 20}) - vec3(0, 0, 1)) < 1e-6f);
    }

    TEST_CASE("shares are those of the point that a ray meets, in perspective or not") {
        random_stream random(3);
        for (int i = 0; i < 100; ++i) {
            const dvec3 from = support::random_direction(random);
            const bool is_flat = i % 2 == 0;
            const sample_view view(
                is_flat ? view_of({dvec3(0), 1}, from) : orbit_camera({dvec3(0), 1}, from, 2), 4);
            const std::array<vec3, 3> corners = random_corners(random);
            const face_gradients face(view, corners);
            const dvec3 weights = glm::normalize(dvec3(random.unit(), random.unit(), 0.1));
            const dvec3 share = weights / (weights.x + weights.y + weights.z);
            const dvec3 point = dvec3(corners[0]) * share.x + dvec3(corners[1]) * share.y +
                                dvec3(corners[2]) * share.z;
            const dvec3 p = view.project(point);
            const dvec2 sample(p.x / p.z - 0.5, p.y / p.z - 0.5);
            const double inverse = face.inverse_w.at(sample.x, sample.y);
            CHECK(inverse * p.z == doctest::Approx(1));
            for (int k = 0; k < 3; ++k) {
                const double at = face.share[static_cast<std::size_t>(k)].at(sample.x, sample.y);
                CHECK(at / inverse == doctest::Approx(share[k]));
            }
            const double distance = glm::dot(
                (is_flat ? dvec3(0) : glm::normalize(from) * 2.0) - point, glm::normalize(from));
            CHECK(view.distance_of(face.nearness.at(sample.x, sample.y)) ==
                  doctest::Approx(distance));
            const vec3 toward = view.toward_viewer(sample + 0.5);
            const dvec3 expected =
                is_flat ? glm::normalize(from) : glm::normalize(glm::normalize(from) * 2.0 - point);
            CHECK(glm::length(toward - vec3(expected)) < 1e-5f);
        }
    }

    TEST_CASE("the area of a small face is what it covers") {
        const sample_view view(orbit_camera({dvec3(0), 1}, {0, 0, 1}), 4);
        const std::array<vec3, 3> corners{vec3(0.5f, 0.4f, 0), vec3(0.51f, 0.4f, 0),
                                          vec3(0.5f, 0.42f, 0)};
        const face_gradients face(view, corners);
        std::array<dvec2, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            const dvec3 h = view.project(dvec3(corners[k]));
            p[k] = dvec2(h) / h.z;
        }
        const dvec2 a = p[1] - p[0];
        const dvec2 b = p[2] - p[0];
        CHECK(face.area_at(face.middle()) ==
              doctest::Approx(0.5 * std::abs(a.x * b.y - a.y * b.x)).epsilon(1e-3));
        CHECK_FALSE(face.is_foreshortened());
    }

    TEST_CASE("a face without area changes nothing") {
        const sample_view view(orbit_camera({dvec3(0), 1}, {0, 0, 1}), 1);
        const face_gradients face(view, {vec3(0), vec3(0), vec3(1, 0, 0)});
        CHECK(face.area_at(1) == 0);
    }
}
