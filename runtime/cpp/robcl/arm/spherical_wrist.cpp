#include "robcl/arm/spherical_wrist.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <optional>
#include <random>
#include <sstream>
#include <stdexcept>

namespace robcl::arm {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double geometry_tolerance = 1e-6;  // m or rad: rounding of a URDF's values
// A goal that is out of reach by less than this distance, in m, counts as reachable, because of
// rounding errors.
constexpr double stretched = 1e-9;
// If the wrist centre is nearer to axis 1 than this distance, in m, joint 1 may have any position.
// The same is true for axis 2 and joint 2.
constexpr double singular = 1e-9;
// If one of the three measures in configuration.hpp is nearer to 0 than this value, the arm counts
// as singular, and the corresponding member of the configuration is empty. The value is not
// smaller, because a rounding error of 1e-16 changes the angles of a stretched arm by 1e-8. If the
// elbow is closer than this value, in rad, to the stretched position, it counts as stretched, which
// moves the wrist centre by 1e-15 m.
constexpr double aligned = 1e-7;
// If joint 5 is closer than this angle, in rad, to the position where axes 4 and 6 are in one line,
// joint 4 keeps the position of the reference.
constexpr double in_line_below = 1e-11;

double angle_of(const Vector2d& in_plane) { return std::atan2(in_plane.x(), in_plane.y()); }

Vector2d at_angle(double length, double angle) {
  return {length * std::sin(angle), length * std::cos(angle)};
}

struct Line {
  Vector3d point;
  Vector3d direction;
};

/// Returns the point of line `a` that is nearest to line `b`; nullopt if the lines are parallel.
std::optional<Vector3d> meeting_point(const Line& a, const Line& b) {
  const double cosine = a.direction.dot(b.direction);
  const double denominator = 1 - cosine * cosine;
  if (denominator < geometry_tolerance) return std::nullopt;  // parallel
  const Vector3d between = b.point - a.point;
  const double along = (between.dot(a.direction) - cosine * between.dot(b.direction)) / denominator;
  return Vector3d(a.point + along * a.direction);
}

double distance_to(const Line& line, const Vector3d& point) {
  return (point - line.point).cross(line.direction).norm();
}

std::vector<Line> axes_at_zero(const KDL::Chain& shared) {
  const KDL::Chain chain = shared;  // a copy, because KDL::Joint caches its last pose
  std::vector<Line> lines;
  KDL::Frame base_from_here = KDL::Frame::Identity();
  for (unsigned i = 0; i < chain.getNrOfSegments(); ++i) {
    const KDL::Segment& segment = chain.getSegment(i);
    const KDL::Joint& joint = segment.getJoint();
    if (joint.getType() != KDL::Joint::None) {
      lines.push_back({to_eigen(base_from_here * joint.JointOrigin()),
                       to_eigen(base_from_here.M * joint.JointAxis()).normalized()});
    }
    base_from_here = base_from_here * segment.pose(0);
  }
  return lines;
}

template <typename Choice>
std::optional<Choice> by_sign(double measure, Choice positive, Choice negative) {
  if (std::abs(measure) < aligned) return std::nullopt;
  return measure > 0 ? positive : negative;
}

}  // namespace

std::unique_ptr<SphericalWristInverse> SphericalWristInverse::for_arm(const ArmModel& model) {
  std::unique_ptr<SphericalWristInverse> solver(new SphericalWristInverse(model));
  if (!solver->measure_geometry() || !solver->verify()) return nullptr;
  solver->look_at_front();
  return solver;
}

void SphericalWristInverse::look_at_front() {
  above_ = axes_[0].z() < 0 ? -1 : 1;  // heights count along the base's z
  if (!model_.front()) return;
  const Configuration now = configuration(*model_.front());
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(model_.name() + ": 'front' " + why +
                                "; give joint positions with the elbow up, the wrist in front of "
                                "the shoulder and the flange bent up");
  };
  if (!now.shoulder || !now.elbow || !now.wrist) refuse("is at a singularity of the arm");
  if (*now.elbow != Elbow::Above) refuse("has the elbow below the line from shoulder to wrist");
  if (*now.shoulder == Shoulder::Lefty) righty_ = -1;
  if (*now.wrist == Wrist::Flip) noflip_ = -1;
}

