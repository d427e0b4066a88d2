// The best plane over many normals, of which few are swept: lazy evaluation.
//
// M. Minoux: Accelerated greedy algorithms for maximizing submodular set functions. 1978. What a
// plane would collect can only fall while faces leave, so what a normal was once worth bounds it for
// good: normals whose bound is below the best plane found so far need not be looked at.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/search/offset_sweep.hpp>

namespace billow::inline BILLOW_ABI {

/// A plane through one of the normals.
struct swept_direction {
    std::size_t row = 0;
    swept_offset at{};
};

/// A row of buckets for each of a set of normals, and what is known of the best plane of each.
template <class Sweep>
class lazy_directions {
public:
    /// Keeps a reference to `sweep`. Memory: normals · sweep.row_size() integers, twice where
    /// penalties are charged: 10 MB at an epsilon of 10 % and a raster of 18.
    lazy_directions(const Sweep& sweep, std::vector<vec3> normals, parallel threads)
        : sweep_(sweep),
          threads_(threads),
          normals_(std::move(normals)),
          contribution_(normals_.size() * sweep.row_size()),
          penalty_(sweep.charges() ? contribution_.size() : 0),
          bounds_(normals_.size(), unknown),
          is_stale_(normals_.size(), 1),
          scratches_(threads.count()) {}

    [[nodiscard]] std::size_t size() const noexcept { return normals_.size(); }

    /// Adds faces to all rows, or takes them out. Cost O(faces · normals).
    void change(const face_table& faces, density_change change) {
        // Starting threads for a few faces costs more than the faces.
        const std::size_t chunk = faces.size * size() < 100'000 ? size() + 1 : rows_per_job;
        threads_.for_chunks(size(), chunk, [&](std::size_t begin, std::size_t end) {
            detail::offset_block block;
            for (std::size_t first = 0; first < faces.padded_size(); first += faces_per_pass) {
                const std::size_t last = std::min(first + faces_per_pass, faces.padded_size());
                for (std::size_t row = begin; row < end; ++row) {
                    sweep_.change(faces, first, last, normals_[row], change, row_of(row), block);
                }
            }
        });
        // Without a charge, a removal leaves all bounds true.
        const bool is_bounded = change == density_change::remove && !sweep_.charges();
        std::ranges::fill(is_stale_, 1);
        if (!is_bounded) std::ranges::fill(bounds_, unknown);
    }
    /// Takes all faces out.
    void clear() noexcept {
        std::ranges::fill(contribution_, 0);
        std::ranges::fill(penalty_, 0);
    }
    /// Bounds hold no longer: weights have grown, or something else is charged.
    void forget_bounds() noexcept {
        std::ranges::fill(bounds_, unknown);
        std::ranges::fill(is_stale_, 1);
    }

    /// The plane of most density over all normals, exactly; of equals that of the first row, and
    /// there of the least offset. Not found where no face is valid for any.
    ///
    /// `remaining` are the faces that are in the rows; `weights[row]` has not grown since the last call.
    /// Source Minoux 1978.
    template <class Weights>
    [[nodiscard]] swept_direction best(const face_table& remaining, const Weights& weights,
                                       double charge) {
        swept_direction best;
        const auto may_win = [&](const candidate& c) {
            return c.bound > best.at.density || (c.bound == best.at.density && c.row < best.row);
        };
        fill_heap();
        std::vector<candidate> batch;
        std::vector<swept_offset> swept;
        for (std::size_t most_swept = 2; !heap_.empty() && may_win(heap_.front());) {
            const bool is_stale = is_stale_[heap_.front().row] != 0;
            take_batch(is_stale, is_stale ? rows_per_job * 16 : most_swept, may_win, batch);
            if (is_stale) {
                renew_bounds(batch, weights, charge);
                continue;
            }
            sweep_batch(remaining, batch, weights, charge, best.at.density, swept);
            for (std::size_t i = 0; i < batch.size(); ++i) {
                const std::size_t row = batch[i].row;
                if (swept[i].is_found) {
                    bounds_[row] = swept[i].density;
                    if (may_win({swept[i].density, row})) best = {row, swept[i]};
                } else {
                    bounds_[row] = std::min(bounds_[row], best.at.density);
                }
            }
            most_swept = std::min<std::size_t>(2 * most_swept, 16);
        }
        return best;
    }

