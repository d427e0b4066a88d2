// billow build: a mesh file in, a billboard cloud as one GLB out.

#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

#include <billow/billow.hpp>
#include <billow/io.hpp>

#include "progress_line.hpp"
#include "verbs.hpp"

namespace cli {
namespace {

using json = nlohmann::ordered_json;
using namespace billow;

struct build_arguments {
    std::filesystem::path input{};
    std::filesystem::path output{};
    std::filesystem::path report{};
    std::filesystem::path atlas_png{};
    std::string epsilon = "10%";
    std::string plane_space = "cube";
    int raster = 18;
    double penalty = 3;
    std::string refine = "fail-safe";
    std::string fit = "least-squares";
    build_options options{};
    bool is_quiet = false;
};

/// Wall time since the last call of lap().
class stopwatch {
public:
    double lap() {
        const auto now = clock::now();
        const double seconds = std::chrono::duration<double>(now - last_).count();
        last_ = now;
        return seconds;
    }
    [[nodiscard]] double total() const {
        return std::chrono::duration<double>(clock::now() - start_).count();
    }

private:
    using clock = std::chrono::steady_clock;
    clock::time_point start_ = clock::now();
    clock::time_point last_ = start_;
};

/// "10%" is a share of the radius, "0.12" a length in scene units. Throws CLI::ValidationError.
tolerance parse_tolerance(const std::string& text) {
    const bool is_share = text.ends_with('%');
    const char* end = text.data() + text.size() - (is_share ? 1 : 0);
    double value = 0;
    const auto parsed = std::from_chars(text.data(), end, value);
    if (parsed.ec != std::errc{} || parsed.ptr != end || !(value > 0) || !std::isfinite(value)) {
        throw CLI::ValidationError("--epsilon", "'" + text +
                                                    "' is neither a percentage such as 10% nor a "
                                                    "length such as 0.12, greater than 0");
    }
    return is_share ? tolerance::of_radius(value / 100) : tolerance::scene_units(value);
}

const std::vector<std::pair<std::string, refinement>> refinements{
    {"original", refinement::original},
    {"fail-safe", refinement::fail_safe},
    {"none", refinement::none}};

/// The fitter that --fit names. Fitting is a small part of the work, so the choice is made when it is
/// called; the plane space is compiled in.
struct chosen_fit {
    std::variant<no_fit, average_fit, svd_fit, least_squares_fit, minimax_fit> fitter{};
    bool allows_less_contribution = false;

