// Unequal jobs handed out one by one, each worker with buffers of its own.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include <billow/core/parallel.hpp>

namespace billow::inline BILLOW_ABI {

/// Calls `body(job, scratch)` once for every job of [0, job_count), in no fixed order. A scratch is
/// used by one job at a time, so that bodies need not allocate.
///
/// Needs  at least one scratch; no more threads run than there are scratches. `body` must not
///        throw, two jobs must not write to the same place, and what a job gives must not depend on
///        what its scratch held.
template <class Scratch, class Body>
void for_jobs(parallel threads, std::size_t job_count, std::vector<Scratch>& scratches,
              const Body& body) {
    BILLOW_ASSERT(!scratches.empty());
    std::atomic<std::size_t> next{0};
    threads.for_chunks(scratches.size(), 1, [&](std::size_t worker, std::size_t) {
        for (std::size_t job = next++; job < job_count; job = next++) body(job, scratches[worker]);
    });
}

}  // namespace billow::inline BILLOW_ABI
