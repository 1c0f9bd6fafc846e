#pragma once

#include <atomic>
#include <cstdint>

#include "gecos/base/clock.hpp"
#include "gecos/lab.hpp"
#include "gecos/session/client/answer_watch.hpp"
#include "gecos/session/protocol/peer_liveness.hpp"
#include "gecos/session/protocol/suspend_aware_clock.hpp"

namespace gecos::session {

/// Judges the server of one session by its heartbeats and by its answers. Does no I/O: the caller
/// passes the numbers of heartbeats and packets that have arrived. Any thread may call
/// `unreachable`, `silent_since` and `unheard_for`; only the maintenance thread may call the other
/// functions.
class ServerWatch {
 public:
  ServerWatch(const LabOptions& options, const Clock& clock);

  /// Returns true while the server has been silent for so long that it may be dead.
  bool unreachable() const { return unreachable_.load(std::memory_order_relaxed); }
  /// Returns the time at which the server became unreachable, by the clock of the runtime. @pre
  /// `unreachable()`
  TimePoint silent_since() const { return silent_since_.load(std::memory_order_relaxed); }
  /// Returns the time since the last heartbeat was read, by CLOCK_BOOTTIME. Unlike silent_for(), it
  /// includes time in which this process did not run.
  Duration unheard_for() const {
    return clock_.since_boot() - heard_at_.load(std::memory_order_relaxed);
  }

  /// Judges whether the server is alive. `heartbeats`: number of heartbeats received so far.
  PeerLiveness::Verdict judge_heartbeats(std::uint64_t heartbeats, TimePoint now);
  /// Returns the time since the last heartbeat.
  Duration silent_for() const { return liveness_.silent_for(liveness_clock_.now()); }

  /// Over a medium that sends heartbeats as packets: returns by when the maintenance thread must
  /// look for a packet of the server at the latest. Every `retry_after(1)` while no packet was read
  /// for one and a half heartbeat periods; otherwise a session that ticks once in a period would
  /// notice up to one period late that the server is unreachable, or that it sends again.
  TimePoint next_look(TimePoint now) const;

  /// Judges whether the server still answers. The judgement is made for the time of the last call
  /// of `judge_heartbeats`. `packets`: number of packets received so far.
  AnswerWatch::Verdict judge_answers(bool calls_are_open, std::uint64_t packets) {
    return answers_.judge(calls_are_open, packets, liveness_clock_.now());
  }
  /// Returns the time since the last packet of the server. Only time in which calls are open
  /// counts.
  Duration mute_for() const { return answers_.silent_for(liveness_clock_.now()); }

 private:
  const Clock& clock_;
  const Duration longest_gap_;        ///< between two packets of a server that sends regularly
  SuspendAwareClock liveness_clock_;  ///< measures how long the server is silent
  PeerLiveness liveness_;
  AnswerWatch answers_;
  std::atomic<bool> unreachable_{false};   // orders no other memory
  std::atomic<TimePoint> silent_since_{};  // valid while unreachable_; orders no other memory
  std::atomic<TimePoint> heard_at_;        // by CLOCK_BOOTTIME; orders no other memory
};

}  // namespace gecos::session
