#include "gecos/access/visitors.hpp"

#include <algorithm>
#include <utility>

namespace gecos::access {
namespace {

constexpr std::uint64_t hash_of_nothing = 0xcbf29ce484222325u;

/// Adds a number to a hash (FNV-1a of 64 bits).
std::uint64_t with(std::uint64_t hash, std::uint64_t number) {
  for (int shift = 0; shift < 64; shift += 8) {
    hash = (hash ^ (number >> shift & 0xff)) * 0x100000001b3u;
  }
  return hash;
}

}  // namespace

bool admits_visitor(const ProgramList& one, const UserAtHost& who) {
  return decide_by(one.list, one.server.user, who) == AccessRule::Named;
}

bool VisitorBook::set(const std::string& name, ProgramList list, std::uint64_t revision) {
  const MutexLock lock(mutex_);
  const auto found = lists_.find(name);
  // A medium may deliver an earlier registration after a later one. The list of the later
  // registration, which has the greater number, stays in force.
  if (found != lists_.end() && found->second.program.server == list.server &&
      list.number <= found->second.program.number) {
    return false;
  }
  const bool replaces = found != lists_.end();
  lists_.insert_or_assign(name, Listed{std::move(list), ++changes_, revision});
  if (replaces) forget_revoked_if_unused();
  return true;
}

bool VisitorBook::drop_other(const std::string& name, const ServerLife& server) {
  const MutexLock lock(mutex_);
  const auto found = lists_.find(name);
  if (found == lists_.end() || found->second.program.server == server) return false;
  lists_.erase(found);
  forget_revoked_if_unused();
  return true;
}

bool VisitorBook::keep_only(FunctionRef<bool(const std::string& name)> keeps_name) {
  const MutexLock lock(mutex_);
  const auto dropped =
      std::erase_if(lists_, [&](const auto& named) { return !keeps_name(named.first); });
  if (dropped > 0) forget_revoked_if_unused();
  return dropped > 0;
}

void VisitorBook::forget_revoked_if_unused() {
  knows_revoked_ = knows_revoked_ && names_somebody_now();
}

bool VisitorBook::names_somebody() const {
  const MutexLock lock(mutex_);
  return names_somebody_now();
}

bool VisitorBook::names_somebody_now() const {
  return std::ranges::any_of(lists_, [](const auto& named) {
    const AllowList& list = named.second.program.list;
    return !list.users.empty() || !list.hosts.empty();
  });
}

bool VisitorBook::admits(const ProgramList& one, const UserAtHost& who) const {
  const ServerLife& server = one.server;
  return admits_visitor(one, who) && (server.own || !revokes(revoked_, server.key, server.user));
}

std::optional<std::string> VisitorBook::object_of(
    const UserAtHost& who, FunctionRef<bool(const ServerLife& server)> counts) const {
  const MutexLock lock(mutex_);
  for (const auto& [name, listed] : lists_) {
    if (admits(listed.program, who) && counts(listed.program.server)) return name;
  }
  return std::nullopt;
}

VisitorBook::Seen VisitorBook::seen_by(const UserAtHost& who) const {
  const MutexLock lock(mutex_);
  Seen seen{{}, hash_of_nothing, 0};
  for (const auto& [name, listed] : lists_) {
    if (!admits(listed.program, who)) continue;
    seen.objects.insert(name);
    seen.view = with(seen.view, listed.change);
    seen.since = std::max(seen.since, listed.revision);
  }
  return seen;
}

void VisitorBook::set_revoked(std::vector<RevokedUser> revoked) {
  const MutexLock lock(mutex_);
  revoked_ = std::move(revoked);
  knows_revoked_ = true;
}

void VisitorBook::lose_revoked() {
  const MutexLock lock(mutex_);
  knows_revoked_ = false;
}

bool VisitorBook::knows_revoked() const {
  const MutexLock lock(mutex_);
  return knows_revoked_;
}

bool VisitorBook::revoked(std::string_view key, const UserAtHost& who) const {
  const MutexLock lock(mutex_);
  return revokes(revoked_, key, who);
}

}  // namespace gecos::access
