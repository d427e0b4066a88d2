// Options of a sweep that take several values: lists and ranges.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "shared.hpp"

namespace cli {

/// How the values of a range lie between its ends.
enum class spacing {
    none,       ///< there are no ranges
    even,       ///< equal differences
    geometric,  ///< equal ratios
};

struct axis_kind {
    const char* option = nullptr;
    spacing between = spacing::none;
    double unit = 0;  ///< values of a range are rounded to multiples of it; 0: they are not
};

/// In the order in which configurations count up, the last the fastest.
inline constexpr std::array<axis_kind, 12> axis_kinds{{{"--preset"},
                                                       {"--search"},
                                                       {"--plane-space"},
                                                       {"--raster", spacing::even, 2},
                                                       {"--contribution"},
                                                       {"--penalty", spacing::even},
                                                       {"--refine"},
                                                       {"--fit"},
                                                       {"--weld"},
                                                       {"--texels", spacing::geometric, 1},
                                                       {"--planes", spacing::geometric, 1},
                                                       {"--epsilon", spacing::geometric}}};

/// An option with the values that it takes in turn, as they were written.
struct sweep_axis {
    CLI::Option* option = nullptr;
    std::vector<std::string> values{};

    /// Throws CLI::ValidationError where the option refuses the value.
    void set(const std::string& value) const {
        option->clear();
        option->add_result(value);
        option->run_callback();
    }
};

inline std::vector<std::string> split_at(std::string_view text, char separator) {
    std::vector<std::string> parts{""};
    for (const char c : text) {
        if (c == separator) {
            parts.emplace_back();
        } else {
            parts.back() += c;
        }
    }
    return parts;
}

/// "A:B:N": N values from A to B. Throws CLI::ValidationError without the option's name, which is put
/// before what its checks throw.
inline std::vector<std::string> values_of_range(const axis_kind& kind, const std::string& text) {
    const auto refuse = [&](const std::string& why) {
        throw CLI::ValidationError("'" + text + "' " + why);
    };
    if (kind.between == spacing::none) refuse("is a range, of which this option has none");
    std::vector<std::string> parts = split_at(text, ':');
    if (parts.size() != 3) refuse("is no range FROM:TO:COUNT such as 2:20:10");
    const bool is_share = parts[0].ends_with('%');
    if (parts[1].ends_with('%') != is_share) refuse("has a percentage at one end only");
    if (is_share) {
        parts[0].pop_back();
        parts[1].pop_back();
    }
    const auto from = number_of(parts[0]);
    const auto to = number_of(parts[1]);
    const auto count = number_of(parts[2]);
    if (!from || !to) refuse("has an end that is no number");
    if (!count || *count != std::floor(*count) || *count < 2 || *count > 1000) {
        refuse("needs a whole number of values, from 2 to 1000");
    }
    if (kind.between == spacing::geometric && !(*from > 0 && *to > 0)) {
        refuse("has equal ratios, so that both ends must be above 0");
    }
    std::vector<std::string> values;
    for (int i = 0; i < *count; ++i) {
        const double at = i / (*count - 1);
        double value = kind.between == spacing::geometric ? *from * std::pow(*to / *from, at)
                                                          : *from + (*to - *from) * at;
        if (kind.unit > 0) value = std::round(value / kind.unit) * kind.unit;
        char written[40];
        std::snprintf(written, sizeof written, is_share ? "%.4g%%" : "%.5g", value);
        values.emplace_back(written);
    }
    return values;
}

/// The values of "a,b,c", each of which may be a range; each value once. Throws as values_of_range.
inline std::vector<std::string> values_of(const axis_kind& kind, const std::string& text) {
    std::vector<std::string> values;
    for (const std::string& part : split_at(text, ',')) {
        if (part.empty()) {
            throw CLI::ValidationError("'" + text + "' lacks a value");
        }
        const bool is_range = part.find(':') != std::string::npos;
        for (const std::string& value :
             is_range ? values_of_range(kind, part) : std::vector{part}) {
            if (std::ranges::find(values, value) == values.end()) values.push_back(value);
        }
    }
    return values;
}

}  // namespace cli
