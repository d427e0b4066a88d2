#include <billow/plants/turtle.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>

using namespace billow;

namespace {

skeleton walked(std::string_view word, const turtle_options& options = {}) {
    auto bones = interpret(word, options);
    REQUIRE(bones);
    return *std::move(bones);
}

void check_near(const dvec3& a, const dvec3& b) { CHECK(glm::distance(a, b) < 1e-12); }

}  // namespace

TEST_SUITE("plants/turtle") {
    TEST_CASE("a stem grows upwards, each segment from the one before") {
        const skeleton s = walked("FF(2)fF");
        REQUIRE(s.segment_count() == 3);
        check_near(s.starts[0], {0, 0, 0});
        check_near(s.ends[1], {0, 3, 0});
        check_near(s.ends[2], {0, 5, 0});
        CHECK(s.parents == std::vector<std::uint32_t>{no_id, 0, no_id});
    }

    TEST_CASE("turns do what the alphabet says") {
        // At the start the left side is -x and the upper side +z.
        const turtle_options right_angle{.angle_deg = 90};
        check_near(walked("+F", right_angle).ends[0], {-1, 0, 0});
        check_near(walked("-F", right_angle).ends[0], {1, 0, 0});
        check_near(walked("&F", right_angle).ends[0], {0, 0, -1});
        check_near(walked("^F", right_angle).ends[0], {0, 0, 1});
        check_near(walked("|F", right_angle).ends[0], {0, -1, 0});
        check_near(walked("/+F", right_angle).ends[0], walked("^F", right_angle).ends[0]);
        check_near(walked(">+F", right_angle).ends[0], walked("/+F", right_angle).ends[0]);
        check_near(walked("<+F", right_angle).ends[0], walked("\\+F", right_angle).ends[0]);
        check_near(walked("/<+F", right_angle).ends[0], walked("+F", right_angle).ends[0]);
        check_near(walked("+(30)F").ends[0], {-0.5, std::sqrt(0.75), 0});
        check_near(walked("-(-30)F").ends[0], {-0.5, std::sqrt(0.75), 0});
    }

    TEST_CASE("after $ the left side is level") {
        const skeleton s = walked("+(20)/(77)&(50)$F");
        CHECK(std::abs(s.frames[0].u.y) < 1e-12);
        check_near(s.frames[0].normal, walked("+(20)/(77)&(50)F").frames[0].normal);
        check_near(walked("$F").ends[0], {0, 1, 0});
    }

    TEST_CASE("brackets bring everything back") {
        const skeleton s = walked("F[+\"F[&FL]]F");
        REQUIRE(s.segment_count() == 4);
        check_near(s.ends[3], {0, 2, 0});
        CHECK(s.parents == std::vector<std::uint32_t>{no_id, 0, 1, 0});
        CHECK(s.leaf_segments == std::vector<std::uint32_t>{2});
    }

    TEST_CASE("the step shrinks by the option or by the number") {
        check_near(walked("\"F", {.shrink = 0.5}).ends[0], {0, 0.5, 0});
        check_near(walked("\"(0.25)F", {.step = 2}).ends[0], {0, 0.5, 0});
    }

    TEST_CASE("children start where their parents end, and frames stay orthonormal") {
        std::string word;
        for (int i = 0; i < 3000; ++i) word += "F+&/^\\-(7)&(3)";
        const skeleton s = walked(
            word,
            {.angle_jitter = 0.3, .length_jitter = 0.3, .wander_deg = 5, .tropism = {0, 0.1, 0}});
        for (std::size_t i = 1; i < s.segment_count(); ++i) {
            REQUIRE(s.starts[i] == s.ends[s.parents[i]]);
            const frame& f = s.frames[i];
            REQUIRE(glm::distance(glm::cross(f.u, f.v), f.normal) < 1e-12);
            REQUIRE(std::abs(glm::dot(f.u, f.v)) < 1e-12);
            REQUIRE(glm::length(f.normal) == doctest::Approx(1).epsilon(1e-12));
        }
    }

    TEST_CASE("tropism bends a branch towards its direction and never past it") {
        const turtle_options light{.tropism = {0, 0.3, 0}};
        const skeleton s = walked("&(80)" + std::string(60, 'F'), light);
        for (std::size_t i = 1; i < s.segment_count(); ++i) {
            REQUIRE(s.frames[i].normal.y > s.frames[i - 1].normal.y - 1e-12);
        }
        CHECK(s.frames.back().normal.y > 0.999);
        CHECK(walked("&(80)FFF", {.tropism = {0, -0.3, 0}}).frames.back().normal.y < 0);
    }

    TEST_CASE("jitter depends on the seed, and stays within its share") {
        const turtle_options loose{.length_jitter = 0.2};
        const std::string word(200, 'F');
        const auto a = interpret(word, loose, 1), b = interpret(word, loose, 1),
                   c = interpret(word, loose, 2);
        CHECK(a->ends == b->ends);
        CHECK(a->ends != c->ends);
        for (std::size_t i = 0; i < 200; ++i) {
            const double length = glm::distance(a->starts[i], a->ends[i]);
            CHECK(length >= 0.8 - 1e-12);
            CHECK(length <= 1.2);
        }
    }

    TEST_CASE("leaves need a twig, segments a length") {
        CHECK(walked("LfLF(0)L").leaf_count() == 0);
        CHECK(walked("F(0)F(-1)").segment_count() == 0);
        CHECK(walked("").segment_count() == 0);
    }

    TEST_CASE("wrong words and options are refused") {
        CHECK(interpret("F]").error().code == error_code::malformed);
        CHECK(interpret("F[").error().code == error_code::malformed);
        for (const char* word : {"F()", "F(.)", "F(1.2.3)", "F(+-1)", "F(1-1)"}) {
            CAPTURE(word);
            const auto bones = interpret(word);
            REQUIRE_FALSE(bones);
            CHECK(bones.error().code == error_code::malformed);
            CHECK(bones.error().message.find("position 1") != std::string::npos);
        }
        CHECK_FALSE(interpret("F", {.step = 0}));
        CHECK_FALSE(interpret("F", {.shrink = -1}));
        CHECK_FALSE(interpret("F", {.angle_deg = std::nan("")}));
        CHECK_FALSE(interpret("F", {.step = std::numeric_limits<double>::infinity()}));
    }
}
