// Progress on stderr: one line that is redrawn on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>
#include <string_view>

#if defined(_WIN32)
#include <io.h>
#else
#include <unistd.h>
#endif

namespace cli {

class progress_line {
public:
    explicit progress_line(bool is_quiet) : is_quiet_(is_quiet) {}
    progress_line(const progress_line&) = delete;
    progress_line& operator=(const progress_line&) = delete;
    ~progress_line() { clear(); }

    /// Says that `stage` has been done to `share`, 0 to 1.
    void operator()(std::string_view stage, double share) {
        if (is_quiet_) return;
        const auto now = clock::now();
        if (stage != stage_) {
            stage_ = stage;
            stage_start_ = now;
            last_ = {};
            quarters_ = 0;
            if (!is_terminal_) std::fprintf(stderr, "%s\n", stage_.c_str());
        }
        if (is_terminal_) {
            if (share < 1 && now - last_ < std::chrono::milliseconds(100)) return;
            last_ = now;
            const double passed = std::chrono::duration<double>(now - stage_start_).count();
            std::fprintf(stderr, "\r\033[K%-7s %3.0f %%", stage_.c_str(), share * 100);
            if (share > 0.05 && share < 1) {
                std::fprintf(stderr, "  %.0f s left", passed * (1 - share) / share);
            }
            std::fflush(stderr);
        } else if (const int quarters = static_cast<int>(share * 4);
                   quarters > quarters_ && quarters < 4) {
            quarters_ = quarters;
            std::fprintf(stderr, "%s %d %%\n", stage_.c_str(), quarters * 25);
        }
    }

    /// Takes the line off the terminal, so that results stand alone.
    void clear() {
        if (is_terminal_ && !stage_.empty()) std::fputs("\r\033[K", stderr);
        stage_.clear();
    }

private:
    using clock = std::chrono::steady_clock;

    [[nodiscard]] static bool stderr_is_terminal() {
#if defined(_WIN32)
        return _isatty(_fileno(stderr)) != 0;
#else
        return isatty(fileno(stderr)) != 0;
#endif
    }

    bool is_quiet_;
    bool is_terminal_ = stderr_is_terminal();
    std::string stage_{};
    clock::time_point stage_start_{};
    clock::time_point last_{};
    int quarters_ = 0;
};

}  // namespace cli
