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
  const std::size_t bytes;  ///< its arguments take

  CallLane lane = CallLane::None;
};

enum class LaneThreads : std::uint8_t {
  One,   ///< one handler of the object at a time, whatever its lane
  Many,  ///< the servant takes calls on several threads
};

/// The order in which one object's calls start: one bounded FIFO for what moves it, a lane beside
/// it for reading, and safety before both. Actor commands run one at a time, unless the interface
/// says otherwise. Pure and not thread-safe.
class ObjectQueue {
 public:
  static constexpr std::size_t most_of_object = 256;
  static constexpr std::size_t most_of_client = 64;
  /// What the arguments of calls may take that have not ended: of one client, and of all. A call
  /// alone is taken whatever it takes; those below `small` are bounded by their number.
  static constexpr std::size_t most_bytes_of_client = 16 * 1024 * 1024;
  static constexpr std::size_t most_bytes_of_object = 64 * 1024 * 1024;
  static constexpr std::size_t small = 4096;

  explicit ObjectQueue(LaneThreads threads) : threads_(threads) {}

  enum class Full : std::uint8_t { Object, Client, BytesOfObject, BytesOfClient };
  /// One that preempts needs no room beside the commands that it replaces; its owner ends them
  /// then.
  tl::expected<void, Full> push(std::shared_ptr<QueueEntry> entry);

  /// Takes the next call that may start now. Null when none may.
  std::shared_ptr<QueueEntry> next();
  /// Likewise, of those that `wanted` picks. Actor commands keep their order: one that is not
  /// wanted holds up those behind it.
  std::shared_ptr<QueueEntry> next(FunctionRef<bool(const QueueEntry&)> wanted);
  /// Its handler's thread came back. The call may be answered later.
  void returned(const QueueEntry& entry);
  /// It is answered and its handler has returned: its successor may start.
  void ended(const QueueEntry& entry);
  /// Takes it out before it started; false when it is not queued.
  bool remove(const QueueEntry& entry);
  /// Takes out all that has not started.
  std::vector<std::shared_ptr<QueueEntry>> drop();

  /// Actor commands that wait, first to start first.
  const std::deque<std::shared_ptr<QueueEntry>>& waiting() const { return actor_; }
  /// Actor commands that started and have not ended.
  const std::vector<QueueEntry*>& running() const { return running_; }
  /// Nothing waits and no handler is inside.
  bool idle() const;
  /// Those of them that the next one waits for.
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
  std::size_t inside_ = 0;                ///< handlers whose thread has not come back
  std::vector<const QueueEntry*> large_;  ///< not below `small`, that have not ended
};

}  // namespace gecos::session
