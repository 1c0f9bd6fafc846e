#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "gecos/base/function_ref.hpp"
#include "gecos/base/result.hpp"
#include "gecos/description.hpp"
#include "gecos/session/protocol/start_words.hpp"

namespace gecos::session {

/// A call as the queue of its object sees it.
struct QueueEntry {
  QueueEntry(SessionId its_client, const OperationDescription& its_operation,
             std::size_t its_bytes = 0)
      : client(its_client), operation(its_operation), bytes(its_bytes) {}
  virtual ~QueueEntry() = default;

  const SessionId client;
  const OperationDescription& operation;
  const std::size_t bytes;  ///< size of its arguments

  CallLane lane = CallLane::None;
};

enum class LaneThreads : std::uint8_t {
  One,   ///< one handler of the object at a time, whatever its lane
  Many,  ///< the servant takes calls on several threads
};

/// The order in which one object's calls start: a bounded FIFO lane for actor commands, a lane for
/// sensor operations, and a safety lane before both. Actor commands run one at a time, unless the
/// interface says otherwise. Pure and not thread-safe.
class ObjectQueue {
 public:
  static constexpr std::size_t most_of_object = 256;
  static constexpr std::size_t most_of_client = 64;
  /// Limits in bytes for the arguments of calls that have not ended: of one client, and of all. A
  /// call that is alone is accepted whatever its size; calls below `small` are limited by number
  /// only.
  static constexpr std::size_t most_bytes_of_client = 16 * 1024 * 1024;
  static constexpr std::size_t most_bytes_of_object = 64 * 1024 * 1024;
  static constexpr std::size_t small = 4096;

  explicit ObjectQueue(LaneThreads threads) : threads_(threads) {}

  enum class Full : std::uint8_t { Object, Client, BytesOfObject, BytesOfClient };
  /// A preempting command needs no room beside the commands that it replaces; the caller of `push`
  /// must then end those.
  tl::expected<void, Full> push(std::shared_ptr<QueueEntry> entry);

  /// Takes the next call that may start now. Null when none may.
  std::shared_ptr<QueueEntry> next();
  /// As above, among the calls that `wanted` selects. Actor commands keep their order: one that is
  /// not selected blocks those after it.
  std::shared_ptr<QueueEntry> next(FunctionRef<bool(const QueueEntry&)> wanted);
  /// The thread of the handler returned. The call may be answered later.
  void returned(const QueueEntry& entry);
  /// The call is answered and its handler has returned: the next call may start.
  void ended(const QueueEntry& entry);
  /// Removes a call that has not started; returns false when it is not queued.
  bool remove(const QueueEntry& entry);
  /// Removes and returns all calls that have not started.
  std::vector<std::shared_ptr<QueueEntry>> drop();

  /// Actor commands that wait, first to start first.
  const std::deque<std::shared_ptr<QueueEntry>>& waiting() const { return actor_; }
  /// Actor commands that started and have not ended.
  const std::vector<QueueEntry*>& running() const { return running_; }
  /// No call waits, and no call runs.
  bool idle() const;
  /// The running actor commands for which the first waiting one must wait.
  std::vector<QueueEntry*> holding_up() const;
  std::optional<std::size_t> position(const QueueEntry& entry) const;

 private:
  using Lane = std::deque<std::shared_ptr<QueueEntry>>;
  Lane& lane_of(const QueueEntry& entry);
  bool keeps_place(const QueueEntry& entry) const;
  std::shared_ptr<QueueEntry> start(Lane& lane, Lane::iterator at);
  std::optional<Full> too_large(const QueueEntry& entry) const;
  bool beside_running(const QueueEntry& entry) const;

  const LaneThreads threads_;
  Lane safety_;
  Lane sensor_;
  Lane actor_;
  std::vector<QueueEntry*> running_;
  std::size_t inside_ = 0;                ///< handlers whose thread has not returned
  std::vector<const QueueEntry*> large_;  ///< calls of at least `small` bytes that have not ended
};

}  // namespace gecos::session
