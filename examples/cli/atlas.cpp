// billow atlas: several mesh files in, their billboard clouds with common textures out.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include <billow/io.hpp>
#include <billow/pipeline/shared_atlas.hpp>

#include "cloud_options.hpp"
#include "manifest.hpp"
#include "names.hpp"
#include "progress_line.hpp"
#include "shared.hpp"

namespace cli {
namespace {

using json = nlohmann::ordered_json;
using namespace billow;

struct atlas_arguments {
    std::vector<std::filesystem::path> inputs{};
    std::filesystem::path folder{};
    std::string mips = "none";
    unsigned threads = 0;
    bool is_quiet = false;

    /// FOLDER/NAME, which the names of all files start with; NAME is that of the folder.
    [[nodiscard]] std::filesystem::path stem() const {
        const auto whole = std::filesystem::absolute(folder).lexically_normal();
        const auto name = whole.has_filename() ? whole.filename() : whole.parent_path().filename();
        return folder / name;
    }
    [[nodiscard]] std::filesystem::path file(const char* ending) const {
        auto name = stem();
        return name += ending;
    }
};

/// The inputs' file names without their endings; equal ones are numbered.
std::vector<std::string> names_of(const std::vector<std::filesystem::path>& inputs) {
    std::vector<std::string> names;
    for (const auto& input : inputs) {
        const std::string name = input.stem().string();
        std::string unique = name;
        for (int i = 1; std::ranges::find(names, unique) != names.end(); ++i) {
            unique = name + "_" + std::to_string(i);
        }
        names.push_back(unique);
    }
    return names;
}

std::vector<glb_node> nodes_of(const std::vector<std::string>& names, const shared_atlas& shared) {
    std::vector<glb_node> nodes;
    for (std::size_t i = 0; i < names.size(); ++i) {
        glb_node node{names[i], {}};
        for (const face_range& range : {shared.members[i].billboards, shared.members[i].kept}) {
            const std::size_t before = node.faces.size();
            node.faces.resize(before + range.size());
            std::iota(node.faces.begin() + static_cast<std::ptrdiff_t>(before), node.faces.end(),
                      static_cast<face_id>(range.begin));
        }
        nodes.push_back(std::move(node));
    }
    return nodes;
}

std::string manifest_json(const atlas_arguments& arguments, const std::vector<std::string>& names,
                          const std::vector<build_result>& clouds, const shared_atlas& shared) {
    json manifest;
    manifest["schema"] = "billow-atlas/1";
    manifest["generator"] = "billow " BILLOW_VERSION;
    manifest["file"] = arguments.file(".glb").filename().string();
    json& told = manifest["atlases"] = json::array();
    for (const atlas& a : shared.baked.atlases) {
        json size;
        size["width"] = a.width();
        size["height"] = a.height();
        told.push_back(std::move(size));
    }
    manifest["fill"] = shared.baked.fill;
    manifest["texture_bytes"] = texture_bytes(shared.drawn);
    json& members = manifest["clouds"] = json::array();
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        const atlas_member& member = shared.members[i];
        json out;
        out["node"] = names[i];
        out["input"] = arguments.inputs[i].filename().string();
        out["planes"] = clouds[i].cloud.plane_count();
        out["triangles"] = member.billboards.size() + member.kept.size();
        out["kept_triangles"] = member.kept.size();
        out["epsilon"] = clouds[i].cloud.epsilon;
        out["max_error"] = clouds[i].errors.max_error;
        out["bounds"] = sphere_json(clouds[i].cloud.bounds);
        members.push_back(std::move(out));
    }
    return manifest.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

exit_code make_atlas(const atlas_arguments& arguments, const cloud_options& options) {
    stopwatch watch;
    const parallel threads{arguments.threads};
    if (std::filesystem::exists(arguments.folder)) {
        for (const char* ending : {".glb", ".json"}) {
            const auto writable = check_writable(arguments.file(ending));
            if (!writable) return fail(writable.error());
        }
    }
    progress_line progress(arguments.is_quiet);
    const std::vector<std::string> names = names_of(arguments.inputs);
    std::vector<build_result> clouds;
    bake_options textures;
    for (std::size_t i = 0; i < arguments.inputs.size(); ++i) {
        const std::string file = arguments.inputs[i].string();
        const auto tell = [&](std::string_view stage, double share) {
            progress(names[i] + ": " + std::string(stage), share);
        };
        tell("load", 0);
        const expected<loaded_mesh> loaded = read_mesh(arguments.inputs[i]);
        if (!loaded) return progress.clear(), fail(loaded.error());
        model_recipe how = options.recipe_for(loaded->mesh);
        how.whole.options.threads = threads;
        how.whole.options.packs_tiles = false;
        if (i == 0) textures = how.whole.options.bake;
        expected<build_result> built = make_cloud(loaded->mesh, how, tell);
        if (!built) {
            progress.clear();
            return fail({built.error().code, file + ": " + built.error().message});
        }
        clouds.push_back(std::move(*built));
    }

    progress("pack", 0);
    const shared_atlas shared = share_atlas(clouds, textures, threads);
    progress("write", 0);
    auto glb = encode_glb(shared.drawn, {.nodes = nodes_of(names, shared), .threads = threads});
    if (!glb) return progress.clear(), fail(glb.error());
    const std::string manifest = manifest_json(arguments, names, clouds, shared);
    std::error_code why;
    std::filesystem::create_directories(arguments.folder, why);
    if (why) {
        progress.clear();
        return fail({error_code::unwritable,
                     arguments.folder.string() + ": cannot be made: " + why.message()});
    }
    const auto written =
        write_together({{arguments.file(".glb"), std::move(*glb)},
                        {arguments.file(".json"), {manifest.begin(), manifest.end()}}});
    if (!written) return progress.clear(), fail(written.error());
    const mip_format format = kind_in(mip_names, arguments.mips);
    const auto mips =
        write_mips(arguments.stem(), shared.baked, format, {.padding = textures.padding}, threads);
    if (!mips) return progress.clear(), fail(mips.error());

    progress.clear();
    if (arguments.is_quiet) return success;
    for (std::size_t i = 0; i < clouds.size(); ++i) {
        std::printf("%s: %zu planes, %zu triangles\n", names[i].c_str(),
                    clouds[i].cloud.plane_count(),
                    shared.members[i].billboards.size() + shared.members[i].kept.size());
    }
    for (const atlas& a : shared.baked.atlases) {
        std::printf("atlas: %d x %d texels, %.0f %% filled\n", a.width(), a.height(),
                    100 * shared.baked.fill);
    }
    if (shared.baked.atlases.size() > 1) {
        std::printf("note: %zu atlases are as many draw calls; --atlases 1 makes texels coarser\n",
                    shared.baked.atlases.size());
    }
    if (!mips->names.empty()) {
        std::printf("mips: %zu files, %s to %s; %d levels keep tiles apart\n", mips->names.size(),
                    mips->names.front().string().c_str(), mips->names.back().string().c_str(),
                    mips->safe_levels);
    }
    std::printf("wrote %s in %.2f s\n", arguments.file(".glb").string().c_str(), watch.total());
    return success;
}

}  // namespace

void add_atlas(CLI::App& tool, exit_code& result) {
    auto arguments = std::make_shared<atlas_arguments>();
    atlas_arguments& a = *arguments;
    CLI::App* verb = tool.add_subcommand(
        "atlas", "Make billboard clouds of several mesh files that share their textures.");
    verb->footer(
        "FOLDER/NAME.glb has a node for each INPUT, all of one material where one atlas holds "
        "them; FOLDER/NAME.json tells of them. NAME is that of the folder.");
    verb->add_option("INPUT", a.inputs, "Meshes: .glb, .gltf or .obj")
        ->required()
        ->configurable(false);
    verb->add_option("-o,--output", a.folder, "Folder to write to; it is made where it is missing")
        ->required()
        ->configurable(false);
    const auto options = std::make_shared<cloud_options>(*verb);
    verb->add_option("--mips", a.mips, "Write mip levels beside the output: png or dds")
        ->check(CLI::IsMember(names_in(mip_names)))
        ->capture_default_str()
        ->group("Output");
    add_run_options(*verb, a.threads, a.is_quiet);
    verb->callback([arguments, options, &result] {
        options->check();
        result = make_atlas(*arguments, *options);
    });
}

}  // namespace cli