    /// Up to `count` planes of other rows that promise most after the last `best`, each with a
    /// normal that is farther than `chord` from those before it and from `from`.
    template <class Weights>
    [[nodiscard]] std::vector<swept_direction> runners_up(const face_table& remaining,
                                                          const Weights& weights, double charge,
                                                          std::size_t from, std::size_t count,
                                                          double chord) {
        std::vector<candidate> chosen;
        const auto is_apart = [&](std::size_t row, std::size_t other) {
            const double cosine = std::abs(glm::dot(dvec3(normals_[row]), dvec3(normals_[other])));
            return 2 - 2 * cosine > chord * chord;
        };
        fill_heap();
        std::vector<candidate> batch;
        while (chosen.size() < count && !heap_.empty() && heap_.front().bound > 0) {
            if (is_stale_[heap_.front().row] != 0) {
                take_batch(
                    true, rows_per_job * 16, [](const candidate&) { return true; }, batch);
                renew_bounds(batch, weights, charge);
                continue;
            }
            std::pop_heap(heap_.begin(), heap_.end());
            const candidate next = heap_.back();
            heap_.pop_back();
            if (is_apart(next.row, from) && std::ranges::all_of(chosen, [&](const candidate& c) {
                    return is_apart(next.row, c.row);
                })) {
                chosen.push_back(next);
            }
        }
        std::vector<swept_offset> swept;
        sweep_batch(remaining, chosen, weights, charge, unknown_density, swept);
        std::vector<swept_direction> found;
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            if (swept[i].is_found) found.push_back({chosen[i].row, swept[i]});
        }
        return found;
    }

private:
    static constexpr double unknown = std::numeric_limits<double>::infinity();
    static constexpr double unknown_density = -std::numeric_limits<double>::infinity();
    static constexpr std::size_t rows_per_job = 8;
    static constexpr std::size_t faces_per_pass = 1024;

    /// A row and its bound; less is worse, or a later row.
    struct candidate {
        double bound;
        std::size_t row;
        friend bool operator<(const candidate& a, const candidate& b) noexcept {
            return a.bound != b.bound ? a.bound < b.bound : a.row > b.row;
        }
    };

    [[nodiscard]] offset_row row_of(std::size_t row) noexcept {
        const std::size_t length = sweep_.row_size();
        const std::span penalty(penalty_);
        return {std::span(contribution_).subspan(row * length, length),
                penalty.empty() ? penalty : penalty.subspan(row * length, length)};
    }

    void fill_heap() {
        heap_.clear();
        for (std::size_t row = 0; row < size(); ++row) heap_.push_back({bounds_[row], row});
        std::make_heap(heap_.begin(), heap_.end());
    }

    /// Moves up to `most` candidates that are stale, or are not, from the top of the heap.
    template <class MayWin>
    void take_batch(bool is_stale, std::size_t most, const MayWin& may_win,
                    std::vector<candidate>& batch) {
        batch.clear();
        while (batch.size() < most && !heap_.empty() && may_win(heap_.front()) &&
               (is_stale_[heap_.front().row] != 0) == is_stale) {
            std::pop_heap(heap_.begin(), heap_.end());
            batch.push_back(heap_.back());
            heap_.pop_back();
        }
    }

    /// Sums up the rows of a batch, and puts them back with what their buckets promise.
    template <class Weights>
    void renew_bounds(const std::vector<candidate>& batch, const Weights& weights, double charge) {
        threads_.for_chunks(batch.size(), rows_per_job, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const std::size_t row = batch[i].row;
                const density_reading read{weights[row], charge};
                bounds_[row] = std::min(bounds_[row], sweep_.bound(row_of(row), read));
                is_stale_[row] = 0;
            }
        });
        for (const candidate& c : batch) {
            heap_.push_back({bounds_[c.row], c.row});
            std::push_heap(heap_.begin(), heap_.end());
        }
    }

    template <class Weights>
    void sweep_batch(const face_table& remaining, const std::vector<candidate>& batch,
                     const Weights& weights, double charge, double than,
                     std::vector<swept_offset>& swept) {
        swept.assign(batch.size(), {});
        // An equal density of an earlier row wins.
        than = std::nextafter(than, unknown_density);
        for_jobs(threads_, batch.size(), scratches_, [&](std::size_t i, sweep_scratch& scratch) {
            const std::size_t row = batch[i].row;
            swept[i] = sweep_.best(remaining, normals_[row], row_of(row),
                                   density_reading{weights[row], charge}, than, scratch);
        });
    }

    const Sweep& sweep_;
    parallel threads_;
    std::vector<vec3> normals_;
    std::vector<std::int64_t> contribution_;
    std::vector<std::int64_t> penalty_;
    std::vector<double> bounds_;
    std::vector<char> is_stale_;
    std::vector<sweep_scratch> scratches_;
    std::vector<candidate> heap_{};
};

}  // namespace billow::inline BILLOW_ABI
