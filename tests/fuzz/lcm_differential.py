"""Generated C++ and Python against lcm-gen's, on random types and random values.

    python tests/fuzz/lcm_differential.py --types 300 --values 1000

For each type: fingerprints are equal; the same value, made independently, is encoded to the same
bytes by lcm-gen's Python, lcm-gen's C++, generated Python and generated C++; each reads the others'
and gets the same value. Exits 1 on the first batch with differences and keeps its folder.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
for place in ("codegen", "runtime/python", "tests/fuzz"):
    if str(TREE / place) not in sys.path:
        sys.path.insert(0, str(TREE / place))

from lcm_batch import Outcome, run  # noqa: E402  (found by the lines above)

SHOWN = 5


def main() -> int:
    parser = argparse.ArgumentParser(description="generated code against lcm-gen's")
    parser.add_argument("--types", type=int, default=300, help="random structs")
    parser.add_argument("--values", type=int, default=1000, help="random values of each")
    parser.add_argument("--batch", type=int, default=25, help="structs compiled together")
    parser.add_argument("--seed", type=int, default=1, help="of the first batch")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="batches at a time")
    asked = parser.parse_args()

    batches = range(asked.seed, asked.seed + -(-asked.types // asked.batch))
    folder = Path(tempfile.mkdtemp(prefix="gecos-lcm-differential-"))
    done: list[Outcome] = []
    failed = False
    # A process per batch: each imports modules of its own.
    with ProcessPoolExecutor(asked.jobs, max_tasks_per_child=1) as pool:
        running = {
            pool.submit(_batch, folder / str(seed), seed, asked.batch, asked.values): seed
            for seed in batches
        }
        for each in as_completed(running):
            outcome = each.result()
            done.append(outcome)
            for line in outcome.differences[:SHOWN]:
                print(line)
            if outcome.differences:
                failed = True
                print(f"batch of seed {running[each]} differs; it is in {folder}/{running[each]}")
            else:
                shutil.rmtree(folder / str(running[each]))
    if not failed:
        shutil.rmtree(folder)
    types = sum(outcome.types for outcome in done)
    differences = sum(len(outcome.differences) for outcome in done)
    print(f"lcm-gen: {types} random types x {asked.values} values, {differences} differences")
    return 1 if failed else 0


def _batch(folder: Path, seed: int, types: int, values: int) -> Outcome:
    folder.mkdir()
    return run(folder, seed, types, values)


if __name__ == "__main__":
    sys.exit(main())
