#include <billow/core/config.hpp>

#include <string>
#include <type_traits>

#include <doctest/doctest.h>

namespace billow::inline BILLOW_ABI {
struct tagged {};
}  // namespace billow::inline BILLOW_ABI

TEST_SUITE("core/config") {
    TEST_CASE("the tag names lanes and threading") {
        const std::string tag = BILLOW_ABI_NAME;
        CHECK(tag.rfind("v0_", 0) == 0);
#if defined(_OPENMP)
        CHECK(tag.find("_omp") != std::string::npos);
#else
        CHECK(tag.find("_serial") != std::string::npos);
#endif
#if BILLOW_LANES == 1
        CHECK(tag.find("scalar") != std::string::npos);
#endif
    }
    TEST_CASE("the tag is an inline namespace") {
        CHECK(std::is_same_v<billow::tagged, billow::BILLOW_ABI::tagged>);
    }
}
