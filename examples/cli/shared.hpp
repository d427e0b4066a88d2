// What several verbs need: reading values, saying what failed, measuring time.
#pragma once

#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <billow/core/expected.hpp>
#include <billow/io/file.hpp>
#include <billow/pipeline.hpp>

#include "verbs.hpp"

namespace cli {

/// Wall time since the last call of lap().
class stopwatch {
public:
    double lap() {
        const auto now = clock::now();
        const double seconds = std::chrono::duration<double>(now - last_).count();
        last_ = now;
        return seconds;
    }
    [[nodiscard]] double total() const {
        return std::chrono::duration<double>(clock::now() - start_).count();
    }

private:
    using clock = std::chrono::steady_clock;
    clock::time_point start_ = clock::now();
    clock::time_point last_ = start_;
};

/// The whole of `text` as a finite number.
inline std::optional<double> number_of(std::string_view text) {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, value);
    if (parsed.ec != std::errc{} || parsed.ptr != end || !std::isfinite(value)) return {};
    return value;
}

/// "10%" is a share of the radius, "0.12" a length in scene units. Throws CLI::ValidationError.
inline billow::tolerance parse_tolerance(const char* option, const std::string& text) {
    const bool is_share = text.ends_with('%');
    const auto value =
        number_of(std::string_view(text).substr(0, text.size() - (is_share ? 1 : 0)));
    if (!value || !(*value > 0)) {
        throw CLI::ValidationError(option, "'" + text +
                                               "' is neither a percentage such as 10% nor a "
                                               "length such as 0.12, greater than 0");
    }
    return is_share ? billow::tolerance::of_radius(*value / 100)
                    : billow::tolerance::scene_units(*value);
}

/// "80%" and "0.8" are the same share. Throws CLI::ValidationError where it is outside [0, most].
inline double parse_share(const char* option, const std::string& text, double most = 1) {
    const bool is_percent = text.ends_with('%');
    auto value = number_of(std::string_view(text).substr(0, text.size() - (is_percent ? 1 : 0)));
    if (value && is_percent) *value /= 100;
    if (!value || !(*value >= 0 && *value <= most)) {
        throw CLI::ValidationError(option, "'" + text +
                                               "' is not a share such as 80% or 0.8, from 0 to " +
                                               std::to_string(static_cast<int>(100 * most)) + "%");
    }
    return *value;
}

/// NAME.png, then NAME_1.png, NAME_2.png …
inline std::filesystem::path numbered(const std::filesystem::path& file, std::size_t number) {
    if (number == 0) return file;
    auto name = file;
    name.replace_filename(file.stem().string() + "_" + std::to_string(number) +
                          file.extension().string());
    return name;
}

inline billow::expected<billow::done> write_text(const std::filesystem::path& file,
                                                 const std::string& text) {
    return billow::write_file(file,
                              {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// --threads and --quiet, which all verbs have that take long.
inline void add_run_options(CLI::App& verb, unsigned& threads, bool& is_quiet) {
    verb.add_option("--threads", threads, "Threads, 0: all; results are the same for any number")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str()
        ->group("Output");
    verb.add_flag("--quiet", is_quiet, "Say nothing but errors")->group("Output");
}

inline exit_code fail(const billow::error& why) {
    std::fprintf(stderr, "billow: %s\n", why.message.c_str());
    return bad_input;
}

}  // namespace cli
