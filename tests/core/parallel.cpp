#include <billow/core/parallel.hpp>

#include <atomic>
#include <vector>

#include <doctest/doctest.h>

TEST_SUITE("core/parallel") {
    TEST_CASE("every index is visited once, in chunks of the given size, for any thread count") {
        for (const unsigned threads : {1u, 2u, 3u, 8u}) {
            for (const std::size_t size : {0u, 1u, 9u, 10u, 11u, 1000u}) {
                std::vector<std::atomic<int>> visits(size);
                std::atomic<bool> is_aligned = true;
                billow::parallel{threads}.for_chunks(size, 10, [&](std::size_t a, std::size_t b) {
                    if (a % 10 != 0 || b <= a || b - a > 10) is_aligned = false;
                    for (std::size_t i = a; i < b; ++i) ++visits[i];
                });
                CHECK(is_aligned);
                for (const auto& count : visits) CHECK(count == 1);
            }
        }
    }
    TEST_CASE("at least one thread is promised, and as many as asked for") {
        CHECK(billow::parallel{}.count() >= 1);
#if defined(_OPENMP)
        CHECK(billow::parallel{3}.count() == 3);
#endif
    }
}
