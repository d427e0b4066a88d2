// Textures for a billboard cloud: from a mesh and its billboards to atlases.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 4.5.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/border.hpp>
#include <billow/bake/occlusion.hpp>
#include <billow/bake/pack.hpp>
#include <billow/bake/place_tiles.hpp>
#include <billow/bake/side_difference.hpp>
#include <billow/bake/surface.hpp>
#include <billow/bake/tile_alpha.hpp>
#include <billow/bake/tile_drawer.hpp>
#include <billow/bake/tile_outline.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

/// Which billboards get a tile for each of their sides.
enum class tile_sides : std::uint8_t {
    automatic,  ///< those whose sides look different
    one,        ///< none: the back shows the front's texels
    two,        ///< all
};

struct bake_options {
    int texels = 512;            ///< texels along the diameter of the bounding sphere
    double texels_per_unit = 0;  ///< texels a scene unit; 0: as `texels` says
    int max_atlas = 4096;        ///< longest side of an atlas, texels
    int max_atlases = 0;         ///< as many atlases at most, by coarser texels; 0: any number
    int padding = 8;             ///< texels around each tile; p keeps log2(p) mip levels clean
    bool power_of_two = false;   ///< sides of atlases are powers of two; costs area
    draw_options draw{};
    alpha_options alpha{};
    std::vector<coverage_thresholds> part_thresholds{};  ///< one a part; none: those of `alpha`
    int outline_corners = 0;  ///< at most so many corners a billboard, 4 or more; 0: rectangles
    tile_sides sides = tile_sides::one;      ///< normal_style::sheets: always two
    double side_difference = 0.1;            ///< of automatic sides, see side_difference()
    occlusion_options occlusion{.rays = 0};  ///< darkens what sees little sky; no rays: nothing
};

/// Enlarges every billboard about its centre to whole texels, at least one each way. Its texel
/// counts are then width / texel_size and height / texel_size, but for rounding.
inline void snap_to_texels(billboard_cloud& cloud, double texel_size) {
    for (billboard& b : cloud.billboards) {
        const auto whole = [texel_size](double extent) {
            return std::max(1.0, std::ceil(extent / texel_size - 1e-6)) * texel_size;
        };
        const double width = whole(b.width);
        const double height = whole(b.height);
        b.origin -= b.axes.u * ((width - b.width) * 0.5) + b.axes.v * ((height - b.height) * 0.5);
        b.width = width;
        b.height = height;
    }
}

/// Tiles of a cloud that are in no atlas yet.
struct drawn_tiles {
    std::vector<tile_picture> tiles{};     ///< as baked_cloud::tiles
    std::vector<std::uint32_t> back_of{};  ///< as baked_cloud::back_of
    std::vector<std::vector<dvec2>> outlines{};
    double texel_size = 0;
    double wanted_size = 0;
    double opaque_area = 0;
    double polygon_area = 0;
};

[[nodiscard]] inline pack_options packing_of(const bake_options& options) noexcept {
    return {.max_size = options.max_atlas,
            .padding = options.padding,
            .power_of_two = options.power_of_two};
}

namespace detail {

/// One call of draw_tiles; its methods are the steps in their order.
class tile_baker {
public:
    tile_baker(const mesh& source, billboard_cloud& cloud, const face_table& faces,
               const bake_options& options, parallel threads, const progress_function& progress)
        : cloud_(cloud),
          faces_(faces),
          options_(options),
          draw_(options.draw),
          threads_(threads),
          progress_(progress),
          look_(source) {
        draw_.measures_surface = options.alpha.area == opaque_area::surface;
    }

