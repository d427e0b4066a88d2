// Mip levels of baked atlases: as much of every tile is drawn on each level, and tiles never mix.
//
// Alpha is scaled for each tile and level by itself, see alpha_coverage.hpp: with one factor for a
// whole atlas dense tiles would grow where thin ones vanish.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/border.hpp>
#include <billow/bake/horizon.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/image/alpha_coverage.hpp>
#include <billow/image/image.hpp>
#include <billow/image/mip_chain.hpp>
#include <billow/image/srgb.hpp>

namespace billow::inline BILLOW_ABI {

struct mip_options {
    int padding = 8;      ///< texels around each tile, as they were baked
    float cutoff = 0.5f;  ///< alpha from which on a texel is drawn
    int levels = 0;       ///< how many, the atlas itself counted; 0: down to 1 × 1
};

/// The levels of an atlas, channel by channel. Level 0 is the atlas itself, each further one half as
/// large, rounded down, at least 1. A channel that the atlas lacks has no levels.
struct atlas_mips {
    std::vector<image> base_color{};
    std::vector<image> normal{};
    std::vector<image> occlusion_roughness_metallic{};
    std::vector<image> emissive{};
    std::vector<image> horizon{};
    int safe_levels = 1;  ///< see safe_mip_levels
};

/// How many levels of an atlas of this size can be drawn, level 0 counted, before a bilinear filter
/// at a tile's edge reads what belongs to another tile: 1 + log2(padding) where sides are powers of
/// two. Half a texel beyond the edge is read at most, so the middle of the farthest texel read lies
/// less than a texel of that level away, and within the padding when that is as wide.
[[nodiscard]] inline int safe_mip_levels(int padding, int width, int height) noexcept {
    int count = 1;
    for (int w = width, h = height; w > 1 || h > 1; ++count) {
        w = std::max(1, w / 2);
        h = std::max(1, h / 2);
        // In 64 bits: a texel of that level is width / w wide and height / h high.
        if (std::int64_t{padding} * w < width || std::int64_t{padding} * h < height) break;
    }
    return count;
}

namespace detail {

/// A level of an atlas: whose texels are, and their alpha before it is scaled.
struct mip_layout {
    int width = 0;
    int height = 0;
    std::vector<std::uint32_t> owner{};  ///< tile, no_id between them
    std::vector<float> alpha{};
    std::vector<pixel_rectangle>
        owned{};  ///< texels of each tile; empty for those of other atlases
};

/// The texels of a level whose middles lie within `area`, texels of level 0. By the middle, not by
/// the larger share: at a corner a neighbour along an edge may have the larger one.
[[nodiscard]] inline pixel_rectangle owned_texels(const pixel_rectangle& area, const ivec2& base,
                                                  const ivec2& level) noexcept {
    const auto first = [](int at, int from, int to) {  // i + 0.5 >= at * to / from
        const std::int64_t twice = std::int64_t{2} * at * to - from;
        return twice <= 0 ? 0 : static_cast<int>((twice + 2 * from - 1) / (2 * from));
    };
    const ivec2 low(first(area.x, base.x, level.x), first(area.y, base.y, level.y));
    const ivec2 high(first(area.x + area.width, base.x, level.x),
                     first(area.y + area.height, base.y, level.y));
    return {low.x, low.y, high.x - low.x, high.y - low.y};
}

/// One call of make_mips for one atlas; its methods are the steps in their order.
class mip_maker {
public:
    mip_maker(const baked_cloud& baked, atlas_id id, const mip_options& options, parallel threads)
        : baked_(baked), atlas_(baked.atlases[id]), id_(id), options_(options), threads_(threads) {}

