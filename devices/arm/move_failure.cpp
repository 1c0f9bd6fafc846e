#include "devices/arm/move_failure.hpp"

namespace devices {
namespace {

struct Words {
  std::string operator()(const Interrupted&) const {
    return "the motion was interrupted; the arm has stopped";
  }
  std::string operator()(const CorrectionsStopped&) const {
    return "no correction came within the watchdog of 'alter'; the arm has stopped";
  }
  std::string operator()(const Refused& refused) const { return refused.reason; }
  std::string operator()(const DriverFault& fault) const { return fault.text; }
  template <typename Reason>
  std::string operator()(const Reason& reason) const {
    return robcl::arm::to_string(robcl::arm::Failure(reason));
  }
};

}  // namespace

std::string to_string(const MoveFailure& failure) { return std::visit(Words{}, failure); }

bool is_refusal(const MoveFailure& failure) {
  return !std::holds_alternative<Interrupted>(failure) &&
         !std::holds_alternative<CorrectionsStopped>(failure) &&
         !std::holds_alternative<DriverFault>(failure);
}

MoveFailure as_move_failure(const robcl::arm::Failure& failure) {
  return std::visit([](const auto& reason) { return MoveFailure(reason); }, failure);
}

}  // namespace devices
