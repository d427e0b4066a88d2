// The turtle that walks a word of plants/grammar.hpp through space.
//
// Prusinkiewicz, Lindenmayer, "The Algorithmic Beauty of Plants", 1990, sections 1.5 to 1.7.
//
//   F f       go forward, drawing a segment / without a trace    L      grow a leaf
//   + -       turn left / right, about the upper side            [ ]    remember / return
//   & ^       pitch down / up, about the left side               "      shrink the step
//   / \ > <   roll right / left / right / left, about the heading; the forest paper uses > and
//             leaves its meaning open
//   |         turn around
//   $         roll until the left side is level, so that + and - turn along the horizon
//
// Other symbols say nothing. A number behind a symbol replaces its angle in degrees (turns), or
// multiplies its length (F f), size (L) or step (").
#pragma once

#include <cmath>
#include <string_view>
#include <utility>

#include <billow/core/random.hpp>
#include <billow/plants/grammar.hpp>
#include <billow/plants/skeleton.hpp>

namespace billow::inline BILLOW_ABI {

struct turtle_options {
    double step = 1;           ///< length of F, in scene units
    double shrink = 0.8;       ///< factor of "
    double angle_deg = 25;     ///< of a turn without a number
    double angle_jitter = 0;   ///< turns differ by up to this share of themselves
    double length_jitter = 0;  ///< segments differ by up to this share of their length
    double wander_deg = 0;     ///< a segment strays by up to this angle from its heading
    dvec3 tropism{0};          ///< segments bend this way; its length is the angle in radians at
                               ///< which a segment across it bends (light: +y, weight: -y)
};

namespace detail {

/// `vector` turned about the unit `axis`.
[[nodiscard]] inline dvec3 rotated(const dvec3& vector, const dvec3& axis, double angle) noexcept {
    const double c = std::cos(angle), s = std::sin(angle);
    return vector * c + glm::cross(axis, vector) * s + axis * (glm::dot(axis, vector) * (1 - c));
}

/// The frame is made orthonormal again: rotating about axes of a length that is not quite 1, one
/// after the other, triples the error every time.
[[nodiscard]] inline frame rotated(const frame& f, const dvec3& axis, double angle) noexcept {
    const dvec3 normal = glm::normalize(rotated(f.normal, axis, angle));
    const dvec3 u = rotated(f.u, axis, angle);
    const dvec3 left = glm::normalize(u - normal * glm::dot(normal, u));
    return {.u = left, .v = glm::cross(normal, left), .normal = normal};
}

/// The decimal number `text`, whatever the locale. Anything else is NaN.
[[nodiscard]] inline double parse_decimal(std::string_view text) noexcept {
    const bool is_negative = text.starts_with('-');
    if (is_negative || text.starts_with('+')) text.remove_prefix(1);
    double value = 0, unit = 0;
    bool has_digit = false;
    for (const char c : text) {
        if (c == '.' && unit == 0) {
            unit = 1;
        } else if (c >= '0' && c <= '9') {
            has_digit = true;
            value = value * 10 + (c - '0');
            unit *= 10;
        } else {
            return std::nan("");
        }
    }
    if (!has_digit) return std::nan("");
    if (unit > 0) value /= unit;
    return is_negative ? -value : value;
}

/// Reads one word. Random numbers come from (seed, position in the word).
class turtle {
public:
    turtle(std::string_view word, const turtle_options& options, std::uint64_t seed)
        : word_(word), options_(options), seed_(seed) {}

    [[nodiscard]] expected<skeleton> walk() {
        for (std::size_t i = 0; i < word_.size(); ++i) {
            position_ = i;
            const char symbol = word_[i];
            double number = std::nan("");
            if (i + 1 < word_.size() && word_[i + 1] == '(') {
                const std::size_t close = word_.find(')', i);
                number = parse_decimal(word_.substr(i + 2, close - i - 2));
                if (std::isnan(number)) {
                    return error{error_code::malformed,
                                 "no number in the parentheses at position " +
                                     std::to_string(i + 1) + " of the plant's word"};
                }
                i = close;
            }
            obey(symbol, number);
        }
        return std::move(bones_);
    }

private:
    struct state {
        dvec3 position{0};
        frame axes{.u = {-1, 0, 0}, .v = {0, 0, 1}, .normal = {0, 1, 0}};
        double step = 1;
        std::uint32_t segment = no_id;
    };

