// Frames. A frame is the position and orientation of one coordinate system, seen from another one.
//
// C++ and Python have the same functions (`from robcl.frames import Frame, translate, mm, deg`):
//
//   make     translate(x, y, z)   rotate_x(a)   rotate_y(a)   rotate_z(a)
//            Frame()                                    identity
//            Frame.from_euler_zyz(x, y, z, a, b, c)     Rz(a)·Ry'(b)·Rz''(c), also V+'s angles
//            Frame.from_euler_zyx(x, y, z, a, b, c)     Rz(a)·Ry'(b)·Rx''(c)
//            Frame.from_fixed_xyz(x, y, z, rx, ry, rz)  about fixed X, then Y, then Z: URDF's rpy,
//                                                       equal to euler_zyx(rz, ry, rx)
//            Frame.from_quaternion(x, y, z, qw, qx, qy, qz)
//            Frame.from_matrix(m)                       4×4, homogeneous
//   read     f.x   f.y   f.z (in C++ f.x(), f.y(), f.z())   f.euler_zyz()   f.euler_zyx()
//            f.fixed_xyz()   f.quaternion()   f.matrix()
//   compute  a * b   f.inverse()   f.transform(point)   distance(a, b)   angle(a, b)
//            near(a, b, position_tolerance, angle_tolerance)
//   units    metres and radians; mm(200), deg(90), in C++ also 200_mm, 90_deg
//
// The names of frames in a product should cancel: world_from_tool = world_from_base *
// base_from_tool.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <stdexcept>
#include <string>

#include "gecos/wire/decoder.hpp"
#include "gecos/wire/encoder.hpp"
#include "robcl/frames/units.hpp"

namespace robcl {

/// The exception for values that do not describe a rigid transformation. Examples are a value that
/// is not finite, a quaternion without unit length, and a matrix that stretches, shears, mirrors or
/// projects. The text says which value is wrong, and by how much.
class InvalidFrame : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The velocity of a rigid body: the velocity of the point of the body that is at the origin, in
/// m/s, and the velocity of its rotation, in rad/s. Both vectors are along the axes of one
/// coordinate system.
struct Twist {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
};

/// A force in N on a rigid body, and its torque about the origin in N·m, along the axes of one
/// coordinate system.
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
};

/// Returns the rotation vector of `turn`: the unit vector along the axis of the rotation,
/// multiplied by the angle of the rotation in rad. The angle is in [0, pi].
Eigen::Vector3d rotation_vector(Eigen::Quaterniond turn);

/// The position, in m, and the orientation of a coordinate system, seen from another coordinate
/// system. The type is a value type of 56 bytes with the alignment of a double. A quaternion and
/// its negative are the same orientation, but `==` returns false for them.
///
/// The class has more methods than other classes, because each representation of a rotation needs
/// one method that makes a frame from it, and one method that returns it.
class Frame {
 public:
  /// The length of a quaternion, or of a column of a rotation matrix, may differ from 1 by this
  /// tolerance, which allows for rounding to single precision. If the difference is larger, a
  /// constructor throws and decoding fails.
  static constexpr double unit_tolerance = 1e-6;

  /// Makes the identity, for which both coordinate systems are the same.
  Frame() = default;
  /// Makes a frame, and normalises `orientation`. Throws InvalidFrame for invalid values.
  Frame(const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation);

  /// The functions `from_…` make a frame. Lengths are in metres and angles in radians. All of them
  /// throw InvalidFrame for invalid values.
  static Frame from_euler_zyz(double x, double y, double z, double a, double b, double c);
  static Frame from_euler_zyx(double x, double y, double z, double a, double b, double c);
  static Frame from_fixed_xyz(double x, double y, double z, double rx, double ry, double rz);
  /// The orientation is the rotation by `angle` about `axis`, a vector of any length but 0.
  static Frame from_axis_angle(double x, double y, double z, const Eigen::Vector3d& axis,
                               double angle);
  static Frame from_quaternion(double x, double y, double z, double qw, double qx, double qy,
                               double qz);
  /// In the quaternion of the new frame, the first component that is not 0 is positive.
  static Frame from_matrix(const Eigen::Matrix4d& matrix);

