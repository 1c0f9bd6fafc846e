#include "gecos/server.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <ostream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "gecos/audit/audit.hpp"
#include "gecos/audit/folder.hpp"
#include "gecos/base/descriptors.hpp"
#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/binding.hpp"
#include "gecos/session/client/context.hpp"
#include "gecos/session/process/termination_signals.hpp"
#include "gecos/session/server/access_control.hpp"
#include "gecos/session/server/connection_audit.hpp"
#include "gecos/session/server/io_loop.hpp"
#include "gecos/session/server/object_host.hpp"
#include "gecos/session/server/registrar.hpp"
#include "gecos/session/server/zone_watch.hpp"
#include "gecos/wire/text.hpp"

namespace gecos {

using session::Context;
using session::ObjectHost;

namespace {

/// Number of descriptors that must be left to accept a client. LCM opens this many to send to one
/// client.
constexpr std::size_t descriptors_of_a_client = 16;
/// Time between two checks of the lab file.
constexpr Duration between_looks = std::chrono::seconds(1);

bool within_process(const std::shared_ptr<media::Acceptor>& acceptor) {
  return acceptor->capabilities().reach == media::Reach::Process;
}

tl::unexpected<ServeError> served_already(const std::string& name, const Servant& servant) {
  return tl::unexpected(ServeError{name + ": this servant is served already, as " +
                                   servant.gecos_served_as() +
                                   ", and can publish under one name only; create a servant for "
                                   "each name"});
}

/// Throws std::invalid_argument if one of `names` is not a valid name of a user or of a host.
void check_names(const std::vector<std::string>& names, const std::string& what) {
  for (std::size_t at = 0; at < names.size(); ++at) {
    const auto fault =
        wire::valid_utf8(names[at]) ? access::fault_of_name(names[at]) : "is not UTF-8";
    if (fault.empty()) continue;
    throw std::invalid_argument("Server::allow: name " + std::to_string(at + 1) + " of the " +
                                what + " " + std::string(fault) +
                                "; write the name as the computer itself writes it");
  }
}

/// Makes `object` follow the rule of the lab file about open streams. Logs each change once.
void judge_open_streams(ObjectHost& object, const access::LabAccess& lab) {
  const std::string& forbidden_by = lab.forbids_open_streams;
  if (!object.streams().allow_in_clear(forbidden_by.empty())) return;
  if (forbidden_by.empty()) {
    log_warning("session", "the lab file allows open streams again: " + object.name() +
                               " may send their samples in clear over lcm");
  } else {
    log_warning("session", forbidden_by + " forbids open streams: " + object.name() +
                               " sends no sample in clear; clients read its streams as before");
  }
}

}  // namespace

class Server::Core {
 public:
  using Made = tl::expected<std::unique_ptr<Core>, std::string>;
  static Made make(const session::LabOrWhyNot& lab, Admission admission);
  Core(std::shared_ptr<Context> lab, Admission admission)
      : lab_(std::move(lab)),
        admission_(admission),
        contact_(std::make_shared<session::BrokerContact>(lab_->runtime()->clock())),
        access_(std::make_shared<session::AccessControl>(lab_->runtime()->options().lab_file,
                                                         admission, contact_)),
        audit_(std::make_shared<audit::Audit>(audit::Journal(audit::default_folder()))),
        connections_(std::make_shared<session::ConnectionAudit>(audit_)),
        io_(lab_->runtime(), access_),
        registrar_(lab_, contact_, access_),
        zones_(lab_->runtime()),
        upkeep_(std::make_shared<Upkeep>(*this)) {
    session::TerminationSignals::prepare();
    lab_->runtime()->maintenance().add(upkeep_);
  }
  ~Core();

  tl::expected<void, ServeError> await_broker(Duration patience);
  tl::expected<void, ServeError> add(std::string name, Servant& servant, ObjectOptions options);
  void allow(std::vector<std::string> users, std::vector<std::string> hosts);
  void run();
  void shut_down();
  /// Returns true in a forked child. The server's threads do not exist there, so the child cannot
  /// end the server.
  bool inherited() const { return getpid() != owner_; }

 private:
  /// The maintenance thread calls `on_tick` of this object. The pointer to the server is set to
  /// null before the parts of the server are destroyed.
  struct Upkeep final : session::TickTarget {
    explicit Upkeep(Core& its_core) : core(&its_core) {}
    session::NextTick on_tick(TimePoint now) override;
    void after_pause(Duration stood_still) override;
    void watch(std::vector<pollfd>& into) override;
    Mutex mutex;
    Core* core GECOS_GUARDED_BY(mutex);  ///< null once the destruction of the server has begun
  };

