#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <variant>

#include "gecos/base/mutex.hpp"
#include "gecos/servant.hpp"

/// Servants that put arriving calls into queues. Other threads take the calls from the queues and
/// handle them.
///
/// The code of this file does not depend on Python. The threads of a session only put calls into
/// the queues, so that they never need the GIL.
namespace gecos::python {

enum class Lane : std::uint8_t {
  Safety,  ///< stop requests and safety operations
  Sensor,  ///< sensor operations that are neither cancelable nor ordered
  Fifo,    ///< all other operations, in the order of arrival
};

/// The task that tells the handlers that a client has stopped the object.
struct Stopped {};
using Task = std::variant<IncomingCall, Stopped>;

/// The queue of the calls that wait for the handlers of one lane. Thread-safe.
class TaskQueue {
 public:
  void push(Task task);
  /// Waits for the next task that may start, and returns it. A call that is returned counts as
  /// started. Returns nullopt after `close`.
  std::optional<Task> next();
  /// Makes `next` return nullopt, and rejects the calls that still wait.
  void close();

 private:
  std::optional<Task> pull();

  Mutex mutex_;
  ConditionVariable arrived_;
  std::deque<Task> waiting_ GECOS_GUARDED_BY(mutex_);
  bool closed_ GECOS_GUARDED_BY(mutex_) = false;
};

/// A servant that puts each call into the queue of its lane.
class PulledServant final : public Servant {
 public:
  explicit PulledServant(const InterfaceDescription& interface) : interface_(interface) {}

  const InterfaceDescription& gecos_interface() const override { return interface_; }
  void gecos_dispatch(IncomingCall call) override;
  bool gecos_begins_calls() const override { return true; }
  bool gecos_share_thread(const OperationDescription& one,
                          const OperationDescription& other) const override;
  /// Puts a Stopped task into the queue of the safety lane. Any thread may call this method.
  void stopped() { queue(Lane::Safety).push(Stopped{}); }
  /// Waits for the next task of the lane and returns it; nullopt after `close`. Any thread may call
  /// this method.
  std::optional<Task> next(Lane lane) { return queue(lane).next(); }
  /// Closes all lanes, so that `next` returns no further task.
  void close();
  /// Publishes a sample of the stream whose code is `code`. Returns false when the interface has no
  /// such stream.
  bool publish(FunctionCode code, ByteView sample, std::int64_t stamp_ns);
  /// Lends the memory of a sample that has `octets` octets between `head` and `tail`. Fails with
  /// the reason.
  tl::expected<Loan, std::string> lend(FunctionCode code, ByteView head, std::size_t octets,
                                       ByteView tail);
  /// Calls `use` with the inward stream whose code is `code`; does nothing while the servant is not
  /// served. Returns false when the interface has no such stream.
  bool with_inward(FunctionCode code, FunctionRef<void(session::InwardCore&)> use) const;

 private:
  TaskQueue& queue(Lane lane) { return lanes_.at(static_cast<std::size_t>(lane)); }

  const InterfaceDescription& interface_;
  std::array<TaskQueue, 3> lanes_;
};

}  // namespace gecos::python
