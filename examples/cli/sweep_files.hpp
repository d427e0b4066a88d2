// A sweep: which configurations there are, what was measured of them, and the files that tell it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <billow/geometry/bounds.hpp>
#include <billow/mesh/mesh.hpp>
#include <billow/metrics/compare.hpp>

#include "screen_options.hpp"
#include "sweep_axis.hpp"
#include "sweep_state.hpp"

namespace cli {

struct sweep_arguments {
    std::filesystem::path input{};
    std::filesystem::path output{};  ///< what the names of all files start with
    std::string distance = "4R";
    billow::compare_options look{.size_px = 256};
    screen_options seen{};
    std::array<std::vector<std::string>, axis_kinds.size()> given{};  ///< values, by axis_kinds
    unsigned threads = 0;
    bool is_quiet = false;

    [[nodiscard]] std::filesystem::path file(const char* ending) const {
        auto name = output;
        return name += ending;
    }
};

inline constexpr std::size_t most_configurations = 10000;

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

/// The name of an option in files: without --.
[[nodiscard]] inline std::string column_of(const CLI::Option& option) {
    return option.get_name().substr(2);  // without --
}

/// A finished sweep.
struct finished_sweep {
    const sweep_arguments& arguments;
    const sweep_plan& plan;
    const billow::mesh& source;
    billow::bounding_sphere bounds{};
    std::vector<sweep_row> rows{};  ///< by configuration
};

/// Scene units from the centre, from where on an error of a row covers at most the pixels given.
[[nodiscard]] double row_distance(const sweep_row& row, const char* error, double radius,
                                  const screen_options& seen);

/// A line a configuration, below the names of columns. Seconds differ from run to run, all else does
/// not.
[[nodiscard]] std::string sweep_csv(const finished_sweep& of);
/// As JSON: keys in a fixed order, no times, no folders.
[[nodiscard]] std::string sweep_report(const finished_sweep& of);
/// The curves as SVG.
[[nodiscard]] std::string sweep_drawing(const finished_sweep& of);

}  // namespace cli
