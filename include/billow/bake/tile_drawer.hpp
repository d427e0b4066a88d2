// Draws the billboards of a cloud, each into a picture of its own.
//
// Luksch, "Implementation of an Improved Billboard Cloud Algorithm", 2009, section 4.5.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/draw_set.hpp>
#include <billow/bake/surface.hpp>
#include <billow/bake/texel.hpp>
#include <billow/bake/tile_picture.hpp>
#include <billow/bake/visibility.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/improve/envelope.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/mesh.hpp>

namespace billow::inline BILLOW_ABI {

struct draw_options {
    int supersample = 4;  ///< samples a texel side, 1 to 8; time grows with its square
    double max_extra_angle = 75 * std::numbers::pi / 180;  ///< radians between a plane and other
                                                           ///< valid faces drawn on it; 0: none
    crack_reduction cracks = crack_reduction::none;
    double envelope_scale =
        1;  ///< size of the boxes that faces must reach into, above 0 to 1: less
            ///< is drawn where it does not belong, more cracks stay
    normal_style normals = normal_style::folded;
    double dome = 0.8;  ///< of normal_style::dome, the weight of the directions out of the middle
    std::vector<double> part_dome{};  ///< one a part; none: `dome` for all
    bool with_horizon = false;        ///< needs a surface that light_by() was told of
    bool measures_surface = false;    ///< fills tile_picture::surface_area
};

/// The cloud seen from behind: planes and billboards turned round their v axes.
[[nodiscard]] inline billboard_cloud turned_round(const billboard_cloud& cloud) {
    billboard_cloud back = cloud;
    for (plane& p : back.planes) p = {-p.normal, -p.rho};
    for (billboard& b : back.billboards) {
        b.origin += b.axes.u * b.width;
        b.axes = {-b.axes.u, b.axes.v, -b.axes.normal};
        b.depth_low = -std::exchange(b.depth_high, -b.depth_low);
    }
    return back;
}

/// What the faces of each billboard look like from its front.
///
/// Needs  `look` of the mesh that `faces` and `cloud` are of; billboards of whole texels, see
///        snap_to_texels. All outlive it.
class tile_drawer {
public:
    /// Cost  as draw_sets.
    tile_drawer(const surface& look, const face_table& faces, const billboard_cloud& cloud,
                double texel_size, const draw_options& options, parallel threads)
        : look_(look),
          faces_(faces),
          cloud_(cloud),
          texel_size_(texel_size),
          options_(options),
          threads_(threads),
          targets_(targets_of(options.supersample)),
          sets_(faces, cloud, targets_,
                {options.max_extra_angle > 0 ? std::cos(options.max_extra_angle) : 2,
                 options.cracks, options.envelope_scale},
                threads) {
        if (options.normals == normal_style::dome) find_middles();
    }
    tile_drawer(const tile_drawer&) = delete;
    tile_drawer& operator=(const tile_drawer&) = delete;

    /// The pictures of some billboards, whose alpha is not set yet. A billboard whose faces slip
    /// between all samples shows the centre of its largest face.
    ///
    /// Needs  1 ≤ supersample ≤ max_supersample.
    /// Cost   O(samples × faces that overlap), parallel over bands of tiles; for each thread 8 bytes
    ///        a sample of a band.
    template <class Progress>
    [[nodiscard]] std::vector<tile_picture> draw(std::span<const plane_id> ids, int supersample,
                                                 const Progress& progress) const {
        const std::vector<draw_target> targets =
            supersample == options_.supersample ? targets_ : targets_of(supersample);
        std::vector<tile_picture> tiles;
        std::vector<job> jobs;
        std::size_t widest = 0;
        for (std::size_t i = 0; i < ids.size(); ++i) {
            const ivec2 size = size_of(ids[i]);
            tiles.push_back(empty_tile(size, supersample, options_.with_horizon));
            widest = std::max(widest, static_cast<std::size_t>(size.x * supersample));
            for (int band = 0; band * band_height < size.y; ++band) {
                jobs.push_back({ids[i], i, band});
            }
        }
        std::vector<float> surface_areas(jobs.size(), 0.0f);
        std::vector<job_scratch> scratches(
            threads_.count(),
            job_scratch{visibility_buffer(supersample), view_shader(look_, supersample)});
        for (job_scratch& scratch : scratches) {
            scratch.buffer.reserve(widest * static_cast<std::size_t>(band_height * supersample));
        }
        // Progress is told by the calling thread, so between slices of the jobs.
        constexpr std::size_t slices = 16;
        for (std::size_t i = 0; i < slices; ++i) {
            const std::size_t begin = jobs.size() * i / slices;
            const std::size_t end = jobs.size() * (i + 1) / slices;
            for_jobs(threads_, end - begin, scratches, [&](std::size_t k, auto& scratch) {
                const job& j = jobs[begin + k];
                surface_areas[begin + k] = draw_band(tiles[j.tile], j, targets[j.plane], scratch);
            });
            progress(static_cast<double>(i + 1) / slices);
        }
        for (std::size_t k = 0; k < jobs.size(); ++k) {
            tiles[jobs[k].tile].surface_area += static_cast<double>(surface_areas[k]);
        }
        show_something(tiles, ids, targets);
        return tiles;
    }

private:
    static constexpr int band_height = 16;  ///< texel rows drawn at a time: bounds the memory

    struct job {
        plane_id plane = 0;
        std::size_t tile = 0;
        int band = 0;
    };
    struct job_scratch {
        visibility_buffer buffer;
        view_shader shader;
    };

    [[nodiscard]] ivec2 size_of(plane_id id) const noexcept {
        const billboard& b = cloud_.billboards[id];
        return {static_cast<int>(std::lround(b.width / texel_size_)),
                static_cast<int>(std::lround(b.height / texel_size_))};
    }