bool SphericalWristInverse::measure_geometry() {
  if (model_.axes() != 6) return false;
  const std::vector<Line> lines = axes_at_zero(model_.chain());
  for (std::size_t i = 0; i < 6; ++i) axes_[i] = lines[i].direction;
  const auto square = [&](std::size_t a, std::size_t b) {
    return std::abs(axes_[a].dot(axes_[b])) < geometry_tolerance;
  };
  const bool parallel_2_3 = axes_[1].cross(axes_[2]).norm() < geometry_tolerance;
  if (!square(0, 1) || !parallel_2_3 || !square(3, 4) || !square(4, 5)) return false;
  const std::optional<Vector3d> wrist = meeting_point(lines[3], lines[4]);
  for (std::size_t i = 3; i < 6; ++i) {
    if (distance_to(lines[i], *wrist) > geometry_tolerance) return false;
  }

  const Frame zero = Kinematics(model_).base_from_flange(JointValues::Zero(6));
  zero_turn_ = zero.rotation();
  flange_to_wrist_ = zero.inverse().transform(*wrist);

  base_from_plane_ << axes_[1].cross(axes_[0]), axes_[1], axes_[0];
  origin_ = lines[0].point + axes_[0] * axes_[0].dot(lines[1].point - lines[0].point);
  const auto in_plane = [&](const Vector3d& point) {
    const Vector3d seen = base_from_plane_.transpose() * (point - origin_);
    return Vector2d(seen.x(), seen.z());
  };
  const Vector2d shoulder = in_plane(lines[1].point);
  const Vector2d elbow = in_plane(lines[2].point);
  const Vector2d wrist_in_plane = in_plane(*wrist);
  shoulder_ = shoulder.x();
  lateral_ = axes_[1].dot(*wrist - origin_);
  upper_arm_ = (elbow - shoulder).norm();
  upper_arm_angle_ = angle_of(elbow - shoulder);
  forearm_ = (wrist_in_plane - elbow).norm();
  forearm_angle_ = angle_of(wrist_in_plane - elbow);
  third_sign_ = axes_[1].dot(axes_[2]) > 0 ? 1 : -1;
  if (upper_arm_ < geometry_tolerance || forearm_ < geometry_tolerance) return false;

  base_from_wrist_ << axes_[4].cross(axes_[3]), axes_[4], axes_[3];
  Vector3d sixth = base_from_wrist_.transpose() * axes_[5];
  sixth_sign_ = sixth.z() < 0 ? -1 : 1;
  sixth *= sixth_sign_;
  sixth_tilt_ = std::atan2(sixth.x(), sixth.z());
  return true;
}

bool SphericalWristInverse::verify() {
  Kinematics forward(model_);
  std::minstd_rand random(90);
  for (int round = 0; round < 64; ++round) {
    JointValues joints(6);
    for (Eigen::Index i = 0; i < 6; ++i) {
      joints[i] = std::uniform_real_distribution<double>(-3, 3)(random);
    }
    const Frame pose = forward.base_from_flange(joints);
    const Solutions found = all(pose, joints);
    bool same_joints = false;
    for (std::size_t i = 0; i < found.count; ++i) {
      const JointValues& solution = found.each[i].joints;
      if (!near(forward.base_from_flange(solution), pose, 1e-7, 1e-7)) return false;
      same_joints |= (solution - joints).cwiseAbs().maxCoeff() < 1e-5;
    }
    if (!same_joints) return false;
  }
  return true;
}

