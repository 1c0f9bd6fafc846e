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

if [ ! -x "$out/venv/bin/python" ] || ! "$out/venv/bin/python" -c 'import iceoryx2, numpy, puccinialin' 2>/dev/null; then
  "${GECOS_PYTHON:-/usr/bin/python3}" -m venv --clear "$out/venv" \
    && "$out/venv/bin/python" -m pip install --quiet --disable-pip-version-check \
      --requirement benchmarks/peers/requirements.txt </dev/null \
    || { say "NOT INSTALLED: iceoryx2 for Python"; rm -rf "$out/venv"; }
fi

# Debian's Rust is older than iceoryx2 takes: without a newer one a toolchain comes into the build folder.
enough=1.89
has_cargo() { command -v cargo >/dev/null && cargo --version | awk '{ print $2 }' | { cat; echo $enough; } | sort -CVr; }
if ! has_cargo && [ -d "$out/venv" ]; then
  say "a Rust toolchain (some 600 MB) into $build/peers/puccinialin"
  XDG_CACHE_HOME=$out "$out/venv/bin/python" -m puccinialin >"$out.rust.log" 2>&1 </dev/null || tail -5 "$out.rust.log" >&2
  export RUSTUP_HOME=$out/puccinialin/rustup CARGO_HOME=$out/puccinialin/cargo
  PATH=$CARGO_HOME/bin:$PATH
fi
if has_cargo; then
  CARGO_TARGET_DIR=$out/cargo cargo build --quiet --release --manifest-path benchmarks/peers/iceoryx2/Cargo.toml \
    || say "NOT BUILT: iceoryx2; cargo says above why"
else
  say "NOT BUILT: iceoryx2, for want of cargo, Rust $enough or newer (rustup has it)"
fi
