#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "gecos/audit/audit.hpp"
#include "gecos/audit/shared_lines.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/session/server/access_control.hpp"

namespace gecos::session {

/// The audit of connections. Records which users other than the user of the server were admitted or
/// refused, and by which rule. For a broker, also records which servers were not allowed to
/// register an object. Thread-safe.
///
/// A user can connect again and again, whether admitted or not. Therefore the number of lines is
/// limited to about one a minute (audit::SharedLines) for the refusals of one user at one object
/// for one reason, and for the admissions of one visitor.
class ConnectionAudit {
 public:
  /// `now`: the function that returns the current time for each line of the audit.
  explicit ConnectionAudit(std::shared_ptr<audit::Audit> audit, std::int64_t (*now)() = audit::now)
      : now_(now), lines_("", audit), audit_(std::move(audit)) {}
  ~ConnectionAudit() { end(); }
  ConnectionAudit(const ConnectionAudit&) = delete;
  ConnectionAudit& operator=(const ConnectionAudit&) = delete;

  /// Records the decision about a client that connects to `object`. Returns the text that the
  /// client gets: why it may not connect, and the number of this refusal. Returns an empty text if
  /// the client may connect.
  std::string judged(const std::string& object, const AccessControl::Judgement& judgement);
  /// Records a refusal. `event` is a string literal. Returns the text that the client gets, like
  /// `judged`.
  std::string refused(std::string_view event, const std::string& object,
                      const AccessControl::Judgement& judgement);
  /// Writes the lines about repeated refusals. Must be called periodically.
  void on_tick();
  /// Writes the lines of all repeated refusals that on_tick has not written yet.
  void end();

 private:
  audit::Line line_about(std::string_view event, const std::string& object,
                         const AccessControl::Judgement& judgement) const;

  std::int64_t (*const now_)();
  Mutex mutex_;
  audit::SharedLines lines_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t refusals_ GECOS_GUARDED_BY(mutex_) = 0;
  const std::shared_ptr<audit::Audit> audit_;
};

}  // namespace gecos::session
