#include <billow/core/jobs.hpp>

#include <atomic>
#include <vector>

#include <doctest/doctest.h>

TEST_SUITE("core/jobs") {
    TEST_CASE("every job is done once, and no scratch serves two jobs at a time") {
        struct scratch {
            std::atomic<int> users{0};
            scratch() = default;
            scratch(const scratch&) {}
        };
        for (const unsigned threads : {1u, 2u, 5u}) {
            std::vector<scratch> scratches(threads);
            std::vector<std::atomic<int>> done(200);
            std::atomic<bool> is_shared = false;
            billow::for_jobs({threads}, done.size(), scratches, [&](std::size_t job, scratch& own) {
                if (++own.users != 1) is_shared = true;
                ++done[job];
                --own.users;
            });
            CHECK_FALSE(is_shared);
            for (const auto& count : done) CHECK(count == 1);
        }
    }
    TEST_CASE("no jobs call nothing") {
        std::vector<int> scratches(2);
        billow::for_jobs({}, 0, scratches, [](std::size_t, int& called) { called = 1; });
        CHECK(scratches == std::vector<int>{0, 0});
    }
}
