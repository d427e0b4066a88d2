// Curves as SVG: plain files, without scripts, for light and dark pages.
#pragma once

#include <string>
#include <vector>

namespace cli {

struct chart_point {
    double x = 0;
    double y = 0;
    std::string told{};  ///< shown when the pointer rests on it
};

/// Points that are joined in their order.
struct chart_series {
    std::string name{};
    std::vector<chart_point> points{};
};

struct chart_axis {
    std::string title{};
    bool is_log = false;  ///< what is not above 0 is left out
};

/// A chart. All charts of a drawing have the same series, by place: one legend serves all.
struct chart {
    std::string title{};
    chart_axis x{};
    chart_axis y{};
    std::vector<chart_series> series{};
};

/// Draws charts side by side, two a row, below a title and a legend. Same charts, same bytes.
[[nodiscard]] std::string svg_of(const std::string& title, const std::vector<chart>& charts);

}  // namespace cli
