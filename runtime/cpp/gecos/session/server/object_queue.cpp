#include "gecos/session/server/object_queue.hpp"

#include <algorithm>

namespace gecos::session {
namespace {

/// The commands before it end when it is queued, so their room is its own.
bool replaces(const Ticket& ticket) { return ticket.operation.on_new == OnNew::Preempt; }

bool beside_each_other(const Ticket& one, const Ticket& other) {
  const bool both_blend =
      one.operation.on_new == OnNew::Blend && other.operation.on_new == OnNew::Blend;
  return one.operation.parallel || other.operation.parallel || both_blend;
}

}  // namespace

tl::expected<void, ObjectQueue::Full> ObjectQueue::push(std::shared_ptr<Ticket> ticket) {
  const std::size_t commands = replaces(*ticket) ? 0 : actor_.size();
  const std::size_t waiting = safety_.size() + sensor_.size() + commands;
  if (waiting != 0 && !ticket->operation.safety) {
    if (waiting >= most_of_object) return tl::unexpected(Full::Object);
    std::ptrdiff_t of_client = 0;
    for (const Lane* lane : {&sensor_, &actor_}) {
      if (lane == &actor_ && commands == 0) continue;
      of_client += std::count_if(lane->begin(), lane->end(), [&](const auto& other) {
        return other->client == ticket->client;
      });
    }
    if (of_client >= static_cast<std::ptrdiff_t>(most_of_client)) {
      return tl::unexpected(Full::Client);
    }
  }
  if (ticket->bytes >= small) {
    if (const auto full = too_large(*ticket)) return tl::unexpected(*full);
    large_.push_back(ticket.get());
  }
  if (ticket->operation.safety) {
    ticket->lane = CallLane::Safety;
  } else if (ticket->operation.status == access::Status::Sensor && !keeps_place(*ticket)) {
    ticket->lane = CallLane::Sensor;
  } else {
    ticket->lane = CallLane::Actor;
  }
  lane_of(*ticket).push_back(std::move(ticket));
  return {};
}

std::optional<ObjectQueue::Full> ObjectQueue::too_large(const Ticket& ticket) const {
  std::size_t of_object = 0;
  std::size_t of_client = 0;
  for (const Ticket* const other : large_) {
    if (replaces(ticket) && other->lane == CallLane::Actor) continue;
    of_object += other->bytes;
    if (other->client == ticket.client) of_client += other->bytes;
  }
  if (of_client != 0 && of_client + ticket.bytes > most_bytes_of_client) return Full::BytesOfClient;
  if (of_object != 0 && of_object + ticket.bytes > most_bytes_of_object) return Full::BytesOfObject;
  return std::nullopt;
}

/// An @ordered reading queues behind the commands of its own caller.
bool ObjectQueue::keeps_place(const Ticket& ticket) const {
  if (!ticket.operation.ordered) return false;
  const auto same_client = [&](const auto& other) { return other->client == ticket.client; };
  return std::any_of(actor_.begin(), actor_.end(), same_client) ||
         std::any_of(running_.begin(), running_.end(), same_client);
}

bool ObjectQueue::idle() const {
  return actor_.empty() && sensor_.empty() && safety_.empty() && running_.empty() && inside_ == 0;
}

ObjectQueue::Lane& ObjectQueue::lane_of(const Ticket& ticket) {
  switch (ticket.lane) {
    case CallLane::Safety:
      return safety_;
    case CallLane::Sensor:
      return sensor_;
    default:
      return actor_;
  }
}

bool ObjectQueue::beside_running(const Ticket& ticket) const {
  return std::all_of(running_.begin(), running_.end(),
                     [&](const Ticket* other) { return beside_each_other(*other, ticket); });
}

std::vector<Ticket*> ObjectQueue::holding_up() const {
  std::vector<Ticket*> holding;
  if (actor_.empty()) return holding;
  for (Ticket* const running : running_) {
    if (!beside_each_other(*running, *actor_.front())) holding.push_back(running);
  }
  return holding;
}

std::shared_ptr<Ticket> ObjectQueue::next() {
  if (threads_ == LaneThreads::One && inside_ != 0) return nullptr;
  Lane* lane = !safety_.empty() ? &safety_ : !sensor_.empty() ? &sensor_ : nullptr;
  if (lane == nullptr && !actor_.empty() && beside_running(*actor_.front())) lane = &actor_;
  return lane == nullptr ? nullptr : start(*lane, lane->begin());
}

std::shared_ptr<Ticket> ObjectQueue::next(FunctionRef<bool(const Ticket&)> wanted) {
  if (threads_ == LaneThreads::One && inside_ != 0) return nullptr;
  for (Lane* const lane : {&safety_, &sensor_}) {
    const auto at =
        std::ranges::find_if(*lane, [&](const auto& ticket) { return wanted(*ticket); });
    if (at != lane->end()) return start(*lane, at);
  }
  if (actor_.empty() || !wanted(*actor_.front()) || !beside_running(*actor_.front())) {
    return nullptr;
  }
  return start(actor_, actor_.begin());
}

std::shared_ptr<Ticket> ObjectQueue::start(Lane& lane, Lane::iterator at) {
  auto ticket = std::move(*at);
  lane.erase(at);
  ticket->started = true;
  ++inside_;
  if (ticket->lane == CallLane::Actor) running_.push_back(ticket.get());
  return ticket;
}

void ObjectQueue::returned(const Ticket& /*ticket*/) { --inside_; }

void ObjectQueue::ended(const Ticket& ticket) {
  running_.erase(std::remove(running_.begin(), running_.end(), &ticket), running_.end());
  if (ticket.bytes >= small) std::erase(large_, &ticket);
}

bool ObjectQueue::remove(const Ticket& ticket) {
  if (ticket.started) return false;
  Lane& lane = lane_of(ticket);
  const auto at = std::find_if(lane.begin(), lane.end(),
                               [&](const auto& other) { return other.get() == &ticket; });
  if (at == lane.end()) return false;
  lane.erase(at);
  return true;
}

std::vector<std::shared_ptr<Ticket>> ObjectQueue::drop() {
  std::vector<std::shared_ptr<Ticket>> dropped;
  for (Lane* lane : {&safety_, &sensor_, &actor_}) {
    dropped.insert(dropped.end(), lane->begin(), lane->end());
    lane->clear();
  }
  return dropped;
}

std::optional<std::size_t> ObjectQueue::position(const Ticket& ticket) const {
  const auto at = std::find_if(actor_.begin(), actor_.end(),
                               [&](const auto& other) { return other.get() == &ticket; });
  if (at == actor_.end()) return std::nullopt;
  return static_cast<std::size_t>(at - actor_.begin()) + running_.size();
}

}  // namespace gecos::session
