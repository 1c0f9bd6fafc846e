#include "gecos/session/server/zone_watch.hpp"

#include <algorithm>
#include <utility>

#include "gecos/base/thread.hpp"
#include "gecos/presence_calls.hpp"      // generated from idl/gecos/presence.gidl
#include "gecos/presence_interface.hpp"  // generated from idl/gecos/presence.gidl
#include "gecos/session/client/context.hpp"
#include "gecos/session/server/object_host.hpp"

namespace gecos::session {
namespace {

/// Maximum time of one attempt to reach the zone. The destructor may have to wait for such an
/// attempt.
constexpr Duration zone_patience = std::chrono::milliseconds(500);
constexpr Duration between_zone_tries = std::chrono::milliseconds(100);

}  // namespace

ZoneWatch::ZoneWatch(std::shared_ptr<Runtime> runtime, std::string zone)
    : zone_(std::move(zone)), lab_(std::make_shared<Context>(std::move(runtime))) {
  thread_ = start_thread("gecos-zone", [this] { run(); });
}

ZoneWatch::~ZoneWatch() {
  {
    const MutexLock lock(mutex_);
    ended_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void ZoneWatch::add(const std::shared_ptr<ObjectHost>& object) {
  const MutexLock lock(mutex_);
  objects_.push_back(object);
  changed_.notify_all();
}

void ZoneWatch::remove(const ObjectHost& object) {
  const MutexLock lock(mutex_);
  std::erase_if(objects_, [&](const auto& each) { return each.lock().get() == &object; });
}

void ZoneWatch::run() {
  do {
    if (!await_object()) return;
    const auto made =
        create(lab_, ZoneInterface::description, {zone_}, {.patience = zone_patience});
    if (!made) {
      tell_unknown("the zone cannot be reached (" + made.error().to_string() + ")");
      continue;
    }
    const auto presence = made->session->subscribe(ZoneInterface::presence_stream);
    if (!presence) {
      tell_unknown("the zone does not report (" + presence.error().text + ")");
      continue;
    }
    follow(**presence);
  } while (rest());
}

void ZoneWatch::follow(StreamCore& presence) {
  RawSample sample;
  while (watches()) {
    if (const auto got = presence.next(sample, deadline_after(between_zone_tries)); !got) {
      if (got.error() != StreamEnd::Lost && !presence.lost()) continue;
      return tell_unknown("the session with the zone's server ended; start that server again");
    }
    const auto report = layout::from_bytes<Zone_presence_result>(sample.bytes);
    if (!report) {
      tell_unknown("the report of the zone does not decode; update the zone's server");
      continue;
    }
    const ZonePresence& reported = report->result;
    each([&](ObjectHost& object) {
      object.presence().take(zone_, {reported.present, reported.spell, reported.why},
                             sample.measured);
    });
  }
}

void ZoneWatch::tell_unknown(const std::string& why) {
  each([&](ObjectHost& object) { object.presence().forget(zone_, why); });
}

template <class Tell>
void ZoneWatch::each(Tell tell) {
  std::vector<std::shared_ptr<ObjectHost>> alive;
  {
    const MutexLock lock(mutex_);
    for (const auto& object : objects_) {
      if (auto one = object.lock()) alive.push_back(std::move(one));
    }
  }
  for (const auto& object : alive) tell(*object);
}

bool ZoneWatch::watches() {
  const MutexLock lock(mutex_);
  return !ended_ && !objects_.empty();
}

bool ZoneWatch::await_object() {
  MutexLock lock(mutex_);
  while (!ended_ && objects_.empty()) changed_.wait(lock);
  return !ended_;
}

bool ZoneWatch::rest() {
  const TimePoint until = deadline_after(between_zone_tries);
  MutexLock lock(mutex_);
  while (!ended_ && changed_.wait_until(lock, until)) {
  }
  return !ended_;
}

void ZoneWatches::add(const std::string& zone, const std::shared_ptr<ObjectHost>& object) {
  auto found =
      std::ranges::find_if(watches_, [&](const auto& watch) { return watch->zone() == zone; });
  if (found == watches_.end()) {
    found = watches_.insert(found, std::make_unique<ZoneWatch>(runtime_, zone));
  }
  (*found)->add(object);
  for (const auto& watch : watches_) {
    if (watch != *found) watch->remove(*object);
  }
}

}  // namespace gecos::session
