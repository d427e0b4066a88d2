// Draws views of a scene: light, coverage and what else is asked for.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <billow/bake/surface.hpp>
#include <billow/bake/visibility.hpp>
#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/types.hpp>
#include <billow/metrics/camera.hpp>
#include <billow/metrics/projected_faces.hpp>
#include <billow/metrics/render_scene.hpp>
#include <billow/metrics/sample_tile.hpp>
#include <billow/metrics/sample_view.hpp>
#include <billow/metrics/view_picture.hpp>

namespace billow::inline BILLOW_ABI {

struct render_options {
    int supersample = 4;           ///< samples a pixel side, 1 to 8; time grows with its square
    float headlight = 0.7f;        ///< light from the viewer's place
    float sky = 0.35f;             ///< light from above, and half of it from below
    bool keeps_faces = false;      ///< fills view_render::faces
    bool keeps_distances = false;  ///< fills view_render::distances
    bool counts_fragments =
        false;  ///< fills all of view_render::counts; alpha is read for hidden faces too
};

/// What was drawn, in pixels: samples divided by the samples of a pixel.
struct render_counts {
    double covered = 0;      ///< the sum of the picture's coverage
    double opaque = 0;       ///< fragments that alpha lets be seen, hidden or not; only on request
    double transparent = 0;  ///< fragments that alpha discards, hidden or not; only on request

    /// How often a covered pixel is drawn, what is discarded included.
    [[nodiscard]] double overdraw() const noexcept {
        return covered > 0 ? (opaque + transparent) / covered : 0.0;
    }
};

/// A view of a scene.
///
/// Shape  `faces`, `distances`: a row a pixel, or none where they were not asked for. They are those
///        of the sample nearest to the pixel's centre, of four equally near ones the lower right.
struct view_render {
    view_picture picture{};
    std::vector<face_id> faces{};    ///< no_id where nothing is
    std::vector<float> distances{};  ///< along the view, from the eye; infinite where nothing is
    render_counts counts{};
};

namespace detail {

/// Shades points of faces in a view; remembers what is constant over the faces met last.
class render_shader {
public:
    void start(const surface& look, const sample_view& view) noexcept {
        look_ = &look;
        view_ = view;
        for (entry& e : entries_) e.look.face = no_id;
    }

    /// The light of a face at the point of it that is nearest to `at`, in samples.
    [[nodiscard]] vec3 light(face_id face, const dvec2& at,
                             const render_options& options) noexcept {
        entry& e = entries_[face % entries_.size()];
        if (e.look.face != face) {
            e.gradients = face_gradients(view_, look_->source().corners(face));
            e.look = look_->look_at(face, pixels(e.gradients, e.gradients.middle()));
        }
        const auto value = [&](const affine_value& of) { return of.at(at.x - 0.5, at.y - 0.5); };
        const double inverse = value(e.gradients.inverse_w);
        const double w = inverse != 0 ? 1 / inverse : 0;
        const double b = std::clamp(value(e.gradients.share[1]) * w, 0.0, 1.0);
        const double c = std::clamp(value(e.gradients.share[2]) * w, 0.0, 1.0 - b);
        if (e.gradients.is_foreshortened()) {
            e.look = look_->look_at(face, pixels(e.gradients, inverse));
        }
        surface_sample sample = look_->at(e.look, vec3(1 - b - c, b, c));
        const vec3 toward = view_.toward_viewer(at);
        sample.normal = normal_toward(sample, e.look, toward);
        const float facing = std::max(0.0f, glm::dot(sample.normal, toward));
        const float sky = options.sky * sample.occlusion * (0.75f + 0.25f * sample.normal.y);
        return sample.base_color * (options.headlight * facing + sky) + sample.emissive;
    }

private:
    struct entry {
        face_look look{};
        face_gradients gradients{};
    };

    [[nodiscard]] double pixels(const face_gradients& face, double inverse_w) const noexcept {
        return face.area_at(inverse_w) / (view_.supersample * view_.supersample);
    }

    const surface* look_ = nullptr;
    sample_view view_{};
    std::array<entry, 256> entries_{};
};

/// What one thread draws tiles with.
struct tile_worker {
    sample_tile tile;
    render_shader shader{};
    fragment_count fragments{};
    std::uint64_t covered = 0;
};

}  // namespace detail

/// What views are drawn with: memory that is used again from view to view.
class render_scratch {
public:
    /// Draws a view into `to`, whose memory is used again.
    ///
    /// Cost   O(faces + samples × faces that overlap); parallel over tiles of the picture.
    void render(const render_scene& scene, const camera& from, const render_options& options,
                view_render& to, parallel threads = {1}) {
        BILLOW_ASSERT(options.supersample >= 1 && options.supersample <= max_supersample);
        BILLOW_ASSERT(from.width_px >= 0 && from.height_px >= 0);
        view_ = sample_view(from, options.supersample);
        start(from, options, to);
        workers_.resize(threads.count(), {sample_tile(options.supersample)});
        if (supersample_ != options.supersample) {
            for (auto& worker : workers_) worker.tile = sample_tile(options.supersample);
            supersample_ = options.supersample;
        }
        for (auto& worker : workers_) {
            worker.shader.start(scene.look, view_);
            worker.fragments = {};
            worker.covered = 0;
        }
        faces_.project(scene, view_);
        for_jobs(threads, faces_.tile_count(), workers_, [&](std::size_t tile, auto& worker) {
            draw_tile(scene, options, tile, worker, to);
        });
        fragment_count sum;
        std::uint64_t covered = 0;
        for (const auto& worker : workers_) {
            covered += worker.covered;
            sum.opaque += worker.fragments.opaque;
            sum.transparent += worker.fragments.transparent;
        }
        const auto in_pixels = [&](std::uint64_t samples) {
            return static_cast<double>(samples) / (options.supersample * options.supersample);
        };
        to.counts = {in_pixels(covered), in_pixels(sum.opaque), in_pixels(sum.transparent)};
    }

private:
    static void start(const camera& from, const render_options& options, view_render& to) {
        to.picture.width = from.width_px;
        to.picture.height = from.height_px;
        const auto size =
            static_cast<std::size_t>(from.width_px) * static_cast<std::size_t>(from.height_px);
        to.picture.pixels.resize(size);
        to.faces.resize(options.keeps_faces ? size : 0);
        to.distances.resize(options.keeps_distances ? size : 0);
    }

