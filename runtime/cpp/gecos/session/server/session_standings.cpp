#include "gecos/session/server/session_standings.hpp"

#include <algorithm>
#include <optional>

namespace gecos::session {

void SessionStandings::add_holder(const std::shared_ptr<ServerSession>& session) {
  session->renewed = {};
  if (std::ranges::find(holders_, session) == holders_.end()) holders_.push_back(session);
}

void SessionStandings::add_feeder(const std::shared_ptr<ServerSession>& session) {
  if (std::ranges::find(feeders_, session) == feeders_.end()) feeders_.push_back(session);
}

void SessionStandings::remove(const ServerSession& session) {
  for (Sessions* const sessions : {&feeders_, &holders_}) {
    std::erase_if(*sessions, [&](const auto& each) { return each.get() == &session; });
  }
}

void SessionStandings::note_change(const access::LeaseTable& leases, TimePoint now) {
  using access::Status;
  const Epoch epoch = leases.epoch();
  for (const auto& session : feeders_) {
    for (const Status needed : {Status::Sensor, Status::Actor, Status::Master}) {
      const bool may = leases.may_start(session->id(), epoch, needed, now).has_value();
      session->standing->set(needed, may ? std::optional(epoch) : std::nullopt);
    }
  }
}

void SessionStandings::note_newer_epoch(const access::LeaseTable& leases) {
  for (const auto& session : holders_) {
    const bool has_status = leases.status_of(session->id()) != access::Status::Sensor;
    session->renewed = has_status ? leases.epoch() : Epoch{};
  }
}

}  // namespace gecos::session
