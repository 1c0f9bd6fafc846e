#include "gecos/session/server/access_control.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <thread>
#include <utility>

#include "gecos/base/descriptor.hpp"
#include "gecos/base/log.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/base/user_and_host.hpp"

namespace gecos::session {
namespace {

using access::EditedLabFile;
using access::LabFileError;

constexpr const char* of_this_host = "/etc/gecos/lab.toml";
// The TOML parser recurses for each part of a dotted key: a key with 200,000 parts would overflow
// the stack and end the process.
constexpr std::size_t largest_file = 1 << 16;
/// A file is read only when it has not changed for this long.
constexpr Duration settled = std::chrono::milliseconds(100);
constexpr Duration settled_empty = std::chrono::seconds(1);
/// Maximum time for which a starting server waits while the file is being written.
constexpr Duration longest_wait = std::chrono::seconds(3);
constexpr Duration between_reads = std::chrono::milliseconds(25);

/// Returns whether `peer` runs as the user of the server or as root. A peer whose user neither the
/// kernel nor a key proves counts as the user of the server.
bool is_of_server(const media::Peer& peer) {
  return peer.uid ? peer.uid == ::geteuid() || peer.uid == 0u : peer.user.empty();
}

/// Returns the path of the lab file that `option` or GECOS_LAB_FILE names; an empty text when
/// neither names one.
std::string named_file(const std::string& option) {
  const char* const variable = std::getenv("GECOS_LAB_FILE");
  const std::string named = !option.empty() ? option : variable != nullptr ? variable : "";
  std::error_code unknown_folder;
  const auto absolute = std::filesystem::absolute(named, unknown_folder);
  return named.empty() || unknown_folder ? named : absolute.string();
}

/// Returns why the server must not use the file with these attributes; an empty text when it may.
std::string distrust(const struct stat& file, const std::string& path) {
  if (!S_ISREG(file.st_mode)) return "this is not a file";
  if (file.st_uid != 0 && file.st_uid != ::geteuid()) {
    return "the file belongs to " + user_name(file.st_uid) +
           ", who could admit anyone; run: chown " + user_name(::geteuid()) + " " + path;
  }
  if ((file.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return "other users may write to the file and could admit anyone; run: chmod go-w " + path;
  }
  if (static_cast<std::size_t>(file.st_size) > largest_file)
    return "the file is larger than 64 KiB";
  return "";
}

/// Returns whether another program seems to be writing the file at the moment. Most editors empty a
/// file before they write it, and a half-written file may be valid although its last rules are
/// missing.
bool is_being_written(const struct stat& file) {
  using std::chrono::system_clock;
  const auto changed = system_clock::time_point(std::chrono::duration_cast<system_clock::duration>(
      std::chrono::seconds(file.st_mtim.tv_sec) + std::chrono::nanoseconds(file.st_mtim.tv_nsec)));
  const auto age = system_clock::now() - changed;
  return std::chrono::abs(age) < (file.st_size == 0 ? settled_empty : settled);
}

/// Reads the file, and sets `must_exist` when it exists. If it does not exist and need not exist,
/// returns an empty text. Returns nullopt while the file is being written.
std::optional<EditedLabFile::Text> text_of(const std::string& path, bool& must_exist) {
  const auto failed = [&](const std::string& why) {
    return tl::unexpected(LabFileError{path, 0, "", why});
  };
  // O_NONBLOCK: a named pipe must not block the server
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file && errno == ENOENT && !must_exist) return std::string();
  must_exist = true;
  struct stat attributes {};
  if (!file || ::fstat(file.get(), &attributes) != 0) {
    return failed("the file cannot be read: " + system_text(errno));
  }
  if (const std::string why = distrust(attributes, path); !why.empty()) return failed(why);
  if (is_being_written(attributes)) return std::nullopt;
  std::string text;
  std::array<char, 4096> part;
  ssize_t count = 0;
  while (text.size() <= largest_file &&
         (count = ::read(file.get(), part.data(), part.size())) > 0) {
    text.append(part.data(), static_cast<std::size_t>(count));
  }
  if (count < 0) return failed("the file cannot be read: " + system_text(errno));
  return text;
}

}  // namespace

AccessControl::AccessControl(const std::string& lab_file)
    : must_exist_(!named_file(lab_file).empty()),
      file_(must_exist_ ? named_file(lab_file) : of_this_host) {}

std::optional<LabFileError> AccessControl::read_file() {
  const auto text = text_of(file_.lists().file, must_exist_);
  auto error = text ? file_.take(*text) : std::nullopt;
  policy_.lab = file_.lists();
  return error;
}

void AccessControl::reread_file() {
  if (const auto error = read_file()) {
    log_error("session", to_string(*error) +
                             "; the last lists without an error stay in force; correct the file");
  }
}

tl::expected<void, std::string> AccessControl::read() {
  for (Duration waited{}; waited < longest_wait; waited += between_reads) {
    {
      const MutexLock lock(mutex_);
      read_file();
      if (file_.known()) return {};
      if (file_.error()) return tl::unexpected(to_string(*file_.error()));
    }
    std::this_thread::sleep_for(between_reads);
  }
  const MutexLock lock(mutex_);
  return tl::unexpected(file_.lists().file + ": the file is being written all the time; try again");
}

void AccessControl::reread() {
  const MutexLock lock(mutex_);
  reread_file();
}

std::string AccessControl::zone_of(const std::string& object) {
  const MutexLock lock(mutex_);
  const auto found = policy_.lab.zones.find(object);
  return found == policy_.lab.zones.end() ? std::string() : found->second;
}

void AccessControl::allow(std::vector<std::string> users, std::vector<std::string> hosts) {
  const MutexLock lock(mutex_);
  policy_.program = access::AllowList{std::move(users), std::move(hosts),
                                      "Server::allow in the program of the server"};
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
    reread_file();
    return policy_.administers(server, who);
  } catch (const std::exception& failed) {
    log_error("session", std::string("nobody is an administrator: ") + failed.what());
    return false;
  }
}

