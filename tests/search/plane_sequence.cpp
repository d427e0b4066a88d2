#include <billow/search/plane_sequence.hpp>

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "support/meshes.hpp"

using namespace billow;

namespace {

/// Squares of area 1, 2, 3 and so on, two radii apart along z.
mesh steps(int count) {
    mesh m;
    for (int i = 0; i < count; ++i) {
        const float half = std::sqrt(static_cast<float>(i + 1)) / 2;
        support::add_square(m, {0, 0, static_cast<float>(2 * i)}, {half, 0, 0}, {0, half, 0});
    }
    return m;
}

/// Always chooses the plane of the first face that is left, and notes what it is told.
struct first_face_chooser {
    std::size_t known = 0;
    std::size_t planes = 0;

    void change(const face_table& faces, density_change change) {
        known += change == density_change::add ? faces.size : 0 - faces.size;
    }
    void faces_taken(const face_table& leaving, const face_table& remaining) {
        known -= leaving.size;
        CHECK(known == remaining.size);
    }
    [[nodiscard]] plane find_plane(const face_table& remaining, greedy_statistics&) const {
        CHECK(known == remaining.size);
        return supporting_plane(remaining, 0);
    }
    void plane_found(const plane&) noexcept { ++planes; }
};

greedy_result run(const mesh& m, detail::sequence_options options, first_face_chooser& chooser) {
    options.epsilon = 0.01;
    const pipeline parts{};
    return detail::plane_sequence(support::table_of(m), parts, options, {})
        .run(m.face_count(), chooser, {});
}

}  // namespace

TEST_SUITE("search/plane_sequence") {
    TEST_CASE("planes come in the order of choice, with the area that they cover so far") {
        first_face_chooser chooser;
        const greedy_result r = run(steps(4), {}, chooser);
        CHECK(chooser.planes == 4);
        CHECK(r.cloud.plane_of_face == std::vector<plane_id>{0, 0, 1, 1, 2, 2, 3, 3});
        REQUIRE(r.covered_area.size() == 4);
        for (int i = 0; i < 4; ++i) {
            const double covered = (i + 1) * (i + 2) / 2 / 10.0;
            CHECK(r.covered_area[static_cast<std::size_t>(i)] == doctest::Approx(covered));
        }
    }
    TEST_CASE("area left, least contribution and number of planes end it") {
        first_face_chooser a, b, c;
        CHECK(run(steps(4), {.skip_area = 0.5}, a).cloud.plane_count() == 3);  // 0.6 ≥ 0.5
        CHECK(run(steps(4), {.min_contribution = 0.25}, b).cloud.plane_count() == 1);
        const greedy_result r = run(steps(4), {.max_planes = 2}, c);
        CHECK(r.cloud.plane_count() == 2);
        CHECK(r.statistics.leftover_faces == 4);
        CHECK(r.statistics.beyond_epsilon_area_share == doctest::Approx(0.7));
        CHECK(r.cloud.plane_of_face == std::vector<plane_id>{0, 0, 1, 1, 1, 1, 1, 1});
    }
}
