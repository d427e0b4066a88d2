// The files of a sweep.

#include "sweep_files.hpp"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "manifest.hpp"
#include "svg_chart.hpp"

namespace cli {

using namespace billow;

namespace {

using sweep_json = nlohmann::ordered_json;

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

}  // namespace

double row_distance(const sweep_row& row, const char* error, double radius,
                    const screen_options& seen) {
    return distance_for_pixels(row.numbers.at(error).get<double>(), radius, seen.pixel_error,
                               seen.screen());
}

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

}  // namespace cli
