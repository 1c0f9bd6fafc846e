#include "gecos/session/lab_core.hpp"

#include <pwd.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>

#include "gecos/media/open.hpp"
#include "gecos/session/linked_session.hpp"
#include "gecos/session/registry.hpp"

namespace gecos::session {
namespace {

std::string user_name() {
  passwd entry{};
  passwd* found = nullptr;
  char text[4096];
  if (getpwuid_r(getuid(), &entry, text, sizeof text, &found) != 0 || found == nullptr) {
    return "uid " + std::to_string(getuid());
  }
  return entry.pw_name;
}

std::string host_name() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "?";
}

/// Every lab of this process that has sessions, so that they part in order when it exits.
class OpenLabs {
 public:
  static OpenLabs& instance() {
    static OpenLabs labs;
    return labs;
  }
  ~OpenLabs() {
    for (const auto& lab : take()) lab->close_sessions(std::chrono::seconds(1));
  }
  void add(const std::shared_ptr<LabCore>& lab) {
    const std::lock_guard lock(mutex_);
    labs_.erase(std::remove_if(labs_.begin(), labs_.end(),
                               [](const auto& known) { return known.expired(); }),
                labs_.end());
    labs_.push_back(lab);
  }

 private:
  std::vector<std::shared_ptr<LabCore>> take() {
    const std::lock_guard lock(mutex_);
    std::vector<std::shared_ptr<LabCore>> alive;
    for (const auto& known : labs_) {
      if (auto lab = known.lock()) alive.push_back(std::move(lab));
    }
    return alive;
  }

  std::mutex mutex_;
  std::vector<std::weak_ptr<LabCore>> labs_;
};

}  // namespace

BootId process_boot() {
  static const BootId boot = [] {
    std::uint64_t number = 0;
    while (number == 0) {
      if (getrandom(&number, sizeof number, 0) != sizeof number) number = 0;
    }
    return BootId{number};
  }();
  return boot;
}

LabCore::LabCore(LabOptions options, const Clock& clock)
    : options_(std::move(options)), clock_(clock), housekeeping_(clock) {}

LabCore::~LabCore() = default;

std::shared_ptr<LabCore> make_lab_core(LabOptions options, const Clock& clock) {
  OpenLabs& labs = OpenLabs::instance();
  auto core = std::make_shared<LabCore>(std::move(options), clock);
  labs.add(core);
  return core;
}

tl::expected<media::Medium*, media::MediumError> LabCore::medium(media::Kind kind) {
  const std::lock_guard lock(mutex_);
  auto found = media_.find(kind);
  if (found == media_.end()) found = media_.emplace(kind, media::open(kind)).first;
  if (!found->second) return tl::unexpected(found->second.error());
  return found->second->get();
}

const std::string& LabCore::host_identity() {
  static const std::string identity = media::host_identity();
  return identity;
}

Hello LabCore::introduce(const InterfaceDescription& wanted) const {
  Hello hello;
  hello.user = user_name();
  hello.host = host_name();
  hello.program = program_invocation_short_name;
  hello.pid = getpid();
  hello.boot = number(process_boot());
  hello.interface_name = wanted.name;
  hello.interface_hash = wanted.hash;
  return hello;
}

tl::expected<std::shared_ptr<LinkedSession>, std::string> LabCore::connect(
    const std::string& address, const InterfaceDescription& wanted, TimePoint deadline,
    Detail* why) {
  if (why != nullptr) *why = Detail::NoServer;
  const auto kind = media::kind_from(std::string_view(address).substr(0, address.find(':')));
  if (!kind) {
    return tl::unexpected("'" + address + "' is no address: it begins with none of inproc:, shm:, lcm:");
  }
  const auto opened = medium(*kind);
  if (!opened) return tl::unexpected(opened.error().text);
  auto link = (*opened)->connect(address);
  if (!link) return tl::unexpected(link.error().text);
  auto session =
      LinkedSession::open(shared_from_this(), std::move(*link), introduce(wanted), deadline);
  if (!session) {
    if (why != nullptr) *why = session.error().detail;
    return tl::unexpected(session.error().reason);
  }
  housekeeping_.tend(*session);
  const std::lock_guard lock(mutex_);
  sessions_.erase(std::remove_if(sessions_.begin(), sessions_.end(),
                                 [](const auto& known) { return known.expired(); }),
                  sessions_.end());
  sessions_.push_back(*session);
  return *session;
}

std::vector<std::string> LabCore::broker_addresses() {
  std::string named = options_.broker;
  if (named.empty()) {
    const char* variable = std::getenv("GECOS_BROKER");
    if (variable != nullptr) named = variable;
  }
  std::vector<std::string> addresses;
  const auto add_well_known = [&](media::Kind kind) {
    if (const auto opened = medium(kind)) {
      addresses.push_back((*opened)->well_known_address(broker_name));
    }
  };
  if (const auto kind = media::kind_from(named)) {  // "lcm": its well-known place
    add_well_known(*kind);
  } else if (!named.empty()) {
    addresses.push_back(named);
  } else {
    add_well_known(media::Kind::Inproc);
    add_well_known(media::Kind::Shm);
  }
  return addresses;
}

tl::expected<std::shared_ptr<LinkedSession>, std::string> LabCore::broker(TimePoint deadline) {
  const std::lock_guard one_looks(broker_mutex_);
  if (broker_ && !broker_->lost()) return broker_;
  broker_.reset();
  std::string tried;
  for (const auto& address : broker_addresses()) {
    auto session = connect(address, broker_interface(), deadline);
    if (session) return broker_ = std::move(*session);
    tried += (tried.empty() ? "" : "; ") + address + ": " + session.error();
  }
  return tl::unexpected("no broker answers; start `gecos-broker`, or say where it is in GECOS_BROKER" +
                        (tried.empty() ? std::string() : " (tried " + tried + ")"));
}

void LabCore::close_sessions(Duration patience) {
  std::vector<std::shared_ptr<LinkedSession>> open;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& known : sessions_) {
      if (auto session = known.lock()) open.push_back(std::move(session));
    }
  }
  const TimePoint give_up = deadline_after(patience);
  for (const auto& session : open) session->close(give_up - std::chrono::steady_clock::now());
  const std::lock_guard one_looks(broker_mutex_);
  broker_.reset();
}

}  // namespace gecos::session
