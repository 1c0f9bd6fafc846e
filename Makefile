# The two commands of this tree are `make demo` and `make test`; each does all of its own set-up.

BUILD ?= build
BUILD_TYPE ?= RelWithDebInfo
JOBS ?= $(shell nproc)
PYTHON := .venv/bin/python
CTEST := ctest --output-on-failure --no-tests=error -j$(JOBS)
CONFIGURE := tools/configure.sh $(BUILD) $(BUILD_TYPE)
# Sources of one target in groups of eight, as the preset dev has it: their headers, most of the work, are read once.
GROUPED := -DCMAKE_UNITY_BUILD=ON
# The targets for use, without tests and benchmarks. Tests are built in the same folder.
PARTS := $(addsuffix /all,runtime/cpp generated/cpp devices examples runtime/python)
# What examples/demo.py starts or imports.
DEMO := gecos-broker robcl-zone robcl-world robcl-rx90 robcl-gripper robcl-lds grip_block runtime/python/all

export GECOS_WERROR ?= $(if $(CI),ON)

.DEFAULT_GOAL := help
.PHONY: help
help:  ## this list
	@sed -n 's/^\([a-z-]*\):[^#]*## */\1\t/p' $(MAKEFILE_LIST) | expand -t 16

.PHONY: demo
demo:  ## broker, devices and the block: the whole system at work, in C++ and in Python
	@tools/setup.sh build
	@$(CONFIGURE) $(GROUPED)
	@cmake --build $(BUILD) -j$(JOBS) --target $(DEMO)
	@$(PYTHON) examples/demo.py --build $(BUILD) $(if $(CLOCK),--clock $(CLOCK))

.PHONY: test
test: build-tests  ## everything that must hold, in lanes; says at the end what each of them said last
	@$(PYTHON) tools/run_lanes.py --build $(BUILD) --jobs $(JOBS)

.PHONY: setup
setup:  ## what `make test` needs: missing apt packages and the virtual environment; quick when they are there
	@tools/setup.sh test

.PHONY: build
build:  ## all C++ but tests and benchmarks, and the Python extension
	@tools/setup.sh build
	@$(CONFIGURE) $(GROUPED)
	@cmake --build $(BUILD) -j$(JOBS) --target $(PARTS)

.PHONY: build-tests
build-tests: setup  ## all C++, and the Python extension
	@$(CONFIGURE) --preset=dev
	@cmake --build $(BUILD) -j$(JOBS)

.PHONY: generate
generate:  ## generated/ from idl/
	@tools/setup.sh gidl
	@.venv/bin/gidl gen

.PHONY: check-generated
check-generated:  ## is generated/ what idl/ says?
	@tools/setup.sh gidl
	@.venv/bin/gidl gen --check

# TESTS="gecos_wire_test robcl_frames_test" builds and runs these programs alone.
TESTS ?=
space := $(subst ,, )
define sanitized
	@tools/setup.sh tests
	@tools/configure.sh $(1) $(BUILD_TYPE) --preset=$(2)
	@cmake --build $(1) -j$(JOBS) $(if $(TESTS),--target $(TESTS))
	@$(CTEST) --test-dir $(1) $(if $(TESTS),-R '^($(subst $(space),|,$(strip $(TESTS))))[.]')
endef

.PHONY: test-asan
test-asan:  ## the C++ tests under AddressSanitizer and UndefinedBehaviorSanitizer
	$(call sanitized,build-asan,asan)

.PHONY: test-tsan
test-tsan:  ## the C++ tests under ThreadSanitizer
	$(call sanitized,build-tsan,tsan)

.PHONY: bench
bench:  ## speeds, shown and never asserted
	@tools/setup.sh bench
	@$(CONFIGURE) -DCMAKE_REQUIRE_FIND_PACKAGE_benchmark=ON
	@cmake --build $(BUILD) -j$(JOBS) --target benchmarks/all runtime/python/all
	@for program in $$(find $(BUILD)/benchmarks -maxdepth 1 -type f -executable | sort); do \
	  echo "──── $$program" && $$program || exit 1; done

