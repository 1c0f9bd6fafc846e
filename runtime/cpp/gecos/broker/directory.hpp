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
  std::uint64_t incarnation = 0;  ///< incarnation of the server process, as its session reports
  Duration served_for{};          ///< how long the object has been served
};

/// The known objects, and the session that enlisted each of them. No I/O; not thread-safe.
///
/// For the time `young` after its start, the directory may receive claims for objects that were
/// served before the broker started. Of several such objects with one name, the one that has been
/// served longest gets the name; an object that is newer than the broker loses the name to each of
/// them. In this time the answer to a claim is provisional. Afterwards a name does not move. Times
/// are of CLOCK_BOOTTIME.
class Directory {
 public:
  static constexpr Duration first_second = std::chrono::seconds(1);

  /// `young` is how long after `started` a claim is provisional.
  explicit Directory(TimePoint started, Duration young = first_second)
      : started_(started), settled_(started + young) {}

  /// Adds `entry`, enlisted by the session of `claim`. The same incarnation of the server may
  /// enlist it again in a new session, even before the end of its last session is known. Fails when
  /// another entry keeps the name. Returns how long the answer is provisional; 0 when the answer is
  /// final.
  tl::expected<Duration, NameTaken> enlist(const Claim& claim, const Entry& entry, TimePoint now);
  /// Removes an object. Only the session that enlisted the object may remove it.
  tl::expected<void, UnknownName> withdraw(std::uint64_t session, const std::string& name);
  /// Removes all objects that the session enlisted, and returns their names.
  std::vector<std::string> end_session(std::uint64_t session);

  tl::expected<Entry, UnknownName> look_up(const std::string& name) const;
  std::vector<Entry> list() const;

 private:
  struct Place {
    std::uint64_t session = 0;
    Entry entry;
    TimePoint since;                 ///< when its server began to serve it, by the broker's clock
    std::vector<Entry> displaced{};  ///< entries that lost this name; no return while `young`
  };
  bool gives_way(const Place& place, const Entry& entry, TimePoint since, TimePoint now) const;
  UnknownName unknown(const std::string& name) const;

  TimePoint started_;
  TimePoint settled_;
  std::map<std::string, Place> places_;
};

}  // namespace gecos::broker