    [[nodiscard]] atlas_mips run() {
        lay_out();
        atlas_mips mips;
        mips.safe_levels = safe_mip_levels(options_.padding, atlas_.width(), atlas_.height());
        const auto colour = [](const std::uint8_t* p) {
            const auto& light = linear_of_srgb_byte();
            return vec4(light[p[0]], light[p[1]], light[p[2]], 0);
        };
        const auto colour_bytes = [](const vec4& v, std::uint8_t* p) {
            for (int c = 0; c < 3; ++c) p[c] = srgb_byte_from_linear(v[c]);
        };
        mips.base_color = levels_of(atlas_.base_color, colour, colour_bytes);
        keep_coverage(mips.base_color);
        mips.emissive = levels_of(atlas_.emissive, colour, colour_bytes);
        mips.normal = levels_of(
            atlas_.normal,
            [](const std::uint8_t* p) {
                return vec4(vec3(p[0], p[1], p[2]) * (2.0f / 255.0f) - 1.0f, 0);
            },
            [](const vec4& v, std::uint8_t* p) {
                const float length = glm::length(vec3(v));
                const vec3 n = length > 1e-6f ? vec3(v) / length : vec3(0, 0, 1);
                for (int c = 0; c < 3; ++c) p[c] = byte_from_unit(n[c] * 0.5f + 0.5f);
            });
        mips.occlusion_roughness_metallic = levels_of(
            atlas_.occlusion_roughness_metallic,
            [](const std::uint8_t* p) { return vec4(p[0], p[1], p[2], 0) / 255.0f; },
            [](const vec4& v, std::uint8_t* p) {
                for (int c = 0; c < 3; ++c) p[c] = byte_from_unit(v[c]);
            });
        // Cones are averaged as the directions that they let through.
        mips.horizon = levels_of(
            atlas_.horizon,
            [](const std::uint8_t* p) {
                const horizon_cone cone = decode_horizon(p);
                const float visible = (1 - cone.cosine) / 2;
                return vec4(cone.axis * visible, visible);
            },
            [](const vec4& v, std::uint8_t* p) {
                const auto bytes = encode_horizon(cone_of(v));
                std::copy(bytes.begin(), bytes.end(), p);
            });
        return mips;
    }

private:
    void lay_out() {
        const ivec2 base(atlas_.width(), atlas_.height());
        ivec2 size = base;
        while (true) {
            mip_layout& level = layouts_.emplace_back();
            level.width = size.x;
            level.height = size.y;
            const auto texels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
            level.owner.assign(texels, no_id);
            level.owned.resize(baked_.tiles.size());
            for (std::uint32_t t = 0; t < baked_.tiles.size(); ++t) {
                if (baked_.tiles[t].atlas != id_) continue;
                const auto area = padded(baked_.tiles[t], atlas_, options_.padding);
                const auto owned = level.owned[t] = owned_texels(area, base, size);
                for (int y = owned.y; y < owned.y + owned.height; ++y) {
                    std::fill_n(level.owner.begin() + std::ptrdiff_t{y} * size.x + owned.x,
                                owned.width, t);
                }
            }
            level.alpha.resize(texels);
            if (layouts_.size() == 1) {
                for (std::size_t i = 0; i < texels; ++i) {
                    level.alpha[i] =
                        static_cast<float>(atlas_.base_color.bytes[4 * i + 3]) / 255.0f;
                }
            } else {
                const mip_layout& above = layouts_[layouts_.size() - 2];
                for_texels(above, level, [&](std::size_t at, const auto& visit) {
                    float sum = 0;
                    float weight = 0;
                    visit([&](std::size_t i, float w) {
                        sum += w * above.alpha[i];
                        weight += w;
                    });
                    level.alpha[at] = sum / weight;
                });
            }
            const bool is_last = static_cast<int>(layouts_.size()) == options_.levels;
            if (is_last || (size.x == 1 && size.y == 1)) return;
            size = ivec2(std::max(1, size.x / 2), std::max(1, size.y / 2));
        }
    }

    /// Calls `body(texel, visit)` for every texel of `below`; `visit(take)` calls `take(i, weight)`
    /// for the texels of `above` under it that belong to its tile, or for all where none does.
    template <class Body>
    void for_texels(const mip_layout& above, const mip_layout& below, const Body& body) const {
        const auto columns = box_taps_of(above.width, below.width);
        const auto rows = box_taps_of(above.height, below.height);
        const auto width = static_cast<std::size_t>(below.width);
        threads_.for_chunks(rows.size(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t at = begin * width; at < end * width; ++at) {
                const box_taps& row = rows[at / width];
                const box_taps& column = columns[at % width];
                body(at, [&](const auto& take) {
                    for (const bool takes_all : {false, true}) {
                        bool has_taken = false;
                        for (int k = 0; k < row.count * column.count; ++k) {
                            const auto x = static_cast<std::size_t>(k % column.count);
                            const auto y = static_cast<std::size_t>(k / column.count);
                            const std::size_t i = (static_cast<std::size_t>(row.first) + y) *
                                                      static_cast<std::size_t>(above.width) +
                                                  static_cast<std::size_t>(column.first) + x;
                            if (!takes_all && above.owner[i] != below.owner[at]) continue;
                            take(i, row.weight[y] * column.weight[x]);
                            has_taken = true;
                        }
                        if (has_taken) return;
                    }
                });
            }
        });
    }

