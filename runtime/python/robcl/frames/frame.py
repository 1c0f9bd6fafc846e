"""The type Frame: position and orientation of a coordinate system, seen from another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, copysign, cos, hypot, isfinite, pi, remainder, sin, sqrt
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
import numpy.typing as npt
from gecos.wire import DecodeProblem, Fields
from robcl.frames.units import in_deg, in_mm

if TYPE_CHECKING:
    from gecos.wire import Decoder, Parts

Vector = npt.NDArray[np.float64]
_Quaternion = tuple[float, float, float, float]

# If the sine or cosine of half the second Euler angle is below this limit, the first and the third
# axis count as parallel. Then only the sum or the difference of the first and the third angle can
# be determined.
_PARALLEL_AXES = 1e-9

# The layout of robcl::Frame in idl/robcl/geometry.gidl.
_LAYOUT = Fields("ddddddd", ("position",) * 3 + ("orientation",) * 4)

# These texts follow "<number> is " in the message of a decoder.
_NOT_FINITE = "the sum of the coordinates, which must be finite"
_NO_ROTATION = (
    "the length of the orientation's quaternion, which must be 1; without rotation, w is 1"
)

_HERE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


class InvalidFrame(ValueError):
    """The values do not describe a rigid transform. The text says which value is wrong, and by how
    much."""


@dataclass(frozen=True, slots=True, eq=False)
class Twist:
    """The velocity of a rigid body, as arrays (3,) along the axes of one coordinate system."""

    linear: npt.ArrayLike  # m/s; velocity of the point of the body that is at the origin
    angular: npt.ArrayLike  # rad/s


@dataclass(frozen=True, slots=True, eq=False)
class Wrench:
    """A force on a rigid body and its torque, as arrays (3,) along the axes of one coordinate
    system."""

    force: npt.ArrayLike  # N
    torque: npt.ArrayLike  # about the origin, N·m


class Frame:
    """Position (in m) and orientation of a coordinate system, seen from another.

    A Frame is immutable. `==` compares number by number; to compare with tolerances, use `near`. A
    quaternion and its negative describe the same orientation, but `==` treats them as different.
    """

    __slots__ = ("_numbers",)

    UNIT_TOLERANCE = 1e-6
    """How far the length of a quaternion or of a column of a rotation matrix may be from 1."""

    _numbers: tuple[float, ...]  # x, y, z, qw, qx, qy, qz

    def __init__(
        self,
        position: Sequence[float] | Vector = (0.0, 0.0, 0.0),
        orientation: Sequence[float] | Vector = (1.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Makes a frame from a position in m and an orientation, a quaternion w, x, y, z. The
        length of the quaternion must be 1 within UNIT_TOLERANCE; the frame has the normalised
        quaternion. Raises InvalidFrame."""
        x, y, z = map(float, position)
        w, i, j, k = map(float, orientation)
        if not (isfinite(x) and isfinite(y) and isfinite(z)):
            _refuse(f"position {_listed((x, y, z))} m is not finite")
        length = hypot(w, i, j, k)
        if not abs(length - 1) <= self.UNIT_TOLERANCE:
            _refuse(
                f"quaternion w, x, y, z = {_listed((w, i, j, k))} has length {length:.9g}; "
                "a rotation has length 1: normalise it, and check the order w, x, y, z"
            )
        numbers = (x, y, z, w / length, i / length, j / length, k / length)
        object.__setattr__(self, "_numbers", numbers)

    @classmethod
    def _of(cls, numbers: tuple[float, ...]) -> Frame:
        frame = cls.__new__(cls)
        object.__setattr__(frame, "_numbers", numbers)
        return frame

    @staticmethod
    def from_euler_zyz(x: float, y: float, z: float, a: float, b: float, c: float) -> Frame:
        """Makes a frame from a position in m and the Euler angles Rz(a)·Ry'(b)·Rz''(c) in rad, as
        in the paper and V+ (yaw, pitch, roll)."""
        return Frame((x, y, z), _product(_product(_about_z(a), _about_y(b)), _about_z(c)))

    @staticmethod
    def from_euler_zyx(x: float, y: float, z: float, a: float, b: float, c: float) -> Frame:
        """Makes a frame from a position in m and the Euler angles Rz(a)·Ry'(b)·Rx''(c) in rad."""
        return Frame((x, y, z), _product(_product(_about_z(a), _about_y(b)), _about_x(c)))

    @staticmethod
    def from_fixed_xyz(x: float, y: float, z: float, rx: float, ry: float, rz: float) -> Frame:
        """Makes a frame from a position in m and rotations in rad about the fixed axes X, then Y,
        then Z. The paper calls them CXYZ, URDF calls them rpy."""
        return Frame.from_euler_zyx(x, y, z, rz, ry, rx)

    @staticmethod
    def from_axis_angle(
        x: float, y: float, z: float, axis: Sequence[float] | Vector, angle: float
    ) -> Frame:
        """Makes a frame from a position in m and a rotation about `axis`, of any length but 0, by
        `angle` in rad. Raises InvalidFrame."""
        i, j, k = map(float, axis)
        length = hypot(i, j, k)
        if not (length > 0 and isfinite(length)):
            _refuse(f"axis {_listed((i, j, k))} has no direction")
        half = _half(angle)
        sine = sin(half) / length
        return Frame((x, y, z), (cos(half), i * sine, j * sine, k * sine))

    @staticmethod
    def from_quaternion(
        x: float, y: float, z: float, qw: float, qx: float, qy: float, qz: float
    ) -> Frame:
        return Frame((x, y, z), (qw, qx, qy, qz))

    @staticmethod
    def from_matrix(matrix: npt.ArrayLike) -> Frame:
        """Makes a frame from a homogeneous 4x4 matrix. In the quaternion of the frame, the first
        component that is not 0 is positive. Raises InvalidFrame."""
        m = np.asarray(matrix, dtype=np.float64)
        if m.shape != (4, 4):
            _refuse(f"the matrix has shape {m.shape}, it must be (4, 4)")
        if not np.isfinite(m).all():
            _refuse("the matrix has numbers that are not finite")
        tolerance = Frame.UNIT_TOLERANCE
        last = m[3]
        if np.linalg.norm(last - (0, 0, 0, 1)) > tolerance * min(1.0, float(np.linalg.norm(last))):
            _refuse(f"last row of the matrix is {_listed(last)}, it must be (0, 0, 0, 1)")
        turn = m[:3, :3]
        off = float(np.abs(turn.T @ turn - np.eye(3)).max())
        if off > 2 * tolerance:
            _refuse(
                f"the matrix stretches or shears by {off:.6g}; a rotation's columns are at right "
                "angles and of length 1"
            )
        if np.linalg.det(turn) < 0:
            _refuse("the matrix mirrors (its determinant is -1)")
        return Frame(m[:3, 3], _from_rotation(turn))

    @property
    def x(self) -> float:
        return self._numbers[0]

    @property
    def y(self) -> float:
        return self._numbers[1]

    @property
    def z(self) -> float:
        return self._numbers[2]

    @property
    def position(self) -> Vector:
        return np.array(self._numbers[:3])

    @property
    def orientation(self) -> Vector:
        """The quaternion w, x, y, z as an array."""
        return np.array(self._numbers[3:])

    def quaternion(self) -> _Quaternion:
        """The orientation as a quaternion w, x, y, z."""
        _, _, _, w, x, y, z = self._numbers
        return w, x, y, z

    def euler_zyz(self) -> tuple[float, float, float]:
        """Returns the angles a, b, c in rad: b in [0, pi], a and c in [-pi, pi]. c is 0 if b is 0
        or pi."""
        return _zyz_of(self.quaternion())

    def euler_zyx(self) -> tuple[float, float, float]:
        """Returns the angles a, b, c in rad: b in [-pi/2, pi/2], a and c in [-pi, pi]. c is 0 if b
        is ±pi/2."""
        # A quarter of a turn about y takes z to x: Rx(c) = Ry(90)·Rz(c)·Ry(-90).
        a, b, c = _zyz_of(_product(self.quaternion(), _about_y(pi / 2)))
        return a, b - pi / 2, c

    def fixed_xyz(self) -> tuple[float, float, float]:
        """Returns the angles rx, ry, rz in rad. They are the angles of `euler_zyx` in reverse
        order."""
        rz, ry, rx = self.euler_zyx()
        return rx, ry, rz

    def rotation_vector(self) -> Vector:
        """The axis of the rotation times its angle in rad, as an array (3,). Its norm is from 0 to
        pi."""
        w, *axis = self.quaternion()
        sine = hypot(*axis)  # of half the angle
        if sine == 0:
            return np.zeros(3)
        angle = 2 * atan2(sine, abs(w))
        return np.array(axis) * copysign(angle / sine, w)

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> Vector:
        """The homogeneous 4x4 matrix, for `np.asarray(frame)`. The array is always a new one, so
        `copy=False` raises ValueError."""
        if copy is False:
            raise ValueError("a Frame has no array in memory: its matrix is always a new one")
        return self.matrix().astype(np.float64 if dtype is None else dtype, copy=False)

    def rotation(self) -> Vector:
        """The 3x3 rotation matrix."""
        return np.array(_rotation(self.quaternion()))

    def matrix(self) -> Vector:
        """The homogeneous 4x4 matrix."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation()
        matrix[:3, 3] = self._numbers[:3]
        return matrix

    def __mul__(self, right: Frame) -> Frame:
        """Composition of two frames: a_from_c = a_from_b * b_from_c."""
        if not isinstance(right, Frame):
            return NotImplemented
        x, y, z = self._moved(*right._numbers[:3])
        w, i, j, k = _product(self.quaternion(), right.quaternion())
        length = hypot(w, i, j, k)
        return Frame._of((x, y, z, w / length, i / length, j / length, k / length))

    __matmul__ = __mul__

    def inverse(self) -> Frame:
        x, y, z, w, i, j, k = self._numbers
        turned_back = Frame._of((0.0, 0.0, 0.0, w, -i, -j, -k))
        return Frame._of((*turned_back._moved(-x, -y, -z), w, -i, -j, -k))

    def transform(self, point: npt.ArrayLike) -> Vector:
        """Converts a point, or an array (…, 3) of points, from this coordinate system to the
        coordinate system from which this frame is seen."""
        points = np.asarray(point, dtype=np.float64)
        if points.shape[-1:] != (3,):
            raise ValueError(f"a point has 3 numbers; this array has shape {points.shape}")
        if points.ndim == 1:
            return np.array(self._moved(*points.tolist()))
        moved: Vector = points @ self.rotation().T + self._numbers[:3]
        return moved

    def transform_twist(self, twist: Twist) -> Twist:
        """Converts a twist from this coordinate system to the origin and the axes from which this
        frame is seen. With the rotation R and the position p of this frame, the new velocities are
        R·v + p x R·ω (linear) and R·ω (angular)."""
        turning = self.rotation() @ _three(twist.angular)
        moving = self.rotation() @ _three(twist.linear) + np.cross(self.position, turning)
        return Twist(moving, turning)

    def transform_wrench(self, wrench: Wrench) -> Wrench:
        """Converts a wrench from this coordinate system to the origin and the axes from which this
        frame is seen. With the rotation R and the position p of this frame, the new force is R·f,
        and the new torque is R·τ + p x R·f."""
        force = self.rotation() @ _three(wrench.force)
        torque = self.rotation() @ _three(wrench.torque) + np.cross(self.position, force)
        return Wrench(force, torque)

    def _moved(self, px: float, py: float, pz: float) -> tuple[float, float, float]:
        x, y, z, w, i, j, k = self._numbers
        # The rotated point is p + w·t + q x t, with t = 2·(q x p).
        tx = 2 * (j * pz - k * py)
        ty = 2 * (k * px - i * pz)
        tz = 2 * (i * py - j * px)
        return (
            x + px + w * tx + j * tz - k * ty,
            y + py + w * ty + k * tx - i * tz,
            z + pz + w * tz + i * ty - j * tx,
        )

    # The methods of the protocol gecos.wire.Contents. The fields are x, y, z, then w, x, y, z of
    # the quaternion. A decoded frame keeps its exact numbers, so that encoding it again gives the
    # same bytes.

    def encode(self, out: Parts) -> None:
        out.append(_LAYOUT.pack(*self._numbers))

    @classmethod
    def decode(cls, source: Decoder) -> Frame:
        start = source.offset
        numbers = _LAYOUT.unpack(source)
        x, y, z, w, i, j, k = numbers
        if not (isfinite(x) and isfinite(y) and isfinite(z)):
            why = f"{x + y + z:g} is {_NOT_FINITE}"
            source.refuse(DecodeProblem.INVALID_VALUE, "position", start, why)
        length = sqrt(w * w + i * i + j * j + k * k)
        if not abs(length - 1) <= cls.UNIT_TOLERANCE:
            why = f"{length:g} is {_NO_ROTATION}"
            source.refuse(DecodeProblem.INVALID_VALUE, "orientation", start + 24, why)
        return cls._of(numbers)

    @staticmethod
    def fingerprint() -> int:
        """Returns lcm-gen's fingerprint of struct Frame { Vector position; Quaternion orientation;
        }."""
        return 0x249634CE2AA17B5E

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        raise AttributeError(f"a Frame is immutable: {name} cannot be set; make a new Frame")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a Frame is immutable: {name} cannot be deleted; make a new Frame")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Frame) and self._numbers == other._numbers

    def __hash__(self) -> int:
        return hash(self._numbers)

    def __reduce__(self) -> tuple[Any, tuple[tuple[float, ...]]]:
        return Frame._of, (self._numbers,)

    def __repr__(self) -> str:
        return f"Frame.from_quaternion({', '.join(map(repr, self._numbers))})"

    def __str__(self) -> str:
        """Returns a text for display, such as "(452.1, -150.0, 431.8) mm, ZYZ (0.00, 90.00, 0.00)
        deg"."""
        place = ", ".join(f"{in_mm(number) + 0.0:.1f}" for number in self._numbers[:3])
        turn = ", ".join(f"{in_deg(number) + 0.0:.2f}" for number in self.euler_zyz())
        return f"({place}) mm, ZYZ ({turn}) deg"


