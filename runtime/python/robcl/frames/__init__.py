"""Frames: position and orientation of one coordinate system, seen from another.

The names are the same in C++ (`robcl/frames/frame.hpp`) and Python::

    make     translate(x, y, z)   rotate_x(a)   rotate_y(a)   rotate_z(a)   Frame(): the identity
             Frame.from_euler_zyz(x, y, z, a, b, c)     Rz(a)·Ry'(b)·Rz''(c), as in the paper and V+
             Frame.from_euler_zyx(x, y, z, a, b, c)     Rz(a)·Ry'(b)·Rx''(c)
             Frame.from_fixed_xyz(x, y, z, rx, ry, rz)  turns about the fixed axes X, then Y, then Z
                                                        (the paper's CXYZ, URDF's rpy)
             Frame.from_axis_angle(x, y, z, axis, angle)
             Frame.from_quaternion(x, y, z, qw, qx, qy, qz)
             Frame.from_matrix(m)                       4x4, homogeneous
    read     f.x f.y f.z  f.euler_zyz()  f.euler_zyx()  f.fixed_xyz()  f.quaternion()  f.matrix()
             f.rotation_vector(): axis times angle
    compute  a * b (or a @ b)   f.inverse()   f.transform(point)   distance(a, b)   angle(a, b)
             near(a, b, position_tolerance, angle_tolerance)   interpolate(a, b, part)
             f.transform_twist(Twist(…))   f.transform_wrench(Wrench(…))
    units    metres and radians; mm(200), deg(90)

In a correct product adjacent names match: world_from_tool = world_from_base * base_from_tool.
"""

from robcl.frames.frame import (
    Frame,
    InvalidFrame,
    Twist,
    Wrench,
    angle,
    distance,
    interpolate,
    near,
    rotate_x,
    rotate_y,
    rotate_z,
    translate,
)
from robcl.frames.units import deg, in_deg, in_mm, mm

__all__ = [
    "Frame",
    "InvalidFrame",
    "Twist",
    "Wrench",
    "angle",
    "deg",
    "distance",
    "in_deg",
    "in_mm",
    "interpolate",
    "mm",
    "near",
    "rotate_x",
    "rotate_y",
    "rotate_z",
    "translate",
]
