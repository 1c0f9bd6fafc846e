// Why an arm cannot be where it is asked to be. One struct per exception in
// idl/robcl/manipulator.gidl.
#pragma once

#include <cstddef>
#include <string>
#include <variant>

namespace robcl::arm {

/// No joint positions whatever put the flange there.
struct OutOfReach {
  std::string reason;
};

/// It could be there if this joint turned further than it can.
struct JointLimit {
  std::size_t axis = 0;  ///< counted from 1
  double value = 0;      ///< rad, as needed
  double lower = 0;      ///< rad
  double upper = 0;      ///< rad
};

/// It could be there, but not on the way asked for.
struct Singular {
  std::string reason;
};

using Failure = std::variant<OutOfReach, JointLimit, Singular>;

std::string to_string(const Failure& failure);

}  // namespace robcl::arm
