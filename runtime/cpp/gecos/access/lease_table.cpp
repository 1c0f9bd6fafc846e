#include "gecos/access/lease_table.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace gecos::access {
namespace {

std::string seconds(Duration duration) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s",
                std::chrono::duration<double>(std::max(duration, Duration::zero())).count());
  return text;
}

std::string needs(Status needed) {
  const std::string status(to_string(needed));
  return "needs " + status + " status";
}

/// Programs in all languages show this text, so it must not use the syntax of one language.
std::string how_to_get(Status needed) {
  return "call " + std::string(to_string(needed)) + "(object) of gecos to acquire it";
}

}  // namespace

std::string describe(const Holder& holder, TimePoint now) {
  std::string text = std::string(to_string(holder.status)) + " status is held by " +
                     holder.client.user + " on " + holder.client.host + " (" +
                     holder.client.program + ", pid " + std::to_string(holder.client.pid) +
                     ") for " + seconds(now - holder.since);
  text += holder.releasing ? "; it is released, but the last commands under it still run"
                           : "; this client loses it if it stays silent for " +
                                 seconds(holder.expires - now) + " more";
  return text;
}

LeaseTable::LeaseTable(IncarnationId incarnation, Duration ttl)
    : incarnation_(incarnation), ttl_(ttl) {}

