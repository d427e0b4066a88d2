#include <billow/search/plane_budget.hpp>

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <billow/cloud/measure.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/teapot.hpp>

#include "support/meshes.hpp"

using namespace billow;

namespace {

constexpr auto itself = [](std::size_t planes) { return planes; };

/// Planes that fall with a power of epsilon, and wobble.
std::size_t planes_at(double epsilon, double factor, double power, double wobble) {
    return 1 + static_cast<std::size_t>(factor * std::pow(epsilon, -power) *
                                        (1 + wobble * std::sin(40 * std::log(epsilon))));
}

}  // namespace

TEST_SUITE("search/plane_budget") {
    TEST_CASE("a count that falls as a power of epsilon is met in few searches") {
        for (const double power : {0.7, 1.0, 1.5, 2.0, 2.5}) {
            for (const double factor : {0.01, 0.3, 2.0}) {
                for (const std::size_t wanted : {10u, 40u, 120u, 600u}) {
                    int calls = 0;
                    const auto search = [&](double epsilon, std::size_t limit) {
                        ++calls;
                        return std::min(planes_at(epsilon, factor, power, 0), limit + 1);
                    };
                    const auto found = search_for_planes(wanted, 1, search, itself);
                    // Epsilon may have to leave [1e-4, 1] for it.
                    const std::size_t least = planes_at(1, factor, power, 0);
                    const std::size_t most = planes_at(1e-4, factor, power, 0);
                    const auto goal = static_cast<double>(std::clamp(wanted, least, most));
                    CHECK(std::abs(static_cast<double>(found.planes) - goal) <=
                          std::max(1.0, 0.03 * goal));
                    CHECK(found.planes == found.result);
                    CHECK(found.searches == calls);
                    CHECK(calls <= 11);
                }
            }
        }
    }
    TEST_CASE("the nearest of all results is kept, also where counts wobble") {
        for (const std::size_t wanted : {7u, 33u, 90u}) {
            std::vector<std::size_t> seen;
            const auto search = [&](double epsilon, std::size_t limit) {
                const std::size_t planes = planes_at(epsilon / 5, 0.5, 1.3, 0.25);
                if (planes <= limit) seen.push_back(planes);
                return std::min(planes, limit + 1);
            };
            const auto found = search_for_planes(wanted, 5, search, itself, {.tolerance = 0});
            const auto miss = [&](std::size_t n) { return n > wanted ? n - wanted : wanted - n; };
            for (const std::size_t n : seen) CHECK(miss(found.planes) <= miss(n));
        }
    }
    TEST_CASE("of two results as near, the one with fewer planes is given") {
        const auto search = [](double epsilon, std::size_t) {
            return std::size_t{epsilon < 0.05 ? 12u : 8u};
        };
        CHECK(search_for_planes(10, 1, search, itself).planes == 8);
        CHECK(search_for_planes(10, 1, search, itself, {.first_epsilon = 0.01}).planes == 8);
    }
    TEST_CASE("a number out of reach gives what the ends of the range give") {
        const auto search = [](double, std::size_t limit) {
            return std::min<std::size_t>(1000, limit + 1);
        };
        CHECK(search_for_planes(3, 1, search, itself).planes == 1000);
        const auto few = [](double, std::size_t) { return std::size_t{6}; };
        CHECK(search_for_planes(500, 1, few, itself).planes == 6);
    }
    TEST_CASE("a greedy search for so many planes finds about that many, within its epsilon") {
        const mesh pot = teapot(3);
        const mesh soup = leaf_soup(600, {.edge = 0.1f});
        for (const mesh* m : {&pot, &soup}) {
            const face_table faces = support::table_of(*m);
            const auto find = [&](std::size_t wanted, unsigned threads) {
                return greedy_search_for_planes(faces, m->face_count(), wanted, {},
                                                pipeline{cube_map{10}}, {threads});
            };
            for (const std::size_t wanted : {8u, 25u}) {
                const auto found = find(wanted, 1);
                CHECK(found.planes == found.result.cloud.plane_count());
                CHECK(found.planes >= wanted - 2);
                CHECK(found.planes <= wanted + 2);
                const cloud_errors e = measure_errors(*m, found.result.cloud);
                CHECK(e.mapped_faces == m->face_count());
                CHECK(e.faces_beyond_epsilon == 0);
                CHECK(found.result.cloud.epsilon == found.epsilon);
                const auto again = find(wanted, 3);
                CHECK(again.epsilon == found.epsilon);
                CHECK(again.result.cloud.planes == found.result.cloud.planes);
            }
        }
    }
    TEST_CASE("a table without faces gives no planes; progress ends at 1") {
        const auto none =
            greedy_search_for_planes(support::table_of(mesh{}), 0, 5, {}, pipeline{cube_map{8}});
        CHECK(none.result.cloud.plane_count() == 0);
        double last = 0;
        const mesh m = leaf_soup(100);
        (void)greedy_search_for_planes(support::table_of(m), m.face_count(), 5, {},
                                       pipeline{cube_map{8}}, {},
                                       [&](std::string_view, double share) {
                                           CHECK(share >= last);
                                           last = share;
                                       });
        CHECK(last == 1);
    }
}
