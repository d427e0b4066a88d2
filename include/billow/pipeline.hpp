// A mesh in, a billboard cloud with its textures out, in one call.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <billow/bake/bake_cloud.hpp>
#include <billow/bake/baked_cloud.hpp>
#include <billow/bake/cloud_mesh.hpp>
#include <billow/cloud/billboard_cloud.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/cloud/merge.hpp>
#include <billow/core/expected.hpp>
#include <billow/core/parallel.hpp>
#include <billow/core/progress.hpp>
#include <billow/mesh/append_mesh.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/select_faces.hpp>
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
    std::size_t plane_count = 0;
    double epsilon = 0;  ///< scene units
    greedy_statistics statistics{};
};

/// A textured billboard cloud, and how it came about.
struct build_result {
    billboard_cloud cloud{};
    baked_cloud baked{};
    mesh kept{};  ///< the faces of no part, as they are in the source
    face_counts faces{};
    greedy_statistics statistics{};    ///< sums over the parts; shares are of their common area
    std::vector<part_result> parts{};  ///< in the order of the plans
    cloud_errors errors{};
    double search_seconds = 0;
    double bake_seconds = 0;

    /// The cloud as a mesh that lies over the original, ready for write_glb. What was kept comes
    /// behind it, with its own materials and the feature id after that of the last plane.
    [[nodiscard]] mesh to_mesh() const {
        mesh result = cloud_mesh(cloud, baked);
        if (kept.face_count() > 0) {
            append_mesh(result, kept, static_cast<std::uint32_t>(cloud.plane_count()));
        }
        return result;
    }
};

namespace detail {

/// One call of build_cloud; its methods are the steps in their order.
class cloud_builder {
public:
    /// `part_of_face`: no_id for a face that is kept; empty: all faces are of part 0.
    cloud_builder(const mesh& source, const build_options& options,
                  std::vector<part_id> part_of_face, std::size_t part_count,
                  const progress_function& progress)
        : source_(source),
          options_(options),
          part_of_face_(std::move(part_of_face)),
          part_count_(part_count),
          progress_(progress) {}

    /// `search_part(part)` calls search().
    template <class SearchPart>
    [[nodiscard]] expected<build_result> run(const SearchPart& search_part) {
        expected<face_table> faces = make_face_table(source_, options_.threads);
        if (!faces) return faces.error();
        faces_ = std::move(*faces);
        for (part_id part = 0; part < part_count_; ++part) search_part(part);
        result_.cloud = merged();
        keep_faces();
        result_.search_seconds = seconds();
        if (result_.cloud.plane_count() > 0) bake();
        result_.bake_seconds = seconds() - result_.search_seconds;
        return std::move(result_);
    }

    template <class... Parts>
    void search(part_id part, const build_options& plan, const pipeline<Parts...>& method) {
        part_result told;
        told.epsilon = plan.epsilon.in(faces_.bounds);
        greedy_result found;
        const face_rows rows = rows_of(part);
        if (rows.empty()) {
            found.cloud.bounds = faces_.bounds;
            found.cloud.epsilon = told.epsilon;
            found.cloud.plane_of_face.assign(source_.face_count(), no_id);
        } else {
            greedy_options how = plan.search;
            how.epsilon = told.epsilon;
            found = greedy_search(select_rows(faces_, rows, options_.threads), source_.face_count(),
                                  how, method, options_.threads, progress_of(rows.size()));
            rows_done_ += rows.size();
        }
        count_faces(part, found.cloud, told.faces);
        told.plane_count = found.cloud.plane_count();
        told.statistics = found.statistics;
        told.statistics.degenerate_faces = told.faces.degenerate;
        add_statistics(told.statistics, area_of(rows));
        clouds_.push_back(std::move(found.cloud));
        thresholds_.push_back(plan.bake.thresholds);
        result_.parts.push_back(told);
    }

private:
    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }
    [[nodiscard]] part_id part_of(face_id face) const noexcept {
        return part_of_face_.empty() ? 0 : part_of_face_[face];
    }
    [[nodiscard]] face_rows rows_of(part_id part) const {
        face_rows rows;
        for (std::uint32_t row = 0; row < faces_.size; ++row) {
            if (part_of(faces_.source[row]) == part) rows.push_back(row);
        }
        return rows;
    }
    [[nodiscard]] double area_of(const face_rows& rows) const {
        double area = 0;
        for (const std::uint32_t row : rows) area += static_cast<double>(faces_.area[row]);
        return area;
    }

