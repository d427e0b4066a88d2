// A mesh in, a billboard cloud with its textures out, in one call.
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <billow/core/config.hpp>
#include <billow/core/expected.hpp>
#include <billow/core/progress.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/pipeline/build_result.hpp>
#include <billow/pipeline/cloud_builder.hpp>
#include <billow/search/parts.hpp>

namespace billow::inline BILLOW_ABI {

namespace detail {

[[nodiscard]] inline expected<done> check_options(const build_options& options) {
    if (!(options.epsilon.value > 0) || !std::isfinite(options.epsilon.value)) {
        return error{
            error_code::invalid_options,
            "epsilon is " + std::to_string(options.epsilon.value) + ", but must be greater than 0"};
    }
    return done{};
}

/// The part of each face, no_id where it is in none.
class part_membership {
public:
    explicit part_membership(std::size_t face_count) : part_of_face(face_count, no_id) {}

    void add(std::span<const face_id> faces) {
        for (const face_id face : faces) {
            BILLOW_ASSERT(face < part_of_face.size() && part_of_face[face] == no_id);
            part_of_face[face] = part_count;
        }
        ++part_count;
    }

    std::vector<part_id> part_of_face;
    part_id part_count = 0;
};

}  // namespace detail

/// Makes a billboard cloud of a mesh.
///
/// Needs   options within the ranges that greedy_options and bake_options state.
/// Fails   invalid_options: an epsilon that is not a positive number; and as make_face_table.
///         A mesh without any area gives a cloud without planes.
/// Cost    as greedy_search and bake_cloud. The cloud is the same for any number of threads.
template <class... Parts>
[[nodiscard]] expected<build_result> build_cloud(const mesh& source, const build_options& options,
                                                 const pipeline<Parts...>& parts,
                                                 const progress_function& progress = {}) {
    if (const auto good = detail::check_options(options); !good) return good.error();
    detail::cloud_builder builder(source, options, {}, 1, progress);
    return builder.run([&](part_id part) { builder.search(part, options, parts); });
}
[[nodiscard]] inline expected<build_result> build_cloud(const mesh& source,
                                                        const build_options& options = {}) {
    return build_cloud(source, options, pipeline{});
}

/// Makes one cloud of several parts of a mesh, each searched alone and in its own way: planes of
/// leaves do not slice the trunk, and a trunk may be finer or coarser than they are. All share the
/// atlases. The faces of no part stay a mesh: build_result::kept.
///
/// Needs   as above for every plan, and its faces within the mesh. Of `options`, bake and threads
///         are read; each part has its own thresholds.
/// Fails   as above.
/// Source  Fuhrmann et al. 2005, section 3.2.2.
template <class Pipeline>
[[nodiscard]] expected<build_result> build_cloud(const mesh& source, const build_options& options,
                                                 std::span<const part_plan<Pipeline>> plans,
                                                 const progress_function& progress = {}) {
    detail::part_membership members(source.face_count());
    for (const part_plan<Pipeline>& plan : plans) {
        if (const auto good = detail::check_options(plan.options); !good) return good.error();
        members.add(plan.faces);
    }
    detail::cloud_builder builder(source, options, std::move(members.part_of_face), plans.size(),
                                  progress);
    return builder.run(
        [&](part_id part) { builder.search(part, plans[part].options, plans[part].method); });
}
template <class Pipeline>
[[nodiscard]] expected<build_result> build_cloud(const mesh& source, const build_options& options,
                                                 const std::vector<part_plan<Pipeline>>& plans,
                                                 const progress_function& progress = {}) {
    return build_cloud(source, options, std::span(plans), progress);
}

/// The same for plans of different types.
template <class... Pipelines>
[[nodiscard]] expected<build_result> build_cloud(const mesh& source, const build_options& options,
                                                 const progress_function& progress,
                                                 const part_plan<Pipelines>&... plans) {
    detail::part_membership members(source.face_count());
    expected<done> good = done{};
    const auto add = [&](const auto& plan) {
        if (good) good = detail::check_options(plan.options);
        members.add(plan.faces);
    };
    (add(plans), ...);
    if (!good) return good.error();
    detail::cloud_builder builder(source, options, std::move(members.part_of_face),
                                  sizeof...(plans), progress);
    return builder.run([&](part_id part) {
        part_id next = 0;
        const auto search = [&](const auto& plan) {
            if (next++ == part) builder.search(part, plan.options, plan.method);
        };
        (search(plans), ...);
    });
}

}  // namespace billow::inline BILLOW_ABI
