// The epsilon that gives a cloud of about so many planes.
//
// Our own: Luksch 2009, section 5.2, looks for an epsilon by hand. The number of planes falls about
// as a power of epsilon, with small steps up and down, so the search runs in logarithms and keeps the
// best cloud it has seen rather than trust the last one.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include <billow/search/search_planes.hpp>

namespace billow::inline BILLOW_ABI {

struct plane_budget_options {
    double first_epsilon = 0.1;   ///< where to start, shares of the radius, within the next two
    double least_epsilon = 1e-4;  ///< shares of the radius, > 0
    double most_epsilon = 1;      ///< shares of the radius
    int max_searches = 10;        ///< > 0
    double tolerance = 0.02;  ///< share of the planes asked for that may be more or fewer, ≥ 0
};

/// A result of the search that came closest to the number of planes.
template <class Result>
struct budgeted {
    Result result{};
    double epsilon = 0;  ///< scene units
    std::size_t planes = 0;
    int searches = 0;
};

/// Searches with one epsilon after the other until the number of planes is right.
///
/// `search(epsilon, limit)` gives a result. It may stop as soon as it has more than `limit` planes,
/// for then the result is of no use. `count(result)` is its number of planes, any number above
/// `limit` when the search was stopped.
///
/// Unit    epsilon and radius in scene units.
/// Needs   planes > 0, radius > 0. Both calls give the same for the same arguments.
/// Gives   the result nearest to `planes` of those seen that were not stopped; of two as near the one
///         with fewer planes. When all were stopped, that of most_epsilon.
/// Cost    max_searches searches and one more at most; those with too many planes are cut short.
template <class Search, class Count>
    requires std::invocable<const Search&, double, std::size_t>
[[nodiscard]] auto search_for_planes(std::size_t planes, double radius, const Search& search,
                                     const Count& count, const plane_budget_options& options = {}) {
    using result_type = std::invoke_result_t<const Search&, double, std::size_t>;
    BILLOW_ASSERT(planes > 0 && radius > 0 && options.max_searches > 0);
    const auto wanted = static_cast<double>(planes);
    const double allowed = options.tolerance * wanted;
    struct sample {
        double log_epsilon = 0;
        double log_planes = 0;
    };
    std::optional<sample> many;  // the largest epsilon with too many planes
    std::optional<sample> few;   // the smallest epsilon with too few
    std::optional<budgeted<result_type>> best;
    const double least = std::log(options.least_epsilon);
    const double most = std::log(options.most_epsilon);
    double at = std::clamp(std::log(options.first_epsilon), least, most);
    int searches = 0;
    while (searches < options.max_searches) {
        const double epsilon = std::exp(at) * radius;
        // More planes than this are no better than what there is; as a sample their bound will do.
        const double best_miss =
            best ? std::abs(static_cast<double>(best->planes) - wanted) : 2 * wanted + 8;
        const auto limit = static_cast<std::size_t>(wanted + std::max(best_miss, allowed));
        result_type result = search(epsilon, limit);
        const std::size_t found = count(result);
        ++searches;
        const double miss = static_cast<double>(found) - wanted;
        const bool is_better = !best || std::abs(miss) < best_miss ||
                               (std::abs(miss) == best_miss && found < best->planes);
        if (is_better && found <= limit) {
            best = budgeted<result_type>{std::move(result), epsilon, found, searches};
        }
        if (std::abs(miss) <= allowed) break;
        const sample seen{at, std::log(static_cast<double>(std::max<std::size_t>(found, 1)))};
        (miss > 0 ? many : few) = seen;
        if ((at == most && miss > 0) || (at == least && miss < 0)) break;

        const double goal = std::log(wanted);
        if (many && few) {
            // Between the two on a line, but a fifth of the way off either end: counts are rough,
            // and those of stopped searches too low.
            const double width = few->log_epsilon - many->log_epsilon;
            if (std::abs(width) < 1e-3) break;
            const double fall = many->log_planes - few->log_planes;
            const double share = fall > 0 ? (many->log_planes - goal) / fall : 0.5;
            at = many->log_epsilon + std::clamp(share, 0.2, 0.8) * width;
        } else {
            // Planes fall with a power of epsilon of about 1.5; a little farther, to enclose them.
            const double step = (seen.log_planes - goal) / 1.5;
            at = std::clamp(at + step * 1.1 + std::copysign(0.05, step), least, most);
        }
    }
    if (!best) {  // every search was stopped
        const double epsilon = options.most_epsilon * radius;
        result_type result = search(epsilon, std::numeric_limits<std::size_t>::max() - 1);
        const std::size_t found = count(result);
        best = budgeted<result_type>{std::move(result), epsilon, found, 0};
        ++searches;
    }
    best->searches = searches;
    return *std::move(best);
}

/// A greedy search, the one that the pipeline names, for a cloud of about `planes` planes.
///
/// Needs   planes > 0; options.max_planes and options.epsilon are not read.
/// Gives   the cloud, with the epsilon it keeps; no plane for a table without faces.
/// Cost    that of a few greedy searches, see search_for_planes; holds the faces a second time.
template <class... Parts>
[[nodiscard]] budgeted<greedy_result> greedy_search_for_planes(
    const face_table& faces, std::size_t face_count, std::size_t planes, greedy_options options,
    const pipeline<Parts...>& parts, parallel threads = {}, const progress_function& progress = {},
    const plane_budget_options& budget = {}) {
    double searches_done = 0;
    const double all = budget.max_searches;
    const progress_function progress_of_one = [&](std::string_view, double share) {
        report(progress, "search", (searches_done + share) / all);
    };
    const auto search = [&](double epsilon, std::size_t limit) {
        options.epsilon = epsilon;
        options.max_planes = limit + 1;
        greedy_result found =
            search_planes(faces, face_count, options, parts, threads, progress_of_one);
        ++searches_done;
        return found;
    };
    const auto count = [](const greedy_result& found) { return found.cloud.plane_count(); };
    if (faces.size == 0) {
        options.epsilon = std::max(faces.bounds.radius, 1.0);
        return {.result = search_planes(faces, face_count, options, parts, threads)};
    }
    budgeted<greedy_result> best =
        search_for_planes(planes, faces.bounds.radius, search, count, budget);
    report(progress, "search", 1);
    return best;
}

}  // namespace billow::inline BILLOW_ABI
