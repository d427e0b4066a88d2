#include <billow/density/falloff_kernel.hpp>

#include <doctest/doctest.h>

#include <billow/policy/falloff.hpp>

using namespace billow;
using billow::detail::falloff_kernel;

namespace {

/// What a face of one unit adds to the bins of a row, low end and length in quarters of a bin.
std::vector<double> bins_of(const falloff_kernel& kernel, int bin_count, int low, int length) {
    std::vector<ramp> row(static_cast<std::size_t>(bin_count));
    const int key = (low + kernel.lead() * falloff_kernel::parts) * kernel.lengths() + length;
    kernel.add(static_cast<std::size_t>(key), 1, row);
    std::vector<double> bins;
    for (const ramp& r : row) {
        CHECK(r.step == 0);
        bins.push_back(-static_cast<double>(r.before) / falloff_kernel::unit);
    }
    return bins;
}

}  // namespace

TEST_SUITE("density/falloff_kernel") {
    TEST_CASE("bins whose centres are valid count by their distance, half a bin is free") {
        // Epsilon is 1.5 bins; valid from 1.25 to 4.25, so the middle is 2.75.
        const falloff_kernel kernel(distance_falloff{}, 1.5, 5, 6);
        const auto bins = bins_of(kernel, 6, 5, 12);
        const auto weight = [](double aside) { return 1.5 / (std::max(0.0, aside - 0.5) + 1.5); };
        CHECK(bins[0] == 0);
        CHECK(bins[1] == doctest::Approx(weight(1.25)).epsilon(1e-3));
        CHECK(bins[2] == doctest::Approx(1));
        CHECK(bins[3] == doctest::Approx(weight(0.75)).epsilon(1e-3));
        CHECK(bins[4] == 0);  // touched, but its centre is not valid
        CHECK(bins[5] == 0);
    }
    TEST_CASE("an interval between two centres counts in the bin of its middle") {
        const falloff_kernel kernel(distance_falloff{}, 1.5, 5, 6);
        const auto bins = bins_of(kernel, 6, 7, 2);  // from 1.75 to 2.25
        CHECK(bins[2] == 1);
        CHECK(bins[1] == 0);
        CHECK(bins[3] == 0);
    }
    TEST_CASE("what lies beyond the axis is left out, every key stays within the row") {
        const falloff_kernel kernel(distance_falloff{}, 1.5, 5, 6);
        CHECK(bins_of(kernel, 6, -10, 12)[0] > 0);
        for (const double b : bins_of(kernel, 6, -16, 8)) CHECK(b == 0);
        std::vector<ramp> row(6);
        for (std::size_t key = 0; key < kernel.key_count(); ++key) kernel.add(key, 1, row);
        for (const ramp& r : row) CHECK(r.before < 0);
    }
    TEST_CASE("without a falloff there is no kernel") { CHECK(falloff_kernel{}.empty()); }
}
