#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/qos/match.hpp"

namespace gecos {

/// An operation or stream whose own `@qos` a medium does not meet. In a session over this medium,
/// each call of the operation or subscription to the stream ends at once as QOS_UNAVAILABLE.
struct UnsuitedMember {
  FunctionCode code{};
  std::string name;  ///< "move", "tool"; "tool=" for a setter
  std::vector<qos::Violation> violations;
  /// True if `violations` concern only the samples of a stream and not its getter. If the getter is
  /// refused, too, the getter has an entry of its own.
  bool samples_only = false;
};

/// The reasons for and against one medium of an object.
struct MediumVerdict {
  std::string medium;       ///< "shm"
  std::string address;      ///< the address at which the server offers the medium
  std::string unreachable;  ///< why this medium does not reach the object; empty if it does
  /// The terms of the interface's `@qos` that the medium does not meet.
  std::vector<qos::Violation> violations;
  /// The operations and streams that cannot be used in a session over this medium. Empty if
  /// suitable() is false, because no session is then opened over this medium.
  std::vector<UnsuitedMember> members;
  /// What the lab file states, if the interface or a member demands HARD_REALTIME and only this
  /// statement permits it over the medium: "[media.lcm] in lab.toml:2 says that lcm is real-time".
  std::string real_time_by;

  bool suitable() const { return unreachable.empty() && violations.empty(); }
};

/// All media of one object, and for each the reasons why `create` would use it or not.
struct Explanation {
  std::string name;
  std::string interface_name;  ///< the interface of the object
  std::string hostname;
  bool simulated = false;
  /// All media of the object. The suitable media come first, in the order in which `create` tries
  /// them.
  std::vector<MediumVerdict> media;
};
/// Returns violated terms in one line: "media=shm: lcm is not one of these media; …".
std::string to_string(const std::vector<qos::Violation>& violations);
/// Prints a line for each medium: "shm: chosen", "lcm: media=shm: lcm is not one of these media".
/// Below a medium, prints `real_time_by` and the members that cannot be used.
std::ostream& operator<<(std::ostream& out, const Explanation& explanation);

}  // namespace gecos
