#!/bin/bash
# build_release.sh <folder> [target...]: as fast as it gets, by link-time optimisation and by a profile of calls that is
# recorded first, with the programs of benchmarks/peers. All that is installed, or the targets.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$1
shift
type=${BUILD_TYPE:-RelWithDebInfo}
common=(-DGECOS_LTO=ON -DBUILD_TESTING=OFF "-DGECOS_PROFILE_DIR=$PWD/$folder/profile")

tools/configure.sh "$folder/recording" "$type" "${common[@]}" -DGECOS_PROFILE=record
cmake --build "$folder/recording" -j"${JOBS:-$(nproc)}" --target gecos_peer
.venv/bin/python benchmarks/peers/record_profile.py --build "$folder/recording"

tools/configure.sh "$folder" "$type" "${common[@]}" -DGECOS_PROFILE=use
cmake --build "$folder" -j"${JOBS:-$(nproc)}" ${1:+--target "$@"}
