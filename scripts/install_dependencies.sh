#!/usr/bin/env bash
# Installs what billow is built with: by apt-get on Debian and Ubuntu, where something is missing.
# Elsewhere it says what to install and goes on.
set -euo pipefail

packages=(
    g++ make cmake python3
    libglm-dev libeigen3-dev libstb-dev
    libtinygltf-dev nlohmann-json3-dev libtinyobjloader-dev libmeshoptimizer-dev
    libdeflate-dev
    libcli11-dev doctest-dev libbenchmark-dev
)
# At home the tests of the glTF validator and of pages are skipped without node or Chromium, in CI
# they may not be.
if [ -n "${CI:-}" ] && ! command -v npm >/dev/null; then
    packages+=(nodejs npm)
fi
if [ -n "${CI:-}" ] && ! command -v chromium-browser google-chrome-stable google-chrome >/dev/null; then
    packages+=(chromium)
fi

if ! command -v apt-get >/dev/null; then
    echo "billow needs a C++20 compiler, CMake 3.25, Python 3.8 and these packages:"
    echo "  brew install cmake libomp glm eigen nlohmann-json meshoptimizer libdeflate cli11 \
doctest google-benchmark"
    echo "  vcpkg install stb tinygltf tinyobjloader   (with brew for the others), or all of it:"
    echo "  vcpkg install glm eigen3 stb tinygltf nlohmann-json tinyobjloader meshoptimizer \
libdeflate cli11 doctest benchmark"
    echo "For vcpkg set CMAKE_TOOLCHAIN_FILE in the environment to its vcpkg.cmake."
    exit 0
fi

missing=()
for package in "${packages[@]}"; do
    # A compiler or CMake from elsewhere is as good as the package.
    if ! dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed &&
        ! command -v "$package" >/dev/null; then
        missing+=("$package")
    fi
done
if [ ${#missing[@]} -eq 0 ]; then
    exit 0
fi

echo "Installing ${missing[*]}"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo)
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -qq --no-install-recommends "${missing[@]}"