std::string AccessControl::refusal(const std::string& object, const media::Peer& peer) noexcept {
  Judgement judgement = judge(object, peer);
  return judgement.admitted ? std::string() : std::move(judgement.text);
}

AccessControl::Judgement AccessControl::judge_registration(const std::string& name,
                                                           const media::Peer& peer) noexcept {
  try {
    const access::UserAtHost who = user_of(peer, host_name());
    const MutexLock lock(mutex_);
    reread_file();
    if (file_.error()) {
      return {false, false, who,
              "no server may register " + name +
                  " while the lab file has an error; correct it: " + to_string(*file_.error())};
    }
    const auto proved = who.user.empty() ? std::nullopt : std::optional(who);
    auto decision = access::may_register(policy_.lab, name, proved);
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
    auto decision = access::may_report(policy_.lab, zone, source, {proved, is_of_server(peer)});
    return {decision.allowed, false, who, std::move(decision.text)};
  } catch (const std::exception& failed) {
    return {false, false, {}, "nobody may report for " + source + ": " + failed.what()};
  }
}

AccessControl::Judgement AccessControl::judge(const std::string& object,
                                              const media::Peer& peer) noexcept {
  if (is_of_server(peer)) return {};
  try {
    const std::string host = host_name();
    const access::UserAtHost server{name_of(::geteuid()), host};
    const access::UserAtHost who = user_of(peer, host);
    const MutexLock lock(mutex_);
    reread_file();
    const access::AccessDecision decision = policy_.decide(server, who, object);
    return {decision.allowed(), false, who, decision.text};
  } catch (const std::exception& failed) {
    return {false, false, {}, object + " refuses all other users: " + failed.what()};
  }
}

}  // namespace gecos::session
