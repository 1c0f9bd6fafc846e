#include "robcl/arm/failure.hpp"

#include <iomanip>
#include <sstream>

#include "robcl/frames/units.hpp"

namespace robcl::arm {
namespace {

std::string words(const OutOfReach& failure) { return "out of reach: " + failure.reason; }

std::string words(const Singular& failure) { return "singular: " + failure.reason; }

std::string words(const JointLimit& failure) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "joint " << failure.axis
       << " would have to stand at " << in_deg(failure.value) << " deg, but its range is "
       << in_deg(failure.lower) << " to " << in_deg(failure.upper) << " deg";
  return text.str();
}

}  // namespace

std::string to_string(const Failure& failure) {
  return std::visit([](const auto& reason) { return words(reason); }, failure);
}

}  // namespace robcl::arm
