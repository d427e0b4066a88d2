// The parts that a plane search is put together from.
#pragma once

#include <billow/density/rasterize.hpp>
#include <billow/fit/fit.hpp>
#include <billow/fit/least_squares.hpp>
#include <billow/plane_space/cube_map.hpp>
#include <billow/search/grouping.hpp>
#include <billow/search/motion.hpp>

namespace billow::inline BILLOW_ABI {

/// The parts of a pipeline that are chosen at compile time, each a value with its parameters:
/// `pipeline{spherical(24), density_policies{}, svd_fit{}}`.
template <plane_space Space = cube_map, class Policies = density_policies<>,
          plane_fitter Fitter = least_squares_fit, face_grouping Grouping = whole_set,
          vertex_motion Motion = fixed_vertices>
struct pipeline {
    Space space{};
    Policies policies{};
    Fitter fitter{};
    Grouping grouping{};
    Motion motion{};
};
template <class Space, class Policies = density_policies<>, class Fitter = least_squares_fit,
          class Grouping = whole_set, class Motion = fixed_vertices>
pipeline(Space, Policies = {}, Fitter = {}, Grouping = {}, Motion = {})
    -> pipeline<Space, Policies, Fitter, Grouping, Motion>;

}  // namespace billow::inline BILLOW_ABI
