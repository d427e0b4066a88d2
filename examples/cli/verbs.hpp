// The verbs of the tool, one file each.
#pragma once

#include <CLI/CLI.hpp>

namespace cli {

/// What the tool gives back to its caller.
enum exit_code : int {
    success = 0,
    bad_input = 1,  ///< a file that cannot be read, used or written
    bad_usage = 2,  ///< options that make no sense
};

/// Adds a verb to the tool. When it is called, `result` becomes its exit code.
void add_build(CLI::App& tool, exit_code& result);
void add_compare(CLI::App& tool, exit_code& result);
void add_inspect(CLI::App& tool, exit_code& result);
void add_lod(CLI::App& tool, exit_code& result);
void add_sweep(CLI::App& tool, exit_code& result);
void add_atlas(CLI::App& tool, exit_code& result);

}  // namespace cli