# What the peers need is this target's alone. BENCH="--quick", "--without NAME", "--only TITLE": bench_peers.py --help
.PHONY: bench-peers
bench-peers:  ## ours beside omniORB, Ice, Cap'n Proto, iceoryx, iceoryx2 and LCM, in one run
	@tools/setup.sh build
	@$(CONFIGURE) $(GROUPED)
	@cmake --build $(BUILD) -j$(JOBS) --target runtime/python/all
	@BUILD_TYPE=$(BUILD_TYPE) JOBS=$(JOBS) tools/build_release.sh build-release gecos_peer limits_peer
	@benchmarks/peers/setup.sh build-release
	@$(PYTHON) benchmarks/peers/bench_peers.py --build build-release $(BENCH)

.PHONY: bench-motion
bench-motion:  ## our moves beside those of ruckig and toppra, our inverse beside other libraries
	@tools/setup.sh build
	@$(CONFIGURE)
	@cmake --build $(BUILD) -j$(JOBS) --target plan_moves solve_poses
	@test -x $(BUILD)/planners/bin/python || $(PYTHON) -m venv $(BUILD)/planners
	@$(BUILD)/planners/bin/python -m pip install --quiet --disable-pip-version-check -r benchmarks/motion/requirements.txt
	@$(BUILD)/planners/bin/python benchmarks/motion/beside_planners.py --build $(BUILD) $(BENCH)
	@$(BUILD)/planners/bin/python benchmarks/motion/beside_solvers.py --build $(BUILD)

# Each run says what it found; all of them run, whatever the others said. FUZZ_SECONDS=60 FUZZ_SETS=20 for shorter ones.
FUZZ_SECONDS ?= 600
FUZZ ?= parser decoders packets datagrams rings samples verdicts lcm-gen evolution gate
.PHONY: fuzz
fuzz:  ## input that nobody would write: to parser, decoders, sessions, lcm and rings; ours against lcm-gen's
	@tools/setup.sh fuzz
	@$(CONFIGURE) -DBUILD_TESTING=ON
	@cmake --build $(BUILD) -j$(JOBS) --target $(PARTS)
	@failed=; for run in $(FUZZ); do \
	  echo "──── $$run" && FUZZ_SECONDS=$(FUZZ_SECONDS) BUILD=$(BUILD) JOBS=$(JOBS) tools/fuzz.sh $$run || failed="$$failed $$run"; \
	done; test -z "$$failed" || { echo "fuzz: FAILED:$$failed"; exit 1; }

# SOAK says how much of what: SOAK="--kills 500 --calls 100000 --seed 7".
SOAK ?=
.PHONY: soak
soak:  ## programs killed and stopped, bad lines, idle clients, stopped motions: does every command end?
	@tools/setup.sh tests
	@$(CONFIGURE) -DBUILD_TESTING=ON
	@cmake --build $(BUILD) -j$(JOBS) --target $(PARTS) tests/stress/all crypto_test stream_rate_test robcl_random_moves_test robcl_move_chain_test
	@$(PYTHON) tests/stress/soak.py --build $(BUILD) $(SOAK)

.PHONY: pictures
pictures:  ## the pictures of docs/motion.md, drawn by `gecos plot` from motions of the simulated RX90
	@tools/setup.sh tests
	@$(CONFIGURE) $(GROUPED)
	@cmake --build $(BUILD) -j$(JOBS) --target gecos-broker robcl-rx90 runtime/python/all
	@$(PYTHON) tools/draw_motions.py --build $(BUILD)

.PHONY: release
release:  ## all C++ as fast as it gets, into build-release: link-time and profile-guided optimisation
	@tools/setup.sh build
	@BUILD_TYPE=$(BUILD_TYPE) JOBS=$(JOBS) tools/build_release.sh build-release

.PHONY: wheels
wheels:  ## both wheels into dist/, tried where the tree is not known
	@tools/setup.sh wheels
	@tools/wheels.sh

.PHONY: format
format:  ## C++ and Python laid out as the house does
	@tools/setup.sh format
	@git ls-files '*.cpp' '*.hpp' ':!generated' | xargs .venv/bin/clang-format -i
	@.venv/bin/ruff check --fix --quiet . && .venv/bin/ruff format --quiet .

.PHONY: clean
clean:  ## all that was built; the virtual environment stays
	@rm -rf build build-asan build-tsan build-fuzz build-release build-wheel dist runtime/python/gecos/_core*.so runtime/python/gecos/wire/_plans*.so