    [[nodiscard]] std::vector<draw_target> targets_of(int supersample) const {
        std::vector<draw_target> targets;
        for (plane_id id = 0; id < cloud_.billboards.size(); ++id) {
            const billboard& b = cloud_.billboards[id];
            const ivec2 size = size_of(id);
            targets.push_back({{b.axes, b.origin + b.axes.v * b.height, texel_size_ / supersample},
                               size.x * supersample,
                               size.y * supersample,
                               band_height * supersample});
        }
        return targets;
    }

    /// The middle of what each part shows, which dome normals point away from.
    void find_middles() {
        const std::size_t parts = std::max<std::size_t>(1, cloud_.parts.size());
        std::vector<dvec3> sums(parts, dvec3(0));
        std::vector<double> areas(parts, 0.0);
        for (std::size_t row = 0; row < faces_.size; ++row) {
            const plane_id plane = cloud_.plane_of_face[faces_.source[row]];
            if (plane == no_id) continue;
            const auto area = static_cast<double>(faces_.area[row]);
            sums[cloud_.part_of(plane)] += faces_.centroid(row) * area;
            areas[cloud_.part_of(plane)] += area;
        }
        for (std::size_t i = 0; i < parts; ++i) {
            middles_.push_back(faces_.bounds.centre +
                               (areas[i] > 0 ? sums[i] / areas[i] : dvec3(0)));
        }
    }

    /// The normal of a texel at `point`.
    [[nodiscard]] vec3 domed(const vec3& normal, plane_id id, const dvec3& point) const noexcept {
        const part_id part = cloud_.part_of(id);
        const double weight = options_.part_dome.empty() ? options_.dome : options_.part_dome[part];
        const dvec3 outward = point - middles_[part];
        const double length = glm::length(outward);
        if (!(length > 0)) return normal;
        const dvec3 sum = dvec3(normal) * (1 - weight) + outward * (weight / length);
        const double sum_length = glm::length(sum);
        return sum_length > 1e-9 ? vec3(sum / sum_length) : normal;
    }

    [[nodiscard]] normal_encoding encoding_of(plane_id id) const noexcept {
        return {cloud_.billboards[id].axes,
                options_.normals == normal_style::object || options_.normals == normal_style::dome};
    }

    void write(tile_picture& tile, plane_id id, const normal_encoding& normals, int x, int y,
               texel value) const noexcept {
        if (options_.normals == normal_style::dome) {
            const billboard& b = cloud_.billboards[id];
            const dvec3 point = b.origin + b.axes.u * ((x + 0.5) * texel_size_) +
                                b.axes.v * (b.height - (y + 0.5) * texel_size_);
            value.look.normal = domed(value.look.normal, id, point);
        }
        write_texel(tile, normals, x, y, value);
    }

    /// Gives the surface area that the band shows, in texels.
    [[nodiscard]] float draw_band(tile_picture& tile, const job& j, const draw_target& target,
                                  job_scratch& scratch) const noexcept {
        const int s = tile.supersample;
        const billboard& board = cloud_.billboards[j.plane];
        const int first = j.band * band_height;
        const int last = std::min(first + band_height, tile.height);
        scratch.buffer.start({0, first * s, target.columns, last * s});
        const double slack = 1e-5 * std::max(cloud_.bounds.radius, texel_size_);
        const depth_range range{board.depth_low - slack, board.depth_high + slack};
        for (const drawn_face& f : sets_[j.plane]) {
            if (f.first_band <= j.band && j.band <= f.last_band) {
                scratch.buffer.draw(look_, target.view, f.face, range);
            }
        }
        scratch.shader.start(target.view);
        const normal_encoding normals = encoding_of(j.plane);
        const vec3 front(board.axes.normal);
        float surface_area = 0;
        for (int y = first; y < last; ++y) {
            for (int x = 0; x < tile.width; ++x) {
                const texel value = resolve_texel(scratch.buffer, scratch.shader, look_, x, y, s,
                                                  front, options_.measures_surface);
                if (value.samples == 0) continue;
                write(tile, j.plane, normals, x, y, value);
                surface_area += value.surface_area;
            }
        }
        return surface_area / static_cast<float>(s * s);
    }

    void show_something(std::vector<tile_picture>& tiles, std::span<const plane_id> ids,
                        std::span<const draw_target> targets) const {
        std::vector<std::size_t> largest_row;
        for (std::size_t i = 0; i < tiles.size(); ++i) {
            const auto& covered = tiles[i].covered;
            if (std::any_of(covered.begin(), covered.end(), [](auto c) { return c > 0; })) continue;
            if (largest_row.empty()) largest_row = largest_rows();
            if (const std::size_t row = largest_row[ids[i]]; row != no_id) {
                draw_centre(tiles[i], ids[i], targets[ids[i]], row);
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

    void draw_centre(tile_picture& tile, plane_id id, const draw_target& target,
                     std::size_t row) const {
        const int s = tile.supersample;
        const dvec2 centre(target.view.project(faces_.centroid(row) + faces_.bounds.centre));
        view_shader shader(look_, s);
        shader.start(target.view);
        const int x = std::clamp(static_cast<int>(centre.x) / s, 0, tile.width - 1);
        const int y = std::clamp(static_cast<int>(centre.y) / s, 0, tile.height - 1);
        write(tile, id, encoding_of(id), x, y, {shader.at(faces_.source[row], centre), 1, 0, 1});
    }

    const surface& look_;
    const face_table& faces_;
    const billboard_cloud& cloud_;
    double texel_size_;
    const draw_options& options_;
    parallel threads_;
    std::vector<draw_target> targets_;
    draw_sets sets_;
    std::vector<dvec3> middles_{};
};

}  // namespace billow::inline BILLOW_ABI