  struct Opened {
    std::vector<std::shared_ptr<media::Acceptor>> acceptors;
    std::vector<std::string> addresses;
  };
  tl::expected<Opened, ServeError> open_places(const std::string& name,
                                               const ObjectOptions& options);
  session::UserRights rights() const;
  /// Prints a warning to stderr, and records in the audit, that every user of every host may
  /// connect to an object.
  void announce_insecure(const std::string& name) const;
  /// Applies an edit of the lab file: moves objects to the zones in which the file now places them,
  /// applies the rule of the file about open streams, and tells the broker which users the objects
  /// now admit. An object leaves all zones only when it is served anew.
  void follow_lab_file(TimePoint now) GECOS_REQUIRES(mutex_);

  const pid_t owner_ = getpid();
  const std::shared_ptr<Context> lab_;
  const Admission admission_;
  const std::shared_ptr<session::BrokerContact> contact_;
  const std::shared_ptr<session::AccessControl> access_;  ///< shared with the acceptors
  const std::shared_ptr<audit::Audit> audit_;
  const std::shared_ptr<session::ConnectionAudit> connections_;  ///< shared with the acceptors
  Mutex mutex_;
  std::vector<std::shared_ptr<ObjectHost>> objects_ GECOS_GUARDED_BY(mutex_);
  EventFd ended_;
  session::IoLoop io_;
  session::Registrar registrar_;
  session::ZoneWatches zones_ GECOS_GUARDED_BY(mutex_);
  /// The time of the next reading of the lab file.
  TimePoint next_look_ GECOS_GUARDED_BY(mutex_){};
  /// The lists of the lab file that `follow_lab_file` applied most recently.
  std::shared_ptr<const access::LabAccess> followed_ GECOS_GUARDED_BY(mutex_);
  std::shared_ptr<Upkeep> upkeep_;
};

Server::Core::Made Server::Core::make(const session::LabOrWhyNot& lab, Admission admission) {
  if (!lab) return tl::unexpected(lab.error().text);
  try {
    return std::make_unique<Core>(*lab, admission);
  } catch (const std::system_error& failed) {
    return tl::unexpected(session::nothing_left("a Server", failed));
  }
}

session::NextTick Server::Core::Upkeep::on_tick(TimePoint now) {
  const MutexLock lock(mutex);
  if (core == nullptr) return TimePoint::max();
  TimePoint next = core->io_.on_tick(now);
  core->registrar_.look();
  core->connections_->on_tick();
  const MutexLock objects(core->mutex_);
  core->follow_lab_file(now);
  for (const auto& object : core->objects_) next = std::min(next, object->on_tick(now));
  return next;
}

void Server::Core::Upkeep::watch(std::vector<pollfd>& into) {
  const MutexLock lock(mutex);
  if (core != nullptr) into.push_back({core->io_.descriptor(), POLLIN, 0});
}

void Server::Core::Upkeep::after_pause(Duration stood_still) {
  const MutexLock lock(mutex);
  if (core == nullptr) return;
  core->io_.await_signs_of_life();
  const MutexLock objects(core->mutex_);
  for (const auto& object : core->objects_) object->after_pause(stood_still);
  core->registrar_.after_pause(stood_still);
}

void Server::Core::follow_lab_file(TimePoint now) {
  if (now >= next_look_) {
    next_look_ = now + between_looks;
    access_->reread();
  }
  const auto lists = access_->lists();
  if (lists == followed_) return;
  try {
    for (const auto& object : objects_) judge_open_streams(*object, *lists);
    registrar_.renew_lists();
    for (const auto& object : objects_) {
      const std::string zone = access_->zone_of(object->name());
      if (zone.empty() || zone == object->presence().zone()) continue;
      log_warning("session", "the lab file places " + object->name() + " in zone " + zone);
      zones_.add(zone, object);
      object->presence().enter(zone);
    }
    followed_ = lists;
  } catch (const std::exception& failed) {  // the next reading tries again
    log_error("session", std::string("an edit of the lab file was not applied: ") + failed.what());
  }
}

Server::Core::~Core() {
  registrar_.end();
  {
    // The lock order is the same as in the maintenance thread: `upkeep_->mutex` before `mutex_`.
    const MutexLock lock(upkeep_->mutex);
    upkeep_->core = nullptr;
  }
  const MutexLock objects(mutex_);
  zones_.end();
  for (const auto& object : objects_) object->close();
  for (const auto& object : objects_) object->join();
  io_.end();
  for (const auto& object : objects_) object->streams().close();
  connections_->end();
  audit_->end();  // a connection that is being closed, or a call, may still own the audit
}

session::UserRights Server::Core::rights() const {
  return {admission_ == Admission::Insecure,
          [access = access_](const media::Peer& peer) { return access->administers(peer); },
          [access = access_](const media::Peer& peer) { return access->other_user(peer); },
          [access = access_](const std::string& object, const media::Peer& peer) {
            return access->visitor(object, peer);
          },
          [access = access_, recorded = connections_](const std::string& object,
                                                      const media::Peer& peer) {
            const auto judgement = access->judge_registration(object, peer);
            return judgement.admitted ? std::string()
                                      : recorded->refused("name_refused", object, judgement);
          },
          [access = access_](const std::string& zone, const std::string& source,
                             const media::Peer& peer) {
            auto judgement = access->judge_report(zone, source, peer);
            return judgement.admitted ? std::string() : std::move(judgement.text);
          }};
}

/// Writes to stderr and not to the log, because GECOS_LOG must not hide this warning.
void Server::Core::announce_insecure(const std::string& name) const {
  const std::string line(72, '*');
  std::fprintf(stderr,
               "%s\n* --insecure: %s admits every user of every host.\n"
               "* No [allow] of a lab file counts. Never do this where hardware moves.\n%s\n",
               line.c_str(), name.c_str(), line.c_str());
  audit_->add({.event = "insecure",
               .time = audit::now(),
               .object = name,
               .why = "the server was started with --insecure"});
}

tl::expected<Server::Core::Opened, ServeError> Server::Core::open_places(
    const std::string& name, const ObjectOptions& options) {
  std::span<const media::Kind> kinds = options.media;
  if (kinds.empty()) kinds = media::all_kinds();
  Opened opened;
  std::string failed;
  for (const media::Kind kind : kinds) {
    bool needed = !options.media.empty();
    auto acceptor = [&]() -> tl::expected<std::unique_ptr<media::Acceptor>, media::MediumError> {
      const auto medium = lab_->runtime()->medium(kind);
      if (!medium) return tl::unexpected(medium.error());
      // A host has only one well-known address for each medium. If no other host can reach the
      // medium, an object with the option `well_known` must be served at that address. Over a
      // network, another host may have the address, or there may be no network. The object is then
      // served over the other media.
      needed = needed ||
               (options.well_known && (*medium)->capabilities().reach != media::Reach::Network);
      try {
        return (*medium)->listen(name, options.well_known);
      } catch (const std::system_error& error) {  // no descriptors are left
        return tl::unexpected(media::MediumError{error.what()});
      }
    }();
    if (acceptor) {
      (*acceptor)->admit_by(
          [access = access_, recorded = connections_, name](const media::Peer& peer) {
            return recorded->judged(name, access->judge(name, peer));
          });
      opened.addresses.push_back((*acceptor)->address());
      opened.acceptors.push_back(std::move(*acceptor));
      continue;
    }
    const std::string why = name + " is not served over " + std::string(media::to_string(kind)) +
                            ": " + acceptor.error().text;
    if (needed) return tl::unexpected(ServeError{why});
    log_warning("session", why);
    failed += (failed.empty() ? "" : "; ") + why;
  }
  if (media::within_process(options.media)) return opened;
  if (std::ranges::all_of(opened.acceptors, within_process))
    return tl::unexpected(ServeError{failed});
  if (!descriptors_left(descriptors_of_a_client)) {
    return tl::unexpected(ServeError{
        name + " is not served: this process has no descriptors left to accept a client: " +
        system_text(errno)});
  }
  return opened;
}

tl::expected<void, ServeError> Server::Core::await_broker(Duration patience) {
  return registrar_.await_broker(deadline_after(patience)).map_error([](const std::string& why) {
    return ServeError{why};
  });
}

tl::expected<void, ServeError> Server::Core::add(std::string name, Servant& servant,
                                                 ObjectOptions options) {
  if (name.empty() || name.find('\0') != std::string::npos) {
    return tl::unexpected(
        ServeError{"no object can be served under the name '" + name.substr(0, name.find('\0')) +
                   "': a name must have at least one character and must not contain NUL"});
  }
  if (!servant.gecos_served_as().empty()) return served_already(name, servant);
  if (admission_ == Admission::Insecure && !options.simulated) {
    return tl::unexpected(ServeError{
        name + " is not served: --insecure admits every user of every host, and " + name +
        " does not declare itself simulated; leave --insecure out and name the users in a lab "
        "file, or declare the object simulated if it moves no hardware"});
  }
  if (const auto read = access_->read(); !read) {
    return tl::unexpected(ServeError{name + " is not served: " + read.error()});
  }
  const bool well_known = options.well_known;
  if (options.visitors) access_->receive(options.visitors);
  if (!well_known) {
    if (const auto found = await_broker(options.patience); !found) {
      return tl::unexpected(ServeError{name + " is not served: " + found.error().text});
    }
  }
  auto opened = open_places(name, options);
  if (!opened) return tl::unexpected(opened.error());
  const std::string zone = access_->zone_of(name);
  auto object = std::make_shared<ObjectHost>(lab_->runtime(), name, servant, std::move(options),
                                             audit_, rights(), zone);
  if (admission_ == Admission::Insecure) announce_insecure(name);
  judge_open_streams(*object, *access_->lists());
  // Another thread may have added the servant in the meantime.
  if (!servant.gecos_attach(object)) return served_already(name, servant);
  for (auto& acceptor : opened->acceptors) io_.serve(object, std::move(acceptor));
  {
    const MutexLock lock(mutex_);
    objects_.push_back(object);
    // If the lab file was edited meanwhile, follow_lab_file() did not know this object. Therefore
    // the rule about open streams is applied to the object again.
    judge_open_streams(*object, *access_->lists());
    if (!zone.empty()) zones_.add(zone, object);
  }
  if (well_known) return {};
  if (auto enlisted = registrar_.add(object, std::move(opened->addresses)); !enlisted) {
    {
      const MutexLock lock(mutex_);
      objects_.erase(std::find(objects_.begin(), objects_.end(), object));
    }
    object->close();
    io_.withdraw(*object);
    object->join();
    object->streams().close();
    return tl::unexpected(ServeError{enlisted.error()});
  }
  return {};
}

void Server::Core::allow(std::vector<std::string> users, std::vector<std::string> hosts) {
  access_->allow(std::move(users), std::move(hosts));
  registrar_.renew_lists();
}

void Server::Core::run() {
  const session::TerminationSignals asked;
  const int descriptors[] = {asked.descriptor(), ended_.descriptor()};
  while (media::sleep_on(descriptors, TimePoint::max()) == media::Wake::Interrupted) {
  }
}

void Server::Core::shut_down() { ended_.notify(); }

std::ostream& operator<<(std::ostream& out, const ServeError& error) { return out << error.text; }

Server::Server(Lab& lab, Admission admission)
    : core_(Core::make(session::LabAccess::context(lab), admission)) {}
Server::~Server() {
  // In a forked child the core is leaked, because the core belongs to the parent process.
  if (core_ && (*core_)->inherited()) static_cast<void>(core_->release());
}

tl::expected<void, ServeError> Server::await_broker(Duration patience) {
  if (!core_) return tl::unexpected(ServeError{core_.error()});
  return (*core_)->await_broker(patience);
}
tl::expected<void, ServeError> Server::add(std::string name, Servant& servant,
                                           ObjectOptions options) {
  if (!core_) return tl::unexpected(ServeError{name + " is not served: " + core_.error()});
  return (*core_)->add(std::move(name), servant, std::move(options));
}
void Server::allow(std::vector<std::string> users, std::vector<std::string> hosts) {
  if (std::max(users.size(), hosts.size()) > access::most_admitted_names) {
    throw std::invalid_argument(
        "Server::allow takes at most 256 users and 256 hosts: name the others in a lab file, or "
        "admit every name by \"*\"");
  }
  check_names(users, "users");
  check_names(hosts, "hosts");
  if (core_) (*core_)->allow(std::move(users), std::move(hosts));
}
void Server::run() {
  if (core_) return (*core_)->run();
  log_error("session", core_.error());
}
void Server::shut_down() {
  if (core_) (*core_)->shut_down();
}

}  // namespace gecos
