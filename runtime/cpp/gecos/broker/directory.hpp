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

/// A server's claim to the name of an object.
struct Claim {
  std::uint64_t session = 0;
  std::uint64_t incarnation = 0;  ///< incarnation of the server process, as its session reports
  Duration served_for{};          ///< how long the object has been served
};

/// An object whose server fell silent without withdrawing the object.
struct Silent {
  Entry entry;
  TimePoint since;  ///< when the server was heard last
};

/// The known objects, each with the session that enlisted it. Does no I/O. Not thread-safe.
///
/// For the duration `young` after its start, the directory may receive claims for objects that were
/// served before the broker started. If several such objects have one name, the object that has
/// been served longest gets the name. An object that was served before the broker started also
/// takes its name from an object that is newer than the broker. During `young` the answer to a
/// claim is provisional. After `young` a name stays with its object. All moments are read from
/// CLOCK_BOOTTIME.
class Directory {
 public:
  static constexpr Duration first_second = std::chrono::seconds(1);
  static constexpr Duration remembered = std::chrono::hours(1);
  static constexpr std::size_t most_silent = 256;

  /// The answer to a claim is provisional until `young` after `started`.
  explicit Directory(TimePoint started, Duration young = first_second)
      : started_(started), settled_(started + young) {}

  /// Adds `entry` for the session of `claim`. The same incarnation of a server may enlist an entry
  /// again in a new session, even before the directory knows that its previous session has ended.
  /// Fails when another entry keeps the name. Returns how long the answer is still provisional; 0
  /// when the answer is final.
  tl::expected<Duration, NameTaken> enlist(const Claim& claim, const Entry& entry, TimePoint now);
  /// Removes an object. Only the session that enlisted the object may remove it.
  tl::expected<void, UnknownName> withdraw(std::uint64_t session, const std::string& name);
  /// Removes all objects that the session enlisted, and returns their names. `heard` is the time of
  /// the last sign of life of the server.
  std::vector<std::string> end_session(std::uint64_t session, TimePoint heard);

  tl::expected<Entry, UnknownName> look_up(const std::string& name) const;
  std::vector<Entry> list() const;
  /// Returns the objects that `end_session` has removed, sorted by name: those whose server was
  /// alive within `remembered` before `now`, and whose name no server has taken since. The
  /// directory keeps at most `most_silent` of them, and forgets the one that has been silent
  /// longest first.
  std::vector<Silent> silent(TimePoint now) const;

 private:
  struct Place {
    std::uint64_t session = 0;
    Entry entry;
    TimePoint since;  ///< when the server began to serve the object, by CLOCK_BOOTTIME of the
                      ///< broker
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
