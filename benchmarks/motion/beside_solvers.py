"""The times of our inverse kinematics beside those of KDL, py-opw-kinematics, pinocchio and the
Robotics Toolbox for Python, for the same random poses.

Ours and KDL are called from C++. py-opw-kinematics solves all poses in one call, so that Python
does not count; the toolbox's solver is compiled, too, and is called once for each pose; the loop of
pinocchio's example is in Python, around compiled functions. The iterative solvers start at a random
place, and know no configurations and no limits; that of the toolbox starts again where it fails.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import roboticstoolbox
from py_opw_kinematics import KinematicModel, Robot
from spatialmath import SE3

TREE = Path(__file__).resolve().parents[2]
CLOSE = 1e-6  # m and rad
STEP = 0.5  # of pinocchio's iteration; its example has 0.1 and needs five times as long
# The RX90 as an ortho-parallel arm with a spherical wrist, in m.
RX90 = KinematicModel(c1=0.42, c2=0.45, c3=0.45, c4=0.085)


def show(name: str, solved: int, times: list[float]) -> None:
    """`times`: in s, one for each pose."""
    share = 100 * solved / len(times)
    print(f"| {name} | {statistics.median(times) * 1e6:.2f} | {share:.1f} % |")


def opw(poses: np.ndarray) -> tuple[int, list[float]]:
    robot = Robot(RX90, degrees=False)
    frames = robot.batch_forward(poses)
    begun = time.perf_counter()
    found = robot.batch_inverse(frames, current_joints=poses[0])
    took = time.perf_counter() - begun
    solved = int(np.isfinite(np.asarray(found)).all(axis=1).sum())
    return solved, [took / len(poses)] * len(poses)


def pin(poses: np.ndarray, references: np.ndarray) -> tuple[int, list[float]]:
    """The loop of pinocchio's example "inverse kinematics", with its step and damping."""
    model = pinocchio.buildModelFromUrdf(str(TREE / "devices" / "arms" / "rx90.urdf"))
    data, flange = model.createData(), model.getFrameId("flange")
    times, solved = [], 0
    for pose, reference in zip(poses, references, strict=True):
        pinocchio.framesForwardKinematics(model, data, pose)
        goal, joints = data.oMf[flange].copy(), reference.copy()
        begun = time.perf_counter()
        for _ in range(1000):
            pinocchio.framesForwardKinematics(model, data, joints)
            away = data.oMf[flange].actInv(goal)
            error = pinocchio.log(away).vector
            if np.abs(error).max() < CLOSE:
                solved += 1
                break
            jacobian = pinocchio.computeFrameJacobian(model, data, joints, flange)
            jacobian = -pinocchio.Jlog6(away.inverse()) @ jacobian
            damped = jacobian @ jacobian.T + 1e-12 * np.eye(6)
            joints = joints - jacobian.T @ np.linalg.solve(damped, error) * STEP
        times.append(time.perf_counter() - begun)
    return solved, times


def toolbox(poses: np.ndarray, references: np.ndarray) -> tuple[int, list[float]]:
    """Its model of the Puma 560, whose limits it uses for the search alone."""
    robot = roboticstoolbox.models.DH.Puma560().ets()
    times, solved = [], 0
    for pose, reference in zip(poses, references, strict=True):
        goal = SE3(robot.fkine(pose)).A
        begun = time.perf_counter()
        found = robot.ik_LM(goal, q0=reference, joint_limits=False)
        times.append(time.perf_counter() - begun)
        solved += int(found.success)
    return solved, times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=Path, default=TREE / "build")
    parser.add_argument("--poses", type=int, default=2000)
    chosen = parser.parse_args()
    program = chosen.build / "benchmarks" / "motion" / "solve_poses"
    command = [program, TREE / "devices" / "arms" / "rx90.toml", str(chosen.poses)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    ours: dict[str, Any] = json.loads(printed)
    poses, references = np.array(ours["poses"]), np.array(ours["references"])
    print("| inverse of the RX90 | us, median | solved |\n|---|--:|--:|")
    for name, key in (
        ("ours, the wanted configuration", "one"),
        ("ours, all eight", "all"),
        ("KDL, Levenberg-Marquardt", "kdl"),
    ):
        show(name, ours[key]["solved"], [us * 1e-6 for us in ours[key]["us"]])
    show("py-opw-kinematics, all at once", *opw(poses))
    few = min(len(poses), 300)
    show("pinocchio, damped iteration", *pin(poses[:few], references[:few]))
    show("Robotics Toolbox, Puma 560", *toolbox(poses[:few], references[:few]))


if __name__ == "__main__":
    main()
