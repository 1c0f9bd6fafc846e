#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/base/result.hpp"
#include "gecos/broker_types.hpp"

namespace gecos::broker {

/// The claim of a server to the name of an object.
struct Claim {
  std::uint64_t session = 0;
  std::uint64_t incarnation = 0;  ///< life of the server process, as its session says
  Duration served_for{};          ///< how long the object has been served
};

/// Which objects there are, and which session enlisted each of them. Pure; not thread-safe.
///
/// While it is `young` it may still hear of objects that were served before its broker started. Of
/// several such objects with one name, the one that has been served longest gets the name; an
/// object that is newer than the broker gives way to each of them. Until then the answer to a claim
/// is provisional. Afterwards a name stays where it is. Times are of CLOCK_BOOTTIME.
class Directory {
 public:
  static constexpr Duration first_second = std::chrono::seconds(1);

  /// `young` is how long after `started` a claim is provisional.
  explicit Directory(TimePoint started, Duration young = first_second)
      : started_(started), settled_(started + young) {}

  /// Adds it, as the session's. The server of that life (`incarnation`) may say the same again, in
  /// a new session perhaps before the end of its last one is known. Whatever else has that name, it
  /// is taken. Gives how long the answer is provisional: 0 when the name is the session's.
  tl::expected<Duration, NameTaken> enlist(const Claim& claim, const Entry& entry, TimePoint now);
  /// Only who enlisted an object takes it off.
  tl::expected<void, UnknownName> withdraw(std::uint64_t session, const std::string& name);
  /// Drops all that the session enlisted, and names it.
  std::vector<std::string> end_session(std::uint64_t session);

  tl::expected<Entry, UnknownName> look_up(const std::string& name) const;
  std::vector<Entry> list() const;

 private:
  struct Place {
    std::uint64_t session = 0;
    Entry entry;
    TimePoint since;                 ///< when its server began to serve it, by our clock
    std::vector<Entry> displaced{};  ///< by it or before it; they do not come back while young
  };
  bool gives_way(const Place& place, const Entry& entry, TimePoint since, TimePoint now) const;
  UnknownName unknown(const std::string& name) const;

  TimePoint started_;
  TimePoint settled_;
  std::map<std::string, Place> places_;
};

}  // namespace gecos::broker
