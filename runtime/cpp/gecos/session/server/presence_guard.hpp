#pragma once

#include <string>

#include "gecos/access/object_presence.hpp"

namespace gecos::session {

struct HostState;

/// Tells one object whether a person is present in its zone (access::ObjectPresence). When no
/// person is present any more, ends the commands of the object that need a person, and stops the
/// object. Thread-safe.
class PresenceGuard {
 public:
  explicit PresenceGuard(HostState& object) : object_(object) {}

  /// Returns the name of the zone in which the object is; an empty text if the object is in no
  /// zone.
  std::string zone();
  /// The object is in `zone` from now on.
  void enter(const std::string& zone);
  // The following functions ignore a `zone` that is not the zone of the object, because the object
  // may have left that zone.

  /// Takes a report of `zone` that was made at `made`, by CLOCK_BOOTTIME of this host.
  void take(const std::string& zone, access::ObjectPresence::Report report, TimePoint made);
  /// Forgets the last report of `zone`: from now on it is not known whether a person is present.
  /// `why`: the reason, for people.
  void forget(const std::string& zone, const std::string& why);
  /// Forgets the last report of presence, from whichever zone it came.
  void forget(const std::string& why);
  void on_tick();

 private:
  template <class Change>
  void change(Change change);

  HostState& object_;
};

}  // namespace gecos::session