def translate(x: float, y: float, z: float) -> Frame:
    return Frame((x, y, z))


def rotate_x(angle: float) -> Frame:
    return Frame(orientation=_about_x(angle))


def rotate_y(angle: float) -> Frame:
    return Frame(orientation=_about_y(angle))


def rotate_z(angle: float) -> Frame:
    return Frame(orientation=_about_z(angle))


def interpolate(start: Frame, goal: Frame, part: float) -> Frame:
    """Returns the frame that has travelled the fraction `part` of the way from `start` to `goal`.
    The position moves along a straight line, and the orientation turns about one axis, by the
    shorter way. Raises ValueError unless `part` is from 0 to 1."""
    if not 0 <= part <= 1:
        raise ValueError(f"part is {part}, but it must be from 0 to 1")
    turn = (start.inverse() * goal).rotation_vector()
    angle = hypot(*turn)
    axis = turn if angle > 0 else (1.0, 0.0, 0.0)
    turned = _product(
        start.quaternion(), Frame.from_axis_angle(0, 0, 0, axis, part * angle).quaternion()
    )
    return Frame(start.position + part * (goal.position - start.position), turned)


def distance(left: Frame, right: Frame) -> float:
    """Returns the distance between the two origins in m."""
    return hypot(left.x - right.x, left.y - right.y, left.z - right.z)