    /// Progress of one part as progress of the whole search.
    [[nodiscard]] progress_function progress_of(std::size_t rows) const {
        if (!progress_ || part_count_ == 1) return progress_;
        const auto all = static_cast<double>(std::max<std::size_t>(1, faces_.size));
        const double before = static_cast<double>(rows_done_) / all;
        const double share = static_cast<double>(rows) / all;
        return [this, before, share](std::string_view stage, double done) {
            progress_(stage, before + share * done);
        };
    }

    void count_faces(part_id part, const billboard_cloud& cloud, face_counts& counts) const {
        std::vector<char> is_degenerate(source_.face_count(), 0);
        for (const face_id face : faces_.degenerate) is_degenerate[face] = 1;
        for (face_id face = 0; face < source_.face_count(); ++face) {
            if (part_of(face) != part) continue;
            const bool is_mapped = cloud.plane_of_face[face] != no_id;
            ++(is_mapped                  ? counts.mapped
               : is_degenerate[face] != 0 ? counts.degenerate
                                          : counts.dropped);
        }
    }

    void add_statistics(const greedy_statistics& of, double area) {
        greedy_statistics& sum = result_.statistics;
        sum.refined_planes += of.refined_planes;
        sum.refinement_levels += of.refinement_levels;
        sum.fail_safes += of.fail_safes;
        sum.tweaks += of.tweaks;
        sum.degenerate_faces += of.degenerate_faces;
        sum.leftover_faces += of.leftover_faces;
        sum.dropped_faces += of.dropped_faces;
        area_done_ += area;
        const double share = area_done_ > 0 ? area / area_done_ : 0;
        const auto add_share = [share](double& to, double more) { to += (more - to) * share; };
        add_share(sum.leftover_area_share, of.leftover_area_share);
        add_share(sum.dropped_area_share, of.dropped_area_share);
        add_share(sum.beyond_epsilon_area_share, of.beyond_epsilon_area_share);
    }

    [[nodiscard]] billboard_cloud merged() {
        if (!clouds_.empty()) return merge_clouds(std::move(clouds_));
        billboard_cloud none;
        none.bounds = faces_.bounds;
        none.plane_of_face.assign(source_.face_count(), no_id);
        return none;
    }

    void keep_faces() {
        std::vector<face_id> kept;
        for (face_id face = 0; face < source_.face_count(); ++face) {
            if (part_of(face) == no_id) kept.push_back(face);
        }
        if (!kept.empty()) result_.kept = select_faces(source_, kept);
        for (const part_result& part : result_.parts) {
            result_.faces.mapped += part.faces.mapped;
            result_.faces.degenerate += part.faces.degenerate;
            result_.faces.dropped += part.faces.dropped;
        }
        result_.faces.kept = kept.size();
        BILLOW_ASSERT(result_.faces.all() == source_.face_count());
    }

    void bake() {
        fit_billboards(source_, result_.cloud, options_.threads);
        result_.errors = measure_errors(source_, result_.cloud);
        if (result_.faces.kept > 0) remove_kept_rows();  // billboards must not show them
        result_.baked =
            bake_cloud(source_, faces_, result_.cloud, options_.bake, options_.threads, progress_);
    }
    void remove_kept_rows() {
        face_rows rows;
        for (std::uint32_t row = 0; row < faces_.size; ++row) {
            if (part_of(faces_.source[row]) != no_id) rows.push_back(row);
        }
        faces_ = select_rows(faces_, rows, options_.threads);
    }

    const mesh& source_;
    const build_options& options_;
    std::vector<part_id> part_of_face_;
    std::size_t part_count_;
    const progress_function& progress_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    face_table faces_{};
    std::size_t rows_done_ = 0;
    double area_done_ = 0;
    std::vector<billboard_cloud> clouds_{};
    std::vector<coverage_thresholds> thresholds_{};
    build_result result_{};
};

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
