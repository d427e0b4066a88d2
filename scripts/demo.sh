#!/usr/bin/env bash
# Installs what is missing, builds the demo in build/demo and lets it write its clouds to out/.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_dependencies.sh
cmake -S . -B build/demo -DCMAKE_BUILD_TYPE=Release \
    -DBILLOW_BUILD_TESTS=OFF -DBILLOW_BUILD_BENCHMARKS=OFF
cmake --build build/demo --parallel "$(getconf _NPROCESSORS_ONLN)" --target billow_demo
build/demo/bin/billow_demo out
