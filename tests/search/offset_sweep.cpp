#include <billow/search/offset_sweep.hpp>

#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <billow/search/face_sets.hpp>
#include <billow/shapes/leaf_soup.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

constexpr double nothing = -std::numeric_limits<double>::infinity();

/// A sweep with the policies that it refers to.
template <class Contribution = projected_area, class Penalty = no_penalty>
struct swept_faces {
    face_table faces;
    double epsilon;
    Contribution worth{};
    Penalty penalty{};
    offset_sweep<Contribution, Penalty> sweep{worth, penalty, epsilon, faces.bounds.radius,
                                              density_scale(faces)};
    sweep_scratch scratch{};
    std::vector<std::int64_t> buckets{};

    swept_offset best(const vec3& normal, double than = nothing) {
        return sweep.best(faces, normal, {1, sweep.charge()}, than, buckets, scratch);
    }
    /// What is counted at an offset, face by face.
    swept_offset at(const vec3& normal, float rho) const {
        swept_offset sum{rho, 0, 0, 0, true};
        const auto eps = static_cast<float>(epsilon);
        const vec3_lanes<float> n = fill_lanes<float>(normal);
        for (std::size_t row = 0; row < faces.size; ++row) {
            const face_lanes<float> face = load_faces<float>(faces, row);
            const offset_interval<float> valid = valid_offsets(face, n, eps);
            if (valid.low > valid.high) continue;
            const auto weight = static_cast<std::int64_t>(worth(face, n) *
                                                          static_cast<float>(density_scale(faces)));
            if (valid.low <= rho && rho <= valid.high) sum.contribution += weight;
            // The side of the plane decides; below 0 all is mirrored.
            const bool is_mirrored = rho < 0;
            const offset_interval<float> charged =
                is_mirrored ? penalty(offset_interval<float>{-valid.high, -valid.low}, eps)
                            : penalty(valid, eps);
            const float offset = is_mirrored ? -rho : rho;
            if (charged.low <= offset && offset < charged.high) sum.penalty += weight;
        }
        sum.density = density_reading{1, sweep.charge()}(sum.contribution, sum.penalty);
        return sum;
    }
    /// The best of all ends of valid and charged offsets, of the points just beside them, and of
    /// what lies halfway between two.
    double most(const vec3& normal) const {
        std::vector<float> ends{0.0f};
        const auto eps = static_cast<float>(epsilon);
        for (std::size_t row = 0; row < faces.size; ++row) {
            const offset_interval<float> valid =
                valid_offsets(load_faces<float>(faces, row), fill_lanes<float>(normal), eps);
            for (const float end : {valid.low, valid.high, valid.low - eps, valid.high + eps}) {
                ends.push_back(end);
            }
        }
        std::sort(ends.begin(), ends.end());
        double best = nothing;
        const auto look = [&](float rho) {
            const swept_offset here = at(normal, rho);
            if (here.contribution > 0) best = std::max(best, here.density);
        };
        for (std::size_t i = 0; i < ends.size(); ++i) {
            look(ends[i]);
            look(std::nextafter(ends[i], -10.0f));
            look(std::nextafter(ends[i], 10.0f));
            if (i > 0) look((ends[i] + ends[i - 1]) / 2);
        }
        return best;
    }
};

template <class Contribution, class Penalty>
void check_against_all_ends(mesh m, double share, const Contribution& worth,
                            const Penalty& penalty) {
    face_table faces = support::table_of(m);
    const double epsilon = share * faces.bounds.radius;
    swept_faces<Contribution, Penalty> of{std::move(faces), epsilon, worth, penalty};
    random_stream random(3);
    for (int i = 0; i < 8; ++i) {
        const vec3 normal(i < 3 ? dvec3(i == 0, i == 1, i == 2)
                                : support::random_direction(random));
        const swept_offset best = of.best(normal);
        const double most = of.most(normal);
        if (most == nothing) {
            CHECK_FALSE(best.is_found);
            continue;
        }
        REQUIRE(best.is_found);
        CHECK(best.density == most);
        const swept_offset there = of.at(normal, best.rho);
        CHECK(there.contribution == best.contribution);
        CHECK(there.penalty == best.penalty);
    }
}

}  // namespace

