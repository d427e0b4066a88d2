// The best offset of a plane whose normal is known, exactly: a sweep over the ends of the intervals of
// offsets at which faces are valid.
//
// For one normal n a face is valid from max n·v - epsilon to min n·v + epsilon (Luksch 2009, section
// 2.1), so the best offset is where the intervals of most weight lie over each other: sort the ends,
// walk along them. Neither bins of offsets nor cells of normals are needed (Décoret et al. 2003 have
// both), so nothing is estimated and nothing has to be refined.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <billow/density/rasterize.hpp>
#include <billow/search/nearest_offset.hpp>
#include <billow/search/offset_block.hpp>

namespace billow::inline BILLOW_ABI {

/// An offset, and what its plane collects. Unit: integers of the sweep's scale, uncharged.
struct swept_offset {
    float rho = 0;
    std::int64_t contribution = 0;
    std::int64_t penalty = 0;
    double density = -std::numeric_limits<double>::infinity();
    bool is_found = false;
};

/// What faces weigh in the buckets of one normal: the differences of two steps, of which sums from
/// the left give an upper bound of contribution and a lower bound of penalty in each bucket.
struct offset_row {
    std::span<std::int64_t> contribution;
    std::span<std::int64_t> penalty;  ///< empty where nothing is charged
};

/// How a sweep reads contribution c and penalty p: biased(c - charge · p, weight).
struct density_reading {
    double weight = 1;  ///< of the normal, > 0: orientation_bias and plane_distribution
    double charge = 0;  ///< weight of a penalty

    [[nodiscard]] double operator()(std::int64_t c, std::int64_t p) const noexcept {
        const auto contribution = static_cast<double>(c);
        return biased(charge == 0 ? contribution : contribution - charge * static_cast<double>(p),
                      weight);
    }
};

/// Buffers of a sweep, to be used again.
struct sweep_scratch {
    struct event {
        float at;
        std::int32_t bucket;
        bool is_after;  ///< counts beyond `at` only: the end of a closed interval
        std::int64_t contribution;
        std::int64_t penalty;
    };
    std::vector<event> events{};
    std::vector<std::int64_t> contribution_at{};  ///< where a bucket begins
    std::vector<std::int64_t> penalty_at{};
    std::vector<char> is_open{};
    std::vector<weighted_middle> middles{};
    detail::offset_block block{};
};

/// Sweeps of faces along normals, for one set of policies.
///
/// Weights are rounded to integers as in a density grid, so that sums do not depend on order: what a
/// row has gathered can be taken out again, and of two offsets the better one is the same for any
/// number of threads.
///
/// Differs from the validity policies of the density, which estimate the offsets of a cell of
/// normals: one normal leaves nothing to estimate, all of them are `valid_offsets`. A falloff has no
/// say in which faces a plane collects, see `nearest`.
template <contribution<simd::wide> Contribution, penalty<simd::wide> Penalty>
class offset_sweep {
public:
    /// Buckets per epsilon. They decide about time only: with more of them bounds are closer, and
    /// fewer normals have to be swept; beyond `most_buckets` rows leave the cache.
    static constexpr int buckets_per_epsilon = 64;
    static constexpr int most_buckets = 2048;

    /// `reach`: the farthest offset that matters, the radius. Keeps references to the policies.
    offset_sweep(const Contribution& worth, const Penalty& charge, double epsilon, double reach,
                 double scale)
        : rules_{worth,
                 charge,
                 offset_buckets(-reach, reach, bucket_count(reach, epsilon)),
                 static_cast<float>(epsilon),
                 static_cast<float>(scale),
                 !std::same_as<Penalty, no_penalty> && charge.weight > 0},
          charge_(charge.weight) {}

    /// The same sweep of the offsets between two only: with closer buckets, so with closer bounds.
    [[nodiscard]] offset_sweep focused(double low, double high) const noexcept {
        offset_sweep sweep = *this;
        sweep.rules_.buckets = offset_buckets(low, high, most_buckets / 2);
        sweep.rim_ = 1;  // these two hold all that lies outside
        return sweep;
    }

