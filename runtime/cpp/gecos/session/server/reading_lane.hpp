#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "gecos/base/function_ref.hpp"
#include "gecos/session/protocol/start_words.hpp"

namespace gecos::session {

struct QueueEntry;

/// The readings that wait at an object. The clients take turns, and the readings of one client
/// start in the order in which they arrived. So a reading waits for the running handler and for at
/// most one reading of each other client, however many readings the other clients have issued. Not
/// thread-safe.
class ReadingLane {
 public:
  using Entry = std::shared_ptr<QueueEntry>;

  void push(Entry entry);
  /// Among the readings that `wanted` selects, removes and returns the one that starts next; null
  /// if there is none.
  Entry take(FunctionRef<bool(const QueueEntry&)> wanted);
  /// Removes a reading. Returns false when the reading does not wait here.
  bool remove(const QueueEntry& entry);
  void clear();

  bool empty() const { return waiting_.empty(); }
  std::size_t size() const { return waiting_.size(); }
  /// Returns the waiting readings in the order in which they arrived.
  const std::deque<Entry>& waiting() const { return waiting_; }

 private:
  /// A client with calls that wait in this lane.
  struct Reader {
    SessionId client;
    std::size_t waiting;
  };
  Entry erase(std::deque<Entry>::iterator at);

  std::deque<Entry> waiting_;
  std::vector<Reader> readers_;  ///< in the order of their turns
};

}  // namespace gecos::session
