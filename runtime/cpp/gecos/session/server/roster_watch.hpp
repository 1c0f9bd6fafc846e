#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "gecos/access/lease_table.hpp"
#include "gecos/access/roster_changes.hpp"
#include "gecos/object_calls.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/protocol/suspend_aware_clock.hpp"
#include "gecos/session/server/object_setup.hpp"
#include "gecos/session/server/open_questions.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// Converts `roster`, the holders of the status of an object, to the form in which clients get
/// them.
std::vector<Holder> shown_to_clients(const std::vector<access::Holder>& roster, TimePoint now);

/// Tells clients who holds the status of one object, and each change of the holders. Not
/// thread-safe: the object's mutex guards it.
class RosterWatch {
 public:
  /// `clock` is the clock of the leases.
  RosterWatch(const ObjectSetup& setup, const access::LeaseTable& leases,
              const SuspendAwareClock& clock);

  std::vector<Holder> holders() const;
  /// Must be called whenever a status or a take-over begins or ends. `why_ended` is the reason for
  /// the end of each status that has ended.
  void note_change(std::string_view why_ended);

  /// Replies with the holders of the status, and with the changes of the holders after the change
  /// `asked.after`. While `asked.after` is the newest change, the reply waits, at most
  /// `asked.patience` seconds.
  void ask(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
           const GecosObject_roster_arguments& asked);
  OpenQuestions& questions() { return questions_; }
  bool somebody_waits() const { return !questions_.empty(); }
  /// Replies to the questions that have waited for too long.
  void on_tick() { answer(); }
  /// Replies to all questions, because the server is about to end.
  void close();

 private:
  void answer();
  void reply(const OpenQuestions::Question& question) const;

  const access::LeaseTable& leases_;
  const SuspendAwareClock& clock_;
  access::RosterChanges changes_;
  OpenQuestions questions_;
};

}  // namespace gecos::session
