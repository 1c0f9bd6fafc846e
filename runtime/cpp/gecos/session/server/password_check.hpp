#pragma once

#include <optional>
#include <string>

#include "gecos/access/password_limit.hpp"
#include "gecos/access/proof.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/crypto/password.hpp"
#include "gecos/session/server/executor.hpp"
#include "gecos/session/server/server_session.hpp"
#include "gecos/session/server/status_line.hpp"

namespace gecos::session {

/// Says whether the password of a client may be compared now, and counts the wrong passwords of
/// each user. Not thread-safe: the object's mutex guards it.
class PasswordCheck {
 public:
  /// Returns why the password of `session` is not compared; an empty text when it may be.
  std::string refusal(ServerSession& session, TimePoint now) const;
  void count_wrong(ServerSession& session, TimePoint now);

 private:
  access::PasswordLimit limit_;
};

/// Derives proofs from passwords, one after the other, on a thread of its own. Thread-safe.
class PasswordProver {
 public:
  explicit PasswordProver(const std::string& object) : executor_("gecos-" + object, 1) {}

  /// Calls `then` with the proof, on the thread of the prover; with nullopt when the memory for
  /// deriving it is missing. Returns false when this process cannot create the thread.
  bool prove(access::Proof password, std::function<void(std::optional<access::Proof>)> then);
  /// Waits until the proofs that were begun have been derived. Later ones are refused.
  void join() { executor_.join(); }

 private:
  const crypto::Salt salt_ = crypto::draw_salt();
  Executor executor_;  ///< last member, so that its thread ends first
};

}  // namespace gecos::session
