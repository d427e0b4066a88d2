// The parts that a plane search is put together from.
#pragma once

#include <concepts>
#include <numbers>

#include <billow/density/rasterize.hpp>
#include <billow/fit/fit.hpp>
#include <billow/fit/least_squares.hpp>
#include <billow/plane_space/cube_map.hpp>
#include <billow/search/grouping.hpp>
#include <billow/search/motion.hpp>

namespace billow::inline BILLOW_ABI {

/// Planes are looked for in a density grid: greedy_search.
struct density_method {};

/// Planes are looked for by exact offsets, normal by normal: exact_search.
struct exact_method {
    /// How much more frontal faces count, ≥ 0, see tangent_share; 0: as the contribution policy says.
    double tangency = 0;
    /// Share of the faces' area, [0, 1]: when less is left, faces count whole, however askew, which
    /// ends the search with fewer planes; 0: never.
    double tail = 0.02;
    /// Normals that a local search starts from for each plane; 0: planes have normals of the space.
    int starts = 4;
    double last_step = 0.15 * std::numbers::pi / 180;  ///< of that search, radians, > 0
};

/// One of the two, chosen when the program runs.
struct either_method {
    bool is_exact = false;
    exact_method exact{};
};

/// Finds planes.
template <class M>
concept search_method = std::same_as<M, density_method> || std::same_as<M, exact_method> ||
    std::same_as<M, either_method>;

/// The parts of a pipeline that are chosen at compile time, each a value with its parameters:
/// `pipeline{spherical(24), density_policies{}, svd_fit{}}`.
template <plane_space Space = cube_map, class Policies = density_policies<>,
          plane_fitter Fitter = least_squares_fit, face_grouping Grouping = whole_set,
          vertex_motion Motion = fixed_vertices, search_method Search = density_method>
struct pipeline {
    Space space{};
    Policies policies{};
    Fitter fitter{};
    Grouping grouping{};
    Motion motion{};
    Search search{};
};
template <class Space, class Policies = density_policies<>, class Fitter = least_squares_fit,
          class Grouping = whole_set, class Motion = fixed_vertices, class Search = density_method>
pipeline(Space, Policies = {}, Fitter = {}, Grouping = {}, Motion = {}, Search = {})
    -> pipeline<Space, Policies, Fitter, Grouping, Motion, Search>;

}  // namespace billow::inline BILLOW_ABI
