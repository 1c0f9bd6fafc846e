// Forward kinematics: the pose and the Jacobian of the flange, or of the tool, at given joint
// positions.
#pragma once

#include <kdl/frames.hpp>
#include <vector>

#include "robcl/arm/joint_values.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/frames/frame.hpp"

namespace robcl::arm {

/// Computes forward kinematics without allocating memory. The constructor computes all that does
/// not depend on the joint positions: it multiplies the constant transforms between two joints of
/// the KDL chain, and gives each joint a coordinate system in which the joint turns about the z
/// axis. Therefore a control cycle has time for several poses with their Jacobian matrices.
class Kinematics {
 public:
  /// `flange_from_tip` is the pose, seen from the flange, of the tip whose Jacobian matrix is
  /// wanted; for example a tool.
  explicit Kinematics(const ArmModel& model, const Frame& flange_from_tip = {});

  /// Returns the pose of the flange at the joint positions `joints`. @pre `joints` has one position
  /// for each axis.
  Frame base_from_flange(const JointValues& joints) const;
  struct Place {
    Frame base_from_tip;
    /// The Jacobian matrix. Its column i is the twist of the tip, seen from the base, while only
    /// joint i turns, with 1 rad/s.
    Jacobian jacobian;
  };
  /// Returns the pose and the Jacobian matrix of the tip at the joint positions `joints`. @pre
  /// `joints` has one position for each axis.
  Place place(const JointValues& joints) const;

 private:
  /// The pose of a joint, seen from the joint before it or, for the first joint, from the base. The
  /// joint turns about the z axis of this pose.
  struct Link {
    Eigen::Matrix3d turn;
    Eigen::Vector3d way;
  };

  static Link link_of(const Frame& frame);
  template <class Visit>
  Frame walk(const JointValues& joints, const Link& end, Visit visit) const;

  std::vector<Link> links_;
  Link flange_, tip_;  // seen from the last joint
};

/// Conversions between the types of KDL and the types of robcl.
inline Eigen::Vector3d to_eigen(const KDL::Vector& vector) {
  return {vector.x(), vector.y(), vector.z()};
}
Frame to_frame(const KDL::Frame& frame);
KDL::Frame to_kdl(const Frame& frame);

}  // namespace robcl::arm
