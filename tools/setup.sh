#!/bin/bash
# setup.sh [gidl|build|tests|test|fuzz|bench|wheels|format]...: brings a Debian 12, Debian 13 or Ubuntu 24.04 machine to
# where these parts of the Makefile run (none named: all of `make test`): apt packages that are missing, and a virtual
# environment in .venv that sees the tree itself. Run again at any time: with everything there it only looks.
set -euo pipefail
cd "$(dirname "$0")/.."

parts=           # that are wanted
packages=()      # name, or name~pattern: any package of the pattern will do, for names that differ by distribution
requirements=()  # files of tools/requirements
runtime=         # clang's libFuzzer is wanted, whose package is named after the version of clang

want() {
  case " $parts " in *" $1 "*) return 0 ;; esac
  parts+=" $1"
  case $1 in
    gidl)
      packages+=(python3 python3-venv)
      requirements+=(build)
      ;;
    build)
      want gidl
      packages+=(
        build-essential cmake ninja-build pkg-config python3-dev
        libeigen3-dev liborocos-kdl-dev liburdfdom-dev libexpected-dev libsodium-dev nlohmann-json3-dev
        libtomlplusplus-dev
        'libglib2.0-0~libglib2\.0-0(t64)?'
      )
      ;;
    tests)  # in C++ and Python, under any sanitizer of g++
      want build
      packages+=(libgtest-dev iproute2)
      requirements+=(tests)
      ;;
    clang)
      packages+=('clang~clang(-1[4-9]|-[2-9][0-9])?')
      ;;
    test)  # another compiler, another compiler of IDL, a big-endian machine
      want tests && want clang && want bench && want wheels && want format
      packages+=(omniidl g++-s390x-linux-gnu qemu-user)
      ;;
    fuzz)
      want tests && want clang
      runtime=yes
      ;;
    bench)
      want build
      packages+=(libbenchmark-dev)
      ;;
    wheels)
      want build
      requirements+=(wheels)
      ;;
    format)
      want gidl
      requirements+=(format)
      ;;
    *)
      echo "setup: there is no $1; name any of gidl, build, tests, test, fuzz, bench, wheels, format" >&2
      exit 2
      ;;
  esac
}

# Installs those of the packages that are missing.
install() {
  local installed wanted missing=() command as_root
  installed=$(dpkg-query -W -f='${db:Status-Abbrev}${binary:Package}\n' 2>/dev/null \
    | sed -n 's/^ii \([^:]*\).*/\1/p') || {
    echo "setup: this machine has no dpkg; it knows Debian 12, Debian 13 and Ubuntu 24.04." >&2
    echo "setup: elsewhere install the equivalents of: ${*%%~*}" >&2
    exit 1
  }
  for wanted; do
    case $wanted in
      *~*) grep -qxE "${wanted#*~}" <<<"$installed" ;;
      *) grep -qxF "$wanted" <<<"$installed" ;;
    esac || missing+=("${wanted%%~*}")
  done
  [ ${#missing[@]} -gt 0 ] || return 0

  command="apt-get install -y --no-install-recommends ${missing[*]}"
  if [ "$(id -u)" = 0 ]; then
    as_root=(env)
  elif command -v sudo >/dev/null && { sudo -n true 2>/dev/null || [ -t 0 ]; }; then
    as_root=(sudo env)
  else
    echo "setup: these packages are missing, and we are neither root nor have sudo: ${missing[*]}" >&2
    echo "setup: ask somebody who is to run:  apt-get update && $command" >&2
    exit 1
  fi
  echo "setup: apt-get update"
  "${as_root[@]}" apt-get update -q </dev/null
  echo "setup: apt-get install ${missing[*]} (minutes on a fresh machine)"
  # shellcheck disable=SC2086
  "${as_root[@]}" DEBIAN_FRONTEND=noninteractive $command </dev/null
}

for part in "${@:-test}"; do
  want "$part"
done
install "${packages[@]}"
if [ -n "$runtime" ]; then
  version=$(tools/clang.sh -dumpversion)
  install "libclang-rt-${version%%.*}-dev"
fi

# The distribution's own interpreter unless told otherwise: python3-dev above belongs to it.
python=${GECOS_PYTHON:-/usr/bin/python3}
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || {
  echo "setup: $python is older than Python 3.11; name a newer one:  GECOS_PYTHON=/path/to/python3 make setup" >&2
  exit 1
}

# .venv/robcl-setup says what the environment was made of; .venv/robcl-setup-tests that tests.txt is in it, and so on.
made_of=$(
  { pwd && "$python" -VV && cat tools/requirements/build.txt tools/link_tree.py pyproject.toml codegen/pyproject.toml; } \
    | sha256sum
)
if [ "$(cat .venv/robcl-setup 2>/dev/null)" != "$made_of" ]; then
  for stamp in .venv/robcl-setup-*; do  # what it held before it shall hold again
    [ ! -f "$stamp" ] || requirements+=("${stamp#.venv/robcl-setup-}")
  done
  echo "setup: a virtual environment in .venv, of $("$python" -V)"
  "$python" -m venv --clear .venv
fi

missing=()
for name in $(printf '%s\n' "${requirements[@]}" | sort -u); do
  file=tools/requirements/$name.txt
  if [ -f "$file" ] && [ "$(cat ".venv/robcl-setup-$name" 2>/dev/null)" != "$(sha256sum <"$file")" ]; then
    missing+=("$name")
  fi
done
if [ ${#missing[@]} -gt 0 ]; then
  files=("${missing[@]/#/tools/requirements/}")
  files=("${files[@]/%/.txt}")
  echo "setup: pip install $(sed -n 's/^\([A-Za-z][A-Za-z0-9_.-]*\).*/\1/p' "${files[@]}" | paste -sd ' ') (up to a minute)"
  .venv/bin/python -m pip install --quiet --disable-pip-version-check "${files[@]/#/--requirement=}" </dev/null
  for name in "${missing[@]}"; do
    sha256sum <"tools/requirements/$name.txt" >".venv/robcl-setup-$name"
  done
fi
if [ ! -f .venv/robcl-setup ]; then
  echo "setup: .venv sees the packages and commands of this tree"
  .venv/bin/python tools/link_tree.py
  echo "$made_of" >.venv/robcl-setup
  echo "setup: done"
fi
