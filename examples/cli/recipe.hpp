// A recipe: how a cloud is made, as values that the options of a verb fill in.
#pragma once

#include <optional>
#include <string>

#include <billow/billow.hpp>
#include <billow/lod/chain.hpp>
#include <billow/pipeline/choose.hpp>
#include <billow/presets.hpp>

#include "chosen.hpp"

namespace cli {

using tool_policies =
    billow::density_policies<chosen_validity, chosen_contribution, billow::inner_side_penalty,
                             billow::distance_falloff, chosen_bias>;
using tool_pipeline = billow::pipeline<chosen_space, tool_policies, chosen_fit, chosen_grouping,
                                       chosen_motion, billow::either_method>;

/// How the planes of a model are found, or of a part of it.
struct recipe {
    billow::build_options options{};
    tool_pipeline method{};
};

/// What a preset of the library fixes.
template <class Pipeline>
[[nodiscard]] recipe recipe_of(const billow::preset<Pipeline>& from) {
    const auto& policies = from.method.policies;
    using falloff = std::remove_cvref_t<decltype(policies.falloff)>;
    constexpr bool is_exact =
        std::is_same_v<std::remove_cvref_t<decltype(from.method.search)>, billow::exact_method>;
    recipe how{from.options,
               {from.method.space,
                {policies.validity, policies.contribution, policies.penalty, {}, policies.bias},
                from.method.fitter,
                from.method.grouping,
                from.method.motion,
                {.is_exact = is_exact}}};
    if constexpr (is_exact) how.method.search.exact = from.method.search;
    if constexpr (falloff::falls) {
        how.method.policies.falloff = policies.falloff;
    } else {
        how.options.search.falloff = billow::falloff_use::nowhere;
    }
    return how;
}

/// What becomes of a trunk that is split off.
enum class trunk_use { billboards, keep, reduce };

/// A cloud for a distance: what was asked for, and what follows.
struct chosen_view {
    billow::viewing_options seen{};
    billow::viewing_choice choice{};
};

/// How a given model becomes a cloud.
struct model_recipe {
    recipe whole{};  ///< or the foliage, where there is a trunk
    std::optional<recipe> trunk{};
    billow::face_roles roles{};  ///< of a model with a trunk
    trunk_use use = trunk_use::billboards;
    double reduced_share = 1;           ///< of the trunk's triangles, trunk_use::reduce
    std::optional<chosen_view> view{};  ///< where epsilon and texels were chosen for a distance
    std::string preset{};
    std::string note{};  ///< one line on what was chosen, and why
};

/// Makes the cloud of a recipe.
billow::expected<billow::build_result> make_cloud(const billow::mesh& source,
                                                  const model_recipe& how,
                                                  const billow::progress_function& progress);

/// Makes a chain of levels with a recipe, of which options.build holds the options.
billow::expected<billow::lod_chain> make_chain(const billow::mesh& source, const recipe& how,
                                               const billow::lod_options& options,
                                               const billow::progress_function& progress);

}  // namespace cli
