#include "devices/arm/motion_call.hpp"

#include <string>
#include <variant>

#include "gecos/base/whole_characters.hpp"

namespace devices {
namespace {

/// Shortens `reason` to at most 160 bytes, the limit of the exceptions in manipulator.gidl. Cuts
/// only between two characters.
std::string shortened(const std::string& reason) {
  return std::string(gecos::whole_characters(reason, 160));
}

struct AsFault {
  gecos::Fault operator()(const robcl::arm::OutOfReach& failure) const {
    return robcl::OutOfReach{shortened(failure.reason)};
  }
  gecos::Fault operator()(const robcl::arm::JointLimit& failure) const {
    robcl::JointLimit limit{.axis = static_cast<std::uint32_t>(failure.axis),
                            .value = failure.value,
                            .lower = failure.lower,
                            .upper = failure.upper};
    if (failure.place) limit.place = {.way = failure.place->way, .turn = failure.place->turn};
    if (failure.configuration != robcl::arm::Configuration{}) {
      limit.configuration = devices::on_wire(failure.configuration);
    }
    return limit;
  }
  gecos::Fault operator()(const robcl::arm::Singular& failure) const {
    return robcl::Singular{shortened(failure.reason)};
  }
  gecos::Fault operator()(const Interrupted&) const { return gecos::Fault::interrupted(); }
  gecos::Fault operator()(const CorrectionsStopped& failure) const {
    return gecos::Fault::failed(to_string(failure));
  }
  gecos::Fault operator()(const Refused& failure) const {
    return gecos::Fault::rejected(failure.reason);
  }
  gecos::Fault operator()(const DriverFault& failure) const {
    return gecos::Fault::failed(failure.text);
  }
};

template <typename To, typename From>
std::optional<To> same(const std::optional<From>& choice) {
  if (!choice) return std::nullopt;
  return static_cast<To>(*choice);
}

static_assert(static_cast<int>(robcl::arm::Shoulder::Lefty) ==
              static_cast<int>(robcl::Shoulder::LEFTY));
static_assert(static_cast<int>(robcl::arm::Elbow::Below) == static_cast<int>(robcl::Elbow::BELOW));
static_assert(static_cast<int>(robcl::arm::Wrist::Flip) == static_cast<int>(robcl::Wrist::FLIP));

}  // namespace

std::optional<robcl::arm::Configuration> configuration_of(const robcl::Trajectory& how) {
  if (!how.configuration) return std::nullopt;
  return from_wire(*how.configuration);
}

robcl::arm::Configuration from_wire(const robcl::Configuration& asked) {
  return {same<robcl::arm::Shoulder>(asked.arm), same<robcl::arm::Elbow>(asked.bend),
          same<robcl::arm::Wrist>(asked.hand)};
}

robcl::Configuration on_wire(const robcl::arm::Configuration& known) {
  return {same<robcl::Shoulder>(known.shoulder), same<robcl::Elbow>(known.elbow),
          same<robcl::Wrist>(known.wrist)};
}

robcl::motion::Pace pace_of(const robcl::Trajectory& how) {
  return {.speed = how.speed,
          .acceleration = how.acceleration,
          .tool_speed = how.tool_speed,
          .turn_speed = how.turn_speed,
          .tool_acceleration = how.tool_acceleration,
          .turn_acceleration = how.turn_acceleration};
}

gecos::Result<void> answer(const tl::expected<void, MoveFailure>& moved) {
  if (!moved) return tl::unexpected(std::visit(AsFault{}, moved.error()));
  return {};
}

}  // namespace devices
