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

std::string name_of(const Client& client) {
  return client.user + " on " + client.host + " (" + client.program + ", pid " +
         std::to_string(client.pid) + ")";
}

/// Programs in all languages show this text, so it must not use the syntax of one language.
std::string how_to_get(Status needed) {
  return "call " + std::string(to_string(needed)) + "(object) of gecos to acquire it";
}

}  // namespace

std::string describe(const Holder& holder, TimePoint now) {
  std::string text = std::string(to_string(holder.status)) + " status is held by " +
                     name_of(holder.client) + " for " + seconds(now - holder.since);
  const std::string program = "the program of " + holder.client.user;
  if (holder.taken_over) {
    text += "; " + program + " took over " + seconds(now - holder.taken_over_since) + " ago";
  }
  text += holder.releasing ? "; the status is released, but the last commands under it still run"
                           : "; " + program + " loses the status if it stays silent for " +
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
      const std::string given = password.empty()
                                    ? "no password was given, so ask the holder for it"
                                    : "the given password is wrong, so ask the holder for it";
      return tl::unexpected(
          refuse(Reason::WrongPassword,
                 status + " status refused: it is shared by password, and " + given, now));
    }
  }

  if (member) {
    auto& holder = mine->second.holder;
    auto& claims = mine->second.claims;
    claims = holder.releasing ? 1 : claims + 1;
    holder.releasing = false;
    holder.status = target;
    holder.expires = now + ttl_;
    if (members_.size() == 1 && !password.empty()) password_ = password;
  } else {
    if (members_.empty()) password_ = password;
    members_.emplace(session, Member{{.session = session,
                                      .status = wanted,
                                      .client = client,
                                      .since = now,
                                      .expires = now + ttl_},
                                     1,
                                     epoch(),
                                     epoch()});
  }
  return Grant{target, epoch()};
}

bool LeaseTable::compares_password(SessionId session) const {
  return !members_.empty() && !members_.contains(session) && !password_.empty();
}

void LeaseTable::renew(SessionId session, TimePoint now) {
  const auto mine = members_.find(session);
  if (mine != members_.end()) mine->second.holder.expires = now + ttl_;
}

void LeaseTable::remove(Members::iterator member) {
  if (member->first == taker_) taker_ = {};
  members_.erase(member);
  if (!members_.empty()) return;
  ++changes_;
  password_ = Proof();
}

bool LeaseTable::release(SessionId session, Epoch epoch, Commands commands) {
  const auto mine = members_.find(session);
  if (mine == members_.end()) return true;
  auto& holder = mine->second.holder;
  if (epoch != this->epoch() || holder.releasing) return false;
  if (--mine->second.claims > 0) return false;
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
    const auto member = members_.find(holder.session);
    losses_[holder.session] = {member->second.first, epoch(), Denial::Reason::LeaseEnded,
                               "its holder was silent for " + seconds(ttl_)};
    remove(member);
  }
  return silent;
}

std::vector<Holder> LeaseTable::stop(SessionId by, const std::string& why, Denial::Reason reason) {
  std::vector<Holder> ended;
  std::erase_if(members_, [&](const auto& entry) {
    const Holder& holder = entry.second.holder;
    losses_[holder.session] = {entry.second.first, epoch(), reason, why};
    if (holder.session == by && !holder.releasing) return false;
    ended.push_back(holder);
    return true;
  });
  ++changes_;
  for (auto& [session, member] : members_) member.first = member.fence = epoch();
  if (!members_.contains(taker_)) taker_ = {};
  if (members_.empty()) password_ = Proof();
  return ended;
}

