#pragma once

#include <cstddef>
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

/// An object whose server was not heard any more and had not withdrawn it.
struct Silent {
  Entry entry;
  TimePoint since;  ///< when the server was heard last
};

/// The known objects, and the session that enlisted each of them. No I/O; not thread-safe.
///
/// For the duration `young` after its start, the directory may receive claims for objects that were
/// served before the broker started. If several such objects have one name, the object that has
/// been served longest gets the name. Each of them takes the name from an object that is newer than
/// the broker. During `young` the answer to a claim is provisional; afterwards a name stays with
/// its object. All moments are read from CLOCK_BOOTTIME.
class Directory {
 public:
  static constexpr Duration first_second = std::chrono::seconds(1);
  static constexpr Duration remembered = std::chrono::hours(1);
  static constexpr std::size_t most_silent = 256;

  /// `young` is how long after `started` a claim is provisional.
  explicit Directory(TimePoint started, Duration young = first_second)
      : started_(started), settled_(started + young) {}

  /// Adds `entry` for the session of `claim`. The same incarnation of a server may enlist an entry
  /// again in a new session, even before the end of its previous session is known. Fails when
  /// another entry keeps the name. Returns for how long the answer is provisional; 0 when it is
  /// final.
  tl::expected<Duration, NameTaken> enlist(const Claim& claim, const Entry& entry, TimePoint now);
  /// Removes an object. Only the session that enlisted the object may remove it.
  tl::expected<void, UnknownName> withdraw(std::uint64_t session, const std::string& name);
  /// Removes all objects that the session enlisted, and returns their names. `heard` is when the
  /// server was heard last.
  std::vector<std::string> end_session(std::uint64_t session, TimePoint heard);

  tl::expected<Entry, UnknownName> look_up(const std::string& name) const;
  std::vector<Entry> list() const;
  /// The objects that `end_session` has removed since `now` - `remembered` and whose name no server
  /// has taken, by name; of more than `most_silent` those that were heard last.
  std::vector<Silent> silent(TimePoint now) const;

 private:
  struct Place {
    std::uint64_t session = 0;
    Entry entry;
    TimePoint since;  ///< when the server began to serve the object, by the broker's clock
    std::vector<Entry> displaced{};  ///< entries that lost this name and cannot get it back
  };
  bool gives_way(const Place& place, const Entry& entry, TimePoint since, TimePoint now) const;
  UnknownName unknown(const std::string& name) const;
  void remember(Silent one);

  TimePoint started_;
  TimePoint settled_;
  std::map<std::string, Place> places_;
  std::map<std::string, Silent> silent_;
};

}  // namespace gecos::broker
