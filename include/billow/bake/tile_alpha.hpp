// Which texels of a tile are opaque, so that as much is drawn as the faces cover.
//
// Fuhrmann et al. 2005, section 3.3.7: binary alpha by rank, 0.3 of a texel's samples. Differs: that
// threshold makes leaves fatter by what their outlines are long; here the threshold is the one of
// each tile with which the area is right. Cook et al. 2007 keep area when leaves are dropped.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <billow/bake/tile_picture.hpp>
#include <billow/core/types.hpp>
#include <billow/image/alpha_coverage.hpp>
#include <billow/image/distance_field.hpp>
#include <billow/image/nearest.hpp>
#include <billow/image/srgb.hpp>

namespace billow::inline BILLOW_ABI {

/// What alpha holds. All are drawn with an alpha test at a half.
enum class alpha_kind : std::uint8_t {
    binary,    ///< 0 or 255
    coverage,  ///< the covered share: antialiased with alpha to coverage, or blended
    distance,  ///< signed distance to the outline: smooth however near one comes
};

/// The opaque area that a tile is given.
enum class opaque_area : std::uint8_t {
    thresholds,  ///< whatever the thresholds give
    covered,     ///< of the faces as they are seen along the billboard's normal
    surface,     ///< of the faces themselves: tilted leaves keep their area, see tile_picture
};

/// Shares of a texel that must be covered for it to be opaque.
struct coverage_thresholds {
    double foliage = 0.3;  ///< materials of alpha_mode::mask and blend
    double solid = 0.5;
};

struct alpha_options {
    alpha_kind kind = alpha_kind::binary;
    opaque_area area = opaque_area::covered;
    coverage_thresholds thresholds{};
    double spread = 4;  ///< texels each way that distances are told, more than 0
};

namespace detail {

/// Neighbours within a tile, the texel itself included.
template <class Visit>
void for_neighbours(const tile_picture& in, int x, int y, const Visit& visit) {
    for (int j = std::max(0, y - 1); j <= std::min(in.height - 1, y + 1); ++j) {
        for (int i = std::max(0, x - 1); i <= std::min(in.width - 1, x + 1); ++i) {
            visit(in.index(i, j));
        }
    }
}

/// One call of choose_alpha for binary alpha; its methods are the steps in their order.
class binary_alpha {
public:
    binary_alpha(tile_picture& tile, const alpha_options& options)
        : tile_(tile), options_(options) {}

    void run() {
        std::vector<char> is_fine(tile_.texel_count(), 0);
        for (std::size_t i = 0; i < tile_.texel_count(); ++i) {
            const bool is_opaque = ratio(i) >= 1 - 1e-6f;
            tile_.alpha(i) = is_opaque ? 255 : 0;
            is_fine[i] = options_.area != opaque_area::thresholds && tile_.cut_out[i] > 0;
        }
        if (options_.area != opaque_area::thresholds) {
            find_thin_solids(is_fine);
            rank(is_fine);
        }
        if (options_.area == opaque_area::surface) grow();
    }

private:
    struct ranked {
        float key;
        std::uint32_t texel;
    };

    /// The covered share over the threshold of what covers it.
    [[nodiscard]] float ratio(std::size_t i) const noexcept {
        if (tile_.covered[i] == 0) return 0;
        const double leaves = static_cast<double>(tile_.cut_out[i]) / tile_.covered[i];
        const double threshold = options_.thresholds.solid +
                                 leaves * (options_.thresholds.foliage - options_.thresholds.solid);
        return static_cast<float>(tile_.share(i) / threshold);
    }

    /// Texels of solids that have no opaque one beside them: rods thinner than a texel. Along the
    /// outline of what is wider a ranking would only fray it.
    void find_thin_solids(std::vector<char>& is_fine) const {
        for (int y = 0; y < tile_.height; ++y) {
            for (int x = 0; x < tile_.width; ++x) {
                const std::size_t at = tile_.index(x, y);
                if (tile_.covered[at] == 0 || tile_.cut_out[at] > 0) continue;
                bool has_opaque = false;
                for_neighbours(tile_, x, y, [&](std::size_t i) {
                    has_opaque |= tile_.cut_out[i] == 0 && tile_.alpha(i) != 0;
                });
                if (!has_opaque) is_fine[at] = 1;
            }
        }
    }

