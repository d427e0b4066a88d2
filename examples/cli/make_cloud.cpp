// The searches of the tool. Apart from the other files, for they take long to compile.

#include <vector>

#include "recipe.hpp"
#ifdef BILLOW_HAS_REDUCE
#include <billow/reduce.hpp>
#endif

namespace cli {

using namespace billow;

namespace {

/// Twigs fall apart when they are reduced further than this, in radii.
constexpr double most_reduction_error = 0.02;

expected<done> treat_trunk(mesh& trunk, double radius, const model_recipe& how) {
    if (how.use != trunk_use::reduce || trunk.face_count() == 0) return done{};
#ifdef BILLOW_HAS_REDUCE
    trunk = reduce_mesh(trunk, how.reduced_share, most_reduction_error * radius).mesh;
    return done{};
#else
    static_cast<void>(radius);
    return error{error_code::unsupported,
                 "--trunk reduce needs a tool that was built with meshoptimizer"};
#endif
}

}  // namespace

expected<build_result> make_cloud(const mesh& source, const model_recipe& how,
                                  const progress_function& progress) {
    if (!how.trunk) return build_cloud(source, how.whole.options, how.whole.method, progress);
    std::vector<part_plan<tool_pipeline>> plans{
        {how.roles.faces_of(face_role::foliage), how.whole.options, how.whole.method}};
    if (how.use == trunk_use::billboards) {
        plans.push_back(
            {how.roles.faces_of(face_role::solid), how.trunk->options, how.trunk->method});
    }
    expected<build_result> result = build_cloud(source, how.whole.options, plans, progress);
    if (result) {
        const auto treated = treat_trunk(result->kept, result->cloud.bounds.radius, how);
        if (!treated) return treated.error();
    }
    return result;
}

expected<lod_chain> make_chain(const mesh& source, const recipe& how, const lod_options& options,
                               const progress_function& progress) {
    return build_lod_chain(source, options, how.method, progress);
}

}  // namespace cli
