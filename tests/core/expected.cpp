#include <billow/core/expected.hpp>

#include <memory>
#include <string>

#include <doctest/doctest.h>

using billow::done;
using billow::error;
using billow::error_code;
using billow::expected;

TEST_SUITE("core/expected") {
    TEST_CASE("holds a value") {
        expected<std::string> e(std::string("seven"));
        CHECK(e.has_value());
        CHECK(static_cast<bool>(e));
        CHECK(*e == "seven");
        CHECK(e->size() == 5);
    }
    TEST_CASE("holds an error") {
        const expected<int> e(error{error_code::malformed, "line 3: no number"});
        CHECK_FALSE(e.has_value());
        CHECK(e.error().code == error_code::malformed);
        CHECK(e.error().message == "line 3: no number");
    }
    TEST_CASE("a value that cannot be copied can be moved out") {
        expected<std::unique_ptr<int>> e(std::make_unique<int>(7));
        const std::unique_ptr<int> taken = *std::move(e);
        CHECK(*taken == 7);
    }
    TEST_CASE("a value of the error's own type stays a value") {
        const expected<done> e{done{}};
        CHECK(e.has_value());
    }
}