tl::expected<void, LeaseRefusal> LeaseTable::take_over(SessionId session, TimePoint now) {
  using Reason = LeaseRefusal::Reason;
  const auto mine = members_.find(session);
  if (mine == members_.end() || mine->second.holder.releasing) {
    return tl::unexpected(
        refuse(Reason::HeldByOther,
               "take-over refused: this client does not hold the status; acquire it first", now));
  }
  if (taker_ == session) return {};
  if (taker_ != SessionId{}) {
    return tl::unexpected(
        refuse(Reason::HeldByOther,
               "take-over refused: " + name_of(members_.at(taker_).holder.client) +
                   " has taken over; wait until it gives sole command back, or stop the object",
               now));
  }
  taker_ = session;
  auto& holder = mine->second.holder;
  holder.taken_over = true;
  holder.taken_over_since = now;
  ++changes_;
  for (auto& [other, member] : members_) {
    if (other == session) continue;
    member.fence = epoch();
    member.preempted_by = name_of(holder.client);
    member.preempted_at = now;
  }
  return {};
}

bool LeaseTable::give_back(SessionId session) {
  if (taker_ != session || session == SessionId{}) return false;
  members_.at(session).holder.taken_over = false;
  taker_ = {};
  return true;
}

void LeaseTable::forget(SessionId session) { losses_.erase(session); }

/// Returns whether a command with `epoch` was issued under the lost status that `loss` describes.
/// `member` is the session's present status, or null; a command that was issued under the present
/// status does not belong to the lost one.
bool LeaseTable::was_issued_under(const Loss& loss, Epoch epoch, const Member* member) const {
  return loss.first <= epoch && epoch <= loss.last && (member == nullptr || epoch < member->first);
}

/// Returns whether the commands that the session issued under `epoch` are still valid: no loss of
/// the status, no stop and no take-over has ended them.
bool LeaseTable::current(const Member* member, SessionId session, Epoch epoch) const {
  if (member != nullptr) return member->fence <= epoch && epoch <= this->epoch();
  const auto lost = losses_.find(session);
  return epoch == this->epoch() &&
         (lost == losses_.end() || !was_issued_under(lost->second, epoch, member));
}

/// Returns the denial of a command that was issued under a status that has ended, or before another
/// holder took over.
Denial LeaseTable::ended(const Member* member, SessionId session, Epoch epoch, Status needed,
                         TimePoint now) const {
  using Reason = Denial::Reason;
  if (member != nullptr && member->first <= epoch && epoch < member->fence) {
    const bool held_off = taker_ != SessionId{} && taker_ != session;
    return {Reason::Preempted, "was issued before " + member->preempted_by + " took over, " +
                                   seconds(now - member->preempted_at) + " ago" +
                                   (held_off ? "; wait until it gives sole command back"
                                             : "; check where the device is, and command again")};
  }
  Denial denial{Reason::LeaseEnded, "was issued under a status that has ended"};
  const auto lost = losses_.find(session);
  if (lost != losses_.end() && was_issued_under(lost->second, epoch, member)) {
    denial = {lost->second.reason, denial.text + ": " + lost->second.why};
  }
  for (const Holder& other : roster()) {
    if (other.session != session) denial.text += "; " + describe(other, now);
  }
  if (member == nullptr) denial.text += "; " + how_to_get(needed) + " again";
  return denial;
}

tl::expected<void, Denial> LeaseTable::authorise(const Member* member, SessionId session,
                                                 Epoch epoch, Status needed, TimePoint now) const {
  using Reason = Denial::Reason;
  if (needed != Status::Sensor && epoch != Epoch{} && !current(member, session, epoch)) {
    return tl::unexpected(ended(member, session, epoch, needed, now));
  }
  if (member == nullptr && !members_.empty() &&
      members_.begin()->second.holder.status == Status::Master) {
    return tl::unexpected(
        Denial{Reason::OthersMaster,
               "is refused while another client is master: " + describe(roster().front(), now)});
  }
  if (needed == Status::Sensor) return {};
  if (member != nullptr && member->holder.status >= needed && epoch != Epoch{}) {
    if (taker_ == SessionId{} || taker_ == session) return {};
    const Holder& taker = members_.at(taker_).holder;
    return tl::unexpected(
        Denial{Reason::HeldOff, "is held off: " + name_of(taker.client) + " took over " +
                                    seconds(now - taker.taken_over_since) +
                                    " ago; wait until it gives sole command back"});
  }
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