    /// The mean of a level's values under each texel of the next, weighted by alpha; of the borders'
    /// values where all is transparent.
    template <class Value>
    [[nodiscard]] std::vector<vec4> lowered(std::size_t level, const Value& value) const {
        const mip_layout& above = layouts_[level - 1];
        std::vector<vec4> result(layouts_[level].alpha.size());
        for_texels(above, layouts_[level], [&](std::size_t at, const auto& visit) {
            vec4 seen(0);
            vec4 all(0);
            float seen_weight = 0;
            float all_weight = 0;
            visit([&](std::size_t i, float w) {
                const vec4 v = value(i);
                const float a = w * above.alpha[i];
                seen += v * a;
                seen_weight += a;
                all += v * w;
                all_weight += w;
            });
            result[at] = seen_weight > 0 ? seen / seen_weight : all / all_weight;
        });
        return result;
    }

    template <class Decode, class Encode>
    [[nodiscard]] std::vector<image> levels_of(const image& source, const Decode& decode,
                                               const Encode& encode) const {
        std::vector<image> chain;
        if (source.empty()) return chain;
        chain.push_back(source);
        const auto channels = static_cast<std::size_t>(source.channels);
        std::vector<vec4> values;
        for (std::size_t level = 1; level < layouts_.size(); ++level) {
            values = level == 1 ? lowered(level,
                                          [&](std::size_t i) {
                                              return decode(source.bytes.data() + i * channels);
                                          })
                                : lowered(level, [&](std::size_t i) { return values[i]; });
            image& to = chain.emplace_back(
                image::filled(layouts_[level].width, layouts_[level].height, source.channels, 0));
            threads_.for_chunks(values.size(), 4096, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    encode(values[i], to.bytes.data() + i * channels);
                }
            });
        }
        return chain;
    }

    /// Writes alpha, scaled so that as much of each tile is drawn as on level 0.
    void keep_coverage(std::vector<image>& chain) const {
        for (std::size_t level = 1; level < layouts_.size(); ++level) {
            const std::vector<float>& alpha = layouts_[level].alpha;
            for (std::size_t i = 0; i < alpha.size(); ++i) {
                chain[level].bytes[4 * i + 3] = byte_from_unit(alpha[i]);
            }
        }
        threads_.for_chunks(baked_.tiles.size(), 1, [&](std::size_t t, std::size_t) {
            const tile& in = baked_.tiles[t];
            if (in.atlas != id_) return;
            const dvec2 low(in.x, in.y);
            const dvec2 high = low + dvec2(in.width, in.height);
            const double wanted = drawn_area(block_of(0, t), low, high, 1, options_.cutoff);
            for (std::size_t level = 1; level < layouts_.size(); ++level) {
                const alpha_block block = block_of(level, t);
                if (block.width <= 0 || block.height <= 0) continue;
                const dvec2 shrink(static_cast<double>(layouts_[level].width) / atlas_.width(),
                                   static_cast<double>(layouts_[level].height) / atlas_.height());
                const float scale = alpha_scale(block, low * shrink, high * shrink,
                                                wanted * shrink.x * shrink.y, options_.cutoff);
                for (int y = block.y; y < block.y + block.height; ++y) {
                    for (int x = block.x; x < block.x + block.width; ++x) {
                        chain[level].pixel(x, y)[3] = byte_from_unit(block.at(x, y) * scale);
                    }
                }
            }
        });
    }

    [[nodiscard]] alpha_block block_of(std::size_t level, std::size_t t) const noexcept {
        const mip_layout& in = layouts_[level];
        const pixel_rectangle& owned = in.owned[t];
        return {in.alpha, in.width, owned.x, owned.y, owned.width, owned.height};
    }

    const baked_cloud& baked_;
    const atlas& atlas_;
    atlas_id id_;
    mip_options options_;
    parallel threads_;
    std::vector<mip_layout> layouts_{};
};

}  // namespace detail

/// The mip levels of every atlas. Colours are averaged in linear light, all channels are weighted by
/// alpha, normals have unit length again, and each texel is made of one tile's texels alone: of the
/// tile in whose padding its middle lies.
///
/// Of a tile, an alpha test draws the same area on every safe level to within 2 % as long as some
/// twenty texels of it are drawn; fewer are too coarse to say it.
///
/// Needs  what fill_borders has filled, tiles whose paddings do not overlap; cutoff in (0, 1].
/// Cost   O(texels), parallel over rows and tiles; 16 bytes a texel of the atlas while it works.
[[nodiscard]] inline std::vector<atlas_mips> make_mips(const baked_cloud& baked,
                                                       const mip_options& options = {},
                                                       parallel threads = {}) {
    BILLOW_ASSERT(options.padding >= 0 && options.levels >= 0);
    BILLOW_ASSERT(options.cutoff > 0 && options.cutoff <= 1);
    std::vector<atlas_mips> mips;
    for (atlas_id id = 0; id < baked.atlases.size(); ++id) {
        mips.push_back(detail::mip_maker(baked, id, options, threads).run());
    }
    return mips;
}

}  // namespace billow::inline BILLOW_ABI
