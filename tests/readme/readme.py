#!/usr/bin/env python3
"""Takes README.md at its word.

    readme.py project FOLDER     writes main.cpp and CMakeLists.txt, the README's blocks of these kinds
    readme.py commands FOLDER    runs the blocks of kind sh in FOLDER, in order, as one script
    readme.py links              checks that every file that the README points to exists

A block that starts with ```sh and one more word installs or builds: it is not run here, but the
scripts and presets that it names must exist.
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
FENCE = re.compile(r"^```([^\n]+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(kind):
    found = [text for name, text in FENCE.findall(README) if name == kind]
    return found or sys.exit(f"README.md has no block of kind {kind}")


def project(folder):
    folder.mkdir(parents=True, exist_ok=True)
    for kind, file in [("cpp", "main.cpp"), ("cmake", "CMakeLists.txt")]:
        if len(blocks(kind)) != 1:
            sys.exit(f"README.md has more than one block of kind {kind}; which is the program's?")
        (folder / file).write_text(blocks(kind)[0], encoding="utf-8", newline="\n")


def commands(folder):
    script = "set -eux\n" + "".join(blocks("sh"))
    sys.exit(subprocess.run(["sh"], input=script, text=True, cwd=folder).returncode)


def links():
    faults = []
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)|src=\"([^\":]+)\"", README):
        faults += [f"{file} does not exist" for file in target
                   if file and not (ROOT / file).exists()]
    presets = json.loads((ROOT / "CMakePresets.json").read_text())["configurePresets"]
    names = {preset["name"] for preset in presets}
    for kind, text in FENCE.findall(README):
        if kind.startswith("sh "):
            faults += [f"{file} does not exist" for file in re.findall(r"scripts/\S+", text)
                       if not (ROOT / file).exists()]
            faults += [f"there is no preset {name}" for name in re.findall(r"--preset (\S+)", text)
                       if name not in names]
    for header in re.findall(r"`((?:[a-z_]+/)*[a-z_]+\.hpp)`", README):
        if not (ROOT / header).exists() and not (ROOT / "include/billow" / header).exists():
            faults.append(f"there is no header {header}")
    print("\n".join(faults) or "every link leads somewhere")
    sys.exit(bool(faults))


if __name__ == "__main__":
    if sys.argv[1:] == ["links"]:
        links()
    elif len(sys.argv) == 3 and sys.argv[1] in ("project", "commands"):
        {"project": project, "commands": commands}[sys.argv[1]](pathlib.Path(sys.argv[2]))
    else:
        sys.exit(__doc__)
