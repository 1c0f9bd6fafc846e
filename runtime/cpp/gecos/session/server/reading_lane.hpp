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
/// start in the order in which they came. So a reading waits for at most one reading of each other
/// session, however many those have asked for, and for the handler that runs. Not thread-safe.
class ReadingLane {
 public:
  using Entry = std::shared_ptr<QueueEntry>;

  void push(Entry entry);
  /// Removes and returns the reading that starts next among those that `wanted` selects; null if
  /// there is none.
  Entry take(FunctionRef<bool(const QueueEntry&)> wanted);
  /// Removes a reading; returns false when it does not wait here.
  bool remove(const QueueEntry& entry);
  void clear();

  bool empty() const { return waiting_.empty(); }
  std::size_t size() const { return waiting_.size(); }
  /// The readings that wait, in the order in which they came.
  const std::deque<Entry>& waiting() const { return waiting_; }

 private:
  /// A client with readings that wait.
  struct Reader {
    SessionId client;
    std::size_t waiting;
  };
  Entry erase(std::deque<Entry>::iterator at);

  std::deque<Entry> waiting_;
  std::vector<Reader> readers_;  ///< in the order of their turns
};

}  // namespace gecos::session
