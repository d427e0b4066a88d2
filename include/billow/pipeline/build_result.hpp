// What build_cloud is asked for and what it gives.
#pragma once

#include <cstdint>
#include <vector>

#include <billow/bake/bake_cloud.hpp>
#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/cloud_mesh.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/cloud/cracks.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/cloud/plane_order.hpp>
#include <billow/core/parallel.hpp>
#include <billow/geometry/bounds.hpp>
#include <billow/improve/cardboard.hpp>
#include <billow/improve/refine_whole.hpp>
#include <billow/improve/weld.hpp>
#include <billow/mesh/append_mesh.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/search/greedy.hpp>
#include <billow/search/parts.hpp>

namespace billow::inline BILLOW_ABI {

/// A length: a share of the radius of the mesh's bounding sphere, or scene units.
struct tolerance {
    double value = 0;
    bool is_of_radius = false;

    [[nodiscard]] static constexpr tolerance of_radius(double share) noexcept {
        return {share, true};
    }
    [[nodiscard]] static constexpr tolerance scene_units(double length) noexcept {
        return {length, false};
    }
    /// In scene units.
    [[nodiscard]] constexpr double in(const bounding_sphere& bounds) const noexcept {
        return is_of_radius ? value * bounds.radius : value;
    }
};

struct build_options {
    tolerance epsilon = tolerance::of_radius(0.1);  ///< largest distance of a vertex to its plane
    greedy_options search{};                        ///< its own epsilon is not read
    std::size_t planes = 0;      ///< 0: as many as epsilon asks for; else epsilon, where the search
                                 ///< starts, is changed until there are about so many
    bool refines_whole = false;  ///< refine_whole() after the search, where no vertex has moved
    whole_refinement_options whole{};  ///< its least_cosine is not read: it is the contribution's
    weld_options weld{};  ///< after the search; weld_online of a pipeline needs none here
    cardboard_options cardboard{.min_coverage = 0};  ///< none; its part is not read
    bake_options bake{};
    bool packs_tiles = true;  ///< else build_result::drawn is left for share_atlas
    parallel threads{};
};

/// Faces whose planes are searched together, and how: a trunk, or its foliage.
template <class Pipeline = pipeline<>>
struct part_plan {
    std::vector<face_id> faces{};  ///< each once, and in no other part
    build_options options{};  ///< a share of the radius is of the whole mesh; of `bake` only the
                              ///< thresholds are read, of threads nothing
    Pipeline method{};
};
template <class Pipeline>
part_plan(std::vector<face_id>, build_options, Pipeline) -> part_plan<Pipeline>;

/// What became of the faces of a mesh: every one is counted once.
struct face_counts {
    std::size_t mapped = 0;      ///< lie on a plane
    std::size_t kept = 0;        ///< of no part: stay a mesh
    std::size_t degenerate = 0;  ///< set aside: they have no area
    std::size_t dropped = 0;     ///< have an area, but no plane wanted them

    [[nodiscard]] std::size_t all() const noexcept { return mapped + kept + degenerate + dropped; }
};

/// How the planes of a part came about.
struct part_result {
    face_counts faces{};
    std::size_t plane_count = 0;       ///< that the search found, and refinement left
    std::size_t cardboard_planes = 0;  ///< that were added to them
    double epsilon = 0;                ///< scene units
    greedy_statistics statistics{};
    whole_refinement_report refined{};  ///< of build_options::refines_whole
    plane_curve curve{};                ///< of the planes that were found, welding not counted
};

/// A textured billboard cloud, and how it came about.
struct build_result {
    billboard_cloud cloud{};
    baked_cloud baked{};
    drawn_tiles drawn{};  ///< the tiles, where they were not packed
    mesh kept{};          ///< the faces of no part, as they are in the source
    face_counts faces{};
    greedy_statistics statistics{};    ///< sums over the parts; shares are of their common area
    std::vector<part_result> parts{};  ///< in the order of the plans
    cloud_errors errors{};
    std::vector<moved_face> moved{};  ///< whose corners welding moved, around cloud.bounds.centre
    weld_statistics weld{};           ///< of the welding after the search
    cloud_cracks cracks{};            ///< where corners have moved: without that,
    cloud_cracks cracks_drawn{};      ///< and with it
    double search_seconds = 0;
    double bake_seconds = 0;

    /// The cloud as a mesh that lies over the original, ready for write_glb. What was kept comes
    /// behind it, with its own materials and the feature id after that of the last plane.
    ///
    /// Needs  tiles that were packed.
    [[nodiscard]] mesh to_mesh() const {
        mesh result = cloud_mesh(cloud, baked);
        if (kept.face_count() > 0) {
            append_mesh(result, kept, static_cast<std::uint32_t>(cloud.plane_count()));
        }
        return result;
    }
};

}  // namespace billow::inline BILLOW_ABI
