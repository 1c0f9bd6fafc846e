"""The shapes and the masses of the arms in devices/arms: no program of this tree reads them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import pi, prod, radians
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

ARMS = Path(__file__).resolve().parents[2] / "devices" / "arms"
ESTIMATED = ("iiwa14", "rx90", "rx90l")
ALL = (*ESTIMATED, "puma560")
TOUCHES = 1e-3  # m

Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]


def turned(rpy: Sequence[float] | Array) -> Array:
    """Roll, pitch and yaw of URDF, as a matrix."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(z @ y @ x)


def about(axis: Array, angle: float) -> Array:
    cross = np.cross(np.eye(3), axis / np.linalg.norm(axis))
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


@dataclass(frozen=True, slots=True)
class Pose:
    at: Array
    axes: Array

    def __mul__(self, other: Pose) -> Pose:
        return Pose(self.at + self.axes @ other.at, self.axes @ other.axes)

    def outside(self, points: Array) -> Array:
        return np.asarray(points @ self.axes.T + self.at)

    def inside(self, points: Array) -> Array:
        return np.asarray((points - self.at) @ self.axes)


def numbers(text: str | None) -> Array:
    return np.array([float(word) for word in (text or "0 0 0").split()])


def pose_in(element: ElementTree.Element) -> Pose:
    origin = element.find("origin")
    found = {} if origin is None else origin.attrib
    return Pose(numbers(found.get("xyz")), turned(numbers(found.get("rpy"))))


@dataclass(frozen=True, slots=True)
class Shape:
    """A box (sizes), a cylinder (radius, length) or a sphere (radius)."""

    kind: str
    size: tuple[float, ...]
    pose: Pose

    @property
    def volume(self) -> float:
        if self.kind == "box":
            return prod(self.size)
        radius, *length = self.size
        return pi * radius**2 * (length[0] if length else 4 / 3 * radius)

    def inertia(self, mass: float) -> Array:
        """About the centre of the solid shape, along the axes of its link."""
        if self.kind == "box":
            x, y, z = np.square(self.size)
            moments = mass / 12 * np.array([y + z, x + z, x + y])
        elif self.kind == "cylinder":
            radius, length = self.size
            across = mass * (3 * radius**2 + length**2) / 12
            moments = np.array([across, across, mass * radius**2 / 2])
        else:
            moments = np.full(3, 0.4 * mass * self.size[0] ** 2)
        return np.asarray(self.pose.axes @ np.diag(moments) @ self.pose.axes.T)

    def distances(self, points: Array) -> Array:
        """How far points, seen from the link, are from the shape; 0 inside."""
        here = self.pose.inside(points)
        if self.kind == "sphere":
            beyond = np.linalg.norm(here, axis=1)[:, None] - self.size[0]
        elif self.kind == "cylinder":
            radius, length = self.size
            from_axis = np.linalg.norm(here[:, :2], axis=1)
            beyond = np.stack([from_axis - radius, np.abs(here[:, 2]) - length / 2], axis=1)
        else:
            beyond = np.abs(here) - np.array(self.size) / 2
        return np.asarray(np.linalg.norm(np.maximum(beyond, 0), axis=1))

    def points(self) -> Array:
        """Points all over the shape, seen from the link."""
        steps = np.linspace(-1, 1, 25)
        cube = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
        if self.kind == "box":
            return self.pose.outside(cube * np.array(self.size) / 2)
        radius = self.size[0]
        half = self.size[1] / 2 if self.kind == "cylinder" else radius
        filled = self.pose.outside(cube * np.array([radius, radius, half]))
        return np.asarray(filled[self.distances(filled) == 0])


def shape_of(element: ElementTree.Element) -> Shape:
    (solid,) = element.iterfind("geometry/*")
    words = {"box": ["size"], "cylinder": ["radius", "length"], "sphere": ["radius"]}[solid.tag]
    size = tuple(float(number) for word in words for number in solid.attrib[word].split())
    return Shape(solid.tag, size, pose_in(element))


@dataclass(frozen=True, slots=True)
class Body:
    """The inertial of a link: its centre and its inertia about that are seen from the link."""

    mass: float
    centre: Array
    inertia: Array


