#include "robcl/motion/pace.hpp"

namespace robcl::motion {
namespace {

std::string says(const char* what, double value, const char* wanted) {
  return std::string(what) + " is " + std::to_string(value) + ", but it must be " + wanted;
}

}  // namespace

std::optional<std::string> problem_of(const Pace& pace) {
  // These comparisons also refuse NaN.
  if (!(pace.speed > 0 && pace.speed <= 1)) return says("speed", pace.speed, "above 0, at most 1");
  if (!(pace.acceleration > 0 && pace.acceleration <= 1)) {
    return says("acceleration", pace.acceleration, "above 0, at most 1");
  }
  if (pace.tool_speed && !(*pace.tool_speed > 0)) {
    return says("tool_speed", *pace.tool_speed, "above 0 m/s");
  }
  if (pace.turn_speed && !(*pace.turn_speed > 0)) {
    return says("turn_speed", *pace.turn_speed, "above 0 rad/s");
  }
  return std::nullopt;
}

}  // namespace robcl::motion
