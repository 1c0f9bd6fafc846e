// The reasons why an arm cannot reach a goal. Each struct corresponds to an exception in
// idl/robcl/manipulator.gidl.
#pragma once

#include <cstddef>
#include <string>
#include <variant>

namespace robcl::arm {

/// The arm cannot reach the goal: no joint positions put the flange there.
struct OutOfReach {
  std::string reason;
};

/// The goal needs a joint position that is outside the limits of the joint.
struct JointLimit {
  std::size_t axis = 0;  ///< number of the joint, from 1
  double value = 0;      ///< position that the goal needs, rad
  double lower = 0;      ///< lower limit, rad
  double upper = 0;      ///< upper limit, rad
};

/// The arm can reach the goal, but not on the requested path.
struct Singular {
  std::string reason;
};

using Failure = std::variant<OutOfReach, JointLimit, Singular>;

std::string to_string(const Failure& failure);

}  // namespace robcl::arm