    /// Makes as many of these texels opaque as they cover: those with most samples first, among
    /// equals those amid others, then in an order that spreads them.
    void rank(const std::vector<char>& is_fine) {
        std::vector<ranked> order;
        double wanted = 0;
        for (int y = 0; y < tile_.height; ++y) {
            for (int x = 0; x < tile_.width; ++x) {
                const std::size_t at = tile_.index(x, y);
                if (is_fine[at] == 0) continue;
                float around = 0;
                for_neighbours(tile_, x, y, [&](std::size_t i) { around += tile_.share(i); });
                order.push_back({ratio(at) + 0.004f * around + 0.001f * spread_order(x, y),
                                 static_cast<std::uint32_t>(at)});
                wanted += static_cast<double>(tile_.share(at));
            }
        }
        const auto count = std::min(order.size(), static_cast<std::size_t>(std::lround(wanted)));
        std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                         order.end(), [](const ranked& a, const ranked& b) {
                             return a.key != b.key ? a.key > b.key : a.texel < b.texel;
                         });
        for (std::size_t i = 0; i < order.size(); ++i) {
            tile_.alpha(order[i].texel) = i < count ? 255 : 0;
        }
    }

    /// In [0, 1): neighbours get values far apart. Source: Roberts, "The unreasonable effectiveness
    /// of quasirandom sequences", 2018.
    [[nodiscard]] static float spread_order(int x, int y) noexcept {
        const double value = 0.7548776662466927 * x + 0.5698402909980532 * y;
        return static_cast<float>(value - std::floor(value));
    }

    /// Adds the texels nearest to opaque ones until the area is that of the tilted faces; no farther
    /// than two texels.
    void grow() {
        std::size_t opaque = 0;
        for (std::size_t i = 0; i < tile_.texel_count(); ++i) opaque += tile_.alpha(i) != 0;
        const auto wanted = static_cast<std::size_t>(std::lround(tile_.surface_area));
        if (opaque == 0 || wanted <= opaque) return;
        std::vector<std::int32_t> nearest(tile_.texel_count());
        nearest_scratch scratch;
        const auto is_opaque = [&](int x, int y) { return tile_.alpha(tile_.index(x, y)) != 0; };
        nearest_pixels(tile_.width, tile_.height, is_opaque, nearest, scratch);
        std::vector<ranked> order;
        for (int y = 0; y < tile_.height; ++y) {
            for (int x = 0; x < tile_.width; ++x) {
                const std::size_t at = tile_.index(x, y);
                const ivec2 to(nearest[at] % tile_.width - x, nearest[at] / tile_.width - y);
                const float distance = glm::length(vec2(to));
                if (distance == 0 || distance > 2) continue;
                order.push_back({distance - tile_.share(at) + 0.001f * spread_order(x, y),
                                 static_cast<std::uint32_t>(at)});
            }
        }
        const auto count = std::min(order.size(), wanted - opaque);
        std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                         order.end(), [](const ranked& a, const ranked& b) {
                             return a.key != b.key ? a.key < b.key : a.texel < b.texel;
                         });
        for (std::size_t i = 0; i < count; ++i) tile_.alpha(order[i].texel) = 255;
    }

    tile_picture& tile_;
    const alpha_options& options_;
};

[[nodiscard]] inline double area_wanted(const tile_picture& tile, opaque_area area) noexcept {
    return area == opaque_area::surface ? tile.surface_area : tile.covered_area();
}

[[nodiscard]] inline std::vector<float> shares_of(const tile_picture& tile) {
    std::vector<float> shares(tile.texel_count());
    for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = tile.share(i);
    return shares;
}