    void obey(char symbol, double number) {
        frame& f = now_.axes;
        const auto turn = [&](const dvec3& axis, double sign) {
            const double degrees = std::isnan(number) ? options_.angle_deg : number;
            f = rotated(f, axis, sign * radians(degrees) * (1 + options_.angle_jitter * jitter(0)));
        };
        const double factor = std::isnan(number) ? 1 : number;
        switch (symbol) {
            case '+':
                turn(f.v, 1);
                break;
            case '-':
                turn(f.v, -1);
                break;
            case '&':
                turn(f.u, 1);
                break;
            case '^':
                turn(f.u, -1);
                break;
            case '/':
            case '>':
                turn(f.normal, 1);
                break;
            case '\\':
            case '<':
                turn(f.normal, -1);
                break;
            case '|':
                f = {.u = -f.u, .v = f.v, .normal = -f.normal};
                break;
            case '$':
                level();
                break;
            case '"':
                now_.step *= std::isnan(number) ? options_.shrink : number;
                break;
            case '[':
                stack_.push_back(now_);
                break;
            case ']':
                now_ = stack_.back();
                stack_.pop_back();
                break;
            case 'F':
            case 'f':
                go(factor, symbol == 'F');
                break;
            case 'L':
                grow_leaf(factor);
                break;
            default:
                break;
        }
    }

    void go(double factor, bool draws) {
        frame& f = now_.axes;
        // The first segment of a root goes straight up, so that it stands flat on the ground.
        const double stray = now_.segment == no_id ? 0 : radians(options_.wander_deg);
        f = rotated(f, f.u, stray * jitter(1));
        f = rotated(f, f.v, stray * jitter(2));
        const dvec3 bend = glm::cross(f.normal, options_.tropism);
        const double angle = glm::length(bend);  // |tropism| sin of the angle to it
        if (angle > 1e-12) f = rotated(f, bend / angle, angle);
        const double length =
            options_.step * now_.step * factor * (1 + options_.length_jitter * jitter(3));
        if (!(length > 0)) return;
        const dvec3 end = now_.position + f.normal * length;
        if (draws) {
            bones_.parents.push_back(now_.segment);
            bones_.starts.push_back(now_.position);
            bones_.ends.push_back(end);
            bones_.frames.push_back(f);
            now_.segment = static_cast<std::uint32_t>(bones_.segment_count() - 1);
        } else {
            now_.segment = no_id;
        }
        now_.position = end;
    }

    /// A leaf with no segment to hang on is not grown.
    void grow_leaf(double factor) {
        if (now_.segment == no_id) return;
        bones_.leaf_segments.push_back(now_.segment);
        bones_.leaf_frames.push_back(now_.axes);
        bones_.leaf_scales.push_back(static_cast<float>(factor));
    }

    void level() {
        frame& f = now_.axes;
        const dvec3 left = glm::cross(dvec3(0, 1, 0), f.normal);
        const double length = glm::length(left);
        if (length < 1e-6) return;  // upright: every left side is level
        f.u = left / length;
        f.v = glm::cross(f.normal, f.u);
    }

    [[nodiscard]] static double radians(double degrees) noexcept {
        return degrees * (3.14159265358979323846 / 180);
    }

    /// One of four numbers in [-1, 1) that belong to the symbol.
    [[nodiscard]] double jitter(std::size_t which) const noexcept {
        return 2 * random_unit(seed_, 4 * position_ + which) - 1;
    }

    std::string_view word_;
    const turtle_options& options_;
    std::uint64_t seed_;
    std::size_t position_ = 0;
    state now_{};
    std::vector<state> stack_{};
    skeleton bones_{};
};

}  // namespace detail

/// The skeleton that `word` plans, standing on the origin and growing towards +y; radii are left
/// to assign_radii.
///
/// Fails   malformed: a bracket without partner, a number that is none; invalid_options: a length
///         or an angle that is not finite, or a step or shrink of zero or less.
/// Cost    O(length of the word).
[[nodiscard]] inline expected<skeleton> interpret(std::string_view word,
                                                  const turtle_options& options = {},
                                                  std::uint64_t seed = 1) {
    if (auto fine = check_brackets(word); !fine) return fine.error();
    const double sum = options.step + options.shrink + options.angle_deg + options.angle_jitter +
                       options.length_jitter + options.wander_deg + options.tropism.x +
                       options.tropism.y + options.tropism.z;
    if (!std::isfinite(sum) || options.step <= 0 || options.shrink <= 0) {
        return error{error_code::invalid_options,
                     "the turtle's step and shrink must be above zero, and all numbers finite"};
    }
    return detail::turtle(word, options, seed).walk();
}

}  // namespace billow::inline BILLOW_ABI
