// The pipelines that the tool knows. Apart from the other files, for they take long to compile.

#include "recipe.hpp"

namespace cli {

using namespace billow;

expected<build_result> make_cloud(const mesh& source, const recipe& how,
                                  const progress_function& progress) {
    const auto run = [&](const auto& space) {
        const density_policies policies{hull_of_samples{}, projected_area{},
                                        inner_side_penalty{how.penalty}};
        return build_cloud(source, how.options, pipeline{space, policies, chosen_fit(how.fit)},
                           progress);
    };
    if (how.is_spherical) return run(spherical(how.raster));
    return run(cube_map(how.raster));
}

}  // namespace cli
