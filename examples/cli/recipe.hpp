// A recipe: how a cloud is made, as values that the options of a verb fill in.
#pragma once

#include <string>
#include <variant>

#include <billow/billow.hpp>
#include <billow/lod/chain.hpp>

namespace cli {

/// The fitter that --fit names. Fitting is a small part of the work, so the choice is made when it is
/// called.
struct chosen_fit {
    std::variant<billow::least_squares_fit, billow::no_fit, billow::average_fit, billow::svd_fit,
                 billow::minimax_fit>
        fitter{};
    bool allows_less_contribution = false;

    chosen_fit() : chosen_fit("least-squares") {}
    explicit chosen_fit(const std::string& name) {
        if (name == "none") fitter = billow::no_fit{};
        if (name == "average") fitter = billow::average_fit{};
        if (name == "svd") fitter = billow::svd_fit{};
        if (name == "minimax") fitter = billow::minimax_fit{};
        allows_less_contribution =
            std::visit([](const auto& fit) { return fit.allows_less_contribution; }, fitter);
    }
    [[nodiscard]] billow::plane operator()(const billow::face_table& faces,
                                           const billow::plane& start) const {
        return std::visit([&](const auto& fit) { return fit(faces, start); }, fitter);
    }
};
static_assert(billow::plane_fitter<chosen_fit>);

/// How the planes of a model are found, or of a part of it. Every choice is a value here; what a
/// user of the library chooses by type is branched on, at little cost, in the chosen_… parts.
struct recipe {
    bool is_spherical = false;
    int raster = 18;
    double penalty = 3;
    std::string fit = "least-squares";
    billow::build_options options{};
};

/// Makes the cloud of a recipe.
billow::expected<billow::build_result> make_cloud(const billow::mesh& source, const recipe& how,
                                                  const billow::progress_function& progress);

/// Makes a chain of levels with a recipe, of which options.build holds the options.
billow::expected<billow::lod_chain> make_chain(const billow::mesh& source, const recipe& how,
                                               const billow::lod_options& options,
                                               const billow::progress_function& progress);

}  // namespace cli
