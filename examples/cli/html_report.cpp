// A comparison as one HTML page.

#include "html_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>
#include <utility>

#include <billow/image/srgb.hpp>
#include <billow/metrics/difference_picture.hpp>

#include "html_page.hpp"
#include "html_plot.hpp"
#include "html_text.hpp"

namespace cli {

using namespace billow;

namespace {

// ---- numbers

/// What a metric is called and how it is read.
struct metric_words {
    std::string_view metric{};
    const char* name = "";
    const char* meaning = "";
};

constexpr std::array<metric_words, all_picture_metrics.size()> words_of_metrics{{
    {"coverage", "Coverage error", "pixels that only one of both covers, of the original's"},
    {"missing", "&emsp;missing", "of the original that the cloud does not cover"},
    {"extra", "&emsp;extra", "that the cloud covers beyond, of the original's"},
    {"extra_of_cloud", "&emsp;extra, of the cloud", "the same, of what the cloud covers"},
    {"gap_intensity", "Gap intensity", "how much longer borders are; below 0: thin parts are lost"},
    {"hole_share", "Holes", "of the original that is missing inside of its silhouette"},
    {"color", "Colour, mean ΔE", "between the mean colours of all that is covered"},
    {"common_color", "Colour where both cover, ΔE", "between the mean colours there"},
    {"local_color", "Local colour, ΔE", "the mean difference after a blur"},
    {"flip", "ꟻLIP", "the difference that an observer sees, over the picture"},
    {"object_flip", "ꟻLIP of the object", "the same, over what is covered"},
}};

static_assert([] {
    for (std::size_t i = 0; i < all_picture_metrics.size(); ++i) {
        if (words_of_metrics[i].metric != all_picture_metrics[i].name) return false;
    }
    return true;
}());

std::string value_text(std::string_view unit, double value) {
    if (unit == "share") return formatted("%.2f %%", 100 * value);
    return formatted(unit == "flip" ? "%.4f" : "%.2f", value);
}

std::string bytes_text(std::uint64_t bytes) {
    if (bytes >= 1'000'000) return formatted("%.2f MB", 1e-6 * static_cast<double>(bytes));
    return formatted("%.1f kB", 1e-3 * static_cast<double>(bytes));
}

std::string direction_text(const dvec3& from) {
    const double azimuth = std::atan2(from.x, from.z) * 180 / std::numbers::pi;
    return formatted("azimuth %.0f°, elevation %.0f°", azimuth, elevation_deg(from));
}

std::string img(const std::string& uri, const std::string& alt, const std::string& rest = {}) {
    return "<img alt=\"" + html_escaped(alt) + "\" " + rest + "src=\"" + uri + "\">";
}

class page_writer {
public:
    page_writer(const std::vector<compared_file>& files, const comparison& found,
                const compare_options& options, const page_pictures& pictures)
        : files_(files), found_(found), options_(options), pictures_(pictures) {}

    [[nodiscard]] std::string run() {
        write_head();
        write_costs();
        write_errors();
        write_plots();
        write_views();
        write_planes();
        write_atlases();
        out_ += "<script>" + std::string(page_script) + "</script>\n</body>\n</html>\n";
        return std::move(out_);
    }

private:
    [[nodiscard]] std::string name_of(std::size_t cloud) const {
        return html_escaped(files_[cloud + 1].name);
    }
    [[nodiscard]] const dvec3& direction(std::size_t view) const {
        return found_.cameras[view].axes.normal;
    }

    void write_head() {
        const std::string name = html_escaped(files_.front().name);
        out_ =
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
            "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
            "img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
            "<meta name=\"viewport\" content=\"width=device-width\">\n<title>" +
            name + ": clouds compared</title>\n<style>" + page_style +
            "</style>\n</head>\n<body>\n<h1>" + name + " and what stands for it</h1>\n";
        out_ += formatted(
            "<p>%d evenly spread views of %d × %d pixels from %.4g radii. ꟻLIP sees "
            "the pictures at %.0f pixels a degree, as large as the object is at that "
            "distance on a screen %d pixels high.</p>\n",
            options_.views, options_.size_px, options_.size_px, options_.distance,
            found_.pixels_per_degree, options_.screen.height_px);
    }

