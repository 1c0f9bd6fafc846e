#include "gecos/session/registrar.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/linked_session.hpp"
#include "gecos/session/registry.hpp"
#include "gecos/session/served_object.hpp"
#include "gecos/session/thread.hpp"

namespace gecos::session {
namespace {

constexpr Duration patience = std::chrono::seconds(2);
constexpr Duration between_tries = std::chrono::milliseconds(200);
constexpr Duration between_looks = std::chrono::milliseconds(20);
/// Server and broker are often started together.
constexpr Duration before_told = std::chrono::seconds(1);

}  // namespace

Registrar::Registrar(std::shared_ptr<LabCore> lab) : lab_(std::move(lab)) {
  thread_ = start_thread("gecos-registrar", [this] { run(); });
}

tl::expected<void, std::string> Registrar::await_broker(TimePoint deadline) {
  for (;;) {
    const auto broker = lab_->broker(std::min(deadline, deadline_after(patience)));
    note_broker(broker ? std::string() : broker.error());
    if (broker) return {};
    if (!rest(between_tries, deadline)) return tl::unexpected(broker.error());
  }
}

void Registrar::note_broker(const std::string& missing) {
  const TimePoint now = lab_->runtime()->clock().now();
  const std::lock_guard lock(mutex_);
  if (missing.empty()) {
    missing_since_.reset();
    told_missing_ = false;
    return;
  }
  if (!missing_since_) missing_since_ = now;
  if (told_missing_ || now < *missing_since_ + before_told) return;
  told_missing_ = true;
  log_warning(
      "session",
      missing + "; this server goes on asking, and until then nobody new finds its objects");
}

bool Registrar::rest(Duration length, TimePoint deadline) {
  const Clock& clock = lab_->runtime()->clock();
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, std::min(deadline, clock.now() + length), [this] { return ended_; });
  return !ended_ && clock.now() < deadline;
}

tl::expected<void, std::string> Registrar::add(const ServedObject& object,
                                               std::vector<std::string> addresses) {
  const InterfaceDescription& interface = object.interface();
  const Hello self = lab_->runtime()->introduce(interface);
  Entry entry;
  entry.name = object.name();
  entry.interface_name = interface.name;
  entry.bases.assign(interface.bases.begin(), interface.bases.end());
  entry.interface_hash = interface.hash;
  entry.boot = self.boot;
  entry.pid = self.pid;
  entry.user = self.user;
  entry.host = lab_->runtime()->host_identity();
  entry.hostname = self.host;
  entry.addresses = std::move(addresses);
  entry.simulated = object.options().simulated;

  auto broker = enlist_first(entry, deadline_after(std::max(patience, object.options().patience)));
  if (!broker) return tl::unexpected(entry.name + " is not served: " + broker.error());
  const std::lock_guard lock(mutex_);
  entries_.push_back(std::move(entry));
  broker_ = std::move(*broker);
  return {};
}

/// A broker that goes while it is asked may be back soon, and takes the same entry again. So does
/// one that has not noticed yet that who had the name before has ended: a server that is started
/// again after it was killed may be quicker.
tl::expected<std::shared_ptr<LinkedSession>, std::string> Registrar::enlist_first(
    const Entry& entry, TimePoint deadline) {
  for (;;) {
    auto broker = lab_->broker(deadline);
    if (!broker) return tl::unexpected(broker.error());
    const auto enlisted = enlist(**broker, entry, deadline);
    if (enlisted) return *broker;
    const bool later = enlisted.error().unheard ||
                       (enlisted.error().taken && holder_has_ended(entry.name, deadline));
    if (later && rest(between_looks, deadline)) continue;
    if (!(*broker)->lost()) return tl::unexpected(enlisted.error().text);
    if (auto back = await_broker(deadline); !back) return tl::unexpected(back.error());
  }
}

bool Registrar::holder_has_ended(const std::string& name, TimePoint deadline) const {
  const auto holder = session::look_up(*lab_, name, deadline);
  if (!holder) return true;  // it was dropped meanwhile
  return holder->host == lab_->runtime()->host_identity() && holder->pid > 0 &&
         ::kill(holder->pid, 0) != 0 && errno == ESRCH;
}

void Registrar::look() {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock || !broker_ || !broker_->lost() || wanted_) return;
  wanted_ = true;
  changed_.notify_all();
}

void Registrar::run() {
  std::unique_lock lock(mutex_);
  while (!ended_) {
    changed_.wait(lock, [this] { return wanted_ || ended_; });
    while (!ended_ && wanted_) {
      lock.unlock();
      const bool enlisted = enlist_again();
      lock.lock();
      if (enlisted) {
        wanted_ = false;
      } else {
        changed_.wait_for(lock, between_tries, [this] { return ended_; });
      }
    }
  }
}

bool Registrar::enlist_again() {
  const TimePoint deadline = deadline_after(patience);
  auto broker = lab_->broker(deadline);
  note_broker(broker ? std::string() : broker.error());
  if (!broker) return false;
  std::vector<Entry> entries;
  {
    const std::lock_guard lock(mutex_);
    entries = entries_;
  }
  std::string missing;
  for (const auto& entry : entries) {
    const auto enlisted = enlist(**broker, entry, deadline);
    if (enlisted) continue;  // the others need not wait for one that is not
    missing += (missing.empty() ? "" : "; ") + entry.name +
               " runs on and is not findable: " + enlisted.error().text;
  }
  if (missing != std::exchange(told_, missing) && !missing.empty()) log_warning("session", missing);
  if (!missing.empty()) return false;
  log_info("session", "a new broker knows the objects of this server");
  const std::lock_guard lock(mutex_);
  broker_ = std::move(*broker);
  return true;
}

void Registrar::end() {
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    ended_ = true;
  }
  changed_.notify_all();
  thread_.join();  // it may just have enlisted them with another broker
  std::shared_ptr<LinkedSession> broker;
  std::vector<Entry> entries;
  {
    const std::lock_guard lock(mutex_);
    broker = std::move(broker_);
    entries.swap(entries_);
  }
  for (const auto& entry : entries) {
    if (!broker->lost()) withdraw(*broker, entry.name);
  }
}

}  // namespace gecos::session
