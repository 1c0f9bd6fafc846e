#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/function_ref.hpp"
#include "gecos/base/result.hpp"
#include "gecos/description.hpp"
#include "gecos/session/server/queue_entry.hpp"
#include "gecos/session/server/reading_lane.hpp"

namespace gecos::session {

enum class LaneThreads : std::uint8_t {
  One,   ///< only one handler of the object runs at a time, in whichever lane
  Many,  ///< handlers may run on several threads, because the servant is thread-safe
};

/// Decides in which order the calls of one object start. The queue has three lanes. Safety
/// operations start first, then sensor operations, for which the clients take turns, then actor
/// commands. The lane of the actor commands is bounded and first in, first out. Actor commands run
/// one at a time, unless the interface says otherwise. A @parallel command does not wait for the
/// commands before it. Not thread-safe.
class ObjectQueue {
 public:
  static constexpr std::size_t most_of_object = 256;
  static constexpr std::size_t most_of_client = 64;
  /// Maximum number of queued calls of all visitors together. The remaining room of the queue is
  /// left to other clients.
  static constexpr std::size_t most_of_visitors = most_of_object / 4;
  /// Limits in bytes for the arguments of all calls that have not ended: of one client, of all
  /// clients of the object, and of all visitors together. A call of any size is accepted when no
  /// other large call is open. Calls with fewer than `small` bytes do not count; only their number
  /// is limited.
  static constexpr std::size_t most_bytes_of_client = 16 * 1024 * 1024;
  static constexpr std::size_t most_bytes_of_object = 64 * 1024 * 1024;
  static constexpr std::size_t most_bytes_of_visitors = most_bytes_of_object / 4;
  static constexpr std::size_t small = 4096;

  explicit ObjectQueue(LaneThreads threads) : threads_(threads) {}

  enum class Full : std::uint8_t {
    Object,
    Client,
    Visitors,
    BytesOfObject,
    BytesOfClient,
    BytesOfVisitors
  };
  /// Queues `entry`. Returns the number of actor commands that were queued or running before. When
  /// a limit is reached, fails and returns which limit. A preempting command may use the room of
  /// the commands that it replaces. The caller must end these commands after `push`.
  tl::expected<std::size_t, Full> push(std::shared_ptr<QueueEntry> entry);

  /// Removes and returns the next call that may start now; null when no call may start.
  std::shared_ptr<QueueEntry> next();
  /// Like next(), but considers only the calls that `wanted` selects. Actor commands keep their
  /// order: a command that is not selected blocks the commands after it.
  std::shared_ptr<QueueEntry> next(FunctionRef<bool(const QueueEntry&)> wanted);
  /// Must be called when the thread of the handler has returned. The call may be answered later.
  void returned(const QueueEntry& entry);
  /// Must be called when the call is answered and its handler has returned. After that the next
  /// call may start.
  void ended(const QueueEntry& entry);
  /// Removes a call that has not started. Returns false when the call is not queued.
  bool remove(const QueueEntry& entry);
  /// Removes and returns all calls that have not started.
  std::vector<std::shared_ptr<QueueEntry>> drop();

  /// Returns the queued actor commands, in the order in which they start.
  const std::deque<std::shared_ptr<QueueEntry>>& waiting() const { return actor_; }
  /// Returns the actor commands that have started and have not ended.
  const std::vector<QueueEntry*>& running() const { return running_; }
  /// True when no call is queued and no call runs.
  bool idle() const;
  /// Returns the running actor commands that must end before the first queued actor command may
  /// start.
  std::vector<QueueEntry*> holding_up() const;
  std::optional<std::size_t> position(const QueueEntry& entry) const;

 private:
  using Lane = std::deque<std::shared_ptr<QueueEntry>>;
  Lane& lane_of(const QueueEntry& entry);  ///< must not be called for a reading
  bool keeps_place(const QueueEntry& entry) const;
  Lane::iterator next_command();
  std::shared_ptr<QueueEntry> start(Lane& lane, Lane::iterator at);
  std::shared_ptr<QueueEntry> start(std::shared_ptr<QueueEntry> entry);
  /// Of the calls that have not started, returns how many `which` selects. Does not count safety
  /// operations or the actor commands that `entry` replaces.
  std::size_t count_waiting(const QueueEntry& entry,
                            FunctionRef<bool(const QueueEntry&)> which) const;
  std::optional<Full> too_large(const QueueEntry& entry) const;
  bool beside_running(const QueueEntry& entry) const;

  const LaneThreads threads_;
  Lane safety_;
  ReadingLane sensor_;
  Lane actor_;
  std::vector<QueueEntry*> running_;
  std::size_t inside_ = 0;                ///< number of handlers whose thread has not returned
  std::vector<const QueueEntry*> large_;  ///< calls of at least `small` bytes that have not ended
};

/// Returns a text for the caller that says which limit is reached and when to try again. `bytes`:
/// size of the arguments of the call that was not queued.
std::string text_of(ObjectQueue::Full full, std::size_t bytes);

}  // namespace gecos::session
