#include "robcl/motion/pace.hpp"

#include <sstream>

namespace robcl::motion {
namespace {

// The least speed or acceleration that a caller may request, in SI units. With smaller values, the
// times of a plan would be so large that they lose precision.
constexpr double least = 1e-6;

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
  const auto too_little = [](const std::optional<double>& value) {
    return value && !(*value >= least);
  };
  if (too_little(pace.tool_speed)) {
    return says("tool_speed", *pace.tool_speed, "at least 1e-6 m/s");
  }
  if (too_little(pace.turn_speed)) {
    return says("turn_speed", *pace.turn_speed, "at least 1e-6 rad/s");
  }
  if (too_little(pace.tool_acceleration)) {
    return says("tool_acceleration", *pace.tool_acceleration, "at least 1e-6 m/s^2");
  }
  if (too_little(pace.turn_acceleration)) {
    return says("turn_acceleration", *pace.turn_acceleration, "at least 1e-6 rad/s^2");
  }
  return std::nullopt;
}

std::optional<std::string> problem_of_joint_move(const Pace& pace) {
  if (pace.tool_acceleration || pace.turn_acceleration) {
    return "tool_acceleration and turn_acceleration limit a straight move; use the fraction "
           "`acceleration`, or a straight move";
  }
  return problem_of(pace);
}

}  // namespace robcl::motion
