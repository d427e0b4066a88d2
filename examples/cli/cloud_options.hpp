// The options that say how a cloud is made, for every verb that makes one.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "recipe.hpp"

namespace cli {

/// Options of a verb. What the user gives changes a recipe, in the order of the help.
class cloud_options {
public:
    explicit cloud_options(CLI::App& verb);

    /// The recipe that the given options make. Throws CLI::ValidationError.
    [[nodiscard]] recipe make_recipe() const;

private:
    /// Adds an option; `apply(recipe&, value)` is called when it is given. `shown` is the default in
    /// the help.
    template <class T, class Apply>
    CLI::Option* add(const std::string& name, const std::string& shown, const std::string& help,
                     Apply apply) {
        auto value = std::make_shared<T>();
        CLI::Option* option = verb_.add_option(name, *value, help)->default_str(shown);
        option->group(group_);
        changes_.emplace_back([option, value, apply](recipe& how) {
            if (option->count() > 0) apply(how, *value);
        });
        return option;
    }
    template <class Apply>
    void add_flag(const std::string& name, const std::string& help, Apply apply) {
        auto value = std::make_shared<bool>(false);
        verb_.add_flag(name, *value, help)->group(group_);
        changes_.emplace_back([value, apply](recipe& how) {
            if (*value) apply(how);
        });
    }

    void add_plane_options();
    void add_texture_options();

    CLI::App& verb_;
    std::string group_{};
    std::vector<std::function<void(recipe&)>> changes_{};
};

}  // namespace cli
