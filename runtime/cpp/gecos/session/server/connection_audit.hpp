#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "gecos/audit/audit.hpp"
#include "gecos/audit/repeats.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/session/server/access_control.hpp"

namespace gecos::session {

/// What the audit says about the connections of other users than the server's own: who was
/// admitted or refused, and by which rule. At a broker, also which servers may not register an
/// object. Thread-safe.
class ConnectionAudit {
 public:
  explicit ConnectionAudit(std::shared_ptr<audit::Audit> audit) : audit_(std::move(audit)) {}

  /// Records the judgement about a client that connects to `object`. Returns what the client is
  /// told: why it may not connect, with the number of this refusal; an empty text if it may.
  std::string judged(const std::string& object, const AccessControl::Judgement& judgement);
  /// Records a refusal. `event`: a literal. Returns what the client is told, as `judged`.
  std::string refused(std::string_view event, const std::string& object,
                      const AccessControl::Judgement& judgement);
  /// Must be called again and again: writes the lines of refusals that were repeated.
  void on_tick();

 private:
  Mutex mutex_;
  audit::Repeats repeats_ GECOS_GUARDED_BY(mutex_);
  std::uint64_t refusals_ GECOS_GUARDED_BY(mutex_) = 0;
  const std::shared_ptr<audit::Audit> audit_;
};

}  // namespace gecos::session