    void write_costs() {
        out_ +=
            "<h2>Cost</h2>\n<div class=\"wide\"><table id=\"costs\">\n<thead><tr><td></td>"
            "<th scope=\"col\">planes</th><th scope=\"col\">triangles</th>"
            "<th scope=\"col\">textures</th><th scope=\"col\">with mips</th>"
            "<th scope=\"col\" title=\"fragments drawn for a pixel covered, mean over "
            "views\">overdraw</th><th scope=\"col\">worst</th></tr></thead>\n<tbody>\n";
        const auto row = [&](const std::string& name, const std::string& planes,
                             const draw_cost& cost, const statistic& overdraw) {
            out_ += "<tr><th scope=\"row\">" + name + "</th><td>" + planes + "</td><td>" +
                    std::to_string(cost.triangles) + "</td><td>" +
                    bytes_text(cost.textures.level_0) + "</td><td>" +
                    bytes_text(cost.textures.with_mips) + "</td>" +
                    formatted("<td>%.2f</td><td>%.2f</td></tr>\n", overdraw.mean, overdraw.worst);
        };
        row(html_escaped(files_.front().name), "", found_.original, found_.original_overdraw);
        for (std::size_t c = 0; c < found_.clouds.size(); ++c) {
            const cloud_comparison& of = found_.clouds[c];
            row(series_mark(c) + name_of(c),
                of.geometric ? std::to_string(of.planes.planes.plane_count()) : "–", of.cost,
                of.overdraw);
        }
        out_ += "</tbody></table></div>\n<p>Textures without any compression.</p>\n";
    }

    [[nodiscard]] static std::string series_mark(std::size_t c) {
        return formatted("<span class=\"swatch b%zu\"></span>", c % 6);
    }

    void write_errors() {
        out_ += "<h2>Errors</h2>\n<div class=\"wide\"><table id=\"errors\">\n<thead><tr><td></td>";
        for (std::size_t c = 0; c < found_.clouds.size(); ++c) {
            out_ += "<th scope=\"colgroup\" colspan=\"4\" class=\"group\">" + series_mark(c) +
                    name_of(c) + "</th>";
        }
        out_ += "</tr>\n<tr><td></td>";
        for (std::size_t c = 0; c < found_.clouds.size(); ++c) {
            out_ +=
                "<th scope=\"col\">mean</th><th scope=\"col\">95 %</th>"
                "<th scope=\"col\">worst</th><th scope=\"col\">in view</th>";
        }
        out_ += "</tr></thead>\n<tbody>\n";
        for (std::size_t i = 0; i < all_picture_metrics.size(); ++i) write_metric(i);
        if (std::any_of(found_.clouds.begin(), found_.clouds.end(),
                        [](const cloud_comparison& c) { return c.geometric.has_value(); })) {
            write_geometry("Geometric error, units", &geometric_errors::mean,
                           &geometric_errors::max, "%.4g", 1);
            write_geometry("&emsp;of the radius", &geometric_errors::mean_of_radius,
                           &geometric_errors::max_of_radius, "%.2f %%", 100);
            write_geometry("&emsp;pixels", &geometric_errors::mean_px, &geometric_errors::max_px,
                           "%.2f", 1);
        }
        out_ +=
            "</tbody></table></div>\n<p>Each is 0 for the original itself. The mean nearest to 0 "
            "is bold. A geometric error is a lower bound: each face is taken to be on the nearest "
            "plane with a polygon over it, since a file does not tell.</p>\n";
    }

    void write_metric(std::size_t row) {
        const picture_metric& metric = all_picture_metrics[row];
        const metric_words& words = words_of_metrics[row];
        out_ += std::string("<tr><th scope=\"row\" title=\"") + words.meaning + "\">" + words.name +
                "</th>";
        double least = 1e300;
        for (const auto& c : found_.clouds) {
            least = std::min(least, std::abs((c.errors.*metric.over_views).mean));
        }
        for (const auto& c : found_.clouds) {
            const statistic& s = c.errors.*metric.over_views;
            const bool is_best = found_.clouds.size() > 1 && std::abs(s.mean) <= least;
            out_ += std::string(is_best ? "<td class=\"best\">" : "<td>") +
                    value_text(metric.unit, s.mean) + "</td><td>" + value_text(metric.unit, s.p95) +
                    "</td><td>" + value_text(metric.unit, s.worst) + "</td><td title=\"" +
                    direction_text(direction(s.worst_view)) + "\"><small>" +
                    std::to_string(s.worst_view) + "</small></td>";
        }
        out_ += "</tr>\n";
    }

