// Which of many things are one, learnt pair by pair.
//
// R. E. Tarjan: Efficiency of a good but not linear set union algorithm. Journal of the ACM 22, 1975.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Sets of the numbers below `size`, each its own at first.
///
/// Cost   nearly O(1) a call. Differs from the source: the least member leads its set, so that the
///        result does not depend on the order of the calls.
class disjoint_sets {
public:
    explicit disjoint_sets(std::size_t size) : parent_(size) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }

    /// The least member of the set that holds `member`.
    [[nodiscard]] std::uint32_t leader(std::uint32_t member) noexcept {
        while (parent_[member] != member) {
            member = parent_[member] = parent_[parent_[member]];
        }
        return member;
    }
    /// Makes the sets of `a` and `b` one.
    void join(std::uint32_t a, std::uint32_t b) noexcept {
        const auto [least, other] = std::minmax({leader(a), leader(b)});
        parent_[other] = least;
    }
    /// Numbers the sets from 0 on, in the order of their least members: one number a member.
    [[nodiscard]] std::vector<std::uint32_t> numbers(std::size_t& set_count) {
        std::vector<std::uint32_t> number(parent_.size());
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < number.size(); ++i) {
            const std::uint32_t least = leader(i);
            number[i] = least == i ? count++ : number[least];
        }
        set_count = count;
        return number;
    }

private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace billow::inline BILLOW_ABI
