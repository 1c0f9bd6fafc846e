#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "gecos/base/short_bytes.hpp"
#include "gecos/servant.hpp"
#include "gecos/session/process/handler_here.hpp"
#include "gecos/session/server/object_queue.hpp"

namespace gecos::session {

class ObjectHost;
class ServerSession;

/// One call at the server, from its arrival until it is answered and its handler has returned.
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
  bool interrupted() const override { return interrupted_.load(std::memory_order_acquire); }
  bool wait_interrupted_until(TimePoint deadline) override;
  bool begin() override;
  std::optional<TimePoint> marked_at() const override;
  void progress(double fraction, ByteView feedback) override;
  void finish(ByteView result) override;
  void fail(Failure failure) override;

  std::shared_ptr<HandlerHere> shared() override { return shared_from_this(); }
  void waits(const CommandCore& command) override;
  void goes_on() override;

  /// Before its mark is written; with the object's mutex.
  void note_mark(TimePoint now) { marked_at_.store(now, std::memory_order_relaxed); }

  /// Who is told how it goes, and under which number; with the object's mutex.
  ServerSession& listener() const { return resumed_in ? *resumed_in : *session; }
  std::uint64_t counter_in(const ServerSession& teller) const {
    return resumed_in.get() == &teller ? resumed_counter : counter;
  }
  ObjectHost& object() const;
  /// "'move' of RX90"
  std::string title() const;
  /// Who waits for it is woken by its object.
  void interrupt() { interrupted_.store(true, std::memory_order_release); }
  /// Where it stands until it is terminal; with the object's mutex.
  Detail running_detail() const {
    return canceling ? Detail::Canceling : started ? Detail::Executing : Detail::Queued;
  }

  const std::shared_ptr<ServerSession> session;
  const std::uint64_t counter;
  const Epoch epoch;

  // Guarded by the object's mutex.
  std::shared_ptr<ServerSession>
      resumed_in;  ///< in which it was sent again, because its own was lost
  std::uint64_t resumed_counter = 0;
  TimePoint deadline = TimePoint::max();
  bool terminal = false;  ///< the caller has its outcome
  bool answered = false;  ///< the handler has given its answer, heard or not
  bool returned = false;  ///< the handler's thread came back
  TimePoint arrived{};    ///< where that is logged
  TimePoint begun{};      ///< its handler, since boot; nothing before, and once it is over
  std::optional<CommandId> awaited;  ///< its handler's thread waits for that without a bound,
  std::string awaited_name;          ///< which is called so,
  TimePoint awaited_since{};         ///< since then
  bool canceling = false;
  bool listed = false;  ///< among the object's open calls
  double fraction = 0;
  Bytes feedback;
  bool progress_dirty = false;  ///< progress that the caller does not know yet
  TimePoint progress_sent{};
  std::size_t position_sent = 0;

 private:
  const ShortBytes arguments_;
  std::atomic<bool> interrupted_{false};                // publishes nothing but itself
  std::atomic<TimePoint> marked_at_{TimePoint::max()};  // publishes nothing but itself
};

}  // namespace gecos::session