    void write_geometry(const char* name, double geometric_errors::*mean,
                        double geometric_errors::*max, const char* format, double factor) {
        out_ += std::string("<tr><th scope=\"row\">") + name + "</th>";
        for (const auto& c : found_.clouds) {
            if (!c.geometric) {
                out_ += "<td>–</td><td></td><td>–</td><td></td>";
                continue;
            }
            out_ += "<td>" + formatted(format, factor * (*c.geometric).*mean) +
                    "</td><td></td><td>" + formatted(format, factor * (*c.geometric).*max) +
                    "</td><td></td>";
        }
        out_ += "</tr>\n";
    }

    void write_plots() {
        out_ +=
            "<h2>Over the views</h2>\n<p>Left: the views in ascending order. Right: by how far "
            "above the horizon the eye is.</p>\n";
        for (const std::size_t row : {0u, 4u, 8u, 10u}) {
            const picture_metric& metric = all_picture_metrics[row];
            std::string name = words_of_metrics[row].name;
            const double factor = metric.unit == "share" ? 100 : 1;
            if (factor > 1) name += ", %";
            double low = 0;
            double high = 0;
            for (const auto& c : found_.clouds) {
                for (const view_errors& v : c.views) {
                    low = std::min(low, factor * v.*metric.of_view);
                    high = std::max(high, factor * v.*metric.of_view);
                }
            }
            const double top = high > 0 || !(low < 0) ? round_above(high) : 0;
            const double bottom = low < 0 ? -round_above(-low) : 0;
            plot sorted(name, bottom, top);
            plot by_elevation(name, bottom, top);
            sorted.label(0, "best view");
            sorted.label(1, "worst");
            by_elevation.label(0, "-90°");
            by_elevation.label(0.5, "0°");
            by_elevation.label(1, "90°");
            for (std::size_t c = 0; c < found_.clouds.size(); ++c) {
                std::vector<double> values;
                for (std::size_t i = 0; i < found_.cameras.size(); ++i) {
                    values.push_back(factor * found_.clouds[c].views[i].*metric.of_view);
                    by_elevation.point(c, (elevation_deg(direction(i)) + 90) / 180, values.back(),
                                       i);
                }
                std::sort(values.begin(), values.end());
                sorted.curve(c, values);
            }
            out_ += "<div class=\"row\">" + sorted.text() + by_elevation.text() + "</div>\n";
        }
    }

    [[nodiscard]] std::string hidden_unless_first(std::size_t c) const {
        return formatted(" data-cloud=\"%zu\"", c) + (c == 0 ? "" : " hidden");
    }

    /// Why a view is shown.
    [[nodiscard]] std::string reasons(std::size_t view) const {
        std::string said;
        for (std::size_t c = 0; c < found_.clouds.size(); ++c) {
            const cloud_comparison& of = found_.clouds[c];
            const bool is_worst = of.errors.coverage.worst_view == view;
            const bool is_seen_most = of.errors.object_flip.worst_view == view;
            const auto least = std::min_element(
                of.views.begin(), of.views.end(),
                [](const view_errors& a, const view_errors& b) { return a.coverage < b.coverage; });
            const bool is_best = static_cast<std::size_t>(least - of.views.begin()) == view;
            const std::string whose = found_.clouds.size() > 1 ? " of " + name_of(c) : "";
            if (is_worst) said += "; worst coverage" + whose;
            if (is_seen_most) said += "; worst ꟻLIP" + whose;
            if (is_best) said += "; best coverage" + whose;
        }
        return said;
    }

