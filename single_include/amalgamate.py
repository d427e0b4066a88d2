#!/usr/bin/env python3
"""Joins the headers of billow into single_include/billow.hpp and billow_io.hpp.

    amalgamate.py           writes both files
    amalgamate.py --check   writes nothing, fails when a file is not what it would write

Own includes are followed depth first, each file once; all others stay where they stand. The same
headers give the same bytes.
"""

import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
INCLUDE = HERE.parent / "include"
OWN_INCLUDE = re.compile(r'\s*#\s*include\s*[<"](billow/[^>"]+)[>"]')


def join(name, seen, path=()):
    """The lines of header `name` and of all that it includes and that is not in `seen` yet."""
    if name in path:
        sys.exit("circle of includes: " + " -> ".join((*path, name)))
    if name in seen:
        return []
    seen.add(name)
    lines = [f"// ---- {name}"]
    depth = 0  # of #if
    for line in (INCLUDE / name).read_text(encoding="utf-8").splitlines():
        own = OWN_INCLUDE.match(line)
        depth += bool(re.match(r"\s*#\s*if", line)) - bool(re.match(r"\s*#\s*endif", line))
        if own and depth:
            sys.exit(f"{name}: includes {own[1]} under #if, the joined file could lose it")
        if own:
            lines += join(own[1], seen, (*path, name))
        elif line.strip() != "#pragma once":
            lines.append(line)
    return lines


def joined_files():
    """What each joined file should hold. The second one stands on the first."""
    seen = set()
    files = {}
    for umbrella, output, first in [
        ("billow/billow.hpp", "billow.hpp", []),
        ("billow/io.hpp", "billow_io.hpp", ['#include "billow.hpp"', ""]),
    ]:
        if (INCLUDE / umbrella).exists():
            head = ["// Generated from include/billow by amalgamate.py, do not edit.",
                    "#pragma once", "", *first]
            files[HERE / output] = "\n".join(head + join(umbrella, seen)) + "\n"
    return files


def main():
    check = sys.argv[1:] == ["--check"]
    if sys.argv[1:] and not check:
        sys.exit(__doc__)
    stale = []
    for file, text in joined_files().items():
        if file.exists() and file.read_text(encoding="utf-8") == text:
            continue
        if check:
            stale.append(file.name)
        else:
            file.write_text(text, encoding="utf-8", newline="\n")
            print("wrote", file.name)
    if stale:
        sys.exit(f"stale: {', '.join(stale)}; run python3 single_include/amalgamate.py")


if __name__ == "__main__":
    main()
