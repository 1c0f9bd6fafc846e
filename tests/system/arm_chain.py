"""The forward kinematics of an arm file, to compute where set points put the tool."""

from __future__ import annotations

import tomllib
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from pathlib import Path

from robcl.frames import Frame


class ArmChain:
    """The joints from the base link to the flange link, as the URDF of an arm's TOML file has
    them."""

    def __init__(self, toml: Path) -> None:
        arm = tomllib.loads(toml.read_text())
        joints = ElementTree.parse(toml.parent / arm["urdf"]).getroot().findall("joint")
        to_link = {joint.find("child").get("link"): joint for joint in joints}  # type: ignore[union-attr]
        self._joints = []
        link = arm["flange_link"]
        while link != arm["base_link"]:
            joint = to_link[link]
            self._joints.insert(0, joint)
            link = joint.find("parent").get("link")  # type: ignore[union-attr]

    def base_from_flange(self, positions: Sequence[float]) -> Frame:
        """`positions` in rad."""
        rest = list(positions)
        pose = Frame()
        for joint in self._joints:
            pose = pose * Frame.from_fixed_xyz(
                *_numbers(joint, "origin", "xyz"), *_numbers(joint, "origin", "rpy")
            )
            if joint.get("type") != "fixed":
                axis = _numbers(joint, "axis", "xyz")
                pose = pose * Frame.from_axis_angle(0.0, 0.0, 0.0, axis, float(rest.pop(0)))
        assert not rest, f"{len(rest)} joint positions too many"
        return pose


def _numbers(joint: ElementTree.Element, tag: str, key: str) -> tuple[float, float, float]:
    element = joint.find(tag)
    text = "0 0 0" if element is None else element.get(key, "0 0 0")
    x, y, z = map(float, text.split())
    return x, y, z
