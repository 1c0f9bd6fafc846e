#!/bin/bash
# Builds the two wheels, gidl and robcl, and uses them as a stranger would: in an environment that knows nothing of the tree.
set -euo pipefail
cd "$(dirname "$0")/.."
python=$PWD/.venv/bin/python

rm -rf dist
for project in codegen .; do
  "$python" -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist "$project" </dev/null
done
ls dist

stranger=$(mktemp -d)
trap 'rm -rf "$stranger"' EXIT
/usr/bin/env -C "$stranger" "$python" -m venv env
cp examples/01_read_distance/client.py "$stranger"
cd "$stranger"
env/bin/python -m pip install --quiet --disable-pip-version-check "$OLDPWD"/dist/*.whl </dev/null

# What the extensions want of the system, and nothing else.
extensions=$(find env -path '*/gecos/*.so')
# shellcheck disable=SC2086  # several
foreign=$(readelf -d $extensions | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' \
  | grep -vE '^(libsodium\.so\.23|libglib-2\.0\.so\.0|libstdc\+\+\.so\.6|libgcc_s\.so\.1|libm\.so\.6|libc\.so\.6|ld-linux.*)$' || true)
if [ -n "$foreign" ]; then
  echo "check_wheels: what is in gecos needs libraries that nobody was told of: $foreign" >&2
  exit 1
fi

printf 'interface Lamp { @actor void turn(in boolean on); };\n' >lamp.gidl
env/bin/gidl gen lamp.gidl
env/bin/gecos --help >help.txt
env/bin/python - <<'EOF'
import gecos
import gecos.wire
import gecos_idl.broker
import robcl.gripper
from gecos import _core
from gecos.wire import plans
from robcl.frames import Frame, mm, translate

assert plans.COMPILED
assert (Frame() * translate(0.0, 0.0, mm(200))).inverse() is not None
for module in (gecos, robcl.gripper, _core):
    assert "site-packages" in module.__file__, module.__file__
EOF
echo "check_wheels: both wheels work where the tree is not known"
