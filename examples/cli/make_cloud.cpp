// The pipelines that the tool knows. Apart from the other files, for they take long to compile.

#include "recipe.hpp"

namespace cli {

using namespace billow;

namespace {

/// Calls `use` with the pipeline that a recipe describes.
template <class Use>
auto with_pipeline(const recipe& how, const Use& use) {
    const auto in_space = [&](const auto& space) {
        const density_policies policies{hull_of_samples{}, projected_area{},
                                        inner_side_penalty{how.penalty}};
        return use(pipeline{space, policies, chosen_fit(how.fit)});
    };
    if (how.is_spherical) return in_space(spherical(how.raster));
    return in_space(cube_map(how.raster));
}

}  // namespace

expected<build_result> make_cloud(const mesh& source, const recipe& how,
                                  const progress_function& progress) {
    return with_pipeline(
        how, [&](const auto& parts) { return build_cloud(source, how.options, parts, progress); });
}

expected<lod_chain> make_chain(const mesh& source, const recipe& how, const lod_options& options,
                               const progress_function& progress) {
    return with_pipeline(
        how, [&](const auto& parts) { return build_lod_chain(source, options, parts, progress); });
}

}  // namespace cli
