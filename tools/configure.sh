#!/bin/bash
# configure.sh <build folder> <build type> [cmake arguments]: configures once, and again only when asked for something
# that the folder was not configured for. CMake itself looks at its own files when it builds. What is not named keeps its
# value: `make demo` after `make test` leaves the tests of the folder configured.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$1
type=$2
shift 2

arguments=(-S . -B "$folder" -G Ninja "-DCMAKE_BUILD_TYPE=$type" "-DPython_EXECUTABLE=$PWD/.venv/bin/python" "$@")
if [ "${GECOS_WERROR:-${CI:+ON}}" = ON ]; then
  arguments+=(-DGECOS_WERROR=ON)  # compilers that nobody tried may warn of something new
fi
if command -v ccache >/dev/null; then
  arguments+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
asked=$(printf '%s\n' "${arguments[@]}" "$(cat .venv/robcl-setup)" "$(sha256sum <CMakePresets.json)")
if [ -f "$folder/build.ninja" ] && [ -f "$folder/configured-for" ] && ! grep -qvxFf "$folder/configured-for" <<<"$asked"; then
  exit 0
fi
cmake "${arguments[@]}"
echo "$asked" >"$folder/configured-for"
