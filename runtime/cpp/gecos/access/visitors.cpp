#include "gecos/access/visitors.hpp"

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
  return decide_by(one.list, one.server, who) == AccessRule::Named;
}

bool VisitorBook::set(const std::string& name, std::uint64_t boot,
                      std::optional<ProgramList> list) {
  const MutexLock lock(mutex_);
  const auto found = lists_.find(name);
  const bool same_life = found != lists_.end() && found->second.program.boot == boot;
  if (!list) {
    if (found == lists_.end() || same_life) return false;
    lists_.erase(found);
    ++changes_;
    if (lists_.empty()) knows_revoked_ = false;
    return true;
  }
  // A medium may deliver an earlier registration after a later one.
  if (same_life && list->number <= found->second.program.number) return false;
  lists_.insert_or_assign(name, Listed{*std::move(list), ++changes_});
  return true;
}

void VisitorBook::keep_only(FunctionRef<bool(const std::string& name)> known) {
  const MutexLock lock(mutex_);
  const auto dropped =
      std::erase_if(lists_, [&](const auto& named) { return !known(named.first); });
  if (dropped > 0 && lists_.empty()) knows_revoked_ = false;
}

bool VisitorBook::empty() const {
  const MutexLock lock(mutex_);
  return lists_.empty();
}

std::optional<std::string> VisitorBook::object_of(const UserAtHost& who) const {
  const MutexLock lock(mutex_);
  for (const auto& [name, listed] : lists_) {
    if (admits_visitor(listed.program, who)) return name;
  }
  return std::nullopt;
}

bool VisitorBook::shows(const std::string& name, const UserAtHost& who) const {
  const MutexLock lock(mutex_);
  const auto found = lists_.find(name);
  return found != lists_.end() && admits_visitor(found->second.program, who);
}

std::uint64_t VisitorBook::view_of(const UserAtHost& who) const {
  const MutexLock lock(mutex_);
  std::uint64_t view = hash_of_nothing;
  for (const auto& [name, listed] : lists_) {
    if (admits_visitor(listed.program, who)) view = with(view, listed.change);
  }
  return view;
}

void VisitorBook::revoke(std::optional<std::vector<RevokedUser>> revoked) {
  const MutexLock lock(mutex_);
  knows_revoked_ = revoked.has_value();
  if (revoked) revoked_ = *std::move(revoked);
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
