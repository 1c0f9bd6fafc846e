// The reasons why an arm cannot reach a goal. Each struct corresponds to an exception in
// idl/robcl/manipulator.gidl.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <variant>

#include "robcl/arm/configuration.hpp"

namespace robcl::arm {

/// The arm cannot reach the goal: no joint positions put the flange there.
struct OutOfReach {
  std::string reason;
};

/// A place on a straight line of the tool: the distance and the angle by which the tool has moved
/// from the start of the line.
struct PlaceOnLine {
  double way = 0;   ///< m
  double turn = 0;  ///< rad
};

/// The goal, or a place on the way to it, needs a joint position that is outside the limits of the
/// joint.
struct JointLimit {
  std::size_t axis = 0;  ///< number of the joint, from 1
  double value = 0;      ///< position that the goal or the place needs, rad
  double lower = 0;      ///< lower limit, rad
  double upper = 0;      ///< upper limit, rad
  /// The place on the straight line of the tool at which the joint would need the position `value`.
  /// Empty if the goal itself needs this position.
  std::optional<PlaceOnLine> place{};
  /// The configuration for which the joint position was computed. All members are empty if the goal
  /// was given as joint positions, or if the arm has no configurations.
  Configuration configuration{};
};

/// The arm can reach the goal, but not on the requested path.
struct Singular {
  std::string reason;
};

using Failure = std::variant<OutOfReach, JointLimit, Singular>;

std::string to_string(const Failure& failure);
/// Returns a text such as "120.0 mm along the line".
std::string to_string(const PlaceOnLine& place);

}  // namespace robcl::arm
