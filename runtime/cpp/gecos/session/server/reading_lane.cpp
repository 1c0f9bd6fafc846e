#include "gecos/session/server/reading_lane.hpp"

#include <algorithm>
#include <utility>

#include "gecos/session/server/queue_entry.hpp"

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
  // One pass is enough: each further entry that is found belongs to a client whose turn comes
  // earlier, so the entry found last is the result.
  auto turn = readers_.end();
  auto next = waiting_.end();
  for (auto at = waiting_.begin(); at != waiting_.end() && turn != readers_.begin(); ++at) {
    const auto reader = std::find_if(
        readers_.begin(), turn, [&](const Reader& one) { return one.client == (*at)->client; });
    if (reader == turn || !wanted(**at)) continue;
    turn = reader;
    next = at;
  }
  if (next == waiting_.end()) return nullptr;
  std::rotate(turn, turn + 1, readers_.end());  // the next turn of this client comes last
  return erase(next);
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
