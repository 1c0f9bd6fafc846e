#pragma once

#include <string>

#include "gecos/session/client/call_sender.hpp"
#include "gecos/session/client/client_heartbeats.hpp"
#include "gecos/session/client/connection_reader.hpp"
#include "gecos/session/client/line_probe.hpp"
#include "gecos/session/client/packet_receiver.hpp"
#include "gecos/session/client/server_watch.hpp"
#include "gecos/session/client/session_end.hpp"
#include "gecos/session/client/session_failover.hpp"
#include "gecos/session/client/subscriptions.hpp"
#include "gecos/session/process/maintenance.hpp"
#include "gecos/session/process/runtime.hpp"

namespace gecos::session {

/// The work of the maintenance thread for one session of a client: sends heartbeats, judges whether
/// the server lives and answers in time, sends calls again, and reads packets while no other thread
/// waits for them.
class ConnectionMaintenance final : public TickTarget {
 public:
  /// The parts of the session that each tick of the maintenance thread uses.
  struct Parts {
    media::Connection& connection;
    const Welcome& welcome;
    ServerWatch& server;
    CallSender& calls;
    PacketReceiver& receiver;
    ConnectionReader& reader;
    SessionFailover& failover;
    SessionEnd& end;
    LineProbe& line;
    const Subscriptions& subscriptions;
  };
  ConnectionMaintenance(Runtime& runtime, Parts session);

  NextTick on_tick(TimePoint now) override;
  bool take_tick_request() override { return session_.calls.take_tick_request(); }
  void watch(std::vector<pollfd>& into) override { session_.reader.watch(into); }
  void unwatch() override { session_.reader.unwatch(); }

 private:
  void judge_heartbeats(TimePoint now);
  void judge_answers();
  TimePoint next_work(TimePoint now);
  std::string who() const;

  const bool reliable_;  ///< the medium loses no packets, and sends none for a heartbeat
  ClientHeartbeats heartbeats_;
  const Parts session_;
};

}  // namespace gecos::session
