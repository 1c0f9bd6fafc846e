"""The durations of our moves beside those of ruckig and toppra, for the same moves and limits.

ruckig plans the joint moves, from rest to rest, all joints arriving together, without and with the
limit of jerk of the arm. toppra has no limit of jerk: ours are compared with it without theirs and
with it. toppra gets the path of the joints that we computed for a straight line, with the way and
the turn of the tool as two joints more, whose limits are those of the tool. It keeps the limits at
its grid points; ours hold everywhere.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import ruckig
import toppra
from toppra import algorithm, constraint

TREE = Path(__file__).resolve().parents[2]
GRID = 2000  # points of toppra on a line


def ruckig_duration(move: dict[str, Any], limits: dict[str, Any], *, jerk: bool) -> float:
    axes = len(limits["speeds"])
    asked = ruckig.InputParameter(axes)
    asked.current_position, asked.target_position = move["from"], move["to"]
    asked.max_velocity, asked.max_acceleration = limits["speeds"], limits["accelerations"]
    rise = limits["seconds_to_full_acceleration"] if jerk else 0.0
    asked.max_jerk = [a / rise if rise > 0 else float("inf") for a in limits["accelerations"]]
    trajectory = ruckig.Trajectory(axes)
    if ruckig.Ruckig(axes).calculate(asked, trajectory) < 0:
        raise RuntimeError(f"ruckig does not plan {move}")
    duration: float = trajectory.duration
    return duration


def toppra_duration(move: dict[str, Any], limits: dict[str, Any]) -> float:
    places = np.array(move["places"]) / move["places"][-1]
    tool = np.outer(places, [move["length"], move["turn"]])
    path = toppra.SplineInterpolator(places, np.hstack([move["joints"], tool]))
    speed, acceleration, turn_speed, turn_acceleration = limits["tool"]
    speeds = np.array([*limits["speeds"], speed, turn_speed])
    accelerations = np.array([*limits["accelerations"], acceleration, turn_acceleration])
    planner = algorithm.TOPPRA(
        [
            constraint.JointVelocityConstraint(np.stack([-speeds, speeds], axis=1)),
            constraint.JointAccelerationConstraint(
                np.stack([-accelerations, accelerations], axis=1)
            ),
        ],
        path,
        gridpoints=np.linspace(0, 1, GRID + 1),
        solver_wrapper="seidel",
    )
    trajectory = planner.compute_trajectory()
    if trajectory is None:
        raise RuntimeError("toppra does not plan a line")
    duration: float = trajectory.duration
    return duration


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, default=TREE / "build")
    parser.add_argument("--moves", type=int, default=200, help="of each kind and arm")
    chosen = parser.parse_args()
    toppra.setup_logging("ERROR")
    print("| durations: ours / theirs | n | median | p99 | most |\n|---|--:|--:|--:|--:|")
    for arm in ("rx90", "puma560"):
        command = [
            chosen.build / "benchmarks" / "motion" / "plan_moves",
            TREE / "devices" / "arms" / f"{arm}.toml",
            str(chosen.moves),
        ]
        printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        limits, *moves = map(json.loads, printed.splitlines())
        lines = [m for m in moves if "joints" in m]
        joints = [m for m in moves if "from" in m]
        toppra_durations = [toppra_duration(m, limits) for m in lines]
        rows: dict[str, list[float]] = {
            "joint moves, ruckig": [
                m["duration"] / ruckig_duration(m, limits, jerk=False) for m in joints
            ],
            "joint moves, limited jerk, ruckig with the same": [
                m["with_jerk_limit"] / ruckig_duration(m, limits, jerk=True) for m in joints
            ],
            "straight moves, toppra": [
                m["duration"] / theirs for m, theirs in zip(lines, toppra_durations, strict=True)
            ],
            "straight moves, limited jerk, toppra without": [
                m["with_jerk_limit"] / theirs
                for m, theirs in zip(lines, toppra_durations, strict=True)
            ],
        }
        for what, ratios in rows.items():
            p99 = float(np.quantile(ratios, 0.99))
            median = statistics.median(ratios)
            print(
                f"| {arm}: {what} | {len(ratios)} | {median:.4f} | {p99:.4f} | {max(ratios):.4f} |"
            )


if __name__ == "__main__":
    main()