SphericalWristInverse::Solutions SphericalWristInverse::all(const Frame& base_from_flange,
                                                            const JointValues& reference,
                                                            const Configuration& wanted) const {
  Solutions found;
  const Vector3d wrist =
      base_from_plane_.transpose() * (base_from_flange.transform(flange_to_wrist_) - origin_);
  const double from_axis = std::hypot(wrist.x(), wrist.y());
  if (from_axis < std::abs(lateral_) - stretched) return found;
  const double forward = std::sqrt(std::max(0.0, from_axis * from_axis - lateral_ * lateral_));

  for (const double side : {1.0, -1.0}) {
    Configuration configuration;
    configuration.shoulder = side * righty_ > 0 ? Shoulder::Righty : Shoulder::Lefty;
    if (!wanted.admits(configuration)) continue;
    const double along = side * forward;  // distance of the wrist centre from axis 1
    const double first = from_axis < singular
                             ? reference[0]
                             : std::atan2(wrist.y(), wrist.x()) - std::atan2(lateral_, along);
    const Vector2d target(along - shoulder_, wrist.z());
    const double length = target.norm();
    if (length > upper_arm_ + forearm_ + stretched) continue;
    if (length < std::abs(upper_arm_ - forearm_) - stretched) continue;
    const double target_angle =
        length < singular ? reference[1] + upper_arm_angle_ : angle_of(target);
    const double cosine = length < singular
                              ? 1.0
                              : (upper_arm_ * upper_arm_ + length * length - forearm_ * forearm_) /
                                    (2 * upper_arm_ * length);
    const double elbow_angle = std::acos(std::clamp(cosine, -1.0, 1.0));
    const double at_shoulder = elbow_angle < aligned ? 0.0 : elbow_angle;
    for (const double bend : {1.0, -1.0}) {
      configuration.elbow = side * bend * above_ < 0 ? Elbow::Above : Elbow::Below;
      if (!wanted.admits(configuration)) continue;
      const double upper = target_angle + bend * at_shoulder;
      const Vector2d elbow = at_angle(upper_arm_, upper);
      const double second = upper - upper_arm_angle_;
      const double third = third_sign_ * (angle_of(target - elbow) - forearm_angle_ - second);
      add_wrists(base_from_flange, {first, second, third}, reference, configuration, wanted, found);
    }
  }
  return found;
}

void SphericalWristInverse::add_wrists(const Frame& base_from_flange, const Vector3d& first_three,
                                       const JointValues& reference, Configuration configuration,
                                       const Configuration& wanted, Solutions& found) const {
  const Matrix3d arm = (AngleAxisd(first_three[0], axes_[0]) *
                        AngleAxisd(first_three[1], axes_[1]) * AngleAxisd(first_three[2], axes_[2]))
                           .toRotationMatrix();
  // `left` is the rotation that joints 4 to 6 must make, in the frame of the wrist: Rz(q4)·Ry(q5 +
  // tilt)·Rz(±q6).
  const Matrix3d left = base_from_wrist_.transpose() * arm.transpose() *
                        base_from_flange.rotation() * zero_turn_.transpose() * base_from_wrist_ *
                        AngleAxisd(sixth_tilt_, Vector3d::UnitY()).toRotationMatrix();
  // If axes 4 and 6 are in one line, any value of q4 is a solution. If they are nearly in one line,
  // q4 is not exact, and therefore the other two joints are computed from q4.
  const bool in_line = std::hypot(left(0, 2), left(1, 2)) < in_line_below;
  double fourth = in_line ? reference[3] : std::atan2(left(1, 2), left(0, 2));
  const double c = std::cos(fourth), s = std::sin(fourth);
  double bend = std::atan2(c * left(0, 2) + s * left(1, 2), left(2, 2));
  double sixth = std::atan2(c * left(1, 0) - s * left(0, 0), c * left(1, 1) - s * left(0, 1));
  for (const double sign : {1.0, -1.0}) {
    configuration.wrist = sign * noflip_ > 0 ? Wrist::Noflip : Wrist::Flip;
    if (wanted.admits(configuration)) {
      Solution& solution = found.each[found.count++];
      solution.configuration = configuration;
      solution.joints.resize(6);
      solution.joints << first_three, fourth, bend - sixth_tilt_, sixth_sign_ * sixth;
      for (Eigen::Index i = 0; i < 6; ++i) {
        solution.joints[i] = nearest_angle(solution.joints[i], reference[i]);
      }
    }
    bend = -bend;
    if (!in_line) {
      fourth += std::numbers::pi;
      sixth += std::numbers::pi;
    }
  }
}

