// For every pixel the nearest pixel of a set, by exact Euclidean distance.
//
// Meijster, Roerdink, Hesselink, "A general algorithm for computing distance transforms in linear
// time", 2000, carried from distances to the pixels that they are measured to.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>

namespace billow::inline BILLOW_ABI {

/// Buffers of nearest_pixels, reused between calls.
struct nearest_scratch {
    struct parabola {
        int x = 0;
        int y = 0;
        int begin = 0;  ///< first column that it is nearest to
    };
    std::vector<parabola> envelopes{};  ///< a row's worth for each chunk of rows
};

inline constexpr std::int32_t no_pixel = -1;

namespace detail {

inline constexpr std::size_t nearest_chunk = 64;  ///< rows, or columns, done together

}  // namespace detail

/// How many envelopes nearest_pixels needs.
[[nodiscard]] inline std::size_t nearest_scratch_size(int width, int height) noexcept {
    const std::size_t rows = static_cast<std::size_t>(height) + detail::nearest_chunk - 1;
    return static_cast<std::size_t>(width) * (rows / detail::nearest_chunk);
}

/// Fills `nearest[y * width + x]` with the index of the nearest pixel (y' * width + x') for which
/// `is_seed(x', y')`; with no_pixel everywhere when there is none. Of equally near ones the choice
/// is fixed, but no particular one.
///
/// Shape  `nearest`: width * height. `scratch`: grown as needed.
/// Needs  width * height < 2³¹.
/// Cost   O(pixels), parallel over columns and rows.
template <class IsSeed>
void nearest_pixels(int width, int height, const IsSeed& is_seed, std::span<std::int32_t> nearest,
                    nearest_scratch& scratch, parallel threads = {1}) {
    constexpr std::size_t chunk = detail::nearest_chunk;
    const auto w = static_cast<std::size_t>(width);
    const auto h = static_cast<std::size_t>(height);
    BILLOW_ASSERT(nearest.size() == w * h);
    const std::size_t envelopes = nearest_scratch_size(width, height);
    if (scratch.envelopes.size() < envelopes) scratch.envelopes.resize(envelopes);

    // First the row of the nearest seed in the same column, downwards, then upwards.
    threads.for_chunks(w, chunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = 0; y < h; ++y) {
            for (std::size_t x = begin; x < end; ++x) {
                nearest[y * w + x] = is_seed(static_cast<int>(x), static_cast<int>(y))
                                         ? static_cast<std::int32_t>(y)
                                         : (y > 0 ? nearest[(y - 1) * w + x] : no_pixel);
            }
        }
        for (std::size_t y = h - 1; y-- > 0;) {
            for (std::size_t x = begin; x < end; ++x) {
                const std::int32_t below = nearest[(y + 1) * w + x];
                const std::int32_t above = nearest[y * w + x];
                const auto row = static_cast<std::int32_t>(y);
                if (below != no_pixel && (above == no_pixel || below - row < row - above)) {
                    nearest[y * w + x] = below;
                }
            }
        }
    });

    // Then along each row the lower envelope of the parabolas (x - x')² + distance(x')².
    threads.for_chunks(h, chunk, [&](std::size_t begin, std::size_t end) {
        const std::span envelope = std::span(scratch.envelopes).subspan(begin / chunk * w, w);
        for (std::size_t y = begin; y < end; ++y) {
            const std::span row = nearest.subspan(y * w, w);
            const auto height_sq = [&](int x) {
                const auto d = static_cast<std::int64_t>(row[static_cast<std::size_t>(x)]) -
                               static_cast<std::int64_t>(y);
                return d * d;
            };
            std::size_t size = 0;
            for (int x = 0; x < width; ++x) {
                if (row[static_cast<std::size_t>(x)] == no_pixel) continue;
                int first = 0;
                while (size > 0) {
                    const int before = envelope[size - 1].x;
                    // The first column where x is nearer than `before`.
                    const std::int64_t gain = height_sq(x) - height_sq(before) +
                                              std::int64_t{x} * x - std::int64_t{before} * before;
                    const std::int64_t span = 2 * (std::int64_t{x} - before);
                    const std::int64_t meet = gain < 0 ? 0 : gain / span + 1;
                    if (meet > envelope[size - 1].begin) {
                        first = static_cast<int>(std::min<std::int64_t>(meet, width));
                        break;
                    }
                    --size;
                }
                if (first < width) envelope[size++] = {x, row[static_cast<std::size_t>(x)], first};
            }
            if (size == 0) continue;
            for (std::size_t i = 0; i < size; ++i) {
                const int last = i + 1 < size ? envelope[i + 1].begin : width;
                for (int x = envelope[i].begin; x < last; ++x) {
                    row[static_cast<std::size_t>(x)] = envelope[i].y * width + envelope[i].x;
                }
            }
        }
    });
}

}  // namespace billow::inline BILLOW_ABI
