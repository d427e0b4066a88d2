// billow sweep: what clouds of many options cost, and how far they are from their original.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <billow/io.hpp>
#include <billow/metrics/compare.hpp>

#include "cloud_options.hpp"
#include "manifest.hpp"
#include "progress_line.hpp"
#include "shared.hpp"
#include "sweep_files.hpp"

namespace cli {
namespace {

using namespace billow;
using sweep_json = nlohmann::ordered_json;

/// What is swept when neither epsilon nor planes are given.
constexpr const char* usual_epsilons = "2%:20%:8";

/// All that numbers depend on, as the options stand, but for the input.
sweep_json sweep_key(const sweep_plan& plan, const sweep_arguments& arguments) {
    sweep_json key;
    key["version"] = BILLOW_VERSION;
    sweep_json& options = key["options"] = sweep_json::object();
    for (const CLI::Option* option : plan.of_cloud) {
        if (option->count() > 0) options[column_of(*option)] = option->results();
    }
    sweep_json& look = key["look"];
    look["views"] = arguments.look.views;
    look["size"] = arguments.look.size_px;
    look["distance_radii"] = arguments.look.distance;
    look["screen"] = arguments.seen.height_px;
    look["fov"] = arguments.seen.fov_degrees;
    return key;
}

sweep_json sweep_numbers(const mesh& source, const build_result& built, const mesh& drawn,
                         const comparison& found, const compare_options& look) {
    const cloud_comparison& cloud = found.clouds.front();
    const double radius = built.cloud.bounds.radius;
    const geometric_errors geometric =
        geometric_error(source, built.cloud, built.moved, {look.distance * radius, look.screen});
    sweep_json numbers;
    numbers["planes"] = built.cloud.plane_count();
    numbers["triangles"] = drawn.face_count();
    numbers["texture_bytes"] = cloud.cost.textures.level_0;
    numbers["texture_bytes_with_mips"] = cloud.cost.textures.with_mips;
    numbers["epsilon_length"] = built.cloud.epsilon;
    numbers["texel_size"] = built.baked.texel_size;
    numbers["geometric_mean"] = geometric.mean;
    numbers["geometric_max"] = geometric.max;
    numbers["geometric_mean_of_radius"] = geometric.mean_of_radius;
    numbers["geometric_max_of_radius"] = geometric.max_of_radius;
    numbers["undrawn_faces"] = geometric.undrawn - built.faces.kept;
    const auto add = [&](const std::string& name, const statistic& of) {
        numbers[name + "_mean"] = of.mean;
        numbers[name + "_p95"] = of.p95;
        numbers[name + "_worst"] = of.worst;
    };
    add("overdraw", cloud.overdraw);
    for (const picture_metric& metric : all_picture_metrics) {
        add(std::string(metric.name), cloud.errors.*metric.over_views);
    }
    return numbers;
}

/// Tells how far configuration `at` of `count` is: most time goes to these three.
class sweep_progress {
public:
    sweep_progress(progress_line& line, std::size_t at, std::size_t count)
        : line_(line), stage_(std::to_string(at + 1) + " of " + std::to_string(count)) {
        line_(stage_, 0);
    }
    void operator()(std::string_view stage, double share) {
        if (stage == "search") line_(stage_, 0.5 * share);
        if (stage == "bake") line_(stage_, 0.5 + 0.2 * share);
        if (stage == "compare") line_(stage_, 0.7 + 0.3 * share);
    }

private:
    progress_line& line_;
    std::string stage_;
};

expected<sweep_row> measure_configuration(const mesh& source, model_recipe how,
                                          const sweep_arguments& arguments, sweep_json key,
                                          sweep_progress progress) {
    stopwatch watch;
    const parallel threads{arguments.threads};
    how.whole.options.threads = threads;
    const auto built = make_cloud(source, how, std::ref(progress));
    if (!built) return built.error();
    const mesh drawn = built->to_mesh();
    const comparison found = compare(source, drawn, arguments.look, threads, std::ref(progress));
    sweep_row row{std::move(key), sweep_numbers(source, *built, drawn, found, arguments.look), {}};
    row.seconds["search"] = built->search_seconds;
    row.seconds["bake"] = built->bake_seconds;
    row.seconds["all"] = watch.total();
    return row;
}

void print_row(const sweep_row& row, const std::string& label, double distance) {
    const auto number = [&](const char* name) { return row.numbers.at(name).get<double>(); };
    std::printf(
        "%s: %.0f planes, coverage off by %.3g %%, vertices by %.3g %% of the radius; from "
        "%.4g on\n",
        label.empty() ? "cloud" : label.c_str(), number("planes"), 100 * number("coverage_mean"),
        100 * number("geometric_max_of_radius"), distance);
    std::fflush(stdout);
}

exit_code sweep(sweep_arguments& arguments, const sweep_plan& plan, const cloud_options& options) {
    stopwatch watch;
    constexpr std::array endings{".csv", ".json", ".svg", ".jsonl"};
    for (const char* ending : endings) {
        const auto writable = check_writable(arguments.file(ending));
        if (!writable) return fail(writable.error());
    }
    progress_line progress(arguments.is_quiet);
    progress("load", 0);
    const auto bytes = read_file(arguments.input);
    if (!bytes) return progress.clear(), fail(bytes.error());
    auto state = sweep_state::open(arguments.file(".jsonl"), *bytes);
    if (!state) return progress.clear(), fail(state.error());
    const expected<loaded_mesh> loaded = read_mesh(arguments.input);
    if (!loaded) return progress.clear(), fail(loaded.error());

    finished_sweep finished{arguments, plan, loaded->mesh, bounding_sphere_of(loaded->mesh)};
    const double radius = finished.bounds.radius;
    const tolerance distance = parse_distance("--distance", arguments.distance);
    const double radii =
        distance.is_of_radius || !(radius > 0) ? distance.value : distance.value / radius;
    if (const std::string fault = fault_of_eye(radii); !fault.empty()) {
        progress.clear();
        std::fprintf(stderr, "billow: --distance: %s is %s\n", arguments.distance.c_str(),
                     fault.c_str());
        return bad_usage;
    }
    arguments.look.distance = radii;
    arguments.look.screen = arguments.seen.screen();

    std::size_t known = 0;
    const std::size_t count = plan.count();
    for (std::size_t i = 0; i < count; ++i) {
        plan.set(i);
        sweep_json key = sweep_key(plan, arguments);
        const sweep_row* before = state->find(key);
        if (before != nullptr) {
            ++known;
            finished.rows.push_back(*before);
        } else {
            auto row = measure_configuration(loaded->mesh, options.recipe_for(loaded->mesh),
                                             arguments, std::move(key), {progress, i, count});
            progress.clear();
            if (!row) {
                return fail({row.error().code, arguments.input.string() + ": " + plan.label(i) +
                                                   ": " + row.error().message});
            }
            if (const auto kept = state->add(*row); !kept) return fail(kept.error());
            finished.rows.push_back(std::move(*row));
        }
        if (arguments.is_quiet) continue;
        const sweep_row& row = finished.rows.back();
        print_row(row, plan.label(i), row_distance(row, "geometric_max", radius, arguments.seen));
    }

    const std::string csv = sweep_csv(finished);
    const std::string report = sweep_report(finished);
    const std::string drawing = sweep_drawing(finished);
    const auto written =
        write_together({{arguments.file(".csv"), {csv.begin(), csv.end()}},
                        {arguments.file(".json"), {report.begin(), report.end()}},
                        {arguments.file(".svg"), {drawing.begin(), drawing.end()}}});
    if (!written) return progress.clear(), fail(written.error());
    progress.clear();
    if (arguments.is_quiet) return success;
    for (const std::string& note : loaded->notes) std::printf("note: %s\n", note.c_str());
    std::printf("%zu configurations, %zu of them known from %s\n", count, known,
                arguments.file(".jsonl").string().c_str());
    std::printf("wrote %s, %s and %s in %.2f s\n", arguments.file(".csv").string().c_str(),
                arguments.file(".json").string().c_str(), arguments.file(".svg").string().c_str(),
                watch.total());
    return success;
}

/// Throws CLI::ValidationError where an option refuses one of its values, or options contradict.
void check_sweep(const sweep_arguments& arguments, const sweep_plan& plan,
                 const cloud_options& options) {
    if (arguments.output.filename().empty()) {
        throw CLI::ValidationError("--output", "is not what a file's name may start with");
    }
    for (const char* ending : {".csv", ".json", ".svg", ".jsonl"}) {
        if (arguments.output.extension() == ending) {
            throw CLI::ValidationError(
                "--output", "is what the names start with: NAME gives NAME.csv, NAME.json ...");
        }
    }
    static_cast<void>(parse_distance("--distance", arguments.distance));
    if (plan.count() > most_configurations) {
        throw CLI::ValidationError("sweep", "more than " + std::to_string(most_configurations) +
                                                " configurations are too many");
    }
    for (std::size_t i = 0; i < plan.count(); ++i) {
        plan.set(i);
        options.check();
    }
}

}  // namespace

void add_sweep(CLI::App& tool, exit_code& result) {
    auto arguments = std::make_shared<sweep_arguments>();
    sweep_arguments& a = *arguments;
    CLI::App* verb = tool.add_subcommand(
        "sweep", "Build clouds of many options, measure them all, and draw the curves.");
    std::string swept;
    for (const axis_kind& kind : axis_kinds) swept += std::string(" ") + kind.option;
    verb->footer("Several values: a list, 64,128,256, or a range FROM:TO:COUNT, 2%:20%:10, for" +
                 swept +
                 ". All combinations are built. Ranges of epsilon, planes and texels have equal "
                 "ratios, those of raster and penalty equal differences; what is a name has lists "
                 "only. Without --epsilon and --planes epsilon is " +
                 usual_epsilons +
                 ".\n"
                 "Writes NAME.csv, NAME.json, NAME.svg, and NAME.jsonl while it runs: called "
                 "again, it goes on where it was stopped.");
    verb->add_option("INPUT", a.input, "Mesh: .glb, .gltf or .obj")
        ->required()
        ->configurable(false);
    verb->add_option("-o,--output", a.output, "NAME that all files start with")
        ->required()
        ->configurable(false);
    const std::size_t others = verb->get_options().size();
    const auto options = std::make_shared<cloud_options>(*verb);
    auto plan = std::make_shared<sweep_plan>();
    const auto all = verb->get_options();
    plan->of_cloud.assign(all.begin() + static_cast<std::ptrdiff_t>(others), all.end());
    for (std::size_t i = 0; i < axis_kinds.size(); ++i) {
        verb->get_option(axis_kinds[i].option)->transform([i, &a](const std::string& text) {
            a.given[i] = values_of(axis_kinds[i], text);
            return a.given[i].front();  // the option's own checks are next
        });
    }
    const auto group = [&](CLI::Option* option) {
        return option->capture_default_str()->group("Measurements");
    };
    group(verb->add_option("--views", a.look.views, "Directions to look from, evenly spread"))
        ->check(CLI::Range(1, 1000));
    group(verb->add_option("--size", a.look.size_px,
                           "Side of the pictures, pixels; the original fills them"))
        ->check(CLI::Range(16, 2048));
    group(verb->add_option("--distance", a.distance,
                           "From the eye to the original's centre: 4R is four radii of its "
                           "bounding sphere, 40 or 40m a length in scene units"));
    add_screen_options(*verb, a.seen, "Measurements",
                       "Pixels that a vertex may be off at the distances that are told");
    add_run_options(*verb, a.threads, a.is_quiet);

    verb->callback([verb, arguments, options, plan, &result] {
        const bool is_usual = verb->count("--epsilon") == 0 && verb->count("--planes") == 0;
        for (std::size_t i = 0; i < axis_kinds.size(); ++i) {
            CLI::Option* option = verb->get_option(axis_kinds[i].option);
            if (is_usual && option->check_lname("epsilon")) {
                plan->axes.push_back({option, values_of(axis_kinds[i], usual_epsilons)});
            } else if (option->count() > 0) {
                plan->axes.push_back({option, arguments->given[i]});
            }
        }
        check_sweep(*arguments, *plan, *options);
        result = sweep(*arguments, *plan, *options);
    });
}

}  // namespace cli