tl::expected<JointValues, Failure> SphericalWristInverse::solve(const Frame& base_from_flange,
                                                                const JointValues& reference,
                                                                const Configuration& wanted) {
  Solutions found = all(base_from_flange, reference, wanted);
  if (found.count == 0) {
    if (all(base_from_flange, reference).count == 0) {
      return tl::unexpected(OutOfReach{why_out_of_reach(base_from_flange)});
    }
    std::ostringstream text;
    text << "no solution in the configuration " << wanted << "; another configuration has one";
    return tl::unexpected(OutOfReach{text.str()});
  }
  const JointValues* best = nullptr;
  std::optional<JointLimit> nearest_miss;
  double best_time = 0, miss = 0;
  for (std::size_t i = 0; i < found.count; ++i) {
    JointValues& joints = found.each[i].joints;
    for (Eigen::Index axis = 0; axis < 6; ++axis) {
      joints[axis] = nearest_turn(joints[axis], reference[axis],
                                  model_.limits()[static_cast<std::size_t>(axis)]);
    }
    if (auto outside = first_outside(model_, joints)) {
      const double by = std::max(outside->lower - outside->value, outside->value - outside->upper);
      outside->configuration = found.each[i].configuration;
      if (!nearest_miss || by < miss) nearest_miss = outside, miss = by;
      continue;
    }
    const double time = travel_time(model_, reference, joints);
    if (!best || time < best_time) best = &joints, best_time = time;
  }
  if (best) return *best;
  return tl::unexpected(*nearest_miss);
}

Configuration SphericalWristInverse::configuration(const JointValues& joints) {
  const double upper = joints[1] + upper_arm_angle_;
  const double fore = joints[1] + third_sign_ * joints[2] + forearm_angle_;
  const Vector2d elbow = at_angle(upper_arm_, upper);
  const Vector2d wrist = elbow + at_angle(forearm_, fore);
  const double along = wrist.x() + shoulder_;
  const double side = along < 0 ? -1 : 1;
  return {by_sign(righty_ * along, Shoulder::Righty, Shoulder::Lefty),
          by_sign(above_ * side * (wrist.x() * elbow.y() - wrist.y() * elbow.x()), Elbow::Above,
                  Elbow::Below),
          by_sign(noflip_ * std::sin(joints[4] + sixth_tilt_), Wrist::Noflip, Wrist::Flip)};
}

std::string SphericalWristInverse::why_out_of_reach(const Frame& base_from_flange) const {
  const Vector3d wrist =
      base_from_plane_.transpose() * (base_from_flange.transform(flange_to_wrist_) - origin_);
  const double from_axis = std::hypot(wrist.x(), wrist.y());
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  if (from_axis < std::abs(lateral_)) {
    text << "the wrist centre would be " << in_mm(from_axis)
         << " mm from axis 1, but this distance must be at least " << in_mm(std::abs(lateral_))
         << " mm";
    return text.str();
  }
  const double along = std::sqrt(from_axis * from_axis - lateral_ * lateral_);
  const double length = std::hypot(along - shoulder_, wrist.z());
  text << "the wrist centre would be " << in_mm(length)
       << " mm from the shoulder, but this distance must be "
       << in_mm(std::abs(upper_arm_ - forearm_)) << " to " << in_mm(upper_arm_ + forearm_) << " mm";
  return text.str();
}

}  // namespace robcl::arm
