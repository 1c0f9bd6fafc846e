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
  if (failure.place) text << to_string(*failure.place) << ": ";
  text << std::fixed << std::setprecision(1) << "joint " << failure.axis
       << " would have to stand at " << in_deg(failure.value) << " deg, but its range is "
       << in_deg(failure.lower) << " to " << in_deg(failure.upper) << " deg";
  if (failure.configuration != Configuration{}) {
    text << " (configuration " << failure.configuration << ")";
  }
  return text.str();
}

}  // namespace

std::string to_string(const Failure& failure) {
  return std::visit([](const auto& reason) { return words(reason); }, failure);
}

std::string to_string(const PlaceOnLine& place) {
  constexpr double no_way = 1e-9;  // m: the tool turns in place
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  if (place.way > no_way || place.turn == 0) {
    text << in_mm(place.way) << " mm along the line";
  } else {
    text << in_deg(place.turn) << " deg into the turn";
  }
  return text.str();
}

}  // namespace robcl::arm
