// Textures for a billboard cloud: from a mesh and its billboards to atlases.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 4.5.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/border.hpp>
#include <billow/bake/draw_set.hpp>
#include <billow/bake/occlusion.hpp>
#include <billow/bake/pack.hpp>
#include <billow/bake/surface.hpp>
#include <billow/bake/texel.hpp>
#include <billow/bake/visibility.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/improve/envelope.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

struct bake_options {
    int texels = 512;           ///< texels along the diameter of the bounding sphere
    int max_atlas = 4096;       ///< longest side of an atlas, texels
    int supersample = 4;        ///< samples a texel side, 1 to 8; time grows with its square
    int padding = 8;            ///< texels around each tile; p keeps log2(p) mip levels clean
    bool power_of_two = false;  ///< sides of atlases are powers of two; costs area
    double max_extra_angle = 75 * std::numbers::pi / 180;  ///< radians between a plane and other
                                                           ///< valid faces drawn on it; 0: none
    coverage_thresholds thresholds{};
    std::vector<coverage_thresholds> part_thresholds{};  ///< one a part; none: `thresholds` for all
    crack_reduction cracks = crack_reduction::none;
    occlusion_options occlusion{.rays = 0};  ///< darkens what sees little sky; no rays: nothing
    bool with_horizon = false;               ///< atlas::horizon, measured by the same rays
    double envelope_scale =
        1;  ///< size of the boxes that faces must reach into, above 0 to 1: less
            ///< is drawn where it does not belong, more cracks stay
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

namespace detail {

/// One call of bake_cloud; its methods are the steps in their order.
class cloud_baker {
public:
    cloud_baker(const mesh& source, billboard_cloud& cloud, const face_table& faces,
                const bake_options& options, parallel threads, const progress_function& progress)
        : cloud_(cloud),
          faces_(faces),
          options_(options),
          threads_(threads),
          progress_(progress),
          look_(source) {}

    [[nodiscard]] baked_cloud run() {
        choose_texel_size();
        snap_to_texels(cloud_, baked_.texel_size);
        place_tiles();
        measure_sky();
        draw_tiles();
        report(progress_, "bake", 0.9);
        ensure_every_tile_shows();
        drop_silent_channels();
        fill_borders(baked_, options_.padding, threads_);
        report(progress_, "bake", 1);
        return std::move(baked_);
    }

private:
    static constexpr int band_height = 16;  ///< texel rows drawn at a time: bounds the memory

    struct job {
        plane_id plane = 0;
        int band = 0;
    };
    /// What a job found, to decide over the whole tile.
    struct job_result {
        bool has_opaque = false;
        int most_samples = 0;
        ivec2 best{0};  ///< the texel with most samples, of a tile without opaque ones
    };
    struct job_scratch {
        visibility_buffer buffer;
        view_shader shader;
    };

    [[nodiscard]] pack_options packing_options() const noexcept {
        return {.max_size = options_.max_atlas,
                .padding = options_.padding,
                .power_of_two = options_.power_of_two};
    }

    /// Luksch 2009, eq 4.1: the same object size for every texel. Where a billboard would not fit
    /// into an atlas, all become coarser.
    void choose_texel_size() {
        double largest = 0;
        for (const billboard& b : cloud_.billboards) {
            largest = std::max({largest, b.width, b.height});
        }
        const double wanted = 2 * cloud_.bounds.radius / options_.texels;
        baked_.texel_size = std::max(wanted, largest / largest_side(packing_options()));
        if (!(baked_.texel_size > 0)) baked_.texel_size = 1;  // a single point has no size
    }

    [[nodiscard]] ivec2 upright_size(const billboard& b) const noexcept {
        return {static_cast<int>(std::lround(b.width / baked_.texel_size)),
                static_cast<int>(std::lround(b.height / baked_.texel_size))};
    }

    void place_tiles() {
        std::vector<ivec2> sizes;
        for (const billboard& b : cloud_.billboards) sizes.push_back(upright_size(b));
        const packing places = pack_rectangles(sizes, packing_options());
        double tile_area = 0;
        double atlas_area = 0;
        for (const ivec2& size : places.atlas_sizes) {
            baked_.atlases.push_back(
                {image::filled(size.x, size.y, 4, 0), image::filled(size.x, size.y, 3, 0),
                 image::filled(size.x, size.y, 3, 0), image::filled(size.x, size.y, 3, 0)});
            if (options_.with_horizon) {
                baked_.atlases.back().horizon = image::filled(size.x, size.y, 4, 0);
            }
            atlas_area += static_cast<double>(size.x) * size.y;
        }
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            const packed_rectangle& r = places.rectangles[i];
            const ivec2 size = r.is_rotated ? ivec2(sizes[i].y, sizes[i].x) : sizes[i];
            baked_.tiles.push_back({r.atlas, r.x, r.y, size.x, size.y, r.is_rotated});
            tile_area += static_cast<double>(size.x) * size.y;
        }
        baked_.fill = atlas_area > 0 ? tile_area / atlas_area : 0;
    }

