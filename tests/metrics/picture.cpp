#include <billow/metrics/picture.hpp>

#include <doctest/doctest.h>

#include <billow/shapes/box.hpp>

namespace {

using namespace billow;

const bounding_sphere unit_cube{dvec3(0), 0.8661};

}  // namespace

TEST_SUITE("metrics/picture") {
    TEST_CASE("a cube seen straight on is a square of its size") {
        const camera view = view_of(unit_cube, {0, 0, 1}, 100, 100);
        const image picture = draw_picture(textured_cube(), view);
        const image empty = draw_picture(mesh{}, view);
        int covered = 0;
        for (int y = 0; y < 100; ++y) {
            for (int x = 0; x < 100; ++x) {
                covered +=
                    !std::equal(picture.pixel(x, y), picture.pixel(x, y) + 3, empty.pixel(x, y));
            }
        }
        const double side = 100 / view.height;
        CHECK(covered == doctest::Approx(side * side).epsilon(0.05));
        // The upper left quarter of a side is its brightest, and +z is blue.
        CHECK(picture.pixel(40, 40)[2] > picture.pixel(60, 60)[2] + 30);
        CHECK(picture.pixel(40, 40)[2] > picture.pixel(40, 40)[0]);
    }

    TEST_CASE("the sides of a cube are where they should be") {
        const auto middle_of = [](const dvec3& from) {
            const image picture = draw_picture(textured_cube(), view_of(unit_cube, from, 64, 64));
            const std::uint8_t* p = picture.pixel(28, 28);
            return std::array<int, 3>{p[0], p[1], p[2]};
        };
        const auto right = middle_of({1, 0, 0});
        CHECK(right[0] > right[1] + 50);
        const auto above = middle_of({0, 1, 0});
        CHECK(above[1] > above[0] + 50);
    }

    TEST_CASE("faces are seen from behind, lit on the side they show") {
        mesh m;
        m.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        m.triangles = {{0, 1, 2}, {0, 2, 3}};
        const image front = draw_picture(m, view_of({dvec3(0), 1}, {0, 0, 1}, 16, 16));
        const image back = draw_picture(m, view_of({dvec3(0), 1}, {0, 0, -1}, 16, 16));
        CHECK(front == back);
    }

    TEST_CASE("threads do not change the picture, and views are right-handed") {
        const camera view = view_of(unit_cube, {1, 2, 3}, 90, 70);
        CHECK(glm::length(glm::cross(view.axes.u, view.axes.v) - view.axes.normal) < 1e-12);
        const mesh cube = textured_cube();
        CHECK(draw_picture(cube, view, {}, {1}) == draw_picture(cube, view, {}, {3}));
    }

    TEST_CASE("two pictures stand side by side") {
        const image a{1, 2, 3, {1, 2, 3, 4, 5, 6}};
        const image b{2, 2, 3, {11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22}};
        const image both = side_by_side(a, b);
        CHECK(both.width == 3);
        CHECK(both.bytes == std::vector<std::uint8_t>{1, 2, 3, 11, 12, 13, 14, 15, 16, 4, 5, 6, 17,
                                                      18, 19, 20, 21, 22});
    }
}
