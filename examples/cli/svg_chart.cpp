// Curves as SVG.

#include "svg_chart.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <utility>

#include "html_plot.hpp"
#include "html_report.hpp"

namespace cli {

namespace {

constexpr double chart_width = 480;
constexpr double chart_height = 320;
constexpr double plot_left = 66;  // of a chart's corner, as the three below
constexpr double plot_right = 464;
constexpr double plot_top = 34;
constexpr double plot_bottom = 266;
constexpr std::size_t chart_colors = 6;

constexpr std::string_view chart_style = R"(<style>
text { font: 12px system-ui, sans-serif; fill: #33373d; }
.title { font-size: 15px; font-weight: 600; } .name { font-weight: 600; }
.page { fill: #fff; } .grid { stroke: #dfe2e5; fill: none; } .edge { stroke: #868c94; fill: none; }
.curve { fill: none; stroke-width: 2; } .again { stroke-dasharray: 6 3; }
.s0 { stroke: #0b63b0; } .s1 { stroke: #c2540a; } .s2 { stroke: #18794e; }
.s3 { stroke: #9a2a80; } .s4 { stroke: #8a6d00; } .s5 { stroke: #54606e; }
circle { fill: #fff; stroke-width: 2; }
@media (prefers-color-scheme: dark) {
text { fill: #d3d6da; }
.page, circle { fill: #17181a; } .grid { stroke: #34373b; } .edge { stroke: #7f858d; }
.s0 { stroke: #6fb3f2; } .s1 { stroke: #f29a5c; } .s2 { stroke: #5cc592; }
.s3 { stroke: #e08acb; } .s4 { stroke: #d8bd52; } .s5 { stroke: #a9b4c0; }
}
</style>
)";

std::string svg_words(double x, double y, const char* anchor, const std::string& words,
                      const char* kind = "") {
    return formatted("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" class=\"%s\">", x, y, anchor,
                     kind) +
           html_escaped(words) + "</text>\n";
}

std::string svg_series_class(std::size_t series) {
    return formatted("s%zu%s", series % chart_colors,
                     series / chart_colors % 2 == 1 ? " again" : "");
}

/// Places along an axis: values to pixels, and the values that are written beside it.
class chart_scale {
public:
    chart_scale(const chart_axis& axis, const chart& of, double chart_point::*value, double from,
                double to)
        : is_log_(axis.is_log), from_(from), to_(to) {
        low_ = std::numeric_limits<double>::infinity();
        high_ = -low_;
        for (const chart_series& series : of.series) {
            for (const chart_point& point : series.points) {
                if (!shows(point.*value)) continue;
                low_ = std::min(low_, point.*value);
                high_ = std::max(high_, point.*value);
            }
        }
        is_empty_ = !(low_ <= high_);
        if (is_empty_) return;
        if (is_log_) {
            choose_log_marks();
        } else {
            choose_even_marks();
        }
    }

    [[nodiscard]] bool shows(double value) const noexcept {
        return std::isfinite(value) && (!is_log_ || value > 0);
    }
    [[nodiscard]] double at(double value) const noexcept {
        const double share = is_log_ ? std::log(value / low_) / std::log(high_ / low_)
                                     : (value - low_) / (high_ - low_);
        return from_ + (to_ - from_) * share;
    }
    [[nodiscard]] bool is_empty() const noexcept { return is_empty_; }
    [[nodiscard]] const std::vector<double>& marks() const noexcept { return marks_; }

private:
    /// 1, 2 and 5 times powers of ten; the powers alone where there are many, more between them where
    /// there are few.
    void choose_log_marks() {
        marks_ = {low_};
        if (high_ > 1.0001 * low_) marks_.push_back(high_);
        low_ *= 0.95;  // points stand clear of the edges
        high_ *= 1.05;
        const double ratio = high_ / low_;
        const std::vector<double> steps = ratio > 2000 ? std::vector{1.0}
                                          : ratio > 8
                                              ? std::vector{1.0, 2.0, 5.0}
                                              : std::vector{1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0};
        std::vector<double> round;
        for (double power = std::pow(10, std::floor(std::log10(low_))); power < high_;
             power *= 10) {
            for (const double step : steps) {
                const double mark = step * power;
                if (mark >= low_ && mark <= high_) round.push_back(mark);
            }
        }
        if (round.size() >= 2) marks_ = std::move(round);
    }
    /// From 0, or below, in steps of 1, 2 or 5 times a power of ten.
    void choose_even_marks() {
        low_ = std::min(low_, 0.0);
        high_ = std::max(high_, low_ + 1e-9);
        const double rough = (high_ - low_) / 6;
        const double power = std::pow(10, std::floor(std::log10(rough)));
        double step = 10 * power;
        for (const double factor : {5.0, 2.0, 1.0}) {
            if (factor * power >= rough) step = factor * power;
        }
        const double first = std::floor(low_ / step);
        const double last = std::ceil(high_ / step);
        low_ = first * step;
        high_ = last * step;
        for (double k = first; k <= last; ++k) marks_.push_back(k * step);
    }

    bool is_log_;
    bool is_empty_ = false;
    double from_;
    double to_;
    double low_ = 0;
    double high_ = 1;
    std::vector<double> marks_{};
};

std::string svg_axes(const chart& of, const chart_scale& x, const chart_scale& y) {
    std::string text;
    for (const double mark : x.marks()) {
        text += formatted("<path class=\"grid\" d=\"M%.1f %.1fV%.1f\"/>", x.at(mark), plot_top,
                          plot_bottom);
        text += svg_words(x.at(mark), plot_bottom + 18, "middle", formatted("%.6g", mark));
    }
    for (const double mark : y.marks()) {
        text += formatted("<path class=\"grid\" d=\"M%.1f %.1fH%.1f\"/>", plot_left, y.at(mark),
                          plot_right);
        text += svg_words(plot_left - 6, y.at(mark) + 4, "end", formatted("%.6g", mark));
    }
    text += formatted("<path class=\"edge\" d=\"M%.1f %.1fV%.1fH%.1f\"/>\n", plot_left, plot_top,
                      plot_bottom, plot_right);
    text += svg_words(0.5 * (plot_left + plot_right), plot_bottom + 38, "middle", of.x.title);
    text += formatted("<g transform=\"translate(14 %.1f) rotate(-90)\">",
                      0.5 * (plot_top + plot_bottom));
    return text + svg_words(0, 0, "middle", of.y.title) + "</g>\n";
}

std::string svg_curve(const chart_series& series, const std::string& kind, const chart_scale& x,
                      const chart_scale& y) {
    std::string line;
    std::string dots;
    for (const chart_point& point : series.points) {
        if (!x.shows(point.x) || !y.shows(point.y)) continue;
        const double across = x.at(point.x);
        const double down = y.at(point.y);
        line += formatted("%c%.1f %.1f", line.empty() ? 'M' : 'L', across, down);
        dots += formatted("<circle class=\"%s\" cx=\"%.1f\" cy=\"%.1f\" r=\"3.5\"><title>",
                          kind.substr(0, 2).c_str(), across, down) +
                html_escaped(point.told) + "</title></circle>\n";
    }
    return "<path class=\"curve " + kind + "\" d=\"" + line + "\"/>\n" + dots;
}

std::string svg_chart(const chart& of) {
    std::string text = svg_words(plot_left, 18, "start", of.title, "name");
    const chart_scale x(of.x, of, &chart_point::x, plot_left, plot_right);
    const chart_scale y(of.y, of, &chart_point::y, plot_bottom, plot_top);
    if (x.is_empty() || y.is_empty()) {
        return text + svg_words(plot_left, 60, "start", "nothing that a logarithm could show");
    }
    text += svg_axes(of, x, y);
    for (std::size_t i = 0; i < of.series.size(); ++i) {
        text += svg_curve(of.series[i], svg_series_class(i), x, y);
    }
    return text;
}

}  // namespace

std::string svg_of(const std::string& title, const std::vector<chart>& charts) {
    std::string body = svg_words(16, 26, "start", title, "title");
    double top = 44;
    const std::vector<chart_series> none;
    const auto& named = charts.empty() ? none : charts.front().series;
    for (std::size_t i = 0; i < named.size(); ++i) {
        if (named[i].name.empty()) continue;
        const double left = 16 + 320 * static_cast<double>(i % 3);
        body += formatted("<path class=\"curve %s\" d=\"M%.1f %.1fh26\"/>",
                          svg_series_class(i).c_str(), left, top + 8);
        body += svg_words(left + 34, top + 12, "start", named[i].name);
        if (i % 3 == 2 || i + 1 == named.size()) top += 20;
    }
    top += 6;
    for (std::size_t i = 0; i < charts.size(); ++i) {
        const std::size_t row = i / 2;
        const double down = top + chart_height * static_cast<double>(row);
        body += formatted("<g transform=\"translate(%.0f %.0f)\">\n",
                          chart_width * static_cast<double>(i % 2), down);
        body += svg_chart(charts[i]) + "</g>\n";
    }
    const std::size_t rows = (charts.size() + 1) / 2;
    const double height = top + chart_height * static_cast<double>(rows);
    return formatted("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\">\n",
                     2 * chart_width, height) +
           std::string(chart_style) + "<rect class=\"page\" width=\"100%\" height=\"100%\"/>\n" +
           body + "</svg>\n";
}

}  // namespace cli
