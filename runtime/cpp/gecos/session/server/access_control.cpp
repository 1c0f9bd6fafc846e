#include "gecos/session/server/access_control.hpp"

#include <unistd.h>

#include <chrono>
#include <exception>
#include <thread>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/user_and_host.hpp"
#include "gecos/binding.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos::session {
namespace {

/// Maximum time for which `read` waits while a program is writing the lab file.
constexpr Duration longest_wait = std::chrono::seconds(3);
constexpr Duration between_reads = std::chrono::milliseconds(25);
/// A decision waits at most this long for the lab file to be read. After this time, the decision
/// uses the lists that were read last.
constexpr Duration answer_within = std::chrono::milliseconds(250);
/// A registration may wait longer, because it is refused without the lab file.
constexpr Duration registration_within = std::chrono::milliseconds(500);

/// Returns whether `peer` runs as the user of the server or as root. If neither the kernel nor a
/// key proves the user of `peer`, the user of the server is assumed.
bool is_of_server(const media::Peer& peer) {
  return peer.uid ? peer.uid == ::geteuid() || peer.uid == 0u : peer.user.empty();
}

std::string refusal_of(const std::string& object, const access::UserAtHost& who) {
  if (who.user.empty()) return object + " refuses a client whose key has no owner: ";
  return object + " refuses user " + who.user + " of host " + who.host + ": ";
}

}  // namespace

AccessControl::AccessControl(const std::string& lab_file, Admission admission,
                             std::shared_ptr<const BrokerContact> contact)
    : file_(lab_file), contact_(std::move(contact)) {
  policy_.insecure = admission == Admission::Insecure;
}

const access::AccessPolicy& AccessControl::policy() {
  if (auto found = file_.lists(); found != lists_) {
    policy_.lab = *found;
    lists_ = std::move(found);
  }
  return policy_;
}

tl::expected<void, std::string> AccessControl::read() {
  const TimePoint until = deadline_after(longest_wait);
  LabFileReader::Found found;
  do {
    if (!file_.read(longest_wait)) {
      return tl::unexpected(file_.path() +
                            ": the file cannot be read: its file system does not answer");
    }
    found = file_.found();
    if (!found.being_written) {
      if (found.known) return {};
      return tl::unexpected(to_string(*found.error));
    }
    std::this_thread::sleep_for(between_reads);
  } while (system_clock().now() < until);
  return tl::unexpected(file_.path() + ": another program keeps writing to the file; try again");
}

std::string AccessControl::zone_of(const std::string& object) {
  const MutexLock lock(mutex_);
  const auto& zones = policy().lab.zones;
  const auto found = zones.find(object);
  return found == zones.end() ? std::string() : found->second;
}

void AccessControl::allow(std::vector<std::string> users, std::vector<std::string> hosts) {
  const MutexLock lock(mutex_);
  policy_.program = access::AllowList{
      std::move(users), std::move(hosts),
      "the list in the program of the server (`allow`, or `users` and `hosts` of `serve`)"};
}

access::AllowList AccessControl::named_by_program(const std::string& object) {
  const MutexLock lock(mutex_);
  return policy().named_by_program(object);
}

std::string AccessControl::name_of(std::uint32_t uid) {
  {
    const MutexLock lock(mutex_);
    if (const auto found = names_.find(uid); found != names_.end()) return found->second;
  }
  std::string name = user_name(uid);
  const MutexLock lock(mutex_);
  return names_.emplace(uid, std::move(name)).first->second;
}

access::UserAtHost AccessControl::user_of(const media::Peer& peer, const std::string& host) {
  if (peer.uid) return {name_of(*peer.uid), host};
  return {peer.user, peer.host};
}

bool AccessControl::administers(const media::Peer& peer) noexcept {
  if (is_of_server(peer)) return true;
  try {
    const std::string host = host_name();
    const access::UserAtHost server{name_of(::geteuid()), host};
    const access::UserAtHost who = user_of(peer, host);
    const MutexLock lock(mutex_);
    return policy().administers(server, who);
  } catch (const std::exception& failed) {
    log_error("session", peer.description +
                             " does not count as an administrator, because the check failed: " +
                             failed.what());
    return false;
  }
}

void AccessControl::receive(std::shared_ptr<const Visitors> visitors) {
  const MutexLock lock(mutex_);
  visitors_ = std::move(visitors);
}

std::optional<access::UserAtHost> AccessControl::other_user(const media::Peer& peer) {
  if (is_of_server(peer)) return std::nullopt;
  return user_of(peer, host_name());
}

std::optional<access::UserAtHost> AccessControl::visitor(const std::string& object,
                                                         const media::Peer& peer) noexcept {
  Judgement judgement = judge_by_lists(object, peer);
  if (judgement.admitted && !judgement.visitor) return std::nullopt;
  return std::move(judgement.who);
}