    [[nodiscard]] bool charges() const noexcept { return rules_.charges; }
    /// The weight that penalties have.
    [[nodiscard]] double charge() const noexcept { return charges() ? charge_ : 0; }
    [[nodiscard]] double scale() const noexcept { return static_cast<double>(rules_.scale); }
    [[nodiscard]] std::size_t row_size() const noexcept {
        return static_cast<std::size_t>(rules_.buckets.count()) + 2;
    }

    /// Adds the faces [begin, end) to a row, or takes them out. Needs multiples of the lanes.
    void change(const face_table& faces, std::size_t begin, std::size_t end, const vec3& normal,
                density_change change, const offset_row& row,
                detail::offset_block& block) const noexcept {
        for (std::size_t first = begin; first < end; first += block.size) {
            const std::size_t count = std::min(block.size, end - first);
            rules_.measure(faces, first, count, normal, block);
            if (change == density_change::add) {
                put<1>(block, count, row);
            } else {
                put<-1>(block, count, row);
            }
        }
    }

    /// No offset of the row has a greater density. Cost O(buckets).
    [[nodiscard]] double bound(const offset_row& row, const density_reading& read) const noexcept {
        std::int64_t c = 0, p = 0, most = 0;
        const std::size_t count = index(rules_.buckets.count()) - rim_;
        if (rim_ != 0) c = row.contribution[0], p = read.charge != 0 ? row.penalty[0] : 0;
        if (read.charge == 0) {
            for (std::size_t b = rim_; b < count; ++b) {
                c += row.contribution[b];
                most = std::max(most, c);
            }
            return read(most, 0);
        }
        double bound = -std::numeric_limits<double>::infinity();
        for (std::size_t b = rim_; b < count; ++b) {
            c += row.contribution[b];
            p += row.penalty[b];
            if (c > 0) bound = std::max(bound, read(c, p));
        }
        return bound;
    }

    /// The offset of most density, if it is more than `than`; of equals the least one. `row` holds
    /// `faces` and no others.
    ///
    /// Cost  O(faces + buckets), and O(e log e) for the e ends that lie in buckets whose bound is more
    ///       than `than`.
    [[nodiscard]] swept_offset best(const face_table& faces, const vec3& normal,
                                    const offset_row& row, const density_reading& read, double than,
                                    sweep_scratch& scratch) const {
        // Bounds are close: nearly always the best offset is in a bucket whose bound is near the
        // highest. Others are opened only when it was not.
        const double highest = bound(row, read);
        if (!(highest > than)) return {};
        const double near = std::max(than, highest - std::abs(highest) / 32);
        swept_offset found = best_beyond(faces, normal, row, read, near, scratch);
        if (!found.is_found && near > than) {
            found = best_beyond(faces, normal, row, read, than, scratch);
        }
        return found;
    }

    /// The same for faces that no row holds. `buckets` is one of row_size(), or two where penalties
    /// are charged; what is in it does not matter.
    [[nodiscard]] swept_offset best(const face_table& faces, const vec3& normal,
                                    const density_reading& read, double than,
                                    std::vector<std::int64_t>& buckets,
                                    sweep_scratch& scratch) const {
        buckets.assign(row_size() * (charges() ? 2 : 1), 0);
        const std::span all(buckets);
        const offset_row row{all.first(row_size()),
                             all.subspan(row_size(), all.size() - row_size())};
        change(faces, 0, faces.padded_size(), normal, density_change::add, row, scratch.block);
        return best(faces, normal, row, read, than, scratch);
    }

