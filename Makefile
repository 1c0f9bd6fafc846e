# The two commands of this tree are `make demo` and `make test`; each does all of its own set-up.

BUILD ?= build
BUILD_TYPE ?= RelWithDebInfo
JOBS ?= $(shell nproc)
PYTHON := .venv/bin/python
CTEST := ctest --output-on-failure -j$(JOBS)

.DEFAULT_GOAL := help
.PHONY: help
help:  ## this list
	@sed -n 's/^\([a-z-]*\):[^#]*## */\1\t/p' $(MAKEFILE_LIST) | expand -t 16

.PHONY: demo
demo: build  ## broker, devices and the block: the whole system at work, in C++ and in Python
	@$(PYTHON) examples/demo.py --build $(BUILD)

.PHONY: test
test: build  ## everything that must hold, in lanes; says at the end what each of them said last
	@$(PYTHON) tools/run_lanes.py --build $(BUILD) --jobs $(JOBS)

.PHONY: setup
setup:  ## missing apt packages and the virtual environment; quick when they are there
	@tools/setup.sh

.PHONY: build
build: setup  ## all C++ and the Python extension
	@tools/configure.sh $(BUILD) $(BUILD_TYPE)
	@cmake --build $(BUILD) -j$(JOBS)

.PHONY: generate
generate: setup  ## generated/ from idl/
	@.venv/bin/gidl gen

.PHONY: check-generated
check-generated: setup  ## is generated/ what idl/ says?
	@.venv/bin/gidl gen --check

.PHONY: test-asan
test-asan: setup  ## the C++ tests under AddressSanitizer and UndefinedBehaviorSanitizer
	@tools/configure.sh build-asan $(BUILD_TYPE) -DGECOS_SANITIZE=address
	@cmake --build build-asan -j$(JOBS)
	@$(CTEST) --test-dir build-asan

.PHONY: test-tsan
test-tsan: setup  ## the C++ tests under ThreadSanitizer
	@tools/configure.sh build-tsan $(BUILD_TYPE) -DGECOS_SANITIZE=thread
	@cmake --build build-tsan -j$(JOBS)
	@$(CTEST) --test-dir build-tsan

.PHONY: bench
bench: build  ## speeds, shown and never asserted
	@for program in $$(find $(BUILD)/benchmarks -maxdepth 1 -type f -executable | sort); do \
	  echo "──── $$program" && $$program || exit 1; done

# What the peers need is this target's alone. BENCH="--quick", "--without NAME", "--only TITLE": bench_peers.py --help
.PHONY: bench-peers
bench-peers: build  ## ours beside omniORB, Ice, Cap'n Proto, iceoryx, iceoryx2 and LCM, in one run
	@BUILD_TYPE=$(BUILD_TYPE) JOBS=$(JOBS) tools/build_release.sh build-release gecos_peer limits_peer
	@benchmarks/peers/setup.sh build-release
	@$(PYTHON) benchmarks/peers/bench_peers.py --build build-release $(BENCH)

# Each run says what it found; all of them run, whatever the others said. FUZZ_SECONDS=60 for shorter ones.
FUZZ_SECONDS ?= 600
.PHONY: fuzz
fuzz: build  ## input that nobody would write: to parser, decoders, sessions, lcm and rings; ours against lcm-gen's
	@failed=; for run in parser decoders packets datagrams rings verdicts lcm-gen evolution; do \
	  echo "──── $$run" && FUZZ_SECONDS=$(FUZZ_SECONDS) BUILD=$(BUILD) JOBS=$(JOBS) tools/fuzz.sh $$run || failed="$$failed $$run"; \
	done; test -z "$$failed" || { echo "fuzz: FAILED:$$failed"; exit 1; }

# SOAK says how much of what: SOAK="--kills 500 --calls 100000 --seed 7".
SOAK ?=
.PHONY: soak
soak: build  ## programs killed 10,000 times, bad lines, cut lines, stopped programs: does every command end?
	@$(PYTHON) tests/stress/soak.py --build $(BUILD) $(SOAK)

.PHONY: release
release: setup  ## all C++ as fast as it gets, into build-release: link-time and profile-guided optimisation
	@BUILD_TYPE=$(BUILD_TYPE) JOBS=$(JOBS) tools/build_release.sh build-release

.PHONY: wheels
wheels: setup  ## both wheels into dist/, tried where the tree is not known
	@tools/check_wheels.sh

.PHONY: format
format: setup  ## C++ and Python laid out as the house does
	@git ls-files '*.cpp' '*.hpp' ':!generated' | xargs clang-format-14 -i
	@.venv/bin/ruff check --fix --quiet . && .venv/bin/ruff format --quiet .

.PHONY: clean
clean:  ## all that was built; the virtual environment stays
	@rm -rf build build-asan build-tsan build-fuzz build-release build-wheel dist runtime/python/gecos/_core*.so runtime/python/gecos/wire/_plans*.so
