// billow compare: how far clouds are from their original, and what they cost.

#include <algorithm>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <billow/io.hpp>
#include <billow/metrics/baselines.hpp>
#include <billow/metrics/compare.hpp>
#ifdef BILLOW_HAS_REDUCE
#include <billow/reduce.hpp>
#endif

#include "html_report.hpp"
#include "progress_line.hpp"
#include "screen_options.hpp"
#include "shared.hpp"

namespace cli {
namespace {

using namespace billow;
using json = nlohmann::ordered_json;

struct compare_arguments {
    std::filesystem::path original{};
    std::vector<std::filesystem::path> clouds{};
    std::filesystem::path report{};
    std::filesystem::path json{};
    std::string distance = "4R";
    compare_options options{};
    unsigned threads = 0;
    bool has_baselines = false;
    bool is_quiet = false;
};

/// Those of meshoptimizer, where the tool was built with it.
std::vector<mesh_reducer> known_reducers() {
#ifdef BILLOW_HAS_REDUCE
    return {{"simplify", [](const mesh& m, double share) { return reduce_mesh(m, share).mesh; }},
            {"simplifySloppy",
             [](const mesh& m, double share) { return reduce_mesh_sloppily(m, share).mesh; }}};
#else
    return {};
#endif
}

json json_of(const statistic& of, const comparison& in) {
    json told;
    told["mean"] = of.mean;
    told["p95"] = of.p95;
    told["worst"] = of.worst;
    told["worst_view"] = of.worst_view;
    const dvec3& from = in.cameras[of.worst_view].axes.normal;
    told["worst_direction"] = {from.x, from.y, from.z};
    return told;
}

json json_of(const draw_cost& cost) {
    json told;
    told["triangles"] = cost.triangles;
    told["texture_bytes"] = cost.textures.level_0;
    told["texture_bytes_with_mips"] = cost.textures.with_mips;
    return told;
}

json json_of(const geometric_errors& errors, std::size_t kept) {
    json told;
    told["mean"] = errors.mean;
    told["max"] = errors.max;
    told["mean_of_radius"] = errors.mean_of_radius;
    told["max_of_radius"] = errors.max_of_radius;
    told["mean_of_diameter"] = errors.mean_of_diameter;
    told["max_of_diameter"] = errors.max_of_diameter;
    told["mean_px"] = errors.mean_px;
    told["max_px"] = errors.max_px;
    told["undrawn_faces"] = errors.undrawn;
    told["kept_faces"] = kept;
    return told;
}

json json_of(const cloud_comparison& cloud, const comparison& in, const std::string& name) {
    json told;
    told["file"] = name;
    told["planes"] = cloud.planes.planes.plane_count();
    told["cost"] = json_of(cloud.cost);
    told["overdraw"] = json_of(cloud.overdraw, in);
    told["geometric"] =
        cloud.geometric ? json_of(*cloud.geometric, cloud.planes.kept) : json(nullptr);
    json& errors = told["errors"];
    for (const picture_metric& metric : all_picture_metrics) {
        json& one = errors[std::string(metric.name)];
        one = json_of(cloud.errors.*metric.over_views, in);
        one["unit"] = std::string(metric.unit);
    }
    json& views = told["views"] = json::array();
    for (std::size_t i = 0; i < cloud.views.size(); ++i) {
        json view;
        for (const picture_metric& metric : all_picture_metrics) {
            view[std::string(metric.name)] = cloud.views[i].*metric.of_view;
        }
        view["overdraw"] = cloud.view_overdraw[i];
        views.push_back(std::move(view));
    }
    return told;
}

/// Keys in a fixed order, no times, no folders.
std::string json_text(const std::vector<compared_file>& files, const comparison& found,
                      const compare_options& options) {
    json told;
    told["schema"] = "billow-compare/1";
    json& chosen = told["options"];
    chosen["views"] = options.views;
    chosen["size"] = options.size_px;
    chosen["distance_radii"] = options.distance;
    chosen["supersample"] = options.supersample;
    chosen["screen_height"] = options.screen.height_px;
    chosen["screen_fov"] = options.screen.fov_y;
    chosen["pixels_per_degree"] = found.pixels_per_degree;
    json& original = told["original"];
    original["file"] = files.front().name;
    original["radius"] = found.bounds.radius;
    original["centre"] = {found.bounds.centre.x, found.bounds.centre.y, found.bounds.centre.z};
    original["cost"] = json_of(found.original);
    original["overdraw"] = json_of(found.original_overdraw, found);
    json& directions = told["directions"] = json::array();
    for (const camera& c : found.cameras) {
        directions.push_back({c.axes.normal.x, c.axes.normal.y, c.axes.normal.z});
    }
    json& clouds = told["clouds"] = json::array();
    for (std::size_t i = 0; i < found.clouds.size(); ++i) {
        clouds.push_back(json_of(found.clouds[i], found, files[i + 1].name));
    }
    return told.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

void print_cloud(const cloud_comparison& cloud, const std::string& name) {
    std::printf("%s: %zu triangles", name.c_str(), cloud.cost.triangles);
    if (cloud.geometric) std::printf(", %zu planes", cloud.planes.planes.plane_count());
    std::printf(", %.3g MB of textures, overdraw %.2f\n",
                1e-6 * static_cast<double>(cloud.cost.textures.level_0), cloud.overdraw.mean);
    std::printf("  %-16s %9s %9s %9s  worst view\n", "", "mean", "95 %", "worst");
    for (const picture_metric& metric : all_picture_metrics) {
        const statistic& s = cloud.errors.*metric.over_views;
        std::printf("  %-16s %9.4f %9.4f %9.4f  %zu\n", std::string(metric.name).c_str(), s.mean,
                    s.p95, s.worst, s.worst_view);
    }
    if (!cloud.geometric) return;
    const geometric_errors& g = *cloud.geometric;
    std::printf(
        "  vertices are off by at least %.4g, at most one %.4g (%.3g and %.3g %% of the "
        "radius, %.3g and %.3g px)\n",
        g.mean, g.max, 100 * g.mean_of_radius, 100 * g.max_of_radius, g.mean_px, g.max_px);
    if (g.undrawn > 0) std::printf("  %zu faces are over no polygon\n", g.undrawn);
}

exit_code compare_files(compare_arguments& arguments) {
    const tolerance distance = parse_distance("--distance", arguments.distance);
    for (const auto* file : {&arguments.report, &arguments.json}) {
        if (file->empty()) continue;
        if (const auto writable = check_writable(*file); !writable) return fail(writable.error());
    }
    progress_line progress(arguments.is_quiet);
    progress("load", 0);
    std::deque<loaded_mesh> loaded;
    std::vector<compared_file> files;
    std::vector<const mesh*> clouds;
    const auto load = [&](const std::filesystem::path& file) -> expected<done> {
        auto read = read_mesh(file);
        if (!read) return read.error();
        loaded.push_back(std::move(*read));
        files.push_back({file.filename().string(), &loaded.back().mesh});
        return done{};
    };
    if (const auto read = load(arguments.original); !read) {
        return progress.clear(), fail(read.error());
    }
    for (std::size_t i = 0; i < arguments.clouds.size(); ++i) {
        progress("load",
                 static_cast<double>(i + 1) / static_cast<double>(arguments.clouds.size() + 1));
        if (const auto read = load(arguments.clouds[i]); !read) {
            return progress.clear(), fail(read.error());
        }
        clouds.push_back(files.back().drawn);
    }

    const parallel threads{arguments.threads};
    if (arguments.has_baselines && files[0].drawn->face_count() > 0 &&
        clouds[0]->face_count() > 0) {
        progress("baselines", 0);
        const baseline_options wanted{.triangles = clouds[0]->face_count(),
                                      .bytes = stored_bytes_of(*clouds[0]),
                                      .reducers = known_reducers()};
        for (baseline& made : make_baselines(*files[0].drawn, wanted, threads)) {
            loaded.emplace_back().mesh = std::move(made.mesh);
            files.push_back({made.name, &loaded.back().mesh});
            clouds.push_back(files.back().drawn);
        }
    }

    const double radius = bounding_sphere_of(*files.front().drawn).radius;
    const bool is_in_radii = distance.is_of_radius || !(radius > 0);
    arguments.options.distance = is_in_radii ? distance.value : distance.value / radius;
    if (const std::string fault = fault_of_eye(arguments.options.distance); !fault.empty()) {
        progress.clear();
        std::fprintf(stderr, "billow: --distance: %s is %s\n", arguments.distance.c_str(),
                     fault.c_str());
        return bad_usage;
    }
    const comparison found =
        compare(*files.front().drawn, clouds, arguments.options, threads, std::ref(progress));
    std::string page;
    if (!arguments.report.empty()) {
        page = html_report(files, found, arguments.options, threads, std::ref(progress));
    }
    for (const auto& [file, text] :
         {std::pair(&arguments.json, arguments.json.empty()
                                         ? std::string()
                                         : json_text(files, found, arguments.options)),
          std::pair(&arguments.report, std::move(page))}) {
        if (file->empty()) continue;
        if (const auto written = write_text(*file, text); !written) {
            return progress.clear(), fail(written.error());
        }
    }
    progress.clear();
    if (arguments.is_quiet) return success;
    for (const loaded_mesh& l : loaded) {
        for (const std::string& note : l.notes) std::printf("note: %s\n", note.c_str());
    }
    std::printf(
        "%s: %zu triangles, %.3g MB of textures, overdraw %.2f; %d views of %d x %d from "
        "%.4g radii\n",
        files.front().name.c_str(), found.original.triangles,
        1e-6 * static_cast<double>(found.original.textures.level_0), found.original_overdraw.mean,
        arguments.options.views, arguments.options.size_px, arguments.options.size_px,
        arguments.options.distance);
    for (std::size_t i = 0; i < found.clouds.size(); ++i) {
        print_cloud(found.clouds[i], files[i + 1].name);
    }
    return success;
}

/// Throws CLI::ValidationError where a file would be written over another.
void check_names(const compare_arguments& a) {
    const auto is_same = [](const std::filesystem::path& x, const std::filesystem::path& y) {
        std::error_code ignored;
        return x.lexically_normal() == y.lexically_normal() ||
               std::filesystem::equivalent(x, y, ignored);
    };
    for (const auto& [option, file] :
         {std::pair("--report", &a.report), std::pair("--json", &a.json)}) {
        if (file->empty()) continue;
        std::vector<std::filesystem::path> inputs = a.clouds;
        inputs.push_back(a.original);
        for (const auto& input : inputs) {
            if (is_same(*file, input)) throw CLI::ValidationError(option, "is one of the inputs");
        }
    }
    if (!a.report.empty() && is_same(a.report, a.json)) {
        throw CLI::ValidationError("--json", "is the file of --report");
    }
    const tolerance distance = parse_distance("--distance", a.distance);
    if (!distance.is_of_radius) return;
    if (const std::string fault = fault_of_eye(distance.value); !fault.empty()) {
        throw CLI::ValidationError("--distance", fault);
    }
}

}  // namespace

void add_compare(CLI::App& tool, exit_code& result) {
    auto arguments = std::make_shared<compare_arguments>();
    compare_arguments& a = *arguments;
    CLI::App* verb = tool.add_subcommand(
        "compare", "Measure how far billboard clouds are from their original, from all sides.");
    verb->add_option("ORIGINAL", a.original, "Mesh: .glb, .gltf or .obj")
        ->required()
        ->configurable(false);
    verb->add_option("CLOUD", a.clouds, "Clouds of it, or other stand-ins: .glb, .gltf or .obj")
        ->required()
        ->configurable(false);
    verb->add_option("--views", a.options.views, "Directions to look from, evenly spread")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    verb->add_option("--size", a.options.size_px,
                     "Side of the pictures, pixels; the original fills them")
        ->check(CLI::Range(16, 2048))
        ->capture_default_str();
    verb->add_option("--distance", a.distance,
                     "From the eye to the original's centre: 4R is four radii of its bounding "
                     "sphere, 12.5 a length in scene units")
        ->capture_default_str();
    verb->add_flag("--baselines", a.has_baselines,
                   "Compare, too, what one would take in the first cloud's place, at its triangles "
                   "and at its bytes: 1, 2, 3 and 8 textured quads, and the mesh reduced by "
                   "meshoptimizer, where the tool was built with it");
    verb->add_option("--report", a.report, "Write tables, pictures and plots as one page: .html")
        ->check([](const std::string& name) {
            return std::filesystem::path(name).extension() == ".html"
                       ? std::string()
                       : "'" + name + "' does not end in .html";
        })
        ->group("Output");
    verb->add_option("--json", a.json, "Write all numbers, those of each view too: .json")
        ->group("Output");
    add_run_options(*verb, a.threads, a.is_quiet);
    verb->callback([arguments, &result] {
        check_names(*arguments);
        result = compare_files(*arguments);
    });
}

}  // namespace cli
