#!/bin/bash
# clang.sh <arguments>: runs the clang++ of this machine with them, any from 14 on; without arguments says which it is.
set -euo pipefail
for compiler in clang++ clang++-{14..40}; do
  version=$("$compiler" -dumpversion 2>/dev/null) || continue
  if [ "${version%%.*}" -ge 14 ]; then
    [ $# -gt 0 ] || { command -v "$compiler"; exit; }
    exec "$compiler" "$@"
  fi
done
echo "clang.sh: there is no clang++ of version 14 or newer; tools/setup.sh test installs it" >&2
exit 1
