// Textures by texel.
#include <billow/bake/bake_cloud.hpp>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <billow/bake/draw_set.hpp>
#include <billow/bake/mips.hpp>
#include <billow/bake/visibility.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/core/random.hpp>
#include <billow/improve/cardboard.hpp>
#include <billow/plants/species.hpp>
#include <billow/search/greedy.hpp>
#ifdef BILLOW_BENCHMARK_IO
#include <billow/io/image_file.hpp>
#endif

#include "bench.hpp"

namespace {

using namespace billow;

billboard_cloud cloud_of(const bench::scene& scene) {
    const double epsilon = bench::epsilon_share * scene.faces.bounds.radius;
    billboard_cloud cloud =
        greedy_search(scene.faces, scene.mesh.face_count(), {.epsilon = epsilon}).cloud;
    fit_billboards(scene.mesh, cloud);
    return cloud;
}

void bake(benchmark::State& state, const bench::scene& scene, unsigned threads,
          const bake_options& options = {}) {
    const billboard_cloud cloud = cloud_of(scene);
    const auto bake_once = [&] {
        billboard_cloud snapped = cloud;
        return bake_cloud(scene.mesh, scene.faces, snapped, options, {threads});
    };
    double texels = 0;
    for (const tile& t : bake_once().tiles) texels += static_cast<double>(t.width) * t.height;
    bench::repeat(state, {"ms_per_megatexel", 1e3, texels / 1e6}, bake_once);
    state.counters["tiles"] = static_cast<double>(cloud.plane_count());
}

void cardboard(benchmark::State& state, const bench::scene& scene) {
    const billboard_cloud cloud = cloud_of(scene);
    std::size_t added = 0;
    bench::repeat(state, bench::ns_per_face(scene.mesh.face_count()), [&] {
        billboard_cloud more = cloud;
        added = add_cardboard_planes(scene.mesh, more, {}, {1});
    });
    state.counters["added"] = static_cast<double>(added);
}

/// Alpha of one tile of strewn shares, 256 texels a side.
void alpha(benchmark::State& state, alpha_kind kind) {
    random_stream random(1);
    tile_picture tile = empty_tile({256, 256}, 4, false);
    for (std::size_t i = 0; i < tile.texel_count(); ++i) {
        tile.covered[i] = static_cast<std::uint8_t>(std::max(0.0, random.between(-16, 16)));
        tile.cut_out[i] = tile.covered[i];
    }
    bench::repeat(state, {"ms_per_megatexel", 1e3, 65536 / 1e6},
                  [&] { choose_alpha(tile, {.kind = kind}); });
}

/// Borders of an atlas where one texel of eight is covered.
void borders(benchmark::State& state, const bench::scene& scene, unsigned threads) {
    billboard_cloud cloud = cloud_of(scene);
    baked_cloud baked = bake_cloud(scene.mesh, scene.faces, cloud, {}, {});
    std::vector<std::vector<char>> covered;
    double texels = 0;
    for (const atlas& a : baked.atlases) {
        std::vector<char>& marks = covered.emplace_back();
        for (std::size_t i = 3; i < a.base_color.bytes.size(); i += 4) {
            marks.push_back(a.base_color.bytes[i] >= 128 ? 1 : 0);
        }
        texels += static_cast<double>(marks.size());
    }
    bench::repeat(state, {"ms_per_megatexel", 1e3, texels / 1e6},
                  [&] { fill_borders(baked, covered, 8, {threads}); });
}

#ifdef BILLOW_BENCHMARK_IO
void png(benchmark::State& state, const bench::scene& scene) {
    billboard_cloud cloud = cloud_of(scene);
    const baked_cloud baked = bake_cloud(scene.mesh, scene.faces, cloud, {}, {});
    const image& picture = baked.atlases[0].base_color;
    const double texels = static_cast<double>(picture.width) * picture.height;
    std::size_t bytes = 0;
    bench::repeat(state, {"ms_per_megatexel", 1e3, texels / 1e6},
                  [&] { bytes = encode_png(picture).size(); });
    state.counters["bits_per_texel"] = 8 * static_cast<double>(bytes) / texels;
}
#endif

void mips(benchmark::State& state, const bench::scene& scene, unsigned threads) {
    billboard_cloud cloud = cloud_of(scene);
    const baked_cloud baked = bake_cloud(scene.mesh, scene.faces, cloud, {}, {});
    double texels = 0;
    for (const atlas& a : baked.atlases) texels += static_cast<double>(a.width()) * a.height();
    std::size_t levels = 0;
    bench::repeat(state, {"ms_per_megatexel", 1e3, texels / 1e6},
                  [&] { levels = make_mips(baked, {}, {threads})[0].base_color.size(); });
    state.counters["levels"] = static_cast<double>(levels);
}

/// A view of a whole scene along z, in samples.
struct bench_view {
    static constexpr int side = 1024;