    void measure_sky() {
        if (options_.occlusion.rays == 0) return;
        sky_ = see_sky(look_, faces_, options_.occlusion, threads_);
        look_.light_by(sky_);
    }

    void draw_tiles() {
        const int s = options_.supersample;
        std::size_t widest = 0;
        for (plane_id id = 0; id < cloud_.billboards.size(); ++id) {
            const billboard& b = cloud_.billboards[id];
            const ivec2 size = upright_size(b);
            const orthographic_view view{b.axes, b.origin + b.axes.v * b.height,
                                         baked_.texel_size / s};
            targets_.push_back({view, size.x * s, size.y * s, band_height * s});
            widest = std::max(widest, static_cast<std::size_t>(size.x * s));
            for (int band = 0; band * band_height < size.y; ++band) jobs_.push_back({id, band});
        }
        results_.resize(jobs_.size());
        const draw_set_options extras{
            options_.max_extra_angle > 0 ? std::cos(options_.max_extra_angle) : 2, options_.cracks,
            options_.envelope_scale};
        const draw_sets sets(faces_, cloud_, targets_, extras, threads_);
        report(progress_, "bake", 0.05);

        std::vector<job_scratch> scratches(
            threads_.count(), job_scratch{visibility_buffer(s), view_shader(look_, s)});
        for (job_scratch& scratch : scratches) {
            scratch.buffer.reserve(widest * static_cast<std::size_t>(band_height * s));
        }
        // Progress is told by the calling thread, so between slices of the jobs.
        const std::size_t slices = progress_ ? 16 : 1;
        for (std::size_t i = 0; i < slices; ++i) {
            const std::size_t begin = jobs_.size() * i / slices;
            const std::size_t end = jobs_.size() * (i + 1) / slices;
            for_jobs(threads_, end - begin, scratches, [&](std::size_t k, auto& scratch) {
                const job& j = jobs_[begin + k];
                results_[begin + k] = draw_band(j, sets[j.plane], scratch);
            });
            report(progress_, "bake",
                   0.05 + 0.85 * static_cast<double>(end) / static_cast<double>(jobs_.size()));
        }
    }

    [[nodiscard]] const coverage_thresholds& thresholds_of(plane_id id) const noexcept {
        return options_.part_thresholds.empty() ? options_.thresholds
                                                : options_.part_thresholds[cloud_.part_of(id)];
    }

    [[nodiscard]] job_result draw_band(const job& j, std::span<const drawn_face> faces,
                                       job_scratch& scratch) noexcept {
        const int s = options_.supersample;
        const draw_target& target = targets_[j.plane];
        const billboard& board = cloud_.billboards[j.plane];
        const int first = j.band * band_height;
        const int last = std::min(first + band_height, target.rows / s);
        scratch.buffer.start({0, first * s, target.columns, last * s});
        const double slack = 1e-5 * std::max(cloud_.bounds.radius, baked_.texel_size);
        const depth_range range{board.depth_low - slack, board.depth_high + slack};
        for (const drawn_face& f : faces) {
            if (f.first_band <= j.band && j.band <= f.last_band) {
                scratch.buffer.draw(look_, target.view, f.face, range);
            }
        }
        scratch.shader.start(target.view);
        const coverage_thresholds& thresholds = thresholds_of(j.plane);
        const tile& t = baked_.tiles[j.plane];
        job_result result;
        for (int y = first; y < last; ++y) {
            for (int x = 0; x < target.columns / s; ++x) {
                const texel value = resolve_texel(scratch.buffer, scratch.shader, look_, x, y, s,
                                                  thresholds, vec3(board.axes.normal));
                if (value.samples == 0) continue;
                write_texel(baked_.atlases[t.atlas], t, board.axes, x, y, value);
                result.has_opaque |= value.is_opaque;
                if (value.samples > result.most_samples) {
                    result.most_samples = value.samples;
                    result.best = {x, y};
                }
            }
        }
        return result;
    }

    /// A tile without any opaque texel keeps its best covered one; one whose faces slip between all
    /// samples shows the centre of its largest face.
    void ensure_every_tile_shows() {
        std::vector<job_result> of_plane(cloud_.billboards.size());
        for (std::size_t i = 0; i < jobs_.size(); ++i) {
            job_result& total = of_plane[jobs_[i].plane];
            total.has_opaque |= results_[i].has_opaque;
            if (results_[i].most_samples > total.most_samples) {
                total.most_samples = results_[i].most_samples;
                total.best = results_[i].best;
            }
        }
        const std::vector<std::size_t> largest_row = largest_rows();
        for (plane_id id = 0; id < of_plane.size(); ++id) {
            if (of_plane[id].has_opaque) continue;
            const tile& t = baked_.tiles[id];
            if (of_plane[id].most_samples > 0) {
                const ivec2 at = texel_position(t, of_plane[id].best.x, of_plane[id].best.y);
                baked_.atlases[t.atlas].base_color.pixel(at.x, at.y)[3] = 255;
            } else if (largest_row[id] != no_id) {
                draw_centre(id, largest_row[id]);
            }
        }
    }

