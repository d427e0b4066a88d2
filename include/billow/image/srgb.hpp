// The nearest sRGB byte of linear light, without a power for every pixel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <billow/image/image.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

struct srgb_steps {
    std::array<float, 257> threshold{};     ///< linear light where byte i begins; the last: never
    std::array<std::uint8_t, 4097> hint{};  ///< largest byte that begins at or below i / 4096
};

[[nodiscard]] inline const srgb_steps& srgb_steps_table() noexcept {
    static const srgb_steps table = [] {
        srgb_steps steps;
        for (std::size_t i = 1; i < 256; ++i) {
            steps.threshold[i] = linear_from_srgb((static_cast<float>(i) - 0.5f) / 255.0f);
        }
        steps.threshold[256] = 2;
        std::size_t byte = 0;
        for (std::size_t i = 0; i < steps.hint.size(); ++i) {
            while (steps.threshold[byte + 1] <= static_cast<float>(i) / 4096.0f) ++byte;
            steps.hint[i] = static_cast<std::uint8_t>(byte);
        }
        return steps;
    }();
    return table;
}

}  // namespace detail

/// The sRGB byte nearest to linear light, which is clamped to [0, 1].
[[nodiscard]] inline std::uint8_t srgb_byte_from_linear(float value) noexcept {
    const detail::srgb_steps& steps = detail::srgb_steps_table();
    const float clamped = value > 0 ? (value < 1 ? value : 1.0f) : 0.0f;  // NaN becomes 0
    std::size_t byte = steps.hint[static_cast<std::size_t>(clamped * 4096.0f)];
    while (steps.threshold[byte + 1] <= clamped) ++byte;
    return static_cast<std::uint8_t>(byte);
}

}  // namespace billow::inline BILLOW_ABI
