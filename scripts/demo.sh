#!/usr/bin/env bash
# Installs what is missing, builds the demo and the tool in build/demo, and lets the demo write its
# clouds to out/.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_dependencies.sh
cmake -S . -B build/demo -DCMAKE_BUILD_TYPE=Release \
    -DBILLOW_BUILD_TESTS=OFF -DBILLOW_BUILD_BENCHMARKS=OFF
cmake --build build/demo --parallel "$(getconf _NPROCESSORS_ONLN)" \
    --target billow_demo billow_cli
build/demo/bin/billow_demo out

cat <<END

In $PWD/out:
  teapot.png  tree.png                    original on the left, cloud on the right
  teapot_cloud.glb  tree_cloud.glb        the clouds, for any viewer of glTF 2.0
  teapot.glb  tree.glb                    the originals
  teapot_atlas.png  tree_atlas.png        the textures

For a mesh of your own:
  build/demo/bin/billow build INPUT.glb -o OUTPUT.glb
END