    [[nodiscard]] drawn_tiles run() {
        choose_texel_size();
        snap_to_texels(cloud_, drawn_.texel_size);
        measure_sky();
        draw_fronts();
        draw_backs();
        choose_alphas();
        crop();
        find_outlines();
        measure_areas();
        return std::move(drawn_);
    }

private:
    /// Luksch 2009, eq 4.1: the same object size for every texel. Where a billboard would not fit
    /// into an atlas, or all into as many as are allowed, all become coarser.
    void choose_texel_size() {
        double largest = 0;
        for (const billboard& b : cloud_.billboards) {
            largest = std::max({largest, b.width, b.height});
        }
        double wanted = options_.texels_per_unit > 0 ? 1 / options_.texels_per_unit
                                                     : 2 * cloud_.bounds.radius / options_.texels;
        if (!(wanted > 0)) wanted = 1;  // a single point has no size
        drawn_.wanted_size = wanted;
        drawn_.texel_size = std::max(wanted, largest / largest_side(packing_of(options_)));
        if (options_.max_atlases == 0) return;
        const double sides = options_.sides == tile_sides::one ? 1 : 2;
        for (; largest > drawn_.texel_size; drawn_.texel_size *= 1.03) {
            std::vector<ivec2> sizes;
            for (const billboard& b : cloud_.billboards) {
                const auto texels = [&](double extent) {
                    return std::max(1, static_cast<int>(std::ceil(extent / drawn_.texel_size)));
                };
                for (int side = 0; side < sides; ++side) {
                    sizes.emplace_back(texels(b.width), texels(b.height));
                }
            }
            const packing places = pack_rectangles(sizes, packing_of(options_));
            if (places.atlas_sizes.size() <= static_cast<std::size_t>(options_.max_atlases)) return;
        }
    }

    void measure_sky() {
        if (options_.occlusion.rays == 0) return;
        sky_ = see_sky(look_, faces_, options_.occlusion, threads_);
        look_.light_by(sky_);
    }

    [[nodiscard]] auto progress_between(double from, double to) const {
        return [this, from, to](double share) {
            report(progress_, "bake", from + (to - from) * share);
        };
    }
    [[nodiscard]] bool draws_two_sides() const noexcept {
        return options_.sides == tile_sides::two || draw_.normals == normal_style::sheets;
    }

    void draw_fronts() {
        std::vector<plane_id> all(cloud_.billboards.size());
        std::iota(all.begin(), all.end(), plane_id{0});
        const tile_drawer drawer(look_, faces_, cloud_, drawn_.texel_size, draw_, threads_);
        drawn_.tiles = drawer.draw(all, draw_.supersample,
                                   progress_between(0.05, draws_two_sides() ? 0.45 : 0.8));
    }

    void draw_backs() {
        if (options_.sides == tile_sides::one && !draws_two_sides()) return;
        const billboard_cloud back = turned_round(cloud_);
        const tile_drawer drawer(look_, faces_, back, drawn_.texel_size, draw_, threads_);
        std::vector<plane_id> wanted(cloud_.billboards.size());
        std::iota(wanted.begin(), wanted.end(), plane_id{0});
        if (!draws_two_sides()) {
            const auto probes = drawer.draw(wanted, 1, [](double) {});
            std::erase_if(wanted, [&](plane_id id) {
                return side_difference(drawn_.tiles[id], probes[id]) <= options_.side_difference;
            });
            if (wanted.empty()) return;
        }
        drawn_.back_of.assign(cloud_.billboards.size(), no_id);
        std::vector<tile_picture> backs =
            drawer.draw(wanted, draw_.supersample, progress_between(0.45, 0.8));
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            drawn_.back_of[wanted[i]] = static_cast<std::uint32_t>(drawn_.tiles.size());
            drawn_.tiles.push_back(std::move(backs[i]));
        }
    }

    void choose_alphas() {
        std::vector<plane_id> plane_of(drawn_.tiles.size());
        std::iota(plane_of.begin(), plane_of.end(), plane_id{0});
        for (plane_id id = 0; id < drawn_.back_of.size(); ++id) {
            if (drawn_.back_of[id] != no_id) plane_of[drawn_.back_of[id]] = id;
        }
        threads_.for_chunks(drawn_.tiles.size(), 1, [&](std::size_t i, std::size_t) {
            alpha_options how = options_.alpha;
            if (!options_.part_thresholds.empty()) {
                how.thresholds = options_.part_thresholds[cloud_.part_of(plane_of[i])];
            }
            choose_alpha(drawn_.tiles[i], how);
        });
    }

