#pragma once

#include <string>

#include "gecos/access/object_presence.hpp"

namespace gecos::session {

struct HostState;

/// Tells one object whether a person is present in its zone (access::ObjectPresence). When presence
/// is lost, ends the commands of the object that need it, and stops the object. Thread-safe.
class PresenceGuard {
 public:
  explicit PresenceGuard(HostState& object) : object_(object) {}

  /// Takes a report of the zone that was made at `made`, by CLOCK_BOOTTIME of this host.
  void take(access::ObjectPresence::Report report, TimePoint made);
  /// Forgets the last report: nothing is known any more. `why`: a text for people.
  void forget(const std::string& why);
  void on_tick();

 private:
  template <class Change>
  void change(Change change);

  HostState& object_;
};

}  // namespace gecos::session
