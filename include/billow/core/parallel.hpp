// The one place that knows OpenMP. Without it everything runs on the calling thread.
#pragma once

#include <algorithm>
#include <cstddef>

#include <billow/core/config.hpp>

#if defined(_OPENMP)
#include <omp.h>
#endif

namespace billow::inline BILLOW_ABI {

/// How many threads a call may use. Results never depend on it: loops are cut into chunks of fixed
/// size, and what the chunks give is joined in their order.
struct parallel {
    unsigned threads = 0;  ///< 0: as many as the machine offers

    /// The number of threads that a loop will get.
    [[nodiscard]] unsigned count() const noexcept {
#if defined(_OPENMP)
        return threads != 0 ? threads : static_cast<unsigned>(std::max(1, omp_get_num_procs()));
#else
        return 1;
#endif
    }

    /// Calls `body(begin, end)` for the chunks [0, chunk), [chunk, 2 chunk), … of [0, size).
    /// `body` must not throw, and two chunks must not write to the same place.
    template <class Body>
    void for_chunks(std::size_t size, std::size_t chunk, const Body& body) const {
        BILLOW_ASSERT(chunk > 0);
        const auto chunk_count = static_cast<std::ptrdiff_t>((size + chunk - 1) / chunk);
        const auto run = [&](std::ptrdiff_t i) {
            const std::size_t begin = static_cast<std::size_t>(i) * chunk;
            body(begin, std::min(begin + chunk, size));
        };
#if defined(_OPENMP)
        if (count() > 1 && chunk_count > 1) {
#pragma omp parallel for schedule(dynamic) num_threads(static_cast <int>(count()))
            for (std::ptrdiff_t i = 0; i < chunk_count; ++i) run(i);
            return;
        }
#endif
        for (std::ptrdiff_t i = 0; i < chunk_count; ++i) run(i);
    }
};

}  // namespace billow::inline BILLOW_ABI
