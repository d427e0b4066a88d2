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
#include "screen_options.hpp"
#include "shared.hpp"
#include "svg_chart.hpp"
#include "sweep_axis.hpp"
#include "sweep_state.hpp"

namespace cli {
namespace {

using namespace billow;
using sweep_json = nlohmann::ordered_json;

struct sweep_arguments {
    std::filesystem::path input{};
    std::filesystem::path output{};  ///< what the names of all files start with
    std::string distance = "4R";
    compare_options look{.size_px = 256};
    screen_options seen{};
    std::array<std::vector<std::string>, axis_kinds.size()> given{};  ///< values, by axis_kinds
    unsigned threads = 0;
    bool is_quiet = false;

    [[nodiscard]] std::filesystem::path file(const char* ending) const {
        auto name = output;
        return name += ending;
    }
};

/// What is swept when neither epsilon nor planes are given.
constexpr const char* usual_epsilons = "2%:20%:8";
constexpr std::size_t most_configurations = 10000;

/// The options of clouds of a verb and those of them that take several values.
struct sweep_plan {
    std::vector<const CLI::Option*> of_cloud{};
    std::vector<sweep_axis> axes{};

    [[nodiscard]] std::size_t count() const {
        std::size_t all = 1;
        for (const sweep_axis& axis : axes) {
            all = std::min(most_configurations + 1, all * axis.values.size());
        }
        return all;
    }
    [[nodiscard]] const std::string& value(std::size_t configuration, std::size_t axis) const {
        std::size_t after = 1;
        for (std::size_t i = axis + 1; i < axes.size(); ++i) after *= axes[i].values.size();
        const auto& values = axes[axis].values;
        return values[configuration / after % values.size()];
    }
    void set(std::size_t configuration) const {
        for (std::size_t i = 0; i < axes.size(); ++i) axes[i].set(value(configuration, i));
    }
    /// What differs between configurations, as it is written: "--texels 64 --epsilon 2%".
    [[nodiscard]] std::string label(std::size_t configuration) const {
        std::string text;
        for (std::size_t i = 0; i < axes.size(); ++i) {
            if (axes[i].values.size() < 2) continue;
            text += (text.empty() ? "" : " ") + axes[i].option->get_name() + " " +
                    value(configuration, i);
        }
        return text;
    }
};

std::string column_of(const CLI::Option& option) {
    return option.get_name().substr(2);  // without --
}

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

/// Scene units from the centre, from where on an error of a row covers at most the pixels given.
double row_distance(const sweep_row& row, const char* error, double radius,
                    const screen_options& seen) {
    return distance_for_pixels(row.numbers.at(error).get<double>(), radius, seen.pixel_error,
                               seen.screen());
}

/// A finished sweep.
struct finished_sweep {
    const sweep_arguments& arguments;
    const sweep_plan& plan;
    const mesh& source;
    bounding_sphere bounds{};
    std::vector<sweep_row> rows{};  ///< by configuration
};

std::string sweep_csv(const finished_sweep& of) {
    std::string text;
    const auto number = [](const sweep_json& value) {
        char written[40];
        std::snprintf(written, sizeof written, "%.9g", value.get<double>());
        return std::string(written);
    };
    for (const sweep_axis& axis : of.plan.axes) text += column_of(*axis.option) + ",";
    for (const auto& entry : of.rows.front().numbers.items()) text += entry.key() + ",";
    text += "distance_by_max,distance_by_mean";
    for (const auto& entry : of.rows.front().seconds.items()) text += ",seconds_" + entry.key();
    text += "\n";
    for (std::size_t i = 0; i < of.rows.size(); ++i) {
        const sweep_row& row = of.rows[i];
        for (std::size_t axis = 0; axis < of.plan.axes.size(); ++axis) {
            text += of.plan.value(i, axis) + ",";
        }
        for (const auto& entry : row.numbers.items()) text += number(entry.value()) + ",";
        const screen_options& seen = of.arguments.seen;
        text += number(row_distance(row, "geometric_max", of.bounds.radius, seen)) + ",";
        text += number(row_distance(row, "geometric_mean", of.bounds.radius, seen));
        for (const auto& entry : row.seconds.items()) text += "," + number(entry.value());
        text += "\n";
    }
    return text;
}

/// Keys in a fixed order, no times, no folders.
std::string sweep_report(const finished_sweep& of) {
    sweep_json told;
    told["schema"] = "billow-sweep/1";
    told["generator"] = "billow " BILLOW_VERSION;
    sweep_json& input = told["input"];
    input["file"] = of.arguments.input.filename().string();
    input["triangles"] = of.source.face_count();
    input["texture_bytes"] = texture_bytes_of(of.source).level_0;
    input["bounds"] = sphere_json(of.bounds);
    sweep_json& look = told["look"];
    look["views"] = of.arguments.look.views;
    look["size"] = of.arguments.look.size_px;
    look["distance_radii"] = of.arguments.look.distance;
    look["screen"] = of.arguments.seen.height_px;
    look["fov"] = of.arguments.seen.fov_degrees;
    look["pixel_error"] = of.arguments.seen.pixel_error;
    sweep_json& axes = told["axes"] = sweep_json::array();
    for (const sweep_axis& axis : of.plan.axes) {
        sweep_json one;
        one["option"] = column_of(*axis.option);
        one["values"] = axis.values;
        axes.push_back(std::move(one));
    }
    sweep_json& rows = told["rows"] = sweep_json::array();
    for (std::size_t i = 0; i < of.rows.size(); ++i) {
        const sweep_row& row = of.rows[i];
        sweep_json one;
        for (std::size_t axis = 0; axis < of.plan.axes.size(); ++axis) {
            one["options"][column_of(*of.plan.axes[axis].option)] = of.plan.value(i, axis);
        }
        one.update(row.numbers);
        const screen_options& seen = of.arguments.seen;
        one["distance_by_max"] = row_distance(row, "geometric_max", of.bounds.radius, seen);
        one["distance_by_mean"] = row_distance(row, "geometric_mean", of.bounds.radius, seen);
        rows.push_back(std::move(one));
    }
    return told.dump(2, ' ', false, sweep_json::error_handler_t::replace) + "\n";
}

/// The axis that curves run along: epsilon, or planes, or what else has several values.
std::size_t curve_axis(const sweep_plan& plan) {
    std::size_t chosen = 0;
    for (std::size_t i = 0; i < plan.axes.size(); ++i) {
        if (plan.axes[i].values.size() > 1) chosen = i;  // these two are the last
    }
    return chosen;
}

/// Rows as curves, a curve for each setting of the other axes, by ascending x.
template <class X, class Y>
std::vector<chart_series> sweep_series(const finished_sweep& of, const X& x, const Y& y) {
    const std::size_t along = curve_axis(of.plan);
    std::vector<chart_series> series;
    for (std::size_t i = 0; i < of.rows.size(); ++i) {
        std::string name;
        for (std::size_t axis = 0; axis < of.plan.axes.size(); ++axis) {
            if (axis == along || of.plan.axes[axis].values.size() < 2) continue;
            name += (name.empty() ? "" : ", ") + column_of(*of.plan.axes[axis].option) + " " +
                    of.plan.value(i, axis);
        }
        auto to = std::ranges::find(series, name, &chart_series::name);
        if (to == series.end()) to = series.insert(to, {name, {}});
        to->points.push_back({x(of.rows[i]), y(of.rows[i]), of.plan.label(i)});
    }
    for (chart_series& each : series) {
        std::ranges::stable_sort(each.points, {}, &chart_point::x);
    }
    return series;
}

std::string sweep_drawing(const finished_sweep& of) {
    const auto number = [](const char* name, double scale = 1) {
        return [name, scale](const sweep_row& row) {
            return scale * row.numbers.at(name).get<double>();
        };
    };
    const auto planes = number("planes");
    const screen_options& seen = of.arguments.seen;
    const auto distance = [&](const sweep_row& row) {
        return row_distance(row, "geometric_max", of.bounds.radius, seen);
    };
    const chart_axis by_planes{"planes", true};
    char pixels[80];
    std::snprintf(pixels, sizeof pixels, "Distance from which no vertex is off by over %.3g px",
                  seen.pixel_error);
    const std::vector<chart> charts{
        {"Silhouette: coverage error, mean of views",
         by_planes,
         {"% of the original", false},
         sweep_series(of, planes, number("coverage_mean", 100))},
        {"All that is seen: object ꟻLIP, mean of views",
         by_planes,
         {"0 to 1", false},
         sweep_series(of, planes, number("object_flip_mean"))},
        {"Geometric error, largest",
         by_planes,
         {"% of the radius", true},
         sweep_series(of, planes, number("geometric_max_of_radius", 100))},
        {pixels,
         by_planes,
         {"scene units from the centre", true},
         sweep_series(of, planes, distance)}};
    return svg_of(of.arguments.input.filename().string() + ": planes, error, distance", charts);
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
    verb->add_option("--threads", a.threads, "Threads, 0: all; results are the same for any number")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str()
        ->group("Output");
    verb->add_flag("--quiet", a.is_quiet, "Say nothing but errors")->group("Output");

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
