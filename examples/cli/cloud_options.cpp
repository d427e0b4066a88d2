// The options of all verbs that make clouds, and what each changes.

#include "cloud_options.hpp"

#include "shared.hpp"

namespace cli {

using namespace billow;

cloud_options::cloud_options(CLI::App& verb) : verb_(verb) {
    add_plane_options();
    add_texture_options();
}

recipe cloud_options::make_recipe() const {
    recipe how;
    for (const auto& change : changes_) change(how);
    if (how.options.bake.max_atlas <= 2 * how.options.bake.padding + 4) {
        throw CLI::ValidationError("--padding", "leaves no room within --max-atlas");
    }
    return how;
}

void cloud_options::add_plane_options() {
    group_ = "Planes";
    add<std::string>("--epsilon", "10%",
                     "Largest distance of a vertex to its plane: P% of the bounding sphere's "
                     "radius, or a number in scene units",
                     [](recipe& how, const std::string& text) {
                         how.options.epsilon = parse_tolerance("--epsilon", text);
                     });
    add<std::size_t>("--max-planes", "0",
                     "Most planes, 0: as many as epsilon asks for; faces that are left go to the "
                     "plane of least error, beyond epsilon",
                     [](recipe& how, std::size_t most) { how.options.search.max_planes = most; });
    add<std::string>(
        "--plane-space", "cube", "How normals are sampled",
        [](recipe& how, const std::string& name) { how.is_spherical = name == "spherical"; })
        ->check(CLI::IsMember({"cube", "spherical"}));
    add<int>("--raster", "18",
             "Normals along a side of the cube, or a quarter of the equator; even",
             [](recipe& how, int raster) { how.raster = raster; })
        ->check(CLI::Range(2, 128))
        ->check([](const std::string& text) {
            return std::stoi(text) % 2 == 0 ? std::string() : "the raster must be even";
        });
    add<double>("--rho-rate", "1.5", "Offset bins an epsilon", [](recipe& how, double rate) {
        how.options.search.rho_rate = rate;
    })->check(CLI::Range(0.1, 16.0));
    add<double>("--penalty", "3",
                "Weight of faces that a plane just misses on its inner side; 0: none",
                [](recipe& how, double weight) { how.penalty = weight; })
        ->check(CLI::Range(0.0, 1000.0));
    static const std::map<std::string, refinement> refinements{{"original", refinement::original},
                                                               {"fail-safe", refinement::fail_safe},
                                                               {"none", refinement::none}};
    add<std::string>("--refine", "fail-safe",
                     "From the densest bin to a plane: 216 sub-bins, 64 sub-bins with a fail-safe, "
                     "or its centre",
                     [](recipe& how, const std::string& name) {
                         how.options.search.refine = refinements.at(name);
                     })
        ->check(CLI::IsMember({"original", "fail-safe", "none"}));
    add<std::string>("--fit", "least-squares",
                     "Move planes to their faces, where epsilon allows it",
                     [](recipe& how, const std::string& name) { how.fit = name; })
        ->check(CLI::IsMember({"none", "average", "svd", "least-squares", "minimax"}));
}

void cloud_options::add_texture_options() {
    group_ = "Textures";
    add<int>("--texels", "512", "Texels along the diameter of the bounding sphere",
             [](recipe& how, int texels) { how.options.bake.texels = texels; })
        ->check(CLI::Range(1, 65536));
    add<int>("--max-atlas", "4096", "Longest side of an atlas, texels", [](recipe& how, int side) {
        how.options.bake.max_atlas = side;
    })->check(CLI::Range(64, 16384));
    add<int>("--supersample", "4", "Samples along a texel's side", [](recipe& how, int samples) {
        how.options.bake.supersample = samples;
    })->check(CLI::Range(1, max_supersample));
    add<int>("--padding", "8", "Texels between tiles; 2^n keep n mip levels apart",
             [](recipe& how, int texels) { how.options.bake.padding = texels; })
        ->check(CLI::Range(0, 256));
    add_flag("--power-of-two", "Make the atlas' sides powers of two",
             [](recipe& how) { how.options.bake.power_of_two = true; });
}

}  // namespace cli
