#include <billow/metrics/coverage_error.hpp>

#include <doctest/doctest.h>

#include "support/pictures.hpp"

using namespace billow;

TEST_SUITE("metrics/coverage_error") {
    TEST_CASE("a picture differs in nothing from itself") {
        for (const view_picture& p : {support::square_at(5, 5), support::random_picture(13, 7, 1),
                                      support::empty_picture(4, 4), view_picture{}}) {
            const coverage_errors e = coverage_error(p, p);
            CHECK(e.error == 0);
            CHECK(e.missing == 0);
            CHECK(e.extra == 0);
            CHECK(e.extra_of_cloud == 0);
        }
    }
    TEST_CASE("a mask shifted by a pixel misses a column of twenty and adds one") {
        const auto e = coverage_error(support::square_at(5, 5), support::square_at(6, 5));
        CHECK(e.error == doctest::Approx(2.0 / 20));
        CHECK(e.missing == doctest::Approx(1.0 / 20));
        CHECK(e.extra == doctest::Approx(1.0 / 20));
    }
    TEST_CASE("shifted by half a pixel it is half of that") {
        view_picture shifted = support::square_at(5, 5);
        support::fill(shifted, 5, 5, 1, 20, {0.1f, 0.25f, 0.05f, 0.5f});
        support::fill(shifted, 25, 5, 1, 20, {0.1f, 0.25f, 0.05f, 0.5f});
        CHECK(coverage_error(support::square_at(5, 5), shifted).error == doctest::Approx(1.0 / 20));
    }
    TEST_CASE("what is too much relates to the original and to the cloud") {
        view_picture larger = support::square_at(5, 5);
        support::fill(larger, 5, 25, 20, 5, {0, 0, 0, 1});
        const auto e = coverage_error(support::square_at(5, 5), larger);
        CHECK(e.missing == 0);
        CHECK(e.extra == doctest::Approx(0.25));
        CHECK(e.extra_of_cloud == doctest::Approx(0.2));
    }
    TEST_CASE("without a cloud all is missing, without an original all is too much") {
        const auto nothing = support::empty_picture(32, 32);
        const auto none = coverage_error(support::square_at(5, 5), nothing);
        CHECK(none.error == 1);
        CHECK(none.missing == 1);
        CHECK(none.extra == 0);
        CHECK(none.extra_of_cloud == 0);
        const auto all = coverage_error(nothing, support::square_at(5, 5));
        CHECK(all.error == 1);
        CHECK(all.missing == 0);
        CHECK(all.extra == 1);
    }
    TEST_CASE("coverage in sixteenths is that of a mask of samples where one holds the other") {
        // Sixteen samples a pixel; the cloud lacks some of the original's and adds none.
        random_stream random(4);
        view_picture a = support::empty_picture(9, 9);
        view_picture b = a;
        int in_a = 0;
        int in_b = 0;
        for (std::size_t i = 0; i < a.pixels.size(); ++i) {
            const int more = static_cast<int>(random.unit() * 17);
            const int less = static_cast<int>(random.unit() * (more + 1));
            in_a += more;
            in_b += less;
            a.pixels[i].a = static_cast<float>(more) / 16;
            b.pixels[i].a = static_cast<float>(less) / 16;
        }
        const auto e = coverage_error(a, b);
        CHECK(e.error == doctest::Approx(static_cast<double>(in_a - in_b) / in_a));
        CHECK(e.extra == 0);
    }
    TEST_CASE("the error is the sum of its parts, and its parts change places with the pictures") {
        const auto a = support::random_picture(17, 11, 2);
        const auto b = support::random_picture(17, 11, 3);
        const auto e = coverage_error(a, b);
        const auto back = coverage_error(b, a);
        CHECK(e.error == doctest::Approx(e.missing + e.extra));
        CHECK(e.extra_of_cloud == doctest::Approx(back.missing));
    }
}
