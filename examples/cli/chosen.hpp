// Parts of a pipeline that are chosen when the tool runs. Each holds the parts that the library
// offers for its place and passes calls on; what is called for every face branches on a flag that is
// the same for all of them.
#pragma once

#include <span>
#include <variant>
#include <vector>

#include <billow/billow.hpp>

namespace cli {

using billow::dvec2;
using billow::dvec3;
using billow::orientation_id;

class chosen_space {
    template <class Call>
    auto pass(const Call& call) const {
        return std::visit(call, space_);
    }

public:
    chosen_space(const billow::cube_map& space = billow::cube_map()) : space_(space) {}
    chosen_space(const billow::spherical& space) : space_(space) {}

    [[nodiscard]] bool is_spherical() const noexcept { return space_.index() == 1; }
    [[nodiscard]] int resolution() const {
        return pass([](const auto& s) { return s.resolution(); });
    }

    [[nodiscard]] std::size_t orientation_count() const {
        return pass([](const auto& s) { return s.orientation_count(); });
    }
    [[nodiscard]] dvec3 direction(orientation_id id) const {
        return pass([&](const auto& s) { return s.direction(id); });
    }
    [[nodiscard]] orientation_id antipode(orientation_id id) const {
        return pass([&](const auto& s) { return s.antipode(id); });
    }
    [[nodiscard]] orientation_id orientation_of(const dvec3& normal) const {
        return pass([&](const auto& s) { return s.orientation_of(normal); });
    }
    [[nodiscard]] billow::orientation_cell cell(orientation_id id) const {
        return pass([&](const auto& s) { return s.cell(id); });
    }
    [[nodiscard]] billow::orientation_list neighbours(orientation_id id) const {
        return pass([&](const auto& s) { return s.neighbours(id); });
    }
    [[nodiscard]] billow::orientation_patch patch(orientation_id id) const {
        return pass([&](const auto& s) { return s.patch(id); });
    }
    [[nodiscard]] dvec3 direction_at(int chart, const dvec2& uv) const {
        return pass([&](const auto& s) { return s.direction_at(chart, uv); });
    }

private:
    std::variant<billow::cube_map, billow::spherical> space_;
};
static_assert(billow::plane_space<chosen_space>);

struct chosen_validity {
    bool is_per_vertex = false;

    chosen_validity(billow::hull_of_samples = {}) {}
    chosen_validity(billow::intersection_of_vertices) : is_per_vertex(true) {}

    template <class V>
    [[nodiscard]] billow::offset_interval<V> operator()(const billow::face_lanes<V>& face,
                                                        const billow::cell_lanes<V>& cell,
                                                        V epsilon) const noexcept {
        return is_per_vertex ? billow::intersection_of_vertices{}(face, cell, epsilon)
                             : billow::hull_of_samples{}(face, cell, epsilon);
    }
};
static_assert(billow::validity<chosen_validity, billow::simd::wide>);

struct chosen_contribution {
    bool is_angular = false;
    float least_cosine = 0;  ///< of billow::within_angle

    chosen_contribution(billow::projected_area = {}) {}
    chosen_contribution(billow::angular_area) : is_angular(true) {}

    void limit_angle(double max_angle_deg) {
        least_cosine = billow::within_angle<>({}, max_angle_deg).least_cosine;
    }

    template <class V>
    [[nodiscard]] V operator()(const billow::face_lanes<V>& face,
                               const billow::vec3_lanes<V>& normal) const noexcept {
        const V worth = is_angular ? billow::angular_area{}(face, normal)
                                   : billow::projected_area{}(face, normal);
        if (least_cosine == 0) return worth;
        using lanes = billow::simd::lanes<V>;
        const V cosine = billow::simd::abs(dot(face.normal, normal));
        return billow::simd::select(cosine >= lanes::fill(least_cosine), worth, lanes::fill(0));
    }
};
static_assert(billow::contribution<chosen_contribution, billow::simd::wide>);

struct chosen_bias : billow::viewpoint_bias {
    chosen_bias(billow::no_bias = {}) {}
    chosen_bias(const billow::horizontal_penalty& from) {
        horizontal_share = from.share;
        cutoff_deg = from.cutoff_deg;
        up = from.up;
    }
};
static_assert(billow::orientation_bias<chosen_bias>);

class chosen_fit {
public:
    chosen_fit(billow::least_squares_fit fit = {}) : fitter_(fit) { look(); }
    chosen_fit(billow::no_fit fit) : fitter_(fit) { look(); }
    chosen_fit(billow::average_fit fit) : fitter_(fit) { look(); }
    chosen_fit(billow::svd_fit fit) : fitter_(fit) { look(); }
    chosen_fit(billow::minimax_fit fit) : fitter_(fit) { look(); }

    bool allows_less_contribution = false;

    [[nodiscard]] billow::plane operator()(const billow::face_table& faces,
                                           const billow::plane& start) const {
        return std::visit([&](const auto& fit) { return fit(faces, start); }, fitter_);
    }
    /// As --fit calls it.
    [[nodiscard]] const char* name() const {
        static constexpr const char* names[] = {"least-squares", "none", "average", "svd",
                                                "minimax"};
        return names[fitter_.index()];
    }

private:
    void look() {
        allows_less_contribution =
            std::visit([](const auto& fit) { return fit.allows_less_contribution; }, fitter_);
    }

    std::variant<billow::least_squares_fit, billow::no_fit, billow::average_fit, billow::svd_fit,
                 billow::minimax_fit>
        fitter_;
};
static_assert(billow::plane_fitter<chosen_fit>);

struct chosen_grouping {
    static constexpr bool takes_all = false;
    bool is_compact = false;
    billow::heaviest_group<> compact{};

    chosen_grouping(billow::whole_set = {}) {}
    chosen_grouping(const billow::heaviest_group<>& from) : is_compact(true), compact(from) {}

    [[nodiscard]] billow::face_rows operator()(const billow::face_table& valid,
                                               const billow::plane& p, double epsilon,
                                               billow::parallel threads) const {
        return is_compact ? compact(valid, p, epsilon, threads)
                          : billow::whole_set{}(valid, p, epsilon, threads);
    }
};
static_assert(billow::face_grouping<chosen_grouping>);

struct chosen_motion {
    static constexpr bool is_still = false;
    bool is_welding = false;
    billow::weld_online weld{};

    chosen_motion(billow::fixed_vertices = {}) {}
    chosen_motion(const billow::weld_online& from) : is_welding(true), weld(from) {}

    void start(const billow::face_table& faces, double epsilon) {
        if (is_welding) weld.start(faces, epsilon);
    }
    void keep_allowed(const billow::face_table& faces, const billow::plane& p,
                      billow::face_rows& rows) const {
        if (is_welding) weld.keep_allowed(faces, p, rows);
    }
    [[nodiscard]] billow::face_rows plane_found(const billow::face_table& taken,
                                                const billow::plane& p,
                                                billow::face_table& remaining) {
        if (is_welding) return weld.plane_found(taken, p, remaining);
        return {};
    }
    void move(billow::face_table& remaining, const billow::face_rows& rows) const {
        if (is_welding) weld.move(remaining, rows);
    }
    [[nodiscard]] std::vector<billow::moved_face> moved_faces() const {
        return is_welding ? weld.moved_faces() : std::vector<billow::moved_face>{};
    }
};
static_assert(billow::vertex_motion<chosen_motion>);

}  // namespace cli
