// billow build: a mesh file in, a billboard cloud as one GLB out.

#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include <billow/io.hpp>

#include "cloud_options.hpp"
#include "names.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "shared.hpp"

namespace cli {
namespace {

using namespace billow;

struct build_arguments {
    std::filesystem::path input{};
    std::filesystem::path output{};
    std::filesystem::path report{};
    std::filesystem::path atlas_png{};
    std::filesystem::path horizon_png{};
    std::string mips = "none";
    unsigned threads = 0;
    bool is_quiet = false;
};

/// Gives the files of mip levels; the others are named by the arguments.
expected<mip_files> write_results(const build_arguments& arguments, const build_result& result,
                                  const mesh& drawn, int padding) {
    const parallel threads{arguments.threads};
    auto written = write_glb(arguments.output, drawn, {.threads = threads});
    if (!written) return written.error();
    for (std::size_t i = 0; i < result.baked.atlases.size(); ++i) {
        const atlas& from = result.baked.atlases[i];
        for (const auto& [file, picture] : {std::pair(&arguments.atlas_png, &from.base_color),
                                            std::pair(&arguments.horizon_png, &from.horizon)}) {
            if (file->empty()) continue;
            if (auto png = write_png(numbered(*file, i), *picture); !png) return png.error();
        }
    }
    const mip_format format = kind_in(mip_names, arguments.mips);
    auto stem = arguments.output;
    return write_mips(stem.replace_extension(), result.baked, format, {.padding = padding},
                      threads);
}

exit_code build(const build_arguments& arguments, const cloud_options& options) {
    stopwatch watch;
    for (const auto* file :
         {&arguments.output, &arguments.report, &arguments.atlas_png, &arguments.horizon_png}) {
        if (file->empty()) continue;
        if (const auto writable = check_writable(*file); !writable) return fail(writable.error());
    }
    progress_line progress(arguments.is_quiet);
    progress("load", 0);
    const expected<loaded_mesh> loaded = read_mesh(arguments.input);
    if (!loaded) return progress.clear(), fail(loaded.error());
    tool_times seconds{.load = watch.lap()};

    model_recipe how = options.recipe_for(loaded->mesh);
    how.whole.options.threads = {arguments.threads};
    bake_options& textures = how.whole.options.bake;
    if (!arguments.horizon_png.empty()) {
        textures.draw.with_horizon = true;
        if (textures.occlusion.rays == 0) textures.occlusion.rays = occlusion_options{}.rays;
    }
    const expected<build_result> result = make_cloud(loaded->mesh, how, std::ref(progress));
    if (!result) {
        progress.clear();
        return fail(
            {result.error().code, arguments.input.string() + ": " + result.error().message});
    }
    watch.lap();

    progress("write", 0);
    const mesh drawn = result->to_mesh();
    const auto mips = write_results(arguments, *result, drawn, textures.padding);
    if (!mips) return progress.clear(), fail(mips.error());
    seconds.write = watch.lap();
    seconds.total = watch.total();
    const finished_build finished{arguments.input, arguments.output,   how,    *loaded,
                                  *result,         drawn.face_count(), seconds};
    if (!arguments.report.empty()) {
        if (const auto written = write_text(arguments.report, report_json(finished)); !written) {
            return progress.clear(), fail(written.error());
        }
    }
    progress.clear();
    if (arguments.is_quiet) return success;
    print_summary(finished);
    if (!mips->names.empty()) {
        std::printf("mips: %zu files, %s to %s; %d levels keep tiles apart\n", mips->names.size(),
                    mips->names.front().string().c_str(), mips->names.back().string().c_str(),
                    mips->safe_levels);
    }
    return success;
}

}  // namespace

void add_build(CLI::App& tool, exit_code& result) {
    auto arguments = std::make_shared<build_arguments>();
    build_arguments& a = *arguments;
    CLI::App* verb = tool.add_subcommand("build", "Make a billboard cloud of a mesh file.");
    verb->footer(
        "billow --config FILE.toml build ... takes these options, by their long names, from "
        "the section [build].");

    verb->add_option("INPUT", a.input, "Mesh: .glb, .gltf or .obj")
        ->required()
        ->configurable(false);
    verb->add_option("-o,--output", a.output, "Billboard cloud: .glb")
        ->required()
        ->configurable(false)
        ->check([](const std::string& name) {
            return std::filesystem::path(name).extension() == ".glb"
                       ? std::string()
                       : "'" + name + "' does not end in .glb";
        });
    const auto options = std::make_shared<cloud_options>(*verb);
    options->add_distance_options();
    verb->add_option("--report", a.report, "Write what was found and measured: .json")
        ->group("Output");
    verb->add_option("--atlas-png", a.atlas_png,
                     "Write the atlas' colours: .png; further atlases get _1, _2, ...")
        ->group("Output");
    verb->add_option("--horizon-png", a.horizon_png,
                     "Write the horizon, a cone of visible sky a texel: .png; with the rays of "
                     "--occlusion, or 64")
        ->group("Output");
    verb->add_option("--mips", a.mips,
                     "Write mip levels that draw as much of every tile as the atlas does, beside "
                     "the output: NAME_basecolor.dds ..., or NAME_basecolor_mip0.png ...")
        ->check(CLI::IsMember(names_in(mip_names)))
        ->capture_default_str()
        ->group("Output");
    add_run_options(*verb, a.threads, a.is_quiet);

    verb->callback([arguments, options, &result] {
        options->check();
        std::error_code ignored;
        if (std::filesystem::equivalent(arguments->input, arguments->output, ignored)) {
            throw CLI::ValidationError("--output", "is the input itself");
        }
        result = build(*arguments, *options);
    });
}

}  // namespace cli
