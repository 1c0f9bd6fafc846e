#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <variant>

#include "gecos/session/servant.hpp"

/// Servants whose handlers are elsewhere: what arrives is queued, and somebody pulls it.
///
/// Nothing here knows Python: the session's threads only ever push.
namespace gecos::python {

enum class Lane : std::uint8_t {
  Sensor,  ///< short sensor operations, safety operations, stops
  Fifo,    ///< everything else, in its order
};

/// A call for a servant, by its number.
struct Arrived {
  std::size_t servant = 0;
  IncomingCall call;
};
/// Somebody stopped a servant.
struct Stopped {
  std::size_t servant = 0;
};
using Task = std::variant<Arrived, Stopped>;

/// What waits for the handlers of one server. Thread-safe.
class TaskQueue {
 public:
  void push(Lane lane, Task task);
  /// Waits for the next task of a lane; nothing at `until`, or when closed.
  std::optional<Task> next(Lane lane, TimePoint until);
  /// Nothing is given out any more; what still waits is answered as not handled.
  void close();
  bool closed() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::array<std::deque<Task>, 2> lanes_;
  bool closed_ = false;
};

/// Queues its calls. The queue must outlive it.
class PulledServant final : public Servant {
 public:
  PulledServant(const InterfaceDescription& interface, TaskQueue& tasks, std::size_t number)
      : interface_(interface), tasks_(tasks), number_(number) {}

  const InterfaceDescription& gecos_interface() const override { return interface_; }
  void gecos_dispatch(IncomingCall call) override;
  /// Any thread.
  void stopped() { tasks_.push(Lane::Sensor, Stopped{number_}); }
  /// Publishes a sample of the stream with this code; false when the interface has none.
  bool publish(FunctionCode code, ByteView sample, std::int64_t stamp_ns);

 private:
  const InterfaceDescription& interface_;
  TaskQueue& tasks_;
  const std::size_t number_;
};

}  // namespace gecos::python