def body_of(link: ElementTree.Element) -> Body:
    found = link.find("inertial")
    assert found is not None, link.get("name")
    mass, inertia = found.find("mass"), found.find("inertia")
    assert mass is not None and inertia is not None
    xx, xy, xz, yy, yz, zz = (
        float(inertia.attrib[word]) for word in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    pose = pose_in(found)
    turned_to_link = pose.axes @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ pose.axes.T
    return Body(float(mass.attrib["value"]), pose.at, np.asarray(turned_to_link))


@dataclass(frozen=True, slots=True)
class Joint:
    parent: str
    child: str
    pose: Pose
    axis: Array

    def turned_by(self, angle: float) -> Pose:
        return self.pose * Pose(np.zeros(3), about(self.axis, angle))


@dataclass(frozen=True, slots=True)
class Arm:
    shapes: dict[str, list[Shape]]
    bodies: dict[str, Body]
    joints: list[Joint]  # from base to flange

    def poses(self, angles: Sequence[float]) -> dict[str, Pose]:
        """The frames of the links in the base."""
        all_poses = {self.joints[0].parent: Pose(np.zeros(3), np.eye(3))}
        for joint, angle in zip(self.joints, angles, strict=True):
            all_poses[joint.child] = all_poses[joint.parent] * joint.turned_by(angle)
        return all_poses


def links_of(name: str) -> list[ElementTree.Element]:
    robot = ElementTree.parse(ARMS / f"{name}.urdf").getroot()
    return [link for link in robot.iterfind("link") if link.get("name") != "flange"]


@cache
def arm(name: str) -> Arm:
    links = links_of(name)
    joints = []
    for joint in ElementTree.parse(ARMS / f"{name}.urdf").getroot().iterfind("joint"):
        parent, child, axis = (joint.find(tag) for tag in ("parent", "child", "axis"))
        assert parent is not None and child is not None
        if joint.get("type") == "fixed":
            continue
        assert axis is not None
        direction = numbers(axis.get("xyz"))
        joints.append(Joint(parent.attrib["link"], child.attrib["link"], pose_in(joint), direction))
    return Arm(
        {
            str(link.get("name")): [shape_of(e) for e in link.iterfind("collision")]
            for link in links
        },
        {str(link.get("name")): body_of(link) for link in links},
        joints,
    )


@pytest.mark.parametrize("name", ALL)
def test_every_link_is_drawn_as_it_collides(name: str) -> None:
    for link in links_of(name):
        drawn, collides = (
            [[ElementTree.tostring(child) for child in part] for part in link.iterfind(tag)]
            for tag in ("visual", "collision")
        )
        assert drawn == collides and drawn, link.get("name")


@pytest.mark.parametrize("name", ALL)
def test_the_axis_of_each_joint_meets_the_shapes_on_both_sides(name: str) -> None:
    along = np.linspace(-0.3, 0.3, 601)[:, None]
    for joint in arm(name).joints:
        in_child = along * joint.axis
        for link, points in ((joint.child, in_child), (joint.parent, joint.pose.outside(in_child))):
            least = min(shape.distances(points).min() for shape in arm(name).shapes[link])
            assert least <= TOUCHES, f"{joint.child}: no shape of {link} is at its axis"


@pytest.mark.parametrize("name", ALL)
def test_the_shapes_of_neighbouring_links_touch_wherever_the_joints_are(name: str) -> None:
    of = arm(name).shapes
    for joint in arm(name).joints:
        for angle in (0, 0.7, -1.5):
            pose = joint.turned_by(angle)
            gap = min(
                shape.distances(pose.outside(other.points())).min()
                for shape in of[joint.parent]
                for other in of[joint.child]
            )
            assert gap <= TOUCHES, f"{joint.child} is {gap} m from {joint.parent}"


@pytest.mark.parametrize("name", ALL)
def test_the_last_shape_ends_at_the_flange(name: str) -> None:
    robot = ElementTree.parse(ARMS / f"{name}.urdf").getroot()
    (fixed,) = robot.iterfind("joint[@type='fixed']")
    flange = pose_in(fixed).at
    (last,) = arm(name).shapes[arm(name).joints[-1].child]
    assert last.distances(flange[None])[0] <= TOUCHES
    assert last.distances(1.05 * flange[None])[0] > TOUCHES


@pytest.mark.parametrize("name", ALL)
def test_every_inertia_is_that_of_a_body(name: str) -> None:
    for link, body in arm(name).bodies.items():
        least, middle, greatest = np.linalg.eigvalsh(body.inertia)
        assert body.mass > 0 and least > 0, link
        assert least + middle >= greatest, link


@pytest.mark.parametrize("name", ALL)
def test_the_masses_add_up_to_what_the_file_says(name: str) -> None:
    said = re.search(r"([\d.]+) kg in\s+all", (ARMS / f"{name}.urdf").read_text())
    assert said
    total = sum(body.mass for body in arm(name).bodies.values())
    assert total == pytest.approx(float(said[1]), abs=0.01)


def solid(shapes: Sequence[Shape], mass: float) -> Body:
    """One body of solid shapes that have the same density."""
    density = mass / sum(shape.volume for shape in shapes)
    masses = [density * shape.volume for shape in shapes]
    centre = sum((m * s.pose.at for m, s in zip(masses, shapes, strict=True)), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, shape in zip(masses, shapes, strict=True):
        away = shape.pose.at - centre
        inertia += shape.inertia(m) + m * (away @ away * np.eye(3) - np.outer(away, away))
    return Body(mass, centre, inertia)


def assert_same(found: Body, wanted: Body, link: str) -> None:
    assert found.centre == pytest.approx(wanted.centre, abs=1e-6), link
    scale = np.abs(wanted.inertia).max()
    assert found.inertia == pytest.approx(wanted.inertia, abs=1e-3 * scale), link


@pytest.mark.parametrize("name", ESTIMATED)
def test_estimated_masses_are_those_of_solid_shapes_of_one_density(name: str) -> None:
    of, bodies = arm(name).shapes, arm(name).bodies
    volume = {link: sum(shape.volume for shape in shapes) for link, shapes in of.items()}
    density = sum(body.mass for body in bodies.values()) / sum(volume.values())
    for link, body in bodies.items():
        assert body.mass == pytest.approx(density * volume[link], abs=1e-3), link
        assert_same(body, solid(of[link], body.mass), link)


def test_the_rx90l_has_the_density_of_the_rx90() -> None:
    long, short = arm("rx90l"), arm("rx90")
    for link in short.bodies.keys() - {"forearm"}:
        assert long.bodies[link].mass == short.bodies[link].mass
    grown = long.shapes["forearm"][0].volume / short.shapes["forearm"][0].volume
    masses = long.bodies["forearm"].mass, short.bodies["forearm"].mass
    assert masses[0] == pytest.approx(masses[1] * grown, rel=1e-3)


# The links of P. Corke's model Puma560: standard Denavit-Hartenberg a, alpha in degrees, d, mass,
# centre of mass, and the moments about it along the axes of the link's frame, which is at its end.
PUBLISHED = {
    "upper_arm": (0.4318, 0, 0, 17.4, (-0.3638, 0.006, 0.2275), (0.13, 0.524, 0.539)),
    "elbow": (0.0203, -90, 0.15005, 4.8, (-0.0203, -0.0141, 0.070), (0.066, 0.086, 0.0125)),
    "forearm": (0, 90, 0.4318, 0.82, (0, 0.019, 0), (1.8e-3, 1.3e-3, 1.8e-3)),
    "wrist": (0, -90, 0, 0.34, (0, 0, 0), (0.3e-3, 0.4e-3, 0.3e-3)),
    "hand": (0, 0, 0, 0.09, (0, 0, 0.032), (0.15e-3, 0.15e-3, 0.04e-3)),
}
TRUNK = (0, 90, 0.67183)


def denavit_hartenberg(a: float, alpha: float, d: float, theta: float) -> Pose:
    turn = turned([0, 0, theta])
    return Pose(turn @ np.array([a, 0, 0]) + [0, 0, d], turn @ turned([radians(alpha), 0, 0]))


def test_the_bodies_of_the_puma_are_where_the_published_ones_are() -> None:
    puma = arm("puma560")
    for angles in np.random.default_rng(1).uniform(-2, 2, (20, 6)):
        poses = puma.poses(angles)
        end = denavit_hartenberg(*TRUNK, angles[0])
        for angle, (link, row) in zip(angles[1:], PUBLISHED.items(), strict=True):
            a, alpha, d, mass, centre, moments = row
            end = end * denavit_hartenberg(a, alpha, d, angle)
            if link == "elbow":  # a body cannot have the published moments
                assert moments[0] + moments[2] < moments[1]
                moments = (0.066, 0.078, 0.0125)
            body, pose = puma.bodies[link], poses[link]
            assert body.mass == mass
            where = pose.outside(body.centre[None])[0]
            assert where == pytest.approx(end.outside(np.array([centre]))[0], abs=1e-9), link
            inertia = pose.axes @ body.inertia @ pose.axes.T
            assert inertia == pytest.approx(end.axes @ np.diag(moments) @ end.axes.T, abs=1e-9)


def test_the_trunk_of_the_puma_has_the_published_inertia_about_its_joint() -> None:
    puma = arm("puma560")
    assert puma.bodies["trunk"].inertia[2, 2] == 0.35
    assert_same(puma.bodies["foot"], solid(puma.shapes["foot"], 20), "foot")