    explicit bench_view(const bench::scene& of)
        : view{{},
               of.faces.bounds.centre + dvec3(-1, 1, 0) * of.faces.bounds.radius,
               2 * of.faces.bounds.radius / side} {
        const draw_target target{view, side, side, side};
        for (std::size_t row = 0; row < of.faces.size; ++row) {
            std::array<dvec3, 3> corners;
            for (std::size_t k = 0; k < 3; ++k) {
                corners[k] = of.faces.corner[k].get(row) + of.faces.bounds.centre;
            }
            if (const auto drawn = clipped_to(target, of.faces.source[row], corners)) {
                faces.push_back(*drawn);
            }
        }
        std::sort(faces.begin(), faces.end());
    }

    template <class V>
    void draw(visibility_buffer& buffer, const surface& look) const {
        buffer.start({0, 0, side, side});
        for (const drawn_face& f : faces) buffer.draw<V>(look, view, f.face, {});
    }

    orthographic_view view;
    std::vector<drawn_face> faces{};
};

template <class V>
void rasterise(benchmark::State& state, const bench::scene& scene) {
    const bench_view from(scene);
    const surface look(scene.mesh);
    visibility_buffer buffer(4);
    bench::repeat(state, bench::ns_per_face(scene.mesh.face_count()),
                  [&] { from.draw<V>(buffer, look); });
}

void resolve(benchmark::State& state, const bench::scene& scene) {
    const bench_view from(scene);
    const surface look(scene.mesh);
    visibility_buffer buffer(4);
    from.draw<simd::wide>(buffer, look);
    constexpr int texels = bench_view::side / 4;
    view_shader shader(look, 4);
    float sum = 0;
    bench::repeat(state, {"ns_per_texel", 1e9, 1.0 * texels * texels}, [&] {
        shader.start(from.view);
        std::array<texel_part, max_supersample * max_supersample> parts;
        for (int y = 0; y < texels; ++y) {
            for (int x = 0; x < texels; ++x) {
                const std::size_t count = parts_of_texel(buffer, x, y, 4, parts);
                for (std::size_t i = 0; i < count; ++i) {
                    sum += shader.at(parts[i].face, parts[i].centre).base_color.x;
                }
            }
        }
    });
    benchmark::DoNotOptimize(sum);
}

const bool bake_rows = [] {
    for (const unsigned threads : {1u, 2u}) {
        bench::add_row(
            "bake.bake_cloud/leaf_soup", 1'000, "scalar", threads,
            [=](benchmark::State& state) { bake(state, bench::leaves(1'000), threads); });
        bench::add_row(
            "bake.mips/leaf_soup", 1'000, "scalar", threads,
            [=](benchmark::State& state) { mips(state, bench::leaves(1'000), threads); });
        bench::add_row(
            "bake.borders/leaf_soup", 1'000, "scalar", threads,
            [=](benchmark::State& state) { borders(state, bench::leaves(1'000), threads); });
        bench::add_row(
            "bake.bake_cloud/broadleaf", 20'000, "scalar", threads, [=](benchmark::State& state) {
                static const bench::scene tree(*grow(*with_face_count(broadleaf(), 20'000, 1), 1));
                bake(state, tree, threads);
            });
    }
    for (const std::size_t size : {1'000u, 113'016u}) {
        for (const auto cracks : {crack_reduction::none, crack_reduction::envelope}) {
            const bool is_plain = cracks == crack_reduction::none;
            bench::add_row(is_plain ? "bake.cracks/none" : "bake.cracks/envelope", size, bench::isa,
                           1, [=](benchmark::State& state) {
                               bake(state, bench::leaves(size), 1, {.draw = {.cracks = cracks}});
                           });
        }
        bench::add_row("improve.cardboard/leaf_soup", size, "scalar", 1,
                       [=](benchmark::State& state) { cardboard(state, bench::leaves(size)); });
    }
    for (const std::size_t size : {1'000u, 113'016u}) {
        bench::add_row("bake.rasterise/leaf_soup", size, "scalar", 1, [=](benchmark::State& state) {
            rasterise<float>(state, bench::leaves(size));
        });
        bench::add_row(
            "bake.rasterise/leaf_soup", size, bench::isa, 1,
            [=](benchmark::State& state) { rasterise<simd::wide>(state, bench::leaves(size)); });
        bench::add_row("bake.resolve/leaf_soup", size, "scalar", 1,
                       [=](benchmark::State& state) { resolve(state, bench::leaves(size)); });
    }
    for (const auto& [name, kind] : {std::pair("bake.alpha/binary", alpha_kind::binary),
                                     std::pair("bake.alpha/coverage", alpha_kind::coverage),
                                     std::pair("bake.alpha/sdf", alpha_kind::distance)}) {
        bench::add_row(name, 1'000, "scalar", 1,
                       [=](benchmark::State& state) { alpha(state, kind); });
    }
#ifdef BILLOW_BENCHMARK_IO
    bench::add_row("io.png/leaf_soup", 1'000, "scalar", 1,
                   [=](benchmark::State& state) { png(state, bench::leaves(1'000)); });
#endif
    return true;
}();

}  // namespace
