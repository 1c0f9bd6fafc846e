#!/bin/bash
# setup.sh <build folder>: what the peers of `make bench-peers` need, and their programs into <build folder>/peers.
# What cannot be had here is named and left out; bench_peers.py then finds no program and says so.
set -uo pipefail
cd "$(dirname "$0")/../.."
build=$1
out=$PWD/$build/peers

packages=(libomniorb4-dev omniidl libzeroc-ice-dev zeroc-ice-compilers capnproto libcapnp-dev libiceoryx-posh-dev)
say() { echo "bench-peers: $*" >&2; }

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${db:Status-Abbrev}' "$package" 2>/dev/null | grep -q '^ii' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  if [ "$(id -u)" = 0 ]; then
    as_root=(env)
  else
    as_root=(sudo -n env)
  fi
  say "apt-get install ${missing[*]}"
  "${as_root[@]}" apt-get update -q </dev/null
  for package in "${missing[@]}"; do  # one by one: a machine that lacks one may have the others
    "${as_root[@]}" DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$package" </dev/null \
      || say "NOT INSTALLED: $package; ask somebody who is root to run: apt-get install $package"
  done
fi

cmake -S benchmarks/peers -B "$out" -G Ninja >"$out.log" 2>&1 && cmake --build "$out" -- -k 0 \
  || say "NOT ALL of the peers in C++ could be built; see $out.log"

if command -v cargo >/dev/null; then
  CARGO_TARGET_DIR=$out/cargo cargo build --quiet --release --manifest-path benchmarks/peers/iceoryx2/Cargo.toml \
    || say "NOT BUILT: iceoryx2; cargo says above why"
else
  say "NOT BUILT: iceoryx2, for want of cargo, Rust 1.89 or newer (rustup has it)"
fi

if [ ! -x "$out/venv/bin/python" ] || ! "$out/venv/bin/python" -c 'import iceoryx2' 2>/dev/null; then
  "${GECOS_PYTHON:-/usr/bin/python3}" -m venv --clear "$out/venv" \
    && "$out/venv/bin/python" -m pip install --quiet --disable-pip-version-check \
      --requirement benchmarks/peers/requirements.txt </dev/null \
    || { say "NOT INSTALLED: iceoryx2 for Python"; rm -rf "$out/venv"; }
fi
