// The fitters, by face.
#include <billow/fit/average.hpp>
#include <billow/fit/least_squares.hpp>
#include <billow/fit/svd.hpp>

#include "bench.hpp"

namespace {

using namespace billow;

const bool fit_rows = [] {
    const auto row = [](const char* family, std::size_t size, const auto& fitter) {
        bench::add_row(family, size, "scalar", 1, [=](benchmark::State& state) {
            const face_table& faces = bench::leaves(size).faces;
            bench::repeat(state, bench::ns_per_face(size),
                          [&] { benchmark::DoNotOptimize(fitter(faces, plane{})); });
        });
    };
    for (const std::size_t size : {1'000u, 10'000u}) {
        row("fit.average/leaf_soup", size, average_fit{});
        row("fit.svd/leaf_soup", size, svd_fit{});
        row("fit.least_squares/leaf_soup", size, least_squares_fit{});
    }
    return true;
}();

}  // namespace