    void write_views() {
        const coverage_colors colors;
        const auto swatch = [](const vec3& light) {
            return formatted("<span class=\"swatch\" style=\"background:rgb(%d %d %d)\"></span>",
                             srgb_byte_from_linear(light.x), srgb_byte_from_linear(light.y),
                             srgb_byte_from_linear(light.z));
        };
        out_ +=
            "<h2>Views</h2>\n<p>Left of the bar the original, right of it the cloud. Coverage: " +
            swatch(colors.both) + "both, " + swatch(colors.missing) + "missing, " +
            swatch(colors.extra) +
            "extra. Colour: ΔE after a blur, <span class=\"scale\">0 <span class=\"heat\">"
            "</span> " +
            formatted("%.0f", hottest_color) + " and more.</span></p>\n";
        if (found_.clouds.size() > 1) {
            out_ += "<p><label>Shown: <select id=\"cloud\">";
            for (std::size_t c = 0; c < found_.clouds.size(); ++c) {
                out_ += formatted("<option value=\"%zu\">", c) + name_of(c) + "</option>";
            }
            out_ += "</select></label></p>\n";
        }
        for (const view_pictures& v : pictures_.views) {
            out_ += formatted("<article class=\"view\"><h3>View %zu: ", v.view) +
                    direction_text(direction(v.view)) + reasons(v.view) +
                    "</h3>\n<div class=\"row\"><figure><div class=\"slider\">" +
                    img(v.original, "original");
            for (std::size_t c = 0; c < v.clouds.size(); ++c) {
                out_ += img(v.clouds[c].seen, files_[c + 1].name,
                            "class=\"after\"" + hidden_unless_first(c) + " ");
            }
            out_ +=
                "</div><input type=\"range\" min=\"0\" max=\"100\" step=\"any\" value=\"50\" "
                "aria-label=\"original or cloud\"></figure>\n";
            for (std::size_t c = 0; c < v.clouds.size(); ++c) {
                const view_errors& e = found_.clouds[c].views[v.view];
                out_ += "<figure class=\"difference\"" + hidden_unless_first(c) + ">" +
                        img(v.clouds[c].coverage, "difference of coverage") +
                        formatted(
                            "<figcaption>coverage error %.2f %%: %.2f %% missing, %.2f %% "
                            "extra</figcaption></figure>\n",
                            100 * e.coverage, 100 * e.missing, 100 * e.extra);
                out_ += "<figure class=\"difference\"" + hidden_unless_first(c) + ">" +
                        img(v.clouds[c].color, "difference of colours") +
                        formatted(
                            "<figcaption>local colour ΔE %.2f, ꟻLIP of the object "
                            "%.3f</figcaption></figure>\n",
                            e.local_color, e.object_flip);
            }
            out_ += "</div></article>\n";
        }
    }

    void write_planes() {
        if (pictures_.planes.empty()) return;
        out_ +=
            "<h2>Planes</h2>\n<p>A colour for each plane: the original's faces by the nearest "
            "plane with a polygon over them, dark where there is none; the cloud's by their "
            "plane.</p>\n<div class=\"row\">\n";
        for (const plane_pictures& p : pictures_.planes) {
            out_ += "<figure><div class=\"slider\">" + img(p.original, "original by planes") +
                    img(p.seen, "cloud by planes", "class=\"after\" ") +
                    "</div><input type=\"range\" min=\"0\" max=\"100\" step=\"any\" value=\"50\" "
                    "aria-label=\"original or cloud\"><figcaption>" +
                    name_of(p.cloud) + "</figcaption></figure>\n";
        }
        out_ += "</div>\n";
    }

    void write_atlases() {
        if (pictures_.atlases.empty()) return;
        out_ += "<h2>Atlas</h2>\n<p>Base colour. Point at a plane to see its outline.</p>\n";
        for (std::size_t i = 0; i < pictures_.atlases.size(); ++i) {
            const atlas_picture& a = pictures_.atlases[i];
            out_ += "<h3>" + name_of(a.cloud) +
                    formatted(
                        ": %d × %d texels</h3>\n<p><label><input type=\"checkbox\" "
                        "class=\"outlines\" data-of=\"atlas%zu\"> all outlines</label></p>\n",
                        a.width, a.height, i) +
                    "<div class=\"atlas\">" + img(a.uri, "atlas") +
                    formatted(
                        "<svg id=\"atlas%zu\" viewBox=\"0 0 %d %d\" "
                        "preserveAspectRatio=\"none\">\n",
                        i, a.width, a.height) +
                    a.planes + "</svg></div><p class=\"said\"></p>\n";
        }
    }

    const std::vector<compared_file>& files_;
    const comparison& found_;
    const compare_options& options_;
    const page_pictures& pictures_;
    std::string out_{};
};

}  // namespace

std::string html_report(const std::vector<compared_file>& files, const comparison& found,
                        const compare_options& options, parallel threads,
                        const progress_function& progress) {
    BILLOW_ASSERT(files.size() == found.clouds.size() + 1);
    const page_pictures pictures = draw_pictures(files, found, options, threads, progress);
    return page_writer(files, found, options, pictures).run();
}

}  // namespace cli
