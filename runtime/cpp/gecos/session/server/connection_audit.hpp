#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "gecos/audit/audit.hpp"
#include "gecos/audit/repeats.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/session/server/access_control.hpp"

namespace gecos::session {

/// The audit of the connections of all users except the user of the server: who was admitted or
/// refused, and by which rule. At a broker, also the servers that were not allowed to register an
/// object. Thread-safe.
class ConnectionAudit {
 public:
  explicit ConnectionAudit(std::shared_ptr<audit::Audit> audit) : audit_(std::move(audit)) {}

  /// Records the judgement about a client that connects to `object`. Repeated admissions of a
  /// visitor within a second share a line. Returns the text for the
  /// client: why it may not connect, with the number of this refusal. Returns an empty text if the
  /// client may connect.
  std::string judged(const std::string& object, const AccessControl::Judgement& judgement);
  /// Records a refusal. `event` is a string literal. Returns the text for the client, like
  /// `judged`.
  std::string refused(std::string_view event, const std::string& object,
                      const AccessControl::Judgement& judgement);
  /// Must be called periodically: writes the lines of refusals that were repeated.
  void on_tick();

 private:
  /// Writes the line. Equal events of one user within the next second are only counted.
  void add_or_count(audit::Line entry) GECOS_REQUIRES(mutex_);

  Mutex mutex_;
  audit::Repeats repeats_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t refusals_ GECOS_GUARDED_BY(mutex_) = 0;
  const std::shared_ptr<audit::Audit> audit_;
};

}  // namespace gecos::session