    /// Among the offsets around `rho` at which the same faces are valid and charged, the one nearest to
    /// the faces, each counted by its contribution and how `weigh` falls: nearest_offset.
    template <falloff<float> Falloff = distance_falloff>
    [[nodiscard]] double nearest(const face_table& faces, const vec3& normal, float rho,
                                 sweep_scratch& scratch, const Falloff& weigh = {}) const {
        constexpr float infinity = std::numeric_limits<float>::infinity();
        float low = rho < 0 ? -infinity : 0;
        float high = rho < 0 ? std::nextafter(0.0f, -1.0f) : infinity;
        if (!charges()) low = -infinity, high = infinity;
        detail::offset_block& block = scratch.block;
        std::vector<weighted_middle>& middles = scratch.middles;
        middles.clear();
        for (std::size_t first = 0; first < faces.padded_size(); first += block.size) {
            const std::size_t count = std::min(block.size, faces.padded_size() - first);
            rules_.measure(faces, first, count, normal, block);
            for (std::size_t i = 0; i < count; ++i) {
                if (block.weight[i] == 0) continue;
                const float from = block.valid.low[i], to = block.valid.high[i];
                if (from <= rho && rho <= to) {
                    low = std::max(low, from);
                    high = std::min(high, to);
                    middles.push_back(
                        {from + (to - from) / 2, static_cast<float>(block.weight[i])});
                }
                if (charges()) keep_uncharged(block, i, rho, low, high);
            }
        }
        if (middles.empty()) return static_cast<double>(rho);
        const double at =
            nearest_offset(middles, static_cast<double>(low), static_cast<double>(high),
                           static_cast<double>(rules_.epsilon), weigh);
        // As a float: a kernel must find the same faces valid.
        return static_cast<double>(std::clamp(static_cast<float>(at), low, high));
    }

private:
    using event = sweep_scratch::event;

    template <int Sign>
    void put(const detail::offset_block& block, std::size_t count,
             const offset_row& row) const noexcept {
        for (std::size_t i = 0; i < count; ++i) {
            const std::int64_t weight = Sign * std::int64_t{block.weight[i]};
            row.contribution[index(block.valid.first[i])] += weight;
            row.contribution[index(block.valid.last[i]) + 1] -= weight;
        }
        if (!rules_.charges) return;
        // Only what is charged throughout a bucket counts.
        const auto put_charge = [&](const detail::offset_ends& at, std::size_t i) {
            if (!(at.low[i] < at.high[i])) return;
            const std::int64_t weight = Sign * std::int64_t{block.weight[i]};
            const std::size_t begin = index(at.first[i]) + 1;
            row.penalty[begin] += weight;
            row.penalty[std::max(begin, index(at.last[i]))] -= weight;
        };
        for (std::size_t i = 0; i < count; ++i) {
            if (block.weight[i] == 0) continue;
            put_charge(block.above, i);
            put_charge(block.below, i);
        }
    }

    [[nodiscard]] static int bucket_count(double reach, double epsilon) noexcept {
        const double wanted = std::ceil(2 * reach / epsilon * buckets_per_epsilon);
        return static_cast<int>(std::clamp(wanted, 1.0, double{most_buckets}));
    }
    [[nodiscard]] static std::size_t index(std::int32_t bucket) noexcept {
        return static_cast<std::size_t>(bucket);
    }

    /// best() by opening all buckets that may hold more than `than`.
    [[nodiscard]] swept_offset best_beyond(const face_table& faces, const vec3& normal,
                                           const offset_row& row, const density_reading& read,
                                           double than, sweep_scratch& scratch) const {
        open_buckets(row, read, than, scratch);
        collect_events(faces, normal, read.charge != 0, scratch);
        return walk(read, than, scratch);
    }

    /// Marks the buckets that may hold more than `than`, and notes their bounds.
    void open_buckets(const offset_row& row, const density_reading& read, double than,
                      sweep_scratch& scratch) const {
        const auto count = index(rules_.buckets.count());
        scratch.is_open.assign(count, 0);
        scratch.contribution_at.resize(count);
        scratch.penalty_at.resize(count);
        std::int64_t c = 0, p = 0;
        for (std::size_t b = 0; b < count; ++b) {
            c += row.contribution[b];
            if (read.charge != 0) p += row.penalty[b];
            scratch.contribution_at[b] = c;
            scratch.penalty_at[b] = p;
            const bool is_asked_for = b >= rim_ && b + rim_ < count;
            const bool is_open = is_asked_for && c > 0 && read(c, p) > than;
            scratch.is_open[b] = is_open ? 1 : 0;
        }
    }

