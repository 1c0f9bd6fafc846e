#include "gecos/session/server/intake.hpp"

#include <algorithm>
#include <utility>

#include "gecos/session/server/object_queue.hpp"

namespace gecos::session {

/// Checks the age of a call. Over a medium that loses no packets, a call may be old just because a
/// handler took long. There, the age of a call matters only after a pause of this process.
Intake::Verdict Intake::arrived(const Arrival& packet) {
  if ((repeats_ || packet.from_a_pause) && too_old(packet.age)) {
    if (repeats_) return Verdict::Ignore;
    window_.arrived_in_order(packet.counter);
    return Verdict::TooLate;
  }
  if (!repeats_) {
    window_.arrived_in_order(packet.counter);
    return Verdict::Take;
  }
  if (packet.needs_all && packet.counter > window_.cumulative_ack() + 1) return Verdict::Ignore;
  switch (window_.arrived(packet.counter)) {
    case ReceiveWindow::Verdict::New:
      return Verdict::Take;
    case ReceiveWindow::Verdict::Seen:
      return Verdict::Seen;
    case ReceiveWindow::Verdict::Beyond:
      break;  // not answered now, because a copy of the call could still start later
  }
  return Verdict::Ignore;
}

bool Intake::abandon_up_to(std::uint64_t counter) {
  if (counter <= window_.cumulative_ack()) return false;
  early_.erase(early_.begin(), early_.upper_bound(counter));
  window_.abandoned(counter);
  return true;
}

bool Intake::put_aside(const wire::PacketView& call, TimePoint now, Duration age) {
  std::size_t bytes = call.body.size();
  for (const auto& [counter, other] : early_) bytes += other.body.size();
  if (!early_.empty() && bytes > ObjectQueue::most_bytes_of_client) return false;
  early_.emplace(call.header.counter,
                 EarlyCall{call.header, Bytes(call.body.begin(), call.body.end()), now, age});
  return true;
}

std::optional<Intake::EarlyCall> Intake::next(TimePoint now) {
  if (early_.empty() || early_.begin()->first > window_.cumulative_ack()) return std::nullopt;
  EarlyCall call = std::move(early_.extract(early_.begin()).mapped());
  call.age += now - call.arrived;
  if (call.header.deadline > Duration{}) {
    call.header.deadline = std::max(call.header.deadline - (now - call.arrived), Duration{1});
  }
  return call;
}

std::optional<std::uint64_t> Intake::first_aside(std::uint64_t after) const {
  const auto found = early_.upper_bound(after);
  return found == early_.end() ? std::nullopt : std::optional(found->first);
}

}  // namespace gecos::session
