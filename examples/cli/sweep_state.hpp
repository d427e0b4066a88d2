// What a sweep has measured so far, in a file, so that it goes on where it was stopped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <billow/core/expected.hpp>

namespace cli {

/// One configuration, measured.
struct sweep_row {
    nlohmann::ordered_json key{};      ///< what was asked for: all that the numbers depend on
    nlohmann::ordered_json numbers{};  ///< by name
    nlohmann::ordered_json seconds{};  ///< by name; differ from run to run
};

/// The rows of one input, one line of JSON each, below a line that says which input that is. Rows of
/// other options stay: a later sweep may ask for them.
class sweep_state {
public:
    /// Reads the file, if there is one.
    ///
    /// Fails   malformed: it holds something else, or rows of another input.
    static billow::expected<sweep_state> open(const std::filesystem::path& file,
                                              std::span<const std::uint8_t> input);

    /// The row with this key; nullptr without one.
    [[nodiscard]] const sweep_row* find(const nlohmann::ordered_json& key) const;
    /// Adds a row and writes the file anew: beside its place, then renamed.
    billow::expected<billow::done> add(sweep_row row);

private:
    std::filesystem::path file_{};
    std::string head_{};  ///< its first line
    std::vector<sweep_row> rows_{};
};

}  // namespace cli