    explicit chosen_fit(const std::string& name) {
        if (name == "average") fitter = average_fit{};
        if (name == "svd") fitter = svd_fit{};
        if (name == "least-squares") fitter = least_squares_fit{};
        if (name == "minimax") fitter = minimax_fit{};
        allows_less_contribution =
            std::visit([](const auto& fit) { return fit.allows_less_contribution; }, fitter);
    }
    [[nodiscard]] plane operator()(const face_table& faces, const plane& start) const {
        return std::visit([&](const auto& fit) { return fit(faces, start); }, fitter);
    }
};
static_assert(plane_fitter<chosen_fit>);

/// Runs the pipeline that the options name.
expected<build_result> run_pipeline(const mesh& source, const build_arguments& arguments,
                                    progress_line& progress) {
    const auto run = [&](const auto& space) {
        const density_policies policies{hull_of_samples{}, projected_area{},
                                        inner_side_penalty{arguments.penalty}};
        return build_cloud(source, arguments.options,
                           pipeline{space, policies, chosen_fit(arguments.fit)},
                           std::ref(progress));
    };
    if (arguments.plane_space == "spherical") return run(spherical(arguments.raster));
    return run(cube_map(arguments.raster));
}

/// Filled field by field: one long initialiser list of JSON takes compilers minutes.
json report_of(const build_arguments& arguments, const loaded_mesh& loaded,
               const build_result& result, double load_seconds, double write_seconds,
               double total_seconds) {
    const cloud_errors& errors = result.errors;
    const greedy_statistics& search = result.statistics;
    const build_options& options = arguments.options;
    const double epsilon = result.cloud.epsilon;
    const std::size_t faces = loaded.mesh.face_count();

    json report;
    report["generator"] = "billow " BILLOW_VERSION;
    report["faces"] = faces;
    report["planes"] = result.cloud.plane_count();
    report["triangles"] = 2 * result.cloud.plane_count();
    report["epsilon"] = epsilon;
    report["radius"] = result.cloud.bounds.radius;
    report["max_error"] = errors.max_error;
    report["mean_error"] = errors.mean_error;
    report["max_error_over_epsilon"] = epsilon > 0 ? errors.max_error / epsilon : 0.0;
    report["projected_area_share"] = errors.projected_area_share;
    report["mapped_faces"] = errors.mapped_faces;
    report["skipped_faces"] = faces - errors.mapped_faces - search.degenerate_faces;
    report["degenerate_faces"] = search.degenerate_faces;
    report["leftover_faces"] = search.leftover_faces;
    report["faces_beyond_epsilon"] = errors.faces_beyond_epsilon;
    json& refinement = report["refinement"];
    refinement["levels"] = search.refinement_levels;
    refinement["fail_safes"] = search.fail_safes;
    refinement["tweaks"] = search.tweaks;

    const auto& atlases = result.baked.atlases;
    json& atlas = report["atlas"];
    atlas["width"] = atlases.empty() ? 0 : atlases.front().width();
    atlas["height"] = atlases.empty() ? 0 : atlases.front().height();
    atlas["fill"] = result.baked.fill;
    atlas["count"] = atlases.size();
    atlas["texel_size"] = result.baked.texel_size;

    json& seconds = report["seconds"];
    seconds["load"] = load_seconds;
    seconds["search"] = result.search_seconds;
    seconds["bake"] = result.bake_seconds;
    seconds["write"] = write_seconds;
    seconds["total"] = total_seconds;
    report["threads"] = options.threads.count();
    report["notes"] = loaded.notes;

    json& chosen = report["options"];
    chosen["epsilon"] = arguments.epsilon;
    chosen["max_planes"] = options.search.max_planes;
    chosen["plane_space"] = arguments.plane_space;
    chosen["raster"] = arguments.raster;
    chosen["rho_rate"] = options.search.rho_rate;
    chosen["penalty"] = arguments.penalty;
    chosen["refine"] = arguments.refine;
    chosen["fit"] = arguments.fit;
    chosen["texels"] = options.bake.texels;
    chosen["max_atlas"] = options.bake.max_atlas;
    chosen["supersample"] = options.bake.supersample;
    chosen["padding"] = options.bake.padding;
    chosen["power_of_two"] = options.bake.power_of_two;
    return report;
}

/// NAME.png, then NAME_1.png, NAME_2.png …
std::filesystem::path numbered(const std::filesystem::path& file, std::size_t number) {
    if (number == 0) return file;
    auto name = file;
    name.replace_filename(file.stem().string() + "_" + std::to_string(number) +
                          file.extension().string());
    return name;
}

expected<done> write_results(const build_arguments& arguments, const build_result& result) {
    auto written =
        write_glb(arguments.output, result.to_mesh(), {.threads = arguments.options.threads});
    if (!written || arguments.atlas_png.empty()) return written;
    for (std::size_t i = 0; i < result.baked.atlases.size(); ++i) {
        auto png = write_png(numbered(arguments.atlas_png, i), result.baked.atlases[i].base_color);
        if (!png) return png;
    }
    return done{};
}

void print_summary(const build_arguments& arguments, const loaded_mesh& loaded,
                   const build_result& result, double seconds) {
    const double epsilon = result.cloud.epsilon;
    std::printf("%s: %zu faces -> %zu planes, %zu triangles\n", arguments.input.string().c_str(),
                loaded.mesh.face_count(), result.cloud.plane_count(),
                2 * result.cloud.plane_count());
    std::printf("error: largest %.4g (%.3f epsilon), mean %.4g; epsilon %.4g, radius %.4g\n",
                result.errors.max_error, epsilon > 0 ? result.errors.max_error / epsilon : 0.0,
                result.errors.mean_error, epsilon, result.cloud.bounds.radius);
    for (const atlas& a : result.baked.atlases) {
        std::printf("atlas: %d x %d texels of %.4g, %.0f %% filled\n", a.width(), a.height(),
                    result.baked.texel_size, 100 * result.baked.fill);
    }
    if (result.errors.faces_beyond_epsilon > 0) {
        std::printf("note: --max-planes leaves %zu faces beyond epsilon\n",
                    result.errors.faces_beyond_epsilon);
    }
    const double wished = 2 * result.cloud.bounds.radius / arguments.options.bake.texels;
    if (result.baked.texel_size > 1.001 * wished) {
        std::printf("note: texels are %.2f times larger than asked for, to fit --max-atlas\n",
                    result.baked.texel_size / wished);
    }
    std::printf("wrote %s in %.2f s\n", arguments.output.string().c_str(), seconds);
}

exit_code fail(const error& why) {
    std::fprintf(stderr, "billow: %s\n", why.message.c_str());
    return bad_input;
}

exit_code build(const build_arguments& arguments) {
    stopwatch watch;
    for (const auto* file : {&arguments.output, &arguments.report, &arguments.atlas_png}) {
        if (file->empty()) continue;
        if (const auto writable = check_writable(*file); !writable) return fail(writable.error());
    }
    progress_line progress(arguments.is_quiet);
    progress("load", 0);
    const expected<loaded_mesh> loaded = read_mesh(arguments.input);
    if (!loaded) return progress.clear(), fail(loaded.error());
    const double load_seconds = watch.lap();

    const expected<build_result> result = run_pipeline(loaded->mesh, arguments, progress);
    if (!result) {
        progress.clear();
        return fail(
            {result.error().code, arguments.input.string() + ": " + result.error().message});
    }
    watch.lap();

    progress("write", 0);
    if (const auto written = write_results(arguments, *result); !written) {
        return progress.clear(), fail(written.error());
    }
    const double write_seconds = watch.lap();
    if (!arguments.report.empty()) {
        const std::string text =
            report_of(arguments, *loaded, *result, load_seconds, write_seconds, watch.total())
                .dump(2, ' ', false, json::error_handler_t::replace) +
            "\n";
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
        if (const auto written = write_file(arguments.report, {bytes, text.size()}); !written) {
            return progress.clear(), fail(written.error());
        }
    }
    progress.clear();
    if (!arguments.is_quiet) {
        for (const std::string& note : loaded->notes) std::printf("note: %s\n", note.c_str());
        print_summary(arguments, *loaded, *result, watch.total());
    }
    return success;
}

}  // namespace

void add_build(CLI::App& tool, exit_code& result) {
    auto arguments = std::make_shared<build_arguments>();
    build_arguments& a = *arguments;
    CLI::App* verb = tool.add_subcommand("build", "Make a billboard cloud of a mesh file.");
    verb->option_defaults()->always_capture_default();
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

    verb->add_option("--epsilon", a.epsilon,
                     "Largest distance of a vertex to its plane: P% of the bounding sphere's "
                     "radius, or a number in scene units")
        ->group("Planes");
    verb->add_option("--max-planes", a.options.search.max_planes,
                     "Most planes, 0: as many as epsilon asks for; faces that are left go to the "
                     "plane of least error, beyond epsilon")
        ->group("Planes");
    verb->add_option("--plane-space", a.plane_space, "How normals are sampled")
        ->check(CLI::IsMember({"cube", "spherical"}))
        ->group("Planes");
    verb->add_option("--raster", a.raster,
                     "Normals along a side of the cube, or a quarter of the equator; even")
        ->check(CLI::Range(2, 128))
        ->check([](const std::string& text) {
            return std::stoi(text) % 2 == 0 ? std::string() : "the raster must be even";
        })
        ->group("Planes");
    verb->add_option("--rho-rate", a.options.search.rho_rate, "Offset bins an epsilon")
        ->check(CLI::Range(0.1, 16.0))
        ->group("Planes");
    verb->add_option("--penalty", a.penalty,
                     "Weight of faces that a plane just misses on its inner side; 0: none")
        ->check(CLI::Range(0.0, 1000.0))
        ->group("Planes");
    verb->add_option("--refine", a.refine,
                     "From the densest bin to a plane: 216 sub-bins, 64 sub-bins with a fail-safe, "
                     "or its centre")
        ->check(CLI::IsMember({"original", "fail-safe", "none"}))
        ->group("Planes");
    verb->add_option("--fit", a.fit, "Move planes to their faces, where epsilon allows it")
        ->check(CLI::IsMember({"none", "average", "svd", "least-squares", "minimax"}))
        ->group("Planes");

    verb->add_option("--texels", a.options.bake.texels,
                     "Texels along the diameter of the bounding sphere")
        ->check(CLI::Range(1, 65536))
        ->group("Textures");
    verb->add_option("--max-atlas", a.options.bake.max_atlas, "Longest side of an atlas, texels")
        ->check(CLI::Range(64, 16384))
        ->group("Textures");
    verb->add_option("--supersample", a.options.bake.supersample, "Samples along a texel's side")
        ->check(CLI::Range(1, max_supersample))
        ->group("Textures");
    verb->add_option("--padding", a.options.bake.padding,
                     "Texels between tiles; 2^n keep n mip levels apart")
        ->check(CLI::Range(0, 256))
        ->group("Textures");
    verb->add_flag("--power-of-two", a.options.bake.power_of_two,
                   "Make the atlas' sides powers of two")
        ->group("Textures");

    verb->add_option("--report", a.report, "Write what was found and measured: .json")
        ->group("Output");
    verb->add_option("--atlas-png", a.atlas_png,
                     "Write the atlas' colours: .png; further atlases get _1, _2, ...")
        ->group("Output");
    verb->add_option("--threads", a.options.threads.threads,
                     "Threads, 0: all; the cloud is the same for any number")
        ->check(CLI::Range(0, 1024))
        ->group("Output");
    verb->add_flag("--quiet", a.is_quiet, "Say nothing but errors")->group("Output");

    verb->callback([arguments, &result] {
        build_arguments& chosen = *arguments;
        chosen.options.epsilon = parse_tolerance(chosen.epsilon);
        for (const auto& [name, kind] : refinements) {
            if (name == chosen.refine) chosen.options.search.refine = kind;
        }
        if (chosen.options.bake.max_atlas <= 2 * chosen.options.bake.padding + 4) {
            throw CLI::ValidationError("--padding", "leaves no room within --max-atlas");
        }
        std::error_code ignored;
        if (std::filesystem::equivalent(chosen.input, chosen.output, ignored)) {
            throw CLI::ValidationError("--output", "is the input itself");
        }
        result = build(chosen);
    });
}

}  // namespace cli
