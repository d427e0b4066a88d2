// billow: turns meshes into billboard clouds, on the command line.

#include <cstdio>
#include <exception>
#include <new>

#include <billow/core/config.hpp>

#include "verbs.hpp"

int main(int argc, char** argv) {
    CLI::App tool{
        "billow turns a mesh into a billboard cloud: a few textured planes that stand for it at a "
        "distance."};
    tool.set_version_flag("--version", "billow " BILLOW_VERSION " (" BILLOW_ABI_NAME ")");
    tool.require_subcommand(1);
    tool.set_config("--config", "",
                    "TOML file with the options of a verb in a section of its name, e.g. [build]")
        ->configurable(false);
    tool.fallthrough();
    tool.footer(
        "Run 'billow VERB --help' for the options of a verb.\n"
        "Exit codes: 0 done, 1 a file is at fault, 2 the options are.");

    cli::exit_code result = cli::success;
    cli::add_build(tool, result);
    cli::add_compare(tool, result);
    cli::add_inspect(tool, result);
    cli::add_lod(tool, result);
    cli::add_sweep(tool, result);
    cli::add_atlas(tool, result);
    try {
        tool.parse(argc, argv);
    } catch (const CLI::ParseError& fault) {
        return tool.exit(fault) == 0 ? cli::success : cli::bad_usage;
    } catch (const std::bad_alloc&) {
        std::fputs("billow: out of memory\n", stderr);
        return cli::bad_input;
    } catch (const std::exception& fault) {
        std::fprintf(stderr, "billow: %s\n", fault.what());
        return cli::bad_input;
    }
    return result;
}
