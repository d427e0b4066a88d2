// A mesh in, a billboard cloud with its textures out, in one call.
#pragma once

#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include <billow/bake/bake_cloud.hpp>
#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/cloud_mesh.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/core/expected.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/search/greedy.hpp>

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
    bake_options bake{};
    parallel threads{};
};

/// A textured billboard cloud, and how it came about.
struct build_result {
    billboard_cloud cloud{};
    baked_cloud baked{};
    greedy_statistics statistics{};
    cloud_errors errors{};
    double search_seconds = 0;
    double bake_seconds = 0;

    /// The cloud as a mesh that lies over the original, ready for write_glb.
    [[nodiscard]] mesh to_mesh() const { return cloud_mesh(cloud, baked); }
};

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
    if (!(options.epsilon.value > 0) || !std::isfinite(options.epsilon.value)) {
        return error{
            error_code::invalid_options,
            "epsilon is " + std::to_string(options.epsilon.value) + ", but must be greater than 0"};
    }
    expected<face_table> faces = make_face_table(source, options.threads);
    if (!faces) return faces.error();

    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    build_result result;
    if (faces->size == 0) {
        result.cloud.bounds = faces->bounds;
        result.cloud.epsilon = options.epsilon.in(faces->bounds);
        result.cloud.plane_of_face.assign(source.face_count(), no_id);
        result.statistics.degenerate_faces = source.face_count();
        return result;
    }
    greedy_options search = options.search;
    search.epsilon = options.epsilon.in(faces->bounds);
    greedy_result found =
        greedy_search(*faces, source.face_count(), search, parts, options.threads, progress);
    result.cloud = std::move(found.cloud);
    result.statistics = found.statistics;
    result.search_seconds = seconds();
    fit_billboards(source, result.cloud, options.threads);
    result.errors = measure_errors(source, result.cloud);
    result.baked =
        bake_cloud(source, *faces, result.cloud, options.bake, options.threads, progress);
    result.bake_seconds = seconds() - result.search_seconds;
    return result;
}
[[nodiscard]] inline expected<build_result> build_cloud(const mesh& source,
                                                        const build_options& options = {}) {
    return build_cloud(source, options, pipeline{});
}

}  // namespace billow::inline BILLOW_ABI
