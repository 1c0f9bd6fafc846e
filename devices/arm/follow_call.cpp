#include "devices/arm/follow_call.hpp"

#include <limits>

#include "devices/arm/motion_call.hpp"

namespace devices {
namespace {

robcl::FollowState on_wire(const robcl::motion::FollowState& known) {
  robcl::FollowState state;
  state.applied = static_cast<std::uint32_t>(known.applied);
  state.dropped = static_cast<std::uint32_t>(known.dropped);
  state.distance_left = known.distance_left;
  state.angle_left = known.angle_left;
  state.limit_axis = known.hold.limit_axis;
  state.out_of_reach = known.hold.out_of_reach;
  return state;
}

}  // namespace

std::optional<Frame> StreamCorrections::next() {
  Stream* const stream = stream_.load();
  if (stream == nullptr) return std::nullopt;
  const auto sample = stream->next();
  return sample ? std::optional(sample->value) : std::nullopt;
}

bool StreamCorrections::expired() {
  const Stream* const stream = stream_.load();
  return stream == nullptr || stream->expired();
}

FollowCall::FollowCall(Progress& run, StreamCorrections::Stream& stream)
    : run_(run),
      stream_(stream),
      feeding_(stream.feeds(run)),
      corrections_(std::make_shared<StreamCorrections>(stream)),
      unreadable_before_(stream.report().unreadable) {}

bool FollowCall::interrupted() {
  if (!unreadable_) {
    const gecos::FeedReport report = stream_.report();
    if (report.unreadable > unreadable_before_) unreadable_ = report.last_refusal;
  }
  return unreadable_ || run_.interrupted();
}

void FollowCall::progress(double, double) { run_.progress(0, on_wire(corrections_->state())); }

gecos::Result<void> FollowCall::answer(const tl::expected<void, MoveFailure>& ended) const {
  if (unreadable_) {
    return tl::unexpected(
        gecos::Fault::failed("a sample of 'alter' is no correction: " + *unreadable_));
  }
  if (!ended && std::holds_alternative<CorrectionsStopped>(ended.error())) {
    return tl::unexpected(robcl::CorrectionsStopped{on_wire(corrections_->state())});
  }
  return devices::answer(ended);
}

robcl::motion::FollowLimits limits_of(const robcl::FollowLimits& asked) {
  robcl::motion::FollowLimits limits;
  limits.distance = asked.distance.value_or(limits.distance);
  limits.angle = asked.angle.value_or(limits.angle);
  limits.tool.speed = asked.tool_speed.value_or(std::numeric_limits<double>::infinity());
  limits.tool.turn_speed = asked.turn_speed.value_or(std::numeric_limits<double>::infinity());
  limits.tool.acceleration = limits.tool.turn_acceleration =
      std::numeric_limits<double>::infinity();
  return limits;
}

}  // namespace devices