def angle(left: Frame, right: Frame) -> float:
    """Returns the angle of the single rotation that turns one orientation into the other, in rad in
    [0, pi]."""
    w, i, j, k = left.quaternion()
    between = _product((w, -i, -j, -k), right.quaternion())
    return 2 * atan2(hypot(*between[1:]), abs(between[0]))


def near(left: Frame, right: Frame, position_tolerance: float, angle_tolerance: float) -> bool:
    return distance(left, right) <= position_tolerance and angle(left, right) <= angle_tolerance


def _half(angle: float) -> float:
    if not isfinite(angle):
        _refuse(f"angle {angle} rad is not finite")
    return angle / 2


def _about_x(angle: float) -> _Quaternion:
    half = _half(angle)
    return cos(half), sin(half), 0.0, 0.0


def _about_y(angle: float) -> _Quaternion:
    half = _half(angle)
    return cos(half), 0.0, sin(half), 0.0


def _about_z(angle: float) -> _Quaternion:
    half = _half(angle)
    return cos(half), 0.0, 0.0, sin(half)


def _product(left: _Quaternion, right: _Quaternion) -> _Quaternion:
    aw, ax, ay, az = left
    bw, bx, by, bz = right
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
    )


def _rotation(q: _Quaternion) -> tuple[tuple[float, ...], ...]:
    w, x, y, z = q
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def _zyz_of(q: _Quaternion) -> tuple[float, float, float]:
    """Returns the Euler angles a, b, c of the rotation Rz(a)·Ry(b)·Rz(c). They are computed from
    the half angles in the quaternion, and are accurate for every rotation."""
    # The quaternion is (cos(b/2)·cos s, -sin(b/2)·sin d, sin(b/2)·cos d, cos(b/2)·sin s) with s
    # = (a + c)/2 and d = (a - c)/2.
    w, x, y, z = q
    cosine = hypot(w, z)
    sine = hypot(x, y)
    total = atan2(z, w)
    difference = atan2(-x, y)
    b = 2 * atan2(sine, cosine)
    if sine < _PARALLEL_AXES:
        return _wrapped(2 * total), b, 0.0
    if cosine < _PARALLEL_AXES:
        return _wrapped(2 * difference), b, 0.0
    return _wrapped(total + difference), b, _wrapped(total - difference)


