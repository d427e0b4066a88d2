// billow lod: a mesh file in, a chain of billboard clouds and a manifest of them out.

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include <billow/io.hpp>
#include <billow/lod/chain.hpp>
#include <billow/lod/switch_distance.hpp>

#include "cloud_options.hpp"
#include "manifest.hpp"
#include "progress_line.hpp"
#include "screen_options.hpp"
#include "shared.hpp"

namespace cli {
namespace {

using json = nlohmann::ordered_json;
using namespace billow;

struct lod_arguments {
    std::filesystem::path input{};
    std::filesystem::path output{};  ///< what the names of all files start with
    lod_options chain{};
    std::string mode = "incremental";
    std::string texel_share = "50%";
    screen_options seen{};
    unsigned threads = 0;
    bool is_quiet = false;

    [[nodiscard]] std::filesystem::path level_file(std::size_t level) const {
        auto name = output;
        return name += "_LOD" + std::to_string(level) + ".glb";
    }
    [[nodiscard]] std::filesystem::path manifest() const {
        auto name = output;
        return name += ".json";
    }
};

json displacement_json(const displacement& moved) {
    json out;
    out["max"] = moved.max;
    out["mean"] = moved.mean;
    return out;
}

/// When a level may be drawn, by one of its errors.
json switch_json(const lod_arguments& arguments, double distance, double radius) {
    const lod_screen screen = arguments.seen.screen();
    json out;
    out["distance"] = distance;
    // What may be drawn at any distance may fill the screen.
    out["screen_height"] = std::min(1.0, relative_screen_height(2 * radius, distance, screen));
    out["screen_coverage"] = screen_coverage(radius, distance, screen);
    return out;
}

json level_json(const lod_level& level, const output_file& file) {
    const billboard_cloud& cloud = level.built.cloud;
    const mesh drawn = level.built.to_mesh();
    json out;
    out["file"] = file.name.filename().string();
    out["made_of"] = level.made_of == lod_source::mesh ? "mesh" : "level above";
    out["most_planes"] = level.most_planes;
    out["planes"] = cloud.plane_count();
    out["triangles"] = drawn.face_count();
    out["bytes"] = file.bytes.size();
    out["texture_bytes"] = texture_bytes(drawn);
    out["texel_size"] = level.built.baked.texel_size;
    out["epsilon"] = cloud.epsilon;
    out["leftover_faces"] = level.built.statistics.leftover_faces;
    json& error = out["error"] = displacement_json(level.error);
    error["bound"] = level.error_bound;
    out["jump"] = displacement_json(level.jump);
    out["bounds"] = sphere_json(bounding_sphere_of(
        drawn.vertex_count(), [&](std::size_t i) { return drawn.positions[i]; }));
    return out;
}

std::vector<double> distances_of(const lod_arguments& arguments, const lod_chain& chain,
                                 double displacement::*error) {
    std::vector<double> errors;
    for (const lod_level& level : chain.levels) errors.push_back(level.error.*error);
    return switch_distances(errors, chain.bounds.radius, arguments.seen.pixel_error,
                            arguments.seen.screen());
}

std::string manifest_json(const lod_arguments& arguments, const loaded_mesh& loaded,
                          const lod_chain& chain, const std::vector<output_file>& files) {
    json manifest;
    manifest["schema"] = "billow-lod/1";
    manifest["generator"] = "billow " BILLOW_VERSION;
    json& input = manifest["input"];
    input["file"] = arguments.input.filename().string();
    input["triangles"] = loaded.mesh.face_count();
    input["bounds"] = sphere_json(chain.bounds);
    json& chosen = manifest["options"];
    chosen["mode"] = arguments.mode;
    chosen["least_incremental"] = arguments.chain.least_incremental;
    chosen["pixel_error"] = arguments.seen.pixel_error;
    chosen["screen"] = arguments.seen.height_px;
    chosen["fov"] = arguments.seen.fov_degrees;
    chosen["texels"] = arguments.chain.build.bake.texels;
    chosen["texel_share"] = arguments.chain.texel_share;
    json& levels = manifest["levels"] = json::array();
    const double radius = chain.bounds.radius;
    const auto by_max = distances_of(arguments, chain, &displacement::max);
    const auto by_mean = distances_of(arguments, chain, &displacement::mean);
    for (std::size_t i = 0; i < chain.levels.size(); ++i) {
        json level = level_json(chain.levels[i], files[i]);
        json& switches = level["switch"];
        switches["by_max"] = switch_json(arguments, by_max[i], radius);
        switches["by_mean"] = switch_json(arguments, by_mean[i], radius);
        level["sharp_distance"] = distance_for_pixels(chain.levels[i].built.baked.texel_size,
                                                      radius, 1, arguments.seen.screen());
        levels.push_back(std::move(level));
    }
    return manifest.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

void print_summary(const lod_arguments& arguments, const loaded_mesh& loaded,
                   const lod_chain& chain, const std::vector<output_file>& files, double seconds) {
    for (const std::string& note : loaded.notes) std::printf("note: %s\n", note.c_str());
    std::printf("%s: %zu faces -> %zu levels\n", arguments.input.string().c_str(),
                loaded.mesh.face_count(), chain.levels.size());
    const auto distances = distances_of(arguments, chain, &displacement::max);
    for (std::size_t i = 0; i < chain.levels.size(); ++i) {
        const lod_level& level = chain.levels[i];
        std::printf("%s: %zu planes of the %s, %zu bytes; error %.4g, bound %.4g; from %.4g on\n",
                    files[i].name.string().c_str(), level.built.cloud.plane_count(),
                    level.made_of == lod_source::mesh ? "mesh" : "level above",
                    files[i].bytes.size(), level.error.max, level.error_bound, distances[i]);
    }
    std::printf("wrote %s in %.2f s\n", arguments.manifest().string().c_str(), seconds);
}

exit_code lod(lod_arguments& arguments, const cloud_options& options) {
    stopwatch watch;
    for (std::size_t i = 0; i < arguments.chain.levels.size(); ++i) {
        const auto writable = check_writable(arguments.level_file(i));
        if (!writable) return fail(writable.error());
    }
    if (const auto writable = check_writable(arguments.manifest()); !writable) {
        return fail(writable.error());
    }
    progress_line progress(arguments.is_quiet);
    progress("load", 0);
    const expected<loaded_mesh> loaded = read_mesh(arguments.input);
    if (!loaded) return progress.clear(), fail(loaded.error());

    recipe how = options.recipe_for_whole(loaded->mesh);
    how.options.threads = {arguments.threads};
    arguments.chain.build = how.options;
    const auto chain = make_chain(loaded->mesh, how, arguments.chain, std::ref(progress));
    if (!chain) {
        progress.clear();
        return fail({chain.error().code, arguments.input.string() + ": " + chain.error().message});
    }

    progress("write", 0);
    std::vector<output_file> files;
    for (std::size_t i = 0; i < chain->levels.size(); ++i) {
        auto bytes = encode_glb(chain->levels[i].built.to_mesh(), {.threads = {arguments.threads}});
        if (!bytes) return progress.clear(), fail(bytes.error());
        files.push_back({arguments.level_file(i), std::move(*bytes)});
    }
    const std::string manifest = manifest_json(arguments, *loaded, *chain, files);
    files.push_back({arguments.manifest(), {manifest.begin(), manifest.end()}});
    if (const auto written = write_together(files); !written) {
        return progress.clear(), fail(written.error());
    }
    progress.clear();
    if (!arguments.is_quiet) print_summary(arguments, *loaded, *chain, files, watch.total());
    return success;
}

constexpr std::array decided_by_levels{"--epsilon", "--planes", "--max-planes"};
constexpr std::array of_parts{"--split",      "--trunk",           "--trunk-epsilon",
                              "--trunk-weld", "--trunk-cardboard", "--trunk-contribution",
                              "--trunk-alpha"};

void check(const CLI::App& verb, const lod_arguments& arguments) {
    for (const char* option : decided_by_levels) {
        if (verb.count(option) > 0) {
            throw CLI::ValidationError(option, "follows from --levels");
        }
    }
    for (const char* option : of_parts) {
        if (verb.count(option) > 0) {
            throw CLI::ValidationError(option, "is not for levels: they are not split");
        }
    }
    const std::vector<std::size_t>& levels = arguments.chain.levels;
    if (!std::ranges::is_sorted(levels, std::greater_equal{})) {
        throw CLI::ValidationError("--levels", "each must have fewer planes than the one before");
    }
    if (arguments.output.filename().empty()) {
        throw CLI::ValidationError("--output", "is not what a file's name may start with");
    }
    if (arguments.output.extension() == ".glb" || arguments.output.extension() == ".json") {
        throw CLI::ValidationError(
            "--output", "is what the names start with: NAME gives NAME_LOD0.glb and NAME.json");
    }
    std::error_code ignored;
    for (std::size_t i = 0; i < levels.size(); ++i) {
        if (std::filesystem::equivalent(arguments.input, arguments.level_file(i), ignored)) {
            throw CLI::ValidationError("--output", "would replace the input");
        }
    }
}

}  // namespace

void add_lod(CLI::App& tool, exit_code& result) {
    auto arguments = std::make_shared<lod_arguments>();
    lod_arguments& a = *arguments;
    CLI::App* verb = tool.add_subcommand(
        "lod", "Make levels of detail of a mesh file: clouds of fewer and fewer planes.");
    verb->footer(
        "Writes NAME_LOD0.glb, NAME_LOD1.glb ... and NAME.json, which tells of each level its "
        "planes, error and switch distance.");

    verb->add_option("INPUT", a.input, "Mesh: .glb, .gltf or .obj")
        ->required()
        ->configurable(false);
    verb->add_option("-o,--output", a.output, "NAME that all files start with")
        ->required()
        ->configurable(false);
    const auto group = [&](CLI::Option* option, const char* name) {
        return option->capture_default_str()->group(name);
    };
    group(verb->add_option("--levels", a.chain.levels, "Most planes of each level, descending"),
          "Levels")
        ->delimiter(',')
        ->check(CLI::Range(1, 10000));
    group(verb->add_option("--mode", a.mode,
                           "What a level is made of: the billboards of the level above, so that "
                           "switches show less, or the mesh"),
          "Levels")
        ->check(CLI::IsMember({"incremental", "independent"}));
    group(verb->add_option("--least-incremental", a.chain.least_incremental,
                           "Levels of fewer planes are made of the mesh in any mode"),
          "Levels");
    group(verb->add_option("--texel-share", a.texel_share,
                           "Texels along the diameter, of those of the level above"),
          "Levels");
    add_screen_options(*verb, a.seen, "Switch distances",
                       "Pixels that a level may be off at its switch distance");
    const auto options = std::make_shared<cloud_options>(*verb);
    for (const char* option : decided_by_levels) verb->get_option(option)->group("");
    for (const char* option : of_parts) verb->get_option(option)->group("");
    add_run_options(*verb, a.threads, a.is_quiet);

    verb->callback([verb, arguments, options, &result] {
        lod_arguments& chosen = *arguments;
        check(*verb, chosen);
        options->check();
        chosen.chain.made_of =
            chosen.mode == "incremental" ? lod_source::level_above : lod_source::mesh;
        chosen.chain.texel_share = parse_share("--texel-share", chosen.texel_share);
        if (!(chosen.chain.texel_share > 0)) {
            throw CLI::ValidationError("--texel-share", "must be above 0");
        }
        result = lod(chosen, *options);
    });
}

}  // namespace cli
