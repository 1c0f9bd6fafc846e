#!/bin/bash
# The whole system at work; see tools/demo.py. `make demo` has built everything before.
cd "$(dirname "$0")/.." && exec .venv/bin/python tools/demo.py "$@"
