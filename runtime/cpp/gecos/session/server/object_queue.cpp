#include "gecos/session/server/object_queue.hpp"

#include <algorithm>
#include <utility>

namespace gecos::session {
namespace {

/// Returns true for a preempting command. When such a command is queued, it ends the commands
/// before it. So it may use the room of these commands in the queue.
bool replaces(const QueueEntry& entry) { return entry.operation.on_new == OnNew::Preempt; }

bool may_start_beside(const QueueEntry& running, const QueueEntry& next) {
  const bool blends = running.lets_next && next.operation.on_new == OnNew::Blend;
  return running.operation.parallel || next.operation.parallel || blends;
}

}  // namespace

std::string text_of(ObjectQueue::Full full, std::size_t bytes) {
  const auto calls = [](std::size_t most, const char* whose) {
    return std::to_string(most) + " calls of " + whose +
           " are queued already; wait until one of them has ended";
  };
  const auto room = [&](std::size_t most, const char* whose) {
    return "its arguments take " + std::to_string(bytes) + " bytes; with the arguments of " +
           whose + " open calls, this exceeds the limit of " + std::to_string(most) +
           " bytes; wait until one of these calls has ended";
  };
  switch (full) {
    case ObjectQueue::Full::Object:
      return calls(ObjectQueue::most_of_object, "all clients");
    case ObjectQueue::Full::Client:
      return calls(ObjectQueue::most_of_client, "this client");
    case ObjectQueue::Full::Visitors:
      return calls(ObjectQueue::most_of_visitors, "visitors");
    case ObjectQueue::Full::BytesOfObject:
      return room(ObjectQueue::most_bytes_of_object, "all clients'");
    case ObjectQueue::Full::BytesOfClient:
      return room(ObjectQueue::most_bytes_of_client, "this client's");
    case ObjectQueue::Full::BytesOfVisitors:
      return room(ObjectQueue::most_bytes_of_visitors, "all visitors'");
  }
  return {};
}

tl::expected<std::size_t, ObjectQueue::Full> ObjectQueue::push(std::shared_ptr<QueueEntry> entry) {
  const std::size_t commands_before = actor_.size() + running_.size();
  const std::size_t commands = replaces(*entry) ? 0 : actor_.size();
  const std::size_t waiting = safety_.size() + sensor_.size() + commands;
  if (waiting != 0 && !entry->operation.safety) {
    if (waiting >= most_of_object) return tl::unexpected(Full::Object);
    const auto same_client = [&](const QueueEntry& one) { return one.client == entry->client; };
    if (count_waiting(*entry, same_client) >= most_of_client) return tl::unexpected(Full::Client);
    const auto visits = [](const QueueEntry& one) { return one.of_visitor; };
    if (entry->of_visitor && count_waiting(*entry, visits) >= most_of_visitors) {
      return tl::unexpected(Full::Visitors);
    }
  }
  if (entry->bytes >= small) {
    if (const auto full = too_large(*entry)) return tl::unexpected(*full);
    large_.push_back(entry.get());
  }
  if (entry->operation.safety) {
    entry->lane = CallLane::Safety;
  } else if (entry->operation.status == access::Status::Sensor && !keeps_place(*entry)) {
    entry->lane = CallLane::Sensor;
  } else {
    entry->lane = CallLane::Actor;
  }
  if (entry->lane == CallLane::Sensor) {
    sensor_.push(std::move(entry));
  } else {
    lane_of(*entry).push_back(std::move(entry));
  }
  return commands_before;
}

std::size_t ObjectQueue::count_waiting(const QueueEntry& entry,
                                       FunctionRef<bool(const QueueEntry&)> which) const {
  std::ptrdiff_t count = 0;
  for (const Lane* lane : {&sensor_.waiting(), &std::as_const(actor_)}) {
    if (lane == &actor_ && replaces(entry)) continue;
    count += std::ranges::count_if(*lane, [&](const auto& other) { return which(*other); });
  }
  return static_cast<std::size_t>(count);
}

std::optional<ObjectQueue::Full> ObjectQueue::too_large(const QueueEntry& entry) const {
  std::size_t of_object = 0;
  std::size_t of_client = 0;
  std::size_t of_visitors = 0;
  for (const QueueEntry* const other : large_) {
    if (replaces(entry) && other->lane == CallLane::Actor) continue;
    of_object += other->bytes;
    if (other->client == entry.client) of_client += other->bytes;
    if (entry.of_visitor && other->of_visitor) of_visitors += other->bytes;
  }
  if (of_client != 0 && of_client + entry.bytes > most_bytes_of_client) return Full::BytesOfClient;
  if (of_visitors != 0 && of_visitors + entry.bytes > most_bytes_of_visitors) {
    return Full::BytesOfVisitors;
  }
  if (of_object != 0 && of_object + entry.bytes > most_bytes_of_object) return Full::BytesOfObject;
  return std::nullopt;
}

/// Returns true for an @ordered reading whose caller has commands in the actor lane: the reading
/// must wait in that lane.
bool ObjectQueue::keeps_place(const QueueEntry& entry) const {
  if (!entry.operation.ordered) return false;
  const auto same_client = [&](const auto& other) { return other->client == entry.client; };
  return std::any_of(actor_.begin(), actor_.end(), same_client) ||
         std::any_of(running_.begin(), running_.end(), same_client);
}

bool ObjectQueue::idle() const {
  return actor_.empty() && sensor_.empty() && safety_.empty() && running_.empty() && inside_ == 0;
}

ObjectQueue::Lane& ObjectQueue::lane_of(const QueueEntry& entry) {
  return entry.lane == CallLane::Safety ? safety_ : actor_;
}

bool ObjectQueue::beside_running(const QueueEntry& entry) const {
  return std::all_of(running_.begin(), running_.end(),
                     [&](const QueueEntry* other) { return may_start_beside(*other, entry); });
}

std::vector<QueueEntry*> ObjectQueue::holding_up() const {
  std::vector<QueueEntry*> holding;
  if (actor_.empty()) return holding;
  for (QueueEntry* const running : running_) {
    if (!may_start_beside(*running, *actor_.front())) holding.push_back(running);
  }
  return holding;
}

std::shared_ptr<QueueEntry> ObjectQueue::next() {
  return next([](const QueueEntry&) { return true; });
}

/// Returns the actor command that may start next: the first command or, while the first command
/// must wait, the first @parallel command. Returns the end of the lane if no command may start.
ObjectQueue::Lane::iterator ObjectQueue::next_command() {
  if (actor_.empty() || beside_running(*actor_.front())) return actor_.begin();
  return std::ranges::find_if(actor_, [](const auto& entry) { return entry->operation.parallel; });
}

std::shared_ptr<QueueEntry> ObjectQueue::next(FunctionRef<bool(const QueueEntry&)> wanted) {
  if (threads_ == LaneThreads::One && inside_ != 0) return nullptr;
  const auto safety =
      std::ranges::find_if(safety_, [&](const auto& entry) { return wanted(*entry); });
  if (safety != safety_.end()) return start(safety_, safety);
  if (auto reading = sensor_.take(wanted)) return start(std::move(reading));
  const auto at = next_command();
  return at == actor_.end() || !wanted(**at) ? nullptr : start(actor_, at);
}

std::shared_ptr<QueueEntry> ObjectQueue::start(Lane& lane, Lane::iterator at) {
  auto entry = std::move(*at);
  lane.erase(at);
  return start(std::move(entry));
}

std::shared_ptr<QueueEntry> ObjectQueue::start(std::shared_ptr<QueueEntry> entry) {
  ++inside_;
  if (entry->lane == CallLane::Actor) running_.push_back(entry.get());
  return entry;
}

void ObjectQueue::returned(const QueueEntry& /*entry*/) { --inside_; }

void ObjectQueue::ended(const QueueEntry& entry) {
  running_.erase(std::remove(running_.begin(), running_.end(), &entry), running_.end());
  if (entry.bytes >= small) std::erase(large_, &entry);
}

bool ObjectQueue::remove(const QueueEntry& entry) {
  if (entry.lane == CallLane::Sensor) return sensor_.remove(entry);
  Lane& lane = lane_of(entry);
  const auto at = std::find_if(lane.begin(), lane.end(),
                               [&](const auto& other) { return other.get() == &entry; });
  if (at == lane.end()) return false;
  lane.erase(at);
  return true;
}

std::vector<std::shared_ptr<QueueEntry>> ObjectQueue::drop() {
  std::vector<std::shared_ptr<QueueEntry>> dropped;
  for (const Lane* lane : {&std::as_const(safety_), &sensor_.waiting(), &std::as_const(actor_)}) {
    dropped.insert(dropped.end(), lane->begin(), lane->end());
  }
  safety_.clear();
  sensor_.clear();
  actor_.clear();
  return dropped;
}

std::optional<std::size_t> ObjectQueue::position(const QueueEntry& entry) const {
  const auto at = std::find_if(actor_.begin(), actor_.end(),
                               [&](const auto& other) { return other.get() == &entry; });
  if (at == actor_.end()) return std::nullopt;
  return static_cast<std::size_t>(at - actor_.begin()) + running_.size();
}

}  // namespace gecos::session
