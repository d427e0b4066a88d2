#include <billow/core/progress.hpp>

#include <string>
#include <vector>

#include <doctest/doctest.h>

TEST_SUITE("core/progress") {
    TEST_CASE("a report reaches the listener, and nobody need listen") {
        std::vector<std::string> heard;
        billow::report([&](std::string_view stage, double) { heard.emplace_back(stage); }, "bake",
                       0.5);
        billow::report({}, "bake", 0.6);
        CHECK(heard == std::vector<std::string>{"bake"});
    }
}
