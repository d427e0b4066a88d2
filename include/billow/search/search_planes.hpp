// The search that a pipeline names.
#pragma once

#include <concepts>
#include <type_traits>
#include <utility>

#include <billow/search/exact_search.hpp>
#include <billow/search/greedy.hpp>

namespace billow::inline BILLOW_ABI {

/// What `method` needs of the options that all searches share. Those that are about bins and their
/// refinement have no counterpart.
[[nodiscard]] inline exact_search_options exact_options(const greedy_options& options,
                                                        const exact_method& method) {
    return {.epsilon = options.epsilon,
            .max_planes = options.max_planes,
            .coverage = 1 - options.skip_area,
            .min_contribution = options.min_contribution,
            .skipped = options.skipped,
            .distribution = options.distribution,
            .method = method};
}

/// greedy_search or exact_search, as `parts.search` says.
template <class... Parts>
[[nodiscard]] greedy_result search_planes(face_table faces, std::size_t face_count,
                                          const greedy_options& options,
                                          const pipeline<Parts...>& parts, parallel threads = {},
                                          const progress_function& progress = {}) {
    using method = std::remove_cvref_t<decltype(parts.search)>;
    const auto search_exactly = [&](const exact_method& how) {
        return exact_search(std::move(faces), face_count, exact_options(options, how), parts,
                            threads, progress);
    };
    if constexpr (std::same_as<method, exact_method>) {
        return search_exactly(parts.search);
    } else {
        if constexpr (std::same_as<method, either_method>) {
            if (parts.search.is_exact) return search_exactly(parts.search.exact);
        }
        return greedy_search(std::move(faces), face_count, options, parts, threads, progress);
    }
}

}  // namespace billow::inline BILLOW_ABI
