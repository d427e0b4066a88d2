// Two small plots of a metric as SVG: its values in ascending order, and by the views' elevation.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include <billow/core/types.hpp>

#include "html_text.hpp"

namespace cli {

/// Degrees above the horizon, +Y up.
inline double elevation_deg(const billow::dvec3& direction) {
    return std::asin(std::clamp(direction.y, -1.0, 1.0)) * 180 / std::numbers::pi;
}

/// The least of 1, 1.5, 2, 3, 4, 5, 6 and 8 times powers of ten that is not below `value`.
inline double round_above(double value) {
    if (!(value > 0)) return 1;
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0}) {
        if (step * power >= value) return step * power;
    }
    return 10 * power;
}

/// The box of a plot: values from `low` to `high` upwards.
class plot {
public:
    plot(const std::string& title, double low, double high) : low_(low), high_(high) {
        text_ = "<svg class=\"plot\" viewBox=\"0 0 480 220\" role=\"img\" aria-label=\"" + title +
                "\"><text x=\"52\" y=\"16\">" + title + "</text>\n";
        for (int i = 0; i <= 4; ++i) {
            const double value = low + (high - low) * i / 4;
            text_ += formatted("<path class=\"axis\" d=\"M52 %.1fH470\"/>", y_of(value));
            text_ += formatted("<text x=\"46\" y=\"%.1f\" text-anchor=\"end\">%.3g</text>\n",
                               y_of(value) + 4, value);
        }
    }
    /// A word below the place `at`, 0 to 1, of the x axis.
    void label(double at, const std::string& word) {
        const char* anchor = at <= 0 ? "start" : at >= 1 ? "end" : "middle";
        text_ += formatted("<text x=\"%.1f\" y=\"212\" text-anchor=\"%s\">", x_of(at), anchor) +
                 word + "</text>\n";
    }
    void curve(std::size_t series, const std::vector<double>& values) {
        text_ += formatted("<path class=\"curve s%zu\" d=\"", series % 6);
        for (std::size_t i = 0; i < values.size(); ++i) {
            const double at = values.size() < 2
                                  ? 0.5
                                  : static_cast<double>(i) / static_cast<double>(values.size() - 1);
            text_ += formatted("%c%.1f %.1f", i == 0 ? 'M' : 'L', x_of(at), y_of(values[i]));
        }
        text_ += "\"/>\n";
    }
    void point(std::size_t series, double at, double value, std::size_t view) {
        text_ += formatted("<circle class=\"d%zu\" cx=\"%.1f\" cy=\"%.1f\" r=\"3\">", series % 6,
                           x_of(at), y_of(value));
        text_ += formatted("<title>view %zu: %.4g</title></circle>\n", view, value);
    }
    [[nodiscard]] std::string text() const { return text_ + "</svg>\n"; }

private:
    [[nodiscard]] static double x_of(double at) { return 52 + 418 * at; }
    [[nodiscard]] double y_of(double value) const {
        return 194 - 168 * (value - low_) / (high_ - low_);
    }

    double low_;
    double high_;
    std::string text_;
};

}  // namespace cli
