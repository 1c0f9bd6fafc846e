#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/command.hpp"
#include "gecos/description.hpp"
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/server/handler_times.hpp"

namespace gecos::session {

class ServerCall;
class ServerSession;

/// Counts of calls, for one operation or for one session.
struct CallCounts {
  std::uint64_t begun = 0;  ///< handlers that have begun
  std::uint64_t deadline_missed = 0;
  std::uint64_t start_by_missed = 0;
  std::array<std::uint64_t, static_cast<std::size_t>(Detail::QosUnavailable) + 1> ended{};

  void count_end(Detail detail) { ++ended[static_cast<std::size_t>(detail)]; }
  /// Returns the ends that were counted, without the details that never came.
  std::vector<OutcomeCount> outcomes() const;
};

/// The counts of one operation of an object.
struct OperationCounts {
  CallCounts calls;
  HandlerTimes times;
};

/// The measurement of the time of one handler.
struct HandlerTiming {
  TimePoint from{};          ///< a moment of Clock::since_boot
  std::uint32_t weight = 0;  ///< timed_weight; 0: the time is not taken
};

/// The counts of the calls of one object, for each operation. Memory for an operation is allocated
/// at its first call. Not thread-safe: the object's mutex guards it.
class CallStatistics {
 public:
  /// `clock` must outlive this object, which is made when the object begins to be served.
  explicit CallStatistics(const Clock& clock) : clock_(clock), since_(clock.now()) {}

  /// Returns the time by Clock::now since which calls are counted.
  TimePoint since() const { return since_; }

  /// Must be called first for each call that is queued.
  void queued(ServerCall& call);
  /// The handler of `call` begins, at `since_boot`, which may be one kernel tick ago.
  /// `long_running`: it runs on a worker thread, so its time is taken.
  void begins(ServerCall& call, TimePoint since_boot, bool long_running);
  /// The handler of `call` runs for at least one tick of the maintenance thread: its time is taken.
  static void runs_long(ServerCall& call);
  /// The outcome of `call` is `detail`.
  void ended(ServerCall& call, Detail detail);
  /// The handler of `call` has answered and returned, or did not begin.
  void finished(ServerCall& call);
  /// A call of `session` ended with `detail` and was never queued. `operation`: null when the
  /// interface has no such operation.
  void refused(ServerSession& session, const OperationDescription* operation, Detail detail);

  /// Returns the counts of all operations that were called, sorted by name.
  std::vector<OperationStats> shown() const;

 private:
  /// Returns the counts of `operation`, which stay at their place.
  OperationCounts& of(const OperationDescription& operation) {
    if (last_ != &operation) find(operation);
    return *last_counts_;
  }
  void find(const OperationDescription& operation);

  const Clock& clock_;
  const TimePoint since_;
  std::unordered_map<const OperationDescription*, std::unique_ptr<OperationCounts>> operations_;
  const OperationDescription* last_ = nullptr;  ///< the operation that was looked up last
  OperationCounts* last_counts_ = nullptr;
};

}  // namespace gecos::session
