#include "robcl/arm/kinematics.hpp"

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

Kinematics::Kinematics(const ArmModel& model) : chain_(model.chain()) {}

Frame Kinematics::base_from_flange(const JointValues& joints) {
  KDL::Frame base_from_here = KDL::Frame::Identity();
  Eigen::Index axis = 0;
  for (unsigned i = 0; i < chain_.getNrOfSegments(); ++i) {
    const KDL::Segment& segment = chain_.getSegment(i);
    const bool turns = segment.getJoint().getType() != KDL::Joint::None;
    base_from_here = base_from_here * segment.pose(turns ? joints[axis++] : 0);
  }
  return to_frame(base_from_here);
}

Kinematics::Place Kinematics::place(const JointValues& joints) {
  Jacobian result(6, joints.size());
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, max_axes> origins(3, joints.size());
  KDL::Frame base_from_here = KDL::Frame::Identity();
  Eigen::Index axis = 0;
  for (unsigned i = 0; i < chain_.getNrOfSegments(); ++i) {
    const KDL::Segment& segment = chain_.getSegment(i);
    const KDL::Joint& joint = segment.getJoint();
    double position = 0;
    if (joint.getType() != KDL::Joint::None) {
      const KDL::Vector direction = base_from_here.M * joint.JointAxis();
      const KDL::Vector origin = base_from_here * joint.JointOrigin();
      result.col(axis).tail<3>() = Eigen::Vector3d(direction.x(), direction.y(), direction.z());
      origins.col(axis) = Eigen::Vector3d(origin.x(), origin.y(), origin.z());
      position = joints[axis++];
    }
    base_from_here = base_from_here * segment.pose(position);
  }
  const Eigen::Vector3d flange(base_from_here.p.x(), base_from_here.p.y(), base_from_here.p.z());
  for (Eigen::Index i = 0; i < joints.size(); ++i) {
    const Eigen::Vector3d direction = result.col(i).tail<3>();
    result.col(i).head<3>() = direction.cross(Eigen::Vector3d(flange - origins.col(i)));
  }
  return {to_frame(base_from_here), result};
}

}  // namespace robcl::arm
