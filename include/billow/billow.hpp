// All of billow but the reading and writing of files, which is in io.hpp.
#pragma once

#include <billow/core/config.hpp>
#include <billow/core/disjoint_sets.hpp>
#include <billow/core/expected.hpp>
#include <billow/core/jobs.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/core/random.hpp>
#include <billow/core/simd.hpp>
#include <billow/core/types.hpp>
#include <billow/core/version.hpp>

#include <billow/geometry/bounds.hpp>
#include <billow/geometry/frame.hpp>
#include <billow/geometry/outline.hpp>
#include <billow/geometry/plane.hpp>
#include <billow/geometry/plane_intersection.hpp>
#include <billow/geometry/ray_tree.hpp>
#include <billow/geometry/rectangle.hpp>
#include <billow/geometry/screen.hpp>

#include <billow/image/alpha_coverage.hpp>
#include <billow/image/distance_field.hpp>
#include <billow/image/image.hpp>
#include <billow/image/mip_chain.hpp>
#include <billow/image/nearest.hpp>
#include <billow/image/raster.hpp>
#include <billow/image/srgb.hpp>

#include <billow/mesh/append_mesh.hpp>
#include <billow/mesh/components.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/material.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/mesh/roles.hpp>
#include <billow/mesh/select_faces.hpp>
#include <billow/mesh/validate.hpp>
#include <billow/mesh/vertex_identity.hpp>

#include <billow/plane_space/cube_map.hpp>
#include <billow/plane_space/plane_space.hpp>
#include <billow/plane_space/spherical.hpp>

#include <billow/fit/average.hpp>
#include <billow/fit/fit.hpp>
#include <billow/fit/least_squares.hpp>
#include <billow/fit/minimax.hpp>
#include <billow/fit/svd.hpp>

#include <billow/plants/branch_mesh.hpp>
#include <billow/plants/grammar.hpp>
#include <billow/plants/leaf_mesh.hpp>
#include <billow/plants/skeleton.hpp>
#include <billow/plants/species.hpp>
#include <billow/plants/textures.hpp>
#include <billow/plants/turtle.hpp>

#include <billow/shapes/box.hpp>
#include <billow/shapes/leaf_soup.hpp>
#include <billow/shapes/sphere.hpp>
#include <billow/shapes/teapot.hpp>

#include <billow/policy/contribution.hpp>
#include <billow/policy/falloff.hpp>
#include <billow/policy/orientation_bias.hpp>
#include <billow/policy/penalty.hpp>
#include <billow/policy/tangency.hpp>
#include <billow/policy/validity.hpp>

#include <billow/density/falloff_kernel.hpp>
#include <billow/density/grid.hpp>
#include <billow/density/rasterize.hpp>

#include <billow/cloud/billboard_cloud.hpp>
#include <billow/cloud/cracks.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/cloud/merge.hpp>
#include <billow/cloud/plane_order.hpp>

#include <billow/search/compact.hpp>
#include <billow/search/direction_search.hpp>
#include <billow/search/exact_search.hpp>
#include <billow/search/face_sets.hpp>
#include <billow/search/fail_safe.hpp>
#include <billow/search/greedy.hpp>
#include <billow/search/grouping.hpp>
#include <billow/search/lazy_directions.hpp>
#include <billow/search/leftovers.hpp>
#include <billow/search/motion.hpp>
#include <billow/search/nearest_offset.hpp>
#include <billow/search/offset_block.hpp>
#include <billow/search/offset_sweep.hpp>
#include <billow/search/parts.hpp>
#include <billow/search/plane_budget.hpp>
#include <billow/search/plane_distribution.hpp>
#include <billow/search/plane_sequence.hpp>
#include <billow/search/refine.hpp>
#include <billow/search/search_planes.hpp>
#include <billow/search/weld_online.hpp>
#include <billow/search/weld_planes.hpp>

#include <billow/improve/cardboard.hpp>
#include <billow/improve/drawn_mesh.hpp>
#include <billow/improve/envelope.hpp>
#include <billow/improve/exchange.hpp>
#include <billow/improve/joint_plane.hpp>
#include <billow/improve/merge_planes.hpp>
#include <billow/improve/plane_cover.hpp>
#include <billow/improve/reassign.hpp>
#include <billow/improve/refine_whole.hpp>
#include <billow/improve/serve_most.hpp>
#include <billow/improve/weld.hpp>

#include <billow/bake/bake_cloud.hpp>
#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/border.hpp>
#include <billow/bake/cloud_mesh.hpp>
#include <billow/bake/draw_set.hpp>
#include <billow/bake/horizon.hpp>
#include <billow/bake/mips.hpp>
#include <billow/bake/occlusion.hpp>
#include <billow/bake/pack.hpp>
#include <billow/bake/pack_search.hpp>
#include <billow/bake/pack_skyline.hpp>
#include <billow/bake/place_tiles.hpp>
#include <billow/bake/row_alpha.hpp>
#include <billow/bake/side_difference.hpp>
#include <billow/bake/sky_sites.hpp>
#include <billow/bake/sky_table.hpp>
#include <billow/bake/surface.hpp>
#include <billow/bake/texel.hpp>
#include <billow/bake/texture_sampler.hpp>
#include <billow/bake/tile_alpha.hpp>
#include <billow/bake/tile_drawer.hpp>
#include <billow/bake/tile_outline.hpp>
#include <billow/bake/tile_picture.hpp>
#include <billow/bake/visibility.hpp>

#include <billow/metrics/baselines.hpp>
#include <billow/metrics/camera.hpp>
#include <billow/metrics/channel.hpp>
#include <billow/metrics/color_error.hpp>
#include <billow/metrics/compare.hpp>
#include <billow/metrics/coverage_error.hpp>
#include <billow/metrics/difference_picture.hpp>
#include <billow/metrics/displacement.hpp>
#include <billow/metrics/draw_cost.hpp>
#include <billow/metrics/flip.hpp>
#include <billow/metrics/gap.hpp>
#include <billow/metrics/geometric_error.hpp>
#include <billow/metrics/lab.hpp>
#include <billow/metrics/nearest_planes.hpp>
#include <billow/metrics/picture.hpp>
#include <billow/metrics/plane_colors.hpp>
#include <billow/metrics/projected_faces.hpp>
#include <billow/metrics/render.hpp>
#include <billow/metrics/render_scene.hpp>
#include <billow/metrics/sample_tile.hpp>
#include <billow/metrics/sample_view.hpp>
#include <billow/metrics/statistic.hpp>
#include <billow/metrics/view_directions.hpp>
#include <billow/metrics/view_errors.hpp>
#include <billow/metrics/view_picture.hpp>

#include <billow/pipeline.hpp>
#include <billow/pipeline/build_result.hpp>
#include <billow/pipeline/choose.hpp>
#include <billow/pipeline/cloud_builder.hpp>
#include <billow/pipeline/shared_atlas.hpp>

#include <billow/lod/chain.hpp>
#include <billow/lod/displacement.hpp>
#include <billow/lod/switch_distance.hpp>
#include <billow/lod/whole_billboards.hpp>

#include <billow/presets.hpp>
