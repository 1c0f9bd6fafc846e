#!/bin/bash
# fuzz.sh <parser|decoders|packets|datagrams|rings|samples|verdicts|lcm-gen|evolution|gate>: one of the runs of `make fuzz`.
# FUZZ_SECONDS says how long the first five run, FUZZ_SEED what verdicts, lcm-gen and gate begin with, FUZZ_SETS how many
# random sets of files gate makes.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${FUZZ_SECONDS:-600}
jobs=${JOBS:-$(nproc)}
python=.venv/bin/python

case "${1-}" in
  parser)
    exec "$python" tests/fuzz/parser_fuzz.py --seconds "$seconds"
    ;;
  decoders | packets | datagrams | rings | samples)
    fuzzer=$1_fuzzer
    compiler=$(tools/clang.sh)
    entry='extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }'
    "$compiler" -fsanitize=fuzzer,address,undefined -x c++ - -o /dev/null <<<"$entry" || {
      echo "fuzz: $compiler cannot link libFuzzer: tools/setup.sh fuzz installs what it needs" >&2
      exit 1
    }
    tools/configure.sh build-fuzz RelWithDebInfo -DBUILD_TESTING=ON -DGECOS_FUZZ=ON -DGECOS_SANITIZE=address \
      "-DCMAKE_CXX_COMPILER=$compiler"
    cmake --build build-fuzz "-j$jobs" --target "$fuzzer"
    corpus=build-fuzz/corpus/$1
    given=tests/fuzz/inputs/$1
    if [ "$1" = decoders ]; then
      given=$corpus/vectors
      "$python" tests/fuzz/write_corpus.py "$given"
    fi
    mkdir -p "$corpus/found"
    exec "build-fuzz/tests/fuzz/$fuzzer" "-max_total_time=$seconds" -max_len=16384 -timeout=10 -rss_limit_mb=1024 \
      -print_final_stats=1 -print_funcs=0 -verbosity=0 "-artifact_prefix=build-fuzz/$1-" "$corpus/found" "$given"
    ;;
  verdicts)
    cmake --build "${BUILD:-build}" "-j$jobs" --target generated_verdicts
    PYTHONPATH=codegen:runtime/python:generated/python exec "$python" tests/generated/compare_verdicts.py \
      --strings 100000 --seed "${FUZZ_SEED:-$RANDOM}" "${BUILD:-build}/tests/cpp/generated/generated_verdicts"
    ;;
  lcm-gen)
    exec "$python" tests/fuzz/lcm_differential.py --types 300 --values 1000 --jobs "$jobs" --seed "${FUZZ_SEED:-1}"
    ;;
  evolution)
    GIDL_EVOLUTION_EDITS=2000 exec "$python" -m pytest -q tests/gidl/test_evolution.py
    ;;
  gate)
    seed=${FUZZ_SEED:-$RANDOM}
    echo "gate: seed $seed"
    exec "$python" tests/generated/gate/__main__.py --random "${FUZZ_SETS:-500}" --seed "$seed" --jobs "$jobs"
    ;;
  *)
    echo "fuzz: name one of parser, decoders, packets, datagrams, rings, samples, verdicts, lcm-gen, evolution, gate" >&2
    exit 2
    ;;
esac
