// What the maintenance thread does for the client side of a session.
#include <algorithm>
#include <cstdio>

#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/retry.hpp"

namespace gecos::session {
void ClientConnection::wake_maintenance() { runtime_->maintenance().wake(); }

TimePoint ClientConnection::on_tick(TimePoint now) {
  if (lost()) return TimePoint::max();
  // Each tick costs a wake-up. So a heartbeat that is due soon is sent in this tick already, unless
  // the medium sends heartbeats as packets.
  const Duration early = repeats_ ? Duration{} : Maintenance::calm_tick;
  const bool beat = now + early >= next_beat_;
  if (beat) {
    connection_->beat();
    next_beat_ = now + runtime_->options().heartbeat;
    loss_look_due_.store(true, std::memory_order_relaxed);
  }
  poll_once();
  if (!lost()) check_liveness(now);
  if (!lost() && !unreachable()) judge_answers();
  return lost() ? TimePoint::max() : calls_.repeat(now, next_beat_);
}

void ClientConnection::check_liveness(TimePoint now) {
  const auto verdict = server_.judge_heartbeats(connection_->beats_seen(), now);
  if (verdict == PeerLiveness::Verdict::Suspect) {
    if (failover_ && calls_.has_repeatable()) failover_->look_for_another(shared_from_this());
  }
  if (verdict != PeerLiveness::Verdict::Dead) return;
  const Duration length = server_.silent_for();
  const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(length).count();
  lose(Ending::Silent, "the server of " + welcome_.object + " (" + connection_->peer().description +
                           ") has been silent for " + std::to_string(milliseconds) + " ms");
}

/// Ends the session when the server sends heartbeats but no answers for longer than AnswerWatch
/// allows.
void ClientConnection::judge_answers() {
  const std::string who = welcome_.object + " (" + connection_->peer().description + ")";
  if (answer_lost_.load()) {
    return lose(Ending::Broken, "an answer of the server of " + who +
                                    " was lost on its way, over " +
                                    std::string(connection_->capabilities().name) +
                                    ", which loses nothing unless its memory is damaged");
  }
  const bool open = calls_.open() != 0;
  switch (server_.judge_answers(open, heard_.load(std::memory_order_relaxed))) {
    case AnswerWatch::Verdict::Fine:
      return;
    case AnswerWatch::Verdict::Ask:
      return calls_.query_old_calls();
    case AnswerWatch::Verdict::Mute:
      char seconds[32];
      std::snprintf(seconds, sizeof seconds, "%.1f s",
                    std::chrono::duration<double>(server_.mute_for()).count());
      return lose(Ending::Silent, "the server of " + who +
                                      " gives signs of life but has answered "
                                      "nothing for " +
                                      seconds + "; start it anew if it hangs");
  }
}

void ClientConnection::watch(std::vector<pollfd>& into) {
  if (lost() || !has_watchers() || !leader_lock_.try_take()) return;
  watching_ = true;
  if (connection_->prepare_to_sleep()) {
    for (const int descriptor : connection_->descriptors()) into.push_back({descriptor, POLLIN, 0});
  } else {
    wake_maintenance();
  }
  leader_lock_.rest();
}

void ClientConnection::unwatch() {
  if (!watching_) return;
  watching_ = false;
  leader_lock_.resume();
  connection_->woke();
  read_all();
  look_for_loss();
  leader_lock_.drop();
  leader_lock_.notify(nullptr);
}

}  // namespace gecos::session