    [[nodiscard]] tile_picture* back_of(plane_id id) noexcept {
        const bool has_back = !drawn_.back_of.empty() && drawn_.back_of[id] != no_id;
        return has_back ? &drawn_.tiles[drawn_.back_of[id]] : nullptr;
    }

    /// Cuts off rows and columns that are nowhere opaque, from tiles and billboards.
    void crop() {
        for (plane_id id = 0; id < cloud_.billboards.size(); ++id) {
            tile_picture& front = drawn_.tiles[id];
            tile_picture* back = back_of(id);
            texel_box box = drawn_box(front);
            if (back != nullptr) box = joined(box, mirrored(drawn_box(*back), back->width));
            if (box.width == 0) box = {0, 0, 1, 1};
            front.box = box;
            if (back != nullptr) back->box = mirrored(box, back->width);
            billboard& b = cloud_.billboards[id];
            const double below = front.height - box.y - box.height;
            b.origin +=
                b.axes.u * (box.x * drawn_.texel_size) + b.axes.v * (below * drawn_.texel_size);
            b.width = box.width * drawn_.texel_size;
            b.height = box.height * drawn_.texel_size;
        }
    }

    void find_outlines() {
        if (options_.outline_corners == 0) return;
        drawn_.outlines.resize(cloud_.billboards.size());
        threads_.for_chunks(cloud_.billboards.size(), 1, [&](std::size_t i, std::size_t) {
            const auto id = static_cast<plane_id>(i);
            std::vector<dvec2> corners;
            add_drawn_corners(drawn_.tiles[id], false, corners);
            if (const tile_picture* back = back_of(id)) add_drawn_corners(*back, true, corners);
            const texel_box& box = drawn_.tiles[id].box;
            drawn_.outlines[id] = outline_around(std::move(corners), {box.width, box.height},
                                                 options_.outline_corners);
        });
    }

    void measure_areas() {
        for (plane_id id = 0; id < cloud_.billboards.size(); ++id) {
            const tile_picture& front = drawn_.tiles[id];
            for (std::size_t i = 0; i < front.texel_count(); ++i) {
                drawn_.opaque_area += front.alpha(i) >= 128;
            }
            const double box = static_cast<double>(front.box.width) * front.box.height;
            drawn_.polygon_area +=
                drawn_.outlines.empty() ? box : box * 0.5 * doubled_area(drawn_.outlines[id]);
        }
    }

    billboard_cloud& cloud_;
    const face_table& faces_;
    const bake_options& options_;
    draw_options draw_;
    parallel threads_;
    const progress_function& progress_;
    surface look_;
    sky_table sky_{};
    drawn_tiles drawn_{};
};

/// Empties channels that hold what a reader would assume without them.
inline void drop_if_all(baked_cloud& baked, image atlas::*channel, const std::array<int, 3>& low,
                        const std::array<int, 3>& high) {
    for (const atlas& a : baked.atlases) {
        const image& values = a.*channel;
        for (std::size_t i = 0; i < a.base_color.bytes.size() / 4; ++i) {
            if (a.base_color.bytes[4 * i + 3] == 0) continue;
            for (std::size_t c = 0; c < 3; ++c) {
                const int value = values.bytes[3 * i + c];
                if (value < low[c] || value > high[c]) return;
            }
        }
    }
    for (atlas& a : baked.atlases) a.*channel = {};
}

inline void drop_silent_channels(baked_cloud& baked) {
    const bool is_tangent_space =
        baked.normals == normal_style::folded || baked.normals == normal_style::sheets;
    if (is_tangent_space) drop_if_all(baked, &atlas::normal, {127, 127, 254}, {129, 129, 255});
    drop_if_all(baked, &atlas::occlusion_roughness_metallic, {255, 255, 0}, {255, 255, 0});
    drop_if_all(baked, &atlas::emissive, {0, 0, 0}, {0, 0, 0});
}

}  // namespace detail

