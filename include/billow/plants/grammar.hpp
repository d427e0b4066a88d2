// Bracketed L-systems: a word is rewritten generation by generation into the plan of a plant.
//
// Prusinkiewicz, Lindenmayer, "The Algorithmic Beauty of Plants", 1990, chapter 1. The words are
// read by plants/turtle.hpp, where the alphabet is listed.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <billow/core/expected.hpp>
#include <billow/core/random.hpp>

namespace billow::inline BILLOW_ABI {

/// `symbol` becomes `successor`. Of several productions for a symbol one is drawn by weight.
struct production {
    char symbol{};
    std::string successor{};
    double weight = 1;
};

/// A symbol without a production stays. A number in parentheses belongs to the symbol before it
/// and is never rewritten; with its symbol it goes.
struct grammar {
    std::string axiom{};
    std::vector<production> productions{};
    std::vector<production> finish{};  ///< applied once, after the last generation
};

struct expand_options {
    unsigned generations = 1;
    std::uint64_t seed = 1;                          ///< of the draws between productions
    std::size_t max_symbols = std::size_t{1} << 26;  ///< longer words are an error
};

/// Looks for a bracket or a parenthesis without its partner.
///
/// Fails   malformed, with the position of the first character that has no partner.
[[nodiscard]] inline expected<done> check_brackets(std::string_view word) {
    const auto fault = [&](std::size_t at) {
        return error{error_code::malformed, "unbalanced '" + std::string(1, word[at]) +
                                                "' at position " + std::to_string(at) +
                                                " of the plant's word"};
    };
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < word.size(); ++i) {
        if (word[i] == '[') open.push_back(i);
        if (word[i] == ']') {
            if (open.empty()) return fault(i);
            open.pop_back();
        }
        if (word[i] == ')') return fault(i);
        if (word[i] == '(') {
            const std::size_t close = word.find_first_not_of("+-.0123456789", i + 1);
            if (close == std::string_view::npos || word[close] != ')') return fault(i);
            i = close;
        }
    }
    if (!open.empty()) return fault(open.back());
    return done{};
}

namespace detail {

/// One generation, or the error of a word that grew too long. The draws depend on (seed, position),
/// so they are the same in whatever order the word is read.
[[nodiscard]] inline expected<std::string> rewrite(std::string_view word,
                                                   std::span<const production> productions,
                                                   std::uint64_t seed, std::size_t max_symbols) {
    std::string next;
    for (std::size_t i = 0; i < word.size(); ++i) {
        const char symbol = word[i];
        const std::size_t last = i + 1 < word.size() && word[i + 1] == '(' ? word.find(')', i) : i;
        double total = 0;
        for (const production& p : productions) {
            if (p.symbol == symbol) total += p.weight;
        }
        if (total > 0) {
            double left = total * random_unit(seed, i);
            const production* drawn = nullptr;
            for (const production& p : productions) {
                if (p.symbol != symbol || p.weight <= 0) continue;
                drawn = &p;
                if (left < p.weight) break;
                left -= p.weight;
            }
            next += drawn->successor;
        } else {
            next += word.substr(i, last - i + 1);
        }
        i = last;
        if (next.size() > max_symbols) {
            return error{error_code::too_large, "the plant's word is longer than " +
                                                    std::to_string(max_symbols) + " symbols"};
        }
    }
    return next;
}

}  // namespace detail

/// The word after `options.generations` rewritings of the axiom and one reading of `finish`.
///
/// Fails   malformed: a bracket of axiom or successor lacks its partner; invalid_options: a weight
///         is negative, infinite or not a number; too_large: more than `max_symbols` symbols.
/// Cost    O(length of all words).
[[nodiscard]] inline expected<std::string> expand(const grammar& rules,
                                                  const expand_options& options = {}) {
    if (auto fine = check_brackets(rules.axiom); !fine) return fine.error();
    for (const auto& productions : {rules.productions, rules.finish}) {
        for (const production& p : productions) {
            if (auto fine = check_brackets(p.successor); !fine) return fine.error();
            if (!(p.weight >= 0 && p.weight < 1e300)) {
                return error{error_code::invalid_options,
                             "a production of '" + std::string(1, p.symbol) +
                                 "' has a weight below zero or without bound"};
            }
        }
    }
    expected<std::string> word = rules.axiom;
    for (unsigned generation = 0; generation <= options.generations && word; ++generation) {
        const bool is_last = generation == options.generations;
        word = detail::rewrite(*word, is_last ? rules.finish : rules.productions,
                               mix_bits(options.seed) + generation, options.max_symbols);
    }
    return word;
}

/// The third bracket of the forest paper's production.
enum class third_branch {
    as_printed,  ///< F[+FL][FL-][>FL]: the minus after the last symbol turns nothing
    turned,      ///< F[+FL][-FL][>FL]: what was almost surely meant
};

/// The tree of "Approach geometry/image for rendering forest in real time", IJMA 3(3), 2011,
/// section 4. From the axiom F, n generations give 4^n F and 4^n - 1 L.
[[nodiscard]] inline grammar forest_paper_grammar(third_branch spelling = third_branch::turned) {
    return {.axiom = "F",
            .productions = {{'F', spelling == third_branch::as_printed ? "F[+FL][FL-][>FL]"
                                                                       : "F[+FL][-FL][>FL]"}}};
}

}  // namespace billow::inline BILLOW_ABI
