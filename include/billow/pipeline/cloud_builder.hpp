// The steps from a mesh to its cloud, in their order: planes for each part, one cloud, welding,
// cardboard planes, rectangles, textures.
#pragma once

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>
#include <vector>

#include <billow/bake/bake_cloud.hpp>
#include <billow/cloud/cracks.hpp>
#include <billow/cloud/fit_billboards.hpp>
#include <billow/cloud/measure.hpp>
#include <billow/cloud/merge.hpp>
#include <billow/cloud/plane_order.hpp>
#include <billow/core/expected.hpp>
#include <billow/core/progress.hpp>
#include <billow/improve/cardboard.hpp>
#include <billow/improve/drawn_mesh.hpp>
#include <billow/improve/refine_whole.hpp>
#include <billow/improve/weld.hpp>
#include <billow/mesh/face_table.hpp>
#include <billow/mesh/select_faces.hpp>
#include <billow/pipeline/build_result.hpp>
#include <billow/search/greedy.hpp>
#include <billow/search/plane_budget.hpp>
#include <billow/search/search_planes.hpp>

namespace billow::inline BILLOW_ABI {

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
        weld();
        result_.search_seconds = seconds();
        if (result_.cloud.plane_count() > 0) texture();
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
            const face_table of_part = select_rows(faces_, rows, options_.threads);
            found = find_planes(of_part, plan, method);
            told.epsilon = found.cloud.epsilon;
            rows_done_ += rows.size();
            if (plan.refines_whole && found.moved.empty()) {
                whole_refinement_options how = plan.whole;
                how.least_cosine = least_cosine_of(method.policies.contribution);
                told.refined = refine_whole(of_part, found.cloud, how, average_fit{},
                                            options_.threads, progress_);
                order_planes_by_area(of_part, found.cloud);
            }
            told.curve = curve_of(of_part, found.cloud);
        }
        count_faces(part, found.cloud, told.faces);
        told.plane_count = found.cloud.plane_count();
        told.statistics = found.statistics;
        told.statistics.degenerate_faces = told.faces.degenerate;
        add_statistics(told.statistics, area_of(rows));
        clouds_.push_back(std::move(found.cloud));
        result_.moved.insert(result_.moved.end(), found.moved.begin(), found.moved.end());
        welds_.push_back(plan.weld);
        cardboards_.push_back(plan.cardboard);
        thresholds_.push_back(plan.bake.alpha.thresholds);
        result_.parts.push_back(told);
    }

private:
    template <class... Parts>
    [[nodiscard]] greedy_result find_planes(face_table faces, const build_options& plan,
                                            const pipeline<Parts...>& method) const {
        greedy_options how = plan.search;
        how.epsilon = plan.epsilon.in(faces.bounds);
        const progress_function progress = progress_of(faces.size);
        if (plan.planes == 0) {
            return search_planes(std::move(faces), source_.face_count(), how, method,
                                 options_.threads, progress);
        }
        plane_budget_options budget;
        budget.first_epsilon = how.epsilon / faces.bounds.radius;
        return greedy_search_for_planes(faces, source_.face_count(), plan.planes, how, method,
                                        options_.threads, progress, budget)
            .result;
    }

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

    /// Adds what is welded now to what the searches have moved.
    void weld() {
        if (welds_.empty()) return;
        welded_faces welded = weld_faces(source_, result_.cloud, welds_);
        result_.weld = welded.statistics;
        result_.moved.insert(result_.moved.end(), welded.moved.begin(), welded.moved.end());
        std::erase_if(result_.moved, [&](const moved_face& moved) {
            return result_.cloud.plane_of_face[moved.face] == no_id;
        });
        std::sort(result_.moved.begin(), result_.moved.end(),
                  [](const moved_face& a, const moved_face& b) { return a.face < b.face; });
    }

    void texture() {
        if (result_.moved.empty()) {
            bake(source_, without_kept(std::move(faces_)));
            return;
        }
        double tolerance = 0;
        for (const weld_options& weld : welds_) tolerance = std::max(tolerance, weld.tolerance);
        const mesh drawn = drawn_mesh(source_, result_.cloud, result_.moved);
        result_.cracks = measure_cracks(source_, result_.cloud, source_, tolerance);
        result_.cracks_drawn = measure_cracks(source_, result_.cloud, drawn, tolerance);
        faces_ = *make_face_table(drawn, options_.threads);  // the source's was good
        bake(drawn, without_kept(std::move(faces_)));
    }

    void bake(const mesh& drawn, const face_table& table) {
        for (part_id part = 0; part < part_count_; ++part) {
            cardboards_[part].only_part = part;
            result_.parts[part].cardboard_planes =
                add_cardboard_planes(drawn, result_.cloud, cardboards_[part], options_.threads);
        }
        fit_billboards(drawn, result_.cloud, options_.threads);
        result_.errors = measure_errors(source_, result_.cloud);
        if (result_.faces.kept > 0) result_.errors.dropped_area_share = dropped_area_share();
        bake_options how = options_.bake;
        how.part_thresholds = thresholds_;
        if (options_.packs_tiles) {
            result_.baked =
                bake_cloud(drawn, table, result_.cloud, how, options_.threads, progress_);
        } else {
            result_.drawn =
                draw_tiles(drawn, table, result_.cloud, how, options_.threads, progress_);
        }
    }

    /// Without what is kept, which has no plane either.
    [[nodiscard]] double dropped_area_share() const {
        double dropped = 0;
        double all = 0;
        for (face_id face = 0; face < source_.face_count(); ++face) {
            const auto [a, b, c] = source_.corners(face);
            const double area = glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)));
            all += area;
            const bool is_lost =
                part_of(face) != no_id && result_.cloud.plane_of_face[face] == no_id;
            if (is_lost) dropped += area;
        }
        return all > 0 ? dropped / all : 0;
    }

    /// Billboards must not show what is kept.
    [[nodiscard]] face_table without_kept(face_table faces) const {
        if (result_.faces.kept == 0) return faces;
        face_rows rows;
        for (std::uint32_t row = 0; row < faces.size; ++row) {
            if (part_of(faces.source[row]) != no_id) rows.push_back(row);
        }
        return select_rows(faces, rows, options_.threads);
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
    std::vector<weld_options> welds_{};
    std::vector<cardboard_options> cardboards_{};
    std::vector<coverage_thresholds> thresholds_{};
    build_result result_{};
};

}  // namespace detail

}  // namespace billow::inline BILLOW_ABI