    /// The row of the largest face of each plane, among those that are drawn there by right.
    [[nodiscard]] std::vector<std::size_t> largest_rows() const {
        std::vector<std::size_t> largest_row(cloud_.plane_count(), no_id);
        std::vector<std::size_t> row_of_face(cloud_.plane_of_face.size(), no_id);
        const auto consider = [&](plane_id plane, std::size_t row) {
            std::size_t& largest = largest_row[plane];
            if (largest == no_id || faces_.area[row] > faces_.area[largest]) largest = row;
        };
        for (std::size_t row = 0; row < faces_.size; ++row) {
            const face_id face = faces_.source[row];
            row_of_face[face] = row;
            if (const plane_id plane = cloud_.plane_of_face[face]; plane != no_id) {
                consider(plane, row);
            }
        }
        for (const drawn_too& d : cloud_.also_drawn) {
            if (const std::size_t row = row_of_face[d.face]; row != no_id) consider(d.plane, row);
        }
        return largest_row;
    }

    void draw_centre(plane_id id, std::size_t row) {
        const int s = options_.supersample;
        const draw_target& target = targets_[id];
        const billboard& board = cloud_.billboards[id];
        const dvec2 centre(target.view.project(faces_.centroid(row) + faces_.bounds.centre));
        view_shader shader(look_, s);
        shader.start(target.view);
        const texel value{shader.at(faces_.source[row], centre), 1, true};
        const int x = std::clamp(static_cast<int>(centre.x) / s, 0, target.columns / s - 1);
        const int y = std::clamp(static_cast<int>(centre.y) / s, 0, target.rows / s - 1);
        const tile& t = baked_.tiles[id];
        write_texel(baked_.atlases[t.atlas], t, board.axes, x, y, value);
    }

    /// Empties channels that hold what a reader would assume without them.
    void drop_silent_channels() {
        drop_if_all(&atlas::normal, {127, 127, 254}, {129, 129, 255});
        drop_if_all(&atlas::occlusion_roughness_metallic, {255, 255, 0}, {255, 255, 0});
        drop_if_all(&atlas::emissive, {0, 0, 0}, {0, 0, 0});
    }

    void drop_if_all(image atlas::*channel, const std::array<int, 3>& low,
                     const std::array<int, 3>& high) {
        for (const atlas& a : baked_.atlases) {
            const image& values = a.*channel;
            for (std::size_t i = 0; i < a.base_color.bytes.size() / 4; ++i) {
                if (a.base_color.bytes[4 * i + 3] == 0) continue;
                for (std::size_t c = 0; c < 3; ++c) {
                    const int value = values.bytes[3 * i + c];
                    if (value < low[c] || value > high[c]) return;
                }
            }
        }
        for (atlas& a : baked_.atlases) a.*channel = {};
    }

    billboard_cloud& cloud_;
    const face_table& faces_;
    const bake_options& options_;
    parallel threads_;
    const progress_function& progress_;
    surface look_;
    sky_table sky_{};
    baked_cloud baked_{};
    std::vector<draw_target> targets_{};
    std::vector<job> jobs_{};
    std::vector<job_result> results_{};
};

}  // namespace detail

/// Draws the textures of a cloud's billboards and packs them into atlases. Each billboard shows its
/// mapped and also-drawn faces and all others of its part that are valid for its plane or, if wanted,
/// reach into its envelope, seen from its front, within the depth of the first two kinds.
///
/// Needs  `faces` is the table of `source`; billboards as fit_billboards gives them.
/// Gives  tiles and atlases; `cloud.billboards` are enlarged to whole texels, so that every texel
///        covers a square of baked_cloud::texel_size. That is the diameter of the bounding sphere
///        over options.texels, or more where a tile would not fit into an atlas.
/// Cost   O(samples × faces that overlap), parallel over bands of tiles; 13 bytes a texel, and for
///        each thread 8 bytes a sample of a band.
/// Source Luksch 2009, section 4.5. Differs: faces that are merely valid are drawn, too, and the
///        border is filled over the whole transparent area.
[[nodiscard]] inline baked_cloud bake_cloud(const mesh& source, const face_table& faces,
                                            billboard_cloud& cloud,
                                            const bake_options& options = {}, parallel threads = {},
                                            const progress_function& progress = {}) {
    BILLOW_ASSERT(cloud.billboards.size() == cloud.plane_count());
    BILLOW_ASSERT(cloud.plane_of_face.size() == source.face_count());
    BILLOW_ASSERT(!options.with_horizon || options.occlusion.rays > 0);
    BILLOW_ASSERT(options.texels > 0 && options.padding >= 0);
    BILLOW_ASSERT(options.supersample >= 1 && options.supersample <= max_supersample);
    BILLOW_ASSERT(options.max_atlas > 2 * options.padding + 4);
    BILLOW_ASSERT(options.envelope_scale > 0 && options.envelope_scale <= 1);
    BILLOW_ASSERT(options.part_thresholds.empty() ||
                  options.part_thresholds.size() >= cloud.parts.size());
    return detail::cloud_baker(source, cloud, faces, options, threads, progress).run();
}

}  // namespace billow::inline BILLOW_ABI