  double x() const { return position_.x(); }
  double y() const { return position_.y(); }
  double z() const { return position_.z(); }
  const Eigen::Vector3d& position() const { return position_; }
  Eigen::Quaterniond orientation() const { return Eigen::Quaterniond(orientation_); }

  /// Returns the ZYZ Euler angles a, b, c in rad. b is in [0, pi]; a and c are in [-pi, pi]. c is 0
  /// if b is 0 or pi.
  std::array<double, 3> euler_zyz() const;
  /// Returns the ZYX Euler angles a, b, c in rad. b is in [-pi/2, pi/2]; a and c are in [-pi, pi].
  /// c is 0 if b is ±pi/2.
  std::array<double, 3> euler_zyx() const;
  /// Returns the angles rx, ry, rz about the fixed axes in rad. They are the angles of `euler_zyx`
  /// in reverse order.
  std::array<double, 3> fixed_xyz() const;
  /// Returns the rotation vector of the orientation: the unit vector along the axis of the
  /// rotation, multiplied by the angle of the rotation in rad. The angle is in [0, pi].
  Eigen::Vector3d rotation_vector() const { return robcl::rotation_vector(orientation()); }
  /// Returns the orientation as a quaternion w, x, y, z.
  std::array<double, 4> quaternion() const;
  Eigen::Matrix4d matrix() const;
  Eigen::Matrix3d rotation() const { return orientation().toRotationMatrix(); }

  /// Composes two frames: a_from_c = a_from_b * b_from_c.
  friend Frame operator*(const Frame& left, const Frame& right);
  Frame inverse() const;
  /// Converts a point from this frame's coordinate system to the coordinate system from which this
  /// frame is seen.
  Eigen::Vector3d transform(const Eigen::Vector3d& point) const;
  /// Converts a twist or a wrench from this frame's coordinate system to the coordinate system from
  /// which this frame is seen. With the rotation R and the position p of this frame, a twist (v, ω)
  /// becomes (R·v + p × R·ω, R·ω), and a wrench (f, τ) becomes (R·f, R·τ + p × R·f).
  Twist transform_twist(const Twist& twist) const;
  Wrench transform_wrench(const Wrench& wrench) const;

  /// Compares two frames exactly, value by value. The function `near` compares them with
  /// tolerances.
  friend bool operator==(const Frame& left, const Frame& right);
  friend bool operator!=(const Frame& left, const Frame& right) { return !(left == right); }

  // The following functions implement GeneralContents. The layout is that of `robcl::Frame` in
  // idl/robcl/geometry.gidl: x, y, z, and then w, x, y, z of the quaternion. Decoding does not
  // normalise the quaternion, so that encoding a decoded frame gives the same bytes again.
  std::size_t encoded_size() const { return 7 * sizeof(double); }
  void encode(gecos::wire::Encoder& to) const;
  bool decode(gecos::wire::Decoder& from);
  static std::int64_t fingerprint();

 private:
  using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();
  Quaternion orientation_ = Quaternion::Identity();
};

Frame translate(double x, double y, double z);
Frame rotate_x(double angle);
Frame rotate_y(double angle);
Frame rotate_z(double angle);

/// Returns the frame after the fraction `part` of the way from `start` to `goal`: the position
/// moves along a straight line, and the orientation turns about one axis, by the shorter way.
/// Throws std::invalid_argument unless `part` is from 0 to 1.
Frame interpolate(const Frame& start, const Frame& goal, double part);

/// Returns the distance between the origins of two frames, in m.
double distance(const Frame& left, const Frame& right);
/// Returns the angle of the rotation from one orientation to the other, in rad. The angle is in [0,
/// pi]. The result is accurate also for small angles.
double angle(const Frame& left, const Frame& right);
bool near(const Frame& left, const Frame& right, double position_tolerance, double angle_tolerance);

/// Prints a frame for people, for example "(452.1, -150.0, 431.8) mm, ZYZ (0.00, 90.00, 0.00) deg".
/// The values are rounded; programs should use `encode`.
std::ostream& operator<<(std::ostream& out, const Frame& frame);
std::string to_string(const Frame& frame);

}  // namespace robcl
