#include "gecos/broker/broker.hpp"

#include <signal.h>

#include <algorithm>
#include <cerrno>
#include <fstream>

#include "gecos/base/log.hpp"

namespace gecos::broker {
namespace {

/// Converts a time in seconds that a server reports. Returns zero for a negative number or NaN, and
/// at most a century.
Duration duration_of(double seconds) {
  constexpr double century = 3.2e9;
  if (!(seconds > 0)) return Duration::zero();
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(std::min(seconds, century)));
}

/// Returns the silence of a server after which the broker ends the session with that server.
Duration silence_that_ends_a_session() {
  const LabOptions standard;
  return standard.lease_ttl + standard.grace;
}

bool has_ended(std::int32_t pid) {
  if (::kill(pid, 0) != 0) return errno == ESRCH;
  std::string status;  // e.g. "4711 (name) S …"; state Z: ended, not yet waited for by its parent
  std::getline(std::ifstream("/proc/" + std::to_string(pid) + "/stat"), status);
  const std::size_t name_end = status.rfind(") ");
  return name_end != std::string::npos && status.substr(name_end + 2, 1) == "Z";
}

/// Returns true when the process of `entry` is known to have ended. Returns false for a process on
/// another host, because nothing is known about it. Processes on this host are assumed to be in one
/// PID namespace.
bool is_gone(const Entry& entry) {
  return entry.pid > 0 && media::on_one_machine(entry.host, media::host_identity()) &&
         has_ended(entry.pid);
}

}  // namespace

Serving Broker::serving(std::vector<media::Kind> media) {
  ObjectOptions options;
  options.simulated = true;  // a broker moves nothing, so it cannot cause harm
  options.well_known = true;
  // When no other process can use these media, no object was served before this broker started.
  const bool alone = media::within_process(media);
  {
    const MutexLock lock(mutex_);
    directory_ =
        Directory(SystemClock().since_boot(), alone ? Duration::zero() : Directory::first_second);
  }
  options.media = std::move(media);
  return {"BROKER", *this, std::move(options)};
}

tl::expected<void, ServeError> Broker::serve(Server& server, std::vector<media::Kind> media) {
  Serving broker = serving(std::move(media));
  return server.add(std::move(broker.name), *this, std::move(broker.options));
}

void Broker::gecos_dispatch(IncomingCall call) {
  calling_ = {call.caller().session, call.caller().incarnation};
  BrokerServant::gecos_dispatch(std::move(call));
}

Result<std::optional<double>> Broker::enlist(const Entry& what, double served_for) {
  const MutexLock lock(mutex_);
  const Claim claim{calling_.session, calling_.incarnation, duration_of(served_for)};
  const auto before = directory_.look_up(what.name);
  const auto provisional = directory_.enlist(claim, what, SystemClock().since_boot());
  if (!provisional) return tl::unexpected(Fault(provisional.error()));
  if (!before) {
    log_info("broker", what.name + " was enlisted with the interface " + what.interface_name);
  } else if (*before != what) {
    log_warning("broker", what.name + " moves from pid " + std::to_string(before->pid) + " on " +
                              before->hostname + " to pid " + std::to_string(what.pid) + " on " +
                              what.hostname + ", which has served it for longer");
  }
  if (*provisional == Duration::zero()) return std::nullopt;
  return std::chrono::duration<double>(*provisional).count();
}

Result<void> Broker::withdraw(const std::string& name) {
  const MutexLock lock(mutex_);
  if (auto gone = directory_.withdraw(calling_.session, name); !gone) {
    return tl::unexpected(Fault(gone.error()));
  }
  log_info("broker", name + " was withdrawn");
  return {};
}

Result<Entry> Broker::lookup(const std::string& name) {
  const MutexLock lock(mutex_);
  auto found = directory_.look_up(name);
  if (!found) return tl::unexpected(Fault(found.error()));
  return *std::move(found);
}

Result<std::vector<Entry>> Broker::list() {
  const MutexLock lock(mutex_);
  return directory_.list();
}

Result<std::vector<SilentObject>> Broker::silent() {
  const TimePoint now = SystemClock().since_boot();
  std::vector<Silent> found;
  {
    const MutexLock lock(mutex_);
    found = directory_.silent(now);
  }
  std::erase_if(found, [](const Silent& one) { return is_gone(one.entry); });
  std::vector<SilentObject> objects;
  for (Silent& one : found) {
    const double seconds = std::chrono::duration<double>(now - one.since).count();
    objects.push_back({std::move(one.entry), seconds});
  }
  return objects;
}

void Broker::gecos_session_ended(std::uint64_t session) {
  // The session may also end earlier, because the kernel reports the death of the server's process.
  // Then this time is too early, but it is not used: `silent` leaves out dead processes.
  const TimePoint heard = SystemClock().since_boot() - silence_that_ends_a_session();
  const MutexLock lock(mutex_);
  for (const auto& name : directory_.end_session(session, heard)) {
    log_info("broker", name + " was removed: its server is gone or silent");
  }
}

}  // namespace gecos::broker
