#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/object.hpp"
#include "gecos/qos/latency_sample.hpp"
#include "gecos/qos/latency_watch.hpp"
#include "gecos/session/protocol/suspend_aware_clock.hpp"

namespace gecos::session {

class ClientConnection;
class PendingCommand;

/// Measures the round trip of one session by pings if the interface demands a bound of the latency.
/// When the round trip exceeds the bound, does what `on_degraded` of the interface says. A session
/// without a bound sends no pings. Thread-safe, except for functions whose comments say otherwise.
class LineProbe {
 public:
  explicit LineProbe(ClientConnection& session);
  ~LineProbe();
  LineProbe(const LineProbe&) = delete;
  LineProbe& operator=(const LineProbe&) = delete;

  /// Sets the bound of the round trip; zero: no bound. `simulated`: whether the object is a
  /// simulated device. Delays of a simulated device do no harm, so they cause no warnings in the
  /// log. Must be called before other threads know the session.
  void bound_by(Duration bound, const InterfaceDescription& wanted, bool simulated);
  /// Measures the latency by pings, for at most `longest`. Blocks. Returns nullopt when the session
  /// is lost. Must not be called on the maintenance thread.
  std::optional<qos::LatencySample::Latency> measure(Duration longest);
  /// Called by the maintenance thread.
  void on_tick(TimePoint now);
  LineState state() const;
  /// Waits until `LineState::degraded` has changed more than `changes` times, the session is lost
  /// or closed, or `deadline` has passed.
  LineState await_change(std::uint64_t changes, TimePoint deadline) const;
  /// Returns the level at which changes of the connection are logged.
  LogLevel log_level() const;
  /// Returns how many pings this object has sent. The program has not issued these calls, so
  /// ClientSession::issued() must not count them.
  std::uint64_t pings() const { return pings_.load(std::memory_order_relaxed); }

 private:
  void send(TimePoint now);
  void take_answer(TimePoint now);
  void note(qos::LatencyWatch::Change change);

  ClientConnection& session_;
  // Only the maintenance thread uses the following members, after bound_by() was called.
  std::optional<qos::LatencyWatch> watch_;
  qos::OnDegraded on_degraded_ = qos::OnDegraded::Event;
  bool simulated_ = false;
  SuspendAwareClock clock_;
  std::shared_ptr<PendingCommand> ping_;  ///< the ping that is under way
  TimePoint sent_{};
  std::atomic<std::uint64_t> pings_{0};  // orders no other memory

  mutable Mutex mutex_;
  mutable ConditionVariable changed_;
  LineState state_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
