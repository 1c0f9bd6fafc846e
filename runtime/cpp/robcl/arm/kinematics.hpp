// Forward: from joint positions to where the flange is, and how it moves.
#pragma once

#include <kdl/chain.hpp>

#include "robcl/arm/joint_values.hpp"
#include "robcl/arm/model.hpp"
#include "robcl/frames/frame.hpp"

namespace robcl::arm {

/// KDL's segments, multiplied without allocating. One thread at a time, because KDL's joints cache;
/// copies are independent.
class Kinematics {
 public:
  explicit Kinematics(const ArmModel& model);

  /// @pre one position per axis, here and below.
  Frame base_from_flange(const JointValues& joints);
  /// Column i: twist of the flange, seen from the base, while joint i turns with 1 rad/s.
  Jacobian jacobian(const JointValues& joints);

 private:
  KDL::Chain chain_;
};

/// KDL's frame as ours.
Frame to_frame(const KDL::Frame& frame);
KDL::Frame to_kdl(const Frame& frame);

}  // namespace robcl::arm
