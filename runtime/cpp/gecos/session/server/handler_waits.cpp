#include "gecos/session/server/handler_waits.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/per_process.hpp"
#include "gecos/session/process/runtime.hpp"
#include "gecos/session/server/object_host.hpp"
#include "gecos/session/server/server_call.hpp"

namespace gecos::session {
namespace {

struct Sessions {
  Mutex mutex;
  std::map<SessionId, std::weak_ptr<ObjectHost>> objects GECOS_GUARDED_BY(mutex);
};

Sessions& sessions() {
  static constinit PerProcess<Sessions> known;
  return known.get();
}

using Calls = std::vector<std::shared_ptr<ServerCall>>;

/// Returns the calls that must end before `call` can end.
Calls awaited_by(ServerCall& call) {
  const auto awaited = call.object().waits().awaited_by(call);
  if (!awaited) return call.object().waits().held_up_by(call);
  const auto object = object_in(*awaited);
  auto found = object == nullptr ? nullptr : object->waits().find(*awaited);
  return found == nullptr ? Calls{} : Calls{std::move(found)};
}

/// `way` is a list of calls, each of which waits for the next one. Returns whether the last call of
/// `way` waits, directly or through other calls, for the first call. If it does, extends `way` to
/// the whole cycle.
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

void note_session(SessionId id, std::weak_ptr<ObjectHost> object) {
  Sessions& known = sessions();
  const MutexLock lock(known.mutex);
  known.objects.insert_or_assign(id, std::move(object));
}

void forget_session(SessionId id) {
  Sessions& known = sessions();
  const MutexLock lock(known.mutex);
  known.objects.erase(id);
}

std::shared_ptr<ObjectHost> object_in(const CommandId& call) {
  if (call.incarnation != number(process_incarnation())) return nullptr;
  Sessions& known = sessions();
  const MutexLock lock(known.mutex);
  const auto found = known.objects.find(SessionId{call.session});
  return found == known.objects.end() ? nullptr : found->second.lock();
}

std::string waits_for_itself(const std::shared_ptr<ServerCall>& handler) {
  Calls way{handler};
  if (!leads_back(way)) return {};
  std::erase_if(way, [](const auto& call) { return !call->object().waits().awaited_by(*call); });
  std::string text = "the handler of " + handler->title() +
                     " waits for this call, and this call cannot start before ";
  if (way.size() == 1) return text + "that handler returns";
  for (auto next = way.begin() + 1; next != way.end(); ++next) {
    text += "the handler of " + (*next)->title() +
            " returns; that handler waits for a call that cannot end before ";
  }
  return text + "the first handler returns";
}

void HandlerWaits::waits(ServerCall& call, const CommandId& awaited, std::string name) {
  const MutexLock lock(object_.mutex);
  object_.calls.handlers().waits(call, awaited, std::move(name), object_.setup.clock().now());
}

void HandlerWaits::goes_on(ServerCall& call) {
  const MutexLock lock(object_.mutex);
  object_.calls.handlers().goes_on(call);
}

std::optional<CommandId> HandlerWaits::awaited_by(const ServerCall& call) {
  const MutexLock lock(object_.mutex);
  return call.waits_for ? std::optional(call.waits_for->command) : std::nullopt;
}

std::shared_ptr<ServerCall> HandlerWaits::find(const CommandId& call) {
  const MutexLock lock(object_.mutex);
  const auto session = object_.calls.outcomes().open(SessionId{call.session});
  const auto* const found = session == nullptr ? nullptr : session->calls.find(call.counter);
  return found == nullptr ? nullptr : *found;
}

std::vector<std::shared_ptr<ServerCall>> HandlerWaits::held_up_by(const ServerCall& call) {
  const MutexLock lock(object_.mutex);
  return object_.calls.held_up_by(call);
}

/// Handlers that wait for each other in a cycle without a time-out never return. Waits that began
/// less than `certain_after` ago are not checked, because the awaited call may be about to end.
void HandlerWaits::end_endless(TimePoint now) {
  constexpr Duration certain_after = std::chrono::milliseconds(200);
  Calls waiting;
  {
    const MutexLock lock(object_.mutex);
    waiting = object_.calls.handlers().waiting_since(now - certain_after);
  }
  for (const auto& handler : waiting) {
    const auto awaited = awaited_by(*handler);
    const auto object = awaited ? object_in(*awaited) : nullptr;
    if (object == nullptr) continue;
    if (const auto why = waits_for_itself(handler); !why.empty()) {
      object->waits().refuse(*awaited, why);
    }
  }
}

void HandlerWaits::refuse(const CommandId& id, const std::string& why) {
  const auto call = find(id);
  if (call == nullptr) return;
  const MutexLock lock(object_.mutex);
  if (call->state.ended() || call->state.begun_at()) return;
  const std::string text = call->title() + " was not started: " + why +
                           "; call the method of the servant directly, or wait in another thread";
  log_warning("server", text);
  // If the servant has put the call into a queue, IncomingCall::begin() later tells the servant to
  // drop the call.
  object_.calls.end(*call, Failure{Detail::Rejected, text, {}, {}});
  object_.calls.note_ready();
}

}  // namespace gecos::session
