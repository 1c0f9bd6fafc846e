#include "gecos/session/server/reading_lane.hpp"

#include <algorithm>
#include <utility>

#include "gecos/session/server/object_queue.hpp"

namespace gecos::session {

void ReadingLane::push(Entry entry) {
  const auto reader = std::ranges::find(readers_, entry->client, &Reader::client);
  if (reader == readers_.end()) {
    readers_.push_back({entry->client, 1});
  } else {
    ++reader->waiting;
  }
  waiting_.push_back(std::move(entry));
}

ReadingLane::Entry ReadingLane::take(FunctionRef<bool(const QueueEntry&)> wanted) {
  for (auto reader = readers_.begin(); reader != readers_.end(); ++reader) {
    const auto at = std::ranges::find_if(waiting_, [&](const auto& entry) {
      return entry->client == reader->client && wanted(*entry);
    });
    if (at == waiting_.end()) continue;
    std::rotate(reader, reader + 1, readers_.end());  // its next turn comes after the others'
    return erase(at);
  }
  return nullptr;
}

bool ReadingLane::remove(const QueueEntry& entry) {
  const auto at = std::ranges::find(waiting_, &entry, &Entry::get);
  if (at == waiting_.end()) return false;
  erase(at);
  return true;
}

void ReadingLane::clear() {
  waiting_.clear();
  readers_.clear();
}

ReadingLane::Entry ReadingLane::erase(std::deque<Entry>::iterator at) {
  Entry entry = std::move(*at);
  waiting_.erase(at);
  const auto reader = std::ranges::find(readers_, entry->client, &Reader::client);
  if (--reader->waiting == 0) readers_.erase(reader);
  return entry;
}

}  // namespace gecos::session