def _from_rotation(turn: Vector) -> _Quaternion:
    """Returns the quaternion of a 3x3 rotation matrix. Its first component that is not 0 is
    positive. The other components are computed from the largest one, so that rounding loses none of
    them. C++ does the same arithmetic, so both languages choose the same sign, also for rotations
    near half a turn."""
    (a, b, c), (d, e, f), (g, h, i) = turn.tolist()
    candidates = (
        (1 + a + e + i, h - f, c - g, d - b),
        (h - f, 1 + a - e - i, b + d, c + g),
        (c - g, b + d, 1 - a + e - i, f + h),
        (d - b, c + g, f + h, 1 - a - e + i),
    )
    largest = max(range(4), key=lambda part: candidates[part][part])
    w, x, y, z = candidates[largest]
    length = copysign(hypot(w, x, y, z), next(part for part in (w, x, y, z) if part != 0))
    return w / length, x / length, y / length, z / length


def _three(vector: npt.ArrayLike) -> Vector:
    numbers = np.asarray(vector, dtype=np.float64)
    if numbers.shape != (3,):
        raise ValueError(f"a vector has 3 numbers; this array has shape {numbers.shape}")
    return numbers


def _wrapped(angle: float) -> float:
    return remainder(angle, 2 * pi)


def _listed(numbers: Sequence[float] | Vector) -> str:
    return f"({', '.join(f'{number:.9g}' for number in numbers)})"


def _refuse(what: str) -> NoReturn:
    raise InvalidFrame(f"frame: {what}")
