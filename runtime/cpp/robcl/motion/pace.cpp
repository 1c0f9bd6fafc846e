#include "robcl/motion/pace.hpp"

#include <sstream>

namespace robcl::motion {
namespace {

constexpr double least_speed = 1e-6;  // m/s or rad/s: below, the times of a plan lose their digits

std::string says(const char* what, double value, const char* wanted) {
  std::ostringstream text;
  text << what << " is " << value << ", but it must be " << wanted;
  return text.str();
}

}  // namespace

std::optional<std::string> problem_of(const Pace& pace) {
  // These comparisons also refuse NaN.
  if (!(pace.speed > 0 && pace.speed <= 1)) return says("speed", pace.speed, "above 0, at most 1");
  if (!(pace.acceleration > 0 && pace.acceleration <= 1)) {
    return says("acceleration", pace.acceleration, "above 0, at most 1");
  }
  if (pace.tool_speed && !(*pace.tool_speed >= least_speed)) {
    return says("tool_speed", *pace.tool_speed, "at least 1e-6 m/s");
  }
  if (pace.turn_speed && !(*pace.turn_speed >= least_speed)) {
    return says("turn_speed", *pace.turn_speed, "at least 1e-6 rad/s");
  }
  return std::nullopt;
}

}  // namespace robcl::motion
