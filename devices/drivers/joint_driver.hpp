#pragma once

#include <string>

#include "gecos/base/result.hpp"
#include "robcl/arm/joint_values.hpp"

namespace devices {

using robcl::arm::JointValues;

/// The drive electronics, or the line to them, do not do what they should.
struct DriverFault {
  std::string text;
};

/// What separates motion from hardware: the joints of one arm. Used by one control loop.
class JointDriver {
 public:
  virtual ~JointDriver() = default;

  /// Where the joints are before anything was commanded, rad.
  virtual JointValues measured() = 0;

  /// Once per control cycle: where the joints shall be `seconds` from the last exchange on,
  /// answered by where they are. Blocks no longer than a part of the cycle, allocates only to fail.
  virtual tl::expected<JointValues, DriverFault> exchange(const JointValues& command,
                                                          double seconds) = 0;
};

}  // namespace devices
