#include "gecos/session/server/object_stats.hpp"

#include <algorithm>
#include <chrono>
#include <functional>

#include "gecos/base/seconds.hpp"
#include "gecos/session/server/object_calls.hpp"
#include "gecos/session/server/object_host.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {
namespace {

SessionStats stats_of_session(ServerSession& session, TimePoint now) {
  const Caller& caller = session.caller();
  SessionStats stats;
  stats.user = caller.user;
  stats.host = caller.host;
  stats.program = caller.program;
  stats.pid = caller.pid;
  stats.medium = session.connection().capabilities().name;
  stats.connected_for = to_seconds(now - session.greeted_at);
  stats.begun = session.counts.begun;
  stats.ended = session.counts.outcomes();
  stats.deadline_missed = session.counts.deadline_missed;
  stats.start_by_missed = session.counts.start_by_missed;
  return stats;
}

}  // namespace

ObjectStats stats_of(ObjectHost& object, ObjectCalls& calls, TimePoint now) {
  ObjectStats stats;
  stats.served_for = to_seconds(now - calls.statistics().since());
  stats.operations = calls.statistics().shown();
  stats.streams = object.streams().stats();
  stats.inward = object.inward().stats();
  for (const auto& session : calls.outcomes().all_open()) {
    stats.sessions.push_back(stats_of_session(*session, now));
    for (const auto& [code, id] : session->subscriptions) ++stats.streams.at(id - 1).readers;
  }
  std::ranges::sort(stats.sessions, std::greater(), &SessionStats::connected_for);
  return stats;
}

}  // namespace gecos::session
