#include "gecos/session/server/session_standings.hpp"

#include <algorithm>
#include <optional>

namespace gecos::session {
namespace {

using Session = std::shared_ptr<ServerSession>;

void add(std::vector<std::weak_ptr<ServerSession>>& sessions, const Session& session) {
  const auto is_it = [&](const auto& each) { return each.lock() == session; };
  if (std::ranges::none_of(sessions, is_it)) sessions.push_back(session);
}

}  // namespace

void SessionStandings::add_holder(const std::shared_ptr<ServerSession>& session) {
  session->renewed = {};
  add(holders_, session);
}

void SessionStandings::add_feeder(const std::shared_ptr<ServerSession>& session) {
  add(feeders_, session);
}

void SessionStandings::remove(const ServerSession& session) {
  for (Sessions* const sessions : {&feeders_, &holders_}) {
    std::erase_if(*sessions, [&](const auto& each) {
      const Session one = each.lock();
      return one == nullptr || one.get() == &session;
    });
  }
}

void SessionStandings::note_change(const access::LeaseTable& leases, TimePoint now) {
  using access::Status;
  const Epoch epoch = leases.epoch();
  for (const auto& each : feeders_) {
    const Session session = each.lock();
    if (session == nullptr) continue;
    for (const Status needed : {Status::Sensor, Status::Actor, Status::Master}) {
      const bool may = leases.may_start(session->id(), epoch, needed, now).has_value();
      session->standing->set(needed, may ? std::optional(epoch) : std::nullopt);
    }
  }
}

void SessionStandings::note_newer_epoch(const access::LeaseTable& leases) {
  for (const auto& each : holders_) {
    const Session session = each.lock();
    if (session == nullptr) continue;
    const bool has_status = leases.status_of(session->id()) != access::Status::Sensor;
    session->renewed = has_status ? leases.epoch() : Epoch{};
  }
}

}  // namespace gecos::session