TEST_SUITE("search/offset_sweep") {
    TEST_CASE("the swept offset is the best of all ends of intervals") {
        for (const double share : {0.3, 0.1, 0.02}) {
            check_against_all_ends(leaf_soup(120), share, projected_area{}, no_penalty{});
            check_against_all_ends(support::random_triangles(90, 0.3, 5), share, angular_area{},
                                   no_penalty{});
            check_against_all_ends(leaf_soup(90), share, within_angle(projected_area{}, 40),
                                   no_penalty{});
        }
    }
    TEST_CASE("the same where penalties are charged") {
        for (const double weight : {0.5, 3.0, 10.0}) {
            check_against_all_ends(leaf_soup(80), 0.1, projected_area{},
                                   inner_side_penalty{weight});
            check_against_all_ends(support::random_triangles(60, 0.2, 8), 0.3, projected_area{},
                                   inner_side_penalty{weight});
        }
    }
    TEST_CASE("equal ends and coinciding faces count as closed intervals") {
        mesh m;
        for (const float z : {-0.1f, 0.1f, 0.1f, 0.3f}) {
            support::add_square(m, {0, 0, z}, {0.5f, 0, 0}, {0, 0.5f, 0});
        }
        check_against_all_ends(m, 0.2, projected_area{}, no_penalty{});
    }
    TEST_CASE("no offset of a row has more than its bound") {
        face_table faces = support::table_of(leaf_soup(400));
        swept_faces<projected_area, inner_side_penalty> of{std::move(faces), 0.1};
        for (const double charge : {0.0, 3.0}) {
            random_stream random(9);
            for (int i = 0; i < 20; ++i) {
                const vec3 normal(support::random_direction(random));
                const density_reading read{0.7, charge};
                const swept_offset best =
                    of.sweep.best(of.faces, normal, read, nothing, of.buckets, of.scratch);
                const std::span all(of.buckets);
                const std::size_t length = of.sweep.row_size();
                const offset_row row{all.first(length), all.subspan(length)};
                CHECK(of.sweep.bound(row, read) >= best.density);
                if (charge == 0) CHECK(of.sweep.bound(row, read) <= 1.25 * best.density);
                CHECK_FALSE(
                    of.sweep.best(of.faces, normal, row, read, best.density, of.scratch).is_found);
                CHECK(of.sweep
                          .best(of.faces, normal, row, read, std::nextafter(best.density, nothing),
                                of.scratch)
                          .density == best.density);
            }
        }
    }
    TEST_CASE("what is taken out of a row leaves it as if it had never been there") {
        const face_table faces = support::table_of(leaf_soup(500));
        const projected_area worth;
        const inner_side_penalty penalty;
        const offset_sweep sweep(worth, penalty, 0.1, faces.bounds.radius, density_scale(faces));
        std::vector<std::int64_t> c(sweep.row_size()), p(sweep.row_size());
        detail::offset_block block;
        const vec3 normal = glm::normalize(vec3(0.2f, 0.5f, -0.4f));
        sweep.change(faces, 0, faces.padded_size(), normal, density_change::add, {c, p}, block);
        CHECK(std::ranges::any_of(c, [](std::int64_t v) { return v != 0; }));
        CHECK(std::ranges::any_of(p, [](std::int64_t v) { return v != 0; }));
        sweep.change(faces, 0, faces.padded_size(), normal, density_change::remove, {c, p}, block);
        CHECK(std::ranges::all_of(c, [](std::int64_t v) { return v == 0; }));
        CHECK(std::ranges::all_of(p, [](std::int64_t v) { return v == 0; }));
    }
    TEST_CASE("a focused sweep finds what lies between its offsets") {
        face_table faces = support::table_of(leaf_soup(600));
        swept_faces<> of{std::move(faces), 0.1};
        const vec3 normal = glm::normalize(vec3(0.6f, -0.5f, 0.4f));
        const swept_offset best = of.best(normal);
        const auto rho = static_cast<double>(best.rho);
        const swept_offset near = of.sweep.focused(rho - 0.05, rho + 0.05)
                                      .best(of.faces, normal, {}, nothing, of.buckets, of.scratch);
        CHECK(near.density == best.density);
        CHECK(near.rho == best.rho);
        const swept_offset away = of.sweep.focused(rho + 0.2, rho + 0.3)
                                      .best(of.faces, normal, {}, nothing, of.buckets, of.scratch);
        CHECK(away.density < best.density);
        CHECK(static_cast<double>(away.rho) > rho + 0.19);
        CHECK(away.density == of.at(normal, away.rho).density);
    }
    TEST_CASE("the nearest offset keeps all faces and lies in the larger") {
        mesh m;
        support::add_square(m, {0, 0, 0.30f}, {0.5f, 0, 0}, {0, 0.5f, 0});
        support::add_square(m, {0, 0, 0.36f}, {0.6f, 0, 0}, {0, 0.5f, 0});
        support::add_square(m, {0, 0, -0.9f}, {0.1f, 0, 0}, {0, 0.1f, 0});
        face_table faces = support::table_of(m);
        const double z = faces.bounds.centre.z;
        swept_faces<> flat{std::move(faces), 0.1};
        const swept_offset best = flat.best({0, 0, 1});
        const double nearest = flat.sweep.nearest(flat.faces, {0, 0, 1}, best.rho, flat.scratch);
        CHECK(nearest == doctest::Approx(0.36 - z));

        swept_faces<projected_area, inner_side_penalty> charged{support::table_of(leaf_soup(500)),
                                                                0.1};
        random_stream random(4);
        for (int i = 0; i < 20; ++i) {
            const vec3 normal(support::random_direction(random));
            const swept_offset found = charged.best(normal);
            const double rho =
                charged.sweep.nearest(charged.faces, normal, found.rho, charged.scratch);
            const swept_offset there = charged.at(normal, static_cast<float>(rho));
            CHECK(there.density >= found.density);
        }
    }
    TEST_CASE("faces wider than two epsilons, and no faces, give no offset") {
        swept_faces<> big{support::table_of(support::random_triangles(10, 0.9, 2)), 1e-4};
        CHECK_FALSE(big.best(glm::normalize(vec3(1, 1, 1))).is_found);
        swept_faces<> none{face_table{.bounds = {.centre = dvec3(0), .radius = 1}}, 0.1};
        CHECK_FALSE(none.best({1, 0, 0}).is_found);
    }
}
