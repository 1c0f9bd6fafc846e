// Forward kinematics: the pose and the Jacobian of the flange at given joint positions.
#pragma once

#include <kdl/chain.hpp>

#include "robcl/arm/joint_values.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/frames/frame.hpp"

namespace robcl::arm {

/// Multiplies KDL's segments without allocating. Used by one thread at a time, because KDL::Joint
/// caches its last pose; copies are independent.
class Kinematics {
 public:
  explicit Kinematics(const ArmModel& model);

  /// @pre `joints` has one position per axis. The same holds for `jacobian`.
  Frame base_from_flange(const JointValues& joints);
  /// Column i: twist of the flange, seen from the base, while joint i turns with 1 rad/s.
  Jacobian jacobian(const JointValues& joints);

 private:
  KDL::Chain chain_;
};

/// Conversions between KDL::Frame and robcl::Frame.
Frame to_frame(const KDL::Frame& frame);
KDL::Frame to_kdl(const Frame& frame);

}  // namespace robcl::arm
