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
  /// Returns how many calls ended with each detail. Omits the details with which no call ended.
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
  std::uint32_t weight = 0;  ///< result of timed_weight(); 0: the time is not measured
};

/// The counts of the calls of one object, for each operation. Memory for an operation is allocated
/// at its first call. Not thread-safe: the object's mutex guards it.
class CallStatistics {
 public:
  /// Must be constructed when the server begins to serve the object. `clock` must outlive this
  /// object.
  explicit CallStatistics(const Clock& clock) : clock_(clock), since_(clock.now()) {}

  /// Returns the time by Clock::now since which calls are counted.
  TimePoint since() const { return since_; }

  /// Must be called for each call that is queued, before the functions below.
  void queued(ServerCall& call);
  /// Must be called when the handler of `call` begins. `since_boot`: the time at which the handler
  /// begins, possibly one kernel tick too early. `long_running`: the handler runs on a worker
  /// thread, so its time is always measured.
  void begins(ServerCall& call, TimePoint since_boot, bool long_running);
  /// Must be called when the handler of `call` has run for at least one tick of the maintenance
  /// thread. The time of such a handler is always measured.
  static void runs_long(ServerCall& call);
  /// Must be called when `call` ends with `detail`.
  void ended(ServerCall& call, Detail detail);
  /// Must be called when the handler of `call` has answered and returned, or will not begin.
  void finished(ServerCall& call);
  /// Must be called when a call of `session` ended with `detail` and was never queued. `operation`:
  /// null when the interface has no such operation.
  void refused(ServerSession& session, const OperationDescription* operation, Detail detail);

  /// Returns the counts of all operations that were called, sorted by name.
  std::vector<OperationStats> shown() const;

 private:
  /// Returns the counts of `operation`. The reference is valid as long as this object exists.
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
