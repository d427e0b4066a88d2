#!/usr/bin/env python3
"""Checks what every header of include/billow promises.

- It includes only its own folder and lower layers.
- Third parties are included only where they belong.
- billow.hpp reaches it, or io.hpp or reduce.hpp what stays apart.
- It starts with a word on what it is and has #pragma once.

    check_headers.py             checks
    check_headers.py --umbrella  writes billow.hpp anew, from the layers below
"""

import pathlib
import re
import sys

INCLUDE = pathlib.Path(__file__).resolve().parent.parent / "include"

# The house, from the ground up. A folder that is not here has no place yet: add it.
LAYERS = [
    ["core"],
    ["geometry"],
    ["image"],
    ["mesh"],
    ["plane_space", "fit", "plants", "shapes"],
    ["policy"],
    ["density", "cloud"],
    ["search"],
    ["improve"],
    ["bake"],
    ["metrics", "io", "reduce"],
    ["pipeline"],
    ["lod", "presets"],
    ["billow"],
]

# Not in billow.hpp, for what they include is no part of billow::billow.
APART = ["io", "reduce"]

# What is included, and who alone may do so.
RESERVED = {
    r"immintrin\.h|arm_neon\.h": r"core/simd\.hpp",
    r"omp\.h": r"core/parallel\.hpp",
    r"Eigen/.*": r"fit/.*",
    r"tiny_.*|stb_image.*|nlohmann/.*": r"io/.*|io\.hpp",
    r"libdeflate\.h": r"io/png_file\.hpp",
    r"meshoptimizer\.h": r"reduce\.hpp",
}

ANY_INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)


def folder(name):
    """Where a header belongs: "mesh" of "mesh/mesh.hpp", "pipeline" of "pipeline.hpp" too."""
    return name.split("/")[0].removesuffix(".hpp")


def layer(name):
    """Height of a header such as "mesh/mesh.hpp", or None where its folder has no place."""
    return next((i for i, row in enumerate(LAYERS) if folder(name) in row), None)


def faults_of(name, text, includes):
    if not text.startswith("//"):
        yield "does not start with a comment that says what it is"
    if "\n#pragma once\n" not in text:
        yield "lacks #pragma once"
    if layer(name) is None:
        yield f"is in a folder without a layer, see {pathlib.Path(__file__).name}"
        return
    for other in includes:
        for pattern, home in RESERVED.items():
            if re.fullmatch(pattern, other) and not re.fullmatch(home, name):
                yield f"includes <{other}>, which belongs to {home} alone"
        if not other.startswith("billow/"):
            continue
        other = other.removeprefix("billow/")
        is_neighbour = folder(other) == folder(name)
        if not (INCLUDE / "billow" / other).exists():
            yield f"includes {other}, which does not exist"
        elif name != "io.hpp" and not is_neighbour and (layer(other) or 0) >= layer(name):
            yield f"includes {other}, which is not in a lower layer"


def reached(includes, name, seen):
    if name in includes and name not in seen:
        seen.add(name)
        for other in includes[name]:
            reached(includes, other.removeprefix("billow/"), seen)
    return seen


def umbrella(names):
    """The text of billow.hpp: every header but those apart, a block for each folder."""
    blocks = ["// All of billow but the reading and writing of files, which is in io.hpp.\n"
              "#pragma once"]
    for home in (home for row in LAYERS for home in row if home not in APART and home != "billow"):
        block = [f"#include <billow/{name}>" for name in names if folder(name) == home]
        if block:
            blocks.append("\n".join(block))
    return "\n\n".join(blocks) + "\n"


def main():
    root = INCLUDE / "billow"
    if sys.argv[1:] == ["--umbrella"]:
        names = sorted(p.relative_to(root).as_posix() for p in root.rglob("*.hpp"))
        (root / "billow.hpp").write_text(umbrella(names), encoding="utf-8", newline="\n")
    elif sys.argv[1:]:
        sys.exit(__doc__)
    texts = {p.relative_to(root).as_posix(): p.read_text(encoding="utf-8")
             for p in sorted(root.rglob("*.hpp"))}
    includes = {name: ANY_INCLUDE.findall(text) for name, text in texts.items()}
    faults = [f"{name} {fault}" for name, text in texts.items()
              for fault in faults_of(name, text, includes[name])]

    seen = reached(includes, "billow.hpp", set())
    faults += [f"billow.hpp reaches {name}, which stays apart"
               for name in sorted(seen) if folder(name) in APART]
    for home in APART:
        reached(includes, f"{home}.hpp", seen)
    for name in texts:
        if name not in seen:
            home = "io.hpp" if name.startswith("io/") else "billow.hpp"
            faults.append(f"{home} lacks #include <billow/{name}>")

    print("\n".join(faults) or f"{len(texts)} headers are in order")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
