// Random numbers that depend on (seed, index) alone, so that threads and call order do not matter.
//
// The mixing function is the finalizer of SplitMix64: Steele, Lea, Flood, "Fast splittable
// pseudorandom number generators", OOPSLA 2014.
#pragma once

#include <cstdint>

#include <billow/core/config.hpp>

namespace billow::inline BILLOW_ABI {

/// 64 well mixed bits of `value`.
[[nodiscard]] constexpr std::uint64_t mix_bits(std::uint64_t value) noexcept {
    value += 0x9e3779b97f4a7c15u;
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebu;
    return value ^ (value >> 31);
}

/// The index-th number of the stream `seed`, uniform in [0, 1).
[[nodiscard]] constexpr double random_unit(std::uint64_t seed, std::uint64_t index) noexcept {
    return static_cast<double>(mix_bits(mix_bits(seed) ^ (index * 0xd1342543de82ef95u)) >> 11) *
           0x1p-53;
}

/// A stream of numbers with a position: random_unit(seed, 0), random_unit(seed, 1), …
class random_stream {
public:
    explicit constexpr random_stream(std::uint64_t seed) noexcept : seed_(seed) {}

    /// Uniform in [0, 1).
    [[nodiscard]] constexpr double unit() noexcept { return random_unit(seed_, index_++); }
    /// Uniform in [low, high).
    [[nodiscard]] constexpr double between(double low, double high) noexcept {
        return low + (high - low) * unit();
    }

private:
    std::uint64_t seed_;
    std::uint64_t index_ = 0;
};

}  // namespace billow::inline BILLOW_ABI
