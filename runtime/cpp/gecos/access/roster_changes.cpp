#include "gecos/access/roster_changes.hpp"

#include <algorithm>
#include <utility>

namespace gecos::access {
namespace {

const Holder* entry_of(SessionId session, const std::vector<Holder>& roster) {
  const auto found = std::ranges::find(roster, session, &Holder::session);
  return found == roster.end() ? nullptr : &*found;
}

}  // namespace

void RosterChanges::note(std::vector<Holder> roster, TimePoint now, std::string_view why_ended) {
  using Kind = RosterChange::Kind;
  for (const Holder& before : roster_) {
    if (entry_of(before.session, roster) == nullptr) add(Kind::Ended, before, now, why_ended);
  }
  for (const Holder& holder : roster) {
    const Holder* const before = entry_of(holder.session, roster_);
    const bool returned = before != nullptr && before->releasing && !holder.releasing;
    if (before == nullptr || returned || holder.status != before->status) {
      add(Kind::Acquired, holder, now);
    }
    if (before == nullptr) continue;
    if (holder.releasing && !before->releasing) add(Kind::Releasing, holder, now);
    if (holder.taken_over == before->taken_over) continue;
    add(holder.taken_over ? Kind::TakenOver : Kind::GivenBack, holder, now);
  }
  roster_ = std::move(roster);
}

std::vector<RosterChange> RosterChanges::after(std::uint64_t number) const {
  const bool known = start_ <= number && number <= newest();
  const std::size_t wanted = known ? static_cast<std::size_t>(newest() - number) : kept;
  return {changes_.end() - static_cast<std::ptrdiff_t>(std::min(wanted, changes_.size())),
          changes_.end()};
}

void RosterChanges::add(RosterChange::Kind kind, const Holder& holder, TimePoint now,
                        std::string_view why_ended) {
  if (changes_.size() == kept) changes_.pop_front();
  ++count_;
  changes_.push_back({newest(), kind, holder, now, std::string(why_ended)});
}

}  // namespace gecos::access