Epoch LeaseTable::epoch() const {
  const std::uint64_t life =
      (number(incarnation_) * 0x9e37'79b9'7f4a'7c15U) & 0xffff'ffff'0000'0000U;
  return Epoch{life | changes_};
}

const LeaseTable::Member* LeaseTable::find(SessionId session) const {
  const auto found = members_.find(session);
  return found == members_.end() ? nullptr : &found->second;
}

std::vector<Holder> LeaseTable::roster() const {
  std::vector<Holder> holders;
  holders.reserve(members_.size());
  for (const auto& [session, member] : members_) holders.push_back(member.holder);
  std::ranges::sort(holders, {},
                    [](const Holder& holder) { return std::pair(holder.since, holder.session); });
  return holders;
}

LeaseRefusal LeaseTable::refuse(LeaseRefusal::Reason reason, std::string_view why,
                                TimePoint now) const {
  LeaseRefusal refusal{reason, std::string(why), roster()};
  for (const Holder& holder : refusal.holders) refusal.text += "; " + describe(holder, now);
  return refusal;
}

LeaseRefusal LeaseTable::refusal_to_return(Status wanted, TimePoint now) const {
  return refuse(
      LeaseRefusal::Reason::HeldByOther,
      std::string(to_string(wanted)) + " status refused: other clients already wait for it", now);
}

tl::expected<Grant, LeaseRefusal> LeaseTable::acquire(SessionId session, const Client& client,
                                                      Status wanted, const Proof& password,
                                                      TimePoint now) {
  using Reason = LeaseRefusal::Reason;
  const std::string status(to_string(wanted));
  const auto mine = members_.find(session);
  const bool member = mine != members_.end();
  const Status target = member ? std::max(wanted, mine->second.holder.status) : wanted;
  for (const auto& [id, other] : members_) {
    if (id == session) continue;
    if (other.holder.status != target) {
      return tl::unexpected(refuse(
          Reason::HeldByOther, status + " status refused: other clients hold another status", now));
    }
    if (member) continue;  // the session has given the right password before
    if (password_.empty()) {
      return tl::unexpected(refuse(
          Reason::HeldByOther,
          status + " status refused: it is not shared, so wait or ask the holder to release it",
          now));
    }
    if (!password_.proves_the_same_as(password)) {
      const std::string given = password.empty() ? "no password was given"
                                                 : "the given password is wrong, so ask the holder";
      return tl::unexpected(
          refuse(Reason::WrongPassword,
                 status + " status refused: it is shared by password, and " + given, now));
    }
  }

  if (member) {
    auto& [holder, claims] = mine->second;
    claims = holder.releasing ? 1 : claims + 1;
    holder.releasing = false;
    holder.status = target;
    holder.expires = now + ttl_;
    if (members_.size() == 1 && !password.empty()) password_ = password;
  } else {
    if (members_.empty()) password_ = password;
    members_.emplace(session, Member{{session, wanted, client, now, now + ttl_, false}, 1});
  }
  return Grant{target, epoch()};
}

void LeaseTable::renew(SessionId session, TimePoint now) {
  const auto mine = members_.find(session);
  if (mine != members_.end()) mine->second.holder.expires = now + ttl_;
}

void LeaseTable::remove(Members::iterator member) {
  members_.erase(member);
  if (!members_.empty()) return;
  ++changes_;
  password_ = Proof();
}

bool LeaseTable::release(SessionId session, Epoch epoch, Commands commands) {
  const auto mine = members_.find(session);
  if (mine == members_.end()) return true;
  auto& [holder, claims] = mine->second;
  if (epoch != this->epoch() || holder.releasing) return false;
  if (--claims > 0) return false;
  if (commands == Commands::Pending) {
    holder.releasing = true;
    return false;
  }
  remove(mine);
  return true;
}

void LeaseTable::drained(SessionId session) {
  const auto mine = members_.find(session);
  if (mine != members_.end() && mine->second.holder.releasing) remove(mine);
}

bool LeaseTable::lose(SessionId session) {
  const auto mine = members_.find(session);
  if (mine == members_.end() || mine->second.holder.releasing) return false;
  remove(mine);
  return true;
}

std::vector<Holder> LeaseTable::expire(TimePoint now) {
  std::vector<Holder> silent;
  for (const auto& [session, member] : members_) {
    if (!member.holder.releasing && member.holder.expires <= now) silent.push_back(member.holder);
  }
  for (const Holder& holder : silent) {
    losses_[holder.session] = {epoch(), Denial::Reason::LeaseEnded,
                               "its holder was silent for " + seconds(ttl_)};
    remove(members_.find(holder.session));
  }
  return silent;
}

std::vector<Holder> LeaseTable::stop(SessionId by, const std::string& why) {
  std::vector<Holder> ended;
  std::erase_if(members_, [&](const auto& entry) {
    const Holder& holder = entry.second.holder;
    losses_[holder.session] = {epoch(), Denial::Reason::Stopped, why};
    if (holder.session == by && !holder.releasing) return false;
    ended.push_back(holder);
    return true;
  });
  ++changes_;
  if (members_.empty()) password_ = Proof();
  return ended;
}

void LeaseTable::forget(SessionId session) { losses_.erase(session); }

tl::expected<void, Denial> LeaseTable::authorise(const Member* member, SessionId session,
                                                 Epoch epoch, Status needed, TimePoint now) const {
  using Reason = Denial::Reason;
  const auto lost = losses_.find(session);
  const bool was_lost = lost != losses_.end() && lost->second.epoch == epoch &&
                        (member == nullptr || epoch != this->epoch());
  if (needed != Status::Sensor && (was_lost || (epoch != Epoch{} && epoch != this->epoch()))) {
    Denial denial{Reason::LeaseEnded, "was issued under a status that has ended"};
    if (was_lost) denial = {lost->second.reason, denial.text + ": " + lost->second.why};
    for (const Holder& other : roster()) {
      if (other.session != session) denial.text += "; " + describe(other, now);
    }
    if (member == nullptr) denial.text += "; " + how_to_get(needed) + " again";
    return tl::unexpected(std::move(denial));
  }
  if (member == nullptr && !members_.empty() &&
      members_.begin()->second.holder.status == Status::Master) {
    return tl::unexpected(
        Denial{Reason::OthersMaster,
               "is refused while another client is master: " + describe(roster().front(), now)});
  }
  if (needed == Status::Sensor) return {};
  if (member != nullptr && member->holder.status >= needed && epoch != Epoch{}) return {};
  Denial denial{Reason::NeedsStatus, needs(needed)};
  for (const Holder& other : roster()) {
    if (other.session != session) denial.text += "; " + describe(other, now);
  }
  if (members_.empty() || member != nullptr) denial.text += "; " + how_to_get(needed);
  return tl::unexpected(std::move(denial));
}

tl::expected<void, Denial> LeaseTable::may_queue(SessionId session, Epoch epoch, Status needed,
                                                 TimePoint now) const {
  const Member* const member = find(session);
  if (member != nullptr && member->holder.releasing && needed != Status::Sensor) {
    return tl::unexpected(Denial{
        Denial::Reason::NeedsStatus,
        needs(needed) + "; the lease was released, and the last commands under it still run; " +
            how_to_get(needed) + " again"});
  }
  return authorise(member, session, epoch, needed, now);
}

tl::expected<void, Denial> LeaseTable::may_start(SessionId session, Epoch epoch, Status needed,
                                                 TimePoint now) const {
  return authorise(find(session), session, epoch, needed, now);
}

Status LeaseTable::status_of(SessionId session) const {
  const Member* const member = find(session);
  return member == nullptr ? Status::Sensor : member->holder.status;
}

bool LeaseTable::releasing(SessionId session) const {
  const Member* const member = find(session);
  return member != nullptr && member->holder.releasing;
}

}  // namespace gecos::access
