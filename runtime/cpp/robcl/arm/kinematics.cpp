#include "robcl/arm/kinematics.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace robcl::arm {

Frame to_frame(const KDL::Frame& frame) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> turn(frame.M.data);
  return Frame({frame.p.x(), frame.p.y(), frame.p.z()},
               Eigen::Quaterniond(Eigen::Matrix3d(turn)).normalized());
}

KDL::Frame to_kdl(const Frame& frame) {
  const auto [w, x, y, z] = frame.quaternion();
  return {KDL::Rotation::Quaternion(x, y, z, w), {frame.x(), frame.y(), frame.z()}};
}

namespace {

/// Turns a coordinate system by `angle` about its z axis.
void turn_about_z(Eigen::Matrix3d& turn, double angle) {
  const double sine = std::sin(angle), cosine = std::cos(angle);
  const Eigen::Vector3d x = turn.col(0);
  turn.col(0) = cosine * x + sine * turn.col(1);
  turn.col(1) = cosine * turn.col(1) - sine * x;
}

}  // namespace

Kinematics::Kinematics(const ArmModel& model, const Frame& flange_from_tip) {
  Frame before_from_here;                  // "before" is the last joint, or the base
  const KDL::Chain chain = model.chain();  // a copy, because KDL::Joint caches its last pose
  for (unsigned i = 0; i < chain.getNrOfSegments(); ++i) {
    const KDL::Segment& segment = chain.getSegment(i);
    const KDL::Joint& joint = segment.getJoint();
    Frame here_from_next = to_frame(segment.pose(0));
    if (joint.getType() != KDL::Joint::None) {
      const Frame here_from_joint(to_eigen(joint.JointOrigin()),
                                  Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(),
                                                                     to_eigen(joint.JointAxis())));
      const Frame before_from_joint = before_from_here * here_from_joint;
      links_.push_back(link_of(before_from_joint));
      before_from_here = Frame();
      here_from_next = here_from_joint.inverse() * here_from_next;
    }
    before_from_here = before_from_here * here_from_next;
  }
  flange_ = link_of(before_from_here);
  tip_ = link_of(before_from_here * flange_from_tip);
}

Kinematics::Link Kinematics::link_of(const Frame& frame) {
  return {frame.orientation().toRotationMatrix(), frame.position()};
}

/// Goes along the chain at the joint positions `joints`, and calls `visit` with the index, the
/// origin and the axis of each joint. `end` is a pose, seen from the last joint; returns the same
/// pose, seen from the base.
template <class Visit>
Frame Kinematics::walk(const JointValues& joints, const Link& end, Visit visit) const {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d way = Eigen::Vector3d::Zero();
  Eigen::Index axis = 0;
  for (const Link& link : links_) {
    way += turn * link.way;
    turn = turn * link.turn;
    visit(axis, way, Eigen::Vector3d(turn.col(2)));
    turn_about_z(turn, joints[axis++]);
  }
  return Frame(way + turn * end.way, Eigen::Quaterniond(Eigen::Matrix3d(turn * end.turn)));
}

Frame Kinematics::base_from_flange(const JointValues& joints) const {
  return walk(joints, flange_, [](auto...) {});
}

Kinematics::Place Kinematics::place(const JointValues& joints) const {
  Jacobian jacobian(6, joints.size());
  const Frame tip = walk(joints, tip_, [&](Eigen::Index axis, const auto& origin, const auto& z) {
    jacobian.col(axis) << origin, z;
  });
  for (auto column : jacobian.colwise()) {
    const Eigen::Vector3d lever = tip.position() - column.head<3>();
    column.head<3>() = Eigen::Vector3d(column.tail<3>()).cross(lever);
  }
  return {tip, jacobian};
}

}  // namespace robcl::arm
