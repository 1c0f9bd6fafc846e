#!/bin/bash
# configure.sh <build folder> <build type> [cmake arguments]: configures once, and again only when asked for something
# else. CMake itself looks at its own files when it builds.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$1
type=$2
shift 2

arguments=(-S . -B "$folder" -G Ninja "-DCMAKE_BUILD_TYPE=$type" "-DPython_EXECUTABLE=$PWD/.venv/bin/python" "$@")
if command -v ccache >/dev/null; then
  arguments+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
asked="${arguments[*]} $(cat .venv/robcl-setup)"
if [ -f "$folder/build.ninja" ] && [ "$(cat "$folder/configured-for" 2>/dev/null)" = "$asked" ]; then
  exit 0
fi
cmake "${arguments[@]}"
echo "$asked" >"$folder/configured-for"