    void draw_tile(const render_scene& scene, const render_options& options, std::size_t tile,
                   detail::tile_worker& worker, view_render& to) {
        const sample_window pixels = faces_.pixels_of(tile);
        const int s = options.supersample;
        worker.tile.start(
            {pixels.x_begin * s, pixels.y_begin * s, pixels.x_end * s, pixels.y_end * s});
        if (options.counts_fragments) {
            faces_.for_faces_of(tile, [&](const projected_face& face) {
                worker.tile.draw<true>(scene.look, view_, face, worker.fragments);
            });
        } else {
            faces_.for_faces_of(tile, [&](const projected_face& face) {
                worker.tile.draw<false>(scene.look, view_, face, worker.fragments);
            });
        }
        const float weight = 1.0f / static_cast<float>(s * s);
        std::array<texel_part, max_supersample * max_supersample> parts;
        for (int y = pixels.y_begin; y < pixels.y_end; ++y) {
            for (int x = pixels.x_begin; x < pixels.x_end; ++x) {
                const std::size_t count = worker.tile.parts_of(x, y, s, parts);
                vec3 sum{0};
                int covered = 0;
                for (std::size_t i = 0; i < count; ++i) {
                    sum += glm::min(worker.shader.light(parts[i].face, parts[i].centre, options),
                                    vec3(1)) *
                           static_cast<float>(parts[i].samples);
                    covered += parts[i].samples;
                }
                worker.covered += static_cast<std::uint64_t>(covered);
                to.picture.at(x, y) = vec4(sum, static_cast<float>(covered)) * weight;
                keep_centre(worker.tile, x, y, options, to);
            }
        }
    }

    void keep_centre(const sample_tile& tile, int x, int y, const render_options& options,
                     view_render& to) const noexcept {
        const int s = options.supersample;
        const auto pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(to.picture.width) +
            static_cast<std::size_t>(x);
        const face_id face = tile.face_at(x * s + s / 2, y * s + s / 2);
        if (options.keeps_faces) to.faces[pixel] = face;
        if (!options.keeps_distances) return;
        const double nearness = tile.nearness_at(x * s + s / 2, y * s + s / 2);
        to.distances[pixel] = face == no_id ? std::numeric_limits<float>::infinity()
                                            : static_cast<float>(view_.distance_of(nearness));
    }

    sample_view view_{};
    int supersample_ = 0;
    projected_faces faces_{};
    std::vector<detail::tile_worker> workers_{};
};

/// Draws one view. Faces are seen from both sides, unless the scene culls their backs; alpha is
/// tested, or dithered over the samples where a material blends; the light is one at the viewer and
/// one from the sky.
///
/// Needs  options.supersample within 1 to 8.
/// Gives  pixels of 0 where nothing is. The light of each face in a pixel is cut off at 1.
/// Cost   O(faces + samples × faces that overlap); parallel over tiles of the picture.
[[nodiscard]] inline view_picture render_view(const render_scene& scene, const camera& from,
                                              const render_options& options = {},
                                              parallel threads = {}) {
    render_scratch scratch;
    view_render result;
    scratch.render(scene, from, options, result, threads);
    return std::move(result.picture);
}

/// Draws every scene from every camera, and calls `body(view, renders)` for each camera: renders[i]
/// is that of *scenes[i], until `body` returns. Calls come from several threads in no fixed order.
///
/// Needs  as render_view; `body` must not throw, and its calls must not write to the same place.
/// Cost   as render_view for each; parallel over cameras. Nothing is allocated after the first view
///        of a thread, but where a view shows more faces than those before.
template <class Body>
void for_views(std::span<const render_scene* const> scenes, std::span<const camera> cameras,
               const render_options& options, parallel threads, const Body& body) {
    struct view_worker {
        render_scratch scratch{};
        std::vector<view_render> renders{};
    };
    std::vector<view_worker> workers(threads.count());
    for (view_worker& worker : workers) worker.renders.resize(scenes.size());
    for_jobs(threads, cameras.size(), workers, [&](std::size_t view, view_worker& worker) {
        for (std::size_t i = 0; i < scenes.size(); ++i) {
            worker.scratch.render(*scenes[i], cameras[view], options, worker.renders[i]);
        }
        body(view, std::span<const view_render>(worker.renders));
    });
}

}  // namespace billow::inline BILLOW_ABI
