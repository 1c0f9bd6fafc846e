#include "gecos/broker/directory.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "gecos/base/seconds.hpp"

namespace gecos::broker {
namespace {

std::string described(const Entry& entry) {
  return "a " + entry.interface_name + " of " + entry.user + " on " + entry.hostname + ", pid " +
         std::to_string(entry.pid);
}

/// Returns a duration as text for people, for example "3.2 s".
std::string in_seconds(Duration length) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", to_seconds(length));
  return text;
}

bool is_a(const Entry& entry, std::string_view interface_name) {
  return entry.interface_name == interface_name ||
         std::ranges::find(entry.bases, interface_name) != entry.bases.end();
}

/// Returns `since` + `length`, or the end of all times if that is later.
TimePoint end_of(TimePoint since, Duration length) {
  return length > TimePoint::max() - since ? TimePoint::max() : since + length;
}

bool is_kept(const Directory& directory, const Silent& one, TimePoint now) {
  return directory.free_in(one, now) != Duration::zero();
}

/// Returns which server keeps the name of a silent object, and until when.
std::string why_kept(const Directory& directory, const Silent& one, TimePoint now) {
  const std::string who =
      described(one.entry) + ", which has been silent for " + in_seconds(now - one.since);
  const auto rest = directory.free_in(one, now);
  if (!rest) return who + "; its process still lives on the broker's host";
  const std::string freed = "after `gecos free " + one.entry.name + "`";
  if (*rest == TimePoint::max() - now) return who + "; the name is free " + freed;
  return who + "; the name is free in " + in_seconds(*rest) + ", or " + freed;
}

/// Returns whether one run of a server process serves both objects.
bool is_same_life(const Entry& one, const Entry& other) {
  return one.boot == other.boot && one.user == other.user && one.hostname == other.hostname;
}

}  // namespace

void Directory::expect(const Entry& entry) {
  silent_.insert_or_assign(entry.name, Silent{entry, started_, 0, Host::Same, true, true});
}

tl::expected<Duration, NameTaken> Directory::enlist(const Claim& claim, const Entry& entry,
                                                    TimePoint now) {
  Standing claimed{now - claim.served_for, std::nullopt};
  if (claim.confirmed_ago) claimed.confirmed = now - *claim.confirmed_ago;
  const Duration provisional = std::max(settled_ - now, Duration::zero());
  bool certain = claimed.confirmed.has_value();
  const bool own_life = entry.boot == claim.incarnation;
  const auto found = places_.find(entry.name);
  if (found == places_.end()) {
    const auto silent = silent_.find(entry.name);
    std::uint64_t epoch = 0;  // 0: the object gets a new epoch
    if (silent != silent_.end()) {
      const Silent& one = silent->second;
      if (own_life && is_same_life(one.entry, entry)) {
        if (one.entry == entry) epoch = one.epoch;
        certain = certain || (one.entry == entry && one.certain);
      } else if (is_kept(*this, one, now)) {
        return tl::unexpected(NameTaken{entry.name, why_kept(*this, one, now)});
      }
      silent_.erase(silent);
    }
    epoch = note(entry, Presence::ONLINE, epoch);
    places_.emplace(entry.name,
                    Place{claim.session, entry, claimed, {}, epoch, claim.host, certain});
    return provisional;
  }
  Place& place = found->second;
  if (place.entry == entry && (place.session == claim.session || own_life)) {
    place.session = claim.session;
    place.certain = place.certain || certain;
    // Both times are computed from the time at which a claim arrives, so a claim that arrives late
    // gives times that are too late. Therefore the earliest ones are the most exact. A claim
    // that says nothing of a confirmation counts most, as does nullopt, the least value.
    place.standing.since = std::min(place.standing.since, claimed.since);
    place.standing.confirmed = std::min(place.standing.confirmed, claimed.confirmed);
    return provisional;
  }
  if (!gives_way(place, entry, claimed, now)) {
    return tl::unexpected(NameTaken{entry.name, described(place.entry)});
  }
  auto displaced = std::move(place.displaced);
  displaced.push_back(std::move(place.entry));
  place = {claim.session, entry,  claimed, std::move(displaced), note(entry, Presence::ONLINE, 0),
           claim.host,    certain};
  return provisional;
}

