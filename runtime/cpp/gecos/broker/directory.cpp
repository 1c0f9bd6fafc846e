#include "gecos/broker/directory.hpp"

#include <algorithm>
#include <utility>

namespace gecos::broker {

tl::expected<Duration, NameTaken> Directory::enlist(const Claim& claim, const Entry& entry,
                                                    TimePoint now) {
  const TimePoint since = now - claim.served_for;
  const Duration provisional = std::max(settled_ - now, Duration::zero());
  const auto found = places_.find(entry.name);
  if (found == places_.end()) {
    places_.emplace(entry.name, Place{claim.session, entry, since});
    silent_.erase(entry.name);
    return provisional;
  }
  Place& place = found->second;
  if (place.entry == entry && (place.session == claim.session || entry.boot == claim.incarnation)) {
    place.session = claim.session;
    // A claim that arrives with a delay yields a later `since`, so the earliest `since` is the most
    // exact.
    place.since = std::min(place.since, since);
    return provisional;
  }
  if (!gives_way(place, entry, since, now)) {
    const Entry& other = place.entry;
    return tl::unexpected(NameTaken{entry.name, "a " + other.interface_name + " of " + other.user +
                                                    " on " + other.hostname + ", pid " +
                                                    std::to_string(other.pid)});
  }
  auto displaced = std::move(place.displaced);
  displaced.push_back(std::move(place.entry));
  place = {claim.session, entry, since, std::move(displaced)};
  return provisional;
}

bool Directory::gives_way(const Place& place, const Entry& entry, TimePoint since,
                          TimePoint now) const {
  return now < settled_ && since < started_ && since < place.since &&
         std::ranges::find(place.displaced, entry) == place.displaced.end();
}

tl::expected<void, UnknownName> Directory::withdraw(std::uint64_t session,
                                                    const std::string& name) {
  const auto found = places_.find(name);
  if (found == places_.end() || found->second.session != session) {
    return tl::unexpected(unknown(name));
  }
  places_.erase(found);
  return {};
}

std::vector<std::string> Directory::end_session(std::uint64_t session, TimePoint heard) {
  std::vector<std::string> dropped;
  for (auto at = places_.begin(); at != places_.end();) {
    if (at->second.session != session) {
      ++at;
      continue;
    }
    dropped.push_back(at->first);
    remember({std::move(at->second.entry), heard});
    at = places_.erase(at);
  }
  return dropped;
}

tl::expected<Entry, UnknownName> Directory::look_up(const std::string& name) const {
  const auto found = places_.find(name);
  if (found == places_.end()) return tl::unexpected(unknown(name));
  return found->second.entry;
}

std::vector<Entry> Directory::list() const {
  std::vector<Entry> entries;
  for (const auto& [name, place] : places_) entries.push_back(place.entry);
  return entries;
}

void Directory::remember(Silent one) {
  const std::string name = one.entry.name;
  silent_.insert_or_assign(name, std::move(one));
  if (silent_.size() <= most_silent) return;
  silent_.erase(std::ranges::min_element(
      silent_, {}, [](const auto& remembered_one) { return remembered_one.second.since; }));
}

std::vector<Silent> Directory::silent(TimePoint now) const {
  std::vector<Silent> found;
  for (const auto& [name, one] : silent_) {
    if (now - one.since < remembered) found.push_back(one);
  }
  return found;
}

UnknownName Directory::unknown(const std::string& name) const {
  UnknownName answer;
  answer.name = name;
  for (const auto& [known, place] : places_) answer.known.push_back(known);
  return answer;
}

}  // namespace gecos::broker
