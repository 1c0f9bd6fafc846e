#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "gecos/audit/audit.hpp"
#include "gecos/audit/shared_lines.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/session/server/access_control.hpp"

namespace gecos::session {

/// The audit of the connections of all users except the user of the server: who was admitted or
/// refused, and by which rule. At a broker, also the servers that were not allowed to register an
/// object. Thread-safe.
///
/// A user can connect again and again, whether admitted or not. Therefore the refusals of one user
/// at one object, for one reason, and the admissions of one visitor share lines, whatever the
/// client does: about one a minute (audit::SharedLines).
class ConnectionAudit {
 public:
  /// `now`: the time of the lines, as audit::now.
  explicit ConnectionAudit(std::shared_ptr<audit::Audit> audit, std::int64_t (*now)() = audit::now)
      : now_(now), lines_("", audit), audit_(std::move(audit)) {}
  ~ConnectionAudit() { end(); }
  ConnectionAudit(const ConnectionAudit&) = delete;
  ConnectionAudit& operator=(const ConnectionAudit&) = delete;

  /// Records the judgement about a client that connects to `object`. Returns the text for the
  /// client: why it may not connect, with the number of this refusal. Returns an empty text if the
  /// client may connect.
  std::string judged(const std::string& object, const AccessControl::Judgement& judgement);
  /// Records a refusal. `event` is a string literal. Returns the text for the client, like
  /// `judged`.
  std::string refused(std::string_view event, const std::string& object,
                      const AccessControl::Judgement& judgement);
  /// Must be called periodically: writes the lines of refusals that were repeated.
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
