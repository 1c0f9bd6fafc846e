#!/bin/bash
# build_release.sh <folder> [target...]: as fast as it gets, by link-time optimisation and by a profile of calls that the
# programs of benchmarks/peers record first, in the same folder. All that is installed, or the targets.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$1
shift
jobs=${JOBS:-$(nproc)}
configure=(tools/configure.sh "$folder" "${BUILD_TYPE:-RelWithDebInfo}" -DGECOS_LTO=ON -DBUILD_TESTING=OFF)

# A profile is good for the very source that recorded it.
source=$(find CMakeLists.txt cmake idl codegen generated/cpp runtime/cpp benchmarks -type f ! -name '*.pyc' -print0 \
  | sort -z | xargs -0 sha256sum | sha256sum)
if [ "$(cat "$folder/recorded-for" 2>/dev/null)" != "$source" ]; then
  rm -rf "$folder/profile"
  "${configure[@]}" -DGECOS_PROFILE=record
  cmake --build "$folder" -j"$jobs" --target gecos_peer
  .venv/bin/python benchmarks/peers/record_profile.py --build "$folder"
  echo "$source" >"$folder/recorded-for"
fi
"${configure[@]}" -DGECOS_PROFILE=use
cmake --build "$folder" -j"$jobs" ${1:+--target "$@"}