/// The share whose contour holds the area `wanted`, found by bisection.
[[nodiscard]] inline double contour_level(const alpha_block& shares, double wanted) noexcept {
    const dvec2 high(shares.width, shares.height);
    double low_level = 0.01;
    double high_level = 1;
    for (int i = 0; i < 12; ++i) {
        const double middle = 0.5 * (low_level + high_level);
        const double area = drawn_area(shares, dvec2(0), high, 1, static_cast<float>(middle));
        (area > wanted ? low_level : high_level) = middle;
    }
    return std::min(0.5 * (low_level + high_level), 0.99);
}

/// What is added to all distances so that filtering them draws the area `wanted`: what is finer than a
/// texel has no outline that distances to it could give back.
[[nodiscard]] inline float distance_shift(std::span<const float> distances, int width, int height,
                                          double spread, double wanted) {
    std::vector<float> alpha(distances.size());
    const alpha_block block{alpha, width, 0, 0, width, height};
    double low = -0.5;
    double high = 0.5;
    for (int i = 0; i < 8; ++i) {
        const double middle = 0.5 * (low + high);
        for (std::size_t k = 0; k < alpha.size(); ++k) {
            alpha[k] = static_cast<float>(0.5 + 0.5 * (static_cast<double>(distances[k]) + middle) /
                                                    spread);
        }
        const double area = drawn_area(block, dvec2(0), dvec2(width, height), 1, 0.5f);
        (area < wanted ? low : high) = middle;
    }
    return static_cast<float>(0.5 * (low + high));
}

inline void choose_distances(tile_picture& tile, const alpha_options& options) {
    const std::vector<float> shares = shares_of(tile);
    const bool is_given = options.area == opaque_area::thresholds;
    const double wanted = area_wanted(tile, options.area);
    const alpha_block block{shares, tile.width, 0, 0, tile.width, tile.height};
    const double level = is_given ? options.thresholds.foliage : contour_level(block, wanted);
    const std::vector<float> distances =
        signed_distances(shares, tile.width, tile.height, level, options.spread);
    const float shift =
        is_given ? 0.0f
                 : distance_shift(distances, tile.width, tile.height, options.spread, wanted);
    for (std::size_t i = 0; i < shares.size(); ++i) {
        tile.alpha(i) = byte_from_distance(distances[i] + shift, options.spread);
    }
}

inline void choose_coverage(tile_picture& tile, const alpha_options& options) {
    const std::vector<float> shares = shares_of(tile);
    const alpha_block block{shares, tile.width, 0, 0, tile.width, tile.height};
    const float scale = options.area == opaque_area::thresholds
                            ? static_cast<float>(0.5 / options.thresholds.foliage)
                            : alpha_scale(block, dvec2(0), dvec2(tile.width, tile.height),
                                          area_wanted(tile, options.area), 0.5f);
    for (std::size_t i = 0; i < shares.size(); ++i) {
        tile.alpha(i) = byte_from_unit(shares[i] * scale);
    }
}

}  // namespace detail

/// Sets the alpha of a tile from the covered samples.
///
/// Gives  an opaque area (alpha of 128 on, binary: counted; else as bilinear filtering draws it) as
///        options.area says: of leaves and of rods thinner than a texel to within a texel, of other
///        solids to within half a texel of their outline. At least one opaque texel where a sample
///        is covered.
/// Cost   O(texels), with distances O(texels · spread²).
inline void choose_alpha(tile_picture& tile, const alpha_options& options) {
    if (tile.texel_count() == 0) return;
    if (options.kind == alpha_kind::binary) detail::binary_alpha(tile, options).run();
    if (options.kind == alpha_kind::coverage) detail::choose_coverage(tile, options);
    if (options.kind == alpha_kind::distance) detail::choose_distances(tile, options);
    std::size_t most = 0;
    for (std::size_t i = 0; i < tile.texel_count(); ++i) {
        if (tile.alpha(i) >= 128) return;
        if (tile.covered[i] > tile.covered[most]) most = i;
    }
    if (tile.covered[most] > 0) tile.alpha(most) = 255;
}

}  // namespace billow::inline BILLOW_ABI
