// Levels of detail of one mesh: billboard clouds of fewer and fewer planes, each made of the one
// above or of the mesh.
//
// Fuhrmann et al. 2005, section 3.3.8: a level that is made of the billboards of the level above
// keeps near their planes, so that a switch between the two shows less.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <billow/lod/displacement.hpp>
#include <billow/lod/whole_billboards.hpp>
#include <billow/pipeline.hpp>
#include <billow/search/plane_budget.hpp>
#include <billow/search/search_planes.hpp>

namespace billow::inline BILLOW_ABI {

enum class lod_source {
    level_above,  ///< incremental, Fuhrmann et al. 2005
    mesh,         ///< independent of the other levels
};

struct lod_options {
    std::vector<std::size_t> levels{24, 11, 4};  ///< most planes of each level, descending
    lod_source made_of = lod_source::level_above;
    std::size_t least_incremental =
        10;                    ///< levels of fewer planes are made of the mesh; Fuhrmann et
                               ///< al. 2005: bad results below 10
    double texel_share = 0.5;  ///< texels along the diameter, of those of the level above
    build_options build{};     ///< texels of level 0; epsilon and most planes are not read
};

/// A level of detail.
struct lod_level {
    build_result built{};
    std::size_t most_planes = 0;            ///< as asked for
    lod_source made_of = lod_source::mesh;  ///< level 0 always of the mesh
    /// No corner is drawn farther from its place, scene units: epsilon, or what was met where that is
    /// larger, and the bound of the level it is made of.
    double error_bound = 0;
    displacement error{};  ///< from the mesh, composed through the levels
    displacement jump{};   ///< from the level above, at the switch; level 0: from the mesh
};

struct lod_chain {
    bounding_sphere bounds{};  ///< of the mesh
    std::vector<lod_level> levels{};
};

/// Makes a cloud of at most `most_planes` planes, with the rest of the options as they are.
template <class B>
concept level_builder = requires(const B& build, const mesh& source, const build_options& options,
                                 std::size_t most_planes, const progress_function& progress) {
    { build(source, options, most_planes, progress) } -> std::same_as<expected<build_result>>;
};

namespace detail {

[[nodiscard]] inline std::optional<error> fault_of(const lod_options& options) {
    const auto refuse = [](const std::string& why) {
        return error{error_code::invalid_options, why};
    };
    if (options.levels.empty()) return refuse("a chain needs a level");
    std::size_t above = 10001;
    for (const std::size_t planes : options.levels) {
        if (planes < 1 || planes > 10000) {
            return refuse("a level of " + std::to_string(planes) +
                          " planes is not between 1 and 10000");
        }
        if (planes >= above) return refuse("levels must have fewer and fewer planes");
        above = planes;
    }
    if (!(options.texel_share > 0 && options.texel_share <= 1)) {
        return refuse("the share of texels must be above 0 and at most 1");
    }
    return std::nullopt;
}

}  // namespace detail

/// Makes a chain with two builders: one for the mesh, one for the mesh of a cloud, which
/// keeps billboards whole.
///
/// Shape   one level an entry of options.levels.
/// Fails   invalid_options: levels that are none, not descending or outside 1 to 10000, a texel share
///         outside (0, 1]; and as the builders.
/// Cost    that of the builders, and 100 bytes a face. Same result for any number of threads when the
///         builders' is.
/// Source  Fuhrmann et al. 2005, section 3.3.8. Differs: epsilon follows from the number of planes.
template <level_builder FromMesh, level_builder FromBillboards>
[[nodiscard]] expected<lod_chain> build_lod_chain(const mesh& source, const lod_options& options,
                                                  const FromMesh& from_mesh,
                                                  const FromBillboards& from_billboards,
                                                  const progress_function& progress = {}) {
    if (const auto fault = detail::fault_of(options)) return *fault;
    lod_chain chain;
    build_options build = options.build;
    double texel_share = 1;
    drawn_faces original;
    drawn_faces above;
    for (const std::size_t most_planes : options.levels) {
        const std::size_t number = chain.levels.size();
        const bool is_incremental = number > 0 && options.made_of == lod_source::level_above &&
                                    most_planes >= options.least_incremental;
        build.bake.texels =
            std::max(1, static_cast<int>(std::lround(options.build.bake.texels * texel_share)));
        build.bake.texels_per_unit = options.build.bake.texels_per_unit * texel_share;
        texel_share *= options.texel_share;
        progress_function tell;
        if (progress) {
            tell = [&](std::string_view stage, double share) {
                progress("level " + std::to_string(number) + ": " + std::string(stage), share);
            };
        }
        const mesh billboards = is_incremental ? cloud_mesh(chain.levels.back().built.cloud,
                                                            chain.levels.back().built.baked)
                                               : mesh{};
        auto built = is_incremental ? from_billboards(billboards, build, most_planes, tell)
                                    : from_mesh(source, build, most_planes, tell);
        if (!built) return built.error();

        lod_level level{.built = std::move(*built), .most_planes = most_planes};
        if (number == 0) {  // the builder has checked the mesh
            chain.bounds = level.built.cloud.bounds;
            original = undisplaced(source);
            above = original;
        }
        const billboard_cloud& cloud = level.built.cloud;
        level.error_bound = std::max(cloud.epsilon, level.built.errors.max_error);
        // Welding moves a corner by epsilon at most, along its plane while its distance stays.
        if (!level.built.moved.empty()) level.error_bound *= std::numbers::sqrt2;
        if (is_incremental) {
            level.made_of = lod_source::level_above;
            level.built.kept = chain.levels.back().built.kept;
            level.error_bound += chain.levels.back().error_bound;
        }
        drawn_faces drawn =
            is_incremental
                ? drawn_through(cloud, billboards_of_faces(billboards),
                                chain.levels[number - 1].built.cloud.plane_count(), above)
                : drawn_by(cloud, original, level.built.moved);
        level.error = displacement_between(source, original, drawn);
        level.jump = displacement_between(source, above, drawn);
        above = std::move(drawn);
        chain.levels.push_back(std::move(level));
    }
    return chain;
}

namespace detail {

/// An epsilon of a cloud of about `most_planes` planes and not more, scene units. Searches that find
/// more are stopped and count for nothing.
template <class... Parts>
[[nodiscard]] double epsilon_of_level(const face_table& faces, std::size_t face_count,
                                      const build_options& options, std::size_t most_planes,
                                      const pipeline<Parts...>& parts) {
    const auto search = [&](double epsilon, std::size_t limit) {
        greedy_options how = options.search;
        how.epsilon = epsilon;
        how.max_planes = most_planes + 1;
        const auto found = search_planes(faces, face_count, how, parts, options.threads);
        const std::size_t planes = found.cloud.plane_count();
        return planes > most_planes ? limit + 1 : planes;
    };
    return search_for_planes(most_planes, faces.bounds.radius, search,
                             [](std::size_t planes) { return planes; }, {.most_epsilon = 2})
        .epsilon;
}

template <class... Parts>
[[nodiscard]] expected<build_result> build_level(const mesh& source, build_options options,
                                                 std::size_t most_planes,
                                                 const pipeline<Parts...>& parts,
                                                 const progress_function& progress) {
    const auto faces = make_face_table(source, options.threads);
    if (!faces) return faces.error();
    options.epsilon = tolerance::scene_units(1);
    if (faces->size > 0) {
        report(progress, "search", 0);
        options.epsilon = tolerance::scene_units(
            epsilon_of_level(*faces, source.face_count(), options, most_planes, parts));
    }
    options.planes = 0;
    options.search.max_planes = most_planes;
    return build_cloud(source, options, parts, progress);
}

}  // namespace detail

/// Makes a chain with a pipeline. Levels that are made of billboards keep them whole instead of
/// moving vertices: billboards share none.
template <class... Parts>
[[nodiscard]] expected<lod_chain> build_lod_chain(const mesh& source, const lod_options& options,
                                                  const pipeline<Parts...>& parts,
                                                  const progress_function& progress = {}) {
    const auto from_mesh = [&](const mesh& of, const build_options& build, std::size_t most_planes,
                               const progress_function& tell) {
        return detail::build_level(of, build, most_planes, parts, tell);
    };
    const auto from_billboards = [&](const mesh& of, build_options build, std::size_t most_planes,
                                     const progress_function& tell) {
        build.search.skip_area = 0;  // a billboard shows many faces
        build.search.min_contribution = 0;
        build.weld = {};              // billboards share no vertex
        build.refines_whole = false;  // it would tear them apart
        const pipeline whole{parts.space, parts.policies, parts.fitter, parts.grouping,
                             whole_billboards(billboards_of_faces(of))};
        return detail::build_level(of, build, most_planes, whole, tell);
    };
    return build_lod_chain(source, options, from_mesh, from_billboards, progress);
}

}  // namespace billow::inline BILLOW_ABI
