#include "robcl/frames/frame.hpp"

#include <array>
#include <cmath>
#include <iomanip>
#include <ostream>
#include <sstream>

namespace robcl {
namespace {

/// The error messages of a decoder contain "<number> is ", followed by one of these two texts.
constexpr char not_finite[] = "the sum of the coordinates, which must be finite";
constexpr char no_rotation[] =
    "the length of the orientation's quaternion, which must be 1; without rotation, w is 1";

// A threshold for sin(b/2) and cos(b/2), where b is the middle one of the ZYZ Euler angles a, b, c.
// If either value is below the threshold, the angles a and c turn about the same axis, and c is set
// to 0. For ZYX Euler angles, b + 90 degrees takes the place of b.
constexpr double parallel_axes = 1e-9;

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

[[noreturn]] void refuse(const std::string& what) { throw InvalidFrame("frame: " + what); }

Eigen::Quaterniond about(const Eigen::Vector3d& axis, double angle) {
  if (!std::isfinite(angle)) refuse("angle " + std::to_string(angle) + " rad is not finite");
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
}

/// Returns the quaternion of a rotation matrix. The first nonzero component of the quaternion is
/// positive. The largest component is computed first, so that rounding errors of the other
/// components stay small. The Python class Frame does the same arithmetic, so that both languages
/// give the same sign even near half a turn.
Eigen::Quaterniond from_rotation(const Eigen::Matrix3d& m) {
  const double a = m(0, 0), b = m(0, 1), c = m(0, 2);
  const double d = m(1, 0), e = m(1, 1), f = m(1, 2);
  const double g = m(2, 0), h = m(2, 1), i = m(2, 2);
  const std::array<Eigen::Vector4d, 4> candidates{{{1 + a + e + i, h - f, c - g, d - b},
                                                   {h - f, 1 + a - e - i, b + d, c + g},
                                                   {c - g, b + d, 1 - a + e - i, f + h},
                                                   {d - b, c + g, f + h, 1 - a - e + i}}};
  std::size_t largest = 0;
  for (std::size_t part = 1; part < 4; ++part) {
    const auto at = [&](std::size_t k) { return candidates[k][static_cast<Eigen::Index>(k)]; };
    if (at(part) > at(largest)) largest = part;
  }
  Eigen::Vector4d wxyz = candidates[largest].normalized();
  for (const double part : wxyz) {
    if (part == 0) continue;
    if (part < 0) wxyz = -wxyz;
    break;
  }
  return {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
}

/// Returns the Euler angles a, b, c of the rotation Rz(a)·Ry(b)·Rz(c). Computes these angles from
/// (a+c)/2, (a-c)/2 and b/2, so that they are accurate for every rotation.
std::array<double, 3> zyz_of(const Eigen::Quaterniond& q) {
  // With s = (a+c)/2 and d = (a-c)/2, the quaternion w, x, y, z is cos(b/2)·cos s, -sin(b/2)·sin d,
  // sin(b/2)·cos d, cos(b/2)·sin s.
  const double cosine = std::hypot(q.w(), q.z());
  const double sine = std::hypot(q.x(), q.y());
  const double sum = std::atan2(q.z(), q.w());
  const double difference = std::atan2(-q.x(), q.y());
  const double b = 2 * std::atan2(sine, cosine);
  if (sine < parallel_axes) return {wrapped(2 * sum), b, 0};
  if (cosine < parallel_axes) return {wrapped(2 * difference), b, 0};
  return {wrapped(sum + difference), b, wrapped(sum - difference)};
}

template <typename Numbers>
std::string listed(const Numbers& numbers) {
  std::ostringstream text;
  text << std::setprecision(9) << "(";
  for (Eigen::Index i = 0; i < numbers.size(); ++i) text << (i ? ", " : "") << numbers.data()[i];
  text << ")";
  return text.str();
}

}  // namespace

Frame::Frame(const Eigen::Vector3d& position, const Eigen::Quaterniond& orientation)
    : position_(position), orientation_(orientation.normalized()) {
  if (!position.allFinite()) refuse("position " + listed(position) + " m is not finite");
  const double length = orientation.norm();
  if (!(std::abs(length - 1) <= unit_tolerance)) {  // this comparison also refuses NaN
    const Eigen::Vector4d wxyz(orientation.w(), orientation.x(), orientation.y(), orientation.z());
    std::ostringstream text;
    text << "quaternion w, x, y, z = " << listed(wxyz) << " has length " << std::setprecision(9)
         << length << "; a rotation has length 1: normalise it, and check the order w, x, y, z";
    refuse(text.str());
  }
}

Frame Frame::from_euler_zyz(double x, double y, double z, double a, double b, double c) {
  return Frame({x, y, z}, about(Eigen::Vector3d::UnitZ(), a) * about(Eigen::Vector3d::UnitY(), b) *
                              about(Eigen::Vector3d::UnitZ(), c));
}

Frame Frame::from_euler_zyx(double x, double y, double z, double a, double b, double c) {
  return Frame({x, y, z}, about(Eigen::Vector3d::UnitZ(), a) * about(Eigen::Vector3d::UnitY(), b) *
                              about(Eigen::Vector3d::UnitX(), c));
}

Frame Frame::from_fixed_xyz(double x, double y, double z, double rx, double ry, double rz) {
  return from_euler_zyx(x, y, z, rz, ry, rx);
}

Frame Frame::from_axis_angle(double x, double y, double z, const Eigen::Vector3d& axis,
                             double angle) {
  const double length = axis.norm();
  if (!(length > 0 && std::isfinite(length))) {
    refuse("axis " + listed(axis) + " has no direction");
  }
  return Frame({x, y, z}, about(axis / length, angle));
}

Frame Frame::from_quaternion(double x, double y, double z, double qw, double qx, double qy,
                             double qz) {
  return Frame({x, y, z}, Eigen::Quaterniond(qw, qx, qy, qz));
}

Frame Frame::from_matrix(const Eigen::Matrix4d& matrix) {
  if (!matrix.allFinite()) refuse("the matrix has numbers that are not finite");
  const Eigen::RowVector4d last = matrix.row(3);
  if (!last.isApprox(Eigen::RowVector4d(0, 0, 0, 1), unit_tolerance)) {
    refuse("last row of the matrix is " + listed(last) + ", it must be (0, 0, 0, 1)");
  }
  const Eigen::Matrix3d turn = matrix.topLeftCorner<3, 3>();
  const double off = (turn.transpose() * turn - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (off > 2 * unit_tolerance) {
    std::ostringstream text;
    text << "the matrix stretches or shears by " << off
         << "; a rotation's columns are at right angles "
         << "and of length 1";
    refuse(text.str());
  }
  if (turn.determinant() < 0) refuse("the matrix mirrors (its determinant is -1)");
  return Frame(matrix.topRightCorner<3, 1>(), from_rotation(turn));
}

std::array<double, 3> Frame::euler_zyz() const { return zyz_of(orientation()); }

std::array<double, 3> Frame::euler_zyx() const {
  // A quarter of a turn about y takes z to x: Rx(c) = Ry(90)·Rz(c)·Ry(-90).
  auto [a, b, c] = zyz_of(orientation() * about(Eigen::Vector3d::UnitY(), deg(90)));
  return {a, b - deg(90), c};
}

std::array<double, 3> Frame::fixed_xyz() const {
  const auto [rz, ry, rx] = euler_zyx();
  return {rx, ry, rz};
}

Eigen::Vector3d rotation_vector(Eigen::Quaterniond turn) {
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();  // of half the angle
  if (sine == 0) return Eigen::Vector3d::Zero();
  return turn.vec() * (2 * std::atan2(sine, turn.w()) / sine);
}

std::array<double, 4> Frame::quaternion() const {
  return {orientation_.w(), orientation_.x(), orientation_.y(), orientation_.z()};
}

Eigen::Matrix4d Frame::matrix() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = rotation();
  matrix.topRightCorner<3, 1>() = position_;
  return matrix;
}

Frame operator*(const Frame& left, const Frame& right) {
  Frame product;
  product.position_ = left.transform(right.position_);
  product.orientation_ = (left.orientation_ * right.orientation_).normalized();
  return product;
}

Frame Frame::inverse() const {
  Frame back;
  back.orientation_ = orientation_.conjugate();
  back.position_ = back.orientation_ * Eigen::Vector3d(-position_);
  return back;
}

Eigen::Vector3d Frame::transform(const Eigen::Vector3d& point) const {
  return position_ + orientation_ * point;
}

Twist Frame::transform_twist(const Twist& twist) const {
  const Eigen::Vector3d turning = orientation_ * twist.angular;
  return {orientation_ * twist.linear + position_.cross(turning), turning};
}

Wrench Frame::transform_wrench(const Wrench& wrench) const {
  const Eigen::Vector3d force = orientation_ * wrench.force;
  return {force, orientation_ * wrench.torque + position_.cross(force)};
}

bool operator==(const Frame& left, const Frame& right) {
  return left.position_ == right.position_ &&
         left.orientation_.coeffs() == right.orientation_.coeffs();
}

void Frame::encode(gecos::wire::Encoder& to) const {
  for (const double metres : {x(), y(), z()}) to.put(metres);
  for (const double part : quaternion()) to.put(part);
}

bool Frame::decode(gecos::wire::Decoder& from) {
  using gecos::wire::DecodeProblem;
  Eigen::Vector3d position;
  for (double& metres : position) {
    if (!from.get(metres, "position")) return false;
  }
  double w = 0, i = 0, j = 0, k = 0;
  for (double* part : {&w, &i, &j, &k}) {
    if (!from.get(*part, "orientation")) return false;
  }
  if (!position.allFinite()) {
    return from.fail_number(DecodeProblem::InvalidValue, position.sum(), not_finite,
                            7 * sizeof(double), "position");
  }
  const double length = std::sqrt(w * w + i * i + j * j + k * k);
  if (!(std::abs(length - 1) <= unit_tolerance)) {
    return from.fail_number(DecodeProblem::InvalidValue, length, no_rotation, 4 * sizeof(double),
                            "orientation");
  }
  position_ = position;
  orientation_ = Quaternion(w, i, j, k);
  return true;
}

std::int64_t Frame::fingerprint() {
  // This is the fingerprint that lcm-gen computes for struct Frame { Vector position; Quaternion
  // orientation; }.
  return 0x249634ce2aa17b5e;
}

Frame translate(double x, double y, double z) {
  return Frame({x, y, z}, Eigen::Quaterniond::Identity());
}

Frame rotate_x(double angle) {
  return Frame(Eigen::Vector3d::Zero(), about(Eigen::Vector3d::UnitX(), angle));
}

Frame rotate_y(double angle) {
  return Frame(Eigen::Vector3d::Zero(), about(Eigen::Vector3d::UnitY(), angle));
}

Frame rotate_z(double angle) {
  return Frame(Eigen::Vector3d::Zero(), about(Eigen::Vector3d::UnitZ(), angle));
}

Frame interpolate(const Frame& start, const Frame& goal, double part) {
  if (!(part >= 0 && part <= 1)) {
    throw std::invalid_argument("part is " + std::to_string(part) + ", but it must be from 0 to 1");
  }
  const Eigen::Vector3d way = goal.position() - start.position();
  const Eigen::Vector3d turn =
      rotation_vector(start.orientation().conjugate() * goal.orientation());
  const double angle = turn.norm();
  const Eigen::Vector3d axis = angle > 0 ? Eigen::Vector3d(turn / angle) : Eigen::Vector3d::UnitX();
  return Frame(start.position() + part * way, start.orientation() * about(axis, part * angle));
}

double distance(const Frame& left, const Frame& right) {
  return (left.position() - right.position()).norm();
}

double angle(const Frame& left, const Frame& right) {
  const Eigen::Quaterniond between = left.orientation().conjugate() * right.orientation();
  return 2 * std::atan2(between.vec().norm(), std::abs(between.w()));
}

bool near(const Frame& left, const Frame& right, double position_tolerance,
          double angle_tolerance) {
  return distance(left, right) <= position_tolerance && angle(left, right) <= angle_tolerance;
}

std::ostream& operator<<(std::ostream& out, const Frame& frame) { return out << to_string(frame); }

std::string to_string(const Frame& frame) {
  const auto [a, b, c] = frame.euler_zyz();
  std::ostringstream text;
  const auto put = [&text](double value, double unit) {
    text << std::round(value / unit) * unit + 0.0;  // + 0.0 turns -0 into 0
    return ", ";
  };
  text << std::fixed << std::setprecision(1) << "(";
  text << put(in_mm(frame.x()), 0.1);
  text << put(in_mm(frame.y()), 0.1);
  put(in_mm(frame.z()), 0.1);
  text << ") mm, ZYZ (" << std::setprecision(2);
  text << put(in_deg(a), 0.01);
  text << put(in_deg(b), 0.01);
  put(in_deg(c), 0.01);
  text << ") deg";
  return text.str();
}

}  // namespace robcl
