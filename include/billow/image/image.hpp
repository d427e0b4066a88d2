// Images of bytes, and the two spaces that their colours live in.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Pixels of 1 to 4 bytes, rows from top to bottom, pixels from left to right, channels together.
/// Whether the colours are sRGB or linear is said where an image is used.
struct image {
    int width = 0;
    int height = 0;
    int channels = 4;
    std::vector<std::uint8_t> bytes{};  ///< width * height * channels

    [[nodiscard]] static image filled(int width, int height, int channels, std::uint8_t value) {
        const auto size = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                          static_cast<std::size_t>(channels);
        return {width, height, channels, std::vector<std::uint8_t>(size, value)};
    }

    [[nodiscard]] bool empty() const noexcept { return bytes.empty(); }
    /// First byte of the pixel in column x of row y.
    [[nodiscard]] const std::uint8_t* pixel(int x, int y) const noexcept {
        return bytes.data() + offset(x, y);
    }
    [[nodiscard]] std::uint8_t* pixel(int x, int y) noexcept { return bytes.data() + offset(x, y); }
    friend bool operator==(const image&, const image&) = default;

private:
    [[nodiscard]] std::size_t offset(int x, int y) const noexcept {
        BILLOW_ASSERT(x >= 0 && x < width && y >= 0 && y < height);
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels);
    }
};

/// Linear light of an sRGB value, both in [0, 1]. Source: IEC 61966-2-1.
[[nodiscard]] inline float linear_from_srgb(float value) noexcept {
    return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

/// sRGB value of linear light, both in [0, 1]. Source: IEC 61966-2-1.
[[nodiscard]] inline float srgb_from_linear(float value) noexcept {
    return value <= 0.0031308f ? value * 12.92f : 1.055f * std::pow(value, 1 / 2.4f) - 0.055f;
}

/// Linear light of each sRGB byte.
[[nodiscard]] inline const std::array<float, 256>& linear_of_srgb_byte() noexcept {
    static const auto table = [] {
        std::array<float, 256> values{};
        for (std::size_t i = 0; i < 256; ++i) {
            values[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
        }
        return values;
    }();
    return table;
}

/// The byte nearest to `value`, which is clamped to [0, 1].
[[nodiscard]] inline std::uint8_t byte_from_unit(float value) noexcept {
    const float clamped = value > 0 ? (value < 1 ? value : 1.0f) : 0.0f;  // NaN becomes 0
    return static_cast<std::uint8_t>(clamped * 255.0f + 0.5f);
}

}  // namespace billow::inline BILLOW_ABI
