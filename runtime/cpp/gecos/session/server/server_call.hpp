#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "gecos/base/short_bytes.hpp"
#include "gecos/servant.hpp"
#include "gecos/session/process/handler_here.hpp"
#include "gecos/session/server/blend_chain.hpp"
#include "gecos/session/server/call_state.hpp"
#include "gecos/session/server/call_statistics.hpp"
#include "gecos/session/server/object_queue.hpp"

namespace gecos::session {

class ObjectHost;
class ServerSession;

/// Says which call the thread of a handler waits for without a time-out, and since when.
struct HandlerWait {
  CommandId command;
  std::string name;
  TimePoint since{};
};

/// One call at the server, from its arrival until the call is answered and its handler has
/// returned. This class has more members than other classes, because the other classes of the
/// server store their data about one call here and so need no tables of their own.
class ServerCall final : public CallCore,
                         public QueueEntry,
                         public HandlerHere,
                         public std::enable_shared_from_this<ServerCall> {
 public:
  ServerCall(std::shared_ptr<ServerSession> session, const OperationDescription& operation,
             std::uint64_t counter, Epoch epoch, ByteView arguments);

  const OperationDescription& operation() const override { return QueueEntry::operation; }
  ByteView arguments() const override { return arguments_.view(); }
  const Caller& caller() const override;
  std::uint64_t counter_in_session() const override { return counter; }
  std::uint64_t status_epoch() const override { return number(epoch); }
  bool interrupted() const override { return interrupted_.load(std::memory_order_acquire); }
  bool wait_interrupted_until(TimePoint deadline) override;
  bool begin() override;
  std::optional<TimePoint> marked_at() const override;
  void progress(double fraction, ByteView feedback) override;
  void let_next() override;
  void finish(ByteView result) override;
  void fail(Failure failure) override;

  std::shared_ptr<HandlerHere> shared() override { return shared_from_this(); }
  void waits(const CommandCore& command) override;
  void goes_on() override;

  /// Records the moment at which the call is marked as started. Must be called before the mark of
  /// the call is written, with the object's mutex held.
  void note_mark(TimePoint now) { marked_at_.store(now, std::memory_order_relaxed); }

  /// `listener` returns the session in which the progress and the outcome of this call are
  /// reported. `counter_in` returns the counter of the call in a session. Both functions require
  /// the object's mutex.
  ServerSession& listener() const { return resumed_in ? *resumed_in : *session; }
  std::uint64_t counter_in(const ServerSession& teller) const {
    return resumed_in.get() == &teller ? resumed_counter : counter;
  }
  ObjectHost& object() const;
  /// Returns a text such as "'move' of RX90".
  std::string title() const;
  /// Sets the interrupt flag only; ObjectCalls::interrupt also wakes the waiting threads.
  void interrupt() { interrupted_.store(true, std::memory_order_release); }

  const std::shared_ptr<ServerSession> session;
  const std::uint64_t counter;
  const Epoch epoch;

  // Guarded by the object's mutex.
  std::shared_ptr<ServerSession>
      resumed_in;  ///< the later session in which the client sent the call again, if it did
  std::uint64_t resumed_counter = 0;
  CallState state;
  CallProgress reported;
  std::size_t position_sent = 0;
  TimePoint arrived{};  ///< set only when the end of the call will be logged
  std::optional<HandlerWait> waits_for;
  bool listed = false;  ///< the call is in ObjectCalls::open_
  /// Set if this call is left out, that is, not carried out, because an earlier command with
  /// @on_new("blend") of the session failed. Set as soon as that failure is known; if the handler
  /// of this call has begun, the handler is then interrupted.
  std::optional<BlendChain::LeftOut> left_out;
  OperationCounts* counts = nullptr;  ///< the counts of the operation; set when the call is queued
  HandlerTiming timing{};

 private:
  const ShortBytes arguments_;
  std::atomic<bool> interrupted_{false};                // orders no other memory
  std::atomic<TimePoint> marked_at_{TimePoint::max()};  // orders no other memory
};

}  // namespace gecos::session
