#include <billow/plants/grammar.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace billow;

namespace {

std::size_t count(const std::string& word, char symbol) {
    return static_cast<std::size_t>(std::ranges::count(word, symbol));
}

}  // namespace

TEST_SUITE("plants/grammar") {
    TEST_CASE("n generations of the forest paper's tree give 4^n F and 4^n - 1 L") {
        for (const auto spelling : {third_branch::as_printed, third_branch::turned}) {
            std::size_t power = 1;
            for (unsigned n = 0; n < 7; ++n, power *= 4) {
                const auto word = expand(forest_paper_grammar(spelling), {.generations = n});
                REQUIRE(word);
                CHECK(count(*word, 'F') == power);
                CHECK(count(*word, 'L') == power - 1);
                CHECK(count(*word, '[') == power - 1);
                CHECK(check_brackets(*word));
            }
        }
        CHECK(*expand(forest_paper_grammar(third_branch::as_printed)) == "F[+FL][FL-][>FL]");
        CHECK(*expand(forest_paper_grammar()) == "F[+FL][-FL][>FL]");
    }

    TEST_CASE("algae grow as Lindenmayer wrote") {
        const grammar algae{.axiom = "A", .productions = {{'A', "AB"}, {'B', "A"}}};
        CHECK(*expand(algae, {.generations = 0}) == "A");
        CHECK(*expand(algae, {.generations = 5}) == "ABAABABAABAAB");
    }

    TEST_CASE("arguments go with their symbol and are never rewritten") {
        const grammar rules{.axiom = "A(1)B(-2.5)C(3)", .productions = {{'A', "B(4)"}, {'1', "X"}}};
        CHECK(*expand(rules) == "B(4)B(-2.5)C(3)");
    }

    TEST_CASE("the finish is read once, after the last generation") {
        const grammar rules{
            .axiom = "A", .productions = {{'A', "FA"}}, .finish = {{'A', "LA"}, {'F', "G"}}};
        CHECK(*expand(rules, {.generations = 0}) == "LA");
        CHECK(*expand(rules, {.generations = 3}) == "GGGLA");
    }

    TEST_CASE("weights are the shares of the draws") {
        const grammar rules{.axiom = std::string(20000, 'A'),
                            .productions = {{'A', "X", 3}, {'A', "Y", 1}, {'A', "Z", 0}}};
        const auto word = expand(rules);
        REQUIRE(word);
        CHECK(double(count(*word, 'X')) == doctest::Approx(15000).epsilon(0.02));
        CHECK(count(*word, 'X') + count(*word, 'Y') == 20000);
    }

    TEST_CASE("the seed decides, and a draw depends on its own place only") {
        const grammar rules{.axiom = "AAAAAAAAAAAAAAAA",
                            .productions = {{'A', "XA"}, {'A', "YA"}, {'B', "XB"}, {'B', "YB"}}};
        CHECK(*expand(rules, {.generations = 3, .seed = 5}) ==
              *expand(rules, {.generations = 3, .seed = 5}));
        CHECK(*expand(rules, {.generations = 3, .seed = 5}) !=
              *expand(rules, {.generations = 3, .seed = 6}));
        grammar other = rules;
        other.axiom[0] = 'B';
        const std::string a = *expand(rules), b = *expand(other);
        CHECK(a.substr(2) == b.substr(2));
    }

    TEST_CASE("a bracket without partner is named with its position") {
        const auto position_of = [](std::string_view word) {
            const auto fine = check_brackets(word);
            REQUIRE_FALSE(fine);
            CHECK(fine.error().code == error_code::malformed);
            return fine.error().message;
        };
        CHECK(position_of("F]").find("']' at position 1") != std::string::npos);
        CHECK(position_of("F[+F[L]").find("'[' at position 1") != std::string::npos);
        CHECK(position_of("F(12").find("'(' at position 1") != std::string::npos);
        CHECK(position_of("F(a)").find("'(' at position 1") != std::string::npos);
        CHECK(position_of("FF)").find("')' at position 2") != std::string::npos);
        CHECK(check_brackets(""));
        CHECK(check_brackets("[[]F(1.5)][]"));
    }

    TEST_CASE("broken rules are refused") {
        CHECK_FALSE(expand({.axiom = "F["}));
        CHECK_FALSE(expand({.axiom = "F", .productions = {{'X', "]["}}}));
        CHECK_FALSE(expand({.axiom = "F", .finish = {{'X', "F(2"}}}));
        CHECK_FALSE(expand({.axiom = "F", .productions = {{'F', "F", -1}}}));
        CHECK_FALSE(expand({.axiom = "F", .productions = {{'F', "F", std::nan("")}}}));
        CHECK_FALSE(expand(
            {.axiom = "F", .productions = {{'F', "F", std::numeric_limits<double>::infinity()}}}));
    }

    TEST_CASE("a word that would grow without end is an error, not a flood") {
        const auto word = expand({.axiom = "F", .productions = {{'F', "FFFF"}}},
                                 {.generations = 1000, .max_symbols = 10000});
        REQUIRE_FALSE(word);
        CHECK(word.error().code == error_code::too_large);
    }

    TEST_CASE("productions of weight zero leave their symbol alone") {
        CHECK(*expand({.axiom = "F", .productions = {{'F', "X", 0}}}) == "F");
    }
}
