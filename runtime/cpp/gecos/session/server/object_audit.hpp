#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "gecos/access/lease_table.hpp"
#include "gecos/audit/audit.hpp"
#include "gecos/audit/repeats.hpp"
#include "gecos/audit/shared_lines.hpp"
#include "gecos/session/server/server_call.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// The audit of one object: its sessions, its status, its actor commands, and the readings that
/// were refused. If the server has no Audit, nothing is recorded. Not thread-safe: the object's
/// mutex guards it.
///
/// Commands that one client repeats within a second share a line (audit::Repeats), so recording
/// such a command costs one search in a short table.
class ObjectAudit {
 public:
  /// `audit` may be null.
  ObjectAudit(std::string object, std::shared_ptr<audit::Audit> audit)
      : object_(std::move(object)), audit_(std::move(audit)), visitors_(object_, audit_) {}
  ~ObjectAudit() { end(); }

  /// Records that a session begins. Sessions of one visitor share lines, about one line a minute
  /// (audit::SharedLines); so do the ends of these sessions, if they have the same reason.
  void connected(ServerSession& session);
  void disconnected(const ServerSession& session, std::string_view because);

  /// Records that a status begins, ends or changes. `event` is a string literal, for example
  /// "status_granted". `counter`: the call that changed the status; 0 if no call did.
  void status(std::string_view event, const ServerSession& session, std::uint64_t counter = 0,
              std::string_view status = {});
  void status_refused(const ServerSession& session, std::uint64_t counter, std::string_view status,
                      const std::string& why);
  void status_lost(const access::Client& holder, const std::string& why);

  /// Records that a client has stopped the object.
  void stopped(const ServerSession& by, std::uint64_t counter);

  /// Records a call, or the opening of a stream, that was refused before it was queued.
  void refused(const ServerSession& session, std::uint64_t counter, FunctionCode code,
               std::string_view operation, const Failure& failure);
  /// Records a call that was refused because its client is a visitor (access/visitors.hpp). All
  /// such calls of one visitor share lines, whatever their operations and sessions. `because`: the
  /// part of the text of `failure` that is the same for each of these calls. Returns the number of
  /// the refusal, like named_request. The number names no session, because the line also counts
  /// calls in other sessions. @pre the client of `session` is a visitor
  std::string visitor_refused(const ServerSession& session, std::uint64_t counter,
                              std::string_view operation, const Failure& failure,
                              const std::string& because);
  /// Records that the handler of a command begins, if the command may take long.
  void begins(const ServerCall& call);
  void ended(const ServerCall& call, Detail detail, const std::string& text);

  /// Repetitions of a command are counted for one second. When this second is over, writes one line
  /// with the number of repetitions. Then lets the audit write to its files.
  void on_tick();
  /// Writes the lines of all repeated commands that on_tick has not written yet.
  void end();

 private:
  audit::Line line(std::string_view event, const Caller& caller, std::uint64_t counter = 0) const;
  /// Writes the line about the beginning or the end of a session.
  void add_of_session(const ServerSession& session, audit::Line entry);
  /// Writes the line. If an equal line follows within a second, that line is only counted.
  void begin(const audit::Repeats::Key& key, audit::Line entry);
  void command(const ServerSession& session, std::uint64_t counter, FunctionCode code,
               std::string_view operation, Detail detail, std::string_view why);

  const std::string object_;
  const std::shared_ptr<audit::Audit> audit_;
  audit::Repeats repeats_;
  audit::SharedLines visitors_;  ///< the lines about visitors
  std::uint64_t visitor_refusals_ = 0;
};

/// Returns the end of the text of a refusal, for example " (request 1a2b-3c4d-7)"; an empty text if
/// `counter` is 0. The user can pass this number to `gecos why`.
std::string named_request(SessionId session, std::uint64_t counter);

}  // namespace gecos::session