/// Draws the tiles of a cloud's billboards. Each billboard shows its mapped and also-drawn faces and
/// all others of its part that are valid for its plane or, if wanted, reach into its envelope, seen
/// from its front, within the depth of the first two kinds.
///
/// Needs  `faces` is the table of `source`; billboards as fit_billboards gives them.
/// Gives  tiles; `cloud.billboards` are moved to whole texels and cropped to what is opaque, so that
///        every texel covers a square of texel_size. That is what options ask for, or more where a
///        tile would not fit into an atlas.
/// Cost   O(samples × faces that overlap), parallel over bands of tiles; 15 bytes a texel, and for
///        each thread 8 bytes a sample of a band.
/// Source Luksch 2009, section 4.5. Differs: faces that are merely valid are drawn, too.
[[nodiscard]] inline drawn_tiles draw_tiles(const mesh& source, const face_table& faces,
                                            billboard_cloud& cloud,
                                            const bake_options& options = {}, parallel threads = {},
                                            const progress_function& progress = {}) {
    BILLOW_ASSERT(cloud.billboards.size() == cloud.plane_count());
    BILLOW_ASSERT(cloud.plane_of_face.size() == source.face_count());
    BILLOW_ASSERT(!options.draw.with_horizon || options.occlusion.rays > 0);
    BILLOW_ASSERT(options.texels > 0 && options.padding >= 0);
    BILLOW_ASSERT(options.draw.supersample >= 1 && options.draw.supersample <= max_supersample);
    BILLOW_ASSERT(options.max_atlas > 2 * options.padding + 4);
    BILLOW_ASSERT(options.outline_corners == 0 || options.outline_corners >= 4);
    BILLOW_ASSERT(options.draw.envelope_scale > 0 && options.draw.envelope_scale <= 1);
    BILLOW_ASSERT(options.part_thresholds.empty() ||
                  options.part_thresholds.size() >= cloud.parts.size());
    return detail::tile_baker(source, cloud, faces, options, threads, progress).run();
}

/// Packs drawn tiles into atlases and gives colours to what is transparent in them.
///
/// Cost  of the packer, and O(texels), parallel over tiles and rows.
[[nodiscard]] inline baked_cloud pack_tiles(drawn_tiles&& drawn, const bake_options& options,
                                            parallel threads = {}) {
    placed_tiles placed =
        place_tiles(drawn.tiles, packing_of(options), options.draw.normals, threads);
    drawn.tiles.clear();
    baked_cloud baked;
    baked.tiles = std::move(placed.tiles);
    baked.back_of = std::move(drawn.back_of);
    baked.outlines = std::move(drawn.outlines);
    baked.atlases = std::move(placed.atlases);
    baked.normals = options.draw.normals;
    baked.texel_size = drawn.texel_size;
    baked.wanted_size = drawn.wanted_size;
    baked.fill = placed.fill;
    baked.opaque_area = drawn.opaque_area;
    baked.polygon_area = drawn.polygon_area;
    detail::drop_silent_channels(baked);
    fill_borders(baked, placed.is_covered, options.padding, threads);
    return baked;
}

/// draw_tiles, then pack_tiles.
[[nodiscard]] inline baked_cloud bake_cloud(const mesh& source, const face_table& faces,
                                            billboard_cloud& cloud,
                                            const bake_options& options = {}, parallel threads = {},
                                            const progress_function& progress = {}) {
    drawn_tiles drawn = draw_tiles(source, faces, cloud, options, threads, progress);
    report(progress, "bake", 0.85);
    baked_cloud baked = pack_tiles(std::move(drawn), options, threads);
    report(progress, "bake", 1);
    return baked;
}

}  // namespace billow::inline BILLOW_ABI
