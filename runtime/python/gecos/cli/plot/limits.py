"""Reads the limits of an arm from the URDF and TOML files with which its server was started
(docs/adding-an-arm.md)."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from gecos.cli.exit_codes import UsageFailure
from gecos.cli.plot.recording import Numbers

_EXAMPLE = "docs/adding-an-arm.md shows such a file"


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmLimits:
    """The limits of an arm in SI units, each with a value for each joint. A member is None if the
    file does not contain it."""

    joints: tuple[str, ...]
    lower: Numbers
    upper: Numbers
    speed: Numbers
    acceleration: Numbers | None = None
    tool_speed: float | None = None
    tool_acceleration: float | None = None


def read_limits(path: Path) -> ArmLimits:
    """Reads an ARM.toml and the URDF file that it names, or only an ARM.urdf, which contains no
    accelerations. Raises UsageFailure and OSError."""
    if path.suffix == ".urdf":
        return _of_urdf(path, None, None)
    if path.suffix == ".toml":
        return _of_toml(path)
    raise UsageFailure(
        f"{path}: the limits of an arm are in a file ARM.toml or ARM.urdf; name such a file"
    )


def check_joints(limits: ArmLimits, name: str, joints: int) -> None:
    """Raises UsageFailure if the arm `name`, which has `joints` joints, has another number of
    joints than `limits`."""
    if joints != len(limits.joints):
        raise UsageFailure(
            f"{name} has {joints} joints, but --limits names the file of an arm with "
            f"{len(limits.joints)} ({', '.join(limits.joints)}); name the file of {name}"
        )


def _of_toml(path: Path) -> ArmLimits:
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UsageFailure(f"{path}: this is no TOML: {error}") from None
    urdf = path.parent / _text(table, "urdf", path)
    found = _of_urdf(urdf, _text(table, "base_link", path), _text(table, "flange_link", path))
    seconds = _seconds(table.get("seconds_to_full_speed"), len(found.joints), path)
    tool = table.get("tool", {})
    if not isinstance(tool, dict):
        raise UsageFailure(f"{path}: tool is no table; {_EXAMPLE}")
    return ArmLimits(
        joints=found.joints,
        lower=found.lower,
        upper=found.upper,
        speed=found.speed,
        acceleration=found.speed / seconds,
        tool_speed=_positive(tool, "speed_m_per_s", path),
        tool_acceleration=_positive(tool, "acceleration_m_per_s2", path),
    )


def _text(table: Mapping[str, Any], key: str, path: Path) -> str:
    value = table.get(key)
    if not isinstance(value, str):
        raise UsageFailure(f"{path}: the key {key} is missing or no text; {_EXAMPLE}")
    return value


def _positive(tool: Mapping[str, Any], key: str, path: Path) -> float:
    value = tool.get(key)
    if value is None or not _is_positive(value):
        raise UsageFailure(
            f"{path}: the key tool.{key} is missing or is not a number above 0; {_EXAMPLE}"
        )
    return float(value)


def _is_positive(value: Any) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and math.isfinite(value) and value > 0


def _seconds(value: Any, joints: int, path: Path) -> Numbers:
    numbers = value if isinstance(value, list) else [value] * joints
    if len(numbers) != joints or not all(map(_is_positive, numbers)):
        raise UsageFailure(
            f"{path}: seconds_to_full_speed must be a number above 0, or a list of such numbers, "
            f"one for each of the {joints} joints; {_EXAMPLE}"
        )
    return np.array(numbers, dtype=np.float64)


def _of_urdf(path: Path, base: str | None, flange: str | None) -> ArmLimits:
    try:
        root = ElementTree.fromstring(path.read_bytes())
    except ElementTree.ParseError as error:
        raise UsageFailure(f"{path}: this is no XML: {error}") from None
    moved = [
        joint
        for joint in _chain(root, path, base, flange)
        if joint.get("type") in ("revolute", "continuous")
    ]
    if not moved:
        raise UsageFailure(f"{path}: there is no revolute joint; {_EXAMPLE}")
    names = tuple(joint.get("name", "") for joint in moved)
    table = [
        [_limit(joint, key, path) for key in ("lower", "upper", "velocity")] for joint in moved
    ]
    lower, upper, speed = np.array(table).T
    return ArmLimits(joints=names, lower=lower, upper=upper, speed=speed)


def _chain(
    root: ElementTree.Element, path: Path, base: str | None, flange: str | None
) -> list[ElementTree.Element]:
    """Returns the joints from the base to the flange, in order. If no flange is given, returns the
    joints of the only chain that has moving joints."""
    above = {_link(joint, "child"): joint for joint in root.iter("joint") if _link(joint, "child")}
    ends = [flange] if flange else _ends(above)
    chains = []
    for end in ends:
        chain: list[ElementTree.Element] = []
        link = end
        while link != base and link in above and len(chain) <= len(above):
            chain.insert(0, above[link])
            link = _link(above[link], "parent")
        if base and link != base:
            raise UsageFailure(f"{path}: no chain of joints leads from {base!r} to {end!r}")
        chains.append(chain)
    moving = {
        tuple(joint.get("name", "") for joint in chain if joint.get("type") != "fixed"): chain
        for chain in chains
    }
    moving.pop((), None)
    if len(moving) > 1:
        raise UsageFailure(
            f"{path}: the joints form more than one chain; name the ARM.toml of the arm, which "
            "says where its chain begins and ends"
        )
    return next(iter(moving.values()), [])


def _ends(above: Mapping[str, ElementTree.Element]) -> list[str]:
    parents = {_link(joint, "parent") for joint in above.values()}
    return [link for link in above if link not in parents]


def _link(joint: ElementTree.Element, which: str) -> str:
    found = joint.find(which)
    return "" if found is None else found.get("link", "")


def _limit(joint: ElementTree.Element, key: str, path: Path) -> float:
    endless = {"lower": -np.inf, "upper": np.inf}
    if joint.get("type") == "continuous" and key in endless:
        return endless[key]
    limit = joint.find("limit")
    try:
        value = float("nan" if limit is None else limit.get(key, "nan"))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageFailure(
            f"{path}: joint {joint.get('name')!r} has no number {key!r} in <limit>; {_EXAMPLE}"
        )
    return value
