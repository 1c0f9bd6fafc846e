#!/bin/bash
# wheels.sh [--of-build]: builds the two wheels, gidl and robcl, into dist/ and uses them as a stranger would, in an
# environment that knows nothing of the tree.
#
# With --of-build, as a lane of `make test` runs it, nothing is compiled and no index is asked: robcl gets the extensions
# that the build has put into the tree, the wheels are thrown away, and numpy and the like are those of .venv.
set -euo pipefail
cd "$(dirname "$0")/.."
tree=$PWD
python=$tree/.venv/bin/python
stranger=$(mktemp -d)
trap 'rm -rf "$stranger"' EXIT

# A wheel of the folder $1. It asks no index: the build backends are in .venv, and a path has a slash.
wheel() {
  "$python" -m pip --disable-pip-version-check wheel --quiet --no-index --no-build-isolation --no-deps \
    --wheel-dir "$dist" "$@" </dev/null
}

if [ "${1-}" = --of-build ]; then
  dist=$stranger/dist
  extensions=(
    "--config-settings=cmake.source-dir=tools/wheel_of_build"
    "--config-settings=cmake.define.EXTENSIONS=$tree/runtime/python/gecos"
    "--config-settings=build-dir=$stranger/build"
  )
else
  dist=$tree/dist
  rm -rf "$dist"
  extensions=()
fi
cp -rL codegen "$stranger/codegen"  # setuptools would pack what an older build left beside the sources
wheel "$stranger/codegen"
wheel ./ "${extensions[@]}"
ls "$dist"

cd "$stranger"
"$python" -m venv --without-pip env
into_env=("$python" -m pip --disable-pip-version-check --python env/bin/python install --quiet)
if [ "${1-}" = --of-build ]; then
  "$python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))' >"$(env/bin/python -c '
import sysconfig
print(sysconfig.get_path("purelib"))')/borrowed.pth"
  into_env+=(--no-index)
fi
"${into_env[@]}" "$dist"/*.whl </dev/null

# What the extensions want of the system, and nothing else.
extensions=$(find env -path '*/gecos/*.so')
# shellcheck disable=SC2086  # several
foreign=$(readelf -d $extensions | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' \
  | grep -vE '^(libsodium\.so\.23|libglib-2\.0\.so\.0|libstdc\+\+\.so\.6|libgcc_s\.so\.1|libm\.so\.6|libc\.so\.6|ld-linux.*)$' || true)
if [ -n "$foreign" ]; then
  echo "wheels: what is in gecos needs libraries that nobody was told of: $foreign" >&2
  exit 1
fi

cp "$tree/tools/use_wheels.py" .
env/bin/python use_wheels.py
