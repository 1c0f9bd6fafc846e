// What the maintenance thread does for the client side of a session.
#include <algorithm>
#include <cstdio>

#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/protocol/retry.hpp"

namespace gecos::session {
namespace {

/// Maximum time between two polls while calls are open over a medium that loses nothing. A packet
/// that was sent without a wake-up is read after at most this time.
constexpr Duration longest_sleep = std::chrono::milliseconds(50);

}  // namespace

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
  if (!lost() && !unreachable()) judge_answers(liveness_clock_.now());
  return lost() ? TimePoint::max() : repeat(now);
}

void ClientConnection::check_liveness(TimePoint now) {
  now = liveness_clock_.advance(now);
  const auto verdict = liveness_.check(connection_->beats_seen(), now);
  if (verdict == PeerLiveness::Verdict::Quiet) return;
  const bool silent = verdict != PeerLiveness::Verdict::Alive;
  if (silent && !unreachable()) {
    silent_since_.store(runtime_->clock().now(), std::memory_order_relaxed);
  }
  unreachable_.store(silent, std::memory_order_relaxed);
  if (verdict == PeerLiveness::Verdict::Suspect) {
    if (failover_ && has_repeatable()) failover_->look_for_another(shared_from_this());
  }
  if (verdict != PeerLiveness::Verdict::Dead) return;
  const Duration length = liveness_.silent_for(now);
  const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(length).count();
  lose(Ending::Silent, "the server of " + welcome_.object + " (" + connection_->peer().description +
                           ") has been silent for " + std::to_string(milliseconds) + " ms");
}

/// Ends the session when the server sends heartbeats but no answers for longer than AnswerWatch
/// allows.
void ClientConnection::judge_answers(TimePoint now) {
  const std::string who = welcome_.object + " (" + connection_->peer().description + ")";
  if (answer_lost_.load()) {
    return lose(Ending::Broken, "an answer of the server of " + who +
                                    " was lost on its way, over " +
                                    std::string(connection_->capabilities().name) +
                                    ", which loses nothing unless its memory is damaged");
  }
  bool open = false;
  {
    const MutexLock lock(mutex_);
    open = calls_.size() != 0;
  }
  switch (answers_.judge(open, heard_.load(std::memory_order_relaxed), now)) {
    case AnswerWatch::Verdict::Fine:
      return;
    case AnswerWatch::Verdict::Ask:
      return ask_after_calls();
    case AnswerWatch::Verdict::Mute:
      char seconds[32];
      std::snprintf(seconds, sizeof seconds, "%.1f s",
                    std::chrono::duration<double>(answers_.silent_for(now)).count());
      return lose(Ending::Silent, "the server of " + who +
                                      " gives signs of life but has answered "
                                      "nothing for " +
                                      seconds + "; start it anew if it hangs");
  }
}

/// Queries calls that are open for long, because a reply may have been damaged in shared memory.
/// Does nothing over a medium that loses packets: there the calls are sent again anyway.
void ClientConnection::ask_after_calls() {
  if (repeats_) return;
  const MutexLock lock(mutex_);
  for (const auto& [counter, command] : calls_.all()) {
    if (counter > open_when_asked_) break;
    wire::PacketHeader header;
    header.kind = wire::PacketKind::Query;
    header.counter = counter;
    if (!send(header, {})) break;
  }
  open_when_asked_ = next_counter_ - 1;
}

/// Over a medium that loses packets, sends each open call again with the same counter: the whole
/// call until its arrival is confirmed, after that only a Query for its outcome. Over any medium,
/// sends a Cancel again that found no room.
TimePoint ClientConnection::repeat(TimePoint now) {
  const MutexLock lock(mutex_);
  // Without open calls only the next heartbeat is due: many idle clients must cost nothing.
  if (!repeats_ && calls_.size() == 0) return next_beat_;
  if (!repeats_ && !cancels_waiting_) return std::min(next_beat_, now + longest_sleep);
  const TimePoint soon = now + Maintenance::tick;
  cancels_waiting_ = false;
  for (const auto& [counter, command] : calls_.all()) {
    auto& retry = command->retry;
    if (!repeats_ && !retry.cancel) continue;
    if (now < retry.next) continue;
    wire::PacketHeader header;
    header.counter = counter;
    if (retry.cancel) {
      header.kind = wire::PacketKind::Cancel;
      if (!send(header, {})) cancels_waiting_ = true;
    }
    if (repeats_ && retry.arrived) {
      header.kind = wire::PacketKind::Query;
      static_cast<void>(send(header, {}));
    } else if (repeats_ && !unreachable()) {
      if (retry.deadline != TimePoint::max()) {
        const Duration left = retry.deadline - runtime_->clock().since_boot();
        wire::write_deadline(retry.packet, std::max(left, Duration{1}));
      }
      if (connection_->send(retry.packet, {})) retry.on_its_way = true;
    }
    retry.next = now + retry_after(++retry.sent);
    if (!repeats_) retry.cancel = cancels_waiting_;
  }
  return soon;
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
