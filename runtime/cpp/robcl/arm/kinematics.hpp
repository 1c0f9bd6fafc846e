// Forward kinematics: the pose and the Jacobian of the flange at given joint positions.
#pragma once

#include <kdl/chain.hpp>

#include "robcl/arm/joint_values.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/frames/frame.hpp"

namespace robcl::arm {

/// Computes forward kinematics by multiplying KDL's segments, without allocating memory. Only one
/// thread at a time may use a Kinematics object, because KDL::Joint caches its last pose. Copies
/// are independent of each other.
class Kinematics {
 public:
  explicit Kinematics(const ArmModel& model);

  /// Returns the pose of the flange at the joint positions `joints`. @pre `joints` has one position
  /// for each axis.
  Frame base_from_flange(const JointValues& joints);
  /// Returns the Jacobian matrix at the joint positions `joints`. Column i is the twist of the
  /// flange, seen from the base, while joint i turns with 1 rad/s. @pre `joints` has one position
  /// for each axis.
  Jacobian jacobian(const JointValues& joints) { return place(joints).jacobian; }

  struct Place {
    Frame base_from_flange;
    Jacobian jacobian;
  };
  /// Returns both results in one pass along the chain.
  Place place(const JointValues& joints);

 private:
  KDL::Chain chain_;
};

/// Conversions between KDL::Frame and robcl::Frame.
Frame to_frame(const KDL::Frame& frame);
KDL::Frame to_kdl(const Frame& frame);

}  // namespace robcl::arm
