#include "gecos/session/handler_waits.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>

#include "gecos/session/runtime.hpp"
#include "gecos/session/served_object.hpp"
#include "gecos/session/server_call.hpp"

namespace gecos::session {
namespace {

thread_local ServerCall* dispatched_here = nullptr;
thread_local std::weak_ptr<ServerCall> pulled_here;

std::shared_ptr<ServerCall> handler_here() {
  return dispatched_here != nullptr ? dispatched_here->shared_from_this() : pulled_here.lock();
}

struct Sessions {
  std::mutex mutex;
  std::map<SessionId, std::weak_ptr<ServedObject>> objects;
};

Sessions& sessions() {
  static Sessions& known = *new Sessions;  // outlives every server of the process
  return known;
}

using Calls = std::vector<std::shared_ptr<ServerCall>>;

/// What has to come to an end before `call` can.
Calls awaited_by(ServerCall& call) {
  const auto awaited = call.object().awaited_by(call);
  if (!awaited) return call.object().held_up_by(call);
  const auto object = object_in(*awaited);
  auto found = object == nullptr ? nullptr : object->find(*awaited);
  return found == nullptr ? Calls{} : Calls{std::move(found)};
}

/// Whether `way.front()` is among what the last of `way` waits for. Then `way` is the circle.
bool leads_back(Calls& way) {
  for (auto& next : awaited_by(*way.back())) {
    if (next == way.front()) return true;
    if (std::find(way.begin(), way.end(), next) != way.end()) continue;
    way.push_back(std::move(next));
    if (leads_back(way)) return true;
    way.pop_back();
  }
  return false;
}

}  // namespace

RunsHere::RunsHere(ServerCall& call) : before_(std::exchange(dispatched_here, &call)) {}
RunsHere::~RunsHere() { dispatched_here = before_; }

void runs_here(std::weak_ptr<ServerCall> call) { pulled_here = std::move(call); }

WaitsHere::WaitsHere(const CommandCore& command) : handler_(handler_here()) {
  if (handler_ == nullptr) return;
  handler_->object().waits(*handler_, command.id(), command.about());
}

WaitsHere::~WaitsHere() {
  if (handler_ != nullptr) handler_->object().goes_on(*handler_);
}

void note_session(SessionId id, std::weak_ptr<ServedObject> object) {
  const std::lock_guard lock(sessions().mutex);
  sessions().objects.insert_or_assign(id, std::move(object));
}

void forget_session(SessionId id) {
  const std::lock_guard lock(sessions().mutex);
  sessions().objects.erase(id);
}

std::shared_ptr<ServedObject> object_in(const CommandId& call) {
  if (call.boot != number(process_boot())) return nullptr;
  const std::lock_guard lock(sessions().mutex);
  const auto found = sessions().objects.find(SessionId{call.session});
  return found == sessions().objects.end() ? nullptr : found->second.lock();
}

std::string waits_for_itself(const std::shared_ptr<ServerCall>& handler) {
  Calls way{handler};
  if (!leads_back(way)) return {};
  std::erase_if(way, [](const auto& call) { return !call->object().awaited_by(*call); });
  std::string text =
      "the handler of " + handler->title() + " waits for it, and it cannot start before ";
  if (way.size() == 1) return text + "that handler returns";
  for (auto next = way.begin() + 1; next != way.end(); ++next) {
    text +=
        "the handler of " + (*next)->title() + " returns, which waits for what cannot end before ";
  }
  return text + "the first one returns";
}

}  // namespace gecos::session
