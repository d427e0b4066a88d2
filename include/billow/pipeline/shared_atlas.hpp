// Several clouds in one set of atlases: one material, so one draw call for all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <billow/bake/bake_cloud.hpp>
#include <billow/bake/cloud_mesh.hpp>
#include <billow/mesh/append_mesh.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/pipeline/build_result.hpp>

namespace billow::inline BILLOW_ABI {

/// Faces [begin, end) of a mesh.
struct face_range {
    std::size_t begin = 0;
    std::size_t end = 0;

    [[nodiscard]] std::size_t size() const noexcept { return end - begin; }
};

/// Where a cloud lies in a mesh that it shares.
struct atlas_member {
    face_range billboards{};
    face_range kept{};  ///< what stayed a mesh
};

struct shared_atlas {
    mesh drawn{};                         ///< all clouds; feature ids count anew for each
    std::vector<atlas_member> members{};  ///< in the order of the clouds
    baked_cloud baked{};                  ///< tiles of all billboards; texel sizes are the first's
};

namespace detail {

/// The billboards and tiles of several clouds as those of one.
struct joined_tiles {
    billboard_cloud cloud{};
    drawn_tiles drawn{};

    void add(build_result& from) {
        drawn_tiles& tiles = from.drawn;
        const std::size_t before = cloud.billboards.size();
        const std::size_t fronts = from.cloud.billboards.size();
        cloud.billboards.insert(cloud.billboards.end(), from.cloud.billboards.begin(),
                                from.cloud.billboards.end());
        // Fronts stay in front of all backs, so the backs of `from` come after those that are there.
        const auto place = drawn.tiles.begin() + static_cast<std::ptrdiff_t>(before);
        const auto first_back = tiles.tiles.begin() + static_cast<std::ptrdiff_t>(fronts);
        const auto backs_begin = static_cast<std::uint32_t>(drawn.tiles.size() + fronts);
        drawn.tiles.insert(place, std::move_iterator(tiles.tiles.begin()),
                           std::move_iterator(first_back));
        drawn.tiles.insert(drawn.tiles.end(), std::move_iterator(first_back),
                           std::move_iterator(tiles.tiles.end()));
        for (std::uint32_t& back : drawn.back_of) {
            if (back != no_id) back += static_cast<std::uint32_t>(fronts);
        }
        for (std::size_t i = 0; i < fronts; ++i) {
            const std::uint32_t back = tiles.back_of.empty() ? no_id : tiles.back_of[i];
            drawn.back_of.push_back(
                back == no_id ? no_id : backs_begin + back - static_cast<std::uint32_t>(fronts));
        }
        drawn.outlines.insert(drawn.outlines.end(), std::move_iterator(tiles.outlines.begin()),
                              std::move_iterator(tiles.outlines.end()));
        drawn.opaque_area += tiles.opaque_area;
        drawn.polygon_area += tiles.polygon_area;
        if (before == 0) {
            drawn.texel_size = tiles.texel_size;
            drawn.wanted_size = tiles.wanted_size;
        }
        tiles = {};
    }
};

}  // namespace detail

/// Packs the tiles of clouds that were built with build_options::packs_tiles off, and takes them away
/// from there.
///
/// Needs   clouds baked with the same normals, outlines or none in all, and channels; `options` as
///         theirs.
/// Gives   atlases and a mesh in which each cloud has its faces together. Clouds without planes have
///         none.
[[nodiscard]] inline shared_atlas share_atlas(std::span<build_result> clouds,
                                              const bake_options& options, parallel threads = {}) {
    shared_atlas result;
    detail::joined_tiles all;
    std::vector<std::size_t> first_billboard;
    for (build_result& cloud : clouds) {
        first_billboard.push_back(all.cloud.billboards.size());
        all.add(cloud);
    }
    first_billboard.push_back(all.cloud.billboards.size());
    result.baked = pack_tiles(std::move(all.drawn), options, threads);
    result.drawn = cloud_mesh(all.cloud, result.baked);

    mesh& drawn = result.drawn;
    std::size_t face = 0;
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        const std::size_t begin = face;
        while (face < drawn.face_count() &&
               drawn.feature_ids[drawn.triangles[face].x] < first_billboard[i + 1]) {
            ++face;
        }
        result.members.push_back({.billboards = {begin, face}});
    }
    std::size_t cloud = 0;
    for (std::uint32_t& id : drawn.feature_ids) {  // ascending
        while (id >= first_billboard[cloud + 1]) ++cloud;
        id -= static_cast<std::uint32_t>(first_billboard[cloud]);
    }
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        const std::size_t begin = drawn.face_count();
        if (clouds[i].kept.face_count() > 0) {
            append_mesh(drawn, clouds[i].kept,
                        static_cast<std::uint32_t>(clouds[i].cloud.plane_count()));
        }
        result.members[i].kept = {begin, drawn.face_count()};
    }
    return result;
}

}  // namespace billow::inline BILLOW_ABI
