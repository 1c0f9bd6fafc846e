#!/bin/bash
# Brings a Debian 12 or Ubuntu 24.04 machine to where this tree builds: apt packages that are missing, and a virtual
# environment in .venv that sees the tree itself. Run again at any time: with everything there it only looks.
set -euo pipefail
cd "$(dirname "$0")/.."

# What the C++ is built with, and the interpreter; a big-endian machine for tests. a|b: either will do (Ubuntu 24.04
# renamed some).
packages=(
  build-essential clang-14 clang-format-14 cmake ninja-build pkg-config omniidl
  python3 python3-venv python3-dev
  libeigen3-dev liborocos-kdl-dev liburdfdom-dev libexpected-dev libsodium-dev nlohmann-json3-dev
  "libglib2.0-0|libglib2.0-0t64"
  libgtest-dev libbenchmark-dev
  g++-s390x-linux-gnu qemu-user
)

installed=$(dpkg-query -W -f='${db:Status-Abbrev}${binary:Package}\n' 2>/dev/null \
  | sed -n 's/^ii \([^:]*\).*/\1/p') || {
  echo "setup: this machine has no dpkg; it knows Debian 12 and Ubuntu 24.04." >&2
  echo "setup: elsewhere install the equivalents of: ${packages[*]}" >&2
  exit 1
}
missing=()
for wanted in "${packages[@]}"; do
  found=
  for name in ${wanted//|/ }; do
    grep -qxF "$name" <<<"$installed" && found=yes
  done
  [ -n "$found" ] || missing+=("${wanted%%|*}")
done

if [ ${#missing[@]} -gt 0 ]; then
  install="apt-get install -y --no-install-recommends ${missing[*]}"
  if [ "$(id -u)" = 0 ]; then
    as_root=(env)
  elif command -v sudo >/dev/null && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
    as_root=(sudo env)
  else
    echo "setup: these packages are missing, and we are neither root nor have sudo: ${missing[*]}" >&2
    echo "setup: ask somebody who is to run:  apt-get update && $install" >&2
    exit 1
  fi
  echo "setup: apt-get update"
  "${as_root[@]}" apt-get update -q </dev/null
  echo "setup: apt-get install ${missing[*]} (minutes on a fresh machine)"
  # shellcheck disable=SC2086
  "${as_root[@]}" DEBIAN_FRONTEND=noninteractive $install </dev/null
fi

# The distribution's own interpreter unless told otherwise: python3-dev above belongs to it.
python=${GECOS_PYTHON:-/usr/bin/python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || {
  echo "setup: $python is older than Python 3.11; name a newer one:  GECOS_PYTHON=/path/to/python3 make setup" >&2
  exit 1
}

stamp=.venv/robcl-setup
now=$(
  { pwd && "$python" -VV && cat tools/setup.sh tools/requirements.txt tools/link_tree.py pyproject.toml codegen/pyproject.toml; } \
    | sha256sum
)
if [ -f "$stamp" ] && [ "$(cat "$stamp")" = "$now" ]; then
  exit 0
fi

echo "setup: a virtual environment in .venv, of $("$python" -V)"
"$python" -m venv --clear .venv
packages_of_python=$(sed -n 's/^\([A-Za-z][A-Za-z0-9_.-]*\).*/\1/p' tools/requirements.txt | paste -sd ' ')
echo "setup: pip install $packages_of_python (about a minute)"
.venv/bin/python -m pip install --quiet --disable-pip-version-check --requirement tools/requirements.txt </dev/null
echo "setup: .venv sees the packages and commands of this tree"
.venv/bin/python tools/link_tree.py
echo "$now" >"$stamp"
echo "setup: done"
