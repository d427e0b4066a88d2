#include <billow/mesh/validate.hpp>

#include <doctest/doctest.h>

#include <limits>

using namespace billow;

namespace {

mesh strip_of(std::uint32_t faces) {
    mesh m;
    for (std::uint32_t i = 0; i < faces + 2; ++i) {
        m.positions.emplace_back(static_cast<float>(i), static_cast<float>(i % 2), 0.0f);
    }
    for (std::uint32_t i = 0; i < faces; ++i) m.triangles.emplace_back(i, i + 1, i + 2);
    return m;
}

}  // namespace

TEST_SUITE("mesh/validate") {
    TEST_CASE("a mesh of nothing and one of degenerate faces are valid") {
        CHECK(validate(mesh{}));
        mesh m = strip_of(1);
        m.triangles.emplace_back(0u, 0u, 0u);
        CHECK(validate(m));
    }

    TEST_CASE("names the first face with a position that is not finite") {
        for (const float bad :
             {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
            mesh m = strip_of(100'000);
            m.positions[70'002].y = bad;
            m.positions[99'000].x = bad;
            for (const unsigned threads : {1u, 2u, 3u}) {
                const auto checked = validate(m, {threads});
                REQUIRE_FALSE(checked);
                CHECK(checked.error().code == error_code::not_finite);
                CHECK(checked.error().message.find("face 70000 ") != std::string::npos);
            }
        }
    }

    TEST_CASE("a vertex that no face uses may be anything") {
        mesh m = strip_of(3);
        m.positions.emplace_back(std::numeric_limits<float>::quiet_NaN());
        CHECK(validate(m));
    }

    TEST_CASE("rejects an index past the last vertex") {
        mesh m = strip_of(3);
        m.triangles[1].z = 5;
        const auto checked = validate(m);
        REQUIRE_FALSE(checked);
        CHECK(checked.error().code == error_code::out_of_range);
        CHECK(checked.error().message.find("face 1 ") != std::string::npos);
    }

    TEST_CASE("rejects columns of another length than their owner's") {
        mesh m = strip_of(3);
        m.uv_sets[1].resize(4);
        CHECK_FALSE(validate(m));
        m = strip_of(3);
        m.face_materials.resize(2);
        CHECK_FALSE(validate(m));
    }
}
