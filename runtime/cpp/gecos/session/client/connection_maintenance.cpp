#include "gecos/session/client/connection_maintenance.hpp"

#include <algorithm>
#include <cstdio>

#include "gecos/session/protocol/retry.hpp"

namespace gecos::session {

ConnectionMaintenance::ConnectionMaintenance(Runtime& runtime, Parts session)
    : reliable_(session.connection.capabilities().reliable),
      heartbeats_(runtime.options().heartbeat,
                  reliable_ ? ClientHeartbeats::Sent::InMemory : ClientHeartbeats::Sent::AsPackets,
                  reliable_ ? TimePoint{} : runtime.heartbeat_anchor()),
      session_(session) {}

NextTick ConnectionMaintenance::on_tick(TimePoint now) {
  const CallSender& calls = session_.calls;
  if (calls.lost()) return TimePoint::max();
  if (heartbeats_.due(now)) {
    session_.connection.beat();
    session_.reader.look_for_loss_soon();
  }
  session_.reader.poll_once();
  if (!calls.lost()) judge_heartbeats(now);
  if (!calls.lost() && !session_.server.unreachable()) judge_answers();
  if (!calls.lost()) session_.line.on_tick(now);
  if (calls.lost()) return TimePoint::max();
  return heartbeats_.next_tick(next_work(now));
}

/// Repeats calls. Returns when the session needs a tick for anything but its own heartbeat.
TimePoint ConnectionMaintenance::next_work(TimePoint now) {
  const TimePoint next = session_.calls.repeat(now, heartbeats_.next());
  if (reliable_) return next;
  // A program that only calls `latest()` of a stream does not read the packets that announce a new
  // key of the stream.
  if (session_.subscriptions.any()) return std::min(next, now + retry_after(1));
  return std::min(next, session_.server.next_look(now));
}

void ConnectionMaintenance::judge_heartbeats(TimePoint now) {
  switch (session_.server.judge_heartbeats(session_.connection.beats_seen(), now)) {
    case PeerLiveness::Verdict::Alive:
    case PeerLiveness::Verdict::Quiet:
      return;
    case PeerLiveness::Verdict::Suspect:
      return session_.failover.look_for_another();
    case PeerLiveness::Verdict::Dead:
      const auto silent =
          std::chrono::duration_cast<std::chrono::milliseconds>(session_.server.silent_for());
      return session_.end.lose(Ending::Silent, "the server of " + who() + " has been silent for " +
                                                   std::to_string(silent.count()) + " ms");
  }
}

/// Ends the session when the server sends heartbeats but no answers for longer than AnswerWatch
/// allows.
void ConnectionMaintenance::judge_answers() {
  if (session_.receiver.answer_lost()) {
    return session_.end.lose(Ending::Broken,
                             "an answer of the server of " + who() + " was lost over " +
                                 std::string(session_.connection.capabilities().name) +
                                 ", which loses packets only if its shared memory is damaged");
  }
  switch (session_.server.judge_answers(session_.calls.open() != 0, session_.receiver.heard())) {
    case AnswerWatch::Verdict::Fine:
      return;
    case AnswerWatch::Verdict::Ask:
      return session_.calls.query_old_calls();
    case AnswerWatch::Verdict::Mute:
      char seconds[32];
      std::snprintf(seconds, sizeof seconds, "%.1f s",
                    std::chrono::duration<double>(session_.server.mute_for()).count());
      return session_.end.lose(
          Ending::Silent, "the server of " + who() +
                              " still sends heartbeats, but has answered no call for " + seconds +
                              "; restart the server if it hangs");
  }
}

std::string ConnectionMaintenance::who() const {
  return session_.welcome.object + " (" + session_.connection.peer().description + ")";
}

}  // namespace gecos::session