    /// Gathers the ends that lie in open buckets; turns the bounds of these buckets into what is
    /// valid and charged where they begin.
    void collect_events(const face_table& faces, const vec3& normal, bool counts_penalty,
                        sweep_scratch& scratch) const {
        std::vector<event>& events = scratch.events;
        events.clear();
        detail::offset_block& block = scratch.block;
        const auto is_open = [&](std::int32_t b) { return scratch.is_open[index(b)] != 0; };
        const auto add_charge = [&](const detail::offset_ends& at, std::size_t i, bool is_after) {
            if (!(at.low[i] < at.high[i])) return;
            const std::int32_t first = at.first[i], last = at.last[i];
            const std::int64_t weight = block.weight[i];
            if (is_open(first)) events.push_back({at.low[i], first, is_after, 0, weight});
            if (!is_open(last)) return;
            events.push_back({at.high[i], last, is_after, 0, -weight});
            if (first < last) scratch.penalty_at[index(last)] += weight;
        };
        for (std::size_t begin = 0; begin < faces.padded_size(); begin += block.size) {
            const std::size_t count = std::min(block.size, faces.padded_size() - begin);
            rules_.measure(faces, begin, count, normal, block);
            for (std::size_t i = 0; i < count; ++i) {
                const std::int64_t weight = block.weight[i];
                if (weight == 0) continue;
                const std::int32_t first = block.valid.first[i], last = block.valid.last[i];
                if (is_open(first)) {
                    events.push_back({block.valid.low[i], first, false, weight, 0});
                    scratch.contribution_at[index(first)] -= weight;
                }
                if (is_open(last)) events.push_back({block.valid.high[i], last, true, -weight, 0});
                if (counts_penalty) {
                    add_charge(block.above, i, false);
                    add_charge(block.below, i, true);
                }
            }
        }
        if (!counts_penalty) return;
        // Charges of either side end at 0.
        for (const float at : {std::nextafter(0.0f, -1.0f), 0.0f}) {
            const std::int32_t b = rules_.buckets.bucket_of(at);
            if (is_open(b)) events.push_back({at, b, false, 0, 0});
        }
    }

    /// Walks along the ends. Density grows only where an interval begins or a charge ends, and below 0
    /// just before an end, so the ends themselves are all that needs a look.
    [[nodiscard]] swept_offset walk(const density_reading& read, double than,
                                    sweep_scratch& scratch) const {
        std::vector<event>& events = scratch.events;
        std::sort(events.begin(), events.end(), [](const event& a, const event& b) {
            return a.at != b.at ? a.at < b.at : a.is_after < b.is_after;
        });
        swept_offset best;
        std::int64_t c = 0, p = 0;
        std::int32_t bucket = -1;
        for (std::size_t i = 0; i < events.size();) {
            if (events[i].bucket != bucket) {
                bucket = events[i].bucket;
                c = scratch.contribution_at[index(bucket)];
                p = scratch.penalty_at[index(bucket)];
            }
            const float at = events[i].at;
            const auto pass = [&](bool is_after) {
                for (; i < events.size() && events[i].at == at && events[i].is_after == is_after;
                     ++i) {
                    c += events[i].contribution;
                    p += events[i].penalty;
                }
            };
            pass(false);
            const double density = read(c, p);
            if (c > 0 && density > than) {
                than = density;
                best = {at, c, p, density, true};
            }
            pass(true);
        }
        return best;
    }

    /// Narrows [low, high] around `rho` to where no other charges of face i begin.
    static void keep_uncharged(const detail::offset_block& block, std::size_t i, float rho,
                               float& low, float& high) noexcept {
        constexpr float infinity = std::numeric_limits<float>::infinity();
        const detail::offset_ends& above = block.above;
        if (above.low[i] < above.high[i]) {
            if (rho < above.low[i]) high = std::min(high, std::nextafter(above.low[i], -infinity));
            if (rho >= above.high[i]) low = std::max(low, above.high[i]);
        }
        const detail::offset_ends& below = block.below;
        if (below.low[i] < below.high[i]) {
            if (rho <= below.low[i]) high = std::min(high, below.low[i]);
            if (rho > below.high[i]) low = std::max(low, std::nextafter(below.high[i], infinity));
        }
    }

    detail::offset_rules<Contribution, Penalty> rules_;
    double charge_;
    std::size_t rim_ = 0;  ///< buckets at either end that nobody asks for
};

}  // namespace billow::inline BILLOW_ABI
