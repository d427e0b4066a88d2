// Clouds of the thesis's experiments: how one is made, and what is told of it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <billow/improve/weld.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/search/refine.hpp>

namespace thesis {

using namespace billow;

enum class method {
    density,          ///< the thesis's: a density grid, least squares
    unfitted,         ///< the same, planes as they are found
    classic,          ///< presets::classic
    exact,            ///< exact_search, without penalty
    exact_refined,    ///< and refine_whole
    density_refined,  ///< the thesis's, and refine_whole
};

struct recipe {
    method how = method::density;
    double epsilon = 0.05;   ///< share of the radius
    std::size_t planes = 0;  ///< 0: as epsilon gives; else about so many, and epsilon follows
    int raster = 18;
    double rho_rate = 1.5;
    double penalty = 3;   ///< of the density grid; the exact search has none
    double tangency = 0;  ///< of the exact search
    bool falls = true;
    refinement refine = refinement::fail_safe;
    double skip_area = 0;
    bool welds = false;
};

/// A cloud, and what is known of it without pictures.
struct cloud_made {
    billow::mesh mesh{};  ///< textured
    std::size_t planes = 0;
    double epsilon = 0;  ///< share of the radius
    double seconds = 0;  ///< of one processor, for the search and refinement of the whole
    double refinement_level = 0;
    double projected_area_share = 0;
    double geometric = 0;  ///< mean, share of the radius
    double skipped_area_share = 0;
};

/// Means over all views.
struct picture_means {
    double coverage = 0;
    double missing = 0;
    double extra = 0;
    double gap_intensity = 0;
    double color = 0;
    double local_color = 0;
};

struct view_settings {
    int views = 42;
    int size_px = 256;
    int supersample = 2;
    int texels = 256;  ///< of clouds, along the diameter
};

[[nodiscard]] cloud_made make_cloud(const mesh& of, const recipe& how, const view_settings& views);

/// The pictures of several clouds against those of their original. No ꟻLIP, which takes longest.
[[nodiscard]] std::vector<picture_means> look_at(const mesh& original,
                                                 std::span<const mesh* const> clouds,
                                                 const view_settings& views);

/// Fuhrmann's: presets::tree, trunk and foliage apart. Planes and seconds alone.
[[nodiscard]] cloud_made search_tree(const mesh& of, double epsilon);

}  // namespace thesis