AccessControl::Judgement AccessControl::judge_visitor(const std::string& object,
                                                      const media::Peer& peer,
                                                      const access::UserAtHost& server,
                                                      const access::UserAtHost& who,
                                                      std::string refusal) {
  const Judgement refused{false, false, who, std::move(refusal)};
  const bool has_list = policy_.program || policy_.lab.objects.contains(object);
  if (!visitors_ || object != access::broker_object || has_list) return refused;
  // The program of a server may name visitors only while the broker admits the user of this server
  // in full, not as a visitor. Otherwise users whom the lab file no longer names could admit each
  // other.
  const auto shown = visitors_->book.object_of(who, [&](const access::ServerLife& one) {
    mutex_.assert_held();
    return one.own || policy_.decide(server, one.user, object).allowed();
  });
  if (!shown) return refused;
  if (visitors_->book.revoked(peer.key, who)) {
    return {false, false, who,
            refusal_of(object, who) + "the user who runs the broker has revoked this user"};
  }
  return {true, false, who,
          object + " admits user " + who.user + " of host " + who.host +
              " as a visitor: the program that serves " + *shown + " names this user",
          true};
}

AccessControl::Judgement AccessControl::judge_registration(const std::string& name,
                                                           const media::Peer& peer) noexcept {
  try {
    const access::UserAtHost who = user_of(peer, host_name());
    const auto refused = [&](const std::string& why) {
      return Judgement{false, false, who, "no server may register " + name + " while " + why};
    };
    if (!file_.read(registration_within)) {
      return refused("the file system of the lab file does not answer: " + file_.path());
    }
    if (const auto error = file_.found().error) {
      return refused(
          "the lab file has an error; correct it, or write an empty file, which removes all its "
          "lists: " +
          to_string(*error));
    }
    const auto proved = who.user.empty() ? std::nullopt : std::optional(who);
    const MutexLock lock(mutex_);
    auto decision = access::may_register(policy().lab, name, proved);
    return {decision.allowed, false, who, std::move(decision.text)};
  } catch (const std::exception& failed) {
    return {false, false, {}, "no server may register " + name + ": " + failed.what()};
  }
}

AccessControl::Judgement AccessControl::judge_report(const std::string& zone,
                                                     const std::string& source,
                                                     const media::Peer& peer) noexcept {
  try {
    const access::UserAtHost who = user_of(peer, host_name());
    const MutexLock lock(mutex_);
    const auto proved = who.user.empty() ? std::nullopt : std::optional(who);
    auto decision = access::may_report(policy().lab, zone, source, {proved, is_of_server(peer)});
    return {decision.allowed, false, who, std::move(decision.text)};
  } catch (const std::exception& failed) {
    return {false, false, {}, "nobody may report for " + source + ": " + failed.what()};
  }
}

bool AccessControl::knows_revoked() {
  const MutexLock lock(mutex_);
  return visitors_ && visitors_->book.knows_revoked();
}

AccessControl::Judgement AccessControl::judge(const std::string& object,
                                              const media::Peer& peer) noexcept {
  if (!is_of_server(peer)) file_.read(answer_within);
  Judgement judgement = judge_by_lists(object, peer);
  if (judgement.visitor && !knows_revoked()) {
    return {false, false, judgement.who,
            refusal_of(object, judgement.who) +
                "at the moment the broker does not know which users are revoked; try again"};
  }
  if (!judgement.admitted || peer.user.empty()) return judgement;
  const std::string since = contact_->out_of_contact();
  if (since.empty()) return judgement;
  judgement.admitted = false;
  judgement.text = refusal_of(object, judgement.who) +
                   "the server has had no contact with the broker " + since +
                   ", so the server does not know which users the laboratory has revoked; when the "
                   "broker answers, the server admits users of other hosts again";
  return judgement;
}

AccessControl::Judgement AccessControl::judge_by_lists(const std::string& object,
                                                       const media::Peer& peer) noexcept {
  if (is_of_server(peer) && peer.key.empty()) return {};
  try {
    const std::string host = host_name();
    const access::UserAtHost server{name_of(::geteuid()), host};
    const access::UserAtHost who = user_of(peer, host);
    if (contact_->revokes(peer.key, who)) {
      return {false, false, who,
              refusal_of(object, who) + "the user who runs the broker has revoked this user"};
    }
    if (is_of_server(peer)) return {};
    const MutexLock lock(mutex_);
    const access::AccessDecision decision = policy().decide(server, who, object);
    if (!decision.allowed()) return judge_visitor(object, peer, server, who, decision.text);
    return {true, false, who, decision.text};
  } catch (const std::exception& failed) {
    return {false, false, {}, object + " refuses all other users: " + failed.what()};
  }
}

}  // namespace gecos::session
