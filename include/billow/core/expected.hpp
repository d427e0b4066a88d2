// A value or the reason why there is none: for what the outside world can get wrong.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include <billow/core/config.hpp>

namespace billow::inline BILLOW_ABI {

/// What went wrong, for programs; error::message says it to people.
enum class error_code {
    not_found,        ///< the file is missing or cannot be opened
    unwritable,       ///< the output cannot be created or written
    truncated,        ///< the file ends before what it announces
    malformed,        ///< the file breaks the rules of its format
    unsupported,      ///< the file is well formed, but uses a feature that billow does not read
    not_finite,       ///< a position is NaN or infinite
    out_of_range,     ///< an index or offset points outside of what it indexes
    too_large,        ///< a size is beyond what can be handled
    invalid_options,  ///< an option is outside of its range
};

/// The reason of a failure. `message` is one line that names the fault and, for files, the file.
struct error {
    error_code code{};
    std::string message;
};

/// A T, or the error that prevented it. Spelled as std::expected of C++23, but ours in every
/// language version, so that objects built with different ones agree on the type.
template <class T>
class expected {
public:
    expected(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    expected(billow::error why) : state_(std::in_place_index<1>, std::move(why)) {}

    [[nodiscard]] bool has_value() const noexcept { return state_.index() == 0; }
    [[nodiscard]] explicit operator bool() const noexcept { return has_value(); }

    /// Needs has_value().
    [[nodiscard]] T& value() & noexcept { return *checked(); }
    [[nodiscard]] const T& value() const& noexcept {
        return *const_cast<expected*>(this)->checked();
    }
    [[nodiscard]] T&& value() && noexcept { return std::move(*checked()); }
    [[nodiscard]] T& operator*() & noexcept { return *checked(); }
    [[nodiscard]] const T& operator*() const& noexcept { return value(); }
    [[nodiscard]] T&& operator*() && noexcept { return std::move(*checked()); }
    [[nodiscard]] T* operator->() noexcept { return checked(); }
    [[nodiscard]] const T* operator->() const noexcept { return &value(); }

    /// Needs !has_value().
    [[nodiscard]] const billow::error& error() const noexcept {
        BILLOW_ASSERT(!has_value());
        return *std::get_if<1>(&state_);
    }

private:
    T* checked() noexcept {
        BILLOW_ASSERT(has_value());
        return std::get_if<0>(&state_);
    }

    std::variant<T, billow::error> state_;
};

/// Stands for "done" where an operation has no value to give.
struct done {};

}  // namespace billow::inline BILLOW_ABI
