#include <billow/cloud/plane_order.hpp>

#include <doctest/doctest.h>

#include <billow/mesh/mesh.hpp>

using namespace billow;

namespace {

/// Triangles of areas 1, 4, 2 and 3 halves on planes 0, 1, 2 and 0; the last on none.
struct small_cloud {
    face_table faces;
    billboard_cloud cloud;

    small_cloud() {
        mesh m;
        const float areas[]{1, 4, 2, 3, 2};
        for (const float area : areas) {
            const auto first = static_cast<std::uint32_t>(m.vertex_count());
            m.positions.insert(m.positions.end(), {{0, 0, 0}, {area, 0, 0}, {0, 1, 0}});
            m.triangles.push_back({first, first + 1, first + 2});
        }
        faces = *make_face_table(m);
        cloud.planes = {{{0, 0, 1}, 0.1}, {{0, 0, 1}, 0.2}, {{0, 0, 1}, 0.3}};
        cloud.plane_of_face = {2, 1, 2, 0, no_id};
    }
};

}  // namespace

TEST_SUITE("cloud/plane_order") {
    TEST_CASE("planes of more area come first, and faces stay on theirs") {
        small_cloud of;
        order_planes_by_area(of.faces, of.cloud);
        CHECK(of.cloud.planes[0].rho == 0.2);
        CHECK(of.cloud.planes[1].rho == 0.1);  // equal areas keep their order
        CHECK(of.cloud.planes[2].rho == 0.3);
        CHECK(of.cloud.plane_of_face == std::vector<plane_id>{2, 0, 2, 1, no_id});
    }
    TEST_CASE("shares of the area add up to what is mapped, and errors are means of distances") {
        const small_cloud of;
        const plane_curve curve = curve_of(of.faces, of.cloud);
        REQUIRE(curve.covered_area.size() == 3);
        CHECK(curve.covered_area[0] == doctest::Approx(3.0 / 12));
        CHECK(curve.covered_area[1] == doctest::Approx(7.0 / 12));
        CHECK(curve.covered_area[2] == doctest::Approx(10.0 / 12));
        CHECK(curve.mean_error[0] == doctest::Approx(0.1));
        CHECK(curve.mean_error[1] == doctest::Approx((3 * 0.1 + 4 * 0.2) / 7));
        CHECK(curve.mean_error[2] == doctest::Approx((3 * 0.1 + 4 * 0.2 + 3 * 0.3) / 10));
        CHECK(curve_of({}, {}).covered_area.empty());
    }
}