/// A broker has the name for one server at a time. So of two confirmed servers, the one that was
/// confirmed later got the name after the other had lost it. A server of this version that was
/// never confirmed starts no actor commands yet, so it stops nothing when it loses the name.
bool Directory::Standing::outranks(const Standing& other) const {
  if (confirmed != other.confirmed) return confirmed > other.confirmed;  // nullopt is less
  return since < other.since;
}

bool Directory::gives_way(const Place& place, const Entry& entry, const Standing& claimed,
                          TimePoint now) const {
  const bool from_before = claimed.confirmed || claimed.since < started_;
  return !has_settled(now) && from_before && claimed.outranks(place.standing) &&
         std::ranges::find(place.displaced, entry) == place.displaced.end();
}

bool Directory::keeps_name(const std::string& name, TimePoint now) const {
  if (places_.contains(name)) return true;
  const auto found = silent_.find(name);
  return found != silent_.end() && is_kept(*this, found->second, now);
}

std::optional<Duration> Directory::free_in(const Silent& one, TimePoint now) const {
  if (one.host == Host::Same) return std::nullopt;
  return std::max(end_of(one.since, options_.name_hold) - now, Duration::zero());
}

tl::expected<void, UnknownName> Directory::withdraw(std::uint64_t session,
                                                    const std::string& name) {
  const auto found = places_.find(name);
  if (found == places_.end() || found->second.session != session) {
    return tl::unexpected(unknown(name));
  }
  note(found->second.entry, Presence::GONE, found->second.epoch);
  places_.erase(found);
  return {};
}

std::vector<std::string> Directory::end_session(std::uint64_t session, TimePoint heard) {
  std::vector<std::string> dropped;
  for (auto at = places_.begin(); at != places_.end();) {
    Place& place = at->second;
    if (place.session != session) {
      ++at;
      continue;
    }
    dropped.push_back(at->first);
    note(place.entry, Presence::SILENT, place.epoch, heard);
    silent_.insert_or_assign(
        at->first, Silent{std::move(place.entry), heard, place.epoch, place.host, place.certain});
    at = places_.erase(at);
  }
  forget_most(heard);
  return dropped;
}

bool Directory::has(std::uint64_t session, const std::string& name) const {
  const auto found = places_.find(name);
  return found != places_.end() && found->second.session == session;
}

std::vector<std::string> Directory::names_of(
    const std::function<bool(std::uint64_t session)>& applies) const {
  std::vector<std::string> names;
  for (const auto& [name, place] : places_) {
    if (applies(place.session)) names.push_back(name);
  }
  return names;
}

bool Directory::is_of_this_host(std::uint64_t session) const {
  return std::ranges::any_of(places_, [&](const auto& named) {
    return named.second.session == session && named.second.host == Host::Same;
  });
}

std::vector<std::string> Directory::process_ended(std::int32_t pid) {
  std::vector<std::string> removed;
  const auto end = [&](auto& list) {
    std::erase_if(list, [&](const auto& named) {
      const auto& [name, one] = named;
      if (one.host != Host::Same || one.entry.pid != pid) return false;
      note(one.entry, Presence::GONE, one.epoch);
      removed.push_back(name);
      return true;
    });
  };
  end(places_);
  end(silent_);
  return removed;
}

tl::expected<void, std::variant<UnknownName, NameInUse>> Directory::free(const std::string& name) {
  using Refusal = std::variant<UnknownName, NameInUse>;
  if (const auto place = places_.find(name); place != places_.end()) {
    return tl::unexpected(
        Refusal(NameInUse{name, "the broker still hears the server of this object, " +
                                    described(place->second.entry) + "; end that server"}));
  }
  const auto found = silent_.find(name);
  if (found == silent_.end()) return tl::unexpected(Refusal(unknown(name)));
  const Silent& one = found->second;
  if (one.host == Host::Same) {
    return tl::unexpected(Refusal(NameInUse{
        name, "the server process of this object, " + described(one.entry) +
                  ", still lives on the broker's host and may move the device again; end it "
                  "with `kill -KILL " +
                  std::to_string(one.entry.pid) + "`, which frees the name at once"}));
  }
  note(one.entry, Presence::GONE, one.epoch);
  silent_.erase(found);
  return {};
}

