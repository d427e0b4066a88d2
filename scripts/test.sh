#!/usr/bin/env bash
# Installs what is missing, builds billow in build/test and runs every test.
set -euo pipefail
cd "$(dirname "$0")/.."

cores=$(getconf _NPROCESSORS_ONLN)

scripts/install_dependencies.sh
cmake -S . -B build/test -DCMAKE_BUILD_TYPE=Release
cmake --build build/test --parallel "$cores"
ctest --test-dir build/test --output-on-failure --parallel "$cores"
