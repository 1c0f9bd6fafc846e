#include "gecos/broker/directory.hpp"

namespace gecos::broker {

tl::expected<void, NameTaken> Directory::enlist(std::uint64_t session, std::uint64_t boot,
                                                const Entry& entry) {
  const auto found = places_.find(entry.name);
  const auto is_its_own = [&](const Place& place) {
    return place.entry == entry && (place.session == session || entry.boot == boot);
  };
  if (found != places_.end() && !is_its_own(found->second)) {
    const Entry& other = found->second.entry;
    return tl::unexpected(NameTaken{entry.name, "a " + other.interface_name + " of " + other.user +
                                                    " on " + other.hostname + ", pid " +
                                                    std::to_string(other.pid)});
  }
  places_.insert_or_assign(entry.name, Place{session, entry});
  return {};
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

std::vector<std::string> Directory::end_session(std::uint64_t session) {
  std::vector<std::string> dropped;
  for (auto at = places_.begin(); at != places_.end();) {
    if (at->second.session != session) {
      ++at;
      continue;
    }
    dropped.push_back(at->first);
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

UnknownName Directory::unknown(const std::string& name) const {
  UnknownName answer;
  answer.name = name;
  for (const auto& [known, place] : places_) answer.known.push_back(known);
  return answer;
}

}  // namespace gecos::broker