TimePoint Directory::on_tick(TimePoint now) {
  const TimePoint back_by = started_ + servers_return_within;
  TimePoint next = has_settled(now) ? TimePoint::max() : settled_;
  for (auto at = silent_.begin(); at != silent_.end();) {
    Silent& one = at->second;
    if (one.expected && now >= back_by) {
      one.expected = false;
      one.epoch = note(one.entry, Presence::SILENT, one.epoch, one.since);
    }
    const bool kept = is_kept(*this, one, now);
    const TimePoint forget = one.since + remembered;
    if (!kept && now >= forget) {
      note(one.entry, Presence::GONE, one.epoch);
      at = silent_.erase(at);
      continue;
    }
    if (one.expected) next = std::min(next, back_by);
    if (one.host == Host::Other)
      next = std::min(next, kept ? end_of(one.since, options_.name_hold) : forget);
    ++at;
  }
  forget_most(now);
  return next;
}

void Directory::forget_most(TimePoint now) {
  std::vector<std::map<std::string, Silent>::iterator> is_free;
  for (auto at = silent_.begin(); at != silent_.end(); ++at) {
    if (!is_kept(*this, at->second, now)) is_free.push_back(at);
  }
  if (is_free.size() <= most_silent) return;
  std::ranges::sort(is_free, {}, [](const auto& at) { return at->second.since; });
  is_free.resize(is_free.size() - most_silent);
  for (const auto& at : is_free) {
    note(at->second.entry, Presence::GONE, at->second.epoch);
    silent_.erase(at);
  }
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

std::vector<Entry> Directory::query(std::string_view interface_name) const {
  std::vector<Entry> entries;
  for (const auto& [name, place] : places_) {
    if (is_a(place.entry, interface_name)) entries.push_back(place.entry);
  }
  return entries;
}

std::vector<Silent> Directory::silent(TimePoint now) const {
  std::vector<Silent> found;
  for (const auto& [name, one] : silent_) {
    if (one.expected) continue;
    if (is_kept(*this, one, now) || now - one.since < remembered) found.push_back(one);
  }
  return found;
}

std::uint64_t Directory::note(const Entry& entry, Presence presence, std::uint64_t epoch,
                              TimePoint heard) {
  ++number_;
  if (epoch == 0) epoch = number_;
  changes_.push_back({{entry, presence, epoch, 0}, heard});
  if (changes_.size() > most_changes) changes_.pop_front();
  return epoch;
}

ListChanges Directory::changes(const ListRevision& since, TimePoint now) const {
  ListChanges answer;
  const auto seconds = [&](TimePoint begin) { return std::max(0.0, to_seconds(now - begin)); };
  answer.revision = revision();
  answer.running_for = seconds(started_);
  answer.whole = since.life != options_.life || since.number > number_ ||
                 number_ - since.number > changes_.size();
  if (!answer.whole) {
    const auto missed = static_cast<std::ptrdiff_t>(number_ - since.number);
    for (auto at = changes_.end() - missed; at != changes_.end(); ++at) {
      answer.changed.push_back(at->what);
      if (at->what.presence == Presence::SILENT)
        answer.changed.back().silent_for = seconds(at->heard);
    }
    return answer;
  }
  for (const auto& [name, place] : places_)
    answer.changed.push_back({place.entry, Presence::ONLINE, place.epoch, 0});
  for (const Silent& one : silent(now))
    answer.changed.push_back({one.entry, Presence::SILENT, one.epoch, seconds(one.since)});
  std::ranges::sort(answer.changed, {}, [](const Registration& one) { return one.entry.name; });
  return answer;
}

bool Directory::uses_process(std::int32_t pid) const {
  const auto of_process = [&](const auto& named) {
    return named.second.host == Host::Same && named.second.entry.pid == pid;
  };
  return std::ranges::any_of(places_, of_process) || std::ranges::any_of(silent_, of_process);
}

std::vector<Entry> Directory::of_this_host(TimePoint now) const {
  std::vector<Entry> entries;
  const auto add = [&](const auto& list) {
    for (const auto& [name, one] : list) {
      const bool certain = one.certain || has_settled(now);
      if (one.host == Host::Same && certain) entries.push_back(one.entry);
    }
  };
  add(places_);
  add(silent_);
  return entries;
}

UnknownName Directory::unknown(const std::string& name) const {
  UnknownName answer;
  answer.name = name;
  for (const auto& [known, place] : places_) answer.known.push_back(known);
  return answer;
}

}  // namespace gecos::broker
